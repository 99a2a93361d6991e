#include "codec/part_units.h"

namespace mvw {

namespace {

/// A line's vertices carry less of the surface than others: steps over those within it.
constexpr float kLineStep = 2;

/// Unnormalised normals of the base's vertices. Coordinates are at most 2^31, so double is exact enough for a frame.
std::vector<Vec3> normals_of(const BaseMesh& base, const PartUnits::Grid& grid, const Lattice& lattice) {
    std::vector<Vec3> normals(base.vertex_count());
    const auto at = [&](std::uint32_t v) { return lattice.in_units(grid[v]); };
    for (const Face& f : base.faces()) {
        const Vec3 normal = cross(at(f[1]) - at(f[0]), at(f[2]) - at(f[0]));
        for (const std::uint32_t v : f) normals[v] += normal;
    }
    return normals;
}

}  // namespace

PartUnits::PartUnits(const BaseMesh& base, std::span<const std::uint8_t> creases,
                     std::span<const std::uint32_t> materials, const Grid& grid, const PartParams& params)
    : on_line_(base.vertex_count(), 0), line_edge_(base.edge_count(), 0) {
    for (unsigned level = 0; level < params.steps.size(); ++level) {
        const float step = params.step(level), across = params.step_across(level);
        smooth_.push_back({step, across, across});
        const float on_line = step * kLineStep;
        line_.push_back({on_line, level == 0 ? on_line : across, on_line});
        first_.push_back(level == 0 ? 0 : vertices_at_level(base, level - 1));
    }
    for (std::uint32_t b = 0; b < base.edge_count(); ++b) {
        const BaseEdge& e = base.edges()[b];
        const bool inside = e.face[1] != kNone && (creases.empty() || creases[b] == 0) &&
                            (materials.empty() || materials[e.face[0]] == materials[e.face[1]]);
        if (inside) continue;
        line_edge_[b] = on_line_[e.v[0]] = on_line_[e.v[1]] = 1;
    }
    const std::vector<Vec3> normals = normals_of(base, grid, params.lattice);
    for (std::uint32_t v = 0; v < base.vertex_count(); ++v) {
        origins_.push_back(to_float(params.lattice.point(grid[v])));
        const Vec3f normal = to_float(normalized(normals[v]));
        frames_.push_back(params.transform.local_frames ? make_frame(normal, Vec3f{1, 0, 0})
                                                        : Frame<float>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    }
}

Vec3f PartUnits::steps(unsigned level, std::uint32_t vertex) const {
    if (level == 0) return on_line_[vertex] != 0 ? line_[0] : smooth_[0];
    const std::uint64_t edge = (vertex - first_[level]) >> (level - 1);
    return edge < line_edge_.size() && line_edge_[edge] != 0 ? line_[level] : smooth_[level];
}

}  // namespace mvw
