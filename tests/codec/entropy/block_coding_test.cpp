#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "codec/entropy/dec_block.h"
#include "codec/entropy/enc_block.h"
#include "codec/entropy/packed_planes.h"

namespace mvw {
namespace {

constexpr float kMiddle = 0.4f;

BaseMesh octahedron() {
    return BaseMesh::create(6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}})
        .value();
}

Tiling single_tile(const BaseMesh& base) {
    return {base, std::vector<std::uint16_t>(base.face_count(), 0), 1};
}

/// Coefficients as a surface gives them: most near zero, a few regions active, sign free.
std::vector<float> surface_like(const BlockShape& shape, unsigned components, unsigned seed, double scale = 40) {
    std::mt19937 random(seed);
    std::vector<float> scaled(shape.size() * components);
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const double place = static_cast<double>(i) / static_cast<double>(shape.size());
        const double activity = scale * std::pow(std::abs(std::sin(9 * place)), 6.0) + 0.1;
        for (unsigned c = 0; c < components; ++c) {
            const double uniform = (static_cast<double>(random()) + 1.0) / 4294967297.0;
            const double laplace = -std::log(uniform) * activity / (c + 1);
            scaled[i * components + c] = static_cast<float>(random() % 2 == 0 ? laplace : -laplace);
        }
    }
    return scaled;
}

std::vector<float> values_of(const BlockDecoder& decoder, std::size_t count, float reconstruction = kMiddle) {
    std::vector<float> values(count);
    const std::vector<float> ones(decoder.components(), 1.0f);
    decoder.values(reconstruction, ones, 0, values);
    return values;
}

/// What a value decodes to when planes from `plane` up are known.
float expected_value(float x, unsigned plane) {
    const double known = std::floor(std::abs(x) / std::ldexp(1.0, static_cast<int>(plane)));
    if (known == 0) return 0;
    return static_cast<float>(std::copysign(std::ldexp(known + double{kMiddle}, static_cast<int>(plane)), x));
}

TEST(BlockCoding, EveryPlaneOfEveryLevelAndComponentCountDecodesToItsQuantiser) {
    const BaseMesh base = octahedron();
    const Tiling tiling = single_tile(base);
    for (unsigned components = 1; components <= kMaxComponents; ++components) {
        Entries parent_entries;
        std::unique_ptr<BlockDecoder> parent;
        for (unsigned level = 0; level <= 5; ++level) {
            const BlockShape shape(base, tiling, 0, level);
            const std::vector<float> scaled = surface_like(shape, components, level);
            const EncodedBlock block = encode_block(shape, components, scaled, parent_entries, kMiddle);
            auto decoder = std::make_unique<BlockDecoder>(components);
            for (const EncodedPlane& plane : block.planes) {
                ASSERT_TRUE(decoder->decode_plane(shape, parent.get(), plane.plane, plane.bytes, true).ok());
                const std::vector<float> values = values_of(*decoder, scaled.size());
                for (std::size_t at = 0; at < scaled.size(); ++at)
                    ASSERT_FLOAT_EQ(values[at], expected_value(scaled[at], plane.plane)) << level << " " << at;
            }
            parent_entries = block.entries;
            parent = std::move(decoder);
        }
    }
}

TEST(BlockCoding, PackedPlanesGiveTheSameValuesAsCodedOnes) {
    const BaseMesh base = octahedron();
    const BlockShape shape(base, single_tile(base), 0, 4);
    for (unsigned components = 1; components <= kMaxComponents; ++components) {
        const std::vector<float> scaled = surface_like(shape, components, components, 1e5);
        const EncodedBlock block = encode_block(shape, components, scaled, {}, kMiddle);
        const unsigned top = block.planes.front().plane;
        BlockDecoder coded(components), packed(components);
        std::size_t next = 0;
        // Words of every width that there is: 1 byte holds 7 planes and a sign.
        for (const unsigned planes : {1u, 7u, 8u, 30u}) {
            const unsigned first = block.planes[next].plane, low = first - std::min(first, planes - 1);
            for (; next < block.planes.size() && block.planes[next].plane >= low; ++next)
                ASSERT_TRUE(
                    coded.decode_plane(shape, nullptr, block.planes[next].plane, block.planes[next].bytes, true));
            Bytes raw;
            ASSERT_TRUE(
                unzip_planes(pack_planes(block.entries, components, first, low), scaled.size(), first, low, raw));
            ASSERT_TRUE(packed.unpack(shape.size(), first, low, raw));
            EXPECT_FALSE(packed.unpack(shape.size(), first, low, raw)) << "the same planes again";
            ASSERT_EQ(values_of(coded, scaled.size()), values_of(packed, scaled.size())) << top << " to " << low;
            if (low == 0) break;
        }
        ASSERT_EQ(coded.lowest_plane(), 0u);
        std::vector<std::int32_t> from_coded(scaled.size()), from_packed(scaled.size());
        coded.integers(from_coded);
        packed.integers(from_packed);
        EXPECT_EQ(from_coded, from_packed);
    }
}

