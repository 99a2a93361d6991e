#include "codec/remesh/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "codec/measure/surface_index.h"
#include "codec/remesh/coarse_grid.h"
#include "codec/remesh/parallel.h"
#include "codec/remesh/rings.h"

namespace mvw {

namespace {

constexpr double kPlentySamples = 1e6, kLeastSamples = 30'000;
constexpr int kMostSteps = 30;      // of conjugate gradients, ...
constexpr double kResidual = 1e-3;  // ... or until so much of the residual is left

/// One point of the input with the input's normal there.
struct Sample {
    Vec3 point, normal;
};

/// One term of the least-squares sum: a sample's closest point on the remesh, and what that moves with.
struct Term {
    Vec3f gap;                       // from there to the sample
    std::uint32_t triangle = kNone;  // none: not to be used
    std::array<float, 3> weight{};
};

std::array<float, 3> to_floats(const std::array<double, 3>& w) {
    return {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])};
}

Vec3 scaled_normal(const std::vector<Vec3>& positions, const Face& f) {
    return cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
}

/// Points spread evenly by area: one in each of `count` equal slices of the cumulated area.
std::vector<Sample> lay_samples(const Mesh& input, std::size_t count) {
    std::vector<Sample> samples;
    samples.reserve(count);
    double area = 0;
    for (const Face& f : input.faces) area += length(scaled_normal(input.positions, f));
    std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): the same samples every time
    std::uniform_real_distribution<double> uniform(0, 1);
    double passed = 0;
    for (const Face& f : input.faces) {
        const Vec3 n = scaled_normal(input.positions, f);
        passed += length(n);
        while (static_cast<double>(samples.size()) < passed / area * static_cast<double>(count)) {
            const double r = std::sqrt(uniform(random)), s = uniform(random);
            samples.push_back({input.positions[f[0]] * (1 - r) + input.positions[f[1]] * (r * (1 - s)) +
                                   input.positions[f[2]] * (r * s),
                               normalized(n)});
        }
    }
    return samples;
}

/// A symmetric 3 x 3 matrix.
struct Block {
    float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

    /// What a distance d counts, as d^T M d: along n in full, across it less.
    static Block of_normal(const Vec3& n, double tangential) {
        const double k = 1 - tangential;
        const auto f = [](double x) { return static_cast<float>(x); };
        return {f(k * n.x * n.x + tangential), f(k * n.x * n.y), f(k * n.x * n.z),
                f(k * n.y * n.y + tangential), f(k * n.y * n.z), f(k * n.z * n.z + tangential)};
    }
    void add(const Block& o, float w) {
        xx += o.xx * w, xy += o.xy * w, xz += o.xz * w, yy += o.yy * w, yz += o.yz * w, zz += o.zz * w;
    }
    friend Vec3 operator*(const Block& m, const Vec3& v) {
        return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
                m.xz * v.x + m.yz * v.y + m.zz * v.z};
    }
};

std::uint32_t count_neighbours(std::span<const RingTriangle> ring) {
    auto count = static_cast<std::uint32_t>(ring.size());  // the first corners; of an open fan one second is left
    for (const RingTriangle& t : ring)
        if (std::ranges::none_of(ring, [&](const RingTriangle& o) { return o.first == t.second; })) ++count;
    return count;
}

/// The terms of each triangle.
struct TermsOfTriangles {
    std::vector<std::uint32_t> begin, term;  // F + 1; numbers of used terms, sorted by triangle

    TermsOfTriangles(const std::vector<Term>& terms, std::size_t triangles) : begin(triangles + 1, 0) {
        for (const Term& t : terms)
            if (t.triangle != kNone) ++begin[t.triangle + 1];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        term.resize(begin.back());
        std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
        for (std::uint32_t k = 0; k < terms.size(); ++k)
            if (terms[k].triangle != kNone) term[at[terms[k].triangle]++] = k;
    }
};

