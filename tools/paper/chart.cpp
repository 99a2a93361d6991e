#include "tools/paper/chart.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace mvw::paper {
namespace {

constexpr double kWidth = 560, kHeight = 380, kLeft = 70, kRight = 150, kTop = 40, kBottom = 52;
constexpr std::array<const char*, 11> kColors{"#b04a2f", "#1f5fa8", "#3c8a4a", "#7a4fa0", "#c98a1b", "#2a9d9d",
                                              "#8a8a2a", "#d0559a", "#555555", "#000000", "#86b1dd"};

/// One axis: values to a span of the picture, and where its ticks are.
struct Axis {
    bool log = false;
    double from = 0, to = 1;  // in log10 where log
    std::vector<double> ticks;

    Axis(bool logarithmic, double least, double most) : log(logarithmic) {
        from = log ? std::log10(least) : least;
        to = log ? std::log10(most) : most;
        if (!(to > from)) to = from + 1;
        log ? log_ticks() : linear_ticks();
    }
    [[nodiscard]] double at(double value) const { return ((log ? std::log10(value) : value) - from) / (to - from); }

 private:
    void linear_ticks() {
        double step = std::pow(10, std::floor(std::log10((to - from) / 3)));
        while ((to - from) / step > 7) step *= (to - from) / step > 16 ? 5 : 2;
        from = std::floor(from / step + 1e-9) * step;
        to = std::ceil(to / step - 1e-9) * step;
        const auto last = std::lround((to - from) / step);
        for (long k = 0; k <= last; ++k) {
            const double t = from + double(k) * step;
            ticks.push_back(std::abs(t) < step / 1e6 ? 0 : t);
        }
    }
    void log_ticks() {
        const double margin = (to - from) * 0.06;
        from -= margin, to += margin;
        const bool few = to - from < 1.5;
        for (int power = int(std::floor(from)); power <= int(std::ceil(to)); ++power)
            for (const int digit : {1, 2, 5})
                if (const double t = std::log10(digit) + power; t >= from && t <= to && (few || digit == 1))
                    ticks.push_back(digit * std::pow(10, power));
    }
};

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        out += c == '<' ? std::string("&lt;") : c == '&' ? std::string("&amp;") : std::string(1, c);
    return out;
}
std::string text(double x, double y, const char* anchor, const std::string& what, const char* more = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                       escaped(what));
}
std::string stroke(double x0, double y0, double x1, double y1, const char* color, double width = 1) {
    return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"{}\" stroke-width=\"{}\"/>\n", x0, y0, x1, y1,
                       color, width);
}

struct Frame {
    Axis x, y;
    [[nodiscard]] double px(double v) const { return kLeft + x.at(v) * (kWidth - kLeft - kRight); }
    [[nodiscard]] double py(double v) const { return kHeight - kBottom - y.at(v) * (kHeight - kTop - kBottom); }
};

Frame frame_of(const Chart& chart) {
    double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
    for (const Line& line : chart.lines)
        for (const auto& [x, y] : line.points) {
            x0 = std::min(x0, x), x1 = std::max(x1, x);
            y0 = std::min(y0, y), y1 = std::max(y1, y);
        }
    if (x0 > x1) x0 = y0 = 1, x1 = y1 = 10;
    return {Axis(chart.log_x, x0, x1), Axis(chart.log_y, y0, y1)};
}

std::string grid(const Frame& f) {
    std::string out;
    for (const double t : f.x.ticks)
        out += stroke(f.px(t), kTop, f.px(t), kHeight - kBottom, "#e4e4e4") +
               text(f.px(t), kHeight - kBottom + 18, "middle", fmt::format("{:.4g}", t));
    for (const double t : f.y.ticks)
        out += stroke(kLeft, f.py(t), kWidth - kRight, f.py(t), "#e4e4e4") +
               text(kLeft - 8, f.py(t) + 4, "end", fmt::format("{:.4g}", t));
    out += stroke(kLeft, kTop, kLeft, kHeight - kBottom, "#888");
    return out + stroke(kLeft, kHeight - kBottom, kWidth - kRight, kHeight - kBottom, "#888");
}

std::string draw(const Frame& f, const Line& line, std::size_t number) {
    const char* color = kColors[number % kColors.size()];
    // Colours repeat nowhere; dashes help those who cannot tell them apart.
    const char* dash = number % 3 == 0   ? ""
                       : number % 3 == 1 ? " stroke-dasharray=\"7 3\""
                                         : " stroke-dasharray=\"2 3\"";
    std::string path, dots;
    for (const auto& [x, y] : line.points) {
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", f.px(x), f.py(y));
        dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.8\" fill=\"{}\"/>\n", f.px(x), f.py(y), color);
    }
    const double y = kTop + 12 + 19 * double(number), x = kWidth - kRight + 12;
    return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"{}/>\n", path, color, dash) +
           dots +
           fmt::format("<path d=\"M{0:.1f} {1:.1f}h22\" stroke=\"{2}\" stroke-width=\"2.4\"{3}/>\n", x, y - 4, color,
                       dash) +
           text(x + 28, y, "start", line.name);
}

}  // namespace

std::string Chart::svg() const {
    const Frame frame = frame_of(*this);
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"DejaVu Sans, sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" "
        "fill=\"white\"/>\n",
        kWidth, kHeight);
    out += grid(frame) + text((kLeft + kWidth - kRight) / 2, 22, "middle", title, " font-weight=\"bold\"") +
           text((kLeft + kWidth - kRight) / 2, kHeight - 12, "middle", x_label) +
           text(16, (kTop + kHeight - kBottom) / 2, "middle", y_label,
                fmt::format(" transform=\"rotate(-90 16 {:.1f})\"", (kTop + kHeight - kBottom) / 2).c_str());
    for (std::size_t i = 0; i < lines.size(); ++i) out += draw(frame, lines[i], i);
    return out + "</svg>\n";
}

}  // namespace mvw::paper
