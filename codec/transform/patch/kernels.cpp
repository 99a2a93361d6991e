#include "codec/transform/patch/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/transform/patch/kernels.cpp"
#include <hwy/foreach_target.h>
// Highway's own headers come after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mvw::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Rows are short: more than eight lanes would mostly be idle.
using Floats = hn::CappedTag<float, 8>;
using V = hn::Vec<Floats>;

/// Writes the first `count` lanes: what lies behind a row's end belongs to the next row or to a ghost.
HWY_INLINE void store_row(V v, float* to, int count) {
    const Floats tag;
    if (count >= static_cast<int>(hn::Lanes(tag)))
        hn::StoreU(v, tag, to);
    else
        hn::BlendedStore(v, hn::FirstN(tag, static_cast<std::size_t>(count)), tag, to);
}
HWY_INLINE V load(const float* from) {
    return hn::LoadU(Floats(), from);
}

/// Rows i - 2 ... i + 2 of a plane, each from its k = 0.
struct Rows {
    const float *m2, *m1, *z, *p1, *p2;

    Rows(const Layout& layout, const float* plane, int i)
        : m2(plane + layout.row(i - 2)),
          m1(plane + layout.row(i - 1)),
          z(plane + layout.row(i)),
          p1(plane + layout.row(i + 1)),
          p2(plane + layout.row(i + 2)) {}
};

struct TenVectors {
    V ends, opp, wings, far;

    explicit TenVectors(const FloatWeights& w)
        : ends(hn::Set(Floats(), w.ends)),
          opp(hn::Set(Floats(), w.opp)),
          wings(hn::Set(Floats(), w.wings)),
          far(hn::Set(Floats(), w.far)) {}

    [[nodiscard]] HWY_INLINE V sum(V e, V o, V w, V f) const {
        return hn::MulAdd(ends, e, hn::MulAdd(opp, o, hn::MulAdd(wings, w, hn::Mul(far, f))));
    }
};

HWY_INLINE V add4(V a, V b, V c, V d) {
    return hn::Add(hn::Add(a, b), hn::Add(c, d));
}

HWY_INLINE V ten_h(const TenVectors& w, const Rows& r, int k) {
    return w.sum(hn::Add(load(r.z + k), load(r.p1 + k)), hn::Add(load(r.z + k + 1), load(r.p1 + k - 1)),
                 add4(load(r.m1 + k + 1), load(r.p1 + k + 1), load(r.z + k - 1), load(r.p2 + k - 1)),
                 hn::Add(load(r.m1 + k), load(r.p2 + k)));
}
HWY_INLINE V ten_v(const TenVectors& w, const Rows& r, int k) {
    return w.sum(hn::Add(load(r.z + k), load(r.z + k + 1)), hn::Add(load(r.m1 + k + 1), load(r.p1 + k)),
                 add4(load(r.m1 + k), load(r.m1 + k + 2), load(r.p1 + k - 1), load(r.p1 + k + 1)),
                 hn::Add(load(r.z + k - 1), load(r.z + k + 2)));
}
HWY_INLINE V ten_d(const TenVectors& w, const Rows& r, int k) {
    return w.sum(hn::Add(load(r.p1 + k), load(r.z + k + 1)), hn::Add(load(r.z + k), load(r.p1 + k + 1)),
                 add4(load(r.p1 + k - 1), load(r.m1 + k + 1), load(r.p2 + k), load(r.z + k + 2)),
                 hn::Add(load(r.p2 + k - 1), load(r.m1 + k + 2)));
}

