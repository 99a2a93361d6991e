#include "codec/remesh/prepare.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "codec/mesh/semi_regular.h"
#include "codec/mesh/vertex_data.h"

namespace mvw {

namespace {

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

/// Appends the triangles of `face` with a middle vertex m[s] (or kNone) on each side s.
void append_split(const Face& face, const std::array<std::uint32_t, 3>& m, std::vector<Face>& out) {
    std::vector<std::uint32_t> rim;
    std::size_t first_middle = 0;
    for (std::size_t s = 0; s < 3; ++s) {
        rim.push_back(face[s]);
        if (m[s] == kNone) continue;
        first_middle = rim.size();
        rim.push_back(m[s]);
    }
    // A fan from a middle vertex: no triangle has all its corners on one side.
    const std::size_t n = rim.size();
    for (std::size_t k = 1; k + 1 < n; ++k)
        out.push_back({rim[first_middle], rim[(first_middle + k) % n], rim[(first_middle + k + 1) % n]});
}

}  // namespace

SplitMesh split_ears(const Mesh& mesh) {
    std::vector<std::uint32_t> fan(mesh.positions.size(), 0);
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) ++fan[v];
    std::unordered_map<std::uint64_t, std::uint32_t> middles;
    SplitMesh split{mesh, {}};
    Mesh& out = split.mesh;
    for (const Face& f : mesh.faces) {
        for (std::size_t s = 0; s < 3; ++s) {
            if (fan[f[s]] != 1) continue;
            const std::uint32_t a = f[(s + 1) % 3], b = f[(s + 2) % 3];
            if (!middles.emplace(edge_key(a, b), static_cast<std::uint32_t>(out.positions.size())).second) continue;
            out.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.5);
            append_vertex_data(mesh, std::array{VertexShare{a, 0.5}, VertexShare{b, 0.5}}, out);
        }
    }
    split.first_face.resize(mesh.faces.size());
    if (middles.empty()) {
        std::iota(split.first_face.begin(), split.first_face.end(), 0u);
        return split;
    }
    out.faces.clear();
    out.materials.clear();
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Face& face = mesh.faces[f];
        split.first_face[f] = static_cast<std::uint32_t>(out.faces.size());
        std::array<std::uint32_t, 3> m{kNone, kNone, kNone};
        for (std::size_t s = 0; s < 3; ++s)
            if (const auto it = middles.find(edge_key(face[s], face[(s + 1) % 3])); it != middles.end())
                m[s] = it->second;
        if (m == std::array<std::uint32_t, 3>{kNone, kNone, kNone})
            out.faces.push_back(face);
        else
            append_split(face, m, out.faces);
        if (!mesh.materials.empty()) out.materials.resize(out.faces.size(), mesh.materials[f]);
    }
    return split;
}

}  // namespace mvw
