// mvw encode: any mesh into a .mvw file.
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "codec/encoder.h"
#include "codec/mesh/io/files.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

struct EncodeArguments {
    std::string input, output, texture, transform, weights = "exact";  // transform empty: chosen
    std::string profile = "small";
    EncodeOptions options;
    bool json = false;
};

/// The kernel's high-water mark of this program's own memory (getrusage would count the parent's, too); 0 where there
/// is no such file.
double peak_megabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024.0;
    return 0;
}

/// A line on the terminal that is written over as work goes on; nothing where standard error is no terminal.
Progress progress_line() {
    if (isatty(STDERR_FILENO) == 0) return {};
    return [](const char* phase, double done) {
        constexpr int kWidth = 30;
        const int filled = static_cast<int>(done * kWidth);
        fmt::print(stderr, "\r{:<12} [{:<30}] {:3.0f} %", phase, std::string(static_cast<std::size_t>(filled), '='),
                   done * 100);
        std::fflush(stderr);
    };
}

void end_progress() {
    if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r{:60}\r", "");
}

/// Every repair by the name it has in JSON and in words.
struct CleaningLine {
    std::uint64_t count;
    const char *key, *words;
};
std::array<CleaningLine, 10> cleaning_lines(const CleanReport& r) {
    return {{{r.triangulated_polygons, "triangulated_polygons", "polygons cut into triangles"},
             {r.replaced_values, "replaced_values", "values of fields that were no numbers, now the field's mean"},
             {r.welded_vertices, "welded_vertices", "vertices joined with others at the same place"},
             {r.unused_vertices, "unused_vertices", "vertices that no face uses dropped"},
             {r.degenerate_faces, "degenerate_faces", "degenerate faces dropped"},
             {r.duplicate_faces, "duplicate_faces", "duplicate faces dropped"},
             {r.split_edges, "split_edges", "non-manifold edges taken apart"},
             {r.split_vertices, "split_vertices", "vertices split"},
             {r.turned_faces, "turned_faces", "faces turned"},
             {r.cut_edges, "cut_edges", "edges cut open"}}};
}

nlohmann::ordered_json cleaning_json(const CleanReport& report) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const CleaningLine& line : cleaning_lines(report)) json[line.key] = line.count;
    return json;
}

void print_cleaning(const CleanReport& report) {
    for (const CleaningLine& line : cleaning_lines(report))
        if (line.count > 0) fmt::print("  {} {}\n", line.count, line.words);
}

nlohmann::ordered_json attributes_json(const Encoded& e) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const AttributeBytes& a : e.attributes) json.push_back({{"name", a.name}, {"bytes", a.bytes}});
    return json;
}

void print_attributes(const Encoded& e) {
    for (const AttributeBytes& a : e.attributes) fmt::print("  {} bytes for attribute {}\n", a.bytes, a.name);
    for (const std::string& name : e.left_out) fmt::print("  {} left out: a file holds {} fields\n", name, kMaxFields);
    for (const std::string& name : e.cleaning.dropped_fields) fmt::print("  {} of the input is not kept\n", name);
    if (e.cleaning.textured_vertices > 0)
        fmt::print("  colours of {} vertices from images, which are not kept themselves\n", e.painted_vertices);
    if (e.material_colors > 0)
        fmt::print("  {}\n", e.material_colors == 1 ? "the colour of one material"
                                                    : fmt::format("colours of {} materials", e.material_colors));
    if (e.color_levels > 0) fmt::print("  {} of the levels for colours alone\n", e.color_levels);
    for (const std::string& image : e.cleaning.missing_textures) fmt::print("  not read: {}\n", image);
}

