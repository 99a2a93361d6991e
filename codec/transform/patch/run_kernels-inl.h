// Kernels between hierarchical arrays, where each patch has runs of its own, and groups, where patches lie in lanes:
// blocks of floats transposed in registers.
#if defined(MVW_RUN_KERNELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MVW_RUN_KERNELS_INL_H
#undef MVW_RUN_KERNELS_INL_H
#else
#define MVW_RUN_KERNELS_INL_H
#endif

#include <algorithm>

#include "codec/transform/patch/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mvw::HWY_NAMESPACE {

/// rows[a][b] <-> rows[b][a], for vectors of 8, 4 or 1 lanes.
template <int W>
HWY_INLINE void transpose([[maybe_unused]] Pack<W> (&rows)[kLanes<W>]) {
    static_assert(kLanes<W> <= 8);
#if HWY_TARGET != HWY_SCALAR
    constexpr int N = kLanes<W>;
    if constexpr (N > 1) {
        const Floats<W> tag;
        const hn::Repartition<double, Floats<W>> wide;
        Pack<W> pairs[N];
        for (int r = 0; r < N; r += 2) {
            pairs[r] = hn::InterleaveLower(tag, rows[r], rows[r + 1]);
            pairs[r + 1] = hn::InterleaveUpper(tag, rows[r], rows[r + 1]);
        }
        Pack<W> fours[N];
        for (int r = 0; r < N; r += 4)
            for (int half = 0; half < 2; ++half) {
                const auto a = hn::BitCast(wide, pairs[r + half]), b = hn::BitCast(wide, pairs[r + 2 + half]);
                fours[r + 2 * half] = hn::BitCast(tag, hn::InterleaveLower(wide, a, b));
                fours[r + 2 * half + 1] = hn::BitCast(tag, hn::InterleaveUpper(wide, a, b));
            }
        if constexpr (N == 4) {
            for (int r = 0; r < 4; ++r) rows[r] = fours[r];
        } else {
            for (int r = 0; r < 4; ++r) {
                rows[r] = hn::ConcatLowerLower(tag, fours[r + 4], fours[r]);
                rows[r + 4] = hn::ConcatUpperUpper(tag, fours[r + 4], fours[r]);
            }
        }
    }
#endif
}

/// Asks for the cache lines in which the next group's runs have what this group's have at `at`: runs of a level follow
/// one another face by face, too short for the machine to foresee their starts.
template <int W, bool kWrite>
HWY_INLINE void foresee_runs(const float* const* runs, std::size_t length, std::size_t at) {
    constexpr std::size_t kLine = 16;
    if (at % kLine != 0) return;
    for (std::size_t lane = 0; lane < W; ++lane)
        __builtin_prefetch(reinterpret_cast<const char*>(runs[lane]) + (W * length + at) * sizeof(float),
                           kWrite ? 1 : 0, 2);
}

template <int W>
void load_runs(const std::vector<std::uint32_t>& run_places, const float* const* runs, unsigned used, bool follow,
               float* to) {
    constexpr int B = std::min(W, 8);
    constexpr std::size_t N = kLanes<B>;
    const std::size_t length = run_places.size();
    const std::uint32_t* places = run_places.data();
    std::size_t at = 0;
    if (used == W)
        for (; at + N <= length; at += N) {
            if (follow) foresee_runs<W, false>(runs, length, at);
            for (std::size_t part = 0; part < W; part += N) {
                Pack<B> rows[N];
                for (std::size_t r = 0; r < N; ++r) rows[r] = load<B>(runs[part + r] + at);
                transpose<B>(rows);
                for (std::size_t r = 0; r < N; ++r) store<B>(rows[r], to + places[at + r] + part);
            }
        }
    for (; at < length; ++at)
        for (unsigned lane = 0; lane < used; ++lane) to[places[at] + lane] = runs[lane][at];
}

template <int W>
void store_runs(const std::vector<std::uint32_t>& run_places, float* const* runs, unsigned used, bool follow,
                const float* from) {
    constexpr int B = std::min(W, 8);
    constexpr std::size_t N = kLanes<B>;
    const std::size_t length = run_places.size();
    const std::uint32_t* places = run_places.data();
    std::size_t at = 0;
    if (used == W)
        for (; at + N <= length; at += N) {
            if (follow) foresee_runs<W, true>(runs, length, at);
            for (std::size_t part = 0; part < W; part += N) {
                Pack<B> rows[N];
                for (std::size_t r = 0; r < N; ++r) rows[r] = load<B>(from + places[at + r] + part);
                transpose<B>(rows);
                for (std::size_t r = 0; r < N; ++r) store<B>(rows[r], runs[part + r] + at);
            }
        }
    for (; at < length; ++at)
        for (unsigned lane = 0; lane < used; ++lane) runs[lane][at] = from[places[at] + lane];
}

template <int W>
void copy(std::span<const Copy> copies, const float* from, float* to) {
    for (const Copy& c : copies) {
        const float x = from[c.from], y = from[c.from + W], z = from[c.from + 2 * W];
        to[c.to] = x, to[c.to + W] = y, to[c.to + 2 * W] = z;
    }
}
template <int W>
void add_back(std::span<const Copy> copies, const float* from, float* to) {
    for (const Copy& c : copies) {
        const float x = from[c.to], y = from[c.to + W], z = from[c.to + 2 * W];
        to[c.from] += x, to[c.from + W] += y, to[c.from + 2 * W] += z;
    }
}
template <int W>
void clear_points(std::span<const std::uint32_t> places, float* to) {
    for (const std::uint32_t place : places) to[place] = to[place + W] = to[place + 2 * W] = 0;
}

template <int W>
void add_back_some(std::span<const std::uint32_t> which, const Copy* copies, float* v) {
    for (const std::uint32_t i : which) add_back<W>({copies + i, 1}, v, v);
}

}  // namespace mvw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
