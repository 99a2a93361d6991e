// What a part's Base chunk says beside the mesh: the numbers that turn symbols into positions (FORMAT.md 4.1), and the
// flags in front of a geometry chunk's planes (FORMAT.md 4.3). Shared by both directions.
#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/container/chunk.h"
#include "codec/mesh/lattice.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Of a lossless part's grid: details, too, have to fit the planes and floats.
inline constexpr unsigned kMaxLosslessBits = 24;

/// Bits of the byte that holds a lattice's bits: its stretch and shift follow; it is Lattice::nested().
inline constexpr std::uint8_t kFittedLattice = 128, kNestedLattice = 64;

inline Lattice read_lattice(ByteReader& in) {
    const std::uint8_t flags = in.u8();
    Lattice lattice;
    lattice.bits = flags & (kNestedLattice - 1);
    if ((flags & kNestedLattice) != 0) lattice = Lattice::nested(lattice.bits);
    if ((flags & kFittedLattice) == 0) return lattice;
    for (std::uint8_t& s : lattice.stretch) s = in.u8();
    for (std::uint8_t& s : lattice.shift) s = in.u8();
    return lattice;
}
inline void write_lattice(ByteWriter& out, const Lattice& lattice) {
    const bool nested = lattice.is_nested(), fitted = !nested && !lattice.is_plain();
    out.u8(static_cast<std::uint8_t>(lattice.bits | (nested ? kNestedLattice : 0) | (fitted ? kFittedLattice : 0)));
    if (!fitted) return;
    for (const std::uint8_t s : lattice.stretch) out.u8(s);
    for (const std::uint8_t s : lattice.shift) out.u8(s);
}

/// First byte of a Base payload.
enum BaseFlags : std::uint8_t {
    kBaseSequential = 1,  // Draco's sequential method instead of edgebreaker
    kBaseCreases = 2,
    kBaseMaterials = 4,
    kBaseTransform = 8,  // transform parameters other than the defaults follow
    kBaseColors = 16,    // materials have colours
    kBaseFast = 32,      // planes are packed (entropy/packed_planes.h) instead of range-coded
    kBaseLossless = 64,  // integers throughout (transform/integer.h): all planes together are exact
    kBaseGrown = 128,    // the mesh is coded triangle by triangle (entropy/mesh_coder.h) instead of by Draco
};

/// A step on disk: eight steps an octave, (1 + (code % 8) / 8) * 2^-(code / 8), exact in binary.
inline float step_from_code(std::uint8_t code) {
    return std::ldexp(1.0f + static_cast<float>(code % 8) / 8.0f, -static_cast<int>(code / 8));
}
/// The code of the largest step that is not above `step`.
inline std::uint8_t step_to_code(double step) {
    unsigned code = 255;
    while (code > 0 && step_from_code(static_cast<std::uint8_t>(code)) <= step) {
        const auto next = static_cast<std::uint8_t>(code % 8 == 7 ? code - 15 : code + 1);
        if ((code % 8 == 7 && code < 15) || step_from_code(next) > step) break;
        code = next;
    }
    return static_cast<std::uint8_t>(code);
}

/// What an attribute of vertices is. On disk: append values, never renumber (FORMAT.md 4.8).
enum class AttributeKind : std::uint8_t {
    Color = 0,       // Y, Co, Cg (color.h)
    ColorAlpha = 1,  // and alpha
    Normals = 2,     // what they differ by from those of the surface (mesh/normals.h)
    Scalar = 3,      // one number
};
inline constexpr unsigned kAttributeKinds = 4;

/// An attribute and how it is coded.
struct AttributeParams {
    AttributeKind kind = AttributeKind::Color;
    Channel channel = Channel::Color;  // of its chunks
    std::vector<std::uint8_t> steps;   // code of the step of plane 0 of each level, L + 1, of all components
    // Of a scalar:
    std::string name;
    double middle = 0, range = 0;  // values are middle + range * x, x in [-1/2, 1/2]
    float mean = 0;                // of x

    [[nodiscard]] unsigned components() const {
        return kind == AttributeKind::Scalar ? 1 : kind == AttributeKind::ColorAlpha ? 4 : 3;
    }
    [[nodiscard]] bool is_color() const { return channel == Channel::Color; }
    /// What a component is where no chunk has come.
    [[nodiscard]] float origin(unsigned component) const {
        if (!is_color()) return mean;
        return component == 0 ? 0.5f : component == 3 ? 1.0f : 0.0f;
    }
};

/// "color", "normal", or a scalar's own name.
inline std::string attribute_name(const AttributeParams& a) {
    return a.is_color() ? "color" : a.kind == AttributeKind::Normals ? "normal" : a.name;
}

