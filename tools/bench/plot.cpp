#include "tools/bench/plot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace mvw::bench {
namespace {

constexpr double kWidth = 720, kHeight = 460, kLeft = 64, kRight = 24, kTop = 44, kBottom = 56;
constexpr std::array<const char*, 4> kColors{"#b04a2f", "#1f5fa8", "#3c8a4a", "#7a4fa0"};

/// Data to picture coordinates.
struct Frame {
    double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;  // log10 x, y

    explicit Frame(const std::vector<Curve>& curves) {
        for (const Curve& c : curves)
            for (const auto& [x, y] : c.points) {
                x0 = std::min(x0, std::log10(x));
                x1 = std::max(x1, std::log10(x));
                y0 = std::min(y0, y);
                y1 = std::max(y1, y);
            }
        if (x0 > x1) x0 = 0, x1 = 1, y0 = 0, y1 = 1;
        y0 = std::floor(y0 / 5) * 5;
        y1 = std::max(y0 + 5, std::ceil(y1 / 5) * 5);
        x1 = std::max(x1, x0 + 0.1);
    }
    [[nodiscard]] double x(double value) const {
        return kLeft + (std::log10(value) - x0) / (x1 - x0) * (kWidth - kLeft - kRight);
    }
    [[nodiscard]] double y(double value) const {
        return kHeight - kBottom - (value - y0) / (y1 - y0) * (kHeight - kTop - kBottom);
    }
};

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        out += c == '<' ? std::string("&lt;") : c == '&' ? std::string("&amp;") : std::string(1, c);
    return out;
}

std::string text(double x, double y, const char* anchor, const std::string& what) {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, escaped(what));
}

std::string grid(const Frame& f) {
    std::string out;
    const auto line = [&](double x0, double y0, double x1, double y1) {
        out += fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"#ddd\"/>\n", x0, y0, x1, y1);
    };
    for (int y = static_cast<int>(f.y0); y <= static_cast<int>(f.y1); y += 5) {
        line(kLeft, f.y(y), kWidth - kRight, f.y(y));
        out += text(kLeft - 6, f.y(y) + 4, "end", std::to_string(y));
    }
    for (int power = static_cast<int>(std::floor(f.x0)); power <= static_cast<int>(f.x1) + 1; ++power)
        for (const int digit : {1, 2, 5}) {
            const double x = digit * std::pow(10, power);
            if (std::log10(x) < f.x0 - 1e-9 || std::log10(x) > f.x1 + 1e-9) continue;
            line(f.x(x), kTop, f.x(x), kHeight - kBottom);
            out += text(f.x(x), kHeight - kBottom + 18, "middle", fmt::format("{:.0f}", x));
        }
    return out;
}

std::string polyline(const Frame& f, const Curve& curve, std::size_t number) {
    const char* color = kColors[number % kColors.size()];
    std::string path, dots;
    for (const auto& [x, y] : curve.points) {
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", f.x(x), f.y(y));
        dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.2\" fill=\"{}\"/>\n", f.x(x), f.y(y), color);
    }
    const double y = kTop + 18 + 18 * static_cast<double>(number);
    return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"/>\n", path, color) + dots +
           fmt::format("<path d=\"M{0} {2}L{1} {2}\" stroke=\"{3}\" stroke-width=\"3\"/>\n", kLeft + 12, kLeft + 36,
                       y - 4, color) +
           text(kLeft + 42, y, "start", curve.name);
}

}  // namespace

std::string Plot::svg() const {
    const Frame frame(curves);
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        kWidth, kHeight);
    out += grid(frame) + text(kWidth / 2, 24, "middle", title) + text(kWidth / 2, kHeight - 14, "middle", x_label);
    out += text(kLeft - 48, kTop - 14, "start", y_label);
    for (std::size_t i = 0; i < curves.size(); ++i) out += polyline(frame, curves[i], i);
    return out + "</svg>\n";
}

}  // namespace mvw::bench
