#include "codec/mesh/io/gltf_node.h"

#include <algorithm>
#include <optional>

#include "codec/mesh/io/gltf_accessor.h"

namespace mvw {
namespace {

/// First scaled, then turned by a unit quaternion (x, y, z, w), then moved.
struct Placement {
    std::array<double, 3> translation{0, 0, 0};
    std::array<double, 4> rotation{0, 0, 0, 1};
    std::array<double, 3> scale{1, 1, 1};

    [[nodiscard]] Affine affine() const {
        const auto [x, y, z, w] = rotation;
        Affine out;
        out.row = {Vec3{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                   Vec3{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                   Vec3{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
        for (Vec3& row : out.row) row = {row.x * scale[0], row.y * scale[1], row.z * scale[2]};
        out.shift = {translation[0], translation[1], translation[2]};
        return out;
    }
};

template <std::size_t N>
void take(const std::vector<double>& from, std::array<double, N>& to) {
    if (from.size() == N) std::ranges::copy(from, to.begin());
}

/// A row for each instance into one member of their placements, as many as the first attribute has rows.
template <std::size_t N>
Result<void> take(const tinygltf::Model& model, const tinygltf::Value& extension, const char* name,
                  std::array<double, N> Placement::*member, std::optional<std::vector<Placement>>& placements) {
    const int accessor = index_of(member_of(extension, "attributes"), name);
    if (accessor < 0) return {};
    const Result<Values> values = open_accessor(model, accessor);
    if (!values) return values.error();
    if (!placements) placements.emplace(values->count);
    if (values->count != placements->size() || values->components != N)
        return Error{Errc::Malformed, 0, "has instances whose attributes do not fit each other"};
    for (std::size_t i = 0; i < placements->size(); ++i)
        for (std::size_t k = 0; k < N; ++k) ((*placements)[i].*member)[k] = values->at(i, k);
    return {};
}

}  // namespace

Affine transform_of(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) {  // by columns
        const auto& m = node.matrix;
        Affine out;
        for (std::size_t r = 0; r < 3; ++r) out.row[r] = {m[r], m[4 + r], m[8 + r]};
        out.shift = {m[12], m[13], m[14]};
        return out;
    }
    Placement placement;
    take(node.translation, placement.translation);
    take(node.rotation, placement.rotation);
    take(node.scale, placement.scale);
    return placement.affine();
}

Result<std::vector<Affine>> instances_of(const tinygltf::Model& model, const tinygltf::Node& node) {
    const auto found = node.extensions.find(kInstancing);
    if (found == node.extensions.end()) return std::vector<Affine>{Affine{}};
    std::optional<std::vector<Placement>> placements;
    for (const auto& done : {take(model, found->second, "TRANSLATION", &Placement::translation, placements),
                             take(model, found->second, "ROTATION", &Placement::rotation, placements),
                             take(model, found->second, "SCALE", &Placement::scale, placements)})
        if (!done) return done.error();
    std::vector<Affine> out;
    if (placements)
        for (const Placement& placement : *placements) out.push_back(placement.affine());
    return out;
}

}  // namespace mvw
