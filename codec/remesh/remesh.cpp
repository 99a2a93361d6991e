#include "codec/remesh/remesh.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <thread>
#include <unordered_set>
#include <utility>

#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/half_edges.h"
#include "codec/mesh/vertex_data.h"
#include "codec/remesh/cover.h"
#include "codec/remesh/facets.h"
#include "codec/remesh/feature_choice.h"
#include "codec/remesh/features.h"
#include "codec/remesh/line_spacing.h"
#include "codec/remesh/prepare.h"
#include "codec/remesh/recognize.h"
#include "codec/remesh/relax.h"
#include "codec/remesh/resample.h"
#include "codec/remesh/self_parameterization.h"
#include "codec/remesh/settle.h"
#include "codec/remesh/surface_walk.h"

namespace mvw {

namespace {

constexpr unsigned kLeastOwnLevels = 2;     // of semi-regular input that is kept; else its base is too large to stream
constexpr double kOversampling = 1.3;       // faces of the finest level for each face of the input
constexpr double kBaseError = 2.8e-3;       // of the diagonal, by the quadrics: where a default base stops
constexpr double kCornerReach = 0.01;       // of the diagonal
constexpr std::size_t kBaseReduction = 10;  // input faces for each face of a default base, at least; ...
constexpr std::size_t kFeatureReduction = 3;  // ... and one more for so many edges of features, which it has to follow
constexpr unsigned kMaxLevels = 8;
constexpr std::uint32_t kMinComponentFaces = 60;  // a smaller component costs less as it is
constexpr double kLongestPainted = 1.0 / 64;      // of the diagonal: of painted facets, while few more are enough
constexpr double kVerticesOfFacets = 6;           // of a remesh that costs as much as one of a few facets
constexpr double kMinReduction = 2;               // input faces for each base face below which wavelets are pointless
constexpr double kTargetError = 1e-4;             // of the diagonal: a finer level where it is missed ...
constexpr double kMaxOversampling = 8;            // ... but no more vertices than this for each of the input
constexpr double kFineError = 2.5e-5;             // of the diagonal: a finer level where it is missed ...
// ... and it costs little (kFewVertices); smooth shapes then need fewer details, ...
constexpr double kMaxFineOversampling = 24;  // ... but a few faces are told with fewer vertices than that
constexpr double kMaxError = 4e-4;           // of the diagonal: a remesh that misses it by more is given up
constexpr double kMaxSmallDeviation =
    1e-2;  // the same at the worst place of a part that Draco codes in a few kilobytes
constexpr std::size_t kSmallPartFaces = 10'000;
constexpr std::uint32_t kSamples = 40'000;  // of each surface and all its vertices, to measure errors; ...
constexpr std::uint32_t kThinning = 4;      // ... of large parts, where the largest is not asked for, one of so many
constexpr std::size_t kMaxFaces = std::size_t{1} << 27;  // of a finest level, whatever was asked for
constexpr double kMaxAloneShare = 0.3;                   // of the area: above this, try without features
constexpr double kNoFeaturesDeg = 181;                   // no edge is as sharp

unsigned default_level(std::size_t input_faces, std::size_t base_faces) {
    const double ratio = kOversampling * static_cast<double>(input_faces) / static_cast<double>(base_faces);
    return static_cast<unsigned>(std::clamp(std::round(std::log2(ratio) / 2), 0.0, double{kMaxLevels}));
}

double area_of(const Mesh& mesh, const Face& f) {
    const Vec3& a = mesh.positions[f[0]];
    return length(cross(mesh.positions[f[1]] - a, mesh.positions[f[2]] - a)) * 0.5;
}

/// Share of the surface in the wanted faces; 0 where there is no surface.
template <typename Wanted>
double area_share(const Mesh& mesh, Wanted wanted) {
    double all = 0, some = 0;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        const double area = area_of(mesh, mesh.faces[f]);
        all += area;
        if (wanted(f)) some += area;
    }
    return all > 0 ? some / all : 0;
}

/// The faces of some components as a mesh of their own, vertices renumbered in order of first use.
template <typename Wanted>
Mesh extract_faces(const Mesh& mesh, Wanted wanted) {
    Mesh out;
    out.paintwork = mesh.paintwork;
    std::vector<std::uint32_t> number(mesh.positions.size(), kNone);
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        if (!wanted(f)) continue;
        Face face = mesh.faces[f];
        for (std::uint32_t& v : face) {
            if (number[v] == kNone) {
                number[v] = static_cast<std::uint32_t>(out.positions.size());
                out.positions.push_back(mesh.positions[v]);
                append_vertex_data(mesh, v, out);
            }
            v = number[v];
        }
        out.faces.push_back(face);
        if (!mesh.materials.empty()) out.materials.push_back(mesh.materials[f]);
    }
    return out;
}

