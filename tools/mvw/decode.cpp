// mvw decode: a file, or as much of it as is there or asked for, as a mesh.
#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "codec/dec_original.h"
#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/normals.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

struct DecodeArguments {
    std::string input, output, tiles;
    unsigned level = 255;
    std::uint64_t max_bytes = ~std::uint64_t{0};
    double target_error = 0;
    bool original = false, normals = false, json = false;
};

/// The numbers of "0,4-7"; Fatal where it is no such list.
std::set<std::uint32_t> tile_list(const std::string& text) {
    std::set<std::uint32_t> tiles;
    std::size_t at = 0;
    const auto number = [&] {
        std::uint32_t value = 0;
        const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), value);
        if (error != std::errc{} || value > 0xFFFF) throw Fatal{kUsage, "--tiles: no list of tiles: " + text};
        at = static_cast<std::size_t>(end - text.data());
        return value;
    };
    while (at < text.size()) {
        const std::uint32_t first = number();
        const bool range = at < text.size() && text[at] == '-';
        if (range) ++at;
        const std::uint32_t last = range ? number() : first;
        for (std::uint32_t t = first; t <= last; ++t) tiles.insert(t);
        if (at < text.size() && text[at++] != ',') throw Fatal{kUsage, "--tiles: no list of tiles: " + text};
    }
    return tiles;
}

/// Which chunks of a whole file are asked for: of the tiles wanted, as far as the error wanted asks for them.
std::function<bool(const ChunkEntry&)> wanted_chunks(const DecodeArguments& arguments, const Decoder& decoder) {
    const std::set<std::uint32_t> tiles = tile_list(arguments.tiles);
    return [&arguments, &decoder, tiles](const ChunkEntry& c) {
        if (c.id.channel == Channel::Original || c.offset + c.length > arguments.max_bytes) return false;
        const FileHeader& header = *decoder.header();
        const bool closing = header.parts[c.id.part].supersedes;
        if (closing && (!tiles.empty() || arguments.level <= finest_level(header))) return false;
        if (!closing && (c.id.channel == Channel::Base || c.id.channel == Channel::Attributes)) return true;
        if (arguments.target_error > 0 && decoder.state().error <= arguments.target_error) return false;
        const bool untiled = c.id.channel == Channel::Splits || c.id.level < header.parts[c.id.part].first_tiled_level;
        return tiles.empty() || untiled || tiles.contains(c.id.tile);
    };
}

bool has_details(const Decoder& decoder) {
    return decoder.state().level > 0 || (decoder.header() != nullptr && finest_level(*decoder.header()) == 0);
}

/// A file without its index, in order: until it states the wanted error, else all of it.
void feed_in_order(Decoder& decoder, ByteSpan file, double target_error) {
    constexpr std::size_t kSlice = 64;
    const std::size_t slice = target_error > 0 ? kSlice : file.size();
    for (std::size_t at = 0; at < file.size() && decoder.feed(file.subspan(at, std::min(slice, file.size() - at))).ok();
         at += slice)
        if (target_error > 0 && decoder.state().error <= target_error && has_details(decoder)) return;
    decoder.finish();
}

/// The part of the file that is there and asked for. --max-bytes alone takes a prefix as it is, its cut chunk included.
void feed(Decoder& decoder, const DecodeArguments& arguments, ByteSpan file) {
    const bool prefix = arguments.max_bytes < file.size() && arguments.tiles.empty();
    if (!prefix && decoder.feed_file(file, wanted_chunks(arguments, decoder))) return;
    if (!arguments.tiles.empty())
        throw Fatal{kFailure, arguments.input + ": --tiles needs the index, which is cut off or damaged"};
    feed_in_order(decoder, file.first(std::min<std::uint64_t>(file.size(), arguments.max_bytes)),
                  arguments.target_error);
}

void write(const DecodeArguments& arguments, const Mesh& mesh) {
    warn_of_attributes(arguments.output, mesh);
    if (const Result<void> r = write_mesh(arguments.output, mesh); !r.ok()) throw Fatal{kFailure, r.error().message};
}

/// Where the file has none.
void add_normals(Mesh& mesh) {
    if (std::ranges::find(mesh.fields, FieldKind::Normals, &VertexField::kind) != mesh.fields.end()) return;
    VertexField& field = mesh.fields.emplace_back(VertexField{FieldKind::Normals, "", {}});
    for (const Vec3& n : vertex_normals(mesh.positions, mesh.faces))
        for (std::size_t k = 0; k < 3; ++k) field.values.push_back(n[k]);
}

