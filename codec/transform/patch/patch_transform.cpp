#include <algorithm>

#include "codec/transform/reference/reference.h"
#include "codec/transform/transform.h"

namespace mvw {

struct PatchTransform::State {
    ReferenceTransform transform;
    std::vector<Vec3> in, out;
};

PatchTransform::PatchTransform(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                               std::span<const std::uint8_t> creases, unsigned)
    : state_(new State{ReferenceTransform(base, levels, options, creases), {}, {}}) {
    const std::uint64_t V = vertices_at_level(base, levels);
    state_->in.resize(V);
    state_->out.resize(V);
}
PatchTransform::~PatchTransform() = default;
PatchTransform::PatchTransform(PatchTransform&&) noexcept = default;
PatchTransform& PatchTransform::operator=(PatchTransform&&) noexcept = default;

void PatchTransform::analyze(std::span<const Vec3f> positions, std::span<Vec3f> coefficients) {
    std::transform(positions.begin(), positions.end(), state_->in.begin(), to_double);
    state_->transform.analyze(state_->in, state_->out);
    std::transform(state_->out.begin(), state_->out.end(), coefficients.begin(), to_float);
}

void PatchTransform::synthesize(std::span<const Vec3f> coefficients, unsigned level, std::span<Vec3f> positions) {
    const std::size_t V = positions.size();
    std::transform(coefficients.begin(), coefficients.begin() + V, state_->in.begin(), to_double);
    state_->transform.synthesize(std::span(state_->in).first(V), level, std::span(state_->out).first(V));
    std::transform(state_->out.begin(), state_->out.begin() + V, positions.begin(), to_float);
}

}  // namespace mvw
