#include "codec/remesh/cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "codec/measure/surface_index.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/parallel.h"
#include "codec/remesh/relax.h"
#include "codec/remesh/rings.h"

namespace mvw {

namespace {

constexpr unsigned kRounds = 5;
constexpr unsigned kSweeps = 10;       // of relaxation in each
constexpr unsigned kFirstDrawing = 2;  // round: before, areas alone may bring points to where they lack
constexpr unsigned kRoundsOfMissed = 2;
constexpr int kRoom = 6;                // edges around a drawn point that relax with it
constexpr int kReach = 3;               // edges around a point, within which the most missed counts for it
constexpr double kPower = -0.5;         // of what is missed over its RMS, for the area aimed at, ...
constexpr double kLeastArea = 1.0 / 8;  // ... which becomes no smaller ...
constexpr double kMostArea = 2;         // ... or larger than that, times what it was
constexpr double kExact = 1e-7;         // of the diagonal
constexpr double kMissed = 3;           // times the RMS distance, ...
constexpr double kMissedOfEdges = 0.2;  // ... and of the mean length of the edges there: a place that takes a point

/// Takes the greatest value within so many edges to each vertex of `triangles`.
template <typename Value>
void spread(const std::vector<Face>& triangles, int edges, std::vector<Value>& values) {
    std::vector<Value> before;
    for (int step = 0; step < edges; ++step) {
        before = values;
        for (const Face& t : triangles) {
            const Value most = std::max({before[t[0]], before[t[1]], before[t[2]]});
            for (const std::uint32_t v : t) values[v] = std::max(values[v], most);
        }
    }
}

/// What points there are for, and how much of it their triangles miss.
class Coverage {
 public:
    Coverage(const Mesh& mesh, const SurfaceWalk& surface, const std::vector<Face>& triangles, std::size_t points,
             unsigned threads)
        : mesh_(mesh),
          surface_(surface),
          triangles_(triangles),
          threads_(threads),
          diagonal_(bounding_box(mesh).diagonal()),
          around_vertex_(mesh.faces, mesh.positions.size()),
          around_point_(triangles, points) {
        face_of_.assign(mesh.positions.size(), kNone);
        on_line_.assign(mesh.positions.size(), 0);
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t v = mesh.faces[f][k], next = mesh.faces[f][(k + 1) % 3];
                face_of_[v] = f;
                if (surface.stops_at(3 * f + k)) on_line_[v] = on_line_[next] = 1;
            }
    }

    /// Measures what points (V) miss.
    void look(const std::vector<FacePoint>& points) {
        positions_.clear();
        for (const FacePoint& p : points) positions_.push_back(surface_.position(p));
        find_nearest(points);
        measure();
    }

    /// Whether what is missed is hardly more than what rounding loses.
    [[nodiscard]] bool is_exact() const { return rms_ <= kExact * diagonal_; }

    /// Factors (V) for the areas of the triangles around each point.
    [[nodiscard]] std::vector<double> area_factors() const {
        std::vector<double> most(positions_.size(), 0);
        for (std::uint32_t v = 0; v < nearest_.size(); ++v)
            if (nearest_[v] != kNone) most[nearest_[v]] = std::max(most[nearest_[v]], missed_[v]);
        spread(triangles_, kReach, most);
        for (double& m : most) m = m > 0 ? std::clamp(std::pow(m / rms_, kPower), kLeastArea, kMostArea) : kMostArea;
        return most;
    }

    /// Moves points (V) to the places missed most, the most missed first, and flags them in `held` (V); those flagged
    /// before do not move. Returns whether any did.
    bool draw(std::vector<FacePoint>& points, std::vector<std::uint8_t>& held) const {
        std::vector<std::uint32_t> places;
        for (std::uint32_t v = 0; v < missed_.size(); ++v)
            if (missed_[v] > kMissed * rms_ && is_highest(v)) places.push_back(v);
        std::ranges::stable_sort(places, std::greater<>{}, [&](std::uint32_t v) { return missed_[v]; });
        bool any = false;
        for (const std::uint32_t v : places) {
            const std::uint32_t p = nearest_[v];
            if (held[p] != 0 || missed_[v] < kMissedOfEdges * mean_edge(p)) continue;
            const Face& f = mesh_.faces[face_of_[v]];
            points[p] = {face_of_[v], {}};
            points[p].weight[static_cast<std::size_t>(std::find(f.begin(), f.end(), v) - f.begin())] = 1;
            held[p] = 1;
            any = true;
        }
        return any;
    }

 private:
    /// The point that is nearest to each vertex of the mesh along its edges (Dijkstra 1959, from all points at once),
    /// but not across lines. Those on lines have none: what the triangles miss there is the lines' bends, which points
    /// beside them do not mend.
    void find_nearest(const std::vector<FacePoint>& points) {
        using Reached = std::pair<double, std::uint32_t>;  // distance, vertex of the mesh
        std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
        std::vector<double> distance(mesh_.positions.size(), HUGE_VAL);
        nearest_.assign(mesh_.positions.size(), kNone);
        const auto reach = [&](std::uint32_t v, double d, std::uint32_t point) {
            if (d >= distance[v]) return;
            distance[v] = d;
            nearest_[v] = point;
            next.emplace(d, v);
        };
        for (std::uint32_t p = 0; p < points.size(); ++p)
            for (const std::uint32_t v : mesh_.faces[points[p].face])
                reach(v, length(mesh_.positions[v] - positions_[p]), p);
        while (!next.empty()) {
            const auto [d, v] = next.top();
            next.pop();
            if (d > distance[v] || on_line_[v] != 0) continue;
            for (const RingTriangle& t : around_vertex_.at(v))
                for (const std::uint32_t w : {t.first, t.second})
                    reach(w, d + length(mesh_.positions[w] - mesh_.positions[v]), nearest_[v]);
        }
        for (std::size_t v = 0; v < nearest_.size(); ++v)
            if (on_line_[v] != 0) nearest_[v] = kNone;
    }

