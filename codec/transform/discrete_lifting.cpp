#include <algorithm>

#include "codec/transform/dense_solve.h"
#include "codec/transform/lifting.h"

namespace mvw {

namespace {

using Column = std::vector<std::pair<std::uint32_t, double>>;

/// Sorts by row and adds up repeated rows.
void compress(Column& column) {
    std::sort(column.begin(), column.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < column.size(); ++i) {
        if (kept > 0 && column[kept - 1].first == column[i].first)
            column[kept - 1].second += column[i].second;
        else
            column[kept++] = column[i];
    }
    column.resize(kept);
}

double product(const Column& a, const Column& b) {
    double sum = 0;
    for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
        if (a[i].first < b[k].first)
            ++i;
        else if (b[k].first < a[i].first)
            ++k;
        else
            sum += a[i++].second * b[k++].second;
    }
    return sum;
}

}  // namespace

DiscreteLifting::DiscreteLifting(const Level& level, PredictRule rule, double s) : level_(level), rule_(rule) {
    // Seeded rules are lifted with the weights of the rule without shape components.
    if (rule == PredictRule::Seeded || rule == PredictRule::SeededNormal) rule_ = PredictRule::Interp;
    const auto E = static_cast<std::uint32_t>(level.edges.size());
    std::vector<Term> terms;
    std::vector<std::size_t> end_of_edge;
    edge_of_odd_.resize(E);
    for (std::uint32_t e = 0; e < E; ++e) {
        predict_terms(level, e, rule_, s, terms);
        end_of_edge.push_back(terms.size());
        edge_of_odd_[level.edges[e].odd - level.vertex_count] = e;
    }
    first_use_.assign(level.vertex_count + 1, 0);
    for (const Term& t : terms) ++first_use_[t.vertex + 1];
    for (std::uint32_t v = 0; v < level.vertex_count; ++v) first_use_[v + 1] += first_use_[v];
    uses_.resize(terms.size());
    columns_.resize(level.vertex_count);
    products_.resize(level.vertex_count);
    std::vector<std::uint32_t> place(first_use_.begin(), first_use_.end() - 1);
    for (std::uint32_t e = 0, t = 0; e < E; ++e)
        for (; t < end_of_edge[e]; ++t) uses_[place[terms[t].vertex]++] = {e, terms[t].position};
}

Column DiscreteLifting::column_of_vertex(std::uint32_t v, bool curve) const {
    Column column;
    for (std::uint32_t u = first_use_[v]; u < first_use_[v + 1]; ++u) {
        const Level::Edge& edge = level_.edges[uses_[u].first];
        if (!curve || edge.sharp) column.emplace_back(edge.odd, uses_[u].second);
    }
    compress(column);
    if (rule_ == PredictRule::Loop) add_loop_even(column);
    const double own = rule_ == PredictRule::Loop ? loop_even(level_, v).a : 1.0;
    column.emplace_back(v, own);
    compress(column);
    return column;
}

Column DiscreteLifting::column_of_edge(std::uint32_t e) const {
    Column column{{level_.edges[e].odd, 1.0}};
    if (rule_ == PredictRule::Loop) add_loop_even(column);
    compress(column);
    return column;
}

void DiscreteLifting::add_loop_even(Column& odd) const {
    const std::size_t count = odd.size();
    std::vector<std::uint32_t> around;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t e = edge_of_odd_[odd[i].first - level_.vertex_count];
        for (const std::uint32_t v : {level_.from(level_.edges[e].half), level_.to(level_.edges[e].half)}) {
            loop_edges(level_, v, around);
            if (std::find(around.begin(), around.end(), e) != around.end())
                odd.emplace_back(v, loop_even(level_, v).b * odd[i].second);
        }
    }
}

const DiscreteLifting::Column& DiscreteLifting::kept_column(std::uint32_t v) const {
    Column& column = columns_[v];
    if (column.empty()) column = column_of_vertex(v, false);
    return column;
}

double DiscreteLifting::kept_product(std::uint32_t v, std::uint32_t w) const {
    auto& products = products_[std::min(v, w)];
    const std::uint32_t other = std::max(v, w);
    for (const auto& [vertex, value] : products)
        if (vertex == other) return value;
    products.emplace_back(other, product(kept_column(v), kept_column(w)));
    return products.back().second;
}

void DiscreteLifting::weights(std::uint32_t edge, bool four, std::vector<LiftTerm>& out) const {
    weights(edge, lifting_template(level_, edge, four), out);
}

void DiscreteLifting::weights(std::uint32_t edge, const std::vector<std::uint32_t>& lift_template,
                              std::vector<LiftTerm>& out) const {
    const bool curve = level_.edges[edge].sharp;
    const std::size_t n = lift_template.size();
    const Column own = column_of_edge(edge);
    std::vector<double> A(n * n), w(n);
    if (curve) {
        std::vector<Column> columns;
        columns.reserve(n);
        for (const std::uint32_t v : lift_template) columns.push_back(column_of_vertex(v, true));
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t k = 0; k <= i; ++k) A[n * i + k] = A[n * k + i] = product(columns[i], columns[k]);
            w[i] = -product(own, columns[i]);
        }
    } else {
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t k = 0; k <= i; ++k)
                A[n * i + k] = A[n * k + i] = kept_product(lift_template[i], lift_template[k]);
            w[i] = -product(own, kept_column(lift_template[i]));
        }
    }
    solve_positive_definite(A, w);
    for (std::size_t i = 0; i < n; ++i) out.push_back({lift_template[i], w[i]});
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
