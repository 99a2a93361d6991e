#include "codec/enc_progressive.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "codec/enc_lattice.h"
#include "codec/enc_splits.h"
#include "codec/entropy/dec_splits.h"

namespace mvw {

namespace {

// Of the vertices, what a round splits, from how many on the most; below as their root. More would take dear ones, too,
// of which coarse versions have more; fewer cost more bits to find.
constexpr double kMostShare = 0.1, kLeastShare = 0.05, kVerticesOfMostShare = 2000;
constexpr std::size_t kFewestFaces = 32, kMostFacesAround = VertexRing::kMostFaces;
constexpr std::size_t kMostVersions = 200;
constexpr double kWorthARound = 0.02;  // of the vertices: with fewer it would take too many
constexpr unsigned kMostLayers = 64;
constexpr double kStay = 4;            // times the error of the best place: what ends may have that need not be moved
constexpr double kRounding = 1.2;      // times a version's error, what it has on its lattice
constexpr double kFinestError = 3e-5;  // RMS, of a version: planes follow
constexpr unsigned kFewestBits = 6, kMostBits = 14;
constexpr double kGrowth = 1.4;  // of vertices, in a chunk
constexpr std::uint32_t kSamples = 30'000, kSamplesOfVersions = 10'000;

/// A version of the mesh, and the collapses that have led to it from a finer one.
struct Version {
    Mesh mesh;
    std::vector<std::uint32_t> names;  // of its vertices: numbers in the finest
    double error = 0;                  // RMS, its vertices as they are
    Lattice lattice;                   // on which they are little worse
    std::vector<Collapse> collapses;
};

double rms_of(const EncoderInput& input, const std::vector<Face>& faces, std::span<const Vec3> positions,
              const SurfaceErrorOptions& sampling) {
    const std::optional<SurfaceError> error = error_of(input, faces, positions, sampling);
    return error ? error->rms : 1;
}

double share_of_round(double vertices) {
    return std::clamp(kMostShare * std::sqrt(vertices / kVerticesOfMostShare), kLeastShare, kMostShare);
}

/// Finds versions, the finest first, each with the coarsest lattice that will do. Lattices change only where they have
/// fewer bits.
class Versions {
 public:
    Versions(const EncoderInput& input, const Mesh& finest, unsigned threads)
        : input_(input), threads_(threads), simplifier_(finest, kStay) {
        add({});
        while (simplifier_.faces() > kFewestFaces && versions_.size() < kMostVersions) {
            const auto vertices = static_cast<double>(versions_.back().mesh.positions.size());
            std::vector<Collapse> round = simplifier_.simplify_round(
                static_cast<std::size_t>(std::ceil(share_of_round(vertices) * vertices)), kMostFacesAround);
            if (round.empty() || double(round.size()) < kWorthARound * vertices) break;
            add(std::move(round));
        }
    }
    [[nodiscard]] const std::vector<Version>& all() const { return versions_; }

 private:
    void add(std::vector<Collapse> collapses) {
        Version v;
        v.collapses = std::move(collapses);
        v.mesh = simplifier_.mesh(&v.names);
        v.error = rms_of(input_, v.mesh.faces, v.mesh.positions, sampled(kSamplesOfVersions, threads_));
        const std::vector<Vec3>& positions = v.mesh.positions;
        v.lattice =
            versions_.empty() ? fit_nested_lattice(positions, v.mesh.faces, kMostBits) : versions_.back().lattice;
        const unsigned least = std::max(kFewestBits, v.lattice.bits - kMostFinerBits);  // both are above zero
        while (v.lattice.bits > least) {
            const Lattice coarser = fit_nested_lattice(positions, v.mesh.faces, v.lattice.bits - 1u);
            const double moved = moved_by_rounding(round_to(coarser, positions), positions, v.mesh.faces);
            if (std::hypot(v.error, moved) > kRounding * std::max(v.error, kFinestError)) break;
            v.lattice = coarser;
        }
        versions_.push_back(std::move(v));
    }