/// (B^T M B + damping) x = B^T M gaps over the vertices that move, B being each used term's weights, M what
/// distances count along the sample's normal and across. Row by row, so that rows can be computed side by side.
class NormalEquations {
 public:
    NormalEquations(const std::vector<Sample>& samples, const std::vector<Term>& terms,
                    const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
                    const FitOptions& options)
        : fixed_(fixed), threads_(options.threads), right_(fixed.size()) {
        const std::size_t V = fixed.size();
        const Rings rings(triangles, V);
        const TermsOfTriangles sorted(terms, triangles.size());
        row_.push_back(0);
        for (std::uint32_t v = 0; v < V; ++v) row_.push_back(row_.back() + count_neighbours(rings.at(v)));
        diagonal_.resize(V);
        column_.assign(row_.back(), kNone);
        block_.resize(row_.back());
        parallel_slices(V, threads_, [&](std::size_t begin, std::size_t end) {
            for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v)
                if (fixed_[v] == 0) assemble(v, rings.at(v), samples, terms, triangles, sorted, options);
        });
    }

    /// The displacement of every vertex; conjugate gradients.
    std::vector<Vec3> solve() const {
        const std::size_t V = right_.size();
        std::vector<Vec3> r = right_, x(V), p = r, Ap(V);
        double rr = inner(r, r);
        const double stop = rr * kResidual * kResidual;
        for (int step = 0; step < kMostSteps && rr > stop; ++step) {
            apply(p, Ap);
            const double alpha = rr / inner(p, Ap);
            for (std::size_t v = 0; v < V; ++v) x[v] += p[v] * alpha, r[v] -= Ap[v] * alpha;
            const double next = inner(r, r);
            for (std::size_t v = 0; v < V; ++v) p[v] = r[v] + p[v] * (next / rr);
            rr = next;
        }
        return x;
    }

 private:
    void assemble(std::uint32_t v, std::span<const RingTriangle> ring, const std::vector<Sample>& samples,
                  const std::vector<Term>& terms, const std::vector<Face>& triangles, const TermsOfTriangles& sorted,
                  const FitOptions& options) {
        const auto damping = static_cast<float>(options.damping);
        diagonal_[v] = {damping, 0, 0, damping, 0, damping};
        for (const RingTriangle& t : ring) {
            const Face& f = triangles[t.triangle];
            const std::size_t corner = f[0] == v ? 0 : f[1] == v ? 1 : 2;
            for (std::uint32_t s = sorted.begin[t.triangle]; s < sorted.begin[t.triangle + 1]; ++s) {
                const Sample& sample = samples[sorted.term[s]];
                const Term& term = terms[sorted.term[s]];
                const std::array<float, 3>& w = term.weight;
                const Block m = Block::of_normal(sample.normal, options.tangential);
                right_[v] += m * to_double(term.gap) * w[corner];
                diagonal_[v].add(m, w[corner] * w[corner]);
                for (const std::size_t other : {(corner + 1) % 3, (corner + 2) % 3})
                    if (fixed_[f[other]] == 0) block_at(v, f[other]).add(m, w[corner] * w[other]);
            }
        }
    }
    Block& block_at(std::uint32_t v, std::uint32_t neighbour) {
        std::uint32_t k = row_[v];
        while (column_[k] != kNone && column_[k] != neighbour) ++k;  // ends: there is a slot for each neighbour
        column_[k] = neighbour;
        return block_[k];
    }
    void apply(const std::vector<Vec3>& x, std::vector<Vec3>& out) const {
        parallel_slices(x.size(), threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                Vec3 sum = diagonal_[v] * x[v];
                for (std::uint32_t k = row_[v]; k < row_[v + 1] && column_[k] != kNone; ++k)
                    sum += block_[k] * x[column_[k]];
                out[v] = sum;
            }
        });
    }
    static double inner(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
        double sum = 0;
        for (std::size_t v = 0; v < a.size(); ++v) sum += dot(a[v], b[v]);
        return sum;
    }

    const std::vector<std::uint8_t>& fixed_;
    const unsigned threads_;
    std::vector<Vec3> right_;
    std::vector<Block> diagonal_;
    std::vector<std::uint32_t> row_, column_;  // V + 1; neighbours that have terms with v, then kNone
    std::vector<Block> block_;                 // as column_
};

