#include "codec/entropy/dec_mesh.h"

#include <memory>

#include "codec/entropy/dec_bits.h"
#include "codec/entropy/mesh_coder.h"

namespace mvw {

namespace {

class Answers : public DecodedBits {
 public:
    using DecodedBits::DecodedBits;
    static BeyondGate beyond(const MeshGrowth&, std::uint32_t) { return {}; }
    static GridPoint position(std::uint32_t) { return {}; }
};

}  // namespace

Result<GridMesh> decode_mesh(ByteSpan bytes, std::uint32_t vertices, std::uint32_t faces, bool has_boundary,
                             unsigned bits) {
    const auto malformed = [] {
        return Error{Errc::Malformed, 0, "the base's bytes make no mesh of the header's counts"};
    };
    if (bits > kMaxMeshBits) return malformed();
    auto model = std::make_unique<MeshModel>();
    Answers answers(bytes);
    MeshCoder coder(vertices, faces, has_boundary, bits, *model, answers);
    if (!coder.run()) return malformed();
    return GridMesh{coder.take_faces(), coder.take_positions()};
}

}  // namespace mvw
