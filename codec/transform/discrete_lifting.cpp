#include <algorithm>

#include "codec/transform/dense_solve.h"
#include "codec/transform/lifting.h"

namespace mvw {

DiscreteLifting::DiscreteLifting(const Level& level, PredictRule rule, double s)
    : level_(level),
      rule_(rule),
      hubs_(level.vertex_count, {false, false}),
      slots_(level.vertex_count, kNone),
      places_(level.vertex_count, kNone) {
    // Seeded rules are lifted with the weights of the rule without shape components.
    if (rule == PredictRule::Seeded || rule == PredictRule::SeededNormal) rule_ = PredictRule::Interp;
    product_runs_.fill(std::vector<Run>(level.vertex_count, {kNone, 0}));
    list_rows(s);
    list_uses();
}

void DiscreteLifting::list_rows(double s) {
    const auto E = static_cast<std::uint32_t>(level_.edges.size());
    terms_.reserve(std::size_t{10} * E + level_.vertex_count);
    first_term_.reserve(E + level_.vertex_count + 1);
    first_term_.push_back(0);
    std::vector<Term> terms;
    for (std::uint32_t e = 0; e < E; ++e) {
        terms.clear();
        predict_terms(level_, e, rule_, s, terms);
        for (const Term& t : terms) terms_.push_back({t.vertex, t.position});
        end_row();
    }
    std::vector<std::uint32_t> around;
    for (std::uint32_t v = 0; v < level_.vertex_count; ++v) {
        const LoopEven even = rule_ == PredictRule::Loop ? loop_even(level_, v) : LoopEven{1, 0};
        terms_.push_back({v, even.a});
        if (rule_ == PredictRule::Loop) {
            loop_edges(level_, v, around);
            for (const std::uint32_t e : around)
                for (std::uint32_t t = first_term_[e]; t < first_term_[e + 1]; ++t)
                    terms_.push_back({terms_[t].at, even.b * terms_[t].weight});
        }
        end_row();
    }
}

/// Sorts the terms since the last row by vertex, adds up those of one vertex, and makes them a row.
void DiscreteLifting::end_row() {
    const auto begin = terms_.begin() + first_term_.back();
    std::sort(begin, terms_.end(), [](const Entry& a, const Entry& b) { return a.at < b.at; });
    auto last = begin;
    for (auto t = begin; t != terms_.end(); ++t)
        if (last != begin && (last - 1)->at == t->at)
            (last - 1)->weight += t->weight;
        else
            *last++ = *t;
    terms_.erase(last, terms_.end());
    first_term_.push_back(static_cast<std::uint32_t>(terms_.size()));
}

void DiscreteLifting::list_uses() {
    first_use_.assign(level_.vertex_count + 1, 0);
    for (const Entry& t : terms_) ++first_use_[t.at + 1];
    for (std::uint32_t v = 0; v < level_.vertex_count; ++v) first_use_[v + 1] += first_use_[v];
    uses_.resize(terms_.size());
    std::vector<std::uint32_t> place(first_use_.begin(), first_use_.end() - 1);
    for (std::uint32_t r = 0; r + 1 < first_term_.size(); ++r)
        for (const Entry& t : row(r)) uses_[place[t.at]++] = {r, t.weight};
}

/// Whether a row takes part in inner products along sharp edges.
bool DiscreteLifting::counts_along_curves(std::uint32_t r) const {
    const auto E = static_cast<std::uint32_t>(level_.edges.size());
    return r < E ? level_.edges[r].sharp : level_.sharp(r - E);
}

/// Whether it takes too long to find all products of a vertex: a hub, or one in sight of it. A base may have as many
/// such vertices as it likes, so theirs are found pair by pair.
bool DiscreteLifting::is_hub(std::uint32_t v) const {
    constexpr std::size_t kMostTerms = 2048;
    auto& [known, hub] = hubs_[v];
    if (known) return hub;
    known = true;
    std::size_t terms = 0;
    for (const Entry& use : uses(v))
        if ((terms += row(use.at).size()) > kMostTerms) return hub = true;
    return hub;
}

/// The entry of a row at a vertex, 0 where it has none.
double DiscreteLifting::term(std::uint32_t r, std::uint32_t v) const {
    const std::span<const Entry> rows = uses(v);
    const auto found =
        std::lower_bound(rows.begin(), rows.end(), r, [](const Entry& e, std::uint32_t at) { return e.at < at; });
    return found != rows.end() && found->at == r ? found->weight : 0;
}

/// <phi_v, phi_w> of all w where it is not zero, v first.
std::span<const DiscreteLifting::Entry> DiscreteLifting::products(std::uint32_t v, bool curve) const {
    auto& [first, count] = product_runs_[curve ? 1 : 0][v];
    if (first == kNone) {
        first = static_cast<std::uint32_t>(products_.size());
        count = 1;
        products_.push_back({v, 0});
        slots_[v] = first;
        for (const Entry& use : uses(v)) {
            if (curve && !counts_along_curves(use.at)) continue;
            for (const Entry& t : row(use.at)) {
                if (slots_[t.at] - first >= count) {  // not of this row, or of none
                    slots_[t.at] = first + count++;
                    products_.push_back({t.at, 0});
                }
                products_[slots_[t.at]].weight += use.weight * t.weight;
            }
        }
    }
    return std::span(products_).subspan(first, count);
}

/// <phi_v, phi_w> of two hubs, or of one with itself.
double DiscreteLifting::hub_product(std::uint32_t v, std::uint32_t w, bool curve) const {
    if (uses(w).size() < uses(v).size()) std::swap(v, w);
    const auto [known, is_new] = hub_products_[curve ? 1 : 0].try_emplace(std::minmax(v, w), 0.0);
    if (is_new)
        for (const Entry& use : uses(v))
            if (!curve || counts_along_curves(use.at)) known->second += use.weight * term(use.at, w);
    return known->second;
}

/// Row by row, but for the upper triangle of hubs' rows.
void DiscreteLifting::fill_matrix(std::span<const std::uint32_t> lift_template, bool curve) const {
    const std::size_t n = lift_template.size();
    std::vector<std::size_t> hubs;
    for (std::size_t i = 0; i < n; ++i) {
        double* const out = matrix_.data() + n * i;
        if (is_hub(lift_template[i])) {
            hubs.push_back(i);
            for (const std::size_t k : hubs) out[k] = hub_product(lift_template[i], lift_template[k], curve);
            continue;
        }
        for (const Entry& entry : products(lift_template[i], curve))
            if (const std::uint32_t place = places_[entry.at]; place != kNone) out[place] = entry.weight;
    }
    for (const std::size_t i : hubs)
        for (std::size_t k = 0; k < i; ++k)
            if (std::find(hubs.begin(), hubs.end(), k) == hubs.end()) matrix_[n * i + k] = matrix_[n * k + i];
}

/// -<phi_e, phi_i>: a detail shows at its own vertex and, by Loop's even rule, at both ends.
void DiscreteLifting::fill_side(std::uint32_t edge, std::span<const std::uint32_t> lift_template) const {
    const Level::Edge& e = level_.edges[edge];
    const auto E = static_cast<std::uint32_t>(level_.edges.size());
    for (std::size_t i = 0; i < lift_template.size(); ++i) {
        side_[i] = -term(edge, lift_template[i]);
        if (rule_ != PredictRule::Loop) continue;
        for (const std::uint32_t v : {level_.from(e.half), level_.to(e.half)})
            if (!level_.sharp(v) || (level_.on_curve(v) && e.sharp))
                side_[i] -= loop_even(level_, v).b * term(E + v, lift_template[i]);
    }
}

void DiscreteLifting::weights(std::uint32_t edge, bool four, std::vector<LiftTerm>& out) const {
    weights(edge, lifting_template(level_, edge, four), out);
}

void DiscreteLifting::weights(std::uint32_t edge, const std::vector<std::uint32_t>& lift_template,
                              std::vector<LiftTerm>& out) const {
    const std::size_t n = lift_template.size();
    matrix_.assign(n * n, 0);
    side_.assign(n, 0);
    for (std::uint32_t i = 0; i < n; ++i) places_[lift_template[i]] = i;
    fill_matrix(lift_template, level_.edges[edge].sharp);
    fill_side(edge, lift_template);
    for (const std::uint32_t v : lift_template) places_[v] = kNone;
    solve_positive_definite(matrix_, side_);
    for (std::size_t i = 0; i < n; ++i) out.push_back({lift_template[i], side_[i]});
}

std::vector<std::uint32_t> lifting_template(const Level& level, std::uint32_t edge, bool four) {
    const TenPoints p = level.ten_points(edge);
    std::vector<std::uint32_t> result;
    const auto add = [&](std::uint32_t v) {
        if (v != kNone && std::find(result.begin(), result.end(), v) == result.end()) result.push_back(v);
    };
    for (const std::uint32_t v : p.ends) add(v);
    if (level.edges[edge].sharp) {
        for (const std::uint32_t end : p.ends)
            if (level.on_curve(end))
                for (const std::uint32_t v : level.curve_neighbours(end)) add(v);
        return result;
    }
    for (const std::uint32_t v : p.opp) add(v);
    if (four) return result;
    for (const std::uint32_t v : p.wings) add(v);
    for (const std::uint32_t v : p.far) add(v);
    return result;
}

}  // namespace mvw
