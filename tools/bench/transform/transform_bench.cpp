// Speed of the production transform, as ratios within one run: to a memcpy of the final positions, of interp to vector,
// of one thread to two, and nanoseconds a vertex from 10^5 to 10^7. Run: mvw_bench_transform [--portable]
// (--portable: as on an x86-64 without AVX; must come first)
#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>

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

/// seeded-normal as the codec uses it, with local frames; the others without.
Case& make_case(const Size& size, TransformKind kind, unsigned threads) {
    static std::string name;
    static std::unique_ptr<Case> kept;
    const std::string wanted =
        std::string(size.name) + "/" + std::to_string(unsigned(kind)) + "/" + std::to_string(threads);
    if (kept && name == wanted) return *kept;
    kept.reset();
    const mvw::BaseMesh base = torus(size.w, size.h);
    const auto V = static_cast<std::size_t>(vertices_at_level(base, size.levels));
    const mvw::TransformOptions options{.kind = kind, .local_frames = kind == TransformKind::SeededNormal};
    kept =
        std::make_unique<Case>(Case{mvw::PatchTransform(base, size.levels, options, {}, threads), std::vector<Vec3f>(V),
                                    std::vector<Vec3f>(V), std::vector<Vec3f>(kind == TransformKind::Vector ? V : 0)});
    std::mt19937 random(2);
    for (std::size_t v = 0; v < V; ++v) {
        Vec3f& c = kept->coefficients[v];
        for (std::size_t i = 0; i < 3; ++i) c[i] = 1e-3f * (float(random() % 2001) / 1000 - 1);
        if (v >= base.vertex_count()) continue;
        const std::size_t row = v / size.w;
        const double a = 6.2831853 * double(v % size.w) / size.w, b = 6.2831853 * double(row) / size.h;
        c = {float((3 + std::cos(b)) * std::cos(a)), float((3 + std::cos(b)) * std::sin(a)), float(std::sin(b))};
    }
    kept->transform.synthesize(kept->coefficients, size.levels, kept->positions);
    name = wanted;
    return *kept;
}

std::size_t vertices_of(const Size& size) {
    return static_cast<std::size_t>(vertices_at_level(torus(size.w, size.h), size.levels));
}

using Key = std::tuple<std::string, std::string, TransformKind, unsigned>;  // what, size, of which, threads
std::map<Key, double> least_ns;                                             // a vertex

/// Times each iteration of `work` by the wall clock.
void run(benchmark::State& state, const Key& key, std::size_t vertices, const std::function<void()>& work) {
    using Clock = std::chrono::steady_clock;
    double& least = least_ns.try_emplace(key, 1e300).first->second;
    for (auto _ : state) {  // NOLINT(clang-analyzer-deadcode.DeadStores): the library's loop
        const auto start = Clock::now();
        work();
        const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
        state.SetIterationTime(seconds);
        least = std::min(least, seconds * 1e9 / double(vertices));
    }
    state.counters["least ns/vertex"] = least;
}

void copy(benchmark::State& state, const Size& size) {
    const std::size_t V = vertices_of(size);
    std::vector<Vec3f> from(V, {1, 2, 3}), to(V);
    run(state, {"memcpy", size.name, {}, 1}, V, [&] {
        std::memcpy(to.data(), from.data(), V * sizeof(Vec3f));
        benchmark::ClobberMemory();
    });
}

void synthesis(benchmark::State& state, const Size& size, TransformKind kind, unsigned threads) {
    Case& c = make_case(size, kind, threads);
    std::vector<Vec3f> second(c.second.size());
    run(state, {"synthesis", size.name, kind, threads}, c.positions.size(),
        [&] { c.transform.synthesize(c.coefficients, size.levels, c.positions, c.second, second); });
}

void analysis(benchmark::State& state, const Size& size, TransformKind kind, unsigned threads) {
    Case& c = make_case(size, kind, threads);
    std::vector<Vec3f> coefficients(c.positions.size());
    std::vector<Vec3f> second(c.second.size());
    run(state, {"analysis", size.name, kind, threads}, c.positions.size(),
        [&] { c.transform.analyze(c.positions, coefficients, second); });
}

void add_benchmarks(const Size& size) {
    const auto add = [&](const std::string& name, const auto& function) {
        benchmark::RegisterBenchmark((name + "/" + size.name).c_str(), function)
            ->UseManualTime()
            ->Unit(benchmark::kMicrosecond)
            ->MinTime(0.3);
    };
    add("memcpy", [&size](benchmark::State& state) { copy(state, size); });
    for (const TransformKind kind : {TransformKind::Interp, TransformKind::Vector, TransformKind::SeededNormal})
        for (const unsigned threads : {1u, 2u}) {
            const std::string tail = "/" + std::string(transform_name(kind)) + "/threads:" + std::to_string(threads);
            add("synthesis" + tail, [&size, kind, threads](auto& state) { synthesis(state, size, kind, threads); });
            add("analysis" + tail, [&size, kind, threads](auto& state) { analysis(state, size, kind, threads); });
        }
}

/// Zero where that did not run.
double least(const std::string& what, const Size& size, TransformKind kind = {}, unsigned threads = 1) {
    const auto found = least_ns.find({what, size.name, kind, threads});
    return found == least_ns.end() ? 0 : found->second;
}

void print_ratios(const Size& size, TransformKind kind) {
    const double one = least("synthesis", size, kind), two = least("synthesis", size, kind, 2);
    std::printf("%-6s %-14s %7.2f %10.2f %10.2f %10.2f %10.2f %10.2f %10.2f\n", size.name,
                std::string(transform_name(kind)).c_str(), least("memcpy", size), one, one / least("memcpy", size),
                least("analysis", size, kind) / one, one / two,
                least("analysis", size, kind) / least("analysis", size, kind, 2),
                one / least("synthesis", size, TransformKind::Interp));
}

}  // namespace

int main(int argc, char** argv) {
    const std::string mode = argc > 1 ? argv[1] : "";
    const bool avx2 = mode == "--avx2", portable = mode == "--portable";
    if (avx2) hwy::DisableTargets(HWY_AVX3 | HWY_AVX3_DL);
    if (portable) hwy::DisableTargets(HWY_AVX2 | HWY_AVX3 | HWY_AVX3_DL);
    if (avx2 || portable) --argc, ++argv;
    for (const Size& size : kSizes) add_benchmarks(size);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    std::printf("\nleast times, and their ratios\n%-6s %-14s %7s %10s %10s %10s %10s %10s %10s\n", "size", "transform",
                "memcpy", "synthesis", "/ memcpy", "analysis", "1 thread", "the same,", "/ interp");
    std::printf("%-6s %-14s %7s %10s %10s %10s %10s %10s\n", "", "", "ns", "ns", "", "/synthesis", "/ 2", "analysis");
    for (const Size& size : kSizes)
        for (const TransformKind kind : {TransformKind::Interp, TransformKind::Vector, TransformKind::SeededNormal})
            print_ratios(size, kind);
    return 0;
}
