// A model part of a 3MF package: the XML that holds objects (3MF Core Specification 1.3, Materials Extension 1.2 for
// groups of colours, Production Extension 1.1 for components in other parts).
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/io/affine.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

/// An object somewhere. path: of the part that holds it; empty: this one.
struct ThreemfPlace {
    std::string path, object;
    Affine to_outer;
};

/// A mesh, or components.
///
/// faces     indices below 2^32 - 1, unchecked
/// colors    F: of each face's corners, indices into ThreemfModel::colors; kNoColor where it has none
/// is_other  neither part of what is built nor a support of it: slicers keep modifiers and negative volumes so
struct ThreemfObject {
    std::vector<Vec3> positions;
    std::vector<Face> faces, colors;
    std::vector<ThreemfPlace> components;
    bool is_other = false;
};

struct ThreemfModel {
    static constexpr std::uint32_t kNoColor = 0xFFFFFFFFu;

    std::map<std::string, ThreemfObject> objects;  // by id
    std::vector<ThreemfPlace> items;               // what is to be built
    std::vector<Rgba8> colors;
    bool leaves_out_colors = false;  // triangles have some by images or mixtures, which are not known
};

/// Calls its argument with one piece of the part after the other, until that fails.
using ThreemfPieces = std::function<Result<void>(const std::function<Result<void>(ByteSpan)>&)>;

/// Elements of other extensions are passed over. Errors say the line, or are those of `pieces`; LimitExceeded where
/// there are more objects, or places of objects, than memory should hold.
Result<ThreemfModel> read_threemf_model(const ThreemfPieces& pieces);

/// Where a package's relationships say that its model is; empty where they say nothing.
Result<std::string> model_of_relationships(const ThreemfPieces& pieces);

}  // namespace mvw
