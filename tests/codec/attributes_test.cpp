// Scalars and normals of vertices, from a mesh into a file and back.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "codec/dec_attribute.h"
#include "codec/decoder.h"
#include "codec/enc_attributes.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/normals.h"
#include "tests/support/encoded_models.h"
#include "tests/support/models.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A smooth function of the place, from about -2 to 2 in a box of diagonal 1.
double wave(const Vec3& p, double diagonal) {
    return std::sin(9 * p.x / diagonal) + std::cos(7 * p.y / diagonal + 5 * p.z / diagonal);
}

VertexField scalar(const std::string& name, const std::vector<Vec3>& positions, double diagonal, double offset = 0) {
    VertexField field{FieldKind::Scalar, name, {}};
    for (const Vec3& p : positions) field.values.push_back(offset + wave(p, diagonal));
    return field;
}

/// Normals that lean by up to 0.3 from those of the surface.
VertexField leaning_normals(const std::vector<Vec3>& positions, const std::vector<Face>& faces, double diagonal) {
    VertexField field{FieldKind::Normals, "", {}};
    const std::vector<Vec3> normals = vertex_normals(positions, faces);
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Vec3 n = normalized(normals[v] + Vec3{0.3, 0, 0} * (wave(positions[v], diagonal) / 2));
        for (std::size_t k = 0; k < 3; ++k) field.values.push_back(n[k]);
    }
    return field;
}

SemiRegularMesh ball_with_fields(unsigned levels) {
    SemiRegularMesh ball = bumpy_ball(levels);
    ball.fields.push_back(leaning_normals(ball.positions, plain(ball).faces, 2));
    ball.fields.push_back(scalar("temperature", ball.positions, 2, 300));
    return ball;
}

const VertexField* find(const Mesh& mesh, FieldKind kind, const std::string& name) {
    for (const VertexField& field : mesh.fields)
        if (field.kind == kind && field.name == name) return &field;
    return nullptr;
}

/// RMS difference of a scalar from what `truth` says at its vertices.
template <typename Truth>
double rms_error(const Mesh& mesh, const VertexField& field, Truth truth) {
    double sum = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const double e = field.values[v] - truth(mesh.positions[v]);
        sum += e * e;
    }
    return std::sqrt(sum / static_cast<double>(mesh.positions.size()));
}

/// Mean angle in degrees between the mesh's normals and those of the nearest vertices of `truth`.
double mean_angle(const Mesh& mesh, const std::vector<Vec3>& normals, const Mesh& truth, const VertexField& field) {
    const ReferenceSurface surface(truth, 1);
    double sum = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const SurfacePoint hit = surface.closest(mesh.positions[v]);
        Vec3 n;
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < 3; ++k)
                n[k] += hit.barycentric[c] * field.values[3 * truth.faces[hit.face][c] + k];
        sum += std::acos(std::clamp(dot(normalized(n), normals[v]), -1.0, 1.0));
    }
    return sum / static_cast<double>(mesh.positions.size()) * 57.29577951308232;
}

std::vector<Vec3> as_vectors(const VertexField& normals) {
    std::vector<Vec3> out;
    for (std::size_t v = 0; 3 * v < normals.values.size(); ++v)
        out.push_back({normals.values[3 * v], normals.values[3 * v + 1], normals.values[3 * v + 2]});
    return out;
}

TEST(Attributes, FieldsOfAWholeFileAreThoseOfTheMesh) {
    for (const unsigned levels : {0u, 3u})
        for (const Profile profile : {Profile::Small, Profile::Fast}) {
            SCOPED_TRACE(levels);
            EncodeOptions options;
            options.profile = profile;
            const SemiRegularMesh ball = ball_with_fields(levels);
            const Mesh mesh = decode(encode_parts({ball}, options).file).value();
            const VertexField* temperature = find(mesh, FieldKind::Scalar, "temperature");
            ASSERT_NE(temperature, nullptr);
            EXPECT_LT(rms_error(mesh, *temperature, [](const Vec3& p) { return 300 + wave(p, 2); }), 0.02);
            const VertexField* normals = find(mesh, FieldKind::Normals, "");
            ASSERT_NE(normals, nullptr);
            EXPECT_LT(mean_angle(mesh, as_vectors(*normals), plain(ball), ball.fields[0]), 1.0);
            EXPECT_GT(mean_angle(mesh, vertex_normals(mesh.positions, mesh.faces), plain(ball), ball.fields[0]), 4.0)
                << "what is not coded would be wrong";
        }
}

