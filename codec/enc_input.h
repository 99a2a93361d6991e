// The surface that is being encoded, with what the encoder's steps ask of it again and again, made once.
#pragma once
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "codec/container/enc_file.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/mesh.h"
#include "codec/remesh/remesh.h"
#include "codec/remesh/surface_walk.h"

namespace mvw {

/// The faces of the input that one part of a remesh stands for, in coded units: around the header's centre, in units of
/// its diagonal. Any number of threads may ask at once.
class PartSurface {
 public:
    /// mesh: clean, at least one face of positive area; in coded units.
    /// feature_angle_deg: of RemeshResult.
    PartSurface(Mesh mesh, unsigned threads, double feature_angle_deg = kFeatureAngleDeg);
    PartSurface(const PartSurface&) = delete;
    PartSurface& operator=(const PartSurface&) = delete;

    [[nodiscard]] const Mesh& mesh() const { return mesh_; }
    /// For distances as fractions of this part's diagonal, and for nearest points in coded units.
    [[nodiscard]] const ReferenceSurface& reference() const { return reference_; }
    /// with_features: paths stop at features (remesh/features.h).
    const SurfaceWalk& walk(bool with_features);

 private:
    const Mesh mesh_;
    const ReferenceSurface reference_;
    const double feature_angle_deg_;
    std::mutex mutex_;  // of what follows
    std::optional<SurfaceWalk> walk_, walk_with_features_;
};

/// A mesh to encode. Any number of threads may ask at once.
class EncoderInput {
 public:
    /// mesh: measurable(); must outlive this. threads: to build indices, at least 1. InvalidArgument where its box does
    /// not fit the header.
    static Result<std::unique_ptr<EncoderInput>> make(const Mesh& mesh, unsigned threads);

    [[nodiscard]] const Mesh& mesh() const { return mesh_; }
    [[nodiscard]] const FileHeader& header() const { return header_; }  // centre and diagonal, nothing else
    [[nodiscard]] const ReferenceSurface& reference() const { return reference_; }
    [[nodiscard]] Vec3 to_coded_units(const Vec3& p) const;
    [[nodiscard]] Vec3 to_model_units(const Vec3& p) const;
    /// The faces of a part of a remesh. Stays; who asks for the same faces again gets the same.
    PartSurface& part(const RemeshResult& remeshed, std::uint32_t part);

 private:
    EncoderInput(const Mesh& mesh, const FileHeader& header, unsigned threads);

    const Mesh& mesh_;
    const FileHeader header_;
    const unsigned threads_;
    const ReferenceSurface reference_;
    struct Part {
        std::vector<std::uint8_t> has_face;  // F
        double feature_angle_deg;
        std::unique_ptr<PartSurface> surface;
    };
    std::mutex mutex_;  // of what follows
    std::vector<Part> parts_;
};

}  // namespace mvw
