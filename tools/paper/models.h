// The semi-regular meshes that the paper's experiments run on.
#pragma once
#include <string>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/result.h"

namespace mvw::paper {

struct Model {
    std::string name, origin;  // origin: a sentence on where it comes from
    SemiRegularMesh mesh;      // in units of its box's diagonal, around the origin

    [[nodiscard]] std::vector<Vec3f> positions() const;
    /// The surface at a level; positions: at least V(level).
    [[nodiscard]] Mesh surface(unsigned level, std::span<const Vec3f> positions) const;
};

/// Four models at `levels`: those of the folder, remeshed to the paper's three sizes, or shapes made by formula where
/// folder is "".
Result<std::vector<Model>> load_models(const std::string& folder, unsigned levels);

}  // namespace mvw::paper
