// The part of a store's file that is on this machine's disk: a sparse file of the same size and places, and beside it a
// list of the blocks that are there with their checksums, so that a restart or a crash loses little and trusts nothing.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/files.h"

namespace mvw::server {

/// One file's blocks. Safe to use from several threads; put() from one at a time.
class CachedFile {
 public:
    static constexpr std::uint64_t kBlockBytes = 64u << 10;
    /// What the two files' names end with; nothing else in a cache folder is ever touched.
    static constexpr std::string_view kBytesEnding = ".origin", kListEnding = ".blocks";

    /// Opens `name`'s files in the folder, or makes them. Blocks that are listed are read once and kept where their
    /// checksums are right. Io where the disk refuses.
    static Result<std::shared_ptr<CachedFile>> open(int folder, const std::string& name, std::uint64_t file_bytes);
    /// Removes both files; whoever has them open keeps them until the end.
    static void remove(int folder, const std::string& name);
    CachedFile(const CachedFile&) = delete;
    CachedFile& operator=(const CachedFile&) = delete;

    [[nodiscard]] std::uint64_t blocks() const { return there_.size(); }
    [[nodiscard]] bool has_block(std::uint64_t block) const { return there_[block].load(std::memory_order_acquire); }
    /// True where all these bytes are there.
    [[nodiscard]] bool has(std::uint64_t offset, std::uint64_t length) const;
    /// Keeps the whole blocks among these bytes, which begin with a block. Io where the disk refuses (it is full).
    Result<void> put(std::uint64_t offset, ByteSpan bytes);
    /// Bytes that are there.
    Result<void> read(std::uint64_t offset, std::span<std::byte> out) const;
    [[nodiscard]] int descriptor() const { return bytes_.get(); }

 private:
    CachedFile(Descriptor bytes, Descriptor list, std::uint64_t file_bytes);
    void trust_list();
    [[nodiscard]] std::uint64_t size_of(std::uint64_t block) const;

    const Descriptor bytes_, list_;
    const std::uint64_t file_bytes_;
    std::vector<std::atomic<bool>> there_;
};

}  // namespace mvw::server
