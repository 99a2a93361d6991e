// Images that meshes are painted with.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

class Texture {
 public:
    enum class Wrap : std::uint8_t { Repeat, Mirror, Clamp };

    /// A PNG, JPEG or WebP file (those that glTF knows but for KTX), through Debian's libstb and libwebp. Unsupported
    /// where it is none; Malformed where it is damaged; LimitExceeded where it has over 2^26 pixels, or more than its
    /// bytes can stand for.
    static Result<Texture> decode(ByteSpan file);
    /// Red, green, blue (linear, in [0, 1]) and alpha between the four texels around (u, v); (0, 0) is the upper left
    /// corner of the image, (1, 1) the lower right one. Zeros where u or v is not finite, or beyond a million.
    [[nodiscard]] std::array<double, 4> at(double u, double v, Wrap across, Wrap down) const;
    [[nodiscard]] std::size_t pixels() const { return texels_.size(); }

 private:
    Texture(std::int64_t width, std::int64_t height)
        : width_(width), height_(height), texels_(static_cast<std::size_t>(width * height)) {}
    static Result<Texture> decode_webp(ByteSpan file);
    std::int64_t width_, height_;
    std::vector<Rgba8> texels_;  // rows from the top
};

/// The images that a mesh file names, each decoded once; together at most kMostPixelsTogether.
template <typename Key>
class Textures {
 public:
    /// Decoded by `decode` (a Result<Texture>) where it is asked for first; null where it could not be read, which is
    /// then added to `missing` by that name.
    template <typename Decode>
    std::shared_ptr<const Texture> get(const Key& key, const std::string& name, const Decode& decode,
                                       std::vector<std::string>& missing) {
        const auto [known, is_new] = known_.try_emplace(key);
        if (!is_new) return known->second;
        Result<Texture> texture = decode();
        if (texture && texture->pixels() > pixels_left_)
            texture = Error{Errc::LimitExceeded, 0, "the file's images have too many pixels together"};
        if (!texture) {
            missing.push_back(name + ": " + texture.error().message);
            return nullptr;
        }
        pixels_left_ -= texture->pixels();
        return known->second = std::make_shared<const Texture>(std::move(*texture));
    }

 private:
    static constexpr std::uint64_t kMostPixelsTogether = std::uint64_t{1} << 27;
    std::uint64_t pixels_left_ = kMostPixelsTogether;
    std::map<Key, std::shared_ptr<const Texture>> known_;
};

}  // namespace mvw
