// Kernels of listed edges: single points of single lanes, with weights that edges of one kind share.
#if defined(MVW_LISTED_KERNELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef MVW_LISTED_KERNELS_INL_H
#undef MVW_LISTED_KERNELS_INL_H
#else
#define MVW_LISTED_KERNELS_INL_H
#endif

#include "codec/transform/patch/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace mvw::HWY_NAMESPACE {

template <int W>
void lift_listed(const LiftTargets& lists, const ListedDetail* listed, float sign, float* v) {
    constexpr int N = kLanes<4>;
    const Floats<4> tag;
    const std::uint32_t* source = lists.sources + lists.first_source;
    for (const LiftTarget& target : lists.targets) {
        Pack<4> sum[4 / N];
        for (int p = 0; p < 4 / N; ++p) sum[p] = hn::Zero(tag);
        const std::uint32_t* last = lists.sources + target.last_source;
        for (const float* weight = lists.weights + target.weights; source != last; ++source, ++weight)
            for (int p = 0; p < 4 / N; ++p)
                sum[p] = hn::MulAdd(hn::Set(tag, *weight), load<4>(&listed[*source].x + p * N), sum[p]);
        HWY_ALIGN float out[4];
        for (int p = 0; p < 4 / N; ++p) store<4>(hn::Mul(sum[p], hn::Set(tag, sign)), out + p * N);
        float* to = v + target.vertex;
        to[0] += out[0], to[W] += out[1], to[2 * W] += out[2];
    }
}

template <int W>
HWY_INLINE Vec3f point(const float* at) {
    return {at[0], at[W], at[2 * W]};
}

template <int W>
void predict_listed(const ListedEdges& lists, float sign, const float* v, const float* shape, const float* normals,
                    ListedDetail* listed) {
    const std::uint32_t* vertex = lists.vertices + lists.first_vertex;
    for (const ListedEdge& edge : lists.edges) {
        const std::uint32_t *ends = vertex, *last = lists.vertices + edge.last_vertex;
        Vec3f P;
        for (const float* w = lists.weights + edge.weights; vertex != last; ++vertex, w += 2) {
            P += point<W>(v + *vertex) * w[0];
            if (shape != nullptr) P += point<W>(shape + *vertex) * w[1];
        }
        if (normals != nullptr && edge.projected != 0) {
            const Vec3f m = (point<W>(v + ends[0]) + point<W>(v + ends[1])) * 0.5f;
            const Vec3f n = normalized(point<W>(normals + ends[0]) + point<W>(normals + ends[1]));
            P = m + n * dot(n, P - m);
        }
        listed->x += P.x * sign, listed->y += P.y * sign, listed->z += P.z * sign;
        ++listed;
    }
}

}  // namespace mvw::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
