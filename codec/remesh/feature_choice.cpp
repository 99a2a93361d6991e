#include "codec/remesh/feature_choice.h"

#include <cmath>
#include <numbers>

#include "codec/mesh/half_edges.h"

namespace mvw {

namespace {

constexpr double kFaint[] = {10, 25};  // degrees, tried in turn
constexpr double kFlatDegrees = 0.1;   // between faces of one plane, at most
constexpr double kLeastFlat = 0.5;     // of a machined part's edges, by length
constexpr double kMostGrowth = 1.5;    // of the base

}  // namespace

bool is_machined(const Mesh& mesh) {
    const EdgeGroups groups = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    const auto normal = [&](std::uint32_t h) {
        const Face& f = mesh.faces[h / 3];
        const Vec3& a = mesh.positions[f[0]];
        return normalized(cross(mesh.positions[f[1]] - a, mesh.positions[f[2]] - a));
    };
    const double least_cosine = std::cos(kFlatDegrees * std::numbers::pi / 180);
    double all = 0, flat = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const std::uint32_t h = groups[g][0];
        const double size =
            length(mesh.positions[origin(mesh.faces, next_half_edge(h))] - mesh.positions[origin(mesh.faces, h)]);
        all += size;
        if (dot(normal(h), normal(groups[g][1])) >= least_cosine) flat += size;
    }
    return flat >= kLeastFlat * all;
}

ChosenFeatures features_from(const Mesh& mesh, double angle_deg) {
    FeatureOptions options;
    options.angle_deg = angle_deg;
    return {feature_half_edges(mesh, options), angle_deg};
}

ChosenFeatures choose_features(const Mesh& mesh,
                               const std::function<std::size_t(const std::vector<std::uint8_t>& sharp)>& base_faces) {
    ChosenFeatures usual = features_from(mesh, kFeatureAngleDeg);
    if (!is_machined(mesh)) return usual;
    const double most = kMostGrowth * static_cast<double>(base_faces(usual.sharp));
    for (const double degrees : kFaint) {
        ChosenFeatures faint = features_from(mesh, degrees);
        if (static_cast<double>(base_faces(faint.sharp)) <= most) return faint;
    }
    return usual;
}

}  // namespace mvw
