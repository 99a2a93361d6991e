// Kernels that need all three components at once: normals, shape components, frames, prediction along the normal.
#if defined(MVW_SURFACE_KERNELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MVW_SURFACE_KERNELS_INL_H
#undef MVW_SURFACE_KERNELS_INL_H
#else
#define MVW_SURFACE_KERNELS_INL_H
#endif

#include "codec/transform/patch/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mvw::HWY_NAMESPACE {

template <int W>
struct Vector {
    using V = Pack<W>;
    V x, y, z;

    friend HWY_INLINE Vector operator+(const Vector& a, const Vector& b) {
        return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
    }
    friend HWY_INLINE Vector operator-(const Vector& a, const Vector& b) {
        return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
    }
    [[nodiscard]] HWY_INLINE Vector scaled(V s) const { return {hn::Mul(x, s), hn::Mul(y, s), hn::Mul(z, s)}; }
    /// *this + s b
    [[nodiscard]] HWY_INLINE Vector plus(V s, const Vector& b) const {
        return {hn::MulAdd(s, b.x, x), hn::MulAdd(s, b.y, y), hn::MulAdd(s, b.z, z)};
    }
    [[nodiscard]] HWY_INLINE V dot(const Vector& b) const {
        return hn::MulAdd(x, b.x, hn::MulAdd(y, b.y, hn::Mul(z, b.z)));
    }
    [[nodiscard]] HWY_INLINE Vector cross(const Vector& b) const {
        return {hn::Sub(hn::Mul(y, b.z), hn::Mul(z, b.y)), hn::Sub(hn::Mul(z, b.x), hn::Mul(x, b.z)),
                hn::Sub(hn::Mul(x, b.y), hn::Mul(y, b.x))};
    }
    /// Unit vector, or zero where this is shorter than the square root of the smallest normal float.
    [[nodiscard]] HWY_INLINE Vector normalized() const {
        const Floats<W> tag;
        const V square = dot(*this);
        const auto some = hn::Gt(square, hn::Set(tag, 1e-37f));
        const V inverse = hn::Div(hn::Set(tag, 1.0f), hn::Sqrt(hn::IfThenElse(some, square, hn::Set(tag, 1.0f))));
        return scaled(hn::IfThenElseZero(some, inverse));
    }
    HWY_INLINE void store_to(float* to) const {
        store<W>(x, to);
        store<W>(y, to + W);
        store<W>(z, to + 2 * W);
    }
};
template <int W>
HWY_INLINE Vector<W> load3(const float* from) {
    return {load<W>(from), load<W>(from + W), load<W>(from + 2 * W)};
}

/// Calls visit(offset of vertex (i, k) within row i) for the vertices of row i, each piece of the lanes in turn.
template <int W, typename Visit>
HWY_INLINE void visit_row(int count, Visit visit) {
    for (std::ptrdiff_t k = 0; k < count; ++k)
        for (std::ptrdiff_t p = 0; p < W; p += kLanes<W>) visit(3 * W * k + p);
}

template <int W>
void normals(const Layout& layout, const float* v, float* out) {
    constexpr std::ptrdiff_t S = 3 * W;
    for (int i = 0; i <= layout.n; ++i) {
        const float *m = v + layout.row(i - 1), *z = v + layout.row(i), *p = v + layout.row(i + 1);
        float* to = out + layout.row(i);
        visit_row<W>(layout.n - i + 1, [&](std::ptrdiff_t at) {
            // The ring in turn; its area vector is that of two quads.
            const auto q0 = load3<W>(p + at), q1 = load3<W>(z + at + S), q2 = load3<W>(m + at + S),
                       q3 = load3<W>(m + at), q4 = load3<W>(z + at - S), q5 = load3<W>(p + at - S);
            ((q2 - q0).cross(q3 - q1) + (q4 - q0).cross(q5 - q3)).normalized().store_to(to + at);
        });
    }
}

template <int W>
void shape(const Layout& layout, const float* v, const float* normal, float* out) {
    constexpr std::ptrdiff_t S = 3 * W;
    const auto quarter = hn::Set(Floats<W>(), 0.25f), minus = hn::Set(Floats<W>(), -1.0f / 24);
    for (int i = 0; i <= layout.n; ++i) {
        const float *m = v + layout.row(i - 1), *z = v + layout.row(i), *p = v + layout.row(i + 1);
        const std::ptrdiff_t row = layout.row(i);
        visit_row<W>(layout.n - i + 1, [&](std::ptrdiff_t at) {
            const auto ring = ((load3<W>(p + at) + load3<W>(m + at)) + (load3<W>(z + at + S) + load3<W>(z + at - S))) +
                              (load3<W>(m + at + S) + load3<W>(p + at - S));
            auto x = load3<W>(z + at).scaled(quarter).plus(minus, ring);
            if (normal != nullptr) {
                const auto N = load3<W>(normal + row + at);
                x = N.scaled(N.dot(x));
            }
            x.store_to(out + row + at);
        });
    }
}

