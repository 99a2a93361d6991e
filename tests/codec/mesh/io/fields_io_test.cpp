// Normals and scalars of vertices in mesh files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/io/text.h"
#include "codec/mesh/normals.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Mesh sphere_with_fields() {
    Mesh mesh = icosphere(2);
    mesh.fields = {{FieldKind::Normals, "", {}}, {FieldKind::Scalar, "quality", {}}, {FieldKind::Scalar, "time", {}}};
    for (const Vec3& p : mesh.positions) {
        const Vec3 n = normalized(p + Vec3{0.2, 0, 0});
        for (std::size_t k = 0; k < 3; ++k) mesh.fields[0].values.push_back(n[k]);
        mesh.fields[1].values.push_back(0.25 * std::floor(8 * p.x));
        mesh.fields[2].values.push_back(1.6e9 + p.y);  // float32 would keep nothing of it
    }
    return mesh;
}

Result<Mesh> read(const std::string& text, MeshFormat format, CleanReport& report) {
    return read_mesh_from_memory(as_bytes(text), format, report);
}

const VertexField* find(const Mesh& mesh, FieldKind kind, const std::string& name) {
    for (const VertexField& field : mesh.fields)
        if (field.kind == kind && field.name == name) return &field;
    return nullptr;
}

void expect_near(const VertexField* field, const VertexField& expected, double tolerance) {
    ASSERT_NE(field, nullptr);
    ASSERT_EQ(field->values.size(), expected.values.size());
    for (std::size_t k = 0; k < expected.values.size(); ++k)
        ASSERT_NEAR(field->values[k], expected.values[k], tolerance) << k;
}

TEST(MeshFields, ReadBackFromEveryFormatThatHoldsThem) {
    const Mesh mesh = sphere_with_fields();
    for (const MeshFormat format : {MeshFormat::Ply, MeshFormat::Obj, MeshFormat::Glb}) {
        SCOPED_TRACE(static_cast<int>(format));
        CleanReport report;
        const Mesh back = read_mesh_from_memory(write_mesh_to_memory(mesh, format).value(), format, report).value();
        expect_near(find(back, FieldKind::Normals, ""), mesh.fields[0], 2e-5);
        if (format == MeshFormat::Obj) continue;
        expect_near(find(back, FieldKind::Scalar, "quality"), mesh.fields[1], 0);
        if (format == MeshFormat::Ply) expect_near(find(back, FieldKind::Scalar, "time"), mesh.fields[2], 1e-6);
    }
}

TEST(MeshFields, WhatAFormatCannotHoldIsNamed) {
    Mesh mesh = sphere_with_fields();
    mesh.colors.resize(mesh.positions.size());
    EXPECT_THAT(left_out_by(MeshFormat::Ply, mesh), IsEmpty());
    EXPECT_THAT(left_out_by(MeshFormat::Glb, mesh), IsEmpty());
    EXPECT_THAT(left_out_by(MeshFormat::Obj, mesh), ElementsAre("quality", "time"));
    EXPECT_THAT(left_out_by(MeshFormat::Off, mesh), ElementsAre("normal", "quality", "time"));
    EXPECT_THAT(left_out_by(MeshFormat::Stl, mesh), ElementsAre("color", "normal", "quality", "time"));
}

TEST(MeshFields, AScalarNamedLikeACoordinateDoesNotBecomeOne) {
    Mesh mesh = icosphere(0);
    for (const char* name : {"x", "x_", "u", "v", "texture_u"})
        mesh.fields.push_back({FieldKind::Scalar, name, std::vector<double>(mesh.positions.size(), 7)});
    CleanReport report;
    const Mesh back =
        read_mesh_from_memory(write_mesh_to_memory(mesh, MeshFormat::Ply).value(), MeshFormat::Ply, report).value();
    EXPECT_NEAR(back.positions[3].x, mesh.positions[3].x, 1e-6);
    for (const char* name : {"x_", "x__", "u_", "v_", "_texture_u"})
        EXPECT_NE(find(back, FieldKind::Scalar, name), nullptr) << name;
    mesh.fields.erase(mesh.fields.begin(), mesh.fields.begin() + 2);
    mesh.fields[2].name = "w";  // u, v, w: a velocity
    const Mesh velocity =
        read_mesh_from_memory(write_mesh_to_memory(mesh, MeshFormat::Ply).value(), MeshFormat::Ply, report).value();
    for (const char* name : {"u", "v", "w"}) EXPECT_NE(find(velocity, FieldKind::Scalar, name), nullptr) << name;
}

