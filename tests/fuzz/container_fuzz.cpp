// Any bytes as a header, an index and chunk heads are read or refused; what is read can be written again. The input is
// the file; a second reading takes it to be an index of the golden header alone.
#include <cstdint>
#include <cstdlib>

#include "codec/container/enc_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    const mvw::Bytes file(begin, begin + size);  // a block of its own, so that reading past it is seen
    const auto header = mvw::read_header(file);
    if (header.ok() && header->file_bytes() == size) {
        const auto toc = mvw::read_toc(*header, mvw::ByteSpan(file).subspan(header->index_offset), size);
        if (toc.ok()) {
            std::vector<mvw::ChunkToWrite> chunks;
            for (const mvw::ChunkEntry& c : toc->chunks)
                chunks.push_back({c.id, mvw::ByteSpan(file).subspan(c.offset, c.length), c.error});
            if (!mvw::write_file(*header, chunks).ok()) std::abort();
        }
    }
    mvw::FileHeader any;
    any.layers = 31;
    any.parts = {{5, 4, 6, 4, 2},
                 {0, 3, 3, 1, 1},
                 {0, 4, 6, 4, 1, 0, false, true},
                 {0, 4, 6, 4, 1, 0, true},
                 {0, 4, 6, 4, 2, 0, true}};
    any.header_bytes = 50;
    any.index_bytes = static_cast<std::uint32_t>(size);
    for (const std::uint64_t body : {std::uint64_t{100}, std::uint64_t{1000}}) {
        any.index_offset = any.header_bytes + body;
        (void)mvw::read_toc(any, file, any.file_bytes()).ok();
    }
    mvw::ByteReader in(file);
    mvw::ChunkId previous;
    while (in.remaining() > 0) {
        const auto head = mvw::read_chunk_head(in, previous);
        if (!head.ok()) break;
        previous = head->id;
    }
    return 0;
}
