// Any bytes, fed to a decoder in slices of any sizes, give a mesh with indices in range or none. To get past the
// checksums, inputs are not files but scripts: byte 0 says how. Even: the rest is a stream as it is, cut into slices by
// its own bytes. Odd: one of two headers of our making, then chunks (level and tile, layer, channel, length, payload)
// with right checksums.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/decoder.h"

namespace {

mvw::Limits small_limits() {
    mvw::Limits limits;
    limits.max_vertices = 20'000;
    limits.max_memory_bytes = 32u << 20;
    limits.max_base_faces = 10'000;
    return limits;
}

void check(const mvw::Decoder& decoder) {
    const auto mesh = decoder.mesh();
    if (!mesh.ok()) return;
    for (const mvw::Face& f : mesh->faces)
        for (const std::uint32_t v : f)
            if (v >= mesh->positions.size()) std::abort();
    for (const mvw::VertexField& field : mesh->fields) {
        if (field.values.size() != field.components() * mesh->positions.size()) std::abort();
        for (const double x : field.values)
            if (!std::isfinite(x)) std::abort();
    }
}

void feed_stream(mvw::ByteSpan bytes) {
    mvw::Decoder decoder(small_limits());
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t slice =
            std::min<std::size_t>(1 + std::to_integer<std::size_t>(bytes[at]) % 97, bytes.size() - at);
        if (!decoder.feed(bytes.subspan(at, slice)).ok()) break;
        at += slice;
    }
    check(decoder);
    decoder.finish();
    check(decoder);
}

mvw::Bytes header_of(const std::vector<mvw::PartInfo>& parts) {
    mvw::FileHeader header;
    (void)mvw::set_box(header, {0, 0, 0}, 1).ok();
    header.transform = 9;
    header.layers = 20;
    header.parts = parts;
    return mvw::write_file(header, {}).value();
}

void feed_chunks(mvw::ByteSpan bytes, bool progressive) {
    // Octahedra; or one that grows.
    static const mvw::Bytes octahedra = header_of(
        {{4, 6, 12, 8, 2}, {0, 6, 12, 8, 1}, {0, 60, 174, 116, 1, 0, false, true, true}, {0, 6, 12, 8, 2, 0, true}});
    static const mvw::Bytes growing = header_of({{0, 60, 174, 116, 2, 0, false, false, true}});
    const mvw::Bytes& header = progressive ? growing : octahedra;
    mvw::Decoder decoder(small_limits());
    if (!decoder.feed_header(header).ok()) std::abort();
    mvw::ByteReader in(bytes);
    while (in.remaining() > 0) {
        const unsigned where = in.u8(), layer = in.u8() % 20, channel = in.u8() % 16, length = in.u8();
        const auto level = static_cast<std::uint8_t>(where % 5);
        mvw::ChunkId id{static_cast<std::uint16_t>(where / 10 % 4), static_cast<std::uint16_t>(where / 5 % 2), level,
                        static_cast<std::uint8_t>(layer),
                        channel == 0 ? mvw::Channel::Geometry : static_cast<mvw::Channel>(channel)};
        if (where >= 240) id = {static_cast<std::uint16_t>(where % 4)};
        if (id.channel == mvw::Channel::Splits) id.tile = 0, id.level = 0;
        if (progressive) id.part = 0, id.level = 0;
        const mvw::ByteSpan payload = in.bytes(std::min<std::size_t>(length, in.remaining()));
        (void)decoder.feed_chunk(id, payload, mvw::crc32c(payload)).ok();
    }
    check(decoder);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    const mvw::Bytes bytes(begin + 1, begin + size);  // a block of its own, so that reading past it is seen
    data[0] % 2 == 0 ? feed_stream(bytes) : feed_chunks(bytes, data[0] % 4 == 3);
    return 0;
}
