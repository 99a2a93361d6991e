#include "tools/bench/decode_speed.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>

#include "codec/decoder.h"
#include "codec/enc_base.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/io/mesh_io.h"

namespace mvw::bench {
namespace {

constexpr unsigned kRuns = 25;
constexpr std::uint32_t kSamples = 100'000;
constexpr int kDracoSpeed = 3;  // 10 less its level
constexpr unsigned kFewestBits = 10, kMostBits = 20;
constexpr double kSame = 0.05;  // dB

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

double psnr_of(const Mesh& input, const Mesh& mesh) {
    return surface_error(input, mesh, {kSamples, 0}).psnr;
}

Mesh placed(const GridMesh& coded, const Box& box, unsigned bits) {
    Mesh mesh;
    mesh.faces = coded.faces;
    const double cell = std::ldexp(box.diagonal(), -static_cast<int>(bits));
    for (const auto& g : coded.grid)
        mesh.positions.push_back(box.center() +
                                 Vec3{static_cast<double>(g[0]), static_cast<double>(g[1]), static_cast<double>(g[2])} *
                                     cell);
    return mesh;
}

std::vector<std::string> row(const std::string& model, const DecodeTime& t, double draco_rate) {
    const double rate = static_cast<double>(t.vertices) / t.seconds;
    return {model,
            t.how,
            std::to_string(t.bytes),
            std::to_string(t.vertices),
            t.psnr > 0 ? fmt::format("{:.2f}", t.psnr) : "",
            fmt::format("{:.2f}", t.seconds * 1000),
            fmt::format("{:.2f}", rate / 1e6),
            fmt::format("{:.2f}", rate / draco_rate)};
}

Result<void> add_profile(const std::string& model, const Mesh& input, EncodeOptions encoding, Table& table) {
    const Result<Encoded> coded = encode(input, encoding);
    if (!coded.ok()) return Error{coded.error().code, 0, model + ": " + coded.error().message};
    const bool fast = encoding.profile == Profile::Fast;
    const std::string how = fast ? "mvw, fast" : "mvw";
    const Bytes& file = coded->file;
    const Mesh mesh = decode(file).value();
    std::vector<Contender> contenders;
    contenders.push_back(own_decoder(input, file, 1, how));
    contenders.push_back(own_decoder(input, file, 2, how + ", 2 threads"));
    contenders.push_back(draco_decoder(input, mesh, contenders[0].time.psnr));
    time_in_turn(contenders);
    const DecodeTime& draco = contenders.back().time;
    const double rate = static_cast<double>(draco.vertices) / draco.seconds;
    for (const std::size_t i : {2u, 0u, 1u}) table.rows.push_back(row(model, contenders[i].time, rate));
    if (!fast) table.rows.push_back(row(model, time_chunk(file), rate));
    return {};
}

Result<void> add_model(const std::string& path, const DecodeSpeedOptions& options, Table& table) {
    CleanReport report;
    Result<Mesh> read = read_mesh(path, report);
    if (!read.ok()) return read.error();
    const Mesh input = clean(std::move(*read), report);
    EncodeOptions encoding;
    encoding.tile_count = options.tile_count;
    for (const Profile profile : {Profile::Small, Profile::Fast}) {
        encoding.profile = profile;
        const std::string model = std::filesystem::path(path).stem().string();
        if (const Result<void> r = add_profile(model, input, encoding, table); !r.ok()) return r;
    }
    return {};
}

}  // namespace

Contender own_decoder(const Mesh& input, ByteSpan file, unsigned threads, const std::string& how) {
    const Mesh mesh = decode(file).value();
    return {{how, file.size(), mesh.positions.size(), psnr_of(input, mesh), 0},
            [file, threads] { (void)decode(file, 255, {}, threads).value(); }};
}

Contender draco_decoder(const Mesh& input, const Mesh& mesh, double psnr) {
    const Box box = bounding_box(mesh);
    Contender out;
    for (unsigned bits = kFewestBits; bits <= kMostBits; ++bits) {
        std::vector<std::array<std::int32_t, 3>> grid;
        for (const Vec3& p : mesh.positions) {
            grid.emplace_back();
            for (std::size_t k = 0; k < 3; ++k)
                grid.back()[k] = static_cast<std::int32_t>(
                    std::lround(std::ldexp((p[k] - box.center()[k]) / box.diagonal(), static_cast<int>(bits))));
        }
        const Bytes bytes = write_draco(mesh.faces, grid, false, kDracoSpeed);
        const auto V = static_cast<std::uint32_t>(grid.size()), F = static_cast<std::uint32_t>(mesh.faces.size());
        const Result<GridMesh> coded = read_draco(bytes, false, V, F);
        if (!coded.ok()) continue;
        out.time = {fmt::format("Draco level 7, {} bits", bits), bytes.size(), coded->grid.size(),
                    psnr_of(input, placed(*coded, box, bits)), 0};
        out.decode = [bytes, V, F, box, bits] { (void)placed(read_draco(bytes, false, V, F).value(), box, bits); };
        if (out.time.psnr >= psnr - kSame) break;
    }
    return out;
}

void time_in_turn(std::span<Contender> contenders) {
    for (Contender& c : contenders) c.time.seconds = std::numeric_limits<double>::infinity();
    for (unsigned run = 0; run < kRuns; ++run)
        for (Contender& c : contenders) {
            const auto start = Clock::now();
            c.decode();
            c.time.seconds = std::min(c.time.seconds, seconds_since(start));
        }
}

DecodeTime time_chunk(ByteSpan file) {
    const FileHeader header = read_header(file).value();
    const Toc toc = read_toc(header, file.subspan(header.index_offset), file.size()).value();
    const unsigned finest = finest_level(header);
    DecodeTime out{"mvw, one more chunk of the finest level", 0, 0, 0, 0};
    Decoder decoder;
    (void)decoder.feed_header(file).ok();
    double seconds = 0, chunks = 0, bytes = 0;
    for (const ChunkEntry& c : toc.chunks) {
        const auto start = Clock::now();
        (void)decoder.feed_chunk(c.id, file.subspan(c.offset, c.length), c.crc32c).ok();
        const Result<Mesh> mesh = decoder.mesh();
        if (!mesh.ok() || c.id.level < finest || c.id.channel != Channel::Geometry) continue;
        seconds += seconds_since(start);
        bytes += static_cast<double>(c.length);
        out.vertices = mesh->positions.size();
        ++chunks;
    }
    out.seconds = seconds / std::max(chunks, 1.0);
    out.bytes = static_cast<std::uint64_t>(bytes / std::max(chunks, 1.0));
    return out;
}

Result<Table> run_decode_speed(const DecodeSpeedOptions& options) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return Error{Errc::Io, 0, options.out + ": " + error.message()};
    Table table{{"model", "what", "bytes", "vertices", "dB", "ms", "million vertices/s", "times Draco"}, {}};
    for (const std::string& path : options.meshes) {
        if (options.say) options.say(path);
        if (const Result<void> r = add_model(path, options, table); !r.ok()) return r.error();
        if (auto written = write_text_file(options.out + "/decode_speed.csv", table.csv()); !written)
            return written.error();
    }
    return table;
}

}  // namespace mvw::bench