void decode_original_to(const DecodeArguments& arguments, ByteSpan file) {
    Result<Mesh> mesh = decode_original(file);
    if (!mesh.ok()) throw Fatal{kFailure, arguments.input + ": " + mesh.error().message};
    if (arguments.normals) add_normals(*mesh);
    write(arguments, *mesh);
    if (arguments.json)
        fmt::print("{}\n", nlohmann::ordered_json{{"bytes_used", file.size()},
                                                  {"level", nullptr},
                                                  {"vertices", mesh->positions.size()},
                                                  {"faces", mesh->faces.size()}}
                               .dump());
    else
        fmt::print("{}: the original mesh, {} vertices, {} faces\n", arguments.output, mesh->positions.size(),
                   mesh->faces.size());
}

void decode(const DecodeArguments& arguments) {
    if (!can_write_mesh(arguments.output))
        throw Fatal{kUsage, arguments.output + ": no kind of mesh file that is written (.ply .obj .stl .off .glb)"};
    const Result<Bytes> all = read_file(arguments.input);
    if (!all.ok()) throw Fatal{kFailure, all.error().message};
    if (arguments.original) return decode_original_to(arguments, *all);

    const auto start = std::chrono::steady_clock::now();
    const Result<FileHeader> header = read_header(*all);
    if (!header.ok()) throw Fatal{kFailure, arguments.input + ": " + header.error().message};
    const ByteSpan file = ByteSpan(*all).first(std::min<std::uint64_t>(all->size(), header->file_bytes()));
    Decoder decoder({}, std::max(1u, std::thread::hardware_concurrency()));
    feed(decoder, arguments, file);
    Result<Mesh> mesh = decoder.mesh(arguments.level);
    if (!mesh.ok()) throw Fatal{kFailure, arguments.input + ": " + mesh.error().message};
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    warn_of_file(arguments.input, decoder, all->size());
    if (arguments.normals) add_normals(*mesh);
    write(arguments, *mesh);

    const DecodeState state = decoder.state();
    const unsigned level = std::min(arguments.level, state.level);
    if (arguments.json) {
        const nlohmann::ordered_json json{{"bytes_used", state.bytes},
                                          {"level", level},
                                          {"vertices", mesh->positions.size()},
                                          {"faces", mesh->faces.size()},
                                          {"seconds", seconds.count()}};
        fmt::print("{}\n", json.dump());
    } else {
        fmt::print("{}: level {}, {} vertices, {} faces from {} bytes\n", arguments.output, level,
                   mesh->positions.size(), mesh->faces.size(), state.bytes);
    }
}

}  // namespace

void add_decode(CLI::App& app) {
    auto arguments = std::make_shared<DecodeArguments>();
    CLI::App* command = app.add_subcommand("decode", "Turns a .mvw file, or the beginning of one, into a mesh");
    command->footer("Example: mvw decode bunny.mvw bunny_8kb.ply --max-bytes 8192");
    command->add_option("INPUT.mvw", arguments->input, "File to decode; a cut one gives the best mesh that it holds")
        ->required();
    command->add_option("OUTPUT", arguments->output, "Mesh to write: .ply .obj .stl .off .glb")->required();
    command->add_option("--level", arguments->level, "Level to stop at: 0 is the base mesh")->check(CLI::Range(0, 255));
    command->add_option("--max-bytes", arguments->max_bytes, "Use the first so many bytes of the file alone");
    command->add_option("--target-error", arguments->target_error, "Stop at this RMS error, a fraction of the diagonal")
        ->check(CLI::PositiveNumber);
    command->add_option("--tiles", arguments->tiles,
                        "Only these tiles, as 0,4-7; all others stay coarse, without cracks");
    command->add_flag("--normals", arguments->normals,
                      "Write normals (.ply .obj .glb): those of encode --normals, else computed from the surface");
    command->add_flag("--original", arguments->original,
                      "The input mesh that encode --keep-original put into the file");
    command->add_flag("--json", arguments->json, "One JSON object: bytes_used level vertices faces seconds");
    command->callback([arguments] { decode(*arguments); });
}

}  // namespace mvw::cli
