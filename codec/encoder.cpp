#include "codec/encoder.h"

#include <algorithm>
#include <thread>

#include "codec/enc_remeshed.h"
#include "codec/enc_slide.h"
#include "codec/measure/surface_error.h"

namespace mvw {

namespace {

/// The faces of the input that one part stands for; its vertices are all of the input's.
Mesh input_of(const Mesh& input, const RemeshResult& remeshed, std::uint32_t part) {
    Mesh out{input.positions, {}, input.colors, {}};
    for (std::size_t f = 0; f < input.faces.size(); ++f)
        if (remeshed.part_of_face[f] == part) out.faces.push_back(input.faces[f]);
    return out;
}

void slide_parts(const Mesh& input, const EncodeOptions& options, RemeshResult& remeshed) {
    const unsigned threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    for (std::uint32_t part = 0; part < remeshed.parts.size(); ++part) {
        if (remeshed.parts[part].levels > 0 && remeshed.own_vertices[part] == 0)
            slide(input_of(input, remeshed, part), options.transform, threads, remeshed.parts[part]);
        if (options.progress) options.progress("slide", double(part + 1) / double(remeshed.parts.size()));
    }
}

}  // namespace

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
    RemeshResult remeshed = remesh(mesh, remeshing);
    slide_parts(mesh, options, remeshed);
    const Result<void> coded = encode_remeshed(mesh, std::move(remeshed), options, out);
    if (!coded.ok()) return coded.error();
    return out;
}

}  // namespace mvw
