#include "codec/enc_attributes.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "codec/color.h"
#include "codec/mesh/normals.h"

namespace mvw {

namespace {

constexpr double kFinestColorError = 1.0 / 255;   // RMS that plane 0 leaves of a component
constexpr double kFinestNormalError = 1.0 / 200;  // likewise
constexpr double kSameValue = 1e-12;              // of a value: less is rounding
constexpr double kMove = 2.5;                     // step of the finest vertices over what it leaves, dead zone included
// A colour error of 40 dB counts as a surface error of 70 dB: both begin to be seen there on a screen.
constexpr double kColorWeight = 1e-3;
constexpr double kNormalWeight = 1e-6;  // of the unit vector: 40 dB count as 100 dB
// Fields are looked at on surfaces that are there: 40 dB of a field's range count as 110 dB.
constexpr double kScalarWeight = 1e-7;

/// An attribute on its way into blocks: values of all vertices, the first three components, and the fourth in x.
struct Attribute {
    AttributeParams params;
    double finest_error = 0, weight = 0;
    std::array<std::vector<Vec3f>, 2> values;
};

Attribute colors_of(const std::vector<Rgba8>& colors) {
    Attribute a;
    a.finest_error = kFinestColorError;
    a.weight = kColorWeight;
    const bool opaque = std::all_of(colors.begin(), colors.end(), [](const Rgba8& c) { return c.a == 255; });
    a.params.kind = opaque ? AttributeKind::Color : AttributeKind::ColorAlpha;
    for (const Rgba8& c : colors) a.values[0].push_back(to_ycocg(c));
    if (!opaque)
        for (const Rgba8& c : colors) a.values[1].push_back({static_cast<float>(c.a) / 255, 0, 0});
    return a;
}

/// What normals differ by from those of the part's finest surface. Nothing where a vertex has none.
Attribute normals_of(const VertexField& field, const SemiRegularMesh& mesh) {
    Attribute a;
    a.finest_error = kFinestNormalError;
    a.weight = kNormalWeight;
    a.params.kind = AttributeKind::Normals;
    const std::vector<Vec3> normals = vertex_normals(mesh.positions, triangles_at_level(mesh.base, mesh.levels));
    for (std::size_t v = 0; v < normals.size(); ++v) {
        const Vec3 n{field.values[3 * v], field.values[3 * v + 1], field.values[3 * v + 2]};
        a.values[0].push_back(squared_length(n) > 0 ? to_float(n - normals[v]) : Vec3f{});
    }
    return a;
}

Attribute scalars_of(const VertexField& field, double finest_error) {
    Attribute a;
    a.finest_error = finest_error;
    a.weight = kScalarWeight;
    a.params.kind = AttributeKind::Scalar;
    a.params.name = field.name;
    const auto [least, most] = std::ranges::minmax(field.values);
    a.params.middle = least / 2 + most / 2;
    a.params.range = most - least;
    // What rounding leaves of a constant, as means of it are, is no range.
    if (a.params.range <= kSameValue * std::max(std::abs(least), std::abs(most))) a.params.range = 0;
    double sum = 0;
    for (const double value : field.values) {
        const double x = a.params.range > 0 ? (value - a.params.middle) / a.params.range : 0;
        sum += x;
        a.values[0].push_back({static_cast<float>(x), 0, 0});
    }
    a.params.mean = std::clamp(static_cast<float>(sum / static_cast<double>(field.values.size())), -0.5f, 0.5f);
    return a;
}

std::vector<Attribute> attributes_of(const SemiRegularMesh& mesh, double field_error) {
    std::vector<Attribute> all;
    if (!mesh.colors.empty()) all.push_back(colors_of(mesh.colors));
    auto channel = static_cast<unsigned>(Channel::FirstField);
    for (const VertexField& field : mesh.fields) {
        assert(channel <= static_cast<unsigned>(Channel::LastField));
        all.push_back(field.kind == FieldKind::Normals ? normals_of(field, mesh) : scalars_of(field, field_error));
        all.back().params.channel = static_cast<Channel>(channel++);
    }
    return all;
}

void code_attribute(Attribute& a, const PartPrecision& precision, unsigned threads, CodedPart& part) {
    const SemiRegularMesh& mesh = part.mesh;
    const std::vector<LevelGain> gains = synthesis_gains(kAttributeTransform, mesh.levels);
    for (const LevelGain& gain : gains)
        a.params.steps.push_back(step_to_code(std::min(a.finest_error * kMove / gain.normal, 1.0)));
    PatchTransform transform(mesh.base, mesh.levels, kAttributeTransform, attribute_creases(mesh.base, mesh.materials),
                             threads);
    for (std::vector<Vec3f>& values : a.values) {
        const std::vector<Vec3f> in = values;
        if (!in.empty()) transform.analyze(in, values);
    }
    const std::size_t components = a.params.components();
    const auto vertices = static_cast<double>(mesh.positions.size());
    part.attributes.push_back(a.params);
    code_blocks(part, a.params.channel, precision, [&](const BlockShape& shape, unsigned level) {
        const float step = step_from_code(a.params.steps[level]);
        const double move = double{step} * gains[level].normal;
        ScaledBlock scaled;
        scaled.unit.assign(components, a.weight * move * move / vertices);
        scaled.values.reserve(shape.size() * components);
        for (const std::uint32_t v : shape.indices())
            for (unsigned c = 0; c < components; ++c)
                scaled.values.push_back((a.values[c / 3][v][c % 3] - (level == 0 ? a.params.origin(c) : 0.0f)) / step);
        return scaled;
    });
}

}  // namespace

Bytes write_attributes(const std::vector<AttributeParams>& attributes) {
    ByteWriter out;
    out.u8(0);  // error code
    out.u8(static_cast<std::uint8_t>(attributes.size()));
    for (const AttributeParams& a : attributes) {
        out.u8(static_cast<std::uint8_t>(a.kind));
        for (const std::uint8_t code : a.steps) out.u8(code);
        if (a.kind != AttributeKind::Scalar) continue;
        out.f64(a.middle);
        out.f64(a.range);
        out.f32(a.mean);
        out.u8(static_cast<std::uint8_t>(a.name.size()));
        out.bytes(std::as_bytes(std::span(a.name)));
    }
    return out.take();
}

void code_attributes(const PartPrecision& precision, unsigned threads, CodedPart& part) {
    for (Attribute& a : attributes_of(part.mesh, precision.field_error)) code_attribute(a, precision, threads, part);
}

}  // namespace mvw
