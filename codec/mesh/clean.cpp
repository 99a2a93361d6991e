#include "codec/mesh/clean.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "codec/mesh/half_edges.h"
#include "codec/mesh/number_positions.h"
#include "codec/mesh/semi_regular.h"
#include "codec/mesh/vertex_data.h"

namespace mvw {
namespace {

bool is_finite(const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// The mesh while it is repaired.
struct Soup {
    Mesh mesh;
    std::vector<std::uint32_t> place;  // V: number of each vertex's position, equal for bit-equal positions
    std::vector<Face> places;          // F: the faces in those numbers
    std::vector<std::uint32_t> mates;  // 3F: the side that each side is sewn to, or kNone

    [[nodiscard]] std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(mesh.positions.size()); }
    [[nodiscard]] std::uint32_t face_count() const { return static_cast<std::uint32_t>(mesh.faces.size()); }
    void sew(std::uint32_t g, std::uint32_t h) {
        mates[g] = h;
        mates[h] = g;
    }
    void open(std::uint32_t h) {
        if (mates[h] == kNone) return;
        mates[mates[h]] = kNone;
        mates[h] = kNone;
    }
    /// True where all sides of face f are sewn.
    [[nodiscard]] bool closed_in(std::uint32_t f) const {
        return mates[3 * f] != kNone && mates[3 * f + 1] != kNone && mates[3 * f + 2] != kNone;
    }
};

void remove_faces(Soup& soup, std::span<const std::uint8_t> doomed) {
    std::uint32_t kept = 0;
    for (std::uint32_t f = 0; f < soup.face_count(); ++f) {
        if (doomed[f]) continue;
        soup.mesh.faces[kept] = soup.mesh.faces[f];
        if (!soup.places.empty()) soup.places[kept] = soup.places[f];
        if (!soup.mesh.materials.empty()) soup.mesh.materials[kept] = soup.mesh.materials[f];
        ++kept;
    }
    soup.mesh.faces.resize(kept);
    if (!soup.places.empty()) soup.places.resize(kept);
    if (!soup.mesh.materials.empty()) soup.mesh.materials.resize(kept);
}

bool repeats_a_vertex(const Face& f) {
    return f[0] == f[1] || f[1] == f[2] || f[2] == f[0];
}

/// Marks the faces over the same three ids as another face: all but one of each such set; a face that `keep` holds
/// fast stays. Returns how many were marked.
template <typename Keep>
std::uint64_t mark_duplicates(std::span<const Face> faces, std::uint32_t id_count, std::vector<std::uint8_t>& doomed,
                              Keep keep) {
    struct Entry {
        std::uint32_t middle, high, face;
    };
    const auto sorted = [&](std::uint32_t f) {
        Face ids = faces[f];
        std::sort(ids.begin(), ids.end());
        return ids;
    };
    std::vector<std::uint32_t> bucket(std::size_t{id_count} + 1, 0);
    for (const Face& f : faces) ++bucket[*std::min_element(f.begin(), f.end()) + 1];
    std::partial_sum(bucket.begin(), bucket.end(), bucket.begin());
    std::vector<Entry> entries(faces.size());
    std::vector<std::uint32_t> fill(bucket.begin(), bucket.end() - 1);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const Face ids = sorted(f);
        entries[fill[ids[0]]++] = {ids[1], ids[2], f};
    }
    std::uint64_t marked = 0;
    for (std::uint32_t id = 0; id < id_count; ++id) {
        const auto first = entries.begin() + bucket[id], last = entries.begin() + bucket[id + 1];
        // Faces held fast come first in their set, so that it is the others that go.
        std::sort(first, last, [&](const Entry& a, const Entry& b) {
            if (a.middle != b.middle) return a.middle < b.middle;
            if (a.high != b.high) return a.high < b.high;
            return keep(a.face) != keep(b.face) ? keep(a.face) : a.face < b.face;
        });
        for (auto e = first; e != last; ++e) {
            const bool same = e != first && e[-1].middle == e->middle && e[-1].high == e->high;
            if (!same || keep(e->face) || doomed[e->face]) continue;
            doomed[e->face] = 1;
            ++marked;
        }
    }
    return marked;
}

/// Drops what no reading of the indices can keep: faces that repeat an index, are given twice or are not finite.
void drop_bad_faces(Soup& soup, CleanReport& report) {
    const Mesh& mesh = soup.mesh;
    std::vector<std::uint8_t> doomed(mesh.faces.size(), 0);
    for (std::uint32_t f = 0; f < soup.face_count(); ++f) {
        const Face& face = mesh.faces[f];
        const bool finite = is_finite(mesh.positions[face[0]]) && is_finite(mesh.positions[face[1]]) &&
                            is_finite(mesh.positions[face[2]]);
        doomed[f] = repeats_a_vertex(face) || !finite;
        report.degenerate_faces += doomed[f];
    }
    report.duplicate_faces +=
        mark_duplicates(mesh.faces, soup.vertex_count(), doomed, [](std::uint32_t) { return false; });
    remove_faces(soup, doomed);
}

/// Sews the two sides of every edge that exactly two faces share by index.
void sew_by_index(Soup& soup) {
    soup.mates.assign(3 * soup.mesh.faces.size(), kNone);
    const EdgeGroups edges = group_edges(soup.mesh.faces, soup.vertex_count());
    for (std::size_t g = 0; g < edges.size(); ++g)
        if (edges[g].size() == 2) soup.sew(edges[g][0], edges[g][1]);
}

/// Drops faces that welding would make degenerate or double, unless the indices close the surface around them: there
/// they hold it together.
void drop_faces_welded_away(Soup& soup, CleanReport& report) {
    std::vector<std::uint8_t> doomed(soup.mesh.faces.size(), 0);
    std::uint64_t dropped = 0;
    for (std::uint32_t f = 0; f < soup.face_count(); ++f) {
        doomed[f] = repeats_a_vertex(soup.places[f]) && !soup.closed_in(f);
        dropped += doomed[f];
    }
    report.degenerate_faces += dropped;
    const std::uint64_t doubles =
        mark_duplicates(soup.places, soup.vertex_count(), doomed, [&](std::uint32_t f) { return soup.closed_in(f); });
    report.duplicate_faces += doubles;
    if (dropped + doubles == 0) return;
    remove_faces(soup, doomed);
    sew_by_index(soup);
}

/// A face at an edge that many faces share, seen along the edge from its lower to its higher place.
struct Leaf {
    double angle;        // of the face around the edge, counter-clockwise
    bool backward;       // the face runs along the edge from higher to lower: its solid lies at larger angles
    std::uint32_t side;  // its half-edge

