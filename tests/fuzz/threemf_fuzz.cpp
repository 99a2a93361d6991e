// The XML of a 3MF package without its archive, whose checksums would keep most inputs out (import_fuzz has these): any
// bytes give a model or an error, the same whether they come at once or in pieces of the first byte's length.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "codec/mesh/io/threemf_model.h"

namespace {

mvw::ThreemfPieces pieces_of(const mvw::Bytes& bytes, std::size_t length) {
    return [&bytes, length](const auto& take) -> mvw::Result<void> {
        for (std::size_t at = 0; at < bytes.size(); at += length)
            if (auto done = take(mvw::ByteSpan(bytes).subspan(at, std::min(length, bytes.size() - at))); !done)
                return done;
        return {};
    };
}

std::size_t triangles_of(const mvw::ThreemfModel& model) {
    std::size_t count = 0;
    for (const auto& [id, object] : model.objects) {
        if (object.faces.size() != object.colors.size()) std::abort();
        for (const mvw::Face& face : object.colors)
            for (const std::uint32_t color : face)
                if (color != mvw::ThreemfModel::kNoColor && color >= model.colors.size()) std::abort();
        count += object.faces.size();
    }
    return count;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    const mvw::Bytes bytes(begin + 1, begin + size);
    const auto whole = mvw::read_threemf_model(pieces_of(bytes, bytes.size() + 1));
    const auto cut = mvw::read_threemf_model(pieces_of(bytes, std::size_t{data[0]} + 1));
    if (whole.ok() != cut.ok()) std::abort();
    if (whole && triangles_of(*whole) != triangles_of(*cut)) std::abort();
    (void)mvw::model_of_relationships(pieces_of(bytes, std::size_t{data[0]} + 1)).ok();
    return 0;
}
