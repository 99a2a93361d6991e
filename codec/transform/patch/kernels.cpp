#include "codec/transform/patch/kernels.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/transform/patch/kernels.cpp"
#include <hwy/foreach_target.h>
// Highway's own headers come after foreach_target.h.
#include "codec/transform/patch/kernels-inl.h"
#include "codec/transform/patch/listed_kernels-inl.h"
#include "codec/transform/patch/run_kernels-inl.h"
#include "codec/transform/patch/surface_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mvw::HWY_NAMESPACE {

/// Sums over the thirty edges around a vertex two rows and more inside; `v`, `h`: rows i - 2 ... i + 1 of the details
/// at the vertex' k, H and D in turn in the latter.
template <int W>
struct EdgeRows {
    const float *vm1, *vz, *vp1, *hm2, *hm1, *hz, *hp1;

    EdgeRows(const Layout& layout, const float* d, int i, int k)
        : vm1(d + layout.edge(kV, i - 1, k)),
          vz(d + layout.edge(kV, i, k)),
          vp1(d + layout.edge(kV, i + 1, k)),
          hm2(d + layout.edge(kH, i - 2, k)),
          hm1(d + layout.edge(kH, i - 1, k)),
          hz(d + layout.edge(kH, i, k)),
          hp1(d + layout.edge(kH, i + 1, k)) {}
    HWY_INLINE void step() {
        constexpr std::ptrdiff_t S = 3 * W;
        vm1 += S, vz += S, vp1 += S;
        hm2 += 2 * S, hm1 += 2 * S, hz += 2 * S, hp1 += 2 * S;
    }
    static HWY_INLINE Pack<W> along(const float* row, int k) { return load<W>(row + 3 * W * k); }
    static HWY_INLINE Pack<W> H(const float* row, int k) { return load<W>(row + 3 * W * 2 * k); }
    static HWY_INLINE Pack<W> D(const float* row, int k) { return load<W>(row + 3 * W * (2 * k + 1)); }

    [[nodiscard]] HWY_INLINE Pack<W> ends(int p) const {
        return hn::Add(add4(H(hz + p, 0), H(hm1 + p, 0), along(vz + p, 0), along(vz + p, -1)),
                       hn::Add(D(hm1 + p, 0), D(hz + p, -1)));
    }
    [[nodiscard]] HWY_INLINE Pack<W> opp(int p) const {
        return hn::Add(add4(H(hz + p, -1), H(hm1 + p, 1), along(vp1 + p, -1), along(vm1 + p, 0)),
                       hn::Add(D(hz + p, 0), D(hm1 + p, -1)));
    }
    [[nodiscard]] HWY_INLINE Pack<W> wings(int p) const {
        return hn::Add(hn::Add(add4(H(hp1 + p, -1), H(hm1 + p, -1), H(hz + p, 1), H(hm2 + p, 1)),
                               add4(along(vp1 + p, 0), along(vp1 + p, -2), along(vm1 + p, 1), along(vm1 + p, -1))),
                       add4(D(hm1 + p, 1), D(hp1 + p, -1), D(hm2 + p, 0), D(hz + p, -2)));
    }
    [[nodiscard]] HWY_INLINE Pack<W> far(int p) const {
        return hn::Add(add4(H(hp1 + p, 0), H(hm2 + p, 0), along(vz + p, 1), along(vz + p, -2)),
                       hn::Add(D(hm2 + p, 1), D(hp1 + p, -2)));
    }
};

template <int W>
void lift_inside(const Layout& layout, const TenVectors<W>& w, float scale, const float* d, const float* in,
                 float* out) {
    constexpr int N = kLanes<W>, S = 3 * W;
    const auto a = hn::Set(Floats<W>(), scale);
    for (int i = 2; i <= layout.n - 4; ++i) {
        EdgeRows<W> rows(layout, d, i, 2);
        const std::ptrdiff_t start = layout.at(i, 2), end = layout.at(i, layout.n - 2 - i);
        for (std::ptrdiff_t at = start; at <= end; at += S, rows.step())
            for (int p = 0; p < S; p += N) {
                foresee(in + layout.vertex_floats + at + p);
                const auto sum = w.sum(rows.ends(p), rows.opp(p), rows.wings(p), rows.far(p));
                store<W>(hn::MulAdd(a, load<W>(in + at + p), sum), out + at + p);
            }
    }
}