void print_json(const Encoded& e, double seconds) {
    std::vector<std::string> left_out = e.left_out;
    left_out.insert(left_out.end(), e.cleaning.dropped_fields.begin(), e.cleaning.dropped_fields.end());
    const nlohmann::ordered_json json{{"input_vertices", e.input_vertices},
                                      {"input_faces", e.input_faces},
                                      {"parts", e.parts},
                                      {"draco_area_share", e.draco_area_share},
                                      {"facets_area_share", e.facets_area_share},
                                      {"base_faces", e.base_faces},
                                      {"levels", e.levels},
                                      {"color_levels", e.color_levels},
                                      {"vertices", e.vertices},
                                      {"bytes", e.file.size()},
                                      {"base_bytes", e.base_bytes},
                                      {"color_bytes", e.color_bytes},
                                      {"painted_vertices", e.painted_vertices},
                                      {"material_colors", e.material_colors},
                                      {"attributes", attributes_json(e)},
                                      {"left_out", left_out},
                                      {"textured_vertices", e.cleaning.textured_vertices},
                                      {"missing_textures", e.cleaning.missing_textures},
                                      {"closing_bytes", e.closing_bytes},
                                      {"original_bytes", e.original_bytes},
                                      {"rms", e.rms},
                                      {"max", e.max},
                                      {"psnr", e.psnr},
                                      {"tangential_share", e.tangential_share},
                                      {"cleaning", cleaning_json(e.cleaning)},
                                      {"seconds", seconds},
                                      {"peak_mb", peak_megabytes()},
                                      {"transform", transform_name(e.transform)}};
    fmt::print("{}\n", json.dump());
}

void print_text(const std::string& output, const Encoded& e, double seconds) {
    fmt::print("{}: {} bytes ({} of them for base meshes) for {} vertices, {} faces\n", output, e.file.size(),
               e.base_bytes, e.input_vertices, e.input_faces);
    print_cleaning(e.cleaning);
    fmt::print("  {} parts, {} base faces, {} levels, {} vertices at the finest\n", e.parts, e.base_faces, e.levels,
               e.vertices);
    fmt::print("  rms error {:.2e} of the diagonal ({:.2f} dB), largest {:.2e}\n", e.rms, e.psnr, e.max);
    print_attributes(e);
    if (e.closing_bytes > 0 && e.levels > 0) fmt::print("  {} bytes for plain triangles at the end\n", e.closing_bytes);
    if (e.closing_bytes > 0 && e.levels == 0)
        fmt::print("  plain triangles in finer and finer versions, which serve this model better than wavelets\n");
    if (e.original_bytes > 0) fmt::print("  {} bytes for the original mesh\n", e.original_bytes);
    if (e.draco_area_share > 0)
        fmt::print("  {:.1f} % of the surface coded by Draco alone\n", 100 * e.draco_area_share);
    if (e.facets_area_share > 0)
        fmt::print("  {:.1f} % of the surface has its own faces for a base\n", 100 * e.facets_area_share);
    fmt::print("  {:.1f} seconds, {:.0f} MB\n", seconds, peak_megabytes());
}

void encode_file(EncodeArguments& arguments) {
    const auto start = std::chrono::steady_clock::now();
    EncodeOptions& options = arguments.options;
    options.choose_transform = arguments.transform.empty();
    if (!arguments.transform.empty()) options.transform.kind = transform_from_name(arguments.transform).value();
    options.profile = arguments.profile == "fast" ? Profile::Fast : Profile::Small;
    options.transform.table1_weights = arguments.weights == "table1";
    options.progress = progress_line();
    CleanReport importing;
    Mesh mesh = load_mesh(arguments.input, importing, arguments.texture);
    if (!arguments.texture.empty() && importing.textured_vertices == 0)
        throw Fatal{kFailure, arguments.texture +
                                  ": colours nothing: it is no PNG, JPEG or WebP, or the mesh is no OBJ with " +
                                  "texture coordinates"};
    const Result<Encoded> encoded = encode(std::move(mesh), options);
    end_progress();
    if (!encoded.ok()) throw Fatal{kFailure, arguments.input + ": " + encoded.error().message};
    if (const Result<void> r = write_file(arguments.output, encoded->file); !r.ok())
        throw Fatal{kFailure, r.error().message};
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    Encoded report = *encoded;
    report.cleaning.triangulated_polygons += importing.triangulated_polygons;
    report.cleaning.replaced_values += importing.replaced_values;
    report.cleaning.dropped_fields = importing.dropped_fields;
    report.cleaning.textured_vertices = importing.textured_vertices;
    report.cleaning.missing_textures = importing.missing_textures;
    arguments.json ? print_json(report, seconds.count()) : print_text(arguments.output, report, seconds.count());
}

}  // namespace