TEST(BlockCoding, ValuesOfARangeAreScaledByComponent) {
    const BaseMesh base = octahedron();
    const BlockShape shape(base, single_tile(base), 0, 3);
    const std::vector<float> scaled = surface_like(shape, 3, 5);
    const EncodedBlock block = encode_block(shape, 3, scaled, {}, kMiddle);
    const unsigned top = block.planes.front().plane;
    BlockDecoder coded(3), packed(3), cut(3);
    for (const EncodedPlane& p : block.planes) ASSERT_TRUE(coded.decode_plane(shape, nullptr, p.plane, p.bytes, true));
    Bytes raw;
    ASSERT_TRUE(unzip_planes(pack_planes(block.entries, 3, top, 0), scaled.size(), top, 0, raw));
    ASSERT_TRUE(packed.unpack(shape.size(), top, 0, raw));
    for (const EncodedPlane& p : block.planes) {
        const bool last = p.plane == 0;
        const ByteSpan bytes = ByteSpan(p.bytes).first(last ? p.bytes.size() / 2 : p.bytes.size());
        ASSERT_TRUE(cut.decode_plane(shape, nullptr, p.plane, bytes, !last));
    }
    const std::array<float, 3> scale{2, 0.5f, 3};
    for (const BlockDecoder* decoder : {&coded, &packed, &cut}) {
        const std::vector<float> all = values_of(*decoder, scaled.size());
        for (std::size_t first = 0, count = 1; first + count < shape.size(); first += count, count = count * 2 + 1) {
            std::vector<float> values(3 * count);
            decoder->values(kMiddle, scale, first, values);
            for (std::size_t at = 0; at < values.size(); ++at)
                ASSERT_EQ(values[at], all[3 * first + at] * scale[at % 3]) << first << " " << at;
        }
    }
}

TEST(BlockCoding, TilesDecodeAlone) {
    const BaseMesh base = octahedron();
    const Tiling tiling(base, std::vector<std::uint16_t>{0, 1, 1, 0, 2, 2, 2, 0}, 3);
    for (std::uint32_t tile = 0; tile < 3; ++tile) {
        const BlockShape coarse(base, tiling, tile, 3), fine(base, tiling, tile, 4);
        const EncodedBlock below = encode_block(coarse, 3, surface_like(coarse, 3, tile), {}, kMiddle);
        const std::vector<float> scaled = surface_like(fine, 3, tile + 10);
        const EncodedBlock block = encode_block(fine, 3, scaled, below.entries, kMiddle);
        BlockDecoder parent(3), decoder(3);
        for (const EncodedPlane& p : below.planes)
            ASSERT_TRUE(parent.decode_plane(coarse, nullptr, p.plane, p.bytes, true).ok());
        for (const EncodedPlane& p : block.planes)
            ASSERT_TRUE(decoder.decode_plane(fine, &parent, p.plane, p.bytes, true).ok());
        const std::vector<float> values = values_of(decoder, scaled.size());
        for (std::size_t at = 0; at < scaled.size(); ++at) ASSERT_FLOAT_EQ(values[at], expected_value(scaled[at], 0));
    }
}

