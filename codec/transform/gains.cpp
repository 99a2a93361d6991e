#include <cmath>

#include "codec/transform/lifting.h"
#include "codec/transform/transform.h"

namespace mvw {

namespace {

/// One number for each point of a square piece of the regular lattice, zero outside.
class Field {
 public:
    explicit Field(int radius) : radius_(radius), width_(2 * radius + 1), data_(std::size_t(width_) * width_) {}
    [[nodiscard]] int radius() const { return radius_; }
    [[nodiscard]] double get(int i, int k) const {
        return std::abs(i) > radius_ || std::abs(k) > radius_ ? 0 : data_[index(i, k)];
    }
    double& at(int i, int k) { return data_[index(i, k)]; }
    [[nodiscard]] double norm() const {
        double sum = 0;
        for (const double v : data_) sum += v * v;
        return std::sqrt(sum);
    }

 private:
    [[nodiscard]] std::size_t index(int i, int k) const {
        return std::size_t(i + radius_) * std::size_t(width_) + std::size_t(k + radius_);
    }
    int radius_, width_;
    std::vector<double> data_;
};

struct Rule {
    TenWeights position, shape, lift;
    bool loop = false;
};

struct Step {
    int i, k;
};
constexpr Step turned(Step a) {
    return {-a.k, a.i + a.k};
}

/// Calls visit(i, k, weight) at the ten points of the edge from (i, k) along u.
template <typename Visit>
void visit_ten(int i, int k, Step u, const TenWeights& w, Visit visit) {
    const Step left = turned(u), right{u.i - left.i, u.k - left.k};
    visit(i, k, w.ends), visit(i + u.i, k + u.k, w.ends);
    visit(i + left.i, k + left.k, w.opp), visit(i + right.i, k + right.k, w.opp);
    visit(i - right.i, k - right.k, w.wings), visit(i + u.i + left.i, k + u.k + left.k, w.wings);
    visit(i - left.i, k - left.k, w.wings), visit(i + u.i + right.i, k + u.k + right.k, w.wings);
    visit(i - u.i, k - u.k, w.far), visit(i + 2 * u.i, k + 2 * u.k, w.far);
}

Field estimated_shape(const Field& v) {
    Field x(v.radius());
    for (int i = -v.radius(); i <= v.radius(); ++i)
        for (int k = -v.radius(); k <= v.radius(); ++k) {
            double ring = 0;
            Step u{1, 0};
            for (unsigned turn = 0; turn < 6; ++turn, u = turned(u)) ring += v.get(i + u.i, k + u.k);
            x.at(i, k) = (v.get(i, k) - ring / 6) / 4;
        }
    return x;
}

/// Loop's even rule: a = 2/5, b = 1/10 at regular vertices.
void loop_even(Field& fine) {
    for (int i = -fine.radius() / 2; i <= fine.radius() / 2; ++i)
        for (int k = -fine.radius() / 2; k <= fine.radius() / 2; ++k) {
            double ring = 0;
            Step u{1, 0};
            for (unsigned turn = 0; turn < 6; ++turn, u = turned(u)) ring += fine.get(2 * i + u.i, 2 * k + u.k);
            fine.at(2 * i, 2 * k) = 0.4 * fine.get(2 * i, 2 * k) + 0.1 * ring;
        }
}

/// One level of synthesis with one detail, `detail`, on the edge from (0,0) to (1,0).
Field refined(const Field& coarse, const Rule& rule, double detail) {
    Field v = coarse;
    visit_ten(0, 0, {1, 0}, rule.lift, [&](int i, int k, double w) { v.at(i, k) += w * detail; });
    const Field x = estimated_shape(v);
    Field fine(2 * v.radius());
    const int r = v.radius();
    for (int i = -r; i <= r; ++i)
        for (int k = -r; k <= r; ++k) {
            fine.at(2 * i, 2 * k) = v.get(i, k);
            Step u{1, 0};
            for (unsigned direction = 0; direction < 3; ++direction, u = turned(u)) {
                if (std::abs(2 * i + u.i) > 2 * r || std::abs(2 * k + u.k) > 2 * r) continue;
                double& e = fine.at(2 * i + u.i, 2 * k + u.k);
                visit_ten(i, k, u, rule.position, [&](int a, int b, double w) { e += w * v.get(a, b); });
                visit_ten(i, k, u, rule.shape, [&](int a, int b, double w) { e += w * x.get(a, b); });
            }
        }
    fine.at(1, 0) += detail;
    if (rule.loop) loop_even(fine);
    return fine;
}

// Beyond this many levels above a coefficient its basis function has its limit's shape: the norm doubles per level.
constexpr unsigned kSimulated = 4;

/// Norms after 0, 1 ... `count` - 1 further levels without details.
std::vector<double> norms(Field start, const Rule& rule, unsigned count) {
    std::vector<double> result{start.norm()};
    while (result.size() < count && result.size() <= kSimulated) {
        start = refined(start, rule, 0);
        result.push_back(start.norm());
    }
    while (result.size() < count) result.push_back(2 * result.back());
    return result;
}

std::vector<double> gains_of(const Rule& rule, unsigned levels) {
    constexpr int kSupport = 5;
    Field vertex(kSupport);
    vertex.at(0, 0) = 1;
    std::vector<double> gains{norms(vertex, rule, levels + 1)[levels]};
    const std::vector<double> detail = norms(refined(Field(kSupport), rule, 1), rule, levels + 1);
    for (unsigned j = 1; j <= levels; ++j) gains.push_back(detail[levels - j]);
    return gains;
}

}  // namespace

std::vector<LevelGain> synthesis_gains(const TransformOptions& options, unsigned levels) {
    const PredictRule predict = predict_rule(options.kind);
    Rule rule{kInterpPosition, {}, ordinary_lifting(options)};
    if (predict == PredictRule::Loop) rule.position = kLoopPosition, rule.loop = true;
    if (predict == PredictRule::Butterfly) rule.position = kButterflyPosition;
    if (predict == PredictRule::Seeded || predict == PredictRule::SeededNormal) rule.shape = kInterpShape;
    const std::vector<double> normal = gains_of(rule, levels);
    std::vector<double> tangential = normal;
    if (predict == PredictRule::SeededNormal) {
        rule.position = {1.0 / 2}, rule.shape = {};
        tangential = gains_of(rule, levels);
    }
    std::vector<LevelGain> gains;
    for (unsigned j = 0; j <= levels; ++j) {
        if (options.local_frames) {
            gains.push_back({normal[j], tangential[j]});
        } else {
            const double mixed = std::sqrt((normal[j] * normal[j] + 2 * tangential[j] * tangential[j]) / 3);
            gains.push_back({mixed, mixed});
        }
    }
    return gains;
}

}  // namespace mvw