    /// At one angle a solid ends (forward) before the next begins.
    bool operator<(const Leaf& o) const {
        if (angle != o.angle) return angle < o.angle;
        return backward != o.backward ? o.backward : side < o.side;
    }
};

std::vector<Leaf> leaves_around(const Soup& soup, std::span<const std::uint32_t> sides) {
    std::vector<Leaf> leaves;
    const auto corner = [&](std::uint32_t h) { return soup.mesh.positions[origin(soup.mesh.faces, h)]; };
    const bool first_backward = origin(soup.places, sides[0]) > origin(soup.places, next_half_edge(sides[0]));
    Vec3 from = corner(sides[0]), to = corner(next_half_edge(sides[0]));
    if (first_backward) std::swap(from, to);
    const Vec3 axis = normalized(to - from);
    Vec3 x_axis, y_axis;
    for (const std::uint32_t side : sides) {
        const Vec3 arm = corner(previous_half_edge(side)) - from;
        const Vec3 across = arm - axis * dot(arm, axis);
        if (squared_length(x_axis) == 0) {
            x_axis = normalized(across);
            y_axis = cross(axis, x_axis);
        }
        const bool backward = origin(soup.places, side) > origin(soup.places, next_half_edge(side));
        leaves.push_back({std::atan2(dot(across, y_axis), dot(across, x_axis)), backward, side});
    }
    std::sort(leaves.begin(), leaves.end());
    return leaves;
}

/// Joins each face where a solid begins with the next free one where a solid ends, as brackets match: the closed parts
/// of an assembly stay apart. The angles are a circle, so the row is gone through twice.
void sew_wedges(Soup& soup, std::span<const Leaf> leaves) {
    std::vector<std::uint32_t> open;
    for (int round = 0; round < 2; ++round) {
        for (const Leaf& leaf : leaves) {
            if (soup.mates[leaf.side] != kNone) continue;
            if (leaf.backward) {
                if (round == 0) open.push_back(leaf.side);
            } else if (!open.empty() && open.back() / 3 != leaf.side / 3) {
                soup.sew(open.back(), leaf.side);
                open.pop_back();
            }
        }
    }
}

/// Joins the two faces that continue each other best, as long as two are left that run against each other: for sheets
/// with fins, where no solid tells what belongs together.
void sew_flattest(Soup& soup, std::span<const Leaf> leaves) {
    for (;;) {
        const Leaf *best_a = nullptr, *best_b = nullptr;
        double best = -1;
        for (const Leaf& a : leaves)
            for (const Leaf& b : leaves) {
                if (!a.backward || b.backward || a.side / 3 == b.side / 3) continue;
                if (soup.mates[a.side] != kNone || soup.mates[b.side] != kNone) continue;
                const double flatness = 1 - std::cos(a.angle - b.angle);
                if (flatness > best) best = flatness, best_a = &a, best_b = &b;
            }
        if (best_a == nullptr) return;
        soup.sew(best_a->side, best_b->side);
    }
}

/// Beyond this many faces at one edge only wedges are matched: the search for the flattest pair is cubic.
constexpr std::size_t kMaxFlattest = 64;

/// Sews what the indices left open where sides lie at equal positions.
void sew_by_position(Soup& soup, CleanReport& report) {
    std::vector<std::uint8_t> open(soup.mates.size());
    for (std::uint32_t h = 0; h < open.size(); ++h)
        open[h] = soup.mates[h] == kNone && origin(soup.places, h) != origin(soup.places, next_half_edge(h));
    const EdgeGroups edges = group_edges(soup.places, soup.vertex_count(), open);
    for (std::size_t g = 0; g < edges.size(); ++g) {
        const auto sides = edges[g];
        if (sides.size() == 1) continue;
        if (sides.size() == 2) {
            if (sides[0] / 3 != sides[1] / 3) soup.sew(sides[0], sides[1]);
            continue;
        }
        ++report.split_edges;
        const std::vector<Leaf> leaves = leaves_around(soup, sides);
        const auto backward = std::count_if(leaves.begin(), leaves.end(), [](const Leaf& l) { return l.backward; });
        if (2 * static_cast<std::size_t>(backward) == leaves.size() || leaves.size() > kMaxFlattest)
            sew_wedges(soup, leaves);
        else
            sew_flattest(soup, leaves);
    }
}

/// True where two sewn sides run along their edge in one direction, so that one of the faces must be turned. A side
/// of no length has equal places at its ends: there the indices tell.
bool run_together(const Soup& soup, std::uint32_t g, std::uint32_t h) {
    const bool has_length = origin(soup.places, g) != origin(soup.places, next_half_edge(g));
    const std::vector<Face>& ids = has_length ? soup.places : soup.mesh.faces;
    return origin(ids, g) == origin(ids, h);
}

constexpr std::uint8_t kUnseen = 2;

/// A component as it was gone through from one face.
struct Turns {
    std::vector<std::uint32_t> faces;  // in the order they were met
    std::vector<std::uint32_t> cuts;   // one side of each edge whose faces cannot agree
};

/// Says in `turned` which faces of the seed's component to reverse so that sewn faces agree, breadth first; as_given:
/// through all edges whose faces agree already before any other, so that cuts lie where the input turns over.
Turns spread_turns(const Soup& soup, std::uint32_t seed, bool as_given, std::vector<std::uint8_t>& turned) {
    Turns out;
    out.faces.push_back(seed);
    turned[seed] = 0;
    std::vector<std::uint32_t> later;
    const auto cross_side = [&](std::uint32_t h, bool together) {
        const std::uint32_t mate = soup.mates[h];
        const std::uint8_t wanted = turned[h / 3] ^ static_cast<std::uint8_t>(together);
        if (turned[mate / 3] == kUnseen) {
            turned[mate / 3] = wanted;
            out.faces.push_back(mate / 3);
        } else if (turned[mate / 3] != wanted && h < mate) {
            out.cuts.push_back(h);
        }
    };
    for (std::size_t i = 0, k = 0; i < out.faces.size() || k < later.size();) {
        if (i == out.faces.size()) {
            cross_side(later[k++], true);
            continue;
        }
        const std::uint32_t f = out.faces[i++];
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
            if (soup.mates[h] == kNone) continue;
            const bool together = run_together(soup, h, soup.mates[h]);
            if (together && as_given)
                later.push_back(h);
            else
                cross_side(h, together);
        }
    }
    return out;
}