TEST(BlockCoding, AParentMayBeAheadButItsLowerPlanesAreNotUsed) {
    const BaseMesh base = octahedron();
    const Tiling tiling = single_tile(base);
    const BlockShape coarse(base, tiling, 0, 2), fine(base, tiling, 0, 3);
    const EncodedBlock below = encode_block(coarse, 3, surface_like(coarse, 3, 1), {}, kMiddle);
    const EncodedBlock block = encode_block(fine, 3, surface_like(fine, 3, 2), below.entries, kMiddle);
    BlockDecoder ahead(3), in_step(3), after_parent(3), beside_parent(3);
    for (const EncodedPlane& p : below.planes) ASSERT_TRUE(ahead.decode_plane(coarse, nullptr, p.plane, p.bytes, true));
    std::size_t next = 0;
    for (const EncodedPlane& p : block.planes) {
        for (; next < below.planes.size() && below.planes[next].plane > p.plane; ++next)
            ASSERT_TRUE(
                in_step.decode_plane(coarse, nullptr, below.planes[next].plane, below.planes[next].bytes, true));
        ASSERT_TRUE(after_parent.decode_plane(fine, &ahead, p.plane, p.bytes, true));
        ASSERT_TRUE(beside_parent.decode_plane(fine, &in_step, p.plane, p.bytes, true));
    }
    const std::size_t count = fine.size() * 3;
    EXPECT_EQ(values_of(after_parent, count), values_of(beside_parent, count));
}

TEST(BlockCoding, EveryTruncationOfAPlaneDecodesABeginningOfTheSameSymbols) {
    const BaseMesh base = octahedron();
    const Tiling tiling = single_tile(base);
    const BlockShape shape(base, tiling, 0, 4);
    const std::vector<float> scaled = surface_like(shape, 3, 5);
    const EncodedBlock block = encode_block(shape, 3, scaled, {}, kMiddle);
    for (std::size_t p = 0; p < block.planes.size(); ++p) {
        const EncodedPlane& plane = block.planes[p];
        std::size_t updated_before = 0;
        for (std::size_t length = 0; length < plane.bytes.size(); ++length) {
            const Bytes cut(plane.bytes.begin(), plane.bytes.begin() + static_cast<std::ptrdiff_t>(length));
            BlockDecoder decoder(3);
            for (std::size_t q = 0; q < p; ++q)
                ASSERT_TRUE(
                    decoder.decode_plane(shape, nullptr, block.planes[q].plane, block.planes[q].bytes, true).ok());
            ASSERT_TRUE(decoder.decode_plane(shape, nullptr, plane.plane, cut, false).ok());
            const std::vector<float> values = values_of(decoder, scaled.size());
            std::size_t updated = 0;
            while (updated < scaled.size() && values[updated] == expected_value(scaled[updated], plane.plane))
                ++updated;
            for (std::size_t at = updated; at < scaled.size(); ++at)
                ASSERT_FLOAT_EQ(values[at], expected_value(scaled[at], plane.plane + 1)) << at;
            EXPECT_GE(updated, updated_before);
            updated_before = updated;
            EXPECT_FALSE(decoder.decode_plane(shape, nullptr, plane.plane - 1, {}, true).ok());
        }
        // All but its last few bytes must already tell nearly all symbols.
        if (plane.bytes.size() > 50) {
            EXPECT_GT(updated_before, scaled.size() * 9 / 10);
        }
    }
}

TEST(BlockCoding, ErrorReductionsSumToWhatTheDecoderGains) {
    const BaseMesh base = octahedron();
    const Tiling tiling = single_tile(base);
    const BlockShape shape(base, tiling, 0, 4);
    const std::vector<float> scaled = surface_like(shape, 3, 6);
    const EncodedBlock block = encode_block(shape, 3, scaled, {}, kMiddle);
    std::array<double, 3> left{};
    for (std::size_t at = 0; at < scaled.size(); ++at) left[at % 3] += double{scaled[at]} * double{scaled[at]};
    BlockDecoder decoder(3);
    for (const EncodedPlane& plane : block.planes) {
        ASSERT_TRUE(decoder.decode_plane(shape, nullptr, plane.plane, plane.bytes, true).ok());
        const std::vector<float> values = values_of(decoder, scaled.size());
        std::array<double, 3> error{};
        for (std::size_t at = 0; at < scaled.size(); ++at) {
            const double difference = double{scaled[at]} - double{values[at]};
            error[at % 3] += difference * difference;
        }
        for (unsigned c = 0; c < 3; ++c) {
            left[c] -= plane.error_reduction[c];
            EXPECT_NEAR(left[c], error[c], 1e-3 * (1 + error[c]));
        }
    }
}

