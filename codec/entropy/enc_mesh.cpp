#include "codec/entropy/enc_mesh.h"

#include <algorithm>
#include <memory>

#include "codec/entropy/enc_bits.h"

namespace mvw {

namespace {

constexpr std::uint32_t kBeginnings = 8;
constexpr std::uint32_t kMostForBeginnings = 20'000;  // faces

class Writer : public MeshSource, public EncodedBits {
 public:
    using MeshSource::MeshSource;
};

EncodedMesh encode_from(const BaseMesh& mesh, const std::vector<GridPoint>& grid, unsigned bits, std::uint32_t face) {
    const auto model = std::make_unique<MeshModel>();
    Writer writer(mesh, grid, face);
    MeshCoder coder(mesh.vertex_count(), mesh.face_count(), writer.has_boundary(), bits, *model, writer);
    if (!coder.run()) return {};
    EncodedMesh coded{writer.take_bytes(), writer.take_origin()};
    for (std::size_t v = 0; v < grid.size(); ++v)  // as a decoder will have them
        if (coder.positions()[v] != grid[coded.origin.vertex[v]]) return {};
    return coded;
}

}  // namespace

EncodedMesh encode_mesh(const BaseMesh& mesh, const std::vector<GridPoint>& grid, unsigned bits) {
    EncodedMesh best;
    const std::uint32_t F = mesh.face_count(), beginnings = F <= kMostForBeginnings ? std::min(F, kBeginnings) : 1;
    for (std::uint64_t k = 0; k < beginnings; ++k) {
        EncodedMesh coded = encode_from(mesh, grid, bits, static_cast<std::uint32_t>(k * F / beginnings));
        if (!coded.bytes.empty() && (best.bytes.empty() || coded.bytes.size() < best.bytes.size()))
            best = std::move(coded);
    }
    return best;
}

}  // namespace mvw
