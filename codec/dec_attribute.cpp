#include "codec/dec_attribute.h"

#include <algorithm>
#include <cmath>

#include "codec/color.h"
#include "codec/mesh/normals.h"

namespace mvw {

namespace {

Error malformed(const char* what) {
    return {Errc::Malformed, 0, what};
}

/// A name, 1 to kMaxFieldName characters from '!' to '~', that none of the attributes before has.
bool is_good_name(const std::string& name, const std::vector<AttributeParams>& before) {
    return !name.empty() && name.size() <= kMaxFieldName &&
           std::all_of(name.begin(), name.end(), [](char c) { return c >= '!' && c <= '~'; }) &&
           std::none_of(before.begin(), before.end(), [&](const AttributeParams& a) { return a.name == name; });
}

}  // namespace

Result<std::vector<AttributeParams>> read_attributes(ByteSpan payload, const PartInfo& info) {
    ByteReader in(payload);
    in.u8();  // error code
    std::vector<AttributeParams> out;
    const unsigned count = in.u8();
    unsigned fields = 0;
    for (unsigned k = 0; k < count && in.ok(); ++k) {
        AttributeParams a;
        const unsigned kind = in.u8();
        if (kind >= kAttributeKinds) return Error{Errc::Unsupported, 0, "an attribute is of an unknown kind"};
        a.kind = AttributeKind{static_cast<std::uint8_t>(kind)};
        const bool color = a.kind <= AttributeKind::ColorAlpha, scalar = a.kind == AttributeKind::Scalar;
        if (!color)
            a.channel = Channel{static_cast<std::uint8_t>(static_cast<unsigned>(Channel::FirstField) + fields++)};
        for (unsigned level = 0; level <= info.levels; ++level) a.steps.push_back(in.u8());
        if (scalar) {
            a.middle = in.f64();
            a.range = in.f64();
            a.mean = in.f32();
            const ByteSpan name = in.bytes(in.u8());
            a.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
            const bool finite = std::isfinite(a.middle) && a.range >= 0 && std::isfinite(std::abs(a.middle) + a.range);
            if (in.ok() && (!finite || !(std::abs(a.mean) <= 0.5f) || !is_good_name(a.name, out)))
                return malformed("a field's range or name is out of range");
        }
        const bool twice = std::any_of(out.begin(), out.end(), [&](const AttributeParams& b) {
            return !scalar && a.is_color() == b.is_color() && b.kind != AttributeKind::Scalar;
        });
        if (in.ok() && (twice || fields > kMaxFields)) return malformed("there are too many attributes");
        out.push_back(std::move(a));
    }
    if (!in.ok() || out.empty()) return malformed("the attributes are cut");
    return out;
}

namespace {

/// The mesh's field of this kind and name, a new one where it has none.
std::vector<double>& field_of(Mesh& mesh, FieldKind kind, const std::string& name) {
    for (VertexField& field : mesh.fields)
        if (field.kind == kind && field.name == name) return field.values;
    return mesh.fields.emplace_back(VertexField{kind, name, {}}).values;
}

/// Those of the surface, turned by what was coded.
void append_normals(std::span<const Vec3f> values, std::size_t first_vertex, std::size_t first_face, const Mesh& mesh,
                    std::vector<double>& out) {
    // From the part alone, about as large as 1, so that products neither vanish nor overflow whatever the model's size.
    const std::span<const Vec3> positions = std::span(mesh.positions).subspan(first_vertex);
    double extent = 0;
    for (const Vec3& p : positions)
        for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, std::abs(p[k] - positions[0][k]));
    std::vector<Vec3> around;
    around.reserve(positions.size());
    for (const Vec3& p : positions) around.push_back(extent > 0 ? (p - positions[0]) / extent : Vec3{});
    std::vector<Face> faces(mesh.faces.begin() + static_cast<std::ptrdiff_t>(first_face), mesh.faces.end());
    for (Face& f : faces)
        for (std::uint32_t& v : f) v -= static_cast<std::uint32_t>(first_vertex);
    const std::vector<Vec3> normals = vertex_normals(around, faces);
    for (std::size_t v = 0; v < values.size(); ++v) {
        const Vec3& n = normals[v];
        const Vec3 turned = normalized(n + to_double(values[v]));
        for (std::size_t k = 0; k < 3; ++k) out.push_back(turned[k]);
    }
}

}  // namespace

std::vector<std::uint8_t> attribute_creases(const BaseMesh& base, std::span<const std::uint32_t> materials) {
    std::vector<std::uint8_t> creases;
    if (materials.empty()) return creases;
    for (const BaseEdge& e : base.edges())
        creases.push_back(e.face[1] != kNone && materials[e.face[0]] != materials[e.face[1]] ? 1 : 0);
    return creases;
}

void AttributeDecoder::ensure(std::size_t vertices, std::size_t base_vertices) {
    const AttributeParams& p = params_;
    for (unsigned k = 0; 3 * k < p.components(); ++k) {
        std::vector<Vec3f>& c = coefficients_[k];
        if (c.empty()) c.assign(base_vertices, {p.origin(3 * k), p.origin(3 * k + 1), p.origin(3 * k + 2)});
        if (c.size() < vertices) c.resize(vertices);
    }
}

void AttributeDecoder::store(std::span<const std::uint32_t> indices, unsigned level, std::span<const float> values) {
    const unsigned components = params_.components();
    const float step = step_from_code(params_.steps[level]);
    for (std::size_t i = 0; i < indices.size(); ++i)
        for (unsigned c = 0; c < components; ++c)
            coefficients_[c / 3][indices[i]][c % 3] =
                values[components * i + c] * step + (level == 0 ? params_.origin(c) : 0.0f);
}

void AttributeDecoder::append_colors(std::span<const Vec3f> values, std::span<const Vec3f> alphas, Mesh& out) const {
    for (std::size_t v = 0; v < values.size(); ++v)
        out.colors.push_back(to_rgba(values[v], alphas.empty() ? 1.0f : alphas[v].x));
}

void AttributeDecoder::append_scalars(std::span<const Vec3f> values, std::vector<double>& out) const {
    for (const Vec3f& v : values)
        out.push_back(params_.middle + params_.range * static_cast<double>(std::max(-0.5f, std::min(0.5f, v.x))));
}

void AttributeDecoder::append(PatchTransform& transform, unsigned level, std::size_t first_vertex,
                              std::size_t first_face, Mesh& out) const {
    std::array<std::vector<Vec3f>, 2> values;
    for (std::size_t k = 0; k < 2; ++k) {
        if (coefficients_[k].empty()) continue;
        values[k].resize(out.positions.size() - first_vertex);
        transform.synthesize(std::span(coefficients_[k]).first(values[k].size()), level, values[k]);
    }
    if (params_.is_color()) {
        out.colors.resize(first_vertex);
        return append_colors(values[0], values[1], out);
    }
    const bool normals = params_.kind == AttributeKind::Normals;
    std::vector<double>& field = field_of(out, normals ? FieldKind::Normals : FieldKind::Scalar, params_.name);
    field.resize(first_vertex * (normals ? 3 : 1));
    if (normals)
        append_normals(values[0], first_vertex, first_face, out, field);
    else
        append_scalars(values[0], field);
}

void pad_vertex_data(Mesh& mesh) {
    if (!mesh.colors.empty()) mesh.colors.resize(mesh.positions.size());
    for (VertexField& field : mesh.fields) field.values.resize(mesh.positions.size() * field.components());
}

}  // namespace mvw