template <int W>
void lift(const Layout& layout, const LiftProgram& program, const FloatWeights& weights, float scale,
          const std::uint32_t* keep, const float* d, const float* in, float* out) {
    constexpr int N = kLanes<W>, S = 3 * W;
    const Floats<W> tag;
    const hn::RebindToUnsigned<Floats<W>> mask_tag;
    const TenVectors<W> w(weights);
    const auto a = hn::Set(tag, scale);
    lift_inside<W>(layout, w, scale, d, in, out);
    const std::uint32_t* edge = program.edges.data();
    const Pack<W> class_weights[4] = {w.ends, w.opp, w.wings, w.far};
    for (const LiftProgram::Point& point : program.points) {
        Pack<W> value[S / N], sum[S / N];
        for (int p = 0; p < S / N; ++p) {
            const auto mask = hn::BitCast(tag, hn::LoadU(mask_tag, keep + point.keep * W + p * N % W));
            foresee(in + layout.vertex_floats + point.vertex + p * N);
            value[p] = hn::Mul(a, hn::And(mask, load<W>(in + point.vertex + p * N)));
        }
        for (std::size_t c = 0; c < 4; ++c) {
            if (point.count[c] == 0) continue;
            for (int p = 0; p < S / N; ++p) sum[p] = load<W>(d + *edge + p * N);
            for (const std::uint32_t* last = edge++ + point.count[c]; edge != last; ++edge)
                for (int p = 0; p < S / N; ++p) sum[p] = hn::Add(sum[p], load<W>(d + *edge + p * N));
            for (int p = 0; p < S / N; ++p) value[p] = hn::MulAdd(class_weights[c], sum[p], value[p]);
        }
        for (int p = 0; p < S / N; ++p) store<W>(value[p], out + point.vertex + p * N);
    }
}

template <int W>
void predict(const Layout& layout, const FloatWeights& position, const FloatWeights& shape_weights, float sign,
             const float* v, const float* shape, float* d) {
    constexpr int N = kLanes<W>, S = 3 * W;
    FloatWeights signed_position = position;
    signed_position.ends *= sign, signed_position.opp *= sign, signed_position.wings *= sign,
        signed_position.far *= sign;
    const TenVectors<W> w(signed_position), wx(shape_weights);
    const auto s = hn::Set(Floats<W>(), sign);
    for (int i = 0; i < layout.n; ++i) {
        const Rows r(layout, v, i), x(layout, shape == nullptr ? v : shape, i);
        float *row = d + layout.edge(kV, i, 0), *pairs = d + layout.edge(kH, i, 0);
        for (std::ptrdiff_t at = 0; at < (layout.n - i) * S; at += S)
            for (int p = 0; p < S; p += N) {
                const TenSums<W> sums(w, r, at + p);
                auto h = sums.h, u = sums.v, g = sums.d;
                if (shape != nullptr) {
                    const TenSums<W> more(wx, x, at + p);
                    h = hn::MulAdd(s, more.h, h), u = hn::MulAdd(s, more.v, u), g = hn::MulAdd(s, more.d, g);
                }
                store<W>(hn::Add(u, load<W>(row + at + p)), row + at + p);
                float *to_h = pairs + 2 * at + p, *to_d = to_h + S;
                store<W>(hn::Add(h, load<W>(to_h)), to_h);
                store<W>(hn::Add(g, load<W>(to_d)), to_d);
            }
    }
}

/// Stores and tells whether that changed a bit.
template <int W>
HWY_INLINE auto changing_store(Pack<W> v, float* to) {
    const hn::RebindToUnsigned<Floats<W>> bits;
    const auto before = hn::BitCast(bits, load<W>(to));
    store<W>(v, to);
    return hn::Xor(before, hn::BitCast(bits, v));
}

