// Speed of the production transform, as ratios within one run: to a memcpy of the final positions, of interp to vector,
// of one thread to two, and nanoseconds a vertex from 10^5 to 10^7. Run: mvw_bench_transform [--portable]
// (--portable: as on an x86-64 without AVX; must come first)
#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <random>
#include <string>

#include "codec/transform/transform.h"

namespace {

using mvw::TransformKind;
using mvw::Vec3f;

/// A torus of w x h quads, each cut along a diagonal at random: valences 4 to 8.
mvw::BaseMesh torus(std::uint32_t w, std::uint32_t h) {
    std::mt19937 random(1);
    std::vector<mvw::Face> faces;
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return (y % h) * w + x % w; };
    for (std::uint32_t y = 0; y < h; ++y)
        for (std::uint32_t x = 0; x < w; ++x) {
            const std::uint32_t a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
            if (random() % 2 == 0) {
                faces.push_back({a, b, d});
                faces.push_back({b, c, d});
            } else {
                faces.push_back({a, b, c});
                faces.push_back({a, c, d});
            }
        }
    return mvw::BaseMesh::create(w * h, std::move(faces)).value();
}

struct Size {
    const char* name;
    std::uint32_t w, h;
    unsigned levels;
};
// The paper's feline has 258,046 points, 5 levels over about 504 faces.
constexpr Size kSizes[] = {{"1e5", 7, 14, 5}, {"258k", 14, 18, 5}, {"1e6", 31, 32, 5}, {"1e7", 50, 50, 6}};

/// A transform with coefficients of a bumpy torus; each kept for the runs that share it, one at a time.
struct Case {
    mvw::PatchTransform transform;
    std::vector<Vec3f> positions, coefficients, second;  // second: of the vector transform alone
};

Case& make_case(const Size& size, TransformKind kind, bool frames, unsigned threads) {
    static std::string name;
    static std::unique_ptr<Case> kept;
    const std::string wanted =
        std::string(size.name) + "/" + std::to_string(unsigned(kind)) + (frames ? "f" : "x") + std::to_string(threads);
    if (kept && name == wanted) return *kept;
    kept.reset();
    const mvw::BaseMesh base = torus(size.w, size.h);
    const auto V = static_cast<std::size_t>(vertices_at_level(base, size.levels));
    const mvw::TransformOptions options{.kind = kind, .local_frames = frames};
    kept =
        std::make_unique<Case>(Case{mvw::PatchTransform(base, size.levels, options, {}, threads), std::vector<Vec3f>(V),
                                    std::vector<Vec3f>(V), std::vector<Vec3f>(kind == TransformKind::Vector ? V : 0)});
    std::mt19937 random(2);
    for (std::size_t v = 0; v < V; ++v) {
        Vec3f& c = kept->coefficients[v];
        for (std::size_t i = 0; i < 3; ++i) c[i] = 1e-3f * (float(random() % 2001) / 1000 - 1);
        if (v >= base.vertex_count()) continue;
        const double a = 6.2831853 * double(v % size.w) / size.w, b = 6.2831853 * double(v / size.w) / size.h;
        c = {float((3 + std::cos(b)) * std::cos(a)), float((3 + std::cos(b)) * std::sin(a)), float(std::sin(b))};
    }
    kept->transform.synthesize(kept->coefficients, size.levels, kept->positions);
    name = wanted;
    return *kept;
}

