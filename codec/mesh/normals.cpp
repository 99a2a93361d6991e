#include "codec/mesh/normals.h"

namespace mvw {

std::vector<Vec3> vertex_normals(std::span<const Vec3> positions, std::span<const Face> faces) {
    std::vector<Vec3> normals(positions.size());
    for (const Face& f : faces) {
        const Vec3 n = cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
        for (const std::uint32_t v : f) normals[v] += n;
    }
    for (Vec3& n : normals) n = normalized(n);
    return normals;
}

}  // namespace mvw
