// From a mesh to the bytes of a .mvw file.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/mesh.h"
#include "codec/remesh/remesh.h"
#include "codec/transform/transform.h"

namespace mvw {

enum class Profile : std::uint8_t {
    Small,  // range-coded planes
    Fast,   // planes packed by zstd: larger, decodes faster
};

struct EncodeOptions {
    Profile profile = Profile::Small;
    TransformOptions transform;
    /// SeededNormalLazy for SeededNormal, where features are and it is not worse; plain triangles instead of either.
    bool choose_transform = true;
    unsigned base_faces = 0;     // 0: chosen from the model
    int levels = -1;             // -1: chosen from the model
    double target_error = 0;     // RMS, fraction of the diagonal; 0: chosen from the model
    unsigned tile_count = 0;     // 0: chosen from the model
    bool color_levels = true;    // levels of no detail where images need more vertices; none where levels >= 0
    bool close = true;           // with plain triangles, or of these alone, where that pays (enc_closing.h)
    unsigned keep_original = 0;  // bits of the input mesh's positions in the last chunk, 1 to 30; 0: no such chunk
    /// Bits of a grid (a cell is the diagonal over 2^bits) on which every vertex is kept exactly, 1 to 24; 0: lossy.
    /// By `butterfly-lazy` on integers; InvalidArgument where the input is not semi-regular.
    unsigned lossless = 0;
    bool normals = false;       // code the input's normals, not only what the decoded surface says of them
    bool scalars = true;        // code scalar fields
    double field_error = 2e-3;  // RMS that coding leaves of a scalar field, fraction of its range; at least 1e-5
    unsigned threads = 0;       // 0: all cores
    Progress progress;
};

/// What an attribute takes of a file.
struct AttributeBytes {
    std::string name;  // "color", "normal" or the scalar's own
    std::uint64_t bytes = 0;
};

/// The file and the figures that `mvw encode --json` reports.
struct Encoded {
    Bytes file;
    CleanReport cleaning;
    std::uint64_t input_vertices = 0, input_faces = 0;  // after cleaning
    std::uint32_t parts = 0, base_faces = 0, levels = 0;
    std::uint32_t color_levels = 0;      // of them, that are there for colours alone
    std::uint64_t painted_vertices = 0;  // whose colours are those of images
    std::uint32_t material_colors = 0;   // materials with a colour of their own
    std::uint64_t vertices = 0, base_bytes = 0, color_bytes = 0, original_bytes = 0;
    std::uint64_t closing_bytes = 0;  // of a closing part (PartInfo::supersedes); 0: none
    std::vector<AttributeBytes> attributes;
    std::vector<std::string> left_out;  // names of fields that the file has no room for: it holds eight
    double draco_area_share = 0, facets_area_share = 0;  // of the surface, in parts of these origins (remesh.h)
    double rms = 0, max = 0, psnr = 0;  // of the whole file's decode against the input (surface_error.h)
    double tangential_share = 0;        // of the details' energy from level 2 up
    TransformKind transform = TransformKind::SeededNormal;
};

/// Cleans, remeshes, transforms, codes. Fails only where nothing is left to code (no face of positive area, a box
/// whose size is not finite), memory limits are exceeded, or lossless coding is asked for of other than semi-regular
/// input. Where the mesh has a paintwork, vertices have its colours where they come to lie. One opaque colour of all
/// vertices is kept as one of the faces (single_color_to_material).
Result<Encoded> encode(Mesh mesh, const EncodeOptions& options);

}  // namespace mvw
