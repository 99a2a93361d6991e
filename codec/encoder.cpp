#include "codec/encoder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <thread>

#include "codec/enc_remeshed.h"
#include "codec/enc_trials.h"
#include "codec/mesh/material_colors.h"

namespace mvw {

namespace {

EncodeOptions with_threads(EncodeOptions options, unsigned threads) {
    options.threads = threads;
    return options;
}

/// Parts whose vertices are all the input's: semi-regular ones, and small components beside them as they are.
Result<RemeshResult> own_parts(const Mesh& mesh, const EncodeOptions& options) {
    RemeshOptions remeshing = remeshing_of(options);
    remeshing.base_faces = 0;
    RemeshResult remeshed = remesh(mesh, remeshing);
    bool any = false, all = true;
    for (const PartOrigin origin : remeshed.origins) {
        any = any || origin == PartOrigin::Recognized;
        all = all && origin != PartOrigin::Remeshed;
    }
    if (any && all) return remeshed;
    return Error{Errc::InvalidArgument, 0,
                 "the mesh has no subdivision connectivity of two levels or more, which lossless coding needs "
                 "(--keep-original keeps any mesh)"};
}

/// Whether the fields are as VertexField says, each scalar by a name of its own.
bool are_fields_sound(const Mesh& mesh) {
    std::set<std::string> names;
    unsigned normals = 0;
    for (const VertexField& field : mesh.fields) {
        const bool is_scalar = field.kind == FieldKind::Scalar;
        if (field.values.size() != field.components() * mesh.positions.size()) return false;
        if (!std::all_of(field.values.begin(), field.values.end(), [](double x) { return std::isfinite(x); }))
            return false;
        if (!is_scalar && ++normals > 1) return false;
        if (!is_scalar) continue;
        const auto is_good = [](char c) { return c >= '!' && c <= '~'; };
        const bool named = !field.name.empty() && field.name.size() <= kMaxFieldName &&
                           std::all_of(field.name.begin(), field.name.end(), is_good);
        if (!named || !names.insert(field.name).second) return false;
    }
    return true;
}

bool are_in_order(const std::vector<MaterialColor>& colors) {
    return std::ranges::adjacent_find(colors, [](const MaterialColor& a, const MaterialColor& b) {
               return a.label >= b.label;
           }) == colors.end();
}

/// Takes away the fields that are not asked for, or more than a file holds, normals first. Names of the latter.
std::vector<std::string> choose_fields(const EncodeOptions& options, std::vector<VertexField>& fields) {
    std::erase_if(fields, [&](const VertexField& field) {
        return field.kind == FieldKind::Normals ? !options.normals : !options.scalars;
    });
    std::stable_partition(fields.begin(), fields.end(),
                          [](const VertexField& field) { return field.kind == FieldKind::Normals; });
    std::vector<std::string> left_out;
    for (std::size_t k = kMaxFields; k < fields.size(); ++k) left_out.push_back(fields[k].name);
    if (fields.size() > kMaxFields) fields.resize(kMaxFields);
    return left_out;
}

Result<Draft> lossless_draft(EncoderInput& input, const EncodeOptions& options) {
    Result<RemeshResult> parts = own_parts(input.mesh(), options);
    return parts.ok() ? Draft::make(input, std::move(*parts), options) : Result<Draft>(parts.error());
}

}  // namespace

Result<Encoded> encode(Mesh mesh, const EncodeOptions& asked_for) {
    if (!are_fields_sound(mesh))
        return Error{Errc::InvalidArgument, 0,
                     "a field of the vertices has no name of its own, or not a finite value each"};
    if (!are_in_order(mesh.material_colors))
        return Error{Errc::InvalidArgument, 0, "colours of materials are not in the order of their labels"};
    Encoded out;
    out.left_out = choose_fields(asked_for, mesh.fields);
    const std::shared_ptr<const Paintwork> paintwork = mesh.paintwork;
    const std::vector<MaterialColor> material_colors = mesh.material_colors;
    mesh = clean(std::move(mesh), out.cleaning);
    mesh.paintwork = paintwork;
    mesh.material_colors = material_colors;
    if (!paintwork) single_color_to_material(mesh);
    if (!measurable(mesh)) return Error{Errc::InvalidArgument, 0, "no face of positive area is left to encode"};
    out.input_vertices = mesh.positions.size();
    out.input_faces = mesh.faces.size();
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const EncodeOptions options = with_threads(asked_for, asked_for.threads > 0 ? asked_for.threads : cores);
    const Result<std::unique_ptr<EncoderInput>> input = EncoderInput::make(mesh, options.threads);
    if (!input.ok()) return input.error();
    Result<Draft> draft = options.lossless > 0 ? lossless_draft(**input, options) : best_draft(**input, options);
    if (!draft.ok()) return draft.error();
    if (const Result<void> r = draft->finish(options, out); !r.ok()) return r.error();
    return out;
}

}  // namespace mvw
