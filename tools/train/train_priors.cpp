// Trains where the adaptive state of every block begins, on the blocks that the encoder makes of real models, and
// writes codec/entropy/priors.h to standard output; what it cost goes to standard error. Changes the format.
//   cmake --build build --target train_priors
//   build/train_priors MESH... > priors.h && clang-format -i priors.h && mv priors.h codec/entropy/
// The present ones: lucy, koala, bun_zipper, fandisk, sr_bunny_oct7, sr_canyon_513, sr_club and demosthenes of the test
// models, unpacked.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "codec/enc_part.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/remesh/remesh.h"
#include "codec/tiles.h"
#include "tools/train/tables.h"

namespace mvw {
namespace {

using Logits = std::array<std::int8_t, BlockModel::kBits>;
using Weights = std::array<std::int8_t, 2 * BlockModel::kWeights>;

struct Sample {
    BlockShape shape;
    Entries entries, parent;
};

/// Counts what a range coder would write.
class CostCounter {
 public:
    explicit CostCounter(const Entries& truth) : truth_(truth) {}

    bool code(std::uint32_t probability, bool truth) {
        bits_ -= std::log2((truth ? probability : 65536.0 - probability) / 65536.0);
        return truth;
    }
    [[nodiscard]] bool any(std::size_t first, std::size_t last, unsigned plane) const {
        return std::any_of(truth_.begin() + static_cast<std::ptrdiff_t>(first),
                           truth_.begin() + static_cast<std::ptrdiff_t>(last),
                           [plane](std::uint32_t entry) { return magnitude_of(entry) >> plane != 0; });
    }
    [[nodiscard]] std::uint32_t truth(std::size_t at) const { return truth_[at]; }
    [[nodiscard]] static constexpr bool stopped() { return false; }
    [[nodiscard]] double bits() const { return bits_; }

 private:
    const Entries& truth_;
    double bits_ = 0;
};

/// Codes a block from a given start and shows the state after each of its planes. Returns bits.
template <typename Visit>
double code(const Sample& sample, const BlockModel& start, const Visit& visit) {
    double bits = 0;
    std::uint32_t largest = 0;
    for (const std::uint32_t entry : sample.entries) largest = std::max(largest, magnitude_of(entry));
    const EntryRows parent = rows_of(sample.parent, 3);
    BlockProgress progress(sample.shape.size(), 3);
    progress.model = start;
    const auto planes = static_cast<unsigned>(std::bit_width(largest));
    progress.top = planes == 0 ? 0 : planes - 1;
    for (unsigned plane = planes; plane-- > 0;) {
        CostCounter counter(sample.entries);
        PlaneCoder(sample.shape, std::span<const EntryRow>(parent), plane, progress, counter).run();
        bits += counter.bits();
        visit(progress.model);
    }
    return bits;
}

void add_samples(const std::string& path, std::vector<Sample>& samples) {
    CleanReport report;
    Result<Mesh> read = read_mesh(path, report);
    if (!read) {
        std::fprintf(stderr, "train_priors: %s: %s\n", path.c_str(), read.error().message.c_str());
        return;
    }
    Mesh mesh = clean(std::move(read).value(), report);
    const Box box = bounding_box(mesh);
    for (Vec3& p : mesh.positions) p = (p - box.center()) / box.diagonal();
    PartPrecision precision;
    precision.base_bits = 12;
    precision.error = 1e-5;
    for (const SemiRegularMesh& part : remesh(mesh, {}).parts) {
        if (part.levels == 0) continue;
        const CodedPart coded = code_part(part, {}, precision, {}, 0);
        const BaseMesh& base = coded.mesh.base;
        const Tiling tiling(base, tile_of_faces(base, 1), 1);
        Entries parent;
        for (const CodedBlock& block : coded.blocks) {
            samples.push_back({BlockShape(base, tiling, 0, block.level), block.planes.entries, parent});
            if (block.level > 0) parent = block.planes.entries;
        }
    }
}

/// Each context's mean probability over all planes of the blocks: upper planes, which a start serves most, stay in view
/// in those below, and no block counts for more than AdaptiveBit::kLimit bits a plane.
Logits mean_logits(const std::vector<Sample>& samples, const Weights& weights) {
    Logits none;
    none.fill(AdaptiveBit::kUntrained);
    std::vector<double> ones(none.size(), 0.2), seen(none.size(), 0.4);
    for (const Sample& sample : samples)
        code(sample, BlockModel(none, weights), [&](const BlockModel& model) {
            for (std::size_t k = 0; k < none.size(); ++k) {
                const double count = model.bits()[k].count();
                ones[k] += count * model.bits()[k].probability() / 65536.0;
                seen[k] += count;
            }
        });
    Logits logits = none;
    for (std::size_t k = 0; k < none.size(); ++k)
        if (seen[k] > 2.5) logits[k] = rounded(16 * std::log(ones[k] / (seen[k] - ones[k])));
    return logits;
}

/// Where the weights go, from the trained start, in blocks large enough to move them.
Weights moved_weights(const std::vector<Sample>& samples, const Logits& logits, const Weights& weights) {
    std::vector<double> sum(weights.size(), 0), of(weights.size(), 0);
    double total = 0;
    for (const Sample& sample : samples) {
        BlockModel end;
        const double bits = code(sample, BlockModel(logits, weights), [&end](const BlockModel& model) { end = model; });
        total += bits;
        if (sample.shape.size() < 100) continue;
        for (std::size_t k = 0; k < weights.size(); ++k) {
            const double weight = end.weights()[k / 2].weight[k % 2] / 1024.0;
            const double importance = weight == weights[k] ? 0 : 1 + std::sqrt(bits);
            sum[k] += importance * weight;
            of[k] += importance;
        }
    }
    std::fprintf(stderr, "%.0f bytes\n", total / 8);
    Weights out = weights;
    for (std::size_t k = 0; k < weights.size(); ++k)
        if (of[k] > 0) out[k] = rounded(std::max(sum[k] / of[k], 0.0));
    return out;
}

int run(int count, char** paths) {
    std::vector<Sample> samples;
    for (int k = 1; k < count; ++k) add_samples(paths[k], samples);
    if (samples.empty()) return 1;
    Weights weights;
    weights.fill(34);
    Logits logits = mean_logits(samples, weights);
    for (int round = 0; round < 5; ++round) {
        weights = moved_weights(samples, logits, weights);
        logits = mean_logits(samples, weights);
    }
    std::printf(
        "// Where the adaptive state of every block begins, made by tools/train/train_priors.cpp: logits in 1/16 "
        "(-128:\n"
        "// never met) in the order of BlockModel's contexts, and mixing weights in 1/64. Part of the format.\n"
        "#pragma once\n#include <array>\n#include <cstdint>\n\nnamespace mvw {\n\n");
    print("kTrainedLogits", logits);
    print("kTrainedWeights", weights);
    std::printf("\n}  // namespace mvw\n");
    return 0;
}

}  // namespace
}  // namespace mvw

int main(int argc, char** argv) {
    return mvw::run(argc, argv);
}