TEST(BlockCoding, ABlockOfZerosHasNoPlanesAndDecodesToZeros) {
    const BaseMesh base = octahedron();
    const BlockShape shape(base, single_tile(base), 0, 3);
    const std::vector<float> scaled(shape.size() * 3, 0.9f);
    EXPECT_TRUE(encode_block(shape, 3, scaled, {}, kMiddle).planes.empty());
    const BlockDecoder decoder(3);
    EXPECT_FALSE(decoder.started());
    EXPECT_EQ(values_of(decoder, scaled.size()), std::vector<float>(scaled.size(), 0.0f));
}

TEST(BlockCoding, IntegersComeBackExactly) {
    const BaseMesh base = octahedron();
    const BlockShape shape(base, single_tile(base), 0, 2);
    std::vector<float> scaled(shape.size() * 3, 0.0f);
    scaled[5] = -8388608.0f;
    scaled[9] = 1.0f;
    const EncodedBlock block = encode_block(shape, 3, scaled, {}, 0.0f);
    BlockDecoder decoder(3);
    for (const EncodedPlane& p : block.planes)
        ASSERT_TRUE(decoder.decode_plane(shape, nullptr, p.plane, p.bytes, true));
    std::vector<std::int32_t> integers(scaled.size());
    decoder.integers(integers);
    for (std::size_t at = 0; at < scaled.size(); ++at) EXPECT_EQ(integers[at], static_cast<std::int32_t>(scaled[at]));
}

TEST(BlockCoding, OneCoefficientIsABlock) {
    const BaseMesh base = BaseMesh::create(3, {{0, 1, 2}}).value();
    const Tiling tiling(base, std::vector<std::uint16_t>{0}, 1);
    const BlockShape shape(base, tiling, 0, 1);
    ASSERT_EQ(shape.size(), 3u);
    for (const float x : {0.0f, 1.0f, -1.0f, 5.5f, -1000.0f}) {
        const std::vector<float> scaled{x, 0, 0};
        const EncodedBlock block = encode_block(shape, 1, scaled, {}, kMiddle);
        BlockDecoder decoder(1);
        for (const EncodedPlane& p : block.planes)
            ASSERT_TRUE(decoder.decode_plane(shape, nullptr, p.plane, p.bytes, true));
        EXPECT_FLOAT_EQ(values_of(decoder, 3)[0], expected_value(x, 0));
    }
}

TEST(BlockCoding, RefusesPlanesOutOfOrder) {
    const BaseMesh base = octahedron();
    const BlockShape shape(base, single_tile(base), 0, 2);
    BlockDecoder decoder(3);
    EXPECT_FALSE(decoder.decode_plane(shape, nullptr, kMaxPlanes, {}, true).ok());
    ASSERT_TRUE(decoder.decode_plane(shape, nullptr, 5, {}, true).ok());
    EXPECT_FALSE(decoder.decode_plane(shape, nullptr, 5, {}, true).ok());
    EXPECT_FALSE(decoder.decode_plane(shape, nullptr, 3, {}, true).ok());
    EXPECT_TRUE(decoder.decode_plane(shape, nullptr, 4, {}, true).ok());
}

TEST(BlockCoding, AnyBytesDecodeToValuesWithinTheirPlanes) {
    const BaseMesh base = octahedron();
    const BlockShape shape(base, single_tile(base), 0, 4);
    std::mt19937 random(7);
    for (int run = 0; run < 60; ++run) {
        const unsigned components = 1 + random() % 4;
        BlockDecoder decoder(components);
        const bool cut = run % 3 == 0;
        for (unsigned plane = run % 2 == 0 ? kMaxPlanes : 6; plane-- > 0;) {
            Bytes bytes(random() % 400);
            for (std::byte& b : bytes) b = static_cast<std::byte>(run % 5 == 0 ? 0xFFu : random());
            ASSERT_TRUE(decoder.decode_plane(shape, nullptr, plane, bytes, !cut).ok());
            if (cut) break;
        }
        for (const float v : values_of(decoder, shape.size() * components)) EXPECT_LE(std::abs(v), 268435456.0f);
    }
}

}  // namespace
}  // namespace mvw
