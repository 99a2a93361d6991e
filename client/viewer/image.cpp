#include "client/viewer/image.h"

#include <stb_image_write.h>

#include <cstdio>

namespace mvw {

Result<void> write_png(const std::string& path, const Image& image) {
    const std::string unfinished = path + ".part";
    const auto fail = [&](const char* what) {
        std::remove(unfinished.c_str());
        return Error{Errc::Io, 0, path + ": " + what};
    };
    const auto w = static_cast<int>(image.width), h = static_cast<int>(image.height);
    if (stbi_write_png(unfinished.c_str(), w, h, 3, image.rgb.data(), 3 * w) == 0) return fail("cannot be written");
    if (std::rename(unfinished.c_str(), path.c_str()) != 0) return fail("cannot be renamed to its final name");
    return {};
}

}  // namespace mvw