/// Which faces to reverse so that sewn faces agree; sides whose faces cannot agree are opened, few rather than many.
std::vector<std::uint8_t> choose_turns(Soup& soup, CleanReport& report) {
    std::vector<std::uint8_t> turned(soup.mesh.faces.size(), kUnseen);
    for (std::uint32_t seed = 0; seed < soup.face_count(); ++seed) {
        if (turned[seed] != kUnseen) continue;
        Turns turns = spread_turns(soup, seed, true, turned);
        if (!turns.cuts.empty()) {
            // Large parts that lie the wrong way and touch others rightly in a few places are better turned.
            std::vector<std::uint8_t> as_given;
            for (const std::uint32_t f : turns.faces) as_given.push_back(std::exchange(turned[f], kUnseen));
            Turns nearest = spread_turns(soup, seed, false, turned);
            if (nearest.cuts.size() < turns.cuts.size())
                turns = std::move(nearest);
            else
                for (std::size_t i = 0; i < as_given.size(); ++i) turned[turns.faces[i]] = as_given[i];
        }
        for (const std::uint32_t h : turns.cuts) soup.open(h);
        report.cut_edges += turns.cuts.size();
        const auto reversed = static_cast<std::size_t>(
            std::count_if(turns.faces.begin(), turns.faces.end(), [&](std::uint32_t f) { return turned[f] != 0; }));
        const bool most = 2 * reversed > turns.faces.size();
        if (most)
            for (const std::uint32_t f : turns.faces) turned[f] ^= 1;
        report.turned_faces += most ? turns.faces.size() - reversed : reversed;
    }
    return turned;
}