TEST(Attributes, ValuesStayWithinTheRangeThatTheBaseStates) {
    SemiRegularMesh ball = bumpy_ball(3);
    ball.fields.push_back({FieldKind::Scalar, "step", {}});
    for (const Vec3& p : ball.positions) ball.fields[0].values.push_back(p.x > 0 ? 1e6 : 1e6 + 1);
    const Bytes file = encode_parts({ball}).file;
    for (std::size_t n = 100; n < file.size(); n += 29) {
        const Result<Mesh> mesh = decode(ByteSpan(file).first(n));
        if (!mesh.ok() || mesh->fields.empty()) continue;
        for (const double x : mesh->fields[0].values) ASSERT_TRUE(x >= 1e6 && x <= 1e6 + 1) << x;
    }
}

TEST(Attributes, AConstantFieldComesBackExactly) {
    SemiRegularMesh ball = bumpy_ball(2);
    ball.fields.push_back({FieldKind::Scalar, "age", std::vector<double>(ball.positions.size(), 12345.678)});
    const Mesh mesh = decode(encode_parts({ball}).file).value();
    const VertexField* age = find(mesh, FieldKind::Scalar, "age");
    ASSERT_NE(age, nullptr);
    for (const double x : age->values) EXPECT_EQ(x, 12345.678);
}

TEST(Attributes, AConstantFieldOfARemeshCostsNextToNothing) {
    Mesh mesh = torus(45, 23);
    EncodeOptions options;
    options.base_faces = 100;
    options.threads = 1;
    const Encoded without = encode(mesh, options).value();
    mesh.fields.push_back({FieldKind::Scalar, "age", std::vector<double>(mesh.positions.size(), 12345.678)});
    const Encoded with = encode(mesh, options).value();
    EXPECT_LT(with.file.size(), without.file.size() + 60);
    const Mesh back = decode(with.file).value();
    for (const double x : find(back, FieldKind::Scalar, "age")->values) EXPECT_NEAR(x, 12345.678, 1e-6);
}

TEST(Attributes, FieldsThatNoFileCouldNameAreRefused) {
    const Mesh mesh = torus(9, 7);
    const std::vector<double> values(mesh.positions.size(), 1.0);
    for (const std::vector<std::string>& names :
         {std::vector<std::string>{""}, {"a b"}, {"twice", "twice"}, {std::string(64, 'x')}}) {
        Mesh named = mesh;
        for (const std::string& name : names) named.fields.push_back({FieldKind::Scalar, name, values});
        EXPECT_FALSE(encode(named, {}).ok()) << names[0];
    }
    Mesh cut = mesh, wild = mesh;
    cut.fields.push_back({FieldKind::Scalar, "short", {1, 2, 3}});
    wild.fields.push_back({FieldKind::Scalar, "wild", values});
    wild.fields[0].values[3] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(encode(cut, {}).ok());
    EXPECT_FALSE(encode(wild, {}).ok());
}

TEST(Attributes, NormalsThatAreTheSurfacesCostNextToNothing) {
    SemiRegularMesh ball = bumpy_ball(3);
    const Bytes without = encode_parts({ball}).file;
    VertexField& field = ball.fields.emplace_back(VertexField{FieldKind::Normals, "", {}});
    for (const Vec3& n : vertex_normals(ball.positions, plain(ball).faces))
        field.values.insert(field.values.end(), {n.x, n.y, n.z});
    const Bytes with = encode_parts({ball}).file;
    EXPECT_LT(with.size(), without.size() + 60);
    const Mesh mesh = decode(with).value();
    ASSERT_NE(find(mesh, FieldKind::Normals, ""), nullptr);
}

