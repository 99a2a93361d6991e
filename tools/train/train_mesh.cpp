// Trains where the coding of coarse meshes begins, and what it expects of new vertices, and writes
// codec/entropy/mesh_priors.h to standard output; what it cost goes to standard error. Changes the format.
//   cmake --build build --target train_mesh
//   build/mvw encode MODEL x.mvw --base-faces N && build/mvw decode x.mvw BASE.ply --level 0    (N: 300, 900, 2400)
//   build/train_mesh BASE.ply... > mesh_priors.h && clang-format -i mesh_priors.h && mv mesh_priors.h codec/entropy/
// The present ones: koala, skull, lucy, human, bun_zipper, cycloidal, adis16480 and counter of the test models and
// libcgal-demo's armadillo, each with those N, and bob, spot, demosthenes, fandisk, plane_holes, box_assembly, koala,
// skull, lucy, human and bun_zipper with their own.
#include <Eigen/Dense>

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numeric>

#include "codec/entropy/enc_mesh_source.h"
#include "codec/entropy/mesh_priors.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/train/tables.h"

namespace mvw {
namespace {

using Logits = std::array<std::int8_t, MeshModel::kBits>;
using Mixing = std::array<std::int8_t, 2 * MeshModel::kWeights>;
constexpr double kCellsOfEdge = 8;  // as the encoder has them
constexpr int kRounds = 5;

struct Sample {
    BaseMesh mesh;
    std::vector<GridPoint> grid;
    unsigned bits, finer;  // of the grid; than kCellsOfEdge asks for
};

/// A vertex as it came, in units of its gate's length, from the gate's middle.
struct Arrival {
    std::size_t row;
    Eigen::Matrix<double, 3, 4> around;
    Eigen::Vector3d place;
};

/// Counts what a range coder would write.
class CostCounter : public MeshSource {
 public:
    using Bits = CostCounter;
    using MeshSource::MeshSource;
    bool code(std::uint32_t probability, bool truth) {
        bits += -std::log2((truth ? probability : 65536.0 - probability) / 65536.0);
        return truth;
    }
    double bits = 0;
};

Eigen::Vector3d point(const GridPoint& p) {
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/// Also remembers new vertices.
class Observer : public CostCounter {
 public:
    Observer(const Sample& sample, std::vector<Arrival>& out)
        : CostCounter(sample.mesh, sample.grid, 0), sample_(sample), out_(out) {}

    BeyondGate beyond(const MeshGrowth& growth, std::uint32_t gate) {
        const BeyondGate truth = CostCounter::beyond(growth, gate);
        if (truth.kind != BeyondGate::Vertex) return truth;
        const auto v = growth.vertex_count();
        const GateView view(growth, positions_, sample_.bits, gate);
        const auto at = [&](std::size_t k) { return point(positions_[view.around()[k]]); };
        const Eigen::Vector3d middle = (at(0) + at(1)) / 2;
        const double length = (at(0) - at(1)).norm();
        if (length == 0) return truth;
        Arrival arrival{view.prediction_class(), {}, (point(position(v)) - middle) / length};
        for (int k = 0; k < 4; ++k)
            arrival.around.col(k) = (at(k == 0 ? 0 : static_cast<std::size_t>(k) + 1) - middle) / length;
        out_.push_back(arrival);
        return truth;
    }
    const GridPoint& position(std::uint32_t v) {
        const GridPoint& p = CostCounter::position(v);
        if (v >= positions_.size()) positions_.resize(v + 1);
        positions_[v] = p;
        return p;
    }

 private:
    const Sample& sample_;
    std::vector<Arrival>& out_;
    std::vector<GridPoint> positions_;
};

template <typename Source>
bool run(const Sample& sample, MeshModel& model, Source& source) {
    return MeshCoder(sample.mesh.vertex_count(), sample.mesh.face_count(), source.has_boundary(), sample.bits, model,
                     source)
        .run();
}

void add_samples(const std::string& path, std::vector<Sample>& samples) {
    CleanReport report;
    Result<Mesh> read = read_mesh(path, report);
    if (!read.ok()) return std::fprintf(stderr, "%s: %s\n", path.c_str(), read.error().message.c_str()), void();
    const Mesh mesh = clean(std::move(*read), report);
    const Box box = bounding_box(mesh);
    double sum = 0;
    for (const Face& f : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) sum += length(mesh.positions[f[k]] - mesh.positions[f[(k + 1) % 3]]);
    const double edge = sum / (3.0 * static_cast<double>(mesh.faces.size())) / box.diagonal();
    const auto coarse = static_cast<unsigned>(std::lround(std::log2(kCellsOfEdge / edge)));
    for (const unsigned finer : {0u, 1u, 3u}) {
        Result<BaseMesh> base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces);
        if (!base.ok()) return std::fprintf(stderr, "%s: %s\n", path.c_str(), base.error().message.c_str()), void();
        Sample sample{std::move(*base), {}, coarse + finer, finer};
        for (const Vec3& p : mesh.positions) {
            const Vec3 q = (p - box.center()) * (std::ldexp(1.0, static_cast<int>(sample.bits)) / box.diagonal());
            sample.grid.push_back({static_cast<int>(std::lround(q.x)), static_cast<int>(std::lround(q.y)),
                                   static_cast<int>(std::lround(q.z))});
        }
        samples.push_back(std::move(sample));
    }
}

/// Weights that make the mean distance least, by least squares over and over.
Eigen::Vector4d fitted(const std::vector<Arrival>& arrivals, int row, const Eigen::Vector4d& usual) {
    constexpr double kPull = 3;  // arrivals' worth, towards the usual weights
    Eigen::Vector4d w = usual;
    for (int round = 0; round < 10; ++round) {
        Eigen::Matrix4d a = kPull * Eigen::Matrix4d::Identity();
        Eigen::Vector4d b = kPull * usual;
        for (const Arrival& x : arrivals) {
            if (row >= 0 && x.row != static_cast<std::size_t>(row)) continue;
            const double weight = 1 / ((x.place - x.around * w).norm() + 0.1);
            a += weight * x.around.transpose() * x.around;
            b += weight * x.around.transpose() * x.place;
        }
        w = a.ldlt().solve(b);
    }
    return w;
}

/// Each context's mean probability, and where the mixing weights have gone in the end.
void learn(const std::vector<Sample>& samples, const Logits& start, Logits& logits, Mixing& mixing) {
    std::vector<double> ones(logits.size(), 0.2), seen(logits.size(), 0.4), sum(mixing.size(), 0), of(mixing.size(), 0);
    std::map<unsigned, std::array<double, 2>> costs;  // by how much finer the grid is: bits, vertices
    for (const Sample& sample : samples) {
        CostCounter counter(sample.mesh, sample.grid, 0);
        MeshModel untrained(start, mixing), trained(logits, mixing);
        if (!run(sample, untrained, counter)) continue;
        CostCounter real(sample.mesh, sample.grid, 0);
        run(sample, trained, real);
        costs[sample.finer][0] += real.bits;
        costs[sample.finer][1] += sample.mesh.vertex_count();
        for (std::size_t k = 0; k < logits.size(); ++k) {
            const double count = untrained.bits[k].count();
            ones[k] += count * untrained.bits[k].probability() / 65536.0;
            seen[k] += count;
        }
        for (std::size_t k = 0; k < mixing.size(); ++k) {
            const double weight = trained.weights[k / 2].weight[k % 2] / 1024.0;
            if (weight == mixing[k]) continue;
            sum[k] += weight;
            of[k] += 1;
        }
    }
    for (const auto& [finer, cost] : costs)
        std::fprintf(stderr, "%.0f cells an edge: %.2f bits a vertex; ",
                     std::ldexp(kCellsOfEdge, static_cast<int>(finer)), cost[0] / cost[1]);
    std::fprintf(stderr, "\n");
    for (std::size_t k = 0; k < logits.size(); ++k)
        if (seen[k] > 2.5) logits[k] = rounded(16 * std::log(ones[k] / (seen[k] - ones[k])));
    for (std::size_t k = 0; k < mixing.size(); ++k)
        if (of[k] > 0) mixing[k] = rounded(std::max(sum[k] / of[k], 0.0));
}

int run(int count, char** paths) {
    std::vector<Sample> samples;
    for (int k = 1; k < count; ++k) add_samples(paths[k], samples);
    if (samples.empty()) return 1;
    std::vector<Arrival> arrivals;
    for (const Sample& sample : samples) {
        MeshModel model;
        Observer observer(sample, arrivals);
        run(sample, model, observer);
    }
    const Eigen::Vector4d usual = fitted(arrivals, -1, {0, -0.5, 0, 0});
    Logits none, logits;
    none.fill(AdaptiveBit::kUntrained);
    logits = none;
    Mixing mixing;
    mixing.fill(34);
    for (int round = 0; round < kRounds; ++round) learn(samples, none, logits, mixing);
    std::printf(
        "// Where the coding of a coarse mesh begins, made by tools/train/train_mesh.cpp: logits in 1/16 (-128: never "
        "met)\n// in the order of MeshModel's contexts, mixing weights in 1/64, and by GateView::prediction_class() "
        "the "
        "weights, in\n// 1/64, of the gate's start, the inner vertex and the ring's before and behind. Part of the "
        "format.\n#pragma once\n#include <array>\n#include <cstdint>\n\nnamespace mvw {\n\n");
    print("kTrainedMeshLogits", logits);
    print("kTrainedMeshWeights", mixing);
    std::printf("inline constexpr std::array<std::array<std::int8_t, 4>, %zu> kMeshPrediction{{",
                kMeshPrediction.size());
    for (std::size_t row = 0; row < kMeshPrediction.size(); ++row) {
        const Eigen::Vector4d w = 64 * fitted(arrivals, static_cast<int>(row), usual);
        std::printf("%s{%d, %d, %d, %d}", row == 0 ? "" : ", ", rounded(w[0]), rounded(w[1]), rounded(w[2]),
                    rounded(w[3]));
    }
    std::printf("}};\n\n}  // namespace mvw\n");
    return 0;
}

}  // namespace
}  // namespace mvw

int main(int argc, char** argv) {
    return mvw::run(argc, argv);
}