/// A mesh as a part of 0 levels.
SemiRegularMesh as_it_is(Mesh mesh) {
    SemiRegularMesh part;
    part.base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), std::move(mesh.faces)).value();
    part.positions = std::move(mesh.positions);
    part.colors = std::move(mesh.colors);
    part.fields = std::move(mesh.fields);
    part.materials = std::move(mesh.materials);
    return part;
}

/// Live faces of the decimated mesh that are `wanted`, as a base with vertices in order of first use.
template <typename Wanted>
BaseMesh extract_base(const CollapseMesh& mesh, Wanted wanted, std::vector<std::uint32_t>& face_ids) {
    std::vector<std::uint32_t> number(mesh.positions.size(), kNone);
    std::vector<Face> faces;
    std::uint32_t vertices = 0;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        if (mesh.faces[f][0] == kNone || !wanted(f)) continue;
        Face face = mesh.faces[f];
        for (std::uint32_t& v : face) {
            if (number[v] == kNone) number[v] = vertices++;
            v = number[v];
        }
        faces.push_back(face);
        face_ids.push_back(f);
    }
    return BaseMesh::create(vertices, std::move(faces)).value();
}

/// Level of each component (0: coded as it is), from what the decimation left of it.
std::vector<unsigned> choose_levels(const CollapseMesh& base, const std::vector<Component>& parts,
                                    const std::vector<std::uint32_t>& component_of_face, const RemeshOptions& options) {
    std::vector<std::size_t> base_faces(parts.size(), 0);
    for (std::uint32_t f = 0; f < base.faces.size(); ++f)
        if (base.faces[f][0] != kNone) ++base_faces[component_of_face[f]];
    std::vector<unsigned> levels(parts.size(), 0);
    for (std::size_t c = 0; c < parts.size(); ++c) {
        const auto faces = static_cast<double>(parts[c].faces);
        const bool pointless = faces < kMinComponentFaces || faces < kMinReduction * static_cast<double>(base_faces[c]);
        if (pointless && options.levels < 0 && options.base_faces == 0) continue;
        levels[c] = options.levels >= 0 ? static_cast<unsigned>(options.levels)
                                        : std::max(1u, default_level(parts[c].faces, base_faces[c]));
    }
    return levels;
}

/// Flags of the base edges that follow features; empty where there are none.
std::vector<std::uint8_t> creases_of(const CollapseMesh& mesh, const BaseMesh& base,
                                     const std::vector<std::uint32_t>& face_ids) {
    std::vector<std::uint8_t> creases(base.edge_count(), 0);
    bool any = false;
    for (std::uint32_t e = 0; e < base.edge_count(); ++e) {
        const BaseEdge& edge = base.edges()[e];
        if (edge.face[1] == kNone || !mesh.is_sharp(face_ids[edge.face[0]] * 3 + edge.side[0])) continue;
        creases[e] = 1;
        any = true;
    }
    if (!any) creases.clear();
    return creases;
}