void report(benchmark::State& state, std::size_t vertices) {
    state.counters["ns/vertex"] = benchmark::Counter(
        double(vertices) * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void copy(benchmark::State& state, const Size& size) {
    const auto V = static_cast<std::size_t>(vertices_at_level(torus(size.w, size.h), size.levels));
    std::vector<Vec3f> from(V, {1, 2, 3}), to(V);
    for (auto _ : state) {
        std::memcpy(to.data(), from.data(), V * sizeof(Vec3f));
        benchmark::ClobberMemory();
    }
    report(state, V);
}

void synthesis(benchmark::State& state, const Size& size, TransformKind kind, bool frames, unsigned threads) {
    Case& c = make_case(size, kind, frames, threads);
    std::vector<Vec3f> second(c.second.size());
    for (auto _ : state) c.transform.synthesize(c.coefficients, size.levels, c.positions, c.second, second);
    report(state, c.positions.size());
}

void analysis(benchmark::State& state, const Size& size, TransformKind kind, bool frames, unsigned threads) {
    Case& c = make_case(size, kind, frames, threads);
    std::vector<Vec3f> coefficients(c.positions.size());
    std::vector<Vec3f> second(c.second.size());
    for (auto _ : state) c.transform.analyze(c.positions, coefficients, second);
    report(state, c.positions.size());
}

/// Prints as usual and keeps each run's time for the table of ratios.
class Ratios : public benchmark::ConsoleReporter {
 public:
    void ReportRuns(const std::vector<Run>& runs) override {
        ConsoleReporter::ReportRuns(runs);
        for (const Run& run : runs)
            if (run.run_type == Run::RT_Iteration) {
                double& best = times_.try_emplace(run.benchmark_name(), 1e30).first->second;
                best = std::min(best, run.GetAdjustedRealTime());
            }
    }
    void print(const std::string& what, const std::string& a, const std::string& b) const {
        const auto x = find(a), y = find(b);
        if (x > 0 && y > 0) std::printf("%-52s %6.2f\n", what.c_str(), x / y);
    }

 private:
    /// Least time of the repetitions whose name starts so.
    [[nodiscard]] double find(const std::string& start) const {
        double best = 0;
        for (const auto& [name, time] : times_)
            if (name.rfind(start + "/", 0) == 0 && (best == 0 || time < best)) best = time;
        return best;
    }
    std::map<std::string, double> times_;
};

}  // namespace

int main(int argc, char** argv) {
    const auto options = [](benchmark::internal::Benchmark* b) {
        b->UseRealTime()->Unit(benchmark::kMicrosecond)->MinTime(0.3);
    };
    const auto add = [&](const std::string& name, const Size& size, TransformKind kind, bool frames, unsigned threads) {
        const std::string tail =
            name + "/" + size.name + (frames ? "/frames" : "") + "/threads:" + std::to_string(threads);
        options(benchmark::RegisterBenchmark(("synthesis/" + tail).c_str(), synthesis, size, kind, frames, threads));
        options(benchmark::RegisterBenchmark(("analysis/" + tail).c_str(), analysis, size, kind, frames, threads));
    };
    for (const Size& size : kSizes) {
        options(benchmark::RegisterBenchmark((std::string("memcpy/") + size.name).c_str(), copy, size));
        for (const TransformKind kind : {TransformKind::Interp, TransformKind::Vector, TransformKind::SeededNormal})
            for (const unsigned threads : {1u, 2u})
                add(std::string(transform_name(kind)), size, kind, kind == TransformKind::SeededNormal, threads);
    }
    if (argc > 1 && std::string(argv[1]) == "--portable") {
        hwy::DisableTargets(HWY_AVX2 | HWY_AVX3 | HWY_AVX3_DL);
        --argc, ++argv;
    }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    Ratios ratios;
    benchmark::RunSpecifiedBenchmarks(&ratios);
    std::printf("\n%-52s %6s\n", "ratio (least time of each)", "");
    for (const Size& size : kSizes)
        for (const std::string kind : {"interp", "seeded-normal"}) {
            const std::string at = kind + "/" + size.name + (kind == "interp" ? "" : "/frames");
            const auto one = at + "/threads:1", two = at + "/threads:2";
            ratios.print("synthesis " + at + " / memcpy", "synthesis/" + one, std::string("memcpy/") + size.name);
            ratios.print("analysis " + at + " / synthesis", "analysis/" + one, "synthesis/" + one);
            ratios.print("synthesis " + at + " 1 thread / 2", "synthesis/" + one, "synthesis/" + two);
            if (kind == "interp")
                ratios.print("synthesis vector / interp " + std::string(size.name),
                             std::string("synthesis/vector/") + size.name + "/threads:1", "synthesis/" + one);
        }
    return 0;
}
