// Writes the golden files of the present format: after a change of the format, and never otherwise.
//
//   mvw_write_golden FOLDER
#include <fmt/core.h>

#include <cstdio>
#include <span>

#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tests/support/encoded_models.h"
#include "tests/support/golden_models.h"

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const std::string folder = std::string(argv[1]) + "/";
    for (const mvw::GoldenModel& model : mvw::golden_models()) {
        const bool whole = model.parts.empty();
        const mvw::Bytes file = whole ? mvw::encode(model.mesh, model.options).value().file
                                      : mvw::encode_parts(model.parts, model.options).file;
        mvw::Decoder decoder;
        const bool fed = decoder.feed(file).ok();
        // Before the mesh, which turns attributes into what they are of a vertex.
        const std::string digest = fmt::format("{:016x}\n", decoder.coefficient_digest());
        const mvw::Result<mvw::Mesh> mesh = decoder.mesh();
        if (!fed || !mesh.ok() || !mvw::write_file(folder + mvw::golden_file(model.name), file).ok() ||
            !mvw::write_mesh(folder + mvw::golden_mesh(model.name), *mesh).ok() ||
            !mvw::write_file(folder + mvw::golden_digest(model.name), std::as_bytes(std::span(digest))).ok()) {
            fmt::print(stderr, "mvw_write_golden: {} failed\n", model.name);
            return 1;
        }
    }
    return 0;
}
