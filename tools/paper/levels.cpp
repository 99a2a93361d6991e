#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "client/viewer/picture.h"
#include "codec/transform/transform.h"
#include "tools/paper/sections.h"

namespace mvw::paper {
namespace {

constexpr unsigned kSide = 300;

/// Details above `level` left out; positions of the finest level.
std::vector<Vec3f> without_details_above(const Model& model, TransformKind kind, unsigned level) {
    const std::vector<Vec3f> positions = model.positions();
    std::vector<Vec3f> coefficients(positions.size()), out(positions.size());
    PatchTransform transform(model.mesh.base, model.mesh.levels, {.kind = kind, .local_frames = false},
                             model.mesh.creases);
    transform.analyze(positions, coefficients);
    std::fill(coefficients.begin() + static_cast<std::ptrdiff_t>(vertices_at_level(model.mesh.base, level)),
              coefficients.end(), Vec3f{});
    transform.synthesize(coefficients, model.mesh.levels, out);
    return out;
}

PictureOptions options_for(const Model& model) {
    PictureOptions options;
    options.width = options.height = kSide;
    options.camera =
        fit_camera(model.surface(std::min(model.mesh.levels, 4u), model.positions()), options.yaw, options.pitch, 1);
    return options;
}

Result<void> add_picture(std::vector<SheetEntry>& entries, const Mesh& mesh, const PictureOptions& options,
                         const std::string& caption) {
    Result<Image> image = draw_picture(mesh, options);
    if (!image.ok()) return image.error();
    entries.push_back({std::move(*image), caption});
    return {};
}

/// Figure 6: the original with its triangles, levels L to 0, level 0 with its triangles.
Result<void> add_sequence(Page& page, const Model& model) {
    const unsigned L = model.mesh.levels;
    const std::vector<Vec3f> positions = model.positions();
    std::vector<Vec3f> coefficients(positions.size());
    PatchTransform transform(model.mesh.base, L, {.kind = TransformKind::Interp, .local_frames = false},
                             model.mesh.creases);
    transform.analyze(positions, coefficients);
    PictureOptions options = options_for(model), wires = options;
    wires.wireframe = true;
    std::vector<SheetEntry> entries;
    if (auto drawn = add_picture(entries, model.surface(L, positions), wires, "original"); !drawn.ok()) return drawn;
    for (unsigned level = L + 1; level-- > 0;) {
        std::vector<Vec3f> v(vertices_at_level(model.mesh.base, level));
        transform.synthesize(coefficients, level, v);
        const Mesh surface = model.surface(level, v);
        const std::string caption = fmt::format("level {}: {} faces", level, surface.faces.size());
        if (auto drawn = add_picture(entries, surface, options, caption); !drawn.ok()) return drawn;
        if (level > 0) continue;
        if (auto drawn = add_picture(entries, surface, wires, "level 0"); !drawn.ok()) return drawn;
    }
    return page.picture(
        "levels_" + model.name, contact_sheet(entries, (L + 4) / 2),
        "Figure 6, " + model.name + ": the original, then after 0 to " + std::to_string(L) + " analyses");
}

/// RMS length, within base faces, of the umbrella of the umbrella: u of a vertex is the mean of its six neighbours less
/// itself. Where a surface curves evenly it vanishes; kinks and small waves stay.
double kinks(const Model& model, const std::vector<Vec3f>& v) {
    const std::uint32_t n = 1u << model.mesh.levels;
    const auto place = [n](std::uint32_t i, std::uint32_t k) { return i * (n + 1) - i * (i - 1) / 2 + k; };
    const auto umbrella = [&](const auto& at, std::uint32_t i, std::uint32_t k) {
        return (at(i + 1, k) + at(i - 1, k) + at(i, k + 1) + at(i, k - 1) + at(i + 1, k - 1) + at(i - 1, k + 1)) /
                   6.0f -
               at(i, k);
    };
    std::vector<std::uint32_t> patch;
    double sum = 0;
    std::size_t count = 0;
    for (std::uint32_t f = 0; f < model.mesh.base.face_count(); ++f) {
        patch_vertices(model.mesh.base, f, model.mesh.levels, patch);
        std::vector<Vec3f> u(patch.size());
        const auto point = [&](std::uint32_t i, std::uint32_t k) { return v[patch[place(i, k)]]; };
        const auto first = [&](std::uint32_t i, std::uint32_t k) { return u[place(i, k)]; };
        for (std::uint32_t i = 1; i < n; ++i)
            for (std::uint32_t k = 1; i + k < n; ++k) u[place(i, k)] = umbrella(point, i, k);
        for (std::uint32_t i = 2; i < n; ++i)
            for (std::uint32_t k = 2; i + k + 1 < n; ++k, ++count) sum += double(squared_length(umbrella(first, i, k)));
    }
    return count == 0 ? 0 : std::sqrt(sum / double(count));
}

double rms(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += double(squared_length(a[i] - b[i]));
    return std::sqrt(sum / double(a.size()));
}

struct Kind {
    TransformKind kind;
    const char* name;
};
constexpr Kind kCompared[] = {{TransformKind::Interp, "interpolatory, lifted"},
                              {TransformKind::Loop, "loop, lifted (10 points)"}};

}  // namespace

Result<void> add_levels(Page& page, const std::vector<Model>& models) {
    page.heading("Figure 6: multiresolution models");
    page.text("Each surface is what analysis by the lifted interpolatory wavelet leaves of the one before.");
    for (std::size_t i = 0; i < std::min<std::size_t>(3, models.size()); ++i)
        if (auto done = add_sequence(page, models[i]); !done.ok()) return done;

    page.heading("Figure 9: interpolatory wavelets against Loop&rsquo;s");
    page.quote(
        "&ldquo;As for loop subdivision, there are ripples in the surfaces generated by loop subdivision wavelets "
        "analysis after several times decomposing. The interpolatory subdivision wavelet analysis we propose plays "
        "better on avoiding these defects.&rdquo; And: Loop&rsquo;s surfaces &ldquo;are smoother in general&rdquo;.");
    page.text(fmt::format("After {} analyses each surface is subdivided again to the finest level without its details.",
                          models.front().mesh.levels - 1));
    std::vector<SheetEntry> entries;
    std::vector<std::vector<std::string>> cells;
    unsigned closer = 0, smoother = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, models.size()); ++i) {
        const Model& model = models[i];
        const std::vector<Vec3f> original = model.positions();
        const PictureOptions options = options_for(model);
        if (auto drawn = add_picture(entries, model.surface(model.mesh.levels, original), options, model.name);
            !drawn.ok())
            return drawn;
        std::vector<double> errors, rough;
        for (const Kind& kind : kCompared) {
            const std::vector<Vec3f> v = without_details_above(model, kind.kind, 1);
            if (auto drawn = add_picture(entries, model.surface(model.mesh.levels, v), options, kind.name); !drawn.ok())
                return drawn;
            errors.push_back(rms(v, original));
            rough.push_back(kinks(model, v));
            cells.push_back({fmt::format("{}, {}", model.name, kind.name), digits(errors.back() * 1e3),
                             digits(rough.back() * 1e6)});
            page.numbers["figure9"][model.name][std::string(transform_name(kind.kind))] = {{"rms", errors.back()},
                                                                                           {"kinks", rough.back()}};
        }
        closer += errors[0] < errors[1] ? 1 : 0;
        smoother += rough[1] < rough[0] ? 1 : 0;
    }
    if (auto drawn = page.picture("loop_against_interp", contact_sheet(entries, 3),
                                  "Figure 9: the original, interpolatory, Loop");
        !drawn.ok())
        return drawn;
    page.table("Against the original", {"", "RMS distance, 1e-3 of the diagonal", "kinks, 1e-6 of the diagonal"},
               cells);
    const std::size_t compared = cells.size() / 2;
    page.verdict(fmt::format(
        "Interpolatory surfaces stay closer to the original on {} of {} models; Loop&rsquo;s have the smaller kinks on "
        "{} of {} "
        "(RMS of the umbrella of the umbrella), as the paper grants.{} The facets of the interpolatory surfaces around "
        "the "
        "vertices of level 1 are the price of resetting x on every level: the rule then predicts x&sup2;+y&sup2; no "
        "better than "
        "the midpoint does.",
        closer, compared, smoother, compared,
        closer == compared
            ? " Loop&rsquo;s distance is that of slow waves about the original: the bulging that the paper marks."
            : " Where Loop is the closer one, the shape is so smooth that its rule fits it as it is: the paper&rsquo;s "
              "claim is "
              "one about scans."));
    return {};
}

}  // namespace mvw::paper
