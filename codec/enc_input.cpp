#include "codec/enc_input.h"

#include <algorithm>

#include "codec/remesh/features.h"

namespace mvw {

PartSurface::PartSurface(Mesh mesh, unsigned threads, double feature_angle_deg)
    : mesh_(std::move(mesh)), reference_(mesh_, threads), feature_angle_deg_(feature_angle_deg) {}

const SurfaceWalk& PartSurface::walk(bool with_features) {
    const std::scoped_lock lock(mutex_);
    std::optional<SurfaceWalk>& walk = with_features ? walk_with_features_ : walk_;
    if (walk) return *walk;
    FeatureOptions features;
    features.angle_deg = feature_angle_deg_;
    walk.emplace(mesh_, with_features ? feature_half_edges(mesh_, features) : std::vector<std::uint8_t>{});
    return *walk;
}

EncoderInput::EncoderInput(const Mesh& mesh, const FileHeader& header, unsigned threads)
    : mesh_(mesh), header_(header), threads_(threads), reference_(mesh, threads) {}

Result<std::unique_ptr<EncoderInput>> EncoderInput::make(const Mesh& mesh, unsigned threads) {
    const Box box = bounding_box(mesh);
    const Vec3 c = box.center();
    FileHeader header;
    if (const Result<void> r = set_box(header, {c.x, c.y, c.z}, box.diagonal()); !r.ok()) return r.error();
    return std::unique_ptr<EncoderInput>(new EncoderInput(mesh, header, threads));
}

Vec3 EncoderInput::to_coded_units(const Vec3& p) const {
    return (p - Vec3{header_.center[0], header_.center[1], header_.center[2]}) / header_.diagonal;
}

Vec3 EncoderInput::to_model_units(const Vec3& p) const {
    return p * header_.diagonal + Vec3{header_.center[0], header_.center[1], header_.center[2]};
}

PartSurface& EncoderInput::part(const RemeshResult& remeshed, std::uint32_t part) {
    std::vector<std::uint8_t> wanted;
    wanted.reserve(remeshed.part_of_face.size());
    for (const std::uint32_t p : remeshed.part_of_face) wanted.push_back(p == part ? 1 : 0);
    const std::scoped_lock lock(mutex_);
    const double degrees = remeshed.feature_angle_deg;
    const auto known = std::ranges::find_if(
        parts_, [&](const Part& p) { return p.feature_angle_deg == degrees && p.has_face == wanted; });
    if (known != parts_.end()) return *known->surface;
    Mesh mesh{{}, {}, mesh_.colors, {}, mesh_.fields};
    mesh.positions.reserve(mesh_.positions.size());
    for (const Vec3& p : mesh_.positions) mesh.positions.push_back(to_coded_units(p));
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f)
        if (wanted[f] != 0) {
            mesh.faces.push_back(mesh_.faces[f]);
            if (!mesh_.materials.empty()) mesh.materials.push_back(mesh_.materials[f]);
        }
    parts_.push_back({std::move(wanted), degrees, std::make_unique<PartSurface>(std::move(mesh), threads_, degrees)});
    return *parts_.back().surface;
}

}  // namespace mvw
