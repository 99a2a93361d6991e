// One model in the browser: bytes of its file or chunks of a session in, arrays to draw out.
#pragma once
#include <optional>
#include <string>

#include "client/drawable.h"
#include "client/session.h"

namespace mvw::web {

/// Which of all that has come is drawn.
struct View {
    unsigned level = 255;
    unsigned layer = 255;           // finest that is used
    double bytes = 1e300;           // of the file's beginning that are used
    client::DrawableOptions lines;  // its level is not used
};

class Model {
 public:
    explicit Model(std::uint64_t memory_bytes);

    /// The next bytes of the file, from its beginning.
    Result<void> feed(ByteSpan bytes);
    /// The file's index, fetched apart; it must fit the header. Taken from feed() where that reaches it.
    Result<void> take_index(ByteSpan bytes);

    /// What a session told.
    void take(const client::Opened& opened);
    void take(client::Received& chunk);
    void take(const client::Restarted&);

    /// Draws into drawable(). NeedMoreData until the view has a base mesh.
    Result<void> draw(const View& view);
    [[nodiscard]] client::Drawable& drawable() { return drawable_; }
    /// Of the decoder that made it.
    [[nodiscard]] DecodeState drawn_state() const { return drawn_state_; }

    [[nodiscard]] const Decoder& decoder() const { return decoder_; }
    /// Bytes of the file's beginning with which each chunk known is there, and the error left then.
    [[nodiscard]] const std::vector<std::array<double, 2>>& points() const { return points_; }
    /// Everything that the file has is here.
    [[nodiscard]] bool complete() const;
    /// The header for people and pages, as JSON; empty before it is there.
    [[nodiscard]] std::string describe() const;

 private:
    struct Chunk {
        ChunkId id;
        std::uint32_t crc32c = 0;
        double end = 0;      // bytes of the file's beginning (or of all that had come) that hold it
        std::size_t at = 0;  // in bytes_
        std::size_t length = 0;
    };
    void list_chunks(const Toc& toc);
    Result<const Decoder*> decoder_of(const View& view);
    [[nodiscard]] bool holds(const Chunk& chunk) const { return chunk.at + chunk.length <= bytes_.size(); }

    Limits limits_;
    Decoder decoder_;
    Bytes bytes_;  // the file's beginning, or the header and payloads in the order of their coming
    bool indexed_ = false;
    std::uint32_t chunk_count_ = 0;  // of the file, where a session said so
    std::uint64_t file_bytes_ = 0;
    std::vector<Chunk> chunks_;
    std::vector<std::array<double, 2>> points_;

    // The decoder of less than everything, and what it was given.
    std::optional<Decoder> subset_;
    unsigned subset_layer_ = 255;
    std::size_t subset_chunks_ = 0;

    client::Drawable drawable_;
    DecodeState drawn_state_;
};

}  // namespace mvw::web
