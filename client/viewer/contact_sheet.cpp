#include <stb_easy_font.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "client/viewer/image.h"

namespace mvw {
namespace {

constexpr unsigned kTextScale = 2, kLineHeight = 12 * kTextScale, kGap = 12;
constexpr std::uint8_t kInk = 40;
constexpr std::size_t kTextLimit = 400;  // characters of a caption; the rest is left out

/// One corner of a rectangle, as stb_easy_font_print writes them: four a rectangle, clockwise from its upper left.
struct TextVertex {
    float x, y, z;
    std::array<std::uint8_t, 4> color;
};

void fill(Image& sheet, unsigned x0, unsigned y0, unsigned x1, unsigned y1) {
    for (unsigned y = y0; y < std::min(y1, sheet.height); ++y)
        for (unsigned x = x0; x < std::min(x1, sheet.width); ++x)
            std::fill_n(&sheet.rgb[(std::size_t{y} * sheet.width + x) * 3], 3, kInk);
}

void draw_text(Image& sheet, unsigned left, unsigned top, std::string text) {
    text.resize(std::min(text.size(), kTextLimit));
    std::vector<TextVertex> corners(std::size_t{80} * (kTextLimit + 1));  // the font needs at most 20 strokes a letter
    const int rectangles = stb_easy_font_print(0, 0, text.data(), nullptr, corners.data(),
                                               static_cast<int>(corners.size() * sizeof(TextVertex)));
    for (int i = 0; i < rectangles; ++i) {
        const TextVertex &a = corners[4 * static_cast<std::size_t>(i)],
                         &c = corners[4 * static_cast<std::size_t>(i) + 2];
        const auto at = [](unsigned origin, float t) { return origin + static_cast<unsigned>(t * kTextScale); };
        fill(sheet, at(left, a.x), at(top, a.y), at(left, c.x), at(top, c.y));
    }
}

void place(Image& sheet, const Image& image, unsigned left, unsigned top) {
    for (unsigned y = 0; y < image.height; ++y)
        std::memcpy(&sheet.rgb[(std::size_t{top + y} * sheet.width + left) * 3],
                    &image.rgb[std::size_t{y} * image.width * 3], std::size_t{3} * image.width);
}

}  // namespace

Image contact_sheet(const std::vector<SheetEntry>& entries, unsigned columns) {
    assert(columns >= 1);
    unsigned width = 1, height = 1, lines = 1;
    for (const SheetEntry& e : entries) {
        width = std::max(width, e.image.width);
        height = std::max(height, e.image.height);
        lines = std::max(lines, 1 + static_cast<unsigned>(std::count(e.caption.begin(), e.caption.end(), '\n')));
    }
    const auto count = static_cast<unsigned>(entries.size());
    columns = std::max(1u, std::min(columns, count));
    const unsigned rows = (count + columns - 1) / columns;
    const unsigned step_x = width + kGap, step_y = height + lines * kLineHeight + 2 * kGap;
    Image sheet{columns * step_x + kGap, rows * step_y + kGap, {}};
    sheet.rgb.assign(std::size_t{3} * sheet.width * sheet.height, 255);
    for (unsigned i = 0; i < count; ++i) {
        const unsigned left = kGap + i % columns * step_x, top = kGap + i / columns * step_y;
        place(sheet, entries[i].image, left, top);
        draw_text(sheet, left, top + height + kGap / 2, entries[i].caption);
    }
    return sheet;
}

}  // namespace mvw
