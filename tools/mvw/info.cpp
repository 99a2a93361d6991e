// mvw info: what a .mvw file says of itself, without decoding it.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "codec/container/toc.h"
#include "codec/dec_attribute.h"
#include "codec/dec_base.h"
#include "codec/mesh/io/files.h"
#include "codec/part_params.h"
#include "codec/transform/transform.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {
namespace {

struct InfoArguments {
    std::string input;
    bool chunks = false, json = false;
};

/// A prefix of the file and what it decodes to.
struct RatePoint {
    std::uint64_t bytes = 0;
    unsigned level = 0;
    double error = 1;
};

/// The ends of chunks at which the error has fallen by a quarter of a decibel or more since the point before.
std::vector<RatePoint> points_of(const Toc& toc) {
    std::vector<RatePoint> points;
    unsigned level = 0;
    const std::size_t shown = chunks_until_shown(toc);
    for (std::size_t i = 0; i < toc.chunks.size(); ++i) {
        const ChunkEntry& c = toc.chunks[i];
        level = std::max<unsigned>(level, c.id.level);
        if (i + 1 < shown) continue;
        const bool last = i + 1 == toc.chunks.size();
        if (!points.empty() && c.error > 0.972 * points.back().error && !last) continue;
        points.push_back({c.offset + c.length, level, c.error});
    }
    return points;
}

std::string decibels(double error) {
    return error > 0 ? fmt::format("{:.2f} dB", -20 * std::log10(error)) : "exact";
}

std::string channel_name(Channel channel) {
    constexpr std::array<const char*, 4> kNames{"base", "geometry", "color", "original"};
    const auto number = static_cast<unsigned>(channel);
    if (number < kNames.size()) return kNames[number];
    if (channel == Channel::Attributes) return "attributes";
    if (channel == Channel::Splits) return "splits";
    if (channel > Channel::Splits) return "unknown";
    return "field" + std::to_string(number - static_cast<unsigned>(Channel::FirstField));
}

/// The chunks of a file without its index that are there whole, with the errors that they state themselves.
Toc toc_of_heads(const FileHeader& header, ByteSpan file) {
    Toc toc{header, {}};
    ChunkId previous;
    std::uint64_t at = header.header_bytes;
    while (at < header.index_offset && at < file.size()) {
        ByteReader in(file.subspan(at));
        const Result<ChunkHead> head = read_chunk_head(in, previous);
        if (!head.ok() || head->length > in.remaining() || !check_chunk_id(header, head->id).ok()) break;
        ByteReader payload(in.bytes(head->length));
        if (head->id.channel == Channel::Base) payload.u8();
        const float error = head->id.channel == Channel::Original && !toc.chunks.empty()
                                ? toc.chunks.back().error
                                : error_from_code(payload.u8());
        toc.chunks.push_back({head->id, at + in.offset() - head->length, head->length, 0, error});
        previous = head->id;
        at += in.offset();
    }
    return toc;
}

Bytes load_file(const std::string& path) {
    Result<Bytes> file = read_file(path);
    if (!file.ok()) throw Fatal{kFailure, file.error().message};
    return std::move(file).value();
}

/// The file's table; that of its beginning where its index is cut off or damaged, which is said.
Toc load_toc(const std::string& path, const Bytes& file) {
    const Result<FileHeader> header = read_header(file);
    if (!header.ok()) throw Fatal{kFailure, path + ": " + header.error().message};
    const std::uint64_t there = file.size(), whole = header->file_bytes();
    Result<Toc> toc = there < whole
                          ? Result<Toc>(Error{Errc::NeedMoreData, there, "cut"})
                          : read_toc(*header, ByteSpan(file).subspan(header->index_offset, header->index_bytes), whole);
    if (toc.ok()) return std::move(toc).value();
    if (there < whole)
        fmt::print(stderr, "mvw: {}: cut at byte {} of {}: these are the chunks before\n", path, there, whole);
    else
        fmt::print(stderr, "mvw: {}: {}: read from the chunks themselves\n", path, toc.error().message);
    return toc_of_heads(*header, file);
}

/// An attribute by its name, and what its chunks take.
struct AttributeSummary {
    AttributeParams params;
    std::uint64_t bytes = 0;
};

struct Summary {
    unsigned levels = 0, tiles = 0;
    std::uint64_t base_bytes = 0, closing_bytes = 0;
    std::vector<AttributeSummary> attributes;
    std::set<std::uint32_t> colored;  // materials
};

AttributeSummary& entry_of(const AttributeParams& params, std::vector<AttributeSummary>& list) {
    for (AttributeSummary& entry : list)
        if (attribute_name(entry.params) == attribute_name(params)) return entry;
    return list.emplace_back(AttributeSummary{params, 0});
}

Summary summary_of(const Toc& toc, ByteSpan file) {
    Summary s;
    s.levels = finest_level(toc.header);
    for (std::size_t p = 0; p < toc.header.main_parts(); ++p) s.tiles += toc.header.parts[p].tiles;
    std::vector<std::vector<AttributeParams>> of_part(toc.header.parts.size());
    for (const ChunkEntry& c : toc.chunks) {
        const bool closing = toc.header.parts[c.id.part].supersedes;
        if (closing) s.closing_bytes += c.length;
        if (leads_to_base(c.id.channel) && !closing) s.base_bytes += c.length;
        if (c.id.channel == Channel::Base) {
            const auto base =
                read_base(file.subspan(c.offset, c.length), toc.header.parts[c.id.part], toc.header.transform);
            if (base.ok())
                for (const MaterialColor& color : base->params.colors) s.colored.insert(color.label);
        }
        if (c.id.channel == Channel::Attributes) {
            auto attributes = read_attributes(file.subspan(c.offset, c.length), toc.header.parts[c.id.part]);
            if (attributes.ok()) of_part[c.id.part] = std::move(*attributes);
        }
        for (const AttributeParams& a : of_part[c.id.part])
            entry_of(a, s.attributes).bytes += a.channel == c.id.channel ? c.length : 0;
    }
    return s;
}

std::string transform_of(const FileHeader& header) {
    if (header.transform >= kTransformCount) return "unknown";
    return std::string(transform_name(TransformKind{header.transform}));
}

void print_json(const Toc& toc, const Summary& s, bool chunks) {
    std::vector<std::string> attributes;
    for (const AttributeSummary& a : s.attributes) attributes.push_back(attribute_name(a.params));
    nlohmann::ordered_json json{{"version", toc.header.version},
                                {"transform", transform_of(toc.header)},
                                {"levels", s.levels},
                                {"tiles", s.tiles},
                                {"layers", toc.header.layers},
                                {"bytes", toc.header.file_bytes()},
                                {"base_bytes", s.base_bytes},
                                {"closing_bytes", s.closing_bytes},
                                {"attributes", attributes},
                                {"material_colors", s.colored.size()},
                                {"points", nlohmann::json::array()}};
    for (const RatePoint& p : points_of(toc))
        json["points"].push_back(nlohmann::ordered_json{{"bytes", p.bytes}, {"level", p.level}, {"error", p.error}});
    if (chunks)
        for (const ChunkEntry& c : toc.chunks)
            json["chunks"].push_back(nlohmann::ordered_json{{"part", c.id.part},
                                                            {"tile", c.id.tile},
                                                            {"level", c.id.level},
                                                            {"layer", c.id.layer},
                                                            {"channel", channel_name(c.id.channel)},
                                                            {"offset", c.offset},
                                                            {"length", c.length},
                                                            {"error", c.error}});
    fmt::print("{}\n", json.dump());
}

void print_attribute(const AttributeSummary& a) {
    fmt::print("attribute {}, {} bytes", attribute_name(a.params), a.bytes);
    if (a.params.kind == AttributeKind::Scalar)
        fmt::print(", from {:.6g} to {:.6g}", a.params.middle - a.params.range / 2,
                   a.params.middle + a.params.range / 2);
    fmt::print("\n");
}

void print_part(const Toc& toc, std::size_t index) {
    const PartInfo& part = toc.header.parts[index];
    std::uint64_t bytes = 0;
    for (const ChunkEntry& c : toc.chunks)
        if (c.id.part == index) bytes += c.length;
    if (part.progressive && !part.preview)
        fmt::print("plain triangles that become more: in the end {} vertices, {} faces\n", part.base_vertices,
                   part.base_faces);
    else if (part.preview)
        fmt::print("shown before that: all of it as plain triangles, {} bytes: {} vertices, {} faces\n", bytes,
                   part.base_vertices, part.base_faces);
    else if (part.supersedes)
        fmt::print("then all of it as plain triangles, {} bytes: {} vertices, {} faces\n", bytes, part.base_vertices,
                   part.base_faces);
    else
        fmt::print("part of {} levels over {} vertices, {} faces\n", part.levels, part.base_vertices, part.base_faces);
}

void print_text(const Toc& toc, const Summary& s, bool chunks) {
    fmt::print("version {}, {} bytes, of these {} for base meshes\n", toc.header.version, toc.header.file_bytes(),
               s.base_bytes);
    fmt::print("transform {}, {} levels, {} tiles, {} layers, {} chunks\n", transform_of(toc.header), s.levels, s.tiles,
               toc.header.layers, toc.chunks.size());
    for (std::size_t p = 0; p < toc.header.parts.size(); ++p) print_part(toc, p);
    for (const AttributeSummary& a : s.attributes) print_attribute(a);
    if (!s.colored.empty()) fmt::print("colours of {} materials\n", s.colored.size());
    fmt::print("\n{:>10}  level  error\n", "bytes");
    for (const RatePoint& p : points_of(toc)) fmt::print("{:>10}  {:>5}  {}\n", p.bytes, p.level, decibels(p.error));
    if (!chunks) return;
    fmt::print("\n{:>10}  {:>8}  part  tile  level  layer  channel   error after\n", "offset", "length");
    for (const ChunkEntry& c : toc.chunks)
        fmt::print("{:>10}  {:>8}  {:>4}  {:>4}  {:>5}  {:>5}  {:<8}  {}\n", c.offset, c.length, c.id.part, c.id.tile,
                   c.id.level, c.id.layer, channel_name(c.id.channel), decibels(c.error));
}

void info(const InfoArguments& arguments) {
    const Bytes file = load_file(arguments.input);
    const Toc toc = load_toc(arguments.input, file);
    const Summary summary = summary_of(toc, file);
    arguments.json ? print_json(toc, summary, arguments.chunks) : print_text(toc, summary, arguments.chunks);
}

}  // namespace

void add_info(CLI::App& app) {
    auto arguments = std::make_shared<InfoArguments>();
    CLI::App* command =
        app.add_subcommand("info", "Says what is in a .mvw file, and the error that each size decodes to");
    command->footer("Example: mvw info bunny.mvw --chunks");
    command->add_option("INPUT.mvw", arguments->input, "File to look at")->required();
    command->add_flag("--chunks", arguments->chunks, "List every chunk");
    command->add_flag("--json", arguments->json,
                      "One JSON object: version transform levels tiles layers bytes base_bytes closing_bytes "
                      "attributes material_colors points");
    command->callback([arguments] { info(*arguments); });
}

}  // namespace mvw::cli
