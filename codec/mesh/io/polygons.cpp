#include "codec/mesh/io/polygons.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

#include "codec/mesh/srgb.h"

namespace mvw {
namespace {

/// Tests of a corner against an ear for all polygons of a file: some seconds.
constexpr std::uint64_t kTriangulationBudget = 2'000'000'000;
/// Half-edges are numbered in 32 bits.
constexpr std::uint64_t kMaxFaces = 0xFFFFFFFFu / 3;

struct Point2 {
    double x = 0, y = 0;
    friend bool operator==(const Point2&, const Point2&) = default;
};

/// Twice the signed area of a, b, c.
double turn(const Point2& a, const Point2& b, const Point2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Clips ears of one polygon, projected so that it runs counter-clockwise.
class EarClipper {
 public:
    EarClipper(std::vector<Point2> points, std::uint64_t& budget)
        : points_(std::move(points)), left_(points_.size()), next_(left_), previous_(left_), budget_(budget) {
        for (std::size_t i = 0; i < left_; ++i) {
            next_[i] = (i + 1) % left_;
            previous_[i] = (i + left_ - 1) % left_;
        }
    }

    template <typename Emit>
    void clip(Emit emit) {
        std::size_t at = 0;
        while (left_ > 3) {
            const std::size_t ear = find_ear(at);
            emit(previous_[ear], ear, next_[ear]);
            next_[previous_[ear]] = next_[ear];
            previous_[next_[ear]] = previous_[ear];
            --left_;
            at = next_[next_[ear]];  // every other corner first: fewer slivers than a fan
        }
        emit(previous_[at], at, next_[at]);
    }

 private:
    /// The next corner from `at` on that can be cut off; where none can (the polygon crosses itself, or is flat) the
    /// one that turns left most.
    std::size_t find_ear(std::size_t at) {
        std::size_t best = at;
        double best_turn = -1e300;
        for (std::size_t i = 0, ear = at; i < left_ && budget_ > 0; ++i, ear = next_[ear]) {
            const double area = turn(points_[previous_[ear]], points_[ear], points_[next_[ear]]);
            if (area > 0 && is_empty(ear)) return ear;
            if (area > best_turn) best_turn = area, best = ear;
        }
        return best;
    }

    /// True where no other corner lies in the triangle at `ear` or on its border. Polygons with holes go to these and
    /// back along one edge, whose ends are corners twice: that is in nobody's way, unless sides leave the ear's tip
    /// into the ear.
    bool is_empty(std::size_t ear) {
        const Point2 a = points_[previous_[ear]], b = points_[ear], c = points_[next_[ear]];
        const auto lies_inside = [&](const Point2& p) { return turn(a, b, p) > 0 && turn(b, c, p) > 0; };
        for (std::size_t i = next_[next_[ear]]; i != previous_[ear] && budget_ > 0; i = next_[i]) {
            --budget_;
            const Point2& p = points_[i];
            if (turn(a, b, p) < 0 || turn(b, c, p) < 0 || turn(c, a, p) < 0 || p == a || p == c) continue;
            if (p == b && !lies_inside(points_[previous_[i]]) && !lies_inside(points_[next_[i]])) continue;
            return false;
        }
        return true;
    }

    std::vector<Point2> points_;
    std::size_t left_;
    std::vector<std::size_t> next_, previous_;
    std::uint64_t& budget_;
};

/// Newell's normal of the polygon around its first corner, not of unit length.
Vec3 newell_normal(const std::vector<Vec3>& positions, const std::uint32_t* corners, std::size_t n) {
    Vec3 normal;
    const Vec3 origin = positions[corners[0]];
    for (std::size_t i = 1; i + 1 < n; ++i)
        normal += cross(positions[corners[i]] - origin, positions[corners[i + 1]] - origin);
    return normal;
}

/// The polygon in the plane across its normal, counter-clockwise.
std::vector<Point2> project(const std::vector<Vec3>& positions, const std::uint32_t* corners, std::size_t n) {
    const Vec3 normal = normalized(newell_normal(positions, corners, n));
    const Vec3 helper = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = normalized(cross(helper, normal)), v = cross(normal, u);
    std::vector<Point2> points(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 p = positions[corners[i]] - positions[corners[0]];
        points[i] = {dot(p, u), dot(p, v)};
    }
    return points;
}

/// Cuts a quad along its shorter diagonal, or along the one that lies inside where the quad is concave.
void cut_quad(const std::vector<Vec3>& positions, const std::uint32_t* c, std::vector<Face>& faces) {
    const std::vector<Point2> p = project(positions, c, 4);
    const double inside_02 = std::min(turn(p[0], p[1], p[2]), turn(p[0], p[2], p[3]));
    const double inside_13 = std::min(turn(p[1], p[2], p[3]), turn(p[1], p[3], p[0]));
    bool cut_02 = inside_02 > inside_13;
    if (inside_02 > 0 && inside_13 > 0)
        cut_02 = squared_length(positions[c[0]] - positions[c[2]]) <= squared_length(positions[c[1]] - positions[c[3]]);
    const std::size_t s = cut_02 ? 0 : 1;
    faces.push_back({c[s], c[s + 1], c[s + 2]});
    faces.push_back({c[s], c[s + 2], c[(s + 3) % 4]});
}

Result<void> check(const Polygons& in) {
    for (std::size_t v = 0; v < in.positions.size(); ++v)
        if (const Vec3& p = in.positions[v]; !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return Error{Errc::Malformed, 0, fmt::format("vertex {} has a coordinate that is not a finite number", v)};
    for (std::size_t p = 0; p < in.count(); ++p)
        for (std::size_t i = in.starts[p]; i < in.starts[p + 1]; ++i)
            if (in.corners[i] >= in.positions.size())
                return Error{Errc::Malformed, 0,
                             in.corners[i] == kBadIndex
                                 ? fmt::format("face {} has an index out of range", p)
                                 : fmt::format("face {} names vertex {} of {}", p, in.corners[i], in.positions.size())};
    if (in.corners.size() >= kMaxFaces)
        return Error{Errc::LimitExceeded, 0, fmt::format("{} face corners are too many", in.corners.size())};
    return {};
}

/// Larger numbers are taken for none: their differences would not be finite.
constexpr double kLargestNumber = 1e300;

/// Values that are no numbers become the mean of those that are: wavelets cannot tell them from others.
void make_finite(VertexField& field, std::size_t vertices, CleanReport& report) {
    field.values.resize(vertices, std::nan(""));
    const auto good = [](double x) { return std::abs(x) <= kLargestNumber; };
    double sum = 0, count = 0;
    for (const double x : field.values)
        if (good(x)) sum += x / static_cast<double>(vertices), ++count;
    const double mean = count > 0 ? sum * (static_cast<double>(vertices) / count) : 0;
    for (double& x : field.values)
        if (!good(x)) x = mean, ++report.replaced_values;
}

/// Normals of length 1, or 0 where they are none.
void make_unit(VertexField& field, std::size_t vertices) {
    field.values.resize(3 * vertices, 0);
    for (std::size_t v = 0; v < vertices; ++v) {
        const Vec3 n = normalized(Vec3{field.values[3 * v], field.values[3 * v + 1], field.values[3 * v + 2]});
        const bool finite = std::abs(squared_length(n) - 1) < 0.01;
        for (std::size_t k = 0; k < 3; ++k) field.values[3 * v + k] = finite ? n[k] : 0;
    }
}

}  // namespace

std::optional<std::size_t> field_of(Polygons& polygons, FieldKind kind, std::string_view name) {
    std::string clean(name.substr(0, kMaxFieldName));
    std::ranges::replace_if(
        clean, [](char c) { return c < '!' || c > '~'; }, '_');
    std::vector<VertexField>& fields = polygons.fields;
    for (std::size_t k = 0; k < fields.size(); ++k)
        if (fields[k].kind == kind && fields[k].name == clean) return k;
    if (fields.size() >= kMostFields) return drop_field(polygons, std::move(clean)), std::nullopt;
    fields.push_back({kind, std::move(clean), {}});
    return fields.size() - 1;
}

void set_value(VertexField& field, std::size_t vertex, std::span<const double> value) {
    const std::size_t first = vertex * value.size();
    if (field.values.size() < first + value.size()) field.values.resize(first + value.size(), std::nan(""));
    std::ranges::copy(value, field.values.begin() + static_cast<std::ptrdiff_t>(first));
}

void drop_field(Polygons& polygons, std::string name) {
    std::vector<std::string>& dropped = polygons.dropped_fields;
    if (dropped.size() < kMostFields && std::ranges::find(dropped, name) == dropped.end())
        dropped.push_back(std::move(name));
}

void triangulate(const std::vector<Vec3>& positions, const std::uint32_t* corners, std::size_t n,
                 std::vector<Face>& faces, std::uint64_t& budget) {
    if (n == 3) return faces.push_back({corners[0], corners[1], corners[2]});
    if (n == 4) return cut_quad(positions, corners, faces);
    EarClipper(project(positions, corners, n), budget).clip([&](std::size_t a, std::size_t b, std::size_t c) {
        faces.push_back({corners[a], corners[b], corners[c]});
    });
}

namespace {

/// Cuts a polygon into triangles of its corners' numbers, 0 to n - 1.
class PolygonCutter {
 public:
    const std::vector<Face>& cut(const std::vector<Vec3>& positions, std::span<const std::uint32_t> corners) {
        points_.clear();
        for (const std::uint32_t v : corners) points_.push_back(positions[v]);
        while (numbers_.size() < corners.size()) numbers_.push_back(static_cast<std::uint32_t>(numbers_.size()));
        faces_.clear();
        triangulate(points_, numbers_.data(), corners.size(), faces_, budget_);
        return faces_;
    }

 private:
    std::uint64_t budget_ = kTriangulationBudget;
    std::vector<Vec3> points_;
    std::vector<std::uint32_t> numbers_;
    std::vector<Face> faces_;
};

/// Of materials without an image; all faces of a label have one paint.
std::vector<MaterialColor> colors_of_labels(const PaintedFaces& painted, const Mesh& mesh) {
    std::map<std::uint32_t, Rgba8> colors;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        if (const Paint& paint = painted.paints[painted.paint_of[f]]; !paint.texture)
            colors.emplace(mesh.materials.empty() ? 0 : mesh.materials[f], to_srgb(paint.color));
    std::vector<MaterialColor> out;
    out.reserve(colors.size());
    for (const auto& [label, color] : colors) out.push_back({label, color});
    return out;
}

/// Without faces of no area, which are nearest to nothing but points of others.
PaintedFaces without_flat_faces(PaintedFaces painted, Mesh& surface) {
    std::size_t kept = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        const auto [a, b, c] = surface.faces[f];
        const std::vector<Vec3>& p = surface.positions;
        if (!(squared_length(cross(p[b] - p[a], p[c] - p[a])) > 0)) continue;
        surface.faces[kept] = surface.faces[f];
        painted.paint_of[kept] = painted.paint_of[f];
        for (std::size_t k = 0; k < 3; ++k) painted.coordinates[3 * kept + k] = painted.coordinates[3 * f + k];
        ++kept;
    }
    surface.faces.resize(kept);
    painted.paint_of.resize(kept);
    painted.coordinates.resize(3 * kept);
    return painted;
}

/// Gives the mesh the colours of its paints: those of materials where no image is, of vertices, and between these.
void paint(Polygons& polygons, PaintedFaces painted, Mesh& mesh, CleanReport& report) {
    painted.paints = std::move(polygons.paints);
    painted.tints = std::move(polygons.tints);
    const auto has_image = [&](std::uint32_t paint) { return painted.paints[paint].texture != nullptr; };
    const bool any_image = std::ranges::any_of(painted.paint_of, has_image), tinted = !painted.tints.empty();
    if (any_image) report.textured_vertices = mesh.positions.size();
    if (!tinted) mesh.material_colors = colors_of_labels(painted, mesh);
    if (!any_image && !tinted) return;
    Mesh surface{mesh.positions, mesh.faces, {}, {}};
    mesh.colors = vertex_colors(*make_paintwork(surface, painted));
    if (!any_image) return;
    painted = without_flat_faces(std::move(painted), surface);
    if (!surface.faces.empty()) mesh.paintwork = make_paintwork(std::move(surface), std::move(painted));
}

}  // namespace

Result<Mesh> to_mesh(Polygons polygons, CleanReport& report) {
    if (const Result<void> fine = check(polygons); !fine) return fine.error();
    Mesh mesh;
    mesh.positions = std::move(polygons.positions);
    mesh.faces.reserve(polygons.corners.size() >= 2 * polygons.count() ? polygons.corners.size() - 2 * polygons.count()
                                                                       : 0);
    PaintedFaces painted;
    PolygonCutter cutter;
    for (std::size_t p = 0; p < polygons.count(); ++p) {
        const std::uint32_t first = polygons.starts[p], n = polygons.starts[p + 1] - first;
        if (n < 3) {
            ++report.degenerate_faces;
            continue;
        }
        report.triangulated_polygons += n > 3;
        for (const Face& cut : cutter.cut(mesh.positions, std::span(polygons.corners).subspan(first, n))) {
            mesh.faces.push_back({});
            for (std::size_t c = 0; c < 3; ++c) {
                mesh.faces.back()[c] = polygons.corners[first + cut[c]];
                if (!polygons.paints.empty()) painted.coordinates.push_back(polygons.coordinates[first + cut[c]]);
            }
            if (!polygons.paints.empty()) painted.paint_of.push_back(polygons.paint_of[p]);
        }
        if (!polygons.materials.empty()) mesh.materials.resize(mesh.faces.size(), polygons.materials[p]);
    }
    if (mesh.faces.empty()) return Error{Errc::Malformed, 0, "has no faces"};

    const auto& labels = mesh.materials;
    if (std::all_of(labels.begin(), labels.end(), [&](std::uint32_t m) { return m == labels[0]; }))
        mesh.materials.clear();
    if (!polygons.paints.empty()) {
        paint(polygons, std::move(painted), mesh, report);
    } else if (!polygons.colors.empty()) {
        mesh.colors = std::move(polygons.colors);
        mesh.colors.resize(mesh.positions.size());
    }
    report.dropped_fields = std::move(polygons.dropped_fields);
    report.missing_textures = std::move(polygons.missing_textures);
    for (VertexField& field : polygons.fields) {
        field.kind == FieldKind::Normals ? make_unit(field, mesh.positions.size())
                                         : make_finite(field, mesh.positions.size(), report);
        mesh.fields.push_back(std::move(field));
    }
    return mesh;
}

}  // namespace mvw