void lift(const Layout& layout, const FloatWeights& weights, float sign, const float* d, float* v) {
    FloatWeights signed_weights = weights;
    signed_weights.ends *= sign, signed_weights.opp *= sign, signed_weights.wings *= sign, signed_weights.far *= sign;
    const TenVectors w(signed_weights);
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    for (int i = 0; i <= layout.n; ++i) {
        for (unsigned c = 0; c < 3; ++c) {
            const float* planes = d + std::size_t{3} * c * layout.plane;
            const Rows H(layout, planes, i), W(layout, planes + layout.plane, i),
                D(layout, planes + std::size_t{2} * layout.plane, i);
            float* out = v + std::size_t{c} * layout.plane + layout.row(i);
            for (int k = 0; k <= layout.n - i; k += lanes) {
                const V ends = hn::Add(add4(load(H.z + k), load(H.m1 + k), load(W.z + k), load(W.z + k - 1)),
                                       hn::Add(load(D.m1 + k), load(D.z + k - 1)));
                const V opp = hn::Add(add4(load(H.z + k - 1), load(H.m1 + k + 1), load(W.p1 + k - 1), load(W.m1 + k)),
                                      hn::Add(load(D.z + k), load(D.m1 + k - 1)));
                const V wings =
                    hn::Add(hn::Add(add4(load(H.p1 + k - 1), load(H.m1 + k - 1), load(H.z + k + 1), load(H.m2 + k + 1)),
                                    add4(load(W.p1 + k), load(W.p1 + k - 2), load(W.m1 + k + 1), load(W.m1 + k - 1))),
                            add4(load(D.m1 + k + 1), load(D.p1 + k - 1), load(D.m2 + k), load(D.z + k - 2)));
                const V far = hn::Add(add4(load(H.p1 + k), load(H.m2 + k), load(W.z + k + 1), load(W.z + k - 2)),
                                      hn::Add(load(D.m2 + k + 1), load(D.p1 + k - 2)));
                store_row(hn::Add(load(out + k), w.sum(ends, opp, wings, far)), out + k, layout.n - i + 1 - k);
            }
        }
    }
}

void predict(const Layout& layout, const FloatWeights& position, const FloatWeights& shape_weights, float sign,
             const float* v, const float* shape, float* d) {
    const TenVectors w(position), wx(shape_weights);
    const V s = hn::Set(Floats(), sign);
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    for (int i = 0; i < layout.n; ++i)
        for (unsigned c = 0; c < 3; ++c) {
            const Rows r(layout, v + std::size_t{c} * layout.plane, i);
            float* out = d + std::size_t{3} * c * layout.plane + layout.row(i);
            for (int k = 0; k < layout.n - i; k += lanes) {
                V h = ten_h(w, r, k), u = ten_v(w, r, k), g = ten_d(w, r, k);
                if (shape != nullptr) {
                    const Rows x(layout, shape + std::size_t{c} * layout.plane, i);
                    h = hn::Add(h, ten_h(wx, x, k)), u = hn::Add(u, ten_v(wx, x, k)), g = hn::Add(g, ten_d(wx, x, k));
                }
                float* at = out + k;
                const int count = layout.n - i - k;
                store_row(hn::MulAdd(s, h, load(at)), at, count);
                at += layout.plane;
                store_row(hn::MulAdd(s, u, load(at)), at, count);
                at += layout.plane;
                store_row(hn::MulAdd(s, g, load(at)), at, count);
            }
        }
}