/// Decoder parameters of one part.
struct PartParams {
    std::uint8_t error_code = 0;        // error left once this chunk and all before it are there: 10^(-code/40)
    Lattice lattice;                    // of base positions, in units of the diagonal
    std::uint8_t reconstruction = 128;  // place within a quantisation interval, in 1/256
    std::vector<std::uint8_t> steps;    // code of the normal step of plane 0 of each level, L + 1; empty for L = 0
    std::vector<std::uint8_t> across;   // likewise of the tangential steps
    bool fast = false;                  // planes are packed, not range-coded
    bool lossless = false;              // coefficients are integers in units of the grid
    TransformOptions transform;         // `kind` comes from the file's header
    std::vector<MaterialColor> colors;  // of materials (Mesh::material_colors)

    [[nodiscard]] float step(unsigned level) const { return step_from_code(steps[level]); }
    [[nodiscard]] float step_across(unsigned level) const { return step_from_code(across[level]); }
    [[nodiscard]] float reconstruction_point() const { return static_cast<float>(reconstruction) / 256.0f; }
};

/// What attributes are transformed by: a linear rule, in no frames.
inline constexpr TransformOptions kAttributeTransform{TransformKind::Interp, 36.0 / 31.0, false, 10, false};

/// One byte for an error: 10^(-code/40), half a decibel apart.
inline float error_from_code(std::uint8_t code) {
    return static_cast<float>(std::pow(10.0, -static_cast<double>(code) / 40.0));
}
inline std::uint8_t error_to_code(double error) {
    if (!(error > 0)) return 255;
    const double code = std::floor(-40.0 * std::log10(error));
    return static_cast<std::uint8_t>(code < 0 ? 0 : code > 255 ? 255 : code);
}

/// Front of a Geometry payload: what its planes build on.
struct GeometryFront {
    std::uint8_t error_code = 0;
    unsigned top_plane = 0;         // of this chunk; it goes down to layers - 1 - layer
    bool starts = false;            // the block's first chunk
    bool needs_parent = false;      // the block one level below must be there down to one plane above the lowest here
    std::uint64_t least_bytes = 0;  // behind this front; with fewer a cut chunk is not shown
    bool beginning = false;         // of a chunk whose rest is nowhere: as if it had been cut
};
inline GeometryFront read_geometry_front(ByteReader& in) {
    GeometryFront front;
    front.error_code = in.u8();
    const unsigned bits = in.u8();
    front.top_plane = bits & 31;
    front.starts = (bits & 32) != 0;
    front.needs_parent = (bits & 64) != 0;
    if ((bits & 128) != 0) {
        const std::uint64_t cut = in.varint();
        front.least_bytes = cut / 2;
        front.beginning = cut % 2 != 0;
    }
    return front;
}
inline void write_geometry_front(ByteWriter& out, const GeometryFront& front) {
    out.u8(front.error_code);
    const std::uint64_t cut = 2 * front.least_bytes + (front.beginning ? 1u : 0u);
    out.u8(static_cast<std::uint8_t>(front.top_plane | (front.starts ? 32u : 0u) | (front.needs_parent ? 64u : 0u) |
                                     (cut > 0 ? 128u : 0u)));
    if (cut > 0) out.varint(cut);
}
/// The same payload behind another front.
inline Bytes with_front(const GeometryFront& front, ByteReader planes) {
    ByteWriter out;
    write_geometry_front(out, front);
    out.bytes(planes.bytes(planes.remaining()));
    return out.take();
}

/// Front of a Splits payload: on which lattices its rounds' vertices lie.
inline constexpr std::size_t kMostSplitRounds = 16;
struct SplitsFront {
    std::uint8_t error_code = 0;
    std::vector<Lattice> rounds;
};
/// before: the lattice so far.
inline SplitsFront read_splits_front(ByteReader& in, Lattice before) {
    SplitsFront front;
    front.error_code = in.u8();
    const std::size_t count = std::min<std::size_t>(in.u8(), kMostSplitRounds + 1);
    for (std::size_t k = 0; k < count; ++k) {
        const Lattice next = read_lattice(in);
        if (!(next == Lattice{0, {}, {}})) before = next;
        front.rounds.push_back(before);
    }
    return front;
}
inline void write_splits_front(ByteWriter& out, const SplitsFront& front, Lattice before) {
    out.u8(front.error_code);
    out.u8(static_cast<std::uint8_t>(front.rounds.size()));
    for (const Lattice& next : front.rounds) {
        if (next == before)
            out.u8(0);
        else
            write_lattice(out, next);
        before = next;
    }
}

}  // namespace mvw
