// A model refining, as an animated picture.
#pragma once
#include <string>
#include <vector>

#include "client/viewer/image.h"
#include "client/viewer/picture.h"
#include "codec/bytes.h"

namespace mvw {

struct Frame {
    Image image;
    unsigned milliseconds = 100;
};

/// Draws a .mvw file from its first bytes on: about `count` prefixes, spaced evenly in the logarithm of their bytes,
/// each with its bytes and error below, at the level that viewers draw; the last is all of it, and stays for a while.
/// Every picture is taken from one place, which `options` choose for the whole model. Errors are the decoder's and
/// draw_picture()'s. count >= 2 (assert).
Result<std::vector<Frame>> draw_refinement(ByteSpan file, unsigned count, bool z_up, PictureOptions options);

/// An animated WebP that repeats for ever. All frames are of one size. Io names the file.
Result<void> write_webp(const std::string& path, const std::vector<Frame>& frames);

}  // namespace mvw