TEST(Attributes, EveryPrefixHasAllValuesOfAFieldOrNone) {
    const Bytes file = encode_parts({ball_with_fields(3)}).file;
    std::size_t with_both = 0;
    double first = 0, last = 0;
    for (std::size_t n = 60; n < file.size(); n += 7) {
        const Result<Mesh> mesh = decode(ByteSpan(file).first(n));
        if (!mesh.ok()) continue;
        for (const VertexField& field : mesh->fields)
            ASSERT_EQ(field.values.size(), field.components() * mesh->positions.size());
        with_both += mesh->fields.size() == 2 ? 1 : 0;
        if (const VertexField* t = find(*mesh, FieldKind::Scalar, "temperature")) {
            last = rms_error(*mesh, *t, [](const Vec3& p) { return 300 + wave(p, 2); });
            if (first == 0) first = last;
        }
    }
    EXPECT_GT(with_both, 20u);
    EXPECT_LT(last, first / 4);
}

TEST(Attributes, PartsWithoutAFieldHaveZerosBesideOthers) {
    SemiRegularMesh plain_ball = bumpy_ball(2);
    for (Vec3& p : plain_ball.positions) p += Vec3{3, 0, 0};
    const std::size_t V = plain_ball.positions.size();
    for (const bool first : {false, true}) {
        std::vector<SemiRegularMesh> parts{ball_with_fields(2)};
        parts.insert(first ? parts.begin() : parts.end(), plain_ball);
        const Mesh mesh = decode(encode_parts(parts).file).value();
        const VertexField* t = find(mesh, FieldKind::Scalar, "temperature");
        ASSERT_NE(t, nullptr);
        ASSERT_EQ(t->values.size(), 2 * V);
        EXPECT_EQ(t->values[first ? 0 : V], 0);
        EXPECT_NEAR(t->values[first ? V : 0], 300, 3);
    }
}

TEST(Attributes, ThreadsDoNotChangeThem) {
    EncodeOptions serial, parallel;
    serial.tile_count = parallel.tile_count = 4;
    serial.threads = 1;
    parallel.threads = 4;
    const Bytes file = encode_parts({ball_with_fields(4)}, serial).file;
    EXPECT_EQ(file, encode_parts({ball_with_fields(4)}, parallel).file);
    const Mesh one = decode(file, 255, {}, 1).value(), four = decode(file, 255, {}, 4).value();
    ASSERT_EQ(one.fields.size(), four.fields.size());
    for (std::size_t k = 0; k < one.fields.size(); ++k) EXPECT_EQ(one.fields[k].values, four.fields[k].values);
}

TEST(Attributes, ChunksInAnyOrderGiveTheSame) {
    const Bytes file = encode_parts({ball_with_fields(3)}).file;
    const Toc toc = toc_of(file);
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_header(file).ok());
    for (auto c = toc.chunks.rbegin(); c != toc.chunks.rend(); ++c)
        ASSERT_TRUE(decoder.feed_chunk(c->id, payload_of(file, *c), c->crc32c).ok());
    const Mesh expected = decode(file).value(), mesh = decoder.mesh().value();
    ASSERT_EQ(mesh.fields.size(), expected.fields.size());
    for (std::size_t k = 0; k < mesh.fields.size(); ++k) EXPECT_EQ(mesh.fields[k].values, expected.fields[k].values);
}

TEST(Attributes, NormalsAreCodedWhereAskedForAndScalarsUnlessRefused) {
    const SemiRegularMesh ball = ball_with_fields(3);
    Mesh input = plain(ball);
    input.fields = ball.fields;
    EncodeOptions options;
    EXPECT_EQ(decode(encode(input, options).value().file)->fields.size(), 1u);
    options.normals = true;
    EXPECT_EQ(decode(encode(input, options).value().file)->fields.size(), 2u);
    options.scalars = options.normals = false;
    EXPECT_TRUE(decode(encode(input, options).value().file)->fields.empty());
}

TEST(Attributes, FieldsBeyondEightAreLeftOutAndNamed) {
    Mesh input = plain(bumpy_ball(2));
    for (int k = 0; k < 10; ++k) input.fields.push_back(scalar("f" + std::to_string(k), input.positions, 2));
    const Encoded e = encode(input, {}).value();
    EXPECT_EQ(e.left_out, (std::vector<std::string>{"f8", "f9"}));
    ASSERT_EQ(e.attributes.size(), 8u);
    for (const AttributeBytes& a : e.attributes) EXPECT_GT(a.bytes, 0u) << a.name;
    EXPECT_EQ(decode(e.file)->fields.size(), 8u);
}