/// Takes back moves at triangles that turned by over 60 degrees, until none is left or the whole round is undone.
void take_back_turned(const std::vector<Face>& triangles, const std::vector<Vec3>& before, std::vector<Vec3>& after) {
    for (int check = 0; check < 8; ++check) {
        bool any = false;
        for (const Face& f : triangles) {
            const Vec3 n0 = scaled_normal(before, f), n1 = scaled_normal(after, f);
            if (dot(n0, n1) >= 0.5 * length(n0) * length(n1) && squared_length(n1) > 0.01 * squared_length(n0))
                continue;
            for (const std::uint32_t v : f) {
                any |= !(after[v] == before[v]);
                after[v] = before[v];
            }
        }
        if (!any) return;
    }
}

/// Each sample's nearest point on a surface. nearest: triangles that may be near, in; those that are, out.
std::vector<Term> terms_on(const std::vector<Vec3>& positions, const std::vector<Face>& triangles,
                           const std::vector<Sample>& samples, unsigned threads, std::vector<std::uint32_t>& nearest) {
    std::vector<Term> terms(samples.size());
    nearest.resize(samples.size(), kNone);
    const SurfaceIndex index(positions, triangles, threads);
    parallel_slices(samples.size(), threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t near = nearest[k] == kNone && k > begin ? nearest[k - 1] : nearest[k];
            const SurfacePoint hit = index.closest(samples[k].point, near);
            nearest[k] = hit.face;
            const Face& f = triangles[hit.face];
            const Vec3 n = normalized(scaled_normal(positions, f));
            const auto& w = hit.barycentric;
            const Vec3 on = positions[f[0]] * w[0] + positions[f[1]] * w[1] + positions[f[2]] * w[2];
            // A sample of the far side of a thin wall must not pull at this side.
            terms[k] = {to_float(samples[k].point - on), dot(n, samples[k].normal) > 0.3 ? hit.face : kNone,
                        to_floats(w)};
        }
    });
    return terms;
}

}  // namespace

void fit(const Mesh& input, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
         const FitOptions& options, std::vector<Vec3>& positions) {
    // Very fine remeshes have many vertices on each face of the input: there fewer samples a vertex say as much.
    const auto vertices = static_cast<double>(positions.size());
    const double count = std::min(options.samples * vertices, 2 * vertices + kPlentySamples);
    const std::vector<Sample> samples = lay_samples(input, static_cast<std::size_t>(count));
    std::vector<std::uint32_t> nearest;
    for (unsigned round = 0; round < options.rounds; ++round) {
        const std::vector<Term> terms = terms_on(positions, triangles, samples, options.threads, nearest);
        const std::vector<Vec3> move = NormalEquations(samples, terms, triangles, fixed, options).solve();
        std::vector<Vec3> moved = positions;
        for (std::size_t v = 0; v < moved.size(); ++v) moved[v] += move[v];
        take_back_turned(triangles, positions, moved);
        positions = std::move(moved);
    }
}

std::vector<Vec3> fit_coarse(const Mesh& input, const BaseMesh& base, unsigned level,
                             const std::vector<Vec3>& positions, unsigned coarse,
                             const std::vector<std::uint8_t>& fixed, const FitOptions& options) {
    const double count = std::max(options.samples * static_cast<double>(fixed.size()), kLeastSamples);
    const std::vector<Sample> samples = lay_samples(input, static_cast<std::size_t>(count));
    std::vector<std::uint32_t> nearest;
    std::vector<Term> terms = terms_on(positions, triangles_at_level(base, level), samples, options.threads, nearest);
    for (Term& term : terms) {
        if (term.triangle == kNone) continue;
        const auto& w = term.weight;
        const FacePoint p = on_level(on_base({term.triangle, {w[0], w[1], w[2]}}, level), coarse);
        term.triangle = p.face;
        term.weight = to_floats(p.weight);
    }
    return NormalEquations(samples, terms, triangles_at_level(base, coarse), fixed, options).solve();
}

}  // namespace mvw
