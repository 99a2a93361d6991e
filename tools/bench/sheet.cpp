#include "tools/bench/sheet.h"

#include <fmt/core.h>

#include <algorithm>

#include "client/viewer/picture.h"
#include "codec/decoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"

namespace mvw::bench {
namespace {

constexpr unsigned kWidth = 480, kHeight = 400;
constexpr unsigned kDrawnTriangles = 60'000;  // finer wireframes are grey

constexpr unsigned kAll = 255;  // of files without levels: their finest triangles

/// One level, decoded.
struct LevelView {
    Mesh mesh;
    std::string caption;
};

Result<std::vector<LevelView>> decode_levels(const Mesh& input, ByteSpan file) {
    const auto header = read_header(file);
    if (!header) return header.error();
    const unsigned levels = finest_level(*header);
    std::vector<LevelView> views;
    for (unsigned level = 0; level <= levels; ++level) {
        auto mesh = decode(file, levels > 0 ? level : kAll);
        if (!mesh) return mesh.error();
        std::string psnr = "nothing to measure";
        if (measurable(*mesh) && measurable(input)) {
            SurfaceErrorOptions options;
            options.samples = 100'000;
            psnr = fmt::format("{:.1f} dB", surface_error(input, *mesh, options).psnr);
        }
        std::string caption = fmt::format("level {}: {} vertices, {}", level, mesh->positions.size(), psnr);
        views.push_back({std::move(mesh).value(), std::move(caption)});
    }
    return views;
}

/// Draws one row of the sheet: the input, then each level.
Result<void> add_row(std::vector<SheetEntry>& entries, const std::vector<const LevelView*>& views,
                     const PictureOptions& options) {
    for (const LevelView* view : views) {
        PictureOptions own = options;
        own.wireframe = options.wireframe && view->mesh.faces.size() <= kDrawnTriangles;
        own.flat = own.backs_in_place = options.wireframe;  // a row as it is seen, and one as it is
        auto image = draw_picture(view->mesh, own);
        if (!image) return image.error();
        entries.push_back({std::move(image).value(), view->caption});
    }
    return {};
}

Result<void> draw_sheet(const LevelView& input, const std::vector<LevelView>& levels, const std::string& path) {
    PictureOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.camera = fit_camera(input.mesh, options.yaw, options.pitch, static_cast<double>(kWidth) / kHeight);
    std::vector<const LevelView*> views{&input};
    for (const LevelView& level : levels) views.push_back(&level);
    LevelView errors = levels.back();
    errors.mesh.material_colors.clear();  // those of errors are to be seen
    if (measurable(input.mesh))
        errors.mesh.colors = heat_colors(vertex_errors(input.mesh, errors.mesh.positions), 1e-3);
    errors.caption = "finest level, distance to the input:\nblue 0, red 0.1 % of the diagonal and over";

    std::vector<SheetEntry> entries;
    std::vector<const LevelView*> first_row = views;
    first_row.push_back(&errors);
    if (auto row = add_row(entries, first_row, options); !row) return row.error();
    options.wireframe = true;
    if (auto row = add_row(entries, views, options); !row) return row.error();
    return write_png(path, contact_sheet(entries, static_cast<unsigned>(first_row.size())));
}

std::string describe(const Topology& t) {
    return fmt::format("{} components, genus {}, {} loops", t.components, t.genus, t.boundary_loops);
}

}  // namespace

Result<Inspection> inspect(const std::string& input_file, const std::string& mvw_file, const std::string& sheet) {
    CleanReport report;
    auto read = read_mesh(input_file, report);
    if (!read) return read.error();
    const Mesh cleaned = clean(std::move(read).value(), report);
    const LevelView input{cleaned, fmt::format("input: {} vertices", cleaned.positions.size())};
    const auto file = read_file(mvw_file);
    if (!file) return file.error();
    const auto levels = decode_levels(input.mesh, *file);
    if (!levels) return levels.error();

    Inspection result;
    result.topology = topology_of(input.mesh);
    result.input_folds = count_folds(input.mesh);
    result.folds = count_folds(levels->back().mesh);
    for (std::size_t k = 0; k < levels->size(); ++k)
        if (const Topology t = topology_of((*levels)[k].mesh); t != result.topology && result.topology_kept) {
            result.topology_kept = false;
            result.topology_trouble =
                fmt::format("level {} has {} instead of {}", k, describe(t), describe(result.topology));
        }
    if (sheet.empty()) return result;
    const auto backs = count_backs(input.mesh);
    if (!backs) return backs.error();
    result.input_backs = *backs;
    for (const LevelView& level : *levels) {
        const auto count = count_backs(level.mesh);
        if (!count) return count.error();
        result.backs.push_back(*count);
    }
    if (auto drawn = draw_sheet(input, *levels, sheet); !drawn) return drawn.error();
    return result;
}

}  // namespace mvw::bench
