#include "client/viewer/animation.h"

#include <fmt/format.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>

#include "codec/decoder.h"
#include "codec/mesh/io/files.h"

namespace mvw {
namespace {

constexpr unsigned kStepMilliseconds = 160, kLastMilliseconds = 2500;
constexpr float kQuality = 82;  // of WebP, 0 to 100

void turn_up(Mesh& mesh, bool z_up) {
    if (z_up)
        for (Vec3& p : mesh.positions) p = {p.x, p.z, -p.y};
}

std::string caption_of(const DecodeState& state, std::size_t bytes) {
    const double kilobytes = static_cast<double>(bytes) / 1024;
    return fmt::format("{:.{}f} KB   {:.1f} dB", kilobytes, kilobytes < 10 ? 1 : 0, -20 * std::log10(state.error));
}

/// Rising numbers of bytes, from the first mesh's to all.
std::vector<std::size_t> steps_between(std::size_t first, std::size_t all, unsigned count) {
    std::vector<std::size_t> steps;
    const double ratio = static_cast<double>(all) / static_cast<double>(first);
    for (unsigned k = 0; k < count; ++k) {
        const double step = static_cast<double>(first) * std::pow(ratio, static_cast<double>(k) / (count - 1));
        steps.push_back(std::min(all, static_cast<std::size_t>(std::lround(step))));
    }
    return steps;
}

/// Bytes of the file with which there is a mesh; all where there never is one.
std::size_t first_mesh_bytes(ByteSpan file) {
    constexpr std::size_t kSlice = 64;
    Decoder decoder;
    for (std::size_t at = 0; at < file.size(); at += kSlice) {
        const ByteSpan slice = file.subspan(at, std::min(kSlice, file.size() - at));
        if (!decoder.feed(slice).ok() || decoder.mesh(0).ok()) return at + slice.size();
    }
    return file.size();
}

}  // namespace

Result<std::vector<Frame>> draw_refinement(ByteSpan file, unsigned count, bool z_up, PictureOptions options) {
    assert(count >= 2);
    Decoder whole;
    if (const Result<void> fed = whole.feed(file); !fed.ok()) return fed.error();
    Result<Mesh> finest = whole.mesh();
    if (!finest.ok()) return finest.error();
    turn_up(*finest, z_up);
    options.camera = fit_camera(*finest, options.yaw, options.pitch, 1.0 * options.width / options.height);
    Decoder decoder;
    std::vector<Frame> frames;
    std::size_t fed_bytes = 0;
    std::uint64_t drawn = 0;
    for (const std::size_t bytes : steps_between(first_mesh_bytes(file), file.size(), count)) {
        if (const Result<void> fed = decoder.feed(file.subspan(fed_bytes, bytes - fed_bytes)); !fed.ok())
            return fed.error();
        fed_bytes = bytes;
        if (decoder.revision() == drawn) continue;  // no chunk has ended since
        drawn = decoder.revision();
        const DecodeState state = decoder.state();
        Result<Mesh> mesh = decoder.mesh(state.level + 1);
        if (!mesh.ok()) return mesh.error();
        turn_up(*mesh, z_up);
        const Result<Image> picture = draw_picture(*mesh, options);
        if (!picture.ok()) return picture.error();
        frames.push_back({contact_sheet({{*picture, caption_of(state, bytes)}}, 1), kStepMilliseconds});
    }
    frames.back().milliseconds = kLastMilliseconds;
    return frames;
}

Result<void> write_webp(const std::string& path, const std::vector<Frame>& frames) {
    const Error refused{Errc::Io, 0, path + ": cannot be made into an animation"};
    WebPAnimEncoderOptions options;
    WebPConfig config;
    if (frames.empty() || WebPAnimEncoderOptionsInit(&options) == 0 || WebPConfigInit(&config) == 0) return refused;
    config.quality = kQuality;
    config.method = 6;
    options.kmax = 1;  // every frame whole: each differs everywhere
    const auto w = static_cast<int>(frames[0].image.width), h = static_cast<int>(frames[0].image.height);
    const std::unique_ptr<WebPAnimEncoder, decltype(&WebPAnimEncoderDelete)> encoder(WebPAnimEncoderNew(w, h, &options),
                                                                                     &WebPAnimEncoderDelete);
    if (!encoder) return refused;
    int at = 0;
    for (const Frame& frame : frames) {
        WebPPicture picture;
        if (WebPPictureInit(&picture) == 0) return refused;
        picture.use_argb = 1;
        picture.width = w;
        picture.height = h;
        const bool added = WebPPictureImportRGB(&picture, frame.image.rgb.data(), 3 * w) != 0 &&
                           WebPAnimEncoderAdd(encoder.get(), &picture, at, &config) != 0;
        WebPPictureFree(&picture);
        if (!added) return refused;
        at += static_cast<int>(frame.milliseconds);
    }
    WebPData data;
    WebPDataInit(&data);
    const bool made = WebPAnimEncoderAdd(encoder.get(), nullptr, at, nullptr) != 0 &&
                      WebPAnimEncoderAssemble(encoder.get(), &data) != 0;
    const Result<void> written =
        made ? write_file(path, std::as_bytes(std::span(data.bytes, data.size))) : Result<void>(refused);
    WebPDataClear(&data);
    return written;
}

}  // namespace mvw
