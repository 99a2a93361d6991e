#include "codec/measure/surface_index.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <string>

namespace mvw {
namespace {

/// Weight of b for the point nearest to p on segment a b.
double closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const double l2 = squared_length(ab);
    return l2 > 0 ? std::clamp(dot(p - a, ab) / l2, 0.0, 1.0) : 0.0;
}

/// For slivers, whose plane is not worth asking: the best of the three sides.
std::array<double, 3> closest_on_sides(const Vec3& p, const std::array<Vec3, 3>& corner) {
    double best = std::numeric_limits<double>::infinity();
    std::array<double, 3> weights{};
    for (std::size_t s = 0; s < 3; ++s) {
        const std::size_t e = (s + 1) % 3;
        const double t = closest_on_segment(p, corner[s], corner[e]);
        const double d = squared_length(corner[s] * (1 - t) + corner[e] * t - p);
        if (d >= best) continue;
        best = d;
        weights = {};
        weights[s] = 1 - t;
        weights[e] = t;
    }
    return weights;
}

Vec3 combine(const std::array<double, 3>& w, const Vec3& a, const Vec3& b, const Vec3& c) {
    return a * w[0] + b * w[1] + c * w[2];
}

}  // namespace

std::array<double, 3> closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 ab = b - a, ac = c - a;
    // sin^2 of the angle at a below 1e-16: the region tests below would be rounding noise.
    if (squared_length(cross(ab, ac)) <= 1e-16 * squared_length(ab) * squared_length(ac))
        return closest_on_sides(p, {a, b, c});

    const Vec3 ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        const double t = d1 / (d1 - d3);
        return {1 - t, t, 0};
    }
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        const double t = d2 / (d2 - d6);
        return {1 - t, 0, t};
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - t, t};
    }
    const double sum = va + vb + vc;
    return {va / sum, vb / sum, vc / sum};
}

namespace {

// Four floats at once, in the vectors that gcc and clang have for every machine.
using Four = float __attribute__((vector_size(16)));

/// The box around a triangle, in the frame.
struct TriangleBox {
    Four low, high;

    TriangleBox(const Vec3& a, const Vec3& b, const Vec3& c) : low{}, high{} {
        for (int k = 0; k < 3; ++k) {
            const auto axis = static_cast<std::size_t>(k);
            low[k] = static_cast<float>(std::min({a[axis], b[axis], c[axis]}));
            high[k] = static_cast<float>(std::max({a[axis], b[axis], c[axis]}));
        }
    }
    [[nodiscard]] float squared_distance(const Four& p) const {
        const Four below = low - p, above = p - high;
        const Four farther = below > above ? below : above;
        const Four outside = farther > Four{} ? farther : Four{};
        const Four squares = outside * outside;
        return squares[0] + squares[1] + squares[2];
    }
};

}  // namespace

/// The mesh in a frame where its box is centred and at most 2 wide, and Embree's hierarchy over it.
struct SurfaceIndex::Hierarchy {
    Vec3 center;
    double scale = 1;  // model units per unit of the frame
    std::vector<Vec3> positions;
    std::vector<Face> faces;
    std::vector<TriangleBox> boxes;  // F
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    Hierarchy(std::span<const Vec3> points, std::span<const Face> triangles, unsigned threads);
    ~Hierarchy() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Hierarchy(const Hierarchy&) = delete;
    Hierarchy& operator=(const Hierarchy&) = delete;

    void normalise(std::span<const Vec3> points);
    void build(unsigned threads);
};

namespace {

/// One query on its way through the hierarchy.
struct Search {
    const std::vector<Vec3>& positions;
    const std::vector<Face>& faces;
    const std::vector<TriangleBox>& boxes;
    Vec3 p;                                                 // in the frame
    float slack = 0;                                        // what floats may be wrong by around p
    double best = std::numeric_limits<double>::infinity();  // squared distance
    std::uint32_t face = kNone;
    std::array<double, 3> weights{};

