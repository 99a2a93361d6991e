#include "codec/remesh/relax.h"

#include <algorithm>
#include <cmath>

#include "codec/measure/surface_index.h"
#include "codec/remesh/parallel.h"

namespace mvw {

SurfaceWalk::SurfaceWalk(const Mesh& mesh) : mesh_(mesh), vertex_face_begin_(mesh.positions.size() + 1, 0) {
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) ++vertex_face_begin_[v + 1];
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) vertex_face_begin_[v + 1] += vertex_face_begin_[v];
    vertex_faces_.resize(mesh.faces.size() * 3);
    std::vector<std::uint32_t> at(vertex_face_begin_.begin(), vertex_face_begin_.end() - 1);
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
        for (const std::uint32_t v : mesh.faces[f]) vertex_faces_[at[v]++] = f;
}

Vec3 SurfaceWalk::position(const FacePoint& p) const {
    const Face& f = mesh_.faces[p.face];
    return mesh_.positions[f[0]] * p.weight[0] + mesh_.positions[f[1]] * p.weight[1] +
           mesh_.positions[f[2]] * p.weight[2];
}

Vec3 SurfaceWalk::normal(std::uint32_t face) const {
    const Face& f = mesh_.faces[face];
    const Vec3& a = mesh_.positions[f[0]];
    return normalized(cross(mesh_.positions[f[1]] - a, mesh_.positions[f[2]] - a));
}

FacePoint SurfaceWalk::closest_from(const FacePoint& start, const Vec3& target) const {
    const auto nearest = [&](std::uint32_t face, double& distance) {
        const Face& f = mesh_.faces[face];
        FacePoint p{face, closest_on_triangle(target, mesh_.positions[f[0]], mesh_.positions[f[1]], mesh_.positions[f[2]])};
        distance = squared_length(position(p) - target);
        return p;
    };
    double best = 0;
    FacePoint p = nearest(start.face, best);
    for (int step = 0; step < 64; ++step) {
        const std::uint32_t here = p.face;
        const std::array<double, 3> weight = p.weight;
        // On a side or a corner the faces around may be nearer; all of them meet at one of its vertices.
        for (std::size_t s = 0; s < 3; ++s) {
            if (weight[s] <= 0 || (weight[0] > 0 && weight[1] > 0 && weight[2] > 0)) continue;
            const std::uint32_t v = mesh_.faces[here][s];
            for (std::uint32_t k = vertex_face_begin_[v]; k < vertex_face_begin_[v + 1]; ++k) {
                double d = 0;
                const FacePoint q = nearest(vertex_faces_[k], d);
                if (d < best * (1 - 1e-9)) best = d, p = q;
            }
        }
        if (p.face == here) break;
    }
    return p;
}

void relax(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
           unsigned rounds, std::vector<FacePoint>& points, unsigned threads) {
    const std::size_t V = points.size();
    std::vector<std::uint32_t> begin(V + 1, 0);
    for (const Face& f : triangles)
        for (const std::uint32_t v : f) ++begin[v + 1];
    for (std::size_t v = 0; v < V; ++v) begin[v + 1] += begin[v];
    std::vector<std::uint32_t> around(triangles.size() * 3), at(begin.begin(), begin.end() - 1);
    for (std::uint32_t f = 0; f < triangles.size(); ++f)
        for (const std::uint32_t v : triangles[f]) around[at[v]++] = f;

    std::vector<Vec3> position(V), moved(V);
    for (std::size_t v = 0; v < V; ++v) position[v] = surface.position(points[v]);
    std::vector<FacePoint> proposal = points;
    for (unsigned round = 0; round < rounds; ++round) {
        parallel_slices(V, threads, [&](std::size_t from, std::size_t to) {
            for (std::size_t v = from; v < to; ++v) {
                moved[v] = position[v];
                proposal[v] = points[v];
                if (fixed[v]) continue;
                Vec3 sum;
                for (std::uint32_t k = begin[v]; k < begin[v + 1]; ++k)
                    for (const std::uint32_t w : triangles[around[k]]) sum += position[w];
                const double n = begin[v + 1] - begin[v];
                Vec3 step = (sum - position[v] * n) / (2 * n) - position[v];
                const Vec3 normal = surface.normal(points[v].face);
                step -= normal * dot(normal, step);
                proposal[v] = surface.closest_from(points[v], position[v] + step * 0.7);
                moved[v] = surface.position(proposal[v]);
            }
        });
        // Take back moves around triangles that turned over.
        std::vector<std::uint8_t> back(V, 0);
        for (int check = 0; check < 4; ++check) {
            bool any = false;
            for (const Face& f : triangles) {
                const Vec3 n = cross(moved[f[1]] - moved[f[0]], moved[f[2]] - moved[f[0]]);
                const Vec3 s = surface.normal(proposal[f[0]].face) + surface.normal(proposal[f[1]].face) +
                               surface.normal(proposal[f[2]].face);
                if (dot(n, s) > 0.2 * length(n) * length(s)) continue;
                for (const std::uint32_t v : f) {
                    if (back[v]) continue;
                    any = true;
                    back[v] = 1, moved[v] = position[v], proposal[v] = points[v];
                }
            }
            if (!any) break;
        }
        position.swap(moved);
        points.swap(proposal);
    }
}

}  // namespace mvw