    const EncoderInput& input_;
    const unsigned threads_;
    Simplifier simplifier_;
    std::vector<Version> versions_;
};

/// The coarse version that a file begins with.
struct Beginning {
    std::size_t version = 0;
    CodedBase base;
};

/// The finest that is short enough, or the coarsest; nothing where that is the finest of all.
std::optional<Beginning> beginning_of(const std::vector<Version>& versions, double bytes) {
    std::optional<Beginning> best;
    for (std::size_t k = versions.size(); k-- > 1;) {
        const Mesh& mesh = versions[k].mesh;
        Result<BaseMesh> base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces);
        if (!base.ok()) continue;
        const Rounded rounded = round_to(versions[k].lattice, mesh.positions);
        CodedBase coded = code_base(*base, rounded.grid, rounded.lattice.bits, false);
        if (best && double(coded.bytes.size()) > bytes) break;
        best = {k, std::move(coded)};
    }
    return best;
}

/// Codes the versions after the first, round by round.
class Growth {
 public:
    Growth(const EncoderInput& input, const std::vector<Version>& versions, const Beginning& beginning,
           unsigned threads)
        : input_(input),
          versions_(versions),
          version_(beginning.version),
          threads_(threads),
          mesh_{SplitMesh(beginning.base.mesh, materials(beginning)),
                {versions[version_].lattice, beginning.base.grid},
                0},
          source_(names(beginning), positions()) {}

    [[nodiscard]] PlannedChunk base(const Beginning& beginning, PartParams params) const {
        SemiRegularMesh mesh;
        mesh.base = beginning.base.mesh;
        mesh.materials = mesh_.mesh.materials();
        params.lattice = mesh_.at.lattice;
        PlannedChunk chunk;
        chunk.payload = write_base(beginning.base, mesh, params);
        chunk.error = error();
        return chunk;
    }
    /// Nothing where there are no finer ones, or the next one cannot be coded.
    std::optional<PlannedChunk> next() {
        if (version_ == 0 || failed_ || layer_ == kMostLayers) return std::nullopt;
        const Lattice before = mesh_.at.lattice;
        const std::size_t begun = mesh_.mesh.vertex_count();
        SplitCoder coder(mesh_, static_cast<std::uint32_t>(versions_[0].mesh.positions.size()), source_);
        SplitsFront front;
        while (version_ > 0 && front.rounds.size() < kMostSplitRounds &&
               double(mesh_.mesh.vertex_count()) < kGrowth * double(begun)) {
            source_.begin_round(versions_[version_].collapses, versions_[version_ - 1].lattice);
            --version_;
            front.rounds.push_back(versions_[version_].lattice);
            failed_ = !coder.run(front.rounds.back());
            if (failed_) return std::nullopt;
            source_.end_round();
            failed_ = mesh_.mesh.vertex_count() != versions_[version_].mesh.positions.size();
            if (failed_) return std::nullopt;
        }
        PlannedChunk chunk;
        chunk.id.channel = Channel::Splits;
        chunk.id.layer = layer_++;
        ByteWriter payload;
        write_splits_front(payload, front, before);
        Bytes bytes = source_.take_bytes();
        bytes.resize(
            std::max(bytes.size(), least_bytes_of_splits(begun, mesh_.mesh.vertex_count(), front.rounds.size())));
        payload.bytes(bytes);
        chunk.payload = payload.take();
        chunk.error = error();
        return chunk;
    }
    [[nodiscard]] PartInfo info() const {
        const BaseMesh mesh = BaseMesh::create(mesh_.mesh.vertex_count(), mesh_.mesh.faces()).value();
        PartInfo info;
        info.base_vertices = mesh.vertex_count();
        info.base_edges = mesh.edge_count();
        info.base_faces = mesh.face_count();
        info.progressive = true;
        return info;
    }
    [[nodiscard]] bool is_done() const { return version_ == 0 && !failed_; }
    /// What a decoder has then, but for the rounding.
    [[nodiscard]] SemiRegularMesh mesh() const {
        SemiRegularMesh out;
        out.base = BaseMesh::create(mesh_.mesh.vertex_count(), mesh_.mesh.faces()).value();
        out.materials = mesh_.mesh.materials();
        for (const std::uint32_t name : source_.names()) out.positions.push_back(source_.positions()[name]);
        return out;
    }
    [[nodiscard]] const Rounded& rounded() const { return mesh_.at; }