void report(const RemeshOptions& options, const char* phase, double done) {
    if (options.progress) options.progress(phase, done);
}

/// One way down to a base, and what each component makes of it.
struct Decimation {
    std::vector<std::uint8_t> sharp;  // half-edges that base edges had to follow; empty: none
    std::unique_ptr<SelfParameterization> parameterization;
    std::vector<unsigned> levels;  // of each component, 0: coded as it is
    double alone_area_share = 0;   // of components that are too large to be their own base
};

Decimation decimate(const Mesh& mesh, std::vector<std::uint8_t> sharp, const std::vector<Component>& parts,
                    const std::vector<std::uint32_t>& component_of_face, const RemeshOptions& options) {
    DecimateOptions how;
    how.target_faces = options.base_faces;
    const auto feature_edges = static_cast<std::size_t>(std::count(sharp.begin(), sharp.end(), 1)) / 2;
    how.max_faces = mesh.faces.size() / kBaseReduction + feature_edges / kFeatureReduction;
    how.error = kBaseError * bounding_box(mesh).diagonal();
    how.corner_reach = kCornerReach;
    how.progress = [&](double done) { report(options, "decimate", done); };
    Decimation out;
    out.sharp = std::move(sharp);
    out.parameterization = std::make_unique<SelfParameterization>(mesh, out.sharp, how);
    out.levels = choose_levels(out.parameterization->base(), parts, component_of_face, options);
    out.alone_area_share = area_share(mesh, [&](std::uint32_t f) {
        const std::uint32_t c = component_of_face[f];
        return out.levels[c] == 0 && parts[c].faces > kMostFacets;
    });
    return out;
}

/// Makes parts of a decimated mesh's components.
class Sampler {
 public:
    Sampler(const Mesh& mesh, const Decimation& decimation, unsigned threads, const RemeshOptions& options)
        : mesh_(mesh),
          parameterization_(*decimation.parameterization),
          surface_(mesh, decimation.sharp),
          threads_(threads),
          options_(options),
          machined_(is_machined(mesh)) {}

    /// The wanted faces, all of components that start with `level`, as a part: finer where they miss the target error;
    /// none where they miss it by far.
    template <typename Wanted>
    std::optional<SemiRegularMesh> make_part(unsigned level, Wanted wanted) const {
        const double target = options_.target_error > 0 ? options_.target_error : kTargetError;
        const Mesh input = extract_faces(mesh_, wanted);
        SemiRegularMesh part;
        std::vector<std::uint32_t> face_ids;
        part.base = extract_base(parameterization_.base(), wanted, face_ids);
        part.creases = creases_of(parameterization_.base(), part.base, face_ids);
        part.materials = materials_of_base(face_ids);
        part.levels = level;
        while (part.levels > 1 && (std::size_t{part.base.face_count()} << (2 * part.levels)) > kMaxFaces) --part.levels;
        Distance error = sample(input, face_ids, part);
        while (options_.levels < 0 && part.levels < kMaxLevels) {
            const auto finer = static_cast<double>(vertices_at_level(part.base, part.levels + 1));
            const bool needed =
                error.rms > target && finer <= kMaxOversampling * static_cast<double>(input.positions.size());
            const bool cheap =
                options_.target_error <= 0 && error.rms > kFineError &&
                finer <= std::min(kFewVertices, kMaxFineOversampling * static_cast<double>(input.positions.size()));
            if (!needed && !cheap) break;
            ++part.levels;
            error = sample(input, face_ids, part);
        }
        if (options_.levels < 0 && options_.base_faces == 0 &&
            (is_given_up(input, error) || is_dearer_than_its_faces(input, part)))
            return std::nullopt;
        return part;
    }

 private:
    /// Between two surfaces, both ways, of the whole mesh's diagonal.
    struct Distance {
        double rms = 0, max = 0;
    };

