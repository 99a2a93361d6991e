#include "codec/remesh/iron.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/mesh/half_edges.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/rings.h"

namespace mvw {

namespace {

constexpr int kMaxRounds = 40;
constexpr double kFoldCosine = -0.6;  // between two triangles' normals: below, they fold; rounding makes it worse
constexpr double kFold = 1;           // what a fold counts beside how far it leans
constexpr double kNoArea = 1e-6;      // of the squared length of a triangle's sides, its doubled area
constexpr std::array kShares{1.0, 0.5, 0.25};  // of the way to the neighbours' mean
constexpr double kMostWay = 0.5;               // of the mean length of a vertex' edges
constexpr double kLeastGain = 1e-3;

class Ironing {
 public:
    Ironing(const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed, std::vector<Vec3>& positions)
        : triangles_(triangles),
          fixed_(fixed),
          positions_(positions),
          start_(positions),
          rings_(triangles, positions.size()),
          mates_(triangles.size() * 3, kNone) {
        const EdgeGroups groups = group_edges(triangles, static_cast<std::uint32_t>(positions.size()));
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (groups[g].size() == 2) mates_[groups[g][0]] = groups[g][1], mates_[groups[g][1]] = groups[g][0];
        for (std::uint32_t t = 0; t < triangles.size(); ++t) normals_.push_back(normal(t));
        for (std::uint32_t t = 0; t < triangles.size(); ++t) mark(t);
    }

    /// Moves what is marked, and marks anew. False where nothing has moved.
    bool round() {
        std::vector<std::uint32_t> marked;
        marked.swap(marked_);
        std::sort(marked.begin(), marked.end());
        marked.erase(std::unique(marked.begin(), marked.end()), marked.end());
        bool any = false;
        for (const std::uint32_t v : marked) {
            any |= improve(v);
            for (const RingTriangle& t : rings_.at(v)) mark(t.triangle);
        }
        return any;
    }

    [[nodiscard]] std::size_t moved() const {
        std::size_t count = 0;
        for (std::size_t v = 0; v < start_.size(); ++v) count += positions_[v] == start_[v] ? 0 : 1;
        return count;
    }

 private:
    /// Unit normal, zero where there is no area to speak of.
    [[nodiscard]] Vec3 normal(std::uint32_t t) const {
        const Face& f = triangles_[t];
        const Vec3 a = positions_[f[1]] - positions_[f[0]], b = positions_[f[2]] - positions_[f[0]];
        const Vec3 n = cross(a, b);
        const double sides = squared_length(a) + squared_length(b) + squared_length(b - a);
        return squared_length(n) > kNoArea * kNoArea * sides * sides ? normalized(n) : Vec3{};
    }
    [[nodiscard]] double badness(std::uint32_t h) const {
        if (mates_[h] == kNone) return 0;
        const Vec3 &a = normals_[h / 3], &b = normals_[mates_[h] / 3];
        if (squared_length(a) == 0 || squared_length(b) == 0) return 2 * kFold;
        const double cosine = dot(a, b);
        return cosine < kFoldCosine ? kFold + kFoldCosine - cosine : 0;
    }
    void mark(std::uint32_t t) {
        for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
            if (badness(h) == 0) continue;
            for (const std::uint32_t side : {h, mates_[h]})
                for (const std::uint32_t v : triangles_[side / 3])
                    if (fixed_[v] == 0) marked_.push_back(v);
        }
    }
    [[nodiscard]] double badness_around(std::uint32_t v) const {
        double sum = 0;
        for (const RingTriangle& t : rings_.at(v))
            for (std::uint32_t h = 3 * t.triangle; h < 3 * t.triangle + 3; ++h) sum += badness(h);
        return sum;
    }
    void move(std::uint32_t v, const Vec3& to) {
        positions_[v] = to;
        for (const RingTriangle& t : rings_.at(v)) normals_[t.triangle] = normal(t.triangle);
    }
    bool improve(std::uint32_t v) {
        const double before = badness_around(v);
        if (before == 0) return false;
        const Vec3 here = positions_[v];
        Vec3 mean;
        double lengths = 0, count = 0;
        for (const RingTriangle& t : rings_.at(v))
            for (const std::uint32_t u : {t.first, t.second}) {
                mean += positions_[u];
                lengths += length(positions_[u] - here);
                ++count;
            }
        mean = mean / count;
        Vec3 best = here;
        double least = before * (1 - kLeastGain);
        for (const double share : kShares) {
            const Vec3 there = here + (mean - here) * share;
            if (length(there - start_[v]) > kMostWay * lengths / count) continue;
            move(v, there);
            const double badness = badness_around(v);
            if (badness >= least) continue;
            least = badness;
            best = there;
        }
        move(v, best);
        return !(best == here);
    }

    const std::vector<Face>& triangles_;
    const std::vector<std::uint8_t>& fixed_;
    std::vector<Vec3>& positions_;
    const std::vector<Vec3> start_;
    const Rings rings_;
    std::vector<std::uint32_t> mates_;   // of each half-edge
    std::vector<Vec3> normals_;          // of each triangle
    std::vector<std::uint32_t> marked_;  // vertices to look at
};

}  // namespace

std::size_t iron(const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
                 std::vector<Vec3>& positions) {
    Ironing ironing(triangles, fixed, positions);
    for (int round = 0; round < kMaxRounds; ++round)
        if (!ironing.round()) break;
    return ironing.moved();
}

}  // namespace mvw
