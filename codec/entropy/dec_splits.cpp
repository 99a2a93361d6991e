#include "codec/entropy/dec_splits.h"

#include "codec/entropy/dec_bits.h"
#include "codec/entropy/split_coder.h"

namespace mvw {

namespace {

class Answers : public DecodedBits {
 public:
    using DecodedBits::DecodedBits;
    static GridPoint refined(std::uint32_t) { return {}; }
    static std::optional<SplitTruth> split(std::uint32_t, const VertexRing&) { return std::nullopt; }
};

}  // namespace

Result<void> decode_splits(std::span<const Lattice> rounds, ByteSpan bytes, bool whole, std::uint32_t most_vertices,
                           std::uint32_t most_faces, ProgressiveMesh& mesh) {
    const Error error{Errc::Malformed, 0, kNoSplits};
    const std::uint32_t before = mesh.mesh.vertex_count();
    // Of a string that is cut nobody knows how long it was; what there is of it bounds the splits by itself.
    if (whole && bytes.size() < least_bytes_of_splits(before, before, rounds.size())) return error;
    Answers answers(bytes, whole);
    SplitCoder coder(mesh, most_vertices, answers);
    for (const Lattice& lattice : rounds) {
        if (!coder.run(lattice)) {
            if (whole) return error;
            break;
        }
        if (whole && bytes.size() < least_bytes_of_splits(before, mesh.mesh.vertex_count(), rounds.size()))
            return error;
    }
    if (mesh.mesh.faces().size() > most_faces) return error;
    return {};
}

}  // namespace mvw