/// What reading a chunk of these attributes says.
Result<std::vector<AttributeParams>> chunk_with(const std::vector<AttributeParams>& attributes) {
    return read_attributes(write_attributes(attributes), {0, 4, 6, 4});
}

AttributeParams scalar_params(const std::string& name, double middle = 0, double range = 1) {
    AttributeParams a;
    a.kind = AttributeKind::Scalar;
    a.steps = {8};
    a.name = name;
    a.middle = middle;
    a.range = range;
    return a;
}

TEST(Attributes, AChunkThatContradictsItselfIsRefused) {
    AttributeParams color, normals;
    color.steps = normals.steps = {8};
    normals.kind = AttributeKind::Normals;
    const auto code = [](const std::vector<AttributeParams>& attributes) {
        return chunk_with(attributes).error().code;
    };
    const auto good = chunk_with({color, normals, scalar_params("a"), scalar_params("b", -1e300, 1e300)});
    ASSERT_TRUE(good.ok());
    EXPECT_EQ(static_cast<unsigned>((*good)[3].channel), 6u);
    const Bytes whole = write_attributes({color, scalar_params("a")});
    for (std::size_t n = 0; n < whole.size(); ++n)
        EXPECT_EQ(read_attributes(ByteSpan(whole).first(n), {0, 4, 6, 4}).error().code, Errc::Malformed) << n;
    EXPECT_EQ(code({color, color}), Errc::Malformed);
    EXPECT_EQ(code({normals, normals}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params("a"), scalar_params("a")}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params("")}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params("two words")}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params(std::string(64, 'x'))}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params("a", 0, -1)}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params("a", std::nan(""), 1)}), Errc::Malformed);
    EXPECT_EQ(code({scalar_params("a", 1.5e308, 1e308)}), Errc::Malformed);
    AttributeParams outside = scalar_params("a");
    outside.mean = 0.75f;
    EXPECT_EQ(code({outside}), Errc::Malformed);
    std::vector<AttributeParams> nine;
    nine.reserve(9);
    for (int k = 0; k < 9; ++k) nine.push_back(scalar_params(std::to_string(k)));
    EXPECT_EQ(code(nine), Errc::Malformed);
    AttributeParams strange = color;
    strange.kind = AttributeKind{9};
    EXPECT_EQ(code({strange}), Errc::Unsupported);
}

/// A real scan with a smooth field and leaning normals, remeshed and back.
TEST(Attributes, AScanKeepsItsFieldAndItsNormals) {
    MVW_SKIP_WITHOUT_MODELS();
    Mesh input = clean_model("spot/spot_triangulated.obj");
    const double diagonal = bounding_box(input).diagonal();
    input.fields = {leaning_normals(input.positions, input.faces, diagonal),
                    scalar("temperature", input.positions, diagonal, 300)};
    EncodeOptions options;
    options.normals = true;
    const Encoded e = encode(input, options).value();
    const Mesh mesh = decode(e.file).value();
    const VertexField *temperature = find(mesh, FieldKind::Scalar, "temperature"),
                      *normals = find(mesh, FieldKind::Normals, "");
    ASSERT_TRUE(temperature != nullptr && normals != nullptr);
    // A five-hundredth of the range, and what the mesh between its vertices leaves of a wave.
    EXPECT_LT(rms_error(mesh, *temperature, [&](const Vec3& p) { return 300 + wave(p, diagonal); }), 0.02);
    const double coded = mean_angle(mesh, as_vectors(*normals), input, input.fields[0]);
    const double computed = mean_angle(mesh, vertex_normals(mesh.positions, mesh.faces), input, input.fields[0]);
    EXPECT_LT(coded, 0.35 * computed) << computed;
}

TEST(Attributes, OnlyMaterialsHaveSharpEdgesOfColour) {
    const BaseMesh base = BaseMesh::create(4, {{0, 1, 2}, {0, 2, 3}}).value();
    EXPECT_TRUE(attribute_creases(base, {}).empty());
    const std::vector<std::uint32_t> same{4, 4}, two{4, 7};
    EXPECT_EQ(attribute_creases(base, same), std::vector<std::uint8_t>(5, 0));
    std::vector<std::uint8_t> expected(5, 0);
    expected[base.edge_of(0, 2)] = 1;
    EXPECT_EQ(attribute_creases(base, two), expected);
}

}  // namespace
}  // namespace mvw