 private:
    [[nodiscard]] const Version& coarse() const { return versions_[version_]; }
    [[nodiscard]] std::vector<std::uint32_t> materials(const Beginning& b) const {
        std::vector<std::uint32_t> out;
        if (!coarse().mesh.materials.empty())
            for (const std::uint32_t f : b.base.source_face) out.push_back(coarse().mesh.materials[f]);
        return out;
    }
    [[nodiscard]] std::vector<std::uint32_t> names(const Beginning& b) const {
        std::vector<std::uint32_t> out(b.base.mesh.vertex_count());
        for (std::uint32_t f = 0; f < b.base.mesh.face_count(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const Face& source = coarse().mesh.faces[b.base.source_face[f]];
                out[b.base.mesh.faces()[f][k]] = coarse().names[source[(k + b.base.source_corner[f]) % 3]];
            }
        return out;
    }
    [[nodiscard]] std::vector<Vec3> positions() const {
        std::vector<Vec3> out(versions_[0].mesh.positions.size());
        for (std::size_t v = 0; v < coarse().names.size(); ++v) out[coarse().names[v]] = coarse().mesh.positions[v];
        return out;
    }
    [[nodiscard]] double error() const {
        return rms_of(input_, mesh_.mesh.faces(), points_of(mesh_.at), sampled(kSamples, threads_));
    }

    const EncoderInput& input_;
    const std::vector<Version>& versions_;
    std::size_t version_;  // that mesh_ is
    const unsigned threads_;
    ProgressiveMesh mesh_;
    SplitSource source_;
    std::uint8_t layer_ = 0;
    bool failed_ = false;
};

}  // namespace

Stage Progressive::beginning(std::size_t splits) const {
    Stage stage;
    stage.info = grown[splits];
    stage.chunks.assign(whole.chunks.begin(), whole.chunks.begin() + std::ptrdiff_t(splits) + 1);
    return stage;
}

std::optional<Progressive> code_progressive(const EncoderInput& input, const Lod& version,
                                            const ProgressiveOptions& options) {
    Mesh mesh;
    mesh.positions = version.mesh.positions;
    mesh.faces = version.mesh.base.faces();
    mesh.materials = version.mesh.materials;
    const Versions versions(input, mesh, options.threads);
    std::optional<Beginning> beginning = beginning_of(versions.all(), options.base_bytes);
    if (!beginning) return std::nullopt;
    beginning->base.progressive = true;
    Growth growth(input, versions.all(), *beginning, options.threads);
    const Growth at_first = growth;
    Progressive out;
    out.grown.push_back(growth.info());
    std::vector<PlannedChunk> splits;
    while (std::optional<PlannedChunk> chunk = growth.next()) {
        splits.push_back(std::move(*chunk));
        out.grown.push_back(growth.info());
    }
    if (!growth.is_done()) return std::nullopt;
    Stage& stage = out.whole;
    stage = code_planes_of(input, {growth.mesh(), version.error}, growth.rounded(),
                           {growth.rounded().lattice.bits, options.error, options.fast, options.threads});
    stage.info.supersedes = false;
    stage.info.progressive = true;
    for (PlannedChunk& c : stage.chunks) c.error = std::min(c.error, splits.back().error);
    stage.chunks.front() = at_first.base(*beginning, stage.part.params);
    stage.chunks.insert(stage.chunks.begin() + 1, splits.begin(), splits.end());
    return out;
}

}  // namespace mvw