template <int W>
bool interleave(const Layout& coarse, const float* v, const float* d, const Layout& fine, float* fine_v) {
    constexpr int N = kLanes<W>, S = 3 * W;
    const hn::RebindToUnsigned<Floats<W>> bits;
    auto changed = hn::Zero(bits);
    for (int i = 0; i <= coarse.n; ++i) {
        const float* even = v + coarse.row(i);
        float* first = fine_v + fine.row(2 * i);
        for (std::ptrdiff_t at = 0; at <= (coarse.n - i) * S; at += S)
            for (int p = 0; p < S; p += N)
                changed = hn::Or(changed, changing_store<W>(load<W>(even + at + p), first + 2 * at + p));
        if (i == coarse.n) break;
        const float *row = d + coarse.edge(kV, i, 0), *pairs = d + coarse.edge(kH, i, 0);
        for (std::ptrdiff_t at = 0; at < (coarse.n - i) * S; at += S)
            for (int p = 0; p < S; p += N)
                changed = hn::Or(changed, changing_store<W>(load<W>(row + at + p), first + 2 * at + S + p));
        float* second = fine_v + fine.row(2 * i + 1);
        for (std::ptrdiff_t at = 0; at < 2 * (coarse.n - i) * S; at += N)
            changed = hn::Or(changed, changing_store<W>(load<W>(pairs + at), second + at));
    }
    return !hn::AllTrue(bits, hn::Eq(changed, hn::Zero(bits)));
}

template <int W>
void deinterleave(const Layout& fine, const float* fine_v, const Layout& coarse, float* v, float* d) {
    constexpr std::size_t point = 3 * W * sizeof(float);
    constexpr std::ptrdiff_t S = 3 * W;
    for (int i = 0; i <= coarse.n; ++i) {
        float* even = v + coarse.row(i);
        const float* first = fine_v + fine.row(2 * i);
        for (std::ptrdiff_t k = 0; k <= coarse.n - i; ++k) std::memcpy(even + k * S, first + 2 * k * S, point);
        if (i == coarse.n) break;
        float *row = d + coarse.edge(kV, i, 0), *pairs = d + coarse.edge(kH, i, 0);
        for (std::ptrdiff_t k = 0; k < coarse.n - i; ++k) std::memcpy(row + k * S, first + (2 * k + 1) * S, point);
        std::memcpy(pairs, fine_v + fine.row(2 * i + 1), 2 * static_cast<std::size_t>(coarse.n - i) * point);
    }
}

template <int W>
Kernels table_of() {
    return {lift<W>,          predict<W>,    predict_along_normal<W>, normals<W>,      shape<W>,
            turn<W>,          interleave<W>, deinterleave<W>,         load_runs<W>,    store_runs<W>,
            copy<W>,          add_back<W>,   add_back_some<W>,        clear_points<W>, lift_listed<W>,
            predict_listed<W>};
}
#if !defined(__wasm__)  // a module that travels carries two widths
Kernels table16() {
    return table_of<16>();
}
Kernels table4() {
    return table_of<4>();
}
#endif
Kernels table8() {
    return table_of<8>();
}
Kernels table1() {
    return table_of<1>();
}

#if !defined(__wasm__)
/// Of the machine's widest vector.
unsigned widest() {
    return static_cast<unsigned>(hn::Lanes(hn::ScalableTag<float>()));
}
#endif

}  // namespace mvw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mvw {

