// A decoder's mesh as a graphics card takes it: indexed arrays, the same for the browser and the window.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/decoder.h"

namespace mvw::client {

/// V vertices, F triangles; positions are relative to the header's `center`, in model units. A vertex between two
/// materials' colours is there once for each, with one normal; such copies come last.
struct Drawable {
    std::vector<Vec3f> positions;          // V
    std::vector<Vec3f> normals;            // V, unit: the file's, else the mean over triangles by area; zero where none
    std::vector<Rgba8> colors;             // V, or empty
    std::vector<std::uint32_t> triangles;  // 3 F
    std::vector<std::uint32_t> edges;  // two for each edge of a triangle, at copies maybe twice; empty unless asked for
    std::vector<std::uint32_t> base_edges;  // two for each piece of a base mesh's edge; empty unless asked for
    unsigned level = 0;                     // finest among the parts
    std::uint32_t parts = 0;  // that have come; where one shows instead of all others, its place among them, from 1
    bool solid = false;       // all of these bound solids, by their bases (codec/mesh/solid.h)
};

struct DrawableOptions {
    unsigned level = 255;  // every part at min(level, its own finest)
    bool edges = false;
    bool base_edges = false;
};

/// Two drawables of one decoder with the same `level`, `parts` and number of triangles have the same triangles, edges
/// and base_edges.
/// NeedMoreData until a base mesh is there. O(V + F).
Result<Drawable> make_drawable(const Decoder& decoder, const DrawableOptions& options);

}  // namespace mvw::client
