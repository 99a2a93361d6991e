// mvw decode: a file, or as much of it as is there or asked for, as a mesh.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {
namespace {

struct DecodeArguments {
    std::string input, output;
    unsigned level = 255;
    std::uint64_t max_bytes = ~std::uint64_t{0};
    double target_error = 0;
    bool json = false;
};

/// Feeds chunk after chunk until the file states the wanted error, else all of it.
void feed_until(Decoder& decoder, ByteSpan file, double target_error) {
    constexpr std::size_t kSlice = 64;
    const std::size_t slice = target_error > 0 ? kSlice : file.size();
    for (std::size_t at = 0; at < file.size() && decoder.feed(file.subspan(at, std::min(slice, file.size() - at))).ok();
         at += slice)
        if (target_error > 0 && decoder.state().error <= target_error && decoder.state().level > 0) return;
    decoder.finish();
}

/// Whole files are read through their index, so that damage costs no more than the damaged chunks.
bool feed_by_index(Decoder& decoder, ByteSpan file) {
    const Result<FileHeader> header = read_header(file);
    if (!header.ok() || header->file_bytes() != file.size()) return false;
    const Result<Toc> toc = read_toc(*header, file.subspan(header->index_offset), file.size());
    if (!toc.ok() || !decoder.feed_header(file).ok()) return false;
    for (const ChunkEntry& c : toc->chunks)
        (void)decoder.feed_chunk(c.id, file.subspan(c.offset, c.length), c.crc32c).ok();
    return true;
}

void warn(const DecodeArguments& arguments, const Decoder& decoder, std::uint64_t there) {
    const FileHeader* header = decoder.header();
    if (there < header->file_bytes() && there < arguments.max_bytes)
        fmt::print(stderr, "mvw: {}: cut at byte {} of {}: this is the best mesh that they hold\n", arguments.input,
                   there, header->file_bytes());
    if (const auto damaged = decoder.state().damaged; damaged > 0)
        fmt::print(stderr, "mvw: {}: {} damaged chunks were left out (mvw verify names them)\n", arguments.input,
                   damaged);
}

void decode(const DecodeArguments& arguments) {
    if (!mesh_format_of(arguments.output)) throw Fatal{kUsage, arguments.output + ": unknown kind of mesh file"};
    const Result<Bytes> all = read_file(arguments.input);
    if (!all.ok()) throw Fatal{kFailure, all.error().message};
    const ByteSpan file = ByteSpan(*all).first(std::min<std::uint64_t>(all->size(), arguments.max_bytes));

    const auto start = std::chrono::steady_clock::now();
    if (const Result<FileHeader> header = read_header(file); !header.ok())
        throw Fatal{kFailure, arguments.input + ": " + header.error().message};
    Decoder decoder;
    if (arguments.target_error > 0 || !feed_by_index(decoder, file)) feed_until(decoder, file, arguments.target_error);
    const Result<Mesh> mesh = decoder.mesh(arguments.level);
    if (!mesh.ok()) throw Fatal{kFailure, arguments.input + ": " + mesh.error().message};
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    warn(arguments, decoder, file.size());
    if (const Result<void> r = write_mesh(arguments.output, *mesh); !r.ok()) throw Fatal{kFailure, r.error().message};

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
    command->add_flag("--json", arguments->json, "One JSON object: bytes_used level vertices faces seconds");
    command->callback([arguments] { decode(*arguments); });
}

}  // namespace mvw::cli