template <int W>
void predict_along_normal(const Layout& layout, const FloatWeights& position, const FloatWeights& shape_weights,
                          float sign, const float* v, const float* shape_x, const float* normal, float* d) {
    constexpr std::ptrdiff_t S = 3 * W;
    const TenVectors<W> w(position), wx(shape_weights);
    const auto s = hn::Set(Floats<W>(), sign), half = hn::Set(Floats<W>(), 0.5f);
    for (int i = 0; i < layout.n; ++i) {
        const Rows r(layout, v, i), x(layout, shape_x, i);
        const float *nz = normal + layout.row(i), *np = normal + layout.row(i + 1);
        float *row = d + layout.edge(kV, i, 0), *pairs = d + layout.edge(kH, i, 0);
        visit_row<W>(layout.n - i, [&](std::ptrdiff_t at) {
            const TenSums<W> vx(w, r, at), vy(w, r, at + W), vz(w, r, at + 2 * W);
            const TenSums<W> sx(wx, x, at), sy(wx, x, at + W), sz(wx, x, at + 2 * W);
            const auto finish = [&](const Vector<W>& Q, const Vector<W>& normals, const Vector<W>& ends, float* to) {
                const Vector<W> n = normals.normalized(), m = ends.scaled(half);
                load3<W>(to).plus(s, m.plus(n.dot(Q - m), n)).store_to(to);
            };
            const auto n0 = load3<W>(nz + at), n1 = load3<W>(nz + at + S), n2 = load3<W>(np + at);
            const auto v0 = load3<W>(r.z + at), v1 = load3<W>(r.z + at + S), v2 = load3<W>(r.p1 + at);
            // 2 at but for the piece of the lanes, which counts once.
            float* pair = pairs + 2 * at - at % S;
            finish({hn::Add(vx.h, sx.h), hn::Add(vy.h, sy.h), hn::Add(vz.h, sz.h)}, n0 + n2, v0 + v2, pair);
            finish({hn::Add(vx.v, sx.v), hn::Add(vy.v, sy.v), hn::Add(vz.v, sz.v)}, n1 + n0, v1 + v0, row + at);
            finish({hn::Add(vx.d, sx.d), hn::Add(vy.d, sy.d), hn::Add(vz.d, sz.d)}, n2 + n1, v2 + v1, pair + S);
        });
    }
}

/// frames.h in lanes.
template <int W>
struct Frames {
    Vector<W> n, t, b;

    Frames(const Vector<W>& normal_sum, const Vector<W>& edge) {
        const Floats<W> tag;
        const auto one = hn::Set(tag, 1.0f), zero = hn::Zero(tag), sine = hn::Set(tag, 1e-3f);
        const auto length_n = hn::Sqrt(normal_sum.dot(normal_sum));
        const auto some = hn::Gt(length_n, sine);
        const Vector<W> unit = normal_sum.scaled(hn::Div(one, hn::IfThenElse(some, length_n, one)));
        n = {hn::IfThenElseZero(some, unit.x), hn::IfThenElseZero(some, unit.y), hn::IfThenElse(some, unit.z, one)};
        Vector<W> flat = edge - n.scaled(n.dot(edge));
        const auto length_t = hn::Sqrt(flat.dot(flat));
        const auto good = hn::Gt(length_t, hn::Mul(sine, hn::Sqrt(edge.dot(edge))));
        const auto along_x = hn::Lt(hn::Abs(n.x), hn::Set(tag, 0.6f));
        const Vector<W> axis{hn::IfThenElse(along_x, one, zero), hn::IfThenElse(along_x, zero, one), zero};
        const Vector<W> stand_in = axis - n.scaled(n.dot(axis));
        flat = {hn::IfThenElse(good, flat.x, stand_in.x), hn::IfThenElse(good, flat.y, stand_in.y),
                hn::IfThenElse(good, flat.z, stand_in.z)};
        t = flat.scaled(hn::Div(one, hn::Sqrt(flat.dot(flat))));
        b = n.cross(t);
    }
};

template <int W>
void turn(const Layout& layout, bool to_model, const float* v, const float* normal, float* d) {
    constexpr std::ptrdiff_t S = 3 * W;
    for (int i = 0; i < layout.n; ++i) {
        const float *vz = v + layout.row(i), *vp = v + layout.row(i + 1);
        const float *nz = normal + layout.row(i), *np = normal + layout.row(i + 1);
        float *row = d + layout.edge(kV, i, 0), *pairs = d + layout.edge(kH, i, 0);
        visit_row<W>(layout.n - i, [&](std::ptrdiff_t at) {
            const auto turn_one = [&](const Vector<W>& normals, const Vector<W>& edge, float* to) {
                const Frames<W> f(normals, edge);
                const Vector<W> c = load3<W>(to);
                const Vector<W> turned = to_model ? f.b.scaled(c.z).plus(c.y, f.t).plus(c.x, f.n)
                                                  : Vector<W>{f.n.dot(c), f.t.dot(c), f.b.dot(c)};
                turned.store_to(to);
            };
            const auto n0 = load3<W>(nz + at), n1 = load3<W>(nz + at + S), n2 = load3<W>(np + at);
            const auto v0 = load3<W>(vz + at), v1 = load3<W>(vz + at + S), v2 = load3<W>(vp + at);
            float* pair = pairs + 2 * at - at % S;
            turn_one(n0 + n2, v2 - v0, pair);
            turn_one(n1 + n0, v0 - v1, row + at);
            turn_one(n2 + n1, v1 - v2, pair + S);
        });
    }
}

}  // namespace mvw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
