// Any bytes give a mesh or an error; any mesh read can be cleaned, and comes out as a manifold that can be written.
// The first byte chooses the format, in the order of MeshFormat.
#include <cstdint>
#include <cstdlib>

#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const auto format = static_cast<mvw::MeshFormat>(data[0] % 7);
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    const mvw::Bytes bytes(begin + 1, begin + size);  // a block of its own, so that reading past it is seen
    mvw::CleanReport report;
    mvw::Result<mvw::Mesh> mesh = mvw::read_mesh_from_memory(bytes, format, report);
    if (!mesh) return 0;
    const mvw::Mesh cleaned = mvw::clean(std::move(mesh).value(), report);
    if (!mvw::is_clean_manifold(cleaned)) std::abort();
    if (!mvw::write_mesh_to_memory(cleaned, mvw::MeshFormat::Ply)) std::abort();
    return 0;
}
