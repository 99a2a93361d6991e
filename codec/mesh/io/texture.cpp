#include "codec/mesh/io/texture.h"

#include <stb_image.h>
#include <webp/decode.h>

#include <cmath>
#include <cstring>
#include <memory>

#include "codec/mesh/io/text.h"
#include "codec/mesh/srgb.h"

namespace mvw {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;
/// One-bit pixels deflated 1,032 times, the most that is possible.
constexpr std::uint64_t kMostPixelsOfByte = 8 * 1032;
/// An image of one colour may have any size in WebP: so many are believed.
constexpr std::uint64_t kFewPixels = std::uint64_t{1} << 22;

/// Other formats of the library are not for bytes from strangers.
bool is_png_or_jpeg(std::string_view file) {
    return file.starts_with("\x89PNG\r\n\x1A\n") || file.starts_with("\xFF\xD8\xFF");
}

bool is_webp(std::string_view file) {
    return file.starts_with("RIFF") && file.size() >= 12 && file.substr(8, 4) == "WEBP";
}

Error too_many_pixels() {
    return {Errc::LimitExceeded, 0, "has more pixels than its bytes can stand for, or than 67 million"};
}

/// Texel that stands at `at`, of n.
std::int64_t wrapped(std::int64_t at, std::int64_t n, Texture::Wrap wrap) {
    if (wrap == Texture::Wrap::Clamp) return std::clamp<std::int64_t>(at, 0, n - 1);
    const std::int64_t period = wrap == Texture::Wrap::Mirror ? 2 * n : n;
    at = (at % period + period) % period;
    return at < n ? at : period - 1 - at;
}

}  // namespace

Result<Texture> Texture::decode_webp(ByteSpan file) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
    int width = 0, height = 0;
    if (WebPGetInfo(bytes, file.size(), &width, &height) == 0 || width < 1 || height < 1)
        return Error{Errc::Malformed, 0, "is no valid image"};
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (pixels > kMostPixels || pixels > std::max(kFewPixels, kMostPixelsOfByte * file.size()))
        return too_many_pixels();
    Texture out(width, height);
    auto* const to = reinterpret_cast<std::uint8_t*>(out.texels_.data());
    if (WebPDecodeRGBAInto(bytes, file.size(), to, 4 * pixels, 4 * width) == nullptr)
        return Error{Errc::Malformed, 0, "is a damaged image"};
    return out;
}

Result<Texture> Texture::decode(ByteSpan file) {
    if (is_webp(as_text(file))) return decode_webp(file);
    if (!is_png_or_jpeg(as_text(file))) return Error{Errc::Unsupported, 0, "is neither PNG, JPEG nor WebP"};
    const auto* bytes = reinterpret_cast<const stbi_uc*>(file.data());
    const auto size = static_cast<int>(std::min<std::size_t>(file.size(), 0x7FFFFFFF));
    int width = 0, height = 0, channels = 0;
    if (stbi_info_from_memory(bytes, size, &width, &height, &channels) == 0 || width < 1 || height < 1)
        return Error{Errc::Malformed, 0, "is no valid image"};
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (pixels > kMostPixels || pixels > kMostPixelsOfByte * file.size()) return too_many_pixels();
    const std::unique_ptr<stbi_uc, void (*)(void*)> rgba(
        stbi_load_from_memory(bytes, size, &width, &height, &channels, 4), stbi_image_free);
    if (!rgba) return Error{Errc::Malformed, 0, "is a damaged image"};
    Texture out(width, height);
    static_assert(sizeof(Rgba8) == 4);
    std::memcpy(out.texels_.data(), rgba.get(), 4 * pixels);
    return out;
}

std::array<double, 4> Texture::at(double u, double v, Wrap across, Wrap down) const {
    constexpr double kFar = 1e6;  // more turns than any model has, few enough for integers
    std::array<double, 4> sum{};
    if (!(std::abs(u) < kFar && std::abs(v) < kFar)) return sum;
    // Texels' middles are at halves.
    const double x = u * static_cast<double>(width_) - 0.5, y = v * static_cast<double>(height_) - 0.5;
    const double left = std::floor(x), top = std::floor(y);
    for (unsigned k = 0; k < 4; ++k) {
        const unsigned right = k & 1, below = k >> 1;
        const double weight = (right != 0 ? x - left : 1 - (x - left)) * (below != 0 ? y - top : 1 - (y - top));
        const std::int64_t column = wrapped(static_cast<std::int64_t>(left) + right, width_, across);
        const std::int64_t row = wrapped(static_cast<std::int64_t>(top) + below, height_, down);
        const std::array<double, 4> c = to_linear(texels_[static_cast<std::size_t>(row * width_ + column)]);
        for (std::size_t n = 0; n < 4; ++n) sum[n] += weight * c[n];
    }
    return sum;
}

}  // namespace mvw
