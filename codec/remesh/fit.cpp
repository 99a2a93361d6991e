#include "codec/remesh/fit.h"

#include <array>
#include <cmath>
#include <random>

#include "codec/measure/surface_index.h"
#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr double kPlentySamples = 1e6;

/// One point of the input with the input's normal there.
struct Sample {
    Vec3 point, normal;
};

/// One term of the least-squares sum: a sample's closest point on the remesh.
struct Term {
    Face vertices{};
    std::array<float, 3> weight{};
    bool used = false;

    /// Value at that point of what is given at the vertices.
    [[nodiscard]] Vec3 at(const std::vector<Vec3>& x) const {
        return x[vertices[0]] * weight[0] + x[vertices[1]] * weight[1] + x[vertices[2]] * weight[2];
    }
};

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

/// (B^T B + damping) x over the vertices that move, B being each used term's distance; conjugate gradients.
class NormalEquations {
 public:
    NormalEquations(const std::vector<Sample>& samples, const std::vector<Term>& terms,
                    const std::vector<std::uint8_t>& fixed, const FitOptions& options)
        : samples_(samples), terms_(terms), fixed_(fixed), options_(options) {}

    /// The displacement of every vertex.
    std::vector<Vec3> solve(const std::vector<Vec3>& positions) const {
        const std::size_t V = positions.size();
        std::vector<Vec3> r(V), x(V), p, Ap(V);
        for (std::size_t k = 0; k < terms_.size(); ++k)
            if (terms_[k].used) scatter(terms_[k], project(k, samples_[k].point - terms_[k].at(positions)), r);
        clamp(r);
        p = r;
        double rr = inner(r, r);
        const double stop = rr * 1e-6;
        for (int step = 0; step < 30 && rr > stop; ++step) {
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
    [[nodiscard]] Vec3 project(std::size_t k, const Vec3& d) const {
        const Vec3& n = samples_[k].normal;
        return n * (dot(n, d) * (1 - options_.tangential)) + d * options_.tangential;
    }
    static void scatter(const Term& t, const Vec3& d, std::vector<Vec3>& out) {
        for (std::size_t k = 0; k < 3; ++k) out[t.vertices[k]] += d * t.weight[k];
    }
    void clamp(std::vector<Vec3>& x) const {
        for (std::size_t v = 0; v < x.size(); ++v)
            if (fixed_[v]) x[v] = {};
    }
    void apply(const std::vector<Vec3>& x, std::vector<Vec3>& out) const {
        for (std::size_t v = 0; v < x.size(); ++v) out[v] = x[v] * options_.damping;
        for (std::size_t k = 0; k < terms_.size(); ++k)
            if (terms_[k].used) scatter(terms_[k], project(k, terms_[k].at(x)), out);
        clamp(out);
    }
    static double inner(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
        double sum = 0;
        for (std::size_t v = 0; v < a.size(); ++v) sum += dot(a[v], b[v]);
        return sum;
    }

    const std::vector<Sample>& samples_;
    const std::vector<Term>& terms_;
    const std::vector<std::uint8_t>& fixed_;
    const FitOptions& options_;
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

}  // namespace

void fit(const Mesh& input, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
         const FitOptions& options, std::vector<Vec3>& positions) {
    // Very fine remeshes have many vertices on each face of the input: there fewer samples a vertex say as much.
    const auto vertices = static_cast<double>(positions.size());
    const double count = std::min(options.samples * vertices, 2 * vertices + kPlentySamples);
    const std::vector<Sample> samples = lay_samples(input, static_cast<std::size_t>(count));
    std::vector<Term> terms(samples.size());
    for (unsigned round = 0; round < options.rounds; ++round) {
        const SurfaceIndex index(positions, triangles, options.threads);
        parallel_slices(samples.size(), options.threads, [&](std::size_t begin, std::size_t end) {
            std::uint32_t near = kNone;
            for (std::size_t k = begin; k < end; ++k) {
                const SurfacePoint hit = index.closest(samples[k].point, near);
                near = hit.face;
                const Face& f = triangles[hit.face];
                const Vec3 n = normalized(scaled_normal(positions, f));
                // A sample of the far side of a thin wall must not pull at this side.
                const auto& w = hit.barycentric;
                terms[k] = {f,
                            {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])},
                            dot(n, samples[k].normal) > 0.3};
            }
        });
        const std::vector<Vec3> move = NormalEquations(samples, terms, fixed, options).solve(positions);
        std::vector<Vec3> moved = positions;
        for (std::size_t v = 0; v < moved.size(); ++v) moved[v] += move[v];
        take_back_turned(triangles, positions, moved);
        positions = std::move(moved);
    }
}

}  // namespace mvw
