// What the kernels' files share: vectors of W lanes or, where the machine's are shorter, pieces of them. Included once
// for each instruction set, hence no usual guard.
#if defined(MVW_KERNELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MVW_KERNELS_INL_H
#undef MVW_KERNELS_INL_H
#else
#define MVW_KERNELS_INL_H
#endif

#include <hwy/highway.h>

#include "codec/transform/patch/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace mvw::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <int W>
using Floats = hn::CappedTag<float, W>;
template <int W>
using Pack = hn::Vec<Floats<W>>;
/// Lanes of one vector.
template <int W>
inline constexpr int kLanes = static_cast<int>(hn::MaxLanes(Floats<W>()));

template <int W>
HWY_INLINE Pack<W> load(const float* from) {
    return hn::LoadU(Floats<W>(), from);
}
template <int W>
HWY_INLINE void store(Pack<W> v, float* to) {
    hn::StoreU(v, Floats<W>(), to);
}
/// Asks for a cache line that the next group will want: its points lie too far apart for the machine to guess.
HWY_INLINE void foresee(const float* at) {
    __builtin_prefetch(at, 0, 2);
}
template <typename V>
HWY_INLINE V add4(V a, V b, V c, V d) {
    return hn::Add(hn::Add(a, b), hn::Add(c, d));
}

/// Rows i - 1 ... i + 2 of a group's vertices.
struct Rows {
    const float *m1, *z, *p1, *p2;

    Rows(const Layout& layout, const float* v, int i)
        : m1(v + layout.row(i - 1)), z(v + layout.row(i)), p1(v + layout.row(i + 1)), p2(v + layout.row(i + 2)) {}
};

template <int W>
struct TenVectors {
    using V = Pack<W>;
    V ends, opp, wings, far;

    explicit TenVectors(const FloatWeights& w)
        : ends(hn::Set(Floats<W>(), w.ends)),
          opp(hn::Set(Floats<W>(), w.opp)),
          wings(hn::Set(Floats<W>(), w.wings)),
          far(hn::Set(Floats<W>(), w.far)) {}

    [[nodiscard]] HWY_INLINE V sum(V e, V o, V w, V f) const {
        return hn::MulAdd(ends, e, hn::MulAdd(opp, o, hn::MulAdd(wings, w, hn::Mul(far, f))));
    }
};

/// The ten-point sums of the edges H, V and D at one place `at` of the rows.
template <int W>
struct TenSums {
    using V = Pack<W>;
    V h, v, d;

    HWY_INLINE TenSums(const TenVectors<W>& w, const Rows& r, std::ptrdiff_t at) {
        constexpr std::ptrdiff_t S = 3 * W;
        const V m0 = load<W>(r.m1 + at), m1 = load<W>(r.m1 + at + S), m2 = load<W>(r.m1 + at + 2 * S);
        const V zm = load<W>(r.z + at - S), z0 = load<W>(r.z + at), z1 = load<W>(r.z + at + S),
                z2 = load<W>(r.z + at + 2 * S);
        const V pm = load<W>(r.p1 + at - S), p0 = load<W>(r.p1 + at), p1 = load<W>(r.p1 + at + S);
        const V qm = load<W>(r.p2 + at - S), q0 = load<W>(r.p2 + at);
        h = w.sum(hn::Add(z0, p0), hn::Add(z1, pm), add4(m1, p1, zm, qm), hn::Add(m0, q0));
        v = w.sum(hn::Add(z0, z1), hn::Add(m1, p0), add4(m0, m2, pm, p1), hn::Add(zm, z2));
        d = w.sum(hn::Add(p0, z1), hn::Add(z0, p1), add4(pm, m1, q0, z2), hn::Add(qm, m2));
    }
};

}  // namespace mvw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
