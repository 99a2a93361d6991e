#include "codec/enc_closing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "client/drawable.h"
#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "tests/support/encoded_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

Mesh rough_torus() {
    return mvw::rough_torus(61, 37, 0.02);
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
    EXPECT_EQ(error_of({plain, closing}), "");
    for (const auto& parts : {std::vector{closing}, {closing, plain}, {plain, deep}, {plain, closing, closing}})
        EXPECT_EQ(error_of(parts), "a closing part has levels or is not the last");
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
