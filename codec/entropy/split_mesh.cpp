#include "codec/entropy/split_mesh.h"

#include "codec/mesh/half_edges.h"

namespace mvw {

SplitMesh::SplitMesh(const BaseMesh& mesh, std::vector<std::uint32_t> materials)
    : faces_(mesh.faces()), materials_(std::move(materials)), out_(mesh.vertex_count(), kNone) {
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        for (unsigned side = 0; side < 3; ++side) {
            const BaseMesh::Side twin = mesh.beyond(f, side);
            twins_.push_back(twin.face == kNone ? kNone : 3 * twin.face + twin.side);
        }
    for (std::uint32_t h = 0; h < twins_.size(); ++h)
        if (std::uint32_t& out = out_[origin(faces_, h)]; out == kNone || twins_[h] == kNone) out = h;
}

void SplitMesh::join(std::uint32_t h, std::uint32_t twin) {
    if (h != kNone) twins_[h] = twin;
    if (twin != kNone) twins_[twin] = h;
}

bool SplitMesh::ring(std::uint32_t v, VertexRing& out) const {
    out.neighbors = out.faces = 0;
    std::uint32_t h = out_[v];
    if (h == kNone) return false;
    do {
        if (out.faces == VertexRing::kMostFaces) return false;
        out.half_edge[out.faces++] = h;
        out.neighbor[out.neighbors++] = origin(faces_, next_half_edge(h));
        const std::uint32_t in = previous_half_edge(h);
        h = twins_[in];
        if (h == kNone) out.neighbor[out.neighbors++] = origin(faces_, in);
    } while (h != kNone && h != out_[v]);
    out.closed = h != kNone;
    return true;
}

bool SplitMesh::is_possible(const VertexRing& ring, const Split& split) {
    const std::size_t k = ring.faces;
    if (split.boundary) return !ring.closed && split.first <= k && split.taken == k - split.first;
    if (split.taken == 0) return false;
    return ring.closed ? split.first < k && split.taken < k : split.first + split.taken <= k;
}

std::pair<std::uint32_t, std::uint32_t> SplitMesh::beside(const VertexRing& ring, const Split& split, unsigned side) {
    const std::size_t k = ring.faces;
    const auto face = [&](std::size_t m) { return ring.half_edge[m % k] / 3; };
    if (side == 0)
        return {split.first > 0 || ring.closed ? face(split.first + k - 1) : kNone,
                split.taken > 0 ? face(split.first) : kNone};
    const std::size_t end = split.first + split.taken;
    return {end < k || ring.closed ? face(end) : kNone, face(end + k - 1)};
}

std::uint32_t SplitMesh::add_face(const Face& face, std::uint32_t material) {
    const auto f = static_cast<std::uint32_t>(faces_.size());
    faces_.push_back(face);
    if (!materials_.empty()) materials_.push_back(material);
    twins_.insert(twins_.end(), 3, kNone);
    return f;
}

void SplitMesh::split(const VertexRing& ring, const Split& split, const std::array<std::uint32_t, 2>& materials) {
    const std::uint32_t v = split.vertex, w = vertex_count();
    const std::size_t k = ring.faces, end = split.first + split.taken;
    // Half-edges that run to v at the two cuts, and those that run from it.
    const auto into = [&](std::size_t m) {  // from neighbour m to v, in the face before
        return m > 0 || ring.closed ? previous_half_edge(ring.half_edge[(m + k - 1) % k]) : kNone;
    };
    const auto from = [&](std::size_t m) { return m < k || ring.closed ? ring.half_edge[m % k] : kNone; };
    const std::uint32_t kept_in = into(split.first), taken_out = split.taken > 0 ? from(split.first) : kNone;
    const std::uint32_t taken_in = split.boundary ? kNone : into(end), kept_out = split.boundary ? kNone : from(end);
    for (std::size_t m = split.first; m < end; ++m) {
        const std::uint32_t h = ring.half_edge[m % k];
        faces_[h / 3][h % 3] = w;
    }
    out_.push_back(kNone);
    const std::uint32_t a = 3 * add_face({v, ring.neighbor[ring.place(split.first)], w}, materials[0]);
    join(a, kept_in);        // v to the neighbour
    join(a + 1, taken_out);  // the neighbour to w
    if (!split.boundary) {
        const std::uint32_t b = 3 * add_face({w, ring.neighbor[ring.place(end)], v}, materials[1]);
        join(b, taken_in);      // w to the neighbour
        join(b + 1, kept_out);  // the neighbour to v
        join(a + 2, b + 2);
    }
    // On boundaries the half-edge without a twin comes first.
    const auto set_out = [&](std::uint32_t h) {
        const std::uint32_t begin = h;
        while (twins_[h] != kNone) {
            h = next_half_edge(twins_[h]);
            if (h == begin) break;
        }
        out_[origin(faces_, h)] = h;
    };
    set_out(a);
    set_out(a + 2);
    set_out(a + 1);
    if (!split.boundary) set_out(a + 4);
}

}  // namespace mvw
