#include "codec/enc_closing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "client/drawable.h"
#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/enc_stage.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/part_params.h"
#include "tests/support/encoded_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

Mesh rough_torus() {
    return mvw::rough_torus(61, 37, 0.005);
}

Encoded encode_with(bool close, Profile profile = Profile::Small) {
    EncodeOptions options;
    options.close = close;
    options.profile = profile;
    return encode(rough_torus(), options).value();
}
const Encoded& closed() {
    static const Encoded file = encode_with(true);
    return file;
}

std::size_t first_of_closing(const Toc& toc) {
    const auto last = static_cast<std::uint16_t>(toc.header.parts.size() - 1);
    return static_cast<std::size_t>(
        std::ranges::find_if(toc.chunks, [&](const ChunkEntry& c) { return c.id.part == last; }) - toc.chunks.begin());
}

TEST(Closing, EndsAFileWithTheInputsTrianglesWhereThatIsShorter) {
    const Encoded wavelets = encode_with(false);
    EXPECT_EQ(wavelets.closing_bytes, 0u);
    EXPECT_FALSE(toc_of(wavelets.file).header.parts.back().supersedes);
    EXPECT_GT(closed().closing_bytes, 0u);
    EXPECT_LT(closed().file.size(), wavelets.file.size());
    EXPECT_LT(closed().rms, wavelets.rms);
    EXPECT_LT(closed().max, wavelets.max / 2);
    const Mesh input = rough_torus(), back = decode(closed().file).value();
    EXPECT_EQ(back.positions.size(), input.positions.size());
    EXPECT_EQ(back.faces.size(), input.faces.size());
    EXPECT_NEAR(surface_error(input, back).rms, closed().rms, 0.1 * closed().rms);
}

TEST(Closing, FastFilesAreClosedToo) {
    const Encoded fast = encode_with(true, Profile::Fast);
    EXPECT_GT(fast.closing_bytes, 0u);
    EXPECT_EQ(decode(fast.file)->faces.size(), rough_torus().faces.size());
    EXPECT_LT(fast.rms, 3e-5);
}

TEST(Closing, QualityNeverFallsNorJumps) {
    const Mesh input = rough_torus();
    const Toc toc = toc_of(closed().file);
    const std::size_t first = first_of_closing(toc);
    ASSERT_LT(first + 20, toc.chunks.size()) << "planes of many tiles";
    double last = 0;
    for (std::size_t i = first - 1; i < toc.chunks.size(); ++i) {
        const ChunkEntry& c = toc.chunks[i];
        const Mesh mesh = decode(ByteSpan(closed().file).first(c.offset + c.length)).value();
        const double psnr = surface_error(input, mesh, {100'000}).psnr;
        if (last > 0) {
            EXPECT_GT(psnr, last - 0.05) << i;
            EXPECT_LT(psnr, last + (i == first ? 0.9 : 1.3)) << i;  // this model's planes climb as steeply
        }
        EXPECT_NEAR(psnr, -20 * std::log10(c.error), i < first ? 1.0 : 0.5) << i;
        last = psnr;
    }
}

TEST(Closing, AtLevelsOfTheWaveletsAreTheWavelets) {
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_file(closed().file));
    const Toc toc = toc_of(closed().file);
    const PartInfo& part = toc.header.parts[0];
    for (unsigned level = 0; level <= part.levels; ++level) {
        EXPECT_EQ(decoder.mesh(level)->faces.size(), std::size_t{part.base_faces} << (2 * level));
        EXPECT_TRUE(decoder.shows(0, level) && !decoder.shows(1, level));
    }
    EXPECT_TRUE(!decoder.shows(0, 255) && decoder.shows(1, 255));
    EXPECT_TRUE(decoder.state().complete);

    // Drawables of one level and as many parts share their indices: these do not.
    const client::Drawable all = client::make_drawable(decoder, {}).value();
    const client::Drawable finest = client::make_drawable(decoder, {part.levels, false, false}).value();
    EXPECT_EQ(all.level, finest.level);
    EXPECT_NE(all.parts, finest.parts);
    EXPECT_EQ(all.triangles.size(), 3 * rough_torus().faces.size());
    EXPECT_EQ(all.solid, finest.solid);
}

TEST(Closing, WithoutItsBaseWaveletsStay) {
    const Toc toc = toc_of(closed().file);
    const std::size_t first = first_of_closing(toc);
    Bytes damaged = closed().file;
    damaged[toc.chunks[first].offset + 20] ^= std::byte{1};
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_file(damaged));
    EXPECT_EQ(decoder.state().damaged, 1u);
    EXPECT_FALSE(decoder.shows(1, 255));
    EXPECT_EQ(decoder.mesh()->faces.size(),
              std::size_t{toc.header.parts[0].base_faces} << (2 * toc.header.parts[0].levels));
    // The other way round it is all there is.
    Decoder alone;
    ASSERT_TRUE(alone.feed_file(closed().file, [&](const ChunkEntry& c) { return c.id.part == 1; }));
    EXPECT_EQ(alone.mesh()->faces.size(), rough_torus().faces.size());
    EXPECT_EQ(alone.mesh(0).error().code, Errc::NeedMoreData);
}

