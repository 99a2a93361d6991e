// Any soup of triangles is encoded, or refused because nothing of it is left to code, and what was encoded decodes.
// Byte 0: options; byte 1: how many vertices; then three bytes a vertex and three a face.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "codec/decoder.h"
#include "codec/encoder.h"

namespace {

constexpr std::size_t kMostFaces = 120;

mvw::Mesh soup(std::span<const std::uint8_t> bytes) {
    mvw::Mesh mesh;
    const std::size_t vertices = std::size_t{1} + bytes[0];
    bytes = bytes.subspan(1);
    for (std::size_t v = 0; v < vertices && bytes.size() >= 3; ++v, bytes = bytes.subspan(3))
        mesh.positions.push_back({double(bytes[0]), double(bytes[1]), double(bytes[2])});
    const auto V = static_cast<std::uint32_t>(mesh.positions.size());
    for (; V > 0 && bytes.size() >= 3 && mesh.faces.size() < kMostFaces; bytes = bytes.subspan(3))
        mesh.faces.push_back({bytes[0] % V, bytes[1] % V, bytes[2] % V});
    return mesh;
}

mvw::EncodeOptions options_of(std::uint8_t byte) {
    mvw::EncodeOptions options;
    options.threads = 1;
    options.levels = (byte & 3) - 1;  // 0 to 2 asked for: even a few faces are remeshed then
    options.base_faces = (byte & 4) != 0 ? 8 : 0;
    options.keep_original = (byte & 8) != 0 ? 12 : 0;
    options.profile = (byte & 16) != 0 ? mvw::Profile::Fast : mvw::Profile::Small;
    options.tile_count = (byte & 32) != 0 ? 3 : 0;
    return options;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    const mvw::Mesh mesh = soup(std::span(data + 1, size - 1));
    const mvw::Result<mvw::Encoded> encoded = mvw::encode(mesh, options_of(data[0]));
    if (!encoded) return 0;
    const mvw::Result<mvw::Mesh> decoded = mvw::decode(encoded->file);
    if (!decoded || decoded->faces.empty()) std::abort();
    for (const mvw::Vec3& p : decoded->positions)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) std::abort();
    return 0;
}
