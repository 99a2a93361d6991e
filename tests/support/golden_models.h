// The models whose files are kept in tests/data: one for each transform and profile.
#pragma once
#include <string>
#include <vector>

#include "codec/encoder.h"

namespace mvw {

struct GoldenModel {
    std::string name;
    std::vector<SemiRegularMesh> parts;
    EncodeOptions options;
    Mesh mesh{};  // encoded as any input, where there are no parts
};

/// "mixed" (tiles, creases, materials, a part by Draco alone), "colors" (with alpha, and the original mesh), "fields"
/// (normals, scalars), "fast", "lossless", the transforms by name, "plain" (a progressive mesh), "preview" (one in
/// front of wavelets), "closing" (that ends with the input's own triangles), "materials" (with colours).
std::vector<GoldenModel> golden_models();

/// File names of a golden model: what a decoder reads, the mesh and the digest of coefficients that it must give.
std::string golden_file(const std::string& name);
std::string golden_mesh(const std::string& name);
std::string golden_digest(const std::string& name);

}  // namespace mvw
