// Which chunk next. File order is rate-distortion order, so the answer is the file's own order, filtered by what the
// peer asked for and led by what it wants first. Knows no socket and no clock.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/container/toc.h"
#include "server/protocol/messages.h"

namespace mvw::protocol {

/// Whether a request leaves out nothing for good: then it is for closing parts and the original, too.
bool wants_everything(const FileHeader& header, const Request& request);

/// Walks one request's chunks:
///   1. base chunks and splits of every part but closing ones, in file order (nothing shows without them);
///   2. then, from the highest tile priority down to 1, the chunks of tiles of that priority, in file order; in the
///      last of these passes, where the request wants everything, those of closing parts and the original as well;
/// of levels and layers up to the request's (a tile's own level cap applies as well), up to and including the first
/// chunk in file order that leaves at most the target error, and no further than the byte budget: the walk ends at the
/// first chunk that would go over it.
/// The chunks of one (part, tile, level, channel) keep their layers' order, so each can be decoded when it comes.
class Schedule {
 public:
    /// `toc` outlives the schedule. O(C + T log T).
    Schedule(const Toc& toc, Request request);

    /// The next chunk that is not in `sent` (which holds all that the peer is known to hold), or none. Amortised O(1)
    /// for each chunk of the file and each distinct priority, times the look-up of its tile.
    std::optional<std::uint32_t> next(const ChunkSet& sent);
    /// Why next() said none.
    [[nodiscard]] EndReason end_reason() const { return reason_; }
    [[nodiscard]] std::uint32_t request_id() const { return request_.id; }

 private:
    [[nodiscard]] bool in_pass(const ChunkId& id) const;

    const Toc* toc_;
    Request request_;                 // tiles sorted by (part, tile)
    std::vector<unsigned> passes_;    // priorities, highest first; the base's pass comes before them all
    std::size_t pass_ = 0;            // index into passes_
    std::uint32_t at_ = 0, end_ = 0;  // next chunk to look at, one past the last wanted
    std::uint64_t held_bytes_ = 0;    // header and payloads that the peer holds, once what is under way arrives
    EndReason reason_ = EndReason::Complete;
};

}  // namespace mvw::protocol
