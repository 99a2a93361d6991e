// Any bytes as the planes of a block and of its parent decode to values within their planes; a cut plane ends the
// block. Byte 0: components, level and, in its highest bit, the way the planes come; byte 1: top plane; then each plane
// is a length byte and that many bytes. The other way: byte 2 is the lowest plane, the rest is a zstd frame or, where it
// is none that fits, what comes out of one.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "codec/entropy/dec_block.h"
#include "codec/entropy/packed_planes.h"

namespace {

mvw::BaseMesh octahedron() {
    return mvw::BaseMesh::create(
               6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}})
        .value();
}

void check_values(const mvw::BlockDecoder& block, std::size_t size) {
    std::vector<float> values(size * block.components());
    const std::vector<float> ones(block.components(), 1.0f);
    block.values(0.5f, ones, 0, values);
    for (const float v : values)
        if (!(v >= -268435456.0f && v <= 268435456.0f)) std::abort();
}

void unpack(mvw::BlockDecoder& block, std::size_t size, unsigned top, unsigned low, mvw::ByteSpan rest) {
    mvw::Bytes raw;
    const std::size_t entries = size * block.components();
    if (top >= mvw::kMaxPlanes || low > top) {
        if (block.unpack(size, top, low, rest)) std::abort();
        return;
    }
    if (!mvw::unzip_planes(rest, entries, top, low, raw)) {
        raw.assign(entries * mvw::packed_width(top, low), std::byte{});
        for (std::size_t i = 0; i < raw.size() && !rest.empty(); ++i) raw[i] = rest[i % rest.size()];
    }
    if (!block.unpack(size, top, low, raw)) std::abort();
    check_values(block, size);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    static const mvw::BaseMesh base = octahedron();
    static const mvw::Tiling tiling(base, std::vector<std::uint16_t>{0, 1, 1, 0, 0, 0, 0, 0}, 2);
    const unsigned components = 1 + data[0] % mvw::kMaxComponents, level = 2 + data[0] / 4 % 3;
    unsigned plane = data[1];
    const mvw::BlockShape coarse(base, tiling, 0, level - 1), fine(base, tiling, 0, level);
    mvw::BlockDecoder parent(components), block(components);
    if (data[0] >= 128 && size > 2) {
        const auto* begin = reinterpret_cast<const std::byte*>(data) + 3;
        const mvw::Bytes rest(begin, begin + (size - 3));
        unpack(block, fine.size(), plane, data[2], rest);
        return 0;
    }
    for (std::size_t at = 2; at < size; --plane) {
        const std::size_t wanted = data[at++], length = wanted < size - at ? wanted : size - at;
        const auto* begin = reinterpret_cast<const std::byte*>(data) + at;
        const mvw::Bytes bytes(begin, begin + length);  // a block of its own, so that reading past it is seen
        at += length;
        const bool whole = length == wanted;
        if (!parent.decode_plane(coarse, nullptr, plane, bytes, true)) return 0;
        if (!block.decode_plane(fine, &parent, plane, bytes, whole)) std::abort();
        check_values(block, fine.size());
        if (!whole || plane == 0) return 0;
    }
    return 0;
}
