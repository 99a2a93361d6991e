// What materials say of a surface's colour: one colour, or an image times that.
#pragma once
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "codec/mesh/io/texture.h"
#include "codec/mesh/paintwork.h"

namespace mvw {

struct Paint {
    std::array<double, 4> color{1, 1, 1, 1};  // linear, and alpha
    bool opaque = false;                      // alpha is not meant
    std::shared_ptr<const Texture> texture;
    Texture::Wrap across = Texture::Wrap::Repeat, down = Texture::Wrap::Repeat;
    // Where in the image (u, v) lies: rows before (u, v, 1).
    std::array<std::array<double, 3>, 2> place{{{1, 0, 0}, {0, 1, 0}}};

    /// Red, green, blue (linear) and alpha; the colour alone where u or v is not finite.
    [[nodiscard]] std::array<double, 4> at(double u, double v) const;
};

/// Whether painting with these tells nothing: one grey for all, no image.
bool are_plain(std::span<const Paint> paints);

/// A mesh file's faces and their paints.
///
/// paint_of     F: number of each face's paint
/// coordinates  3 F: (u, v) of each corner, not finite where it has none
/// tints        empty, or V colours (linear, and alpha) that the paint is multiplied with
struct PaintedFaces {
    std::vector<Paint> paints;
    std::vector<std::uint32_t> paint_of;
    std::vector<std::array<float, 2>> coordinates;
    std::vector<std::array<float, 4>> tints;
};

/// surface: positions and faces.
std::unique_ptr<const Paintwork> make_paintwork(Mesh surface, PaintedFaces painted);

/// One colour for each vertex of the surface: the mean of its corners' in linear light; white where it has none.
std::vector<Rgba8> vertex_colors(const Paintwork& paintwork);

}  // namespace mvw
