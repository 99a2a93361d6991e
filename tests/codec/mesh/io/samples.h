// Small files of every mesh format, good ones and bad ones, as literals.
#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/io/mesh_io.h"

namespace mvw {

struct Sample {
    std::string name;
    MeshFormat format;
    Bytes bytes;
    std::size_t vertices = 0, faces = 0;  // what reading gives
    std::optional<Rgba8> color;           // of vertex 1, where there are colours
};

struct BadSample {
    Sample sample;
    std::string reason;  // part of what the error must say
};

std::vector<Sample> good_samples();
std::vector<BadSample> bad_samples();

Sample obj(const std::string& text);
/// Little-endian float32.
Bytes floats(std::initializer_list<float> values);
/// A .gltf of one triangle (0,0,0), (1,0,0), (0,1,0) in an outer buffer, or inside where the URI is empty; `scene` is
/// JSON that states scenes and nodes.
Sample gltf_triangle(const std::string& uri = {},
                     const std::string& scene = R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}])");

}  // namespace mvw