TEST(Closing, ViewsOfFewerLayersDoWithout) {
    const FileHeader header = toc_of(closed().file).header;
    const ChunkId base{1, 0, 0, 0, Channel::Base}, planes{1, 0, 0, 0, Channel::Geometry};
    for (const ChunkId& id : {base, planes}) {
        EXPECT_FALSE(in_layers(header, id, header.layers - 2u));
        EXPECT_TRUE(in_layers(header, id, header.layers - 1u));
    }
    EXPECT_TRUE(in_layers(header, {0, 0, 0, 0, Channel::Base}, 0));
    EXPECT_FALSE(in_layers(header, {0, 0, 0, 3, Channel::Geometry}, 2));
}

TEST(Closing, OnlyTheLastOfSeveralPartsWithoutLevelsMayClose) {
    const auto error_of = [](std::vector<PartInfo> parts) {
        FileHeader header;
        header.layers = 1;
        header.parts = std::move(parts);
        const Bytes payload(8);
        const Result<Bytes> file = write_file(header, std::vector<ChunkToWrite>{{{}, payload, 0.5f}});
        const Result<FileHeader> back = file.ok() ? read_header(*file) : Result<FileHeader>(file.error());
        return back.ok() ? std::string() : back.error().message;
    };
    const PartInfo plain{2, 4, 6, 4}, closing{0, 4, 6, 4, 1, 0, true}, deep{2, 4, 6, 4, 1, 0, true};
    const PartInfo preview{0, 4, 6, 4, 1, 0, false, true}, both{0, 4, 6, 4, 1, 0, true, true};
    EXPECT_EQ(error_of({plain, closing}), "");
    EXPECT_EQ(error_of({plain, preview}), "");
    EXPECT_EQ(error_of({plain, plain, preview, closing}), "");
    for (const auto& parts : {std::vector{closing}, {closing, plain}, {plain, deep}, {preview}})
        EXPECT_EQ(error_of(parts), "a preview or a closing part has levels or is the first");
    for (const auto& parts : {std::vector{plain, closing, plain},
                              {plain, closing, preview},
                              {plain, preview, preview},
                              {plain, closing, closing}})
        EXPECT_EQ(error_of(parts), "a part follows the preview or the closing one");
    EXPECT_EQ(error_of({plain, both}), "a preview is a closing part");
}

