#include "codec/encoder.h"

#include "codec/enc_remeshed.h"
#include "codec/measure/surface_error.h"

namespace mvw {

Result<Encoded> encode(Mesh mesh, const EncodeOptions& options) {
    Encoded out;
    mesh = clean(std::move(mesh), out.cleaning);
    if (!measurable(mesh)) return Error{Errc::InvalidArgument, 0, "no face of positive area is left to encode"};
    out.input_vertices = mesh.positions.size();
    out.input_faces = mesh.faces.size();
    RemeshOptions remeshing;
    remeshing.base_faces = options.base_faces;
    remeshing.levels = options.levels;
    remeshing.target_error = options.target_error;
    remeshing.threads = options.threads;
    remeshing.progress = options.progress;
    const Result<void> coded = encode_remeshed(mesh, remesh(mesh, remeshing), options, out);
    if (!coded.ok()) return coded.error();
    return out;
}

}  // namespace mvw
