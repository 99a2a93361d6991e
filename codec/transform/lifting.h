// Lifting weights, computed from the masks: psi = phi_e + sum of w_i phi_i with <psi, phi_i> = 0 over the template, the
// paper's equation (4). Ordinary edges: continuous inner product of limit functions. Everywhere else: the discrete one
// (Bertram: finer scaling functions taken as orthonormal), a small system for each neighbourhood.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "codec/transform/stencils.h"

namespace mvw {

/// Masks of a two-component scheme on the regular lattice (row vectors [v, x], matrices act from the right). A scalar
/// scheme has only the upper left entries.
struct LatticeMasks {
    using Matrix = std::array<double, 4>;  // row by row
    Matrix G, L;                           // even vertex: itself, its ring
    Matrix J, K, M, N;                     // odd vertex: ends, opp, wings, far
};
/// The matrix-valued interpolatory Loop scheme; with `printed_sign`, M as the paper prints it.
LatticeMasks interpolatory_masks(bool printed_sign = false);
/// An interpolating scalar rule (x reset on every level), and Loop's scheme, whose limit is the quartic box spline.
LatticeMasks scalar_masks(const TenWeights& position);
LatticeMasks loop_masks();

/// Weights of an ordinary edge's ten points for the scheme that starts from [1, 0]; inner products are sums over the
/// lattice of `levels` subdivisions (1: the discrete one; 7: the limit to 5 digits).
///
/// end_share  what one unit at the edge adds to each end: 0, but 1/10 for Loop's scheme in lifting form
/// four       template of ends and opposites alone
TenWeights lattice_weights(const LatticeMasks& masks, unsigned levels, double end_share = 0, bool four = false);

/// Largest |<psi, phi_i>| / <phi_i, phi_i> that these weights leave over the ten points: the check of the solver.
double lattice_residual(const LatticeMasks& masks, unsigned levels, const TenWeights& weights);

/// Weights of one edge: those of `vertex[i]` is `weight[i]`.
struct LiftTerm {
    std::uint32_t vertex;
    double weight;
};

/// Solves for the weights near irregular and sharp vertices of one level. Keeps what edges near each other share: not
/// for several threads at once.
class DiscreteLifting {
 public:
    /// Prediction stencils are computed for all edges of the level here. O(E).
    DiscreteLifting(const Level& level, PredictRule rule, double s);

    /// Appends the weights of `edge`. Template: those of the ten points that exist, or ends and opposites alone
    /// (`four`); on a sharp edge the curve's four, with inner products along sharp edges only.
    void weights(std::uint32_t edge, bool four, std::vector<LiftTerm>& out) const;
    /// The same for a template of the caller's choice.
    void weights(std::uint32_t edge, const std::vector<std::uint32_t>& lift_template, std::vector<LiftTerm>& out) const;

 private:
    /// Row r of the subdivision matrix P says how the finer level's vertex r comes from coarse ones: rows [0, E) are
    /// edges' new vertices, row E + v is that of vertex v itself. phi_v is column v of P, <phi_v, phi_w> entry (v, w)
    /// of P^T P.
    struct Entry {
        std::uint32_t at;  // a row, or a coarse vertex
        double weight;
    };
    [[nodiscard]] std::span<const Entry> row(std::uint32_t r) const {
        return std::span(terms_).subspan(first_term_[r], first_term_[r + 1] - first_term_[r]);
    }
    /// The rows that hold a vertex, rising.
    [[nodiscard]] std::span<const Entry> uses(std::uint32_t v) const {
        return std::span(uses_).subspan(first_use_[v], first_use_[v + 1] - first_use_[v]);
    }
    using Run = std::array<std::uint32_t, 2>;  // first, count
    void list_rows(double s);
    void list_uses();
    void end_row();
    [[nodiscard]] bool counts_along_curves(std::uint32_t r) const;
    [[nodiscard]] bool is_hub(std::uint32_t v) const;
    [[nodiscard]] double term(std::uint32_t r, std::uint32_t v) const;
    [[nodiscard]] std::span<const Entry> products(std::uint32_t v, bool curve) const;
    [[nodiscard]] double hub_product(std::uint32_t v, std::uint32_t w, bool curve) const;
    void fill_matrix(std::span<const std::uint32_t> lift_template, bool curve) const;
    void fill_side(std::uint32_t edge, std::span<const std::uint32_t> lift_template) const;

    const Level& level_;
    PredictRule rule_;
    std::vector<std::uint32_t> first_term_, first_use_;
    std::vector<Entry> terms_, uses_;

    // Rows of P^T P that have been asked for, the diagonal first: of all rows of P, and of those on curves alone. A run
    // begins at kNone before.
    mutable std::array<std::vector<Run>, 2> product_runs_;
    mutable std::vector<Entry> products_;
    mutable std::vector<std::array<bool, 2>> hubs_;  // of each vertex: whether it is known, whether it is one
    // Single entries between hubs, by the smaller vertex and the larger one.
    mutable std::array<std::map<std::pair<std::uint32_t, std::uint32_t>, double>, 2> hub_products_;
    // Where each vertex was last put among products_. Scratch: its place in the template, kNone outside; the system.
    mutable std::vector<std::uint32_t> slots_, places_;
    mutable std::vector<double> matrix_, side_;
};

/// The template of an edge (see DiscreteLifting::weights), without repeats.
std::vector<std::uint32_t> lifting_template(const Level& level, std::uint32_t edge, bool four);

/// Both ends regular: the ten constant weights serve.
inline bool is_ordinary(const Level& level, std::uint32_t edge) {
    const std::uint32_t h = level.edges[edge].half;
    return level.regular(level.from(h)) && level.regular(level.to(h));
}

/// The constant weights that the options select for ordinary edges. All zero for lazy transforms.
TenWeights ordinary_lifting(const TransformOptions& options);

}  // namespace mvw