void add_encode(CLI::App& app) {
    auto arguments = std::make_shared<EncodeArguments>();
    EncodeOptions& options = arguments->options;
    CLI::App* command = app.add_subcommand("encode", "Turns a triangle mesh into a .mvw file");
    command->footer("Example: mvw encode bunny.ply bunny.mvw");
    command->add_option("INPUT", arguments->input, "Mesh: .ply .obj .stl .3mf .off .gltf .glb")->required();
    command->add_option("OUTPUT.mvw", arguments->output, "File to write")->required();
    command
        ->add_option("--transform", arguments->transform,
                     "Wavelet transform (default: seeded-normal; of models with sharp edges seeded-normal-lazy unless "
                     "it measures worse)")
        ->check(CLI::IsMember(transform_names()));
    command->add_option("--levels", options.levels, "Levels above the base (default: chosen from the model)")
        ->check(CLI::Range(0, 12));
    command->add_option("--base-faces", options.base_faces, "Faces of the base mesh (default: chosen from the model)");
    command->add_option("--target-error", options.target_error, "RMS error to reach, a fraction of the diagonal")
        ->check(CLI::PositiveNumber);
    command
        ->add_option("--profile", arguments->profile, "small, or fast: planes packed by zstd, larger, decodes faster")
        ->check(CLI::IsMember({"small", "fast"}))
        ->capture_default_str();
    command->add_option("--tile-count", options.tile_count, "Tiles of each part (default: chosen from the model)")
        ->check(CLI::Range(1, 65535));
    command->add_flag("!--no-color-levels", options.color_levels,
                      "No finer levels than the shape needs (default: more where images show more than vertices hold)");
    command->add_flag(
        "!--no-closing", options.close,
        "Wavelets alone (default: a file ends with plain triangles, as the input has them or fewer, where "
        "that is better for few bytes more, or wavelets stay visibly off; models of flat parts and sharp "
        "edges may do without wavelets)");
    command
        ->add_option("--keep-original", options.keep_original,
                     "Also keep the input mesh (cleaned; without attributes) with so many bits a coordinate; see "
                     "decode --original")
        ->check(CLI::Range(1, 30));
    command
        ->add_option("--lossless", options.lossless,
                     "Keep every vertex exactly on a grid of so many bits a coordinate; for semi-regular meshes only "
                     "(others: --keep-original)")
        ->check(CLI::Range(1, 24))
        ->excludes("--transform")
        ->excludes("--levels")
        ->excludes("--base-faces")
        ->excludes("--target-error");
    command->add_option("--s", options.transform.s, "Shape of the rule at extraordinary vertices, in (0, 36/31]")
        ->check(CLI::Range(1e-6, 36.0 / 31.0));
    command->add_option("--weights", arguments->weights, "Lifting weights: computed (exact), or the paper's (table1)")
        ->check(CLI::IsMember({"exact", "table1"}));
    command->add_option("--template", options.transform.loop_template, "Lifting template of loop: 4 or 10")
        ->check(CLI::IsMember({4, 10}));
    command->add_option(
        "--texture", arguments->texture,
        "PNG, JPEG or WebP that colours the vertices of an .obj with texture coordinates that names no image");
    command->add_flag("--normals", options.normals,
                      "Code the input's normals, too (default: whoever draws the surface computes them)");
    command->add_flag("!--no-scalars", options.scalars,
                      "Leave out scalar fields of vertices (PLY properties, glTF's _NAME); by default eight are kept");
    command
        ->add_option("--field-error", options.field_error, "RMS error of scalar fields, a fraction of a field's range")
        ->check(CLI::Range(1e-5, 1.0))
        ->capture_default_str();
    command->add_option("--threads", options.threads, "Threads (default: all cores)")->check(CLI::Range(1, 256));
    command->add_flag("--json", arguments->json, "One JSON object of all figures");
    command->callback([arguments] { encode_file(*arguments); });
}

}  // namespace mvw::cli
