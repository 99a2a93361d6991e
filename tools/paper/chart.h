// Line charts as SVG.
#pragma once
#include <array>
#include <string>
#include <vector>

namespace mvw::paper {

struct Line {
    std::string name;
    std::vector<std::array<double, 2>> points;
};

struct Chart {
    std::string title, x_label, y_label;
    bool log_x = false, log_y = false;
    std::vector<Line> lines;

    /// Axes cover the data; a logarithmic one needs values above 0.
    [[nodiscard]] std::string svg() const;
};

}  // namespace mvw::paper
