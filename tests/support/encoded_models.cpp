#include "tests/support/encoded_models.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {

Encoded encode_parts(std::vector<SemiRegularMesh> parts, EncodeOptions options) {
    Mesh whole;
    for (const SemiRegularMesh& part : parts) whole = whole.faces.empty() ? plain(part) : join(whole, plain(part));
    RemeshResult remeshed;
    for (const SemiRegularMesh& part : parts)  // coded as they are
        remeshed.origins.push_back(part.levels > 0 ? PartOrigin::Recognized : PartOrigin::Alone);
    remeshed.parts = std::move(parts);
    Encoded out;
    options.threads = std::max(1u, options.threads);
    const auto input = EncoderInput::make(whole, options.threads).value();
    Draft draft = Draft::make(*input, std::move(remeshed), options).value();
    EXPECT_TRUE(draft.finish(options, out).ok());
    return out;
}

Toc toc_of(const Bytes& file) {
    const FileHeader header = read_header(file).value();
    return read_toc(header, ByteSpan(file).subspan(header.index_offset), file.size()).value();
}

ByteSpan payload_of(const Bytes& file, const ChunkEntry& chunk) {
    return ByteSpan(file).subspan(chunk.offset, chunk.length);
}

namespace {
Encoded encoded_ball(unsigned levels, double error) {
    EncodeOptions options;
    options.target_error = error;
    options.threads = 1;
    return encode_parts({bumpy_ball(levels)}, options);
}
}  // namespace

const Encoded& small_file() {
    static const Encoded file = encoded_ball(3, 5e-4);
    return file;
}

const Encoded& fine_file() {
    static const Encoded file = encoded_ball(5, 2e-6);
    return file;
}

}  // namespace mvw