    void measure() {
        missed_.assign(mesh_.positions.size(), 0);
        parallel_slices(missed_.size(), threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                if (nearest_[v] != kNone) missed_[v] = distance(mesh_.positions[v], nearest_[v]);
        });
        double sum = 0;
        for (const double m : missed_) sum += m * m;
        const auto count = missed_.size() - static_cast<std::size_t>(std::ranges::count(nearest_, kNone));
        rms_ = count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
    }

    /// From p to the triangles around a point, or around a neighbour, as long as those are nearer: other sheets of the
    /// surface do not count, however near.
    [[nodiscard]] double distance(const Vec3& p, std::uint32_t point) const {
        double least = HUGE_VAL;
        for (std::uint32_t from = kNone; point != from;) {
            from = point;
            for (const RingTriangle& t : around_point_.at(from)) {
                const std::array<std::uint32_t, 3> at{from, t.first, t.second};
                const Vec3 &a = positions_[at[0]], &b = positions_[at[1]], &c = positions_[at[2]];
                const std::array<double, 3> weight = closest_on_triangle(p, a, b, c);
                const double d = squared_length(a * weight[0] + b * weight[1] + c * weight[2] - p);
                if (d >= least) continue;
                least = d;
                point = at[static_cast<std::size_t>(std::ranges::max_element(weight) - weight.begin())];
            }
        }
        return std::sqrt(least);
    }

    /// Mean length of the edges between a point and its neighbours.
    [[nodiscard]] double mean_edge(std::uint32_t point) const {
        double sum = 0;
        for (const RingTriangle& t : around_point_.at(point))
            sum += length(positions_[t.first] - positions_[point]) + length(positions_[t.second] - positions_[point]);
        return sum / (2 * std::max(1.0, double(around_point_.at(point).size())));
    }

    /// Whether no neighbour of v is missed by more.
    [[nodiscard]] bool is_highest(std::uint32_t v) const {
        return std::ranges::all_of(around_vertex_.at(v), [&](const RingTriangle& t) {
            return missed_[t.first] <= missed_[v] && missed_[t.second] <= missed_[v];
        });
    }

    const Mesh& mesh_;
    const SurfaceWalk& surface_;
    const std::vector<Face>& triangles_;
    const unsigned threads_;
    const double diagonal_;               // of the mesh
    const Rings around_vertex_;           // of the mesh
    const Rings around_point_;            // of the triangles
    std::vector<std::uint32_t> face_of_;  // of each vertex of the mesh, one; kNone: none
    std::vector<std::uint8_t> on_line_;   // flags of the mesh's vertices where walks stop
    std::vector<Vec3> positions_;         // of the points
    std::vector<std::uint32_t> nearest_;  // point for each vertex of the mesh; kNone: none, or it is on a line
    std::vector<double> missed_;          // distance of each vertex of the mesh that has a point; else 0
    double rms_ = 0;                      // of these
};

}  // namespace

void relax_to_cover(const Mesh& mesh, const SurfaceWalk& surface, const std::vector<Face>& triangles,
                    const std::vector<std::uint8_t>& fixed, unsigned threads, std::vector<FacePoint>& points) {
    Coverage coverage(mesh, surface, triangles, points.size(), threads);
    std::vector<std::uint8_t> held = fixed;
    std::vector<double> factors;
    for (unsigned round = 0; round < kRounds; ++round) {
        if (round > 0) {
            coverage.look(points);
            factors.clear();
            if (!coverage.is_exact()) factors = coverage.area_factors();
            if (round >= kFirstDrawing) coverage.draw(points, held);
        }
        relax(surface, triangles, held, {kSweeps, threads, factors}, points);
    }
}

bool cover_missed(const Mesh& mesh, const SurfaceWalk& surface, const std::vector<Face>& triangles,
                  const std::vector<std::uint8_t>& fixed, unsigned threads, std::vector<FacePoint>& points) {
    Coverage coverage(mesh, surface, triangles, points.size(), threads);
    std::vector<std::uint8_t> held = fixed;
    for (unsigned round = 0; round < kRoundsOfMissed; ++round) {
        coverage.look(points);
        if (!coverage.draw(points, held)) return round > 0;
        std::vector<std::uint8_t> room(points.size(), 0);
        for (std::size_t p = 0; p < room.size(); ++p) room[p] = held[p] != 0 && fixed[p] == 0 ? 1 : 0;
        spread(triangles, kRoom, room);
        std::vector<std::uint8_t> still = held;
        for (std::size_t p = 0; p < still.size(); ++p)
            if (room[p] == 0) still[p] = 1;
        relax(surface, triangles, still, {kSweeps, threads, {}}, points);
    }
    return true;
}

}  // namespace mvw
