// A mesh on a lattice that grows by vertex splits, and the adaptive state that these are coded with.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/entropy/adaptive_bit.h"
#include "codec/entropy/split_mesh.h"
#include "codec/mesh/lattice.h"

namespace mvw {

/// Lattices of more bits are not refined so, and not by more bits at once.
inline constexpr unsigned kMostSplitBits = 16, kMostFinerBits = 4;

/// Adaptive bits of each kind of decision, by context. Trained starts were tried: they save 1 %.
struct SplitModel {
    static constexpr std::size_t kBends = 4;     // of an edge: flat, to 18 degrees, to 45, above
    static constexpr std::size_t kSharp = 4;     // edges of the upper two kinds at a vertex: 0, 1, 2, more
    static constexpr std::size_t kSizes = 4;     // a vertex' edges against all: below 1/2, below 1, below 2, more
    static constexpr std::size_t kValences = 8;  // faces at a vertex: 3 or fewer, 4, ..., 10 or more
    static constexpr std::size_t kTakes = 8, kLefts = 4, kRanks = 4, kEqual = 3, kVotes = 3, kGuesses = 4;
    static constexpr std::size_t kKinds = 3, kScales = 20, kLengths = 12;  // of numbers

    static constexpr std::size_t kSplit = 0, kSplitOther = kSplit + 2 * kBends * kSizes,
                                 kBoundary = kSplitOther + kValences * kSharp, kTaken = kBoundary + 1,
                                 kFirst = kTaken + kValences * kTakes, kFirstOther = kFirst + kSharp * 3 * 3 * 3,
                                 kStays = kFirstOther + kRanks * kLefts * kBends, kSame = kStays + 2 * kSharp,
                                 kNumber = kSame + 2 * 2 * kEqual * kGuesses * kVotes,
                                 kNumberSet = (kScales + kLengths) * kLengths, kTop = kNumber + kKinds * kNumberSet,
                                 kSign = kTop + kKinds * kLengths, kMaterial = kSign + kKinds, kRefined = kMaterial + 1,
                                 kBits = kRefined + 3;
    static constexpr std::size_t kSplitWeights = 0, kFirstWeights = 1, kNumberWeights = 2,
                                 kWeights = kNumberWeights + kKinds * kLengths;

    SplitModel() { weights.fill({{kShare, kShare}}); }

    static constexpr std::uint32_t kRare = 10'000;  // in 1/65536: guesses that hold less often are not asked for
    static constexpr std::int32_t kShare = 40'000;  // of either context, in 1/65536, at first
    std::array<AdaptiveBit, kBits> bits;
    std::array<MixWeights, kWeights> weights;
};

/// What a decoder has of a progressive mesh. Nothing can follow a beginning of bits.
struct ProgressiveMesh {
    SplitMesh mesh;
    Rounded at;               // its vertices
    std::uint32_t fresh = 0;  // those from here on came in the round before, or in the base
    SplitModel model{};
    std::vector<Vec3f> unrefined{};  // where the last vertices still are, if bits end while the lattice becomes finer
};

}  // namespace mvw
