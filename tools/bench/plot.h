// Line plots as SVG.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace mvw::bench {

/// A named line through points (x, y), in order of rising x > 0.
struct Curve {
    std::string name;
    std::vector<std::array<double, 2>> points;
};

/// Curves over a logarithmic x axis.
struct Plot {
    std::string title, x_label, y_label;
    std::vector<Curve> curves;

    [[nodiscard]] std::string svg() const;
};

}  // namespace mvw::bench
