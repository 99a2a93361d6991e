#include "codec/enc_progressive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/entropy/dec_splits.h"
#include "codec/measure/surface_error.h"
#include "codec/part_params.h"
#include "tests/support/encoded_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A mesh as a progressive file of it.
struct Grown {
    Mesh input;
    FileHeader header;
    std::vector<PlannedChunk> plan;
    Bytes file;
};

Grown grown(Mesh mesh, double base_bytes = 150) {
    Grown out;
    out.input = mesh;
    const std::unique_ptr<EncoderInput> input = EncoderInput::make(mesh, 1).value();
    const Lod own = own_version(*input).value();
    Progressive coded = code_progressive(*input, own, {base_bytes, 1e-5, false, 1}).value();
    out.header = input->header();
    out.header.parts = {coded.whole.info};
    out.header.layers = static_cast<std::uint8_t>(coded.whole.layers);
    out.plan = coded.whole.chunks;
    out.file = write_file(out.header, to_write(out.plan)).value();
    return out;
}

double psnr_of(const Mesh& input, const Result<Mesh>& mesh) {
    return mesh.ok() ? surface_error(input, *mesh, {50'000}).psnr : 0;
}

std::vector<Mesh> shapes() {
    Mesh striped = chequered_plate(6);
    for (std::size_t f = 0; f < striped.faces.size(); ++f)
        striped.materials.push_back(striped.positions[striped.faces[f][0]].x > 0.5 ? 4 : 9);
    Mesh open = chequered_plate(5);
    std::erase_if(open.faces, [&](const Face& f) { return open.positions[f[0]].x > 0.7; });
    CleanReport report;
    return {chequered_plate(8), striped, clean(open, report), rough_torus(31, 17, 0.03), icosphere(3)};
}

TEST(Progressive, EndsWithTheInputsOwnTrianglesFromFewToMany) {
    for (const Mesh& mesh : shapes()) {
        const Grown g = grown(mesh);
        const Mesh back = decode(g.file).value();
        EXPECT_EQ(back.positions.size(), mesh.positions.size());
        EXPECT_EQ(back.faces.size(), mesh.faces.size());
        EXPECT_GT(psnr_of(mesh, back), 92);
        if (!mesh.materials.empty()) {
            std::vector<std::uint32_t> before = mesh.materials, after = back.materials;
            std::sort(before.begin(), before.end());
            std::sort(after.begin(), after.end());
            EXPECT_EQ(before, after);
        }
        std::size_t faces = 0;
        double last = 0;
        Decoder decoder;
        ASSERT_TRUE(decoder.feed_header(g.file).ok());
        for (const PlannedChunk& c : g.plan) {
            ASSERT_TRUE(decoder.feed_chunk(c.id, c.payload, crc32c(c.payload)).ok());
            const Mesh now = decoder.mesh().value();
            EXPECT_GE(now.faces.size(), faces);
            EXPECT_EQ(now.faces.size() > faces, leads_to_base(c.id.channel));
            faces = now.faces.size();
            const double psnr = psnr_of(mesh, now);
            EXPECT_GT(psnr, last - 0.5);
            if (leads_to_base(c.id.channel)) {
                EXPECT_NEAR(psnr, -20 * std::log10(c.error), 0.7);
            }
            last = std::max(last, psnr);
        }
        EXPECT_TRUE(decoder.state().waiting == 0);
    }
}

TEST(Progressive, CutAnywhereItIsAMeshBetweenThoseOfItsChunks) {
    const Grown g = grown(chequered_plate(8));
    std::size_t faces = 0;
    std::size_t different = 0;
    for (std::size_t bytes = g.header.header_bytes; bytes <= g.file.size(); bytes += 7) {
        const Result<Mesh> mesh = decode(ByteSpan(g.file).first(bytes));
        if (!mesh.ok()) continue;
        ASSERT_TRUE(BaseMesh::create(static_cast<std::uint32_t>(mesh->positions.size()), mesh->faces).ok());
        EXPECT_GE(mesh->faces.size(), faces);
        different += mesh->faces.size() > faces;
        faces = mesh->faces.size();
    }
    EXPECT_GT(different, 20u) << "places at which there is more to see";
}

/// Splits that begin with a finer lattice: their number in the plan; none: 0.
std::size_t first_finer(const Grown& g) {
    Lattice lattice;
    for (std::size_t k = 0; k < g.plan.size(); ++k) {
        ByteReader in(g.plan[k].payload);
        if (g.plan[k].id.channel == Channel::Base) {
            (void)in.bytes(2);
            lattice = read_lattice(in);
        } else if (g.plan[k].id.channel == Channel::Splits) {
            const SplitsFront front = read_splits_front(in, lattice);
            if (!(front.rounds.front() == lattice)) return k;
            lattice = front.rounds.back();
        }
    }
    return 0;
}

TEST(Progressive, VerticesStayUntilTheirPlaceOnAFinerLatticeIsThere) {
    std::size_t looked_at = 0;
    for (const Mesh& mesh : {rough_torus(31, 17, 0.03), rough_torus(41, 23, 0.01), icosphere(4)}) {
        const Grown g = grown(mesh);
        const std::size_t finer = first_finer(g);
        if (finer == 0) continue;
        std::vector<ChunkEntry> chunks = toc_of(g.file).chunks;
        const auto begin = static_cast<std::size_t>(chunks[finer].offset);
        const Mesh before = decode(ByteSpan(g.file).first(begin)).value();
        std::size_t last = 0;
        for (std::size_t bytes = begin + 12; bytes < begin + 28; bytes += 4) {
            const Mesh cut = decode(ByteSpan(g.file).first(bytes)).value();
            ASSERT_EQ(cut.positions.size(), before.positions.size());
            std::size_t moved = 0;
            for (std::size_t v = 0; v < cut.positions.size(); ++v) moved += !(cut.positions[v] == before.positions[v]);
            EXPECT_GE(moved, last);
            EXPECT_LT(moved, cut.positions.size()) << bytes - begin << " bytes";
            last = moved;
        }
        EXPECT_GT(last, 0u);
        ++looked_at;
    }
    EXPECT_GT(looked_at, 0u);
}

TEST(Progressive, LatticesOutOfRangeAreRefused) {
    const Grown g = grown(chequered_plate(8));
    const auto complete = [&](std::size_t chunk, std::size_t at, std::uint8_t byte) {
        Decoder decoder;
        EXPECT_TRUE(decoder.feed_header(g.file).ok());
        for (std::size_t k = 0; k < g.plan.size(); ++k) {
            Bytes payload = g.plan[k].payload;
            if (k == chunk) payload[at] = static_cast<std::byte>(byte);
            (void)decoder.feed_chunk(g.plan[k].id, payload, crc32c(payload)).ok();
        }
        const Result<Mesh> mesh = decoder.mesh();
        return mesh.ok() && mesh->faces.size() == g.input.faces.size();
    };
    ASSERT_EQ(g.plan[1].id.channel, Channel::Splits);
    EXPECT_TRUE(complete(g.plan.size(), 0, 0));
    for (const std::uint8_t flags : {0, 64, 128, 192})
        for (const std::uint8_t bits : {0, 17, 31, 63}) EXPECT_FALSE(complete(0, 2, flags | bits)) << flags + bits;
    for (const std::uint8_t bits : {17, 64, 64 + 17, 63, 128, 192}) EXPECT_FALSE(complete(1, 2, bits)) << int{bits};
}

TEST(Progressive, MoreBytesDoNotMakeItWorse) {
    const Mesh mesh = rough_torus(31, 17, 0.03);
    const Grown g = grown(mesh);
    std::size_t end = g.header.header_bytes;
    for (const PlannedChunk& c : g.plan)
        if (leads_to_base(c.id.channel)) end += c.payload.size();
    double best = 0;
    for (std::size_t bytes = g.header.header_bytes; bytes <= end; bytes += 5) {
        const double psnr = psnr_of(mesh, decode(ByteSpan(g.file).first(bytes)));
        EXPECT_GT(psnr, best - 0.7) << bytes;
        best = std::max(best, psnr);
    }
}

TEST(Progressive, ChunksWaitForThoseBefore) {
    const Grown g = grown(chequered_plate(8));
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_header(g.file).ok());
    for (std::size_t k = g.plan.size(); k-- > 1;)
        ASSERT_TRUE(decoder.feed_chunk(g.plan[k].id, g.plan[k].payload, crc32c(g.plan[k].payload)).ok());
    EXPECT_FALSE(decoder.mesh().ok());
    EXPECT_EQ(decoder.state().waiting, g.plan.size() - 1);
    ASSERT_TRUE(decoder.feed_chunk(g.plan[0].id, g.plan[0].payload, crc32c(g.plan[0].payload)).ok());
    EXPECT_EQ(decoder.state().waiting, 0u);
    const Mesh whole = decode(g.file).value();
    EXPECT_EQ(decoder.mesh()->faces, whole.faces);
    EXPECT_EQ(decoder.mesh()->positions, whole.positions);
}

TEST(Progressive, DamagedSplitsAreRefusedAndLeaveWhatThereIs) {
    const Grown g = grown(chequered_plate(8));
    std::mt19937 random(2);
    const auto splits = std::ranges::find(g.plan, Channel::Splits, [](const PlannedChunk& c) { return c.id.channel; });
    ASSERT_NE(splits, g.plan.end());
    unsigned refused = 0;
    for (int k = 0; k < 300; ++k) {
        Decoder decoder;
        ASSERT_TRUE(decoder.feed_header(g.file).ok());
        ASSERT_TRUE(decoder.feed_chunk(g.plan[0].id, g.plan[0].payload, crc32c(g.plan[0].payload)).ok());
        const std::size_t before = decoder.mesh()->faces.size();
        Bytes payload = splits->payload;
        for (int n = 0; n < 3; ++n) payload[random() % payload.size()] = static_cast<std::byte>(random());
        (void)decoder.feed_chunk(splits->id, payload, crc32c(payload)).ok();
        refused += decoder.state().damaged;
        const Mesh mesh = decoder.mesh().value();
        EXPECT_GE(mesh.faces.size(), before);
        EXPECT_TRUE(BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces).ok());
    }
    EXPECT_GT(refused, 10u);
}