namespace {

HWY_EXPORT(table8);
HWY_EXPORT(table1);
#if !defined(__wasm__)
HWY_EXPORT(table16);
HWY_EXPORT(table4);
HWY_EXPORT(widest);
#endif

struct Slot {
    EdgePlane plane;
    int i, k;
};
/// The thirty edges that lift the vertex (0, 0), by class.
constexpr Slot kLiftedBy[] = {{kH, 0, 0},  {kH, -1, 0},  {kV, 0, 0},  {kV, 0, -1}, {kD, -1, 0}, {kD, 0, -1},   // ends
                              {kH, 0, -1}, {kH, -1, 1},  {kV, 1, -1}, {kV, -1, 0}, {kD, 0, 0},  {kD, -1, -1},  // opp
                              {kH, 1, -1}, {kH, -1, -1}, {kH, 0, 1},  {kH, -2, 1}, {kV, 1, 0},  {kV, 1, -2},
                              {kV, -1, 1}, {kV, -1, -1},                                                       // wings
                              {kD, -1, 1}, {kD, 1, -1},  {kD, -2, 0}, {kD, 0, -2},                             // wings
                              {kH, 1, 0},  {kH, -2, 0},  {kV, 0, 1},  {kV, 0, -2}, {kD, -2, 1}, {kD, 1, -2}};  // far
constexpr std::array<std::size_t, 5> kClassStart{0, 6, 12, 24, 30};

Keep keep_at(int i, int k, int n) {
    const Barycentric b = barycentric(i, k, n);
    if (std::min({b[0], b[1], b[2]}) < 0) return kKeepNone;
    for (unsigned c = 0; c < 3; ++c)
        if (b[c] == n) return static_cast<Keep>(kKeepCorner + c);
    for (unsigned s = 0; s < 3; ++s)
        if (b[(s + 2) % 3] == 0) return static_cast<Keep>(kKeepSide + s);
    return kKeepAll;
}

}  // namespace

LiftProgram make_lift_program(const Layout& layout) {
    const int n = layout.n;
    LiftProgram program;
    struct Entry {
        LiftProgram::Point point;
        std::size_t first, last;  // of `edges`
    };
    std::vector<Entry> entries;
    std::vector<std::uint32_t> edges;
    const auto add = [&](int i, int k) {
        Entry entry{{layout.at(i, k), keep_at(i, k, n), {}}, edges.size(), 0};
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t e = kClassStart[c]; e < kClassStart[c + 1]; ++e) {
                const int a = i + kLiftedBy[e].i, b = k + kLiftedBy[e].k;
                if (a < 0 || b < 0 || a + b >= n) continue;
                edges.push_back(layout.edge(kLiftedBy[e].plane, a, b));
                ++entry.point.count[c];
            }
        entry.last = edges.size();
        entries.push_back(entry);
    };
    for (int i = -1; i <= n; ++i)
        for (int k = i < 0 ? 1 : i == 0 ? 0 : -1; k <= (i <= 0 ? n : n + 1 - i); ++k)
            if (i < 2 || k < 2 || i + k > n - 2) add(i, k);
    // Points of equal counts one after the other: the kernel's loops are then easy to foresee.
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.point.count < b.point.count; });
    program.points.reserve(entries.size());
    program.edges.reserve(edges.size());
    const auto at = [&](std::size_t e) { return edges.begin() + static_cast<std::ptrdiff_t>(e); };
    for (const Entry& entry : entries) {
        program.points.push_back(entry.point);
        program.edges.insert(program.edges.end(), at(entry.first), at(entry.last));
    }
    return program;
}

#if defined(__wasm__)
const Kernels& kernels(unsigned lanes) {
    static const Kernels eight = HWY_DYNAMIC_DISPATCH(table8)(), one = HWY_DYNAMIC_DISPATCH(table1)();
    return lanes == 8 ? eight : one;
}

unsigned lanes_for(std::uint32_t faces) {
    return faces > 2 ? 8 : 1;
}
#else
const Kernels& kernels(unsigned lanes) {
    static const Kernels sixteen = HWY_DYNAMIC_DISPATCH(table16)(), eight = HWY_DYNAMIC_DISPATCH(table8)(),
                         four = HWY_DYNAMIC_DISPATCH(table4)(), one = HWY_DYNAMIC_DISPATCH(table1)();
    return lanes == 16 ? sixteen : lanes == 8 ? eight : lanes == 4 ? four : one;
}

unsigned lanes_for(std::uint32_t faces) {
    static const bool wide = HWY_DYNAMIC_DISPATCH(widest)() >= 16;
    return wide && faces > 64 ? 16 : faces > 4 ? 8 : faces > 2 ? 4 : 1;
}
#endif

}  // namespace mvw
#endif
