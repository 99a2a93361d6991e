#include "codec/remesh/density.h"

namespace mvw {

namespace {

constexpr int kRounds = 4;

}  // namespace

std::vector<double> areas_around(const std::vector<Vec3>& positions, const std::vector<Face>& faces) {
    std::vector<double> area, at_vertex(positions.size()), count(positions.size());
    area.reserve(faces.size());
    for (const Face& f : faces) {
        const Vec3& a = positions[f[0]];
        area.push_back(0.5 * length(cross(positions[f[1]] - a, positions[f[2]] - a)));
        for (const std::uint32_t v : f) ++count[v];
    }
    for (int round = 0; round < kRounds; ++round) {
        at_vertex.assign(positions.size(), 0);
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (const std::uint32_t v : faces[f]) at_vertex[v] += area[f] / count[v];
        for (std::size_t f = 0; f < faces.size(); ++f)
            area[f] = (at_vertex[faces[f][0]] + at_vertex[faces[f][1]] + at_vertex[faces[f][2]]) / 3;
    }
    return area;
}

}  // namespace mvw