TEST(MeshFields, PlyPropertiesOfAnyTypeAreScalarsAndTheRestIsNamed) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar label\nproperty float u\nproperty double depth\nproperty float v\nproperty list uchar int "
        "ring\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 3 .5 1e-3 .5 1 9\n1 0 0 4 .5 nan .5 0\n0 1 0 5 .5 3e-3 .5 2 1 1\n3 0 1 2\n";
    CleanReport report;
    const Mesh mesh = read(text, MeshFormat::Ply, report).value();
    ASSERT_EQ(mesh.fields.size(), 2u);
    EXPECT_THAT(mesh.fields[0].values, ElementsAre(3, 4, 5));
    EXPECT_EQ(mesh.fields[1].name, "depth");
    EXPECT_NEAR(mesh.fields[1].values[1], 2e-3, 1e-12) << "what is no number is the mean of those that are";
    EXPECT_EQ(report.replaced_values, 1u);
    EXPECT_THAT(report.dropped_fields, ElementsAre("u", "v", "ring"));
}

TEST(MeshFields, NormalsOfObjCornersBecomeTheirVertexMean) {
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 2\nvn 0 1 0\nf 1//1 2//1 3//1\nf 2//2 4//-2 3//2\nf 1 2 4\n";
    CleanReport report;
    const Mesh mesh = read(text, MeshFormat::Obj, report).value();
    const VertexField* normals = find(mesh, FieldKind::Normals, "");
    ASSERT_NE(normals, nullptr);
    const auto expect = [&](std::size_t v, const Vec3& n) {
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(normals->values[3 * v + k], n[k], 1e-12) << v;
    };
    expect(0, {0, 0, 1});
    expect(1, normalized(Vec3{0, 1, 1}));
    expect(3, {0, 0, 1});
}

TEST(MeshFields, WeldedVerticesTakeTheMean) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}, {3, 4, 5}};
    mesh.colors = {{0, 0, 0, 255}, {10, 0, 0, 255}, {0, 0, 0, 255}, {20, 0, 0, 255}, {0, 0, 0, 255}, {0, 0, 0, 255}};
    mesh.fields = {{FieldKind::Scalar, "a", {0, 1, 2, 3, 4, 6}},
                   {FieldKind::Normals, "", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 1}}};
    CleanReport report;
    const Mesh joined = clean(mesh, report);
    ASSERT_TRUE(is_clean_manifold(joined));
    EXPECT_THAT(joined.fields[0].values, ElementsAre(0, 2, 4, 4));
    EXPECT_EQ(joined.colors[1].r, 15);
    EXPECT_NEAR(joined.fields[1].values[4], std::sqrt(0.5), 1e-12);
}

TEST(MeshFields, TheBunnysConfidenceAndTheTrucksNormalsAreRead) {
    MVW_SKIP_WITHOUT_MODELS();
    CleanReport report;
    const Mesh bunny = read_model("bun_zipper.ply", report).value();
    const VertexField* confidence = find(bunny, FieldKind::Scalar, "confidence");
    ASSERT_TRUE(confidence != nullptr && find(bunny, FieldKind::Scalar, "intensity") != nullptr);
    EXPECT_NEAR(confidence->values[0], 0.850855, 1e-9);
    // Normals of a model with nodes that turn and mirror agree with its surface.
    const Mesh truck = read_model("milktruck.glb", report).value();
    const VertexField* normals = find(truck, FieldKind::Normals, "");
    ASSERT_NE(normals, nullptr);
    const std::vector<Vec3> computed = vertex_normals(truck.positions, truck.faces);
    std::size_t agree = 0;
    for (std::size_t v = 0; v < computed.size(); ++v)
        agree += dot(computed[v],
                     Vec3{normals->values[3 * v], normals->values[3 * v + 1], normals->values[3 * v + 2]}) > 0.9;
    EXPECT_GT(static_cast<double>(agree), 0.95 * static_cast<double>(computed.size()));
}

}  // namespace
}  // namespace mvw