    /// True where face f is nearer than, or as near as and before, all seen so far.
    bool offer(std::uint32_t f) {
        const Vec3 &a = positions[faces[f][0]], &b = positions[faces[f][1]], &c = positions[faces[f][2]];
        const std::array<double, 3> w = closest_on_triangle(p, a, b, c);
        const double d = squared_length(combine(w, a, b, c) - p);
        if (d > best || (d == best && f >= face)) return false;
        best = d;
        face = f;
        weights = w;
        return true;
    }

    [[nodiscard]] float radius() const {
        const float r = static_cast<float>(std::sqrt(best)) + slack;
        return std::isfinite(r) ? r : std::numeric_limits<float>::infinity();
    }
};

/// Most triangles that the hierarchy proposes lie outside the radius: their boxes say so for a tenth of the work.
bool visit(RTCPointQueryFunctionArguments* args) {
    auto& search = *static_cast<Search*>(args->userPtr);
    const RTCPointQuery& query = *args->query;
    if (search.boxes[args->primID].squared_distance(Four{query.x, query.y, query.z, 0}) > query.radius * query.radius)
        return false;
    if (!search.offer(args->primID)) return false;
    args->query->radius = search.radius();
    return true;
}

}  // namespace

SurfaceIndex::Hierarchy::Hierarchy(std::span<const Vec3> points, std::span<const Face> triangles, unsigned threads)
    : faces(triangles.begin(), triangles.end()) {
    assert(!faces.empty());
    normalise(points);
    build(threads);
}

void SurfaceIndex::Hierarchy::normalise(std::span<const Vec3> points) {
    Box box;
    for (const Face& f : faces)
        for (const std::uint32_t v : f) box.add(points[v]);
    center = box.center();
    const Vec3 extent = box.max - box.min;
    scale = std::max({extent.x, extent.y, extent.z}) * 0.5;
    if (!(scale > 0)) scale = 1;
    positions.reserve(points.size());
    for (const Vec3& p : points) positions.push_back((p - center) / scale);
    boxes.reserve(faces.size());
    for (const Face& f : faces) boxes.emplace_back(positions[f[0]], positions[f[1]], positions[f[2]]);
}

void SurfaceIndex::Hierarchy::build(unsigned threads) {
    device = rtcNewDevice(threads == 0 ? nullptr : ("threads=" + std::to_string(threads)).c_str());
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                          sizeof(Vec3f), positions.size()));
    for (const Vec3& p : positions) *v++ = to_float(p);
    auto* f = static_cast<Face*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Face), faces.size()));
    std::copy(faces.begin(), faces.end(), f);
    rtcCommitGeometry(geometry);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT));
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
}

SurfaceIndex::SurfaceIndex(std::span<const Vec3> positions, std::span<const Face> faces, unsigned threads)
    : hierarchy_(std::make_unique<Hierarchy>(positions, faces, threads)) {}
SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

SurfacePoint SurfaceIndex::closest(const Vec3& p, std::uint32_t near_face) const {
    const Hierarchy& h = *hierarchy_;
    Search search{h.positions, h.faces, h.boxes, (p - h.center) / h.scale};
    const double reach = std::max({1.0, std::abs(search.p.x), std::abs(search.p.y), std::abs(search.p.z)});
    // Far away, where floats would overflow when squared, every triangle is looked at.
    const bool far = reach > 1e15;
    // What rounding to floats may add up to, in the hierarchy and in boxes, is just under 1e-6 of this.
    search.slack = far ? std::numeric_limits<float>::infinity() : static_cast<float>(2e-6 * reach);
    search.offer(near_face == kNone ? 0 : near_face);

    RTCPointQuery query;
    const Vec3f origin = far ? Vec3f{} : to_float(search.p);
    query.x = origin.x;
    query.y = origin.y;
    query.z = origin.z;
    query.time = 0;
    query.radius = search.radius();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(h.scene, &query, &context, visit, &search);

    const Face& f = h.faces[search.face];
    const Vec3 q = combine(search.weights, h.positions[f[0]], h.positions[f[1]], h.positions[f[2]]);
    return {search.face, search.weights, q * h.scale + h.center, std::sqrt(search.best) * h.scale};
}

}  // namespace mvw
