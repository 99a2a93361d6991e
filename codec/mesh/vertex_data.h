// Colours and fields of vertices, moved from mesh to mesh whatever they are. From and To are Mesh or SemiRegularMesh.
#pragma once
#include <algorithm>
#include <array>
#include <span>

#include "codec/mesh/mesh.h"

namespace mvw {

/// A vertex and its weight in a mean.
struct VertexShare {
    std::uint32_t vertex = 0;
    double weight = 1;
};

inline Rgba8 mean_color(std::span<const Rgba8> colors, std::span<const VertexShare> shares) {
    std::array<double, 4> sum{};
    for (const VertexShare& s : shares) {
        const Rgba8& c = colors[s.vertex];
        sum[0] += s.weight * c.r, sum[1] += s.weight * c.g, sum[2] += s.weight * c.b, sum[3] += s.weight * c.a;
    }
    const auto byte = [](double x) { return static_cast<std::uint8_t>(std::clamp(x + 0.5, 0.0, 255.0)); };
    return {byte(sum[0]), byte(sum[1]), byte(sum[2]), byte(sum[3])};
}

/// Appends a mean value of vertices of `from`; normals come out of unit length, or zero.
inline void append_mean(const VertexField& from, std::span<const VertexShare> shares, VertexField& to) {
    std::array<double, 3> sum{};
    for (const VertexShare& s : shares)
        for (std::size_t k = 0; k < from.components(); ++k)
            sum[k] += s.weight * from.values[s.vertex * from.components() + k];
    if (from.kind == FieldKind::Normals) {
        const Vec3 unit = normalized(Vec3{sum[0], sum[1], sum[2]});
        sum = {unit.x, unit.y, unit.z};
    }
    to.values.insert(to.values.end(), sum.begin(), sum.begin() + static_cast<std::ptrdiff_t>(from.components()));
}

/// Appends to `to` a vertex whose colour and fields are means of those in `from`; weights sum to 1. `to` has the
/// fields of `from`, or no vertex yet.
template <typename From, typename To>
void append_vertex_data(const From& from, std::span<const VertexShare> shares, To& to) {
    if (!from.colors.empty()) to.colors.push_back(mean_color(from.colors, shares));
    for (std::size_t k = 0; k < from.fields.size(); ++k) {
        if (k == to.fields.size()) to.fields.push_back({from.fields[k].kind, from.fields[k].name, {}});
        append_mean(from.fields[k], shares, to.fields[k]);
    }
}
template <typename From, typename To>
void append_vertex_data(const From& from, std::uint32_t vertex, To& to) {
    const VertexShare share{vertex, 1};
    append_vertex_data(from, std::span(&share, 1), to);
}

}  // namespace mvw
