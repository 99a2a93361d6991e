#include "codec/remesh/surface_walk.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/mesh/half_edges.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

namespace {

constexpr unsigned kMaxCrossings = 256;

Vec3 combine(const std::array<Vec3, 3>& corners, const std::array<double, 3>& weight) {
    return corners[0] * weight[0] + corners[1] * weight[1] + corners[2] * weight[2];
}

}  // namespace

SurfaceWalk::SurfaceWalk(const Mesh& mesh, std::span<const std::uint8_t> sharp)
    : mesh_(mesh), mates_(mesh.faces.size() * 3, kNone) {
    const EdgeGroups groups = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const std::uint32_t h = groups[g][0], twin = groups[g][1];
        if (!sharp.empty() && sharp[h] != 0) continue;
        mates_[h] = twin;
        mates_[twin] = h;
    }
    Fans fans = find_fans(mates_);
    corner_ = std::move(fans.of_corner);
    normals_.resize(fans.count);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Face& t = mesh.faces[f];
        const Vec3 n = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
        for (std::size_t k = 0; k < 3; ++k) normals_[corner_[3 * f + k]] += n;
    }
    for (Vec3& n : normals_) n = normalized(n);
}

Vec3 SurfaceWalk::position(const FacePoint& p) const {
    const Face& f = mesh_.faces[p.face];
    return combine({mesh_.positions[f[0]], mesh_.positions[f[1]], mesh_.positions[f[2]]}, p.weight);
}

Vec3 SurfaceWalk::normal(const FacePoint& p) const {
    const std::uint32_t* c = corner_.data() + std::size_t{3} * p.face;
    return normalized(combine({normals_[c[0]], normals_[c[1]], normals_[c[2]]}, p.weight));
}

FacePoint SurfaceWalk::walk(const FacePoint& start, const Vec3& step) const {
    FacePoint p = start;
    Vec3 left = step;  // what is still to go, in the plane of p.face
    for (unsigned crossing = 0; crossing < kMaxCrossings; ++crossing) {
        const Face& f = mesh_.faces[p.face];
        const Vec3 &a = mesh_.positions[f[0]], &b = mesh_.positions[f[1]], &c = mesh_.positions[f[2]];
        const Vec3 n = cross(b - a, c - a);
        const double nn = squared_length(n);
        if (nn == 0) return p;
        if (crossing == 0) left = left - n * (dot(n, left) / nn);
        // How the weights change over the step: the gradient of each is the opposite edge turned into the face.
        const std::array<double, 3> change{dot(cross(n, c - b), left) / nn, dot(cross(n, a - c), left) / nn,
                                           dot(cross(n, b - a), left) / nn};
        double t = 1;
        std::size_t out = 3;  // corner opposite to the side that the path leaves by
        for (std::size_t k = 0; k < 3; ++k) {
            if (p.weight[k] + t * change[k] >= 0 || change[k] >= 0) continue;
            t = std::max(p.weight[k], 0.0) / -change[k];
            out = k;
        }
        for (std::size_t k = 0; k < 3; ++k) p.weight[k] = std::max(0.0, p.weight[k] + t * change[k]);
        if (out == 3) break;
        p.weight[out] = 0;
        const auto side = static_cast<std::uint32_t>((out + 1) % 3);
        const std::uint32_t h = 3 * p.face + side, mate = mates_[h];
        if (mate == kNone) break;
        const Vec3 edge = normalized(mesh_.positions[f[(side + 1) % 3]] - mesh_.positions[f[side]]);
        const Vec3 outward = cross(edge, n) / std::sqrt(nn);
        const double along = dot(left, edge) * (1 - t), across = dot(left, outward) * (1 - t);
        const double first = p.weight[side], second = p.weight[(side + 1) % 3];
        p.face = mate / 3;
        p.weight = {};
        p.weight[mate % 3] = second;
        p.weight[(mate + 1) % 3] = first;
        const Face& g = mesh_.faces[p.face];
        const Vec3 outside = normalized(cross(
            cross(mesh_.positions[g[1]] - mesh_.positions[g[0]], mesh_.positions[g[2]] - mesh_.positions[g[0]]), edge));
        left = edge * along - outside * across;
    }
    const double sum = p.weight[0] + p.weight[1] + p.weight[2];
    for (double& w : p.weight) w /= sum;
    return p;
}

}  // namespace mvw