/// Reverses faces by exchanging their corners 1 and 2, which exchanges sides 0 and 2.
void turn_faces(Soup& soup, std::span<const std::uint8_t> turned) {
    const auto slot = [&](std::uint32_t h) { return turned[h / 3] ? h - h % 3 + (2 - h % 3) : h; };
    std::vector<std::uint32_t> mates(soup.mates.size(), kNone);
    for (std::uint32_t h = 0; h < mates.size(); ++h)
        if (soup.mates[h] != kNone) mates[slot(h)] = slot(soup.mates[h]);
    soup.mates = std::move(mates);
    for (std::uint32_t f = 0; f < soup.face_count(); ++f) {
        if (!turned[f]) continue;
        std::swap(soup.mesh.faces[f][1], soup.mesh.faces[f][2]);
        std::swap(soup.places[f][1], soup.places[f][2]);
    }
}

/// Faces in fan numbers: what the mesh would be now.
std::vector<Face> faces_of_fans(const Fans& fans) {
    std::vector<Face> faces(fans.of_corner.size() / 3);
    for (std::uint32_t c = 0; c < fans.of_corner.size(); ++c) faces[c / 3][c % 3] = fans.of_corner[c];
    return faces;
}

/// Removes faces two corners of which have become one vertex, and sews the neighbours across them.
bool collapse_faces(Soup& soup, std::span<const Face> fan_faces, CleanReport& report) {
    std::vector<std::uint8_t> doomed(fan_faces.size(), 0);
    std::uint64_t count = 0;
    for (std::uint32_t f = 0; f < fan_faces.size(); ++f) {
        if (!repeats_a_vertex(fan_faces[f])) continue;
        std::uint32_t gone = 3 * f;  // the side whose two corners are one vertex
        while (fan_faces[f][gone % 3] != fan_faces[f][next_half_edge(gone) % 3]) ++gone;
        const std::uint32_t g = next_half_edge(gone), h = previous_half_edge(gone);
        const std::uint32_t a = soup.mates[g], b = soup.mates[h];
        for (const std::uint32_t side : {gone, g, h}) soup.open(side);
        if (a != kNone && b != kNone && a / 3 != b / 3 && a / 3 != f && b / 3 != f) soup.sew(a, b);
        doomed[f] = 1;
        ++count;
    }
    if (count == 0) return false;
    report.degenerate_faces += count;
    std::vector<std::uint32_t> moved(fan_faces.size(), kNone), mates;
    for (std::uint32_t f = 0, kept = 0; f < fan_faces.size(); ++f)
        if (!doomed[f]) moved[f] = kept++;
    for (std::uint32_t h = 0; h < soup.mates.size(); ++h)
        if (!doomed[h / 3])
            mates.push_back(soup.mates[h] == kNone ? kNone : 3 * moved[soup.mates[h] / 3] + soup.mates[h] % 3);
    soup.mates = std::move(mates);
    remove_faces(soup, doomed);
    return true;
}

