#include "client/cache.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "codec/container/crc32c.h"
#include "tests/support/program.h"
#include "tests/support/stream_models.h"

namespace mvw::client {
namespace {

using test::make_stream_file;
using test::MemoryModel;

/// Puts every chunk of a file under a URL.
Opened fill(ChunkCache& cache, const Bytes& file, std::size_t chunks = SIZE_MAX) {
    const auto model = MemoryModel::make(file);
    const auto& toc = model->toc();
    Opened opened{Bytes(model->header().begin(), model->header().end()), static_cast<std::uint32_t>(toc.chunks.size()),
                  file.size(), model->payload_bytes()};
    cache.begin(opened, "\"tag\"");
    for (std::uint32_t i = 0; i < std::min(chunks, toc.chunks.size()); ++i) {
        Received r{i, toc.chunks[i].id, toc.chunks[i].crc32c, toc.chunks[i].error, Bytes(toc.chunks[i].length)};
        EXPECT_TRUE(model->read(toc.chunks[i].offset, r.payload).ok());
        cache.put(r);
    }
    return opened;
}

std::uint64_t size_of(const std::string& folder) {
    std::uint64_t total = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) total += entry.file_size();
    return total;
}

TEST(ChunkCache, GivesBackWhatWasPut) {
    const ScratchFolder folder;
    const Bytes file = make_stream_file();
    Opened opened;
    {
        ChunkCache cache({folder / "c"}, "url");
        EXPECT_FALSE(cache.load({}));
        opened = fill(cache, file, 20);
        fill(cache, file, 20);  // again: nothing is kept twice
    }
    ChunkCache cache({folder / "c"}, "url");
    const std::optional<Stored> stored = cache.load({});
    ASSERT_TRUE(stored);
    EXPECT_EQ(stored->header, opened.header);
    EXPECT_EQ(stored->chunk_count, opened.chunk_count);
    EXPECT_EQ(stored->etag, "\"tag\"");
    EXPECT_EQ(stored->chunks.size(), 20u);
    EXPECT_FALSE(ChunkCache({folder / "c"}, "another url").load({}));
}

TEST(ChunkCache, EveryCutAndEveryFlippedByteGivesSoundChunksOrNone) {
    const ScratchFolder folder;
    const Bytes model = make_stream_file({.tiles = 2, .levels = 1, .layers = 2, .payload_bytes = 50});
    {
        ChunkCache cache({folder / "c"}, "url");
        fill(cache, model);
    }
    std::string path;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "c"))
        if (entry.path().extension() == ".chunks") path = entry.path().string();
    const std::string whole = read_text(path);
    const auto check = [&] {
        ChunkCache cache({folder / "c"}, "url");
        const std::optional<Stored> stored = cache.load({});
        if (!stored) return;
        for (const Received& r : stored->chunks) EXPECT_EQ(crc32c(r.payload), r.crc32c);
    };
    for (std::size_t n = 0; n < whole.size(); n += 3) {
        write_text(path, whole.substr(0, n));
        check();
        std::string flipped = whole;
        flipped[n] = static_cast<char>(flipped[n] ^ 0x41);
        write_text(path, flipped);
        check();
    }
}

TEST(ChunkCache, StaysWithinItsRoomAndForgetsTheOldest) {
    const ScratchFolder folder;
    const std::uint64_t room = 200'000;
    for (unsigned i = 0; i < 12; ++i) {
        ChunkCache cache({folder / "c", room}, "url" + std::to_string(i));
        fill(cache, make_stream_file({.payload_bytes = 1000, .seed = i + 1}));
    }
    // One model may come on top of a full folder before the next one makes room.
    EXPECT_LT(size_of(folder / "c"), room * 3 / 2);
    EXPECT_FALSE(ChunkCache({folder / "c", room}, "url0").load({}));
    EXPECT_TRUE(ChunkCache({folder / "c", room}, "url11").load({}));
}

TEST(ChunkCache, FolderThatCannotBeWrittenIsNoFault) {
    ChunkCache cache({"/proc/nothing"}, "url");
    fill(cache, make_stream_file());
    EXPECT_FALSE(cache.load({}));
}

}  // namespace
}  // namespace mvw::client