    /// Whether a part is better left to Draco. Small ones cost little there, so they have to be good at their worst
    /// place, too: a rounded corner of a CAD model that the grid cuts off is seen, whatever the mean.
    [[nodiscard]] static bool is_given_up(const Mesh& input, const Distance& error) {
        const bool is_small = input.faces.size() < kSmallPartFaces;
        return error.rms > kMaxError || (is_small && error.max > kMaxSmallDeviation);
    }

    /// Whether a few faces cost less than what would stand for them.
    [[nodiscard]] static bool is_dearer_than_its_faces(const Mesh& input, const SemiRegularMesh& part) {
        return input.faces.size() <= kMostFacets && static_cast<double>(part.positions.size()) >
                                                        kVerticesOfFacets * static_cast<double>(input.positions.size());
    }

    /// Of each base face; it lies within one material, because its edges follow their borders.
    [[nodiscard]] std::vector<std::uint32_t> materials_of_base(const std::vector<std::uint32_t>& face_ids) const {
        if (mesh_.materials.empty()) return {};
        std::vector<FacePoint> points;
        for (const std::uint32_t face : face_ids) points.push_back({face, {1.0 / 3, 1.0 / 3, 1.0 / 3}});
        parameterization_.to_input(points, threads_);
        std::vector<std::uint32_t> materials;
        for (const FacePoint& p : points) materials.push_back(mesh_.materials[p.face]);
        return materials;
    }

    /// Fills in positions, colours and fields of a part whose base and levels stand. Returns how far the two surfaces
    /// are apart.
    Distance sample(const Mesh& input, const std::vector<std::uint32_t>& face_ids, SemiRegularMesh& part) const {
        report(options_, "sample", 0);
        std::vector<FacePoint> points = grid_points(part.base, part.levels, face_ids);
        space_lines(mesh_, parameterization_, part, face_ids, threads_, points);
        parameterization_.to_input(points, threads_);

        report(options_, "relax", 0);
        const std::vector<Face> triangles = triangles_at_level(part.base, part.levels);
        const std::vector<std::uint8_t> fixed = line_vertices(part);
        if (machined_) {  // where it is edges that cut corners, which more points do not mend
            relax(surface_, triangles, fixed, {.threads = threads_}, points);
        } else {
            relax_to_cover(mesh_, surface_, triangles, fixed, threads_, points);
        }
        part.positions = positions_of(mesh_, points);
        take_vertex_data(mesh_, points, part);

        report(options_, "fit", 0);
        std::vector<Vec3> normals;
        for (std::size_t v = 0; v < points.size(); ++v)
            normals.push_back(fixed[v] != 0 ? Vec3{} : surface_.normal(points[v]));
        settle(input, triangles, fixed, normals, {1, false, threads_}, part.positions);
        const std::uint32_t thinning = input.faces.size() >= kSmallPartFaces ? kThinning : 1;
        const SurfaceError error =
            surface_error(input, {part.positions, triangles, {}, {}}, {kSamples / thinning, threads_, thinning});
        report(options_, "fit", 1);
        const double scale = bounding_box(input).diagonal() / bounding_box(mesh_).diagonal();
        return {error.rms * scale, error.max * scale};
    }

    const Mesh& mesh_;
    const SelfParameterization& parameterization_;
    const SurfaceWalk surface_;
    const unsigned threads_;
    const RemeshOptions& options_;
    const bool machined_;
};