TEST(Progressive, ABaseFromWhichSplitsCannotLeadToTheHeadersCountsIsRefused) {
    const Grown g = grown(chequered_plate(8));
    for (const auto& [vertices, faces] : {std::pair{1, 0}, {0, 1}, {100'000, 0}}) {
        Decoder decoder;
        FileHeader header = g.header;
        header.parts[0].base_vertices += static_cast<std::uint32_t>(vertices);
        header.parts[0].base_faces += static_cast<std::uint32_t>(faces);
        header.parts[0].base_edges += static_cast<std::uint32_t>(vertices + faces);
        const Result<Bytes> file = write_file(header, to_write(g.plan));
        if (!file.ok() || !decoder.feed(*file).ok()) continue;  // not a header
        const DecodeState state = decoder.state();
        EXPECT_FALSE(state.complete) << vertices << ' ' << faces;
    }
}

TEST(Progressive, APreviewMayBeOne) {
    const Mesh plate = chequered_plate(8);
    EncodeOptions options;
    options.close = false;
    const Encoded wavelets = encode(plate, options).value();
    const std::unique_ptr<EncoderInput> input = EncoderInput::make(plate, 1).value();
    const Progressive coded = code_progressive(*input, own_version(*input).value(), {150, 1e-5, false, 1}).value();
    ASSERT_GT(coded.grown.size(), 2u);
    const Stage stage = coded.beginning(2);
    EXPECT_EQ(stage.chunks.size(), 3u);
    FileHeader header = toc_of(wavelets.file).header;
    const auto part = static_cast<std::uint16_t>(header.parts.size());
    header.parts.push_back(stage.info);
    header.parts.back().preview = true;
    std::vector<PlannedChunk> chunks = stage.chunks;
    for (PlannedChunk& c : chunks) {
        c.id.part = part;
        c.payload[c.id.channel == Channel::Base ? 1 : 0] = std::byte{error_to_code(c.error)};
    }
    std::vector<ChunkToWrite> all = to_write(chunks);
    for (const ChunkEntry& c : toc_of(wavelets.file).chunks)
        all.push_back({c.id, ByteSpan(wavelets.file).subspan(c.offset, c.length), c.error});
    const Bytes file = write_file(header, all).value();
    Decoder decoder;
    std::size_t k = 0;
    for (const ChunkEntry& c : toc_of(file).chunks) {
        Decoder beginning;
        ASSERT_TRUE(beginning.feed(ByteSpan(file).first(c.offset + c.length)).ok());
        if (k < 3) {
            EXPECT_EQ(beginning.mesh()->faces.size(), coded.grown[k].base_faces);
        }
        ++k;
    }
    EXPECT_EQ(decode(file)->positions.size(), decode(wavelets.file)->positions.size());
}

}  // namespace
}  // namespace mvw
