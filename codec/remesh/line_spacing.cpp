#include "codec/remesh/line_spacing.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "codec/remesh/resample.h"

namespace mvw {

namespace {

constexpr double kMostCut = 1e-4;         // of the diagonal
constexpr std::uint32_t kFineness = 16;   // places to choose from for each point of an edge
constexpr std::uint32_t kLeastSteps = 2;  // of these, between points
constexpr std::size_t kPointsAtOnce = 1u << 20;

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const double squared = squared_length(ab);
    const double t = squared > 0 ? std::clamp(dot(p - a, ab) / squared, 0.0, 1.0) : 0.0;
    return length(a + ab * t - p);
}

/// How far a line is from the polygon of every kFineness-th of its points.
double most_cut(std::span<const Vec3> line) {
    double most = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const std::size_t from = std::min(i / kFineness * kFineness, line.size() - 1 - kFineness);
        most = std::max(most, distance_to_segment(line[i], line[from], line[from + kFineness]));
    }
    return most;
}

double angle(const Vec3& a, const Vec3& b) {
    return std::atan2(length(cross(a, b)), dot(a, b));
}

/// For each place of the line the share of its points that shall lie before it, from 0 to 1.
std::vector<double> shares(std::span<const Vec3> line) {
    std::vector<double> length_until{0}, turn_until{0};
    for (std::size_t i = 1; i < line.size(); ++i) {
        length_until.push_back(length_until.back() + length(line[i] - line[i - 1]));
        const bool inner = i + 1 < line.size();
        turn_until.push_back(turn_until.back() + (inner ? angle(line[i] - line[i - 1], line[i + 1] - line[i]) : 0));
    }
    std::vector<double> out;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const double by_length = length_until.back() > 0 ? length_until[i] / length_until.back() : 0;
        // A turn draws points from both of its sides.
        const double turn = (turn_until[i] + turn_until[i == 0 ? 0 : i - 1]) / 2;
        const double by_turn = turn_until.back() > 0 ? turn / turn_until.back() : by_length;
        out.push_back((by_length + by_turn) / 2);
    }
    return out;
}

/// The places of n + 1 points, the first and the last at the ends.
std::vector<std::uint32_t> places(const std::vector<double>& share, std::uint32_t n) {
    std::vector<std::uint32_t> out{0};
    const auto last = static_cast<std::uint32_t>(share.size() - 1);
    for (std::uint32_t t = 1; t < n; ++t) {
        const auto at = std::lower_bound(share.begin(), share.end(), static_cast<double>(t) / n) - share.begin();
        out.push_back(
            std::clamp(static_cast<std::uint32_t>(at), out.back() + kLeastSteps, last - kLeastSteps * (n - t)));
    }
    out.push_back(last);
    return out;
}

/// Base edges on boundaries and creases.
std::vector<std::uint32_t> line_edges(const SemiRegularMesh& part) {
    std::vector<std::uint32_t> edges;
    for (std::uint32_t b = 0; b < part.base.edge_count(); ++b)
        if (part.base.edges()[b].face[1] == kNone || (!part.creases.empty() && part.creases[b] != 0))
            edges.push_back(b);
    return edges;
}

}  // namespace

void space_lines(const Mesh& mesh, const SelfParameterization& parameterization, const SemiRegularMesh& part,
                 const std::vector<std::uint32_t>& face_ids, unsigned threads, std::vector<FacePoint>& points) {
    const std::uint32_t n = 1u << part.levels, fine = n * kFineness;
    const auto on_edge = [&](const BaseEdge& e, std::uint32_t place) {
        FacePoint p{face_ids[e.face[0]], {0, 0, 0}};
        p.weight[(e.side[0] + 1u) % 3] = static_cast<double>(place) / fine;
        p.weight[e.side[0]] = 1 - p.weight[(e.side[0] + 1u) % 3];
        return p;
    };
    // Batches: each pass through the parameterisation costs as much as the input has faces, each point some bytes.
    const std::vector<std::uint32_t> edges = line_edges(part);
    const std::size_t batch = std::max<std::size_t>(1, kPointsAtOnce / (fine + 1));
    for (std::size_t begin = 0; begin < edges.size(); begin += batch) {
        const std::size_t end = std::min(edges.size(), begin + batch);
        std::vector<FacePoint> lines;
        for (std::size_t k = begin; k < end; ++k)
            for (std::uint32_t place = 0; place <= fine; ++place)
                lines.push_back(on_edge(part.base.edges()[edges[k]], place));
        parameterization.to_input(lines, threads);
        const std::vector<Vec3> positions = positions_of(mesh, lines);
        for (std::size_t k = begin; k < end; ++k) {
            const auto line = std::span(positions).subspan((k - begin) * (fine + 1), fine + 1);
            if (most_cut(line) <= kMostCut) continue;
            const BaseEdge& e = part.base.edges()[edges[k]];
            const std::vector<std::uint32_t> chosen = places(shares(line), n);
            for (std::uint32_t t = 1; t < n; ++t)
                points[edge_vertex_index(part.base, e, part.levels, t)] = on_edge(e, chosen[t]);
        }
    }
}

}  // namespace mvw