/// remesh() of a mesh none of whose components is semi-regular already.
RemeshResult remesh_irregular(const Mesh& input, const RemeshOptions& options) {
    RemeshResult result;
    const Box box = bounding_box(input);
    const double diagonal = box.diagonal();
    if (!(diagonal > 0) || !std::isfinite(diagonal)) {
        result.parts.push_back(as_it_is(input));
        result.part_of_face.assign(input.faces.size(), 0);
        result.alone_area_share = 1;
        result.origins.assign(1, PartOrigin::Alone);
        return result;
    }
    // In a box of unit diagonal around the origin, so that no model is too small, too large or too far away.
    const Vec3 center = box.center();
    Mesh unit = input;
    for (Vec3& p : unit.positions) p = (p - center) / diagonal;
    const SplitMesh split = split_ears(unit);
    const Mesh& mesh = split.mesh;
    const unsigned threads = options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::uint32_t> component_of_face;
    const std::vector<Component> parts = components(mesh, component_of_face);

    const auto base_faces = [&](const std::vector<std::uint8_t>& sharp) {
        return decimate(mesh, sharp, parts, component_of_face, {}).parameterization->base().live_faces();
    };
    const ChosenFeatures features = options.feature_angle_deg > 0 ? features_from(mesh, options.feature_angle_deg)
                                                                  : choose_features(mesh, base_faces);
    const std::vector<std::uint8_t>& sharp = features.sharp;
    result.feature_angle_deg = features.angle_deg;
    Decimation decimation = decimate(mesh, sharp, parts, component_of_face, options);
    const bool has_features = std::find(sharp.begin(), sharp.end(), 1) != sharp.end();
    if (has_features && options.base_faces == 0 && decimation.alone_area_share > kMaxAloneShare) {
        // So many features leave too little to collapse, as the noise of some scans does: do without them.
        // Borders between materials stay.
        Decimation smooth =
            decimate(mesh, features_from(mesh, kNoFeaturesDeg).sharp, parts, component_of_face, options);
        if (smooth.alone_area_share <= decimation.alone_area_share) {
            decimation = std::move(smooth);
            result.feature_angle_deg = kNoFeaturesDeg;
        }
    }

    const Sampler sampler(mesh, decimation, threads, options);
    std::vector<unsigned>& levels = decimation.levels;
    std::vector<std::uint32_t> part_of_component(parts.size(), kNone);
    std::vector<std::uint32_t> component;  // of each face of the input
    for (const std::uint32_t first : split.first_face) component.push_back(component_of_face[first]);
    const auto add = [&](SemiRegularMesh part, PartOrigin origin, const auto& wanted) {
        for (std::uint32_t c = 0; c < parts.size(); ++c)
            if (wanted(c)) part_of_component[c] = static_cast<std::uint32_t>(result.parts.size());
        result.parts.push_back(std::move(part));
        result.origins.push_back(origin);
    };
    const std::set<unsigned, std::greater<>> used(levels.begin(), levels.end());
    for (const unsigned level : used) {
        if (level == 0) break;
        const auto wanted = [&](std::uint32_t c) { return levels[c] == level; };
        auto part = sampler.make_part(level, [&](std::uint32_t f) { return wanted(component_of_face[f]); });
        if (!part) continue;
        for (Vec3& p : part->positions) p = p * diagonal + center;
        add(std::move(*part), PartOrigin::Remeshed, wanted);
    }
    const auto keep_faces = [&](PartOrigin origin, const auto& wanted) {
        Mesh kept = extract_faces(input, [&](std::uint32_t f) { return wanted(component[f]); });
        if (kept.faces.empty()) return 0.0;
        if (origin == PartOrigin::Facets && kept.paintwork) split_large_faces(kept, diagonal * kLongestPainted);
        add(origin == PartOrigin::Facets ? facets_of(kept) : as_it_is(kept), origin, wanted);
        return area_share(unit, [&](std::uint32_t f) { return wanted(component[f]); });
    };
    const std::vector<std::uint32_t> remeshed = part_of_component;
    std::vector<std::uint8_t> facets(parts.size(), 0);
    if (options.levels < 0 && options.base_faces == 0)
        facets = choose_facets(input, component, parts.size(), input.paintwork != nullptr,
                               [&](std::uint32_t c) { return remeshed[c] == kNone; });
    result.facets_area_share = keep_faces(PartOrigin::Facets, [&](std::uint32_t c) { return facets[c] != 0; });
    result.alone_area_share =
        keep_faces(PartOrigin::Alone, [&](std::uint32_t c) { return remeshed[c] == kNone && facets[c] == 0; });
    for (std::uint32_t f = 0; f < input.faces.size(); ++f)
        result.part_of_face.push_back(part_of_component[component[f]]);
    return result;
}

