// Colours of a surface between its vertices: what materials and their images say before they become colours of the
// vertices that are coded.
#pragma once
#include <array>
#include <cstdint>

#include "codec/mesh/mesh.h"

namespace mvw {

class Paintwork {
 public:
    Paintwork() = default;
    Paintwork(const Paintwork&) = delete;
    Paintwork& operator=(const Paintwork&) = delete;
    virtual ~Paintwork() = default;

    /// The painted faces as their file has them, not cleaned: positions finite, in model units, indices in range.
    [[nodiscard]] virtual const Mesh& surface() const = 0;
    /// Red, green, blue (linear) and alpha in [0, 1] of the point of a face at these weights of its corners.
    [[nodiscard]] virtual std::array<double, 4> at(std::uint32_t face, const std::array<double, 3>& weights) const = 0;
};

}  // namespace mvw
