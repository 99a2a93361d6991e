#include "tools/bench/backs.h"

#include "client/viewer/picture.h"

namespace mvw::bench {
namespace {

constexpr double kYaws[] = {0, 90, 180, 270}, kPitches[] = {20, 60};
constexpr unsigned kWidth = 1500, kHeight = 900;
constexpr unsigned kLeastRed = 60;  // darker pixels do not tell their hue

/// Whether a pixel of a grey mesh's picture is mostly a back's red.
bool shows_back(unsigned red, unsigned green) {
    return red > kLeastRed && 5 * red > 8 * green;
}

Result<std::uint64_t> count_red(const Mesh& grey, bool in_place) {
    std::uint64_t count = 0;
    PictureOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.backs_in_place = in_place;
    for (const double yaw : kYaws)
        for (const double pitch : kPitches) {
            options.yaw = yaw;
            options.pitch = pitch;
            const auto picture = draw_picture(grey, options);
            if (!picture) return picture.error();
            for (std::size_t i = 0; i < picture->rgb.size(); i += 3)
                count += shows_back(picture->rgb[i], picture->rgb[i + 1]) ? 1 : 0;
        }
    return count;
}

}  // namespace

Result<BackPixels> count_backs(const Mesh& mesh) {
    const Mesh grey{mesh.positions, mesh.faces, {}, {}};
    const auto in_place = count_red(grey, true);
    if (!in_place) return in_place.error();
    const auto seen = *in_place > 0 ? count_red(grey, false) : in_place;
    if (!seen) return seen.error();
    return BackPixels{*in_place, *seen};
}

}  // namespace mvw::bench