/// Opens edges that would have the same two vertices as another: with both open, their faces come apart or are sewn
/// the other way. Where nothing is left to open at such an edge its faces are cut out (a lone triangle is a manifold).
bool open_repeated_edges(Soup& soup, std::span<const Face> fan_faces, std::uint32_t fan_count, CleanReport& report) {
    const EdgeGroups edges = group_edges(fan_faces, fan_count);
    bool changed = false;
    for (std::size_t g = 0; g < edges.size(); ++g) {
        const auto sides = edges[g];
        const bool two = sides.size() == 2 && origin(fan_faces, sides[0]) != origin(fan_faces, sides[1]);
        if (sides.size() == 1) continue;
        if (two) {
            // Two open sides over the same two vertices are one edge, sewn or not.
            if (soup.mates[sides[0]] == kNone && soup.mates[sides[1]] == kNone) soup.sew(sides[0], sides[1]);
            continue;
        }
        const bool sewn =
            std::any_of(sides.begin(), sides.end(), [&](std::uint32_t h) { return soup.mates[h] != kNone; });
        for (const std::uint32_t h : sides) {
            soup.open(h);
            if (sewn) continue;
            soup.open(next_half_edge(h));
            soup.open(previous_half_edge(h));
        }
        report.split_edges += !sewn || sides.size() > 2;
        changed = true;
    }
    return changed;
}

/// Opens what still is no manifold until nothing is; every round opens a sewn edge or removes a face.
Fans settle(Soup& soup, CleanReport& report) {
    for (;;) {
        Fans fans = find_fans(soup.mates);
        const std::vector<Face> faces = faces_of_fans(fans);
        if (collapse_faces(soup, faces, report)) continue;
        if (!open_repeated_edges(soup, faces, fans.count, report)) return fans;
    }
}

/// One vertex for each fan, in the order of the first vertex that it joins.
Mesh build(const Soup& soup, const Fans& fans, CleanReport& report) {
    const Mesh& in = soup.mesh;
    std::vector<std::uint32_t> first(fans.count, kNone);  // lowest input vertex of each fan
    for (std::uint32_t c = 0; c < fans.of_corner.size(); ++c)
        first[fans.of_corner[c]] = std::min(first[fans.of_corner[c]], origin(in.faces, c));
    std::vector<std::uint32_t> order(fans.count), number(fans.count);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return first[a] < first[b]; });

    // Pairs of (fan, input vertex): a fan of many input vertices welded them, an input vertex in many fans was split.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> uses(fans.of_corner.size());
    for (std::uint32_t c = 0; c < uses.size(); ++c) uses[c] = {fans.of_corner[c], origin(in.faces, c)};
    std::sort(uses.begin(), uses.end());
    uses.erase(std::unique(uses.begin(), uses.end()), uses.end());

    Mesh out;
    out.positions.reserve(fans.count);
    std::vector<VertexShare> joined;
    for (std::uint32_t i = 0; i < fans.count; ++i) {
        const std::uint32_t fan = order[i];
        number[fan] = i;
        out.positions.push_back(in.positions[first[fan]]);
        joined.clear();
        for (auto use = std::ranges::lower_bound(uses, std::pair{fan, 0u}); use != uses.end() && use->first == fan;
             ++use)
            joined.push_back({use->second, 1});
        for (VertexShare& share : joined) share.weight = 1 / static_cast<double>(joined.size());
        append_vertex_data(in, joined, out);
    }
    out.faces = faces_of_fans(fans);
    for (Face& f : out.faces)
        for (std::uint32_t& v : f) v = number[v];
    out.materials = in.materials;

    std::vector<std::uint8_t> used(in.positions.size(), 0);
    for (const auto& [fan, vertex] : uses) used[vertex] = 1;
    const auto inputs = static_cast<std::uint64_t>(std::ranges::count(used, 1));
    report.welded_vertices += uses.size() - fans.count;
    report.split_vertices += uses.size() - inputs;
    return out;
}

}  // namespace

Mesh clean(Mesh mesh, CleanReport& report) {
    std::vector<std::uint8_t> used(mesh.positions.size(), 0);
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) used[v] = 1;
    report.unused_vertices += static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 0));

    Soup soup{std::move(mesh), {}, {}, {}};
    drop_bad_faces(soup, report);
    sew_by_index(soup);
    soup.place = number_positions(soup.mesh.positions);
    for (const Face& f : soup.mesh.faces) soup.places.push_back({soup.place[f[0]], soup.place[f[1]], soup.place[f[2]]});
    drop_faces_welded_away(soup, report);
    sew_by_position(soup, report);
    turn_faces(soup, choose_turns(soup, report));
    const Fans fans = settle(soup, report);
    return build(soup, fans, report);
}

}  // namespace mvw
