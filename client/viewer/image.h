// Pictures in memory, as PNG files, and side by side.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "codec/result.h"

namespace mvw {

/// 8-bit sRGB rows, top row first, 3 bytes a pixel.
struct Image {
    unsigned width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

/// Writes a PNG beside its final name, then renames. Io names the file.
Result<void> write_png(const std::string& path, const Image& image);

/// One picture of a contact sheet; line breaks in the caption are kept.
struct SheetEntry {
    Image image;
    std::string caption;  // printable ASCII
};

/// Puts pictures in rows of `columns` on a white sheet, each with its caption below; columns >= 1 (assert). Cells are
/// as large as the largest picture.
Image contact_sheet(const std::vector<SheetEntry>& entries, unsigned columns);

}  // namespace mvw