/// The torus' wavelets behind a coarse version of it.
Bytes previewed(const Encoded& wavelets, PartInfo& preview) {
    const Mesh torus = rough_torus();
    const std::unique_ptr<EncoderInput> input = EncoderInput::make(torus, 1).value();
    const std::vector<Lod> versions = versions_of(*input, own_version(*input).value(), {{0.002, 1}}, 1);
    Stage stage = code_stage(*input, versions[0], {9, 0, false, 1});
    PlannedChunk& base = stage.chunks.front();
    const Toc toc = toc_of(wavelets.file);
    FileHeader header = toc.header;
    base.id.part = static_cast<std::uint16_t>(header.parts.size());
    base.payload[1] = std::byte{error_to_code(base.error)};
    preview = stage.info;
    preview.preview = true;
    header.parts.push_back(preview);
    std::vector<ChunkToWrite> chunks{{base.id, base.payload, static_cast<float>(base.error)}};
    for (const ChunkEntry& c : toc.chunks)
        chunks.push_back({c.id, ByteSpan(wavelets.file).subspan(c.offset, c.length), c.error});
    return write_file(header, chunks).value();
}

TEST(Preview, IsShownUntilTheWaveletsAreBetter) {
    const Encoded wavelets = encode_with(false);
    PartInfo preview;
    const Bytes file = previewed(wavelets, preview);
    const Toc toc = toc_of(file);
    EXPECT_EQ(chunks_until_shown(toc), 1u);
    const Mesh input = rough_torus();
    std::size_t previews = 0;
    double last = 0;
    for (const ChunkEntry& c : toc.chunks) {
        const ByteSpan beginning = ByteSpan(file).first(c.offset + c.length);
        Decoder decoder;
        ASSERT_TRUE(decoder.feed(beginning).ok());
        EXPECT_NE(decoder.shows(0, 255), decoder.shows(1, 255));
        previews += decoder.shows(1, 255);
        if (decoder.shows(1, 255)) {
            EXPECT_EQ(decoder.mesh()->faces.size(), preview.base_faces);
        }
        const double psnr = surface_error(input, decoder.mesh().value(), {100'000}).psnr;
        EXPECT_GT(psnr, last - 0.3) << "chunk that ends at " << c.offset + c.length;
        last = psnr;
        // Who asks for a level gets it as soon as it is there.
        if (decoder.base(0) != nullptr) {
            EXPECT_TRUE(decoder.shows(0, 1) && !decoder.shows(1, 1));
        }
    }
    EXPECT_GE(previews, 2u);
    EXPECT_LT(previews, toc.chunks.size() / 2);
    EXPECT_EQ(decode(file)->positions.size(), decode(wavelets.file)->positions.size());
}

TEST(Preview, IsNothingToWaitFor) {
    const Encoded wavelets = encode_with(false);
    PartInfo preview;
    const Bytes file = previewed(wavelets, preview);
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_file(file, [](const ChunkEntry& c) { return c.id.part == 0; }));
    EXPECT_EQ(decoder.mesh()->positions.size(), decode(wavelets.file)->positions.size());
}

/// Of flat parts and sharp edges alone: one that plain triangles serve from the beginning.
class PlainFile : public ::testing::Test {
 protected:
    static const Mesh& plate() {
        static const Mesh mesh = chequered_plate(20);
        return mesh;
    }
    static const Encoded& file(bool close) {
        static const std::array files{encode_plate(false), encode_plate(true)};
        return files[close ? 1 : 0];
    }
    static double psnr_at(const Encoded& encoded, std::size_t bytes) {
        const Result<Mesh> mesh = decode(ByteSpan(encoded.file).first(bytes));
        return mesh.ok() ? surface_error(plate(), *mesh, {200'000}).psnr : 0;
    }

 private:
    static Encoded encode_plate(bool close) {
        EncodeOptions options;
        options.close = close;
        return encode(plate(), options).value();
    }
};

TEST_F(PlainFile, IsBetterFromTheBeginning) {
    const Toc toc = toc_of(file(true).file);
    ASSERT_EQ(toc.header.parts.size(), 1u);
    EXPECT_TRUE(toc.header.parts[0].progressive);
    EXPECT_GT(finest_level(toc_of(file(false).file).header), 0u);
    const std::size_t first = toc.chunks[0].offset + toc.chunks[0].length;
    for (const std::size_t bytes : {first, std::size_t{2048}, std::size_t{3072}})
        EXPECT_GT(psnr_at(file(true), bytes), psnr_at(file(false), bytes) + 1) << bytes;
    EXPECT_EQ(file(true).levels, 0u);
    EXPECT_GT(file(true).psnr, 90);
}

TEST_F(PlainFile, NeverGetsWorse) {
    const Toc toc = toc_of(file(true).file);
    double last = 0;
    for (const ChunkEntry& c : toc.chunks) {
        const double psnr = psnr_at(file(true), c.offset + c.length);
        EXPECT_GT(psnr, last - 0.1) << "chunk that ends at " << c.offset + c.length;
        EXPECT_NEAR(psnr, -20 * std::log10(c.error), 1.0);
        last = std::max(last, psnr);
    }
}

TEST(Closing, WhatCannotBeRemeshedShowsSomethingEarlyAllTheSame) {
    const Mesh input = mvw::rough_torus(30, 16, 0.1);
    EncodeOptions options;
    options.close = false;
    const Encoded alone = encode(input, options).value(), file = encode(input, {}).value();
    ASSERT_GT(alone.facets_area_share + alone.draco_area_share, 0.99);
    EXPECT_GT(file.psnr, 90);
    EXPECT_LT(double(file.file.size()), 1.7 * double(alone.file.size()));
    const std::size_t half = alone.file.size() / 2;
    EXPECT_FALSE(decode(ByteSpan(alone.file).first(half)).ok());
    const Result<Mesh> early = decode(ByteSpan(file.file).first(half));
    ASSERT_TRUE(early.ok()) << early.error().message;
    EXPECT_GT(surface_error(input, *early, {.samples = 20'000}).psnr, 40);
}

/// Circles of latitude between two poles, as programs draw balls.
Mesh ball_of_circles(std::uint32_t around, std::uint32_t circles) {
    Mesh mesh;
    for (std::uint32_t c = 1; c <= circles; ++c)
        for (std::uint32_t k = 0; k < around; ++k) {
            const double a = c * std::numbers::pi / (circles + 1), b = k * 2 * std::numbers::pi / around;
            mesh.positions.push_back({std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)});
        }
    const std::uint32_t north = around * circles, south = north + 1;
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 1}, {0, 0, -1}});
    for (std::uint32_t k = 0; k < around; ++k) {
        const std::uint32_t next = (k + 1) % around, last = around * (circles - 1);
        mesh.faces.push_back({north, k, next});
        mesh.faces.push_back({south, last + next, last + k});
        for (std::uint32_t row = 0; row < last; row += around) {
            mesh.faces.push_back({row + k, row + around + k, row + next});
            mesh.faces.push_back({row + next, row + around + k, row + around + next});
        }
    }
    return mesh;
}

// The base of what a preview stands for may come right behind it: the preview states its own error, not that one's, or
// it would be shown for good.
TEST(Preview, MakesPlaceForFacets) {
    const Mesh input = ball_of_circles(36, 17);
    const Encoded file = encode(input, {}).value();
    const Toc toc = toc_of(file.file);
    ASSERT_GT(file.facets_area_share, 0.99);
    ASSERT_TRUE(toc.header.parts.back().preview);
    EXPECT_GT(file.psnr, 90);
    EXPECT_NEAR(surface_error(input, decode(file.file).value(), {.samples = 100'000}).psnr, file.psnr, 0.5);
    Decoder decoder;
    ASSERT_TRUE(decoder.feed(ByteSpan(file.file).first(toc.chunks[1].offset)).ok());
    const double first = surface_error(input, decoder.mesh().value(), {.samples = 100'000}).rms;
    EXPECT_NEAR(decoder.state().error, first, 0.05 * first);
}

TEST(Closing, AttributesAndChoicesOfOnesOwnKeepWavelets) {
    Mesh colored = rough_torus();
    colored.colors.assign(colored.positions.size(), {10, 20, 30, 255});
    colored.colors[0] = {30, 20, 10, 255};
    EXPECT_EQ(encode(colored, {})->closing_bytes, 0u);
    EncodeOptions levels;
    levels.levels = 2;
    EXPECT_EQ(encode(rough_torus(), levels)->closing_bytes, 0u);
}

}  // namespace
}  // namespace mvw