struct Vector {
    V x, y, z;
};
HWY_INLINE Vector load3(const float* from, std::size_t plane) {
    return {load(from), load(from + plane), load(from + 2 * plane)};
}
HWY_INLINE Vector operator+(const Vector& a, const Vector& b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vector operator-(const Vector& a, const Vector& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector scaled(const Vector& a, V s) {
    return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
/// a + s b
HWY_INLINE Vector mul_add(V s, const Vector& b, const Vector& a) {
    return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
HWY_INLINE V dot3(const Vector& a, const Vector& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vector cross3(const Vector& a, const Vector& b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE void store3(const Vector& v, float* to, std::size_t plane, int count) {
    store_row(v.x, to, count);
    store_row(v.y, to + plane, count);
    store_row(v.z, to + 2 * plane, count);
}
/// Unit vector, or zero where a is shorter than the square root of the smallest normal float.
HWY_INLINE Vector normalized3(const Vector& a) {
    const Floats tag;
    const V square = dot3(a, a);
    const auto some = hn::Gt(square, hn::Set(tag, 1e-37f));
    const V inverse = hn::Div(hn::Set(tag, 1.0f), hn::Sqrt(hn::IfThenElse(some, square, hn::Set(tag, 1.0f))));
    return scaled(a, hn::IfThenElseZero(some, inverse));
}

void normals(const Layout& layout, const float* v, float* out) {
    const std::size_t plane = layout.plane;
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    for (int i = 0; i <= layout.n; ++i) {
        const float *m = v + layout.row(i - 1), *z = v + layout.row(i), *p = v + layout.row(i + 1);
        for (int k = 0; k <= layout.n - i; k += lanes) {
            // The ring in turn; its area vector is that of two quads.
            const Vector q0 = load3(p + k, plane), q1 = load3(z + k + 1, plane), q2 = load3(m + k + 1, plane),
                         q3 = load3(m + k, plane), q4 = load3(z + k - 1, plane), q5 = load3(p + k - 1, plane);
            const Vector area = cross3(q2 - q0, q3 - q1) + cross3(q4 - q0, q5 - q3);
            store3(normalized3(area), out + layout.row(i) + k, plane, layout.n - i + 1 - k);
        }
    }
}

void shape(const Layout& layout, const float* v, const float* normal, float* out) {
    const std::size_t plane = layout.plane;
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    const V quarter = hn::Set(Floats(), 0.25f), minus = hn::Set(Floats(), -1.0f / 24);
    for (int i = 0; i <= layout.n; ++i) {
        const float *m = v + layout.row(i - 1), *z = v + layout.row(i), *p = v + layout.row(i + 1);
        for (int k = 0; k <= layout.n - i; k += lanes) {
            const Vector ring =
                ((load3(p + k, plane) + load3(m + k, plane)) + (load3(z + k + 1, plane) + load3(z + k - 1, plane))) +
                (load3(m + k + 1, plane) + load3(p + k - 1, plane));
            Vector x = mul_add(minus, ring, scaled(load3(z + k, plane), quarter));
            if (normal != nullptr) {
                const Vector N = load3(normal + layout.row(i) + k, plane);
                x = scaled(N, dot3(N, x));
            }
            store3(x, out + layout.row(i) + k, plane, layout.n - i + 1 - k);
        }
    }
}

void predict_along_normal(const Layout& layout, const FloatWeights& position, const FloatWeights& shape_weights,
                          float sign, const float* v, const float* shape_x, const float* normal, float* d) {
    const TenVectors w(position), wx(shape_weights);
    const std::size_t plane = layout.plane;
    const V s = hn::Set(Floats(), sign), half = hn::Set(Floats(), 0.5f);
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    for (int i = 0; i < layout.n; ++i) {
        const Rows rx(layout, v, i), ry(layout, v + plane, i), rz(layout, v + 2 * plane, i);
        const Rows sx(layout, shape_x, i), sy(layout, shape_x + plane, i), sz(layout, shape_x + 2 * plane, i);
        const std::ptrdiff_t z = layout.row(i), p = layout.row(i + 1);
        for (int k = 0; k < layout.n - i; k += lanes) {
            const int count = layout.n - i - k;
            const auto finish = [&](const Vector& Q, std::ptrdiff_t a, std::ptrdiff_t b, std::size_t edge_plane) {
                const Vector n = normalized3(load3(normal + a, plane) + load3(normal + b, plane));
                const Vector m = scaled(load3(v + a, plane) + load3(v + b, plane), half);
                const Vector P = mul_add(dot3(n, Q - m), n, m);
                float* at = d + edge_plane * plane + z + k;
                store3(mul_add(s, P, load3(at, 3 * plane)), at, 3 * plane, count);
            };
            finish({hn::Add(ten_h(w, rx, k), ten_h(wx, sx, k)), hn::Add(ten_h(w, ry, k), ten_h(wx, sy, k)),
                    hn::Add(ten_h(w, rz, k), ten_h(wx, sz, k))},
                   z + k, p + k, kH);
            finish({hn::Add(ten_v(w, rx, k), ten_v(wx, sx, k)), hn::Add(ten_v(w, ry, k), ten_v(wx, sy, k)),
                    hn::Add(ten_v(w, rz, k), ten_v(wx, sz, k))},
                   z + k + 1, z + k, kV);
            finish({hn::Add(ten_d(w, rx, k), ten_d(wx, sx, k)), hn::Add(ten_d(w, ry, k), ten_d(wx, sy, k)),
                    hn::Add(ten_d(w, rz, k), ten_d(wx, sz, k))},
                   p + k, z + k + 1, kD);
        }
    }
}

/// frames.h in lanes.
struct Frames {
    Vector n, t, b;

    Frames(const Vector& normal_sum, const Vector& edge) {
        const Floats tag;
        const V one = hn::Set(tag, 1.0f), zero = hn::Zero(tag), sine = hn::Set(tag, 1e-3f);
        const V length_n = hn::Sqrt(dot3(normal_sum, normal_sum));
        const auto some = hn::Gt(length_n, sine);
        const Vector unit = scaled(normal_sum, hn::Div(one, hn::IfThenElse(some, length_n, one)));
        n = {hn::IfThenElseZero(some, unit.x), hn::IfThenElseZero(some, unit.y), hn::IfThenElse(some, unit.z, one)};
        Vector flat = edge - scaled(n, dot3(n, edge));
        const V length_t = hn::Sqrt(dot3(flat, flat));
        const auto good = hn::Gt(length_t, hn::Mul(sine, hn::Sqrt(dot3(edge, edge))));
        const auto along_x = hn::Lt(hn::Abs(n.x), hn::Set(tag, 0.6f));
        const Vector axis{hn::IfThenElse(along_x, one, zero), hn::IfThenElse(along_x, zero, one), zero};
        const Vector stand_in = axis - scaled(n, dot3(n, axis));
        flat = {hn::IfThenElse(good, flat.x, stand_in.x), hn::IfThenElse(good, flat.y, stand_in.y),
                hn::IfThenElse(good, flat.z, stand_in.z)};
        t = scaled(flat, hn::Div(one, hn::Sqrt(dot3(flat, flat))));
        b = cross3(n, t);
    }
};

void turn(const Layout& layout, bool to_model, const float* v, const float* normal, float* d) {
    const std::size_t plane = layout.plane;
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    for (int i = 0; i < layout.n; ++i) {
        const std::ptrdiff_t z = layout.row(i), p = layout.row(i + 1);
        for (int k = 0; k < layout.n - i; k += lanes) {
            const auto turn_one = [&](std::ptrdiff_t from, std::ptrdiff_t to, std::size_t edge_plane) {
                const Frames f(load3(normal + from, plane) + load3(normal + to, plane),
                               load3(v + to, plane) - load3(v + from, plane));
                float* at = d + edge_plane * plane + z + k;
                const Vector c = load3(at, 3 * plane);
                const Vector turned = to_model ? mul_add(c.x, f.n, mul_add(c.y, f.t, scaled(f.b, c.z)))
                                               : Vector{dot3(f.n, c), dot3(f.t, c), dot3(f.b, c)};
                store3(turned, at, 3 * plane, layout.n - i - k);
            };
            turn_one(z + k, p + k, kH);
            turn_one(z + k + 1, z + k, kV);
            turn_one(p + k, z + k + 1, kD);
        }
    }
}

void interleave(const Layout& coarse, const float* v, const float* d, const Layout& fine, float* fine_v) {
    const Floats tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    for (unsigned c = 0; c < 3; ++c) {
        const float *even = v + std::size_t{c} * coarse.plane, *odd = d + std::size_t{3} * c * coarse.plane;
        float* out = fine_v + std::size_t{c} * fine.plane;
        // Each pair of stores may run over into ghosts or the next row, which is written later.
        for (int i = 0; i <= coarse.n; ++i) {
            const std::ptrdiff_t z = coarse.row(i);
            float* first = out + fine.row(2 * i);
            for (int k = 0; k <= coarse.n - i; k += lanes)
                hn::StoreInterleaved2(load(even + z + k), load(odd + coarse.plane + z + k), tag, first + 2 * k);
            if (i == coarse.n) break;
            float* second = out + fine.row(2 * i + 1);
            for (int k = 0; k < coarse.n - i; k += lanes)
                hn::StoreInterleaved2(load(odd + z + k), load(odd + std::size_t{2} * coarse.plane + z + k), tag,
                                      second + 2 * k);
        }
    }
}

void deinterleave(const Layout& fine, const float* fine_v, const Layout& coarse, float* v, float* d) {
    const Floats tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    for (unsigned c = 0; c < 3; ++c) {
        float *even = v + std::size_t{c} * coarse.plane, *odd = d + std::size_t{3} * c * coarse.plane;
        const float* in = fine_v + std::size_t{c} * fine.plane;
        for (int i = 0; i <= coarse.n; ++i) {
            const std::ptrdiff_t z = coarse.row(i);
            const float* first = in + fine.row(2 * i);
            for (int k = 0; k <= coarse.n - i; k += lanes) {
                V a, b;
                hn::LoadInterleaved2(tag, first + 2 * k, a, b);
                store_row(a, even + z + k, coarse.n - i + 1 - k);
                if (coarse.n - i - k > 0) store_row(b, odd + coarse.plane + z + k, coarse.n - i - k);
            }
            if (i == coarse.n) break;
            const float* second = in + fine.row(2 * i + 1);
            for (int k = 0; k < coarse.n - i; k += lanes) {
                V a, b;
                hn::LoadInterleaved2(tag, second + 2 * k, a, b);
                store_row(a, odd + z + k, coarse.n - i - k);
                store_row(b, odd + std::size_t{2} * coarse.plane + z + k, coarse.n - i - k);
            }
        }
    }
}

/// Runs of a face in order: for each odd row of the next level, pairs D(i,k) H(i,k+1); for each even one V(i,k). A
/// row's last vector may reach into the run's later rows: `left` points remain from the row's start to the run's end.
template <typename Pairs, typename Singles>
void visit_runs(const Layout& layout, Pairs pairs, Singles singles) {
    const int total = 3 * layout.n * (layout.n - 1) / 2;
    int at = 0;
    for (int i = 0; i < layout.n; ++i) {
        if (i > 0) singles(i, layout.n - i, at, total - at);
        if (i > 0) at += layout.n - i;
        pairs(i, layout.n - 1 - i, at, total - at);
        at += 2 * (layout.n - 1 - i);
    }
}

// With one lane (Highway's portable code) pairs need no shuffling: the loops over single points serve.
#if HWY_TARGET != HWY_SCALAR
/// a0 b0 a1 b1 ...: the first and second half.
HWY_INLINE void interleave_lanes(V a, V b, V& low, V& high) {
    const Floats tag;
    low = hn::InterleaveLower(tag, a, b);
    high = hn::InterleaveUpper(tag, a, b);
#if HWY_MAX_BYTES > 16  // both work within blocks of four
    const V blocks = low;
    low = hn::ConcatLowerLower(tag, high, blocks);
    high = hn::ConcatUpperUpper(tag, high, blocks);
#endif
}
HWY_INLINE Vector even_lanes(const Vector& low, const Vector& high) {
    const Floats tag;
    return {hn::ConcatEven(tag, high.x, low.x), hn::ConcatEven(tag, high.y, low.y), hn::ConcatEven(tag, high.z, low.z)};
}
HWY_INLINE Vector odd_lanes(const Vector& low, const Vector& high) {
    const Floats tag;
    return {hn::ConcatOdd(tag, high.x, low.x), hn::ConcatOdd(tag, high.y, low.y), hn::ConcatOdd(tag, high.z, low.z)};
}
#endif

void load_details(const Layout& layout, const Vec3f* run, float* d) {
    const Floats tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    const std::size_t plane = layout.plane;
    const auto singles = [&](int i, int count, int at, int left) {
        float* out = d + plane + layout.row(i);
        int k = 0;
        for (; k < count && k + lanes <= left; k += lanes) {
            Vector p;
            hn::LoadInterleaved3(tag, &run[at + k].x, p.x, p.y, p.z);
            store3(p, out + k, 3 * plane, count - k);
        }
        for (; k < count; ++k)
            for (std::size_t c = 0; c < 3; ++c) out[3 * c * plane + std::size_t(k)] = run[at + k][c];
    };
    const auto pairs = [&](int i, int count, int at, [[maybe_unused]] int left) {
        float *H = d + layout.row(i) + 1, *D = d + 2 * plane + layout.row(i);
        int k = 0;
#if HWY_TARGET != HWY_SCALAR
        for (; k < count && 2 * (k + lanes) <= left; k += lanes) {
            Vector p, q;
            hn::LoadInterleaved3(tag, &run[at + 2 * k].x, p.x, p.y, p.z);
            hn::LoadInterleaved3(tag, &run[at + 2 * k + lanes].x, q.x, q.y, q.z);
            store3(even_lanes(p, q), D + k, 3 * plane, count - k);
            store3(odd_lanes(p, q), H + k, 3 * plane, count - k);
        }
#endif
        for (; k < count; ++k)
            for (std::size_t c = 0; c < 3; ++c) {
                D[3 * c * plane + std::size_t(k)] = run[at + 2 * k][c];
                H[3 * c * plane + std::size_t(k)] = run[at + 2 * k + 1][c];
            }
    };
    visit_runs(layout, pairs, singles);
}

void store_details(const Layout& layout, const float* d, Vec3f* run) {
    const Floats tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    const std::size_t plane = layout.plane;
    const auto singles = [&](int i, int count, int at, int left) {
        const float* in = d + plane + layout.row(i);
        int k = 0;
        for (; k < count && k + lanes <= left; k += lanes) {
            const Vector p = load3(in + k, 3 * plane);
            hn::StoreInterleaved3(p.x, p.y, p.z, tag, &run[at + k].x);
        }
        for (; k < count; ++k)
            for (std::size_t c = 0; c < 3; ++c) run[at + k][c] = in[3 * c * plane + std::size_t(k)];
    };
    const auto pairs = [&](int i, int count, int at, [[maybe_unused]] int left) {
        const float *H = d + layout.row(i) + 1, *D = d + 2 * plane + layout.row(i);
        int k = 0;
#if HWY_TARGET != HWY_SCALAR
        for (; k < count && 2 * (k + lanes) <= left; k += lanes) {
            const Vector p = load3(D + k, 3 * plane), q = load3(H + k, 3 * plane);
            Vector low, high;
            interleave_lanes(p.x, q.x, low.x, high.x);
            interleave_lanes(p.y, q.y, low.y, high.y);
            interleave_lanes(p.z, q.z, low.z, high.z);
            hn::StoreInterleaved3(low.x, low.y, low.z, tag, &run[at + 2 * k].x);
            hn::StoreInterleaved3(high.x, high.y, high.z, tag, &run[at + 2 * k + lanes].x);
        }
#endif
        for (; k < count; ++k)
            for (std::size_t c = 0; c < 3; ++c) {
                run[at + 2 * k][c] = D[3 * c * plane + std::size_t(k)];
                run[at + 2 * k + 1][c] = H[3 * c * plane + std::size_t(k)];
            }
    };
    visit_runs(layout, pairs, singles);
}

void loop_even(const Layout& layout, bool inverse, const float* d, float* v) {
    const Floats tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    const V a = hn::Set(tag, inverse ? 2.5f : 0.4f), b = hn::Set(tag, inverse ? -0.25f : 0.1f);
    for (int i = 0; i <= layout.n; ++i)
        for (unsigned c = 0; c < 3; ++c) {
            const float* planes = d + std::size_t{3} * c * layout.plane;
            const Rows H(layout, planes, i), W(layout, planes + layout.plane, i),
                D(layout, planes + std::size_t{2} * layout.plane, i);
            float* out = v + std::size_t{c} * layout.plane + layout.row(i);
            for (int k = 0; k <= layout.n - i; k += lanes) {
                const V sum = hn::Add(add4(load(H.z + k), load(H.m1 + k), load(W.z + k), load(W.z + k - 1)),
                                      hn::Add(load(D.m1 + k), load(D.z + k - 1)));
                store_row(hn::MulAdd(a, load(out + k), hn::Mul(b, sum)), out + k, layout.n - i + 1 - k);
            }
        }
}

Kernels kernel_table() {
    return {lift,       predict,      predict_along_normal, normals,       shape,    turn,
            interleave, deinterleave, load_details,         store_details, loop_even};
}

}  // namespace mvw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mvw {

HWY_EXPORT(kernel_table);

const Kernels& kernels() {
    static const Kernels table = HWY_DYNAMIC_DISPATCH(kernel_table)();
    return table;
}

}  // namespace mvw
#endif