/// Flags of the base edges that are features of the mesh along their whole length; empty where there are none.
std::vector<std::uint8_t> own_creases(const Mesh& mesh, const std::vector<std::uint8_t>& sharp,
                                      const Recognized& found) {
    const auto key = [](std::uint32_t a, std::uint32_t b) {
        return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    };
    std::unordered_set<std::uint64_t> edges;
    for (std::uint32_t h = 0; h < sharp.size(); ++h)
        if (sharp[h] != 0) edges.insert(key(origin(mesh.faces, h), origin(mesh.faces, next_half_edge(h))));
    std::vector<std::uint8_t> creases;
    for (std::uint32_t b = 0; b < found.base.edge_count() && !edges.empty(); ++b) {
        const auto vertex = [&](std::uint32_t t) {
            return found.vertices[edge_vertex_index(found.base, found.base.edges()[b], found.levels, t)];
        };
        bool sharp_all_along = true;
        for (std::uint32_t t = 0; t < (1u << found.levels) && sharp_all_along; ++t)
            sharp_all_along = edges.count(key(vertex(t), vertex(t + 1))) > 0;
        creases.push_back(sharp_all_along ? 1 : 0);
    }
    if (std::find(creases.begin(), creases.end(), 1) == creases.end()) creases.clear();
    return creases;
}

/// Components that have subdivision connectivity, with their own vertices.
std::vector<SemiRegularMesh> take_over(const Mesh& mesh, Recognition& recognition) {
    std::vector<SemiRegularMesh> parts;
    const std::vector<std::uint8_t> sharp = feature_half_edges(mesh);
    for (Recognized& found : recognition.meshes) {
        SemiRegularMesh part;
        part.creases = own_creases(mesh, sharp, found);
        part.materials = std::move(found.materials);
        part.base = std::move(found.base);
        part.levels = found.levels;
        for (const std::uint32_t v : found.vertices) {
            part.positions.push_back(mesh.positions[v]);
            append_vertex_data(mesh, v, part);
        }
        parts.push_back(std::move(part));
    }
    return parts;
}

}  // namespace

RemeshResult remesh(const Mesh& input, const RemeshOptions& options) {
    const bool asked_for = options.base_faces > 0 || options.levels >= 0 || options.target_error > 0;
    if (asked_for) return remesh_irregular(input, options);
    Recognition recognition = recognize(input, kLeastOwnLevels);
    if (recognition.meshes.empty()) return remesh_irregular(input, options);

    std::vector<std::uint32_t> component_of_face;
    components(input, component_of_face);
    const auto is_irregular = [&](std::uint32_t f) {
        return recognition.mesh_of_component[component_of_face[f]] == kNone;
    };
    const Mesh irregular = extract_faces(input, is_irregular);
    RemeshResult result;
    if (!irregular.faces.empty()) result = remesh_irregular(irregular, options);
    const double irregular_share = area_share(input, is_irregular);
    result.alone_area_share *= irregular_share;
    result.facets_area_share *= irregular_share;

    const auto others = static_cast<std::uint32_t>(result.parts.size());
    std::vector<std::uint32_t> part_of_face;
    std::size_t at = 0;
    for (std::uint32_t f = 0; f < input.faces.size(); ++f)
        part_of_face.push_back(is_irregular(f) ? result.part_of_face[at++]
                                               : others + recognition.mesh_of_component[component_of_face[f]]);
    result.part_of_face = std::move(part_of_face);
    for (SemiRegularMesh& part : take_over(input, recognition)) result.parts.push_back(std::move(part));
    result.origins.resize(result.parts.size(), PartOrigin::Recognized);
    return result;
}

}  // namespace mvw
