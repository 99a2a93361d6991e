#include "tests/support/golden_models.h"

#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {

namespace {

GoldenModel mixed() {
    SemiRegularMesh alone = bumpy_ball(0), far = bumpy_ball(1);
    for (Vec3& p : alone.positions) p += Vec3{3, 0, 0};
    for (Vec3& p : far.positions) p += Vec3{0, 3, 0};
    far.materials = {1, 1, 2, 2, 1, 1, 2, 9};
    far.creases.assign(far.base.edge_count(), 0);
    for (std::size_t e = 0; e < far.creases.size(); e += 3) far.creases[e] = 1;
    GoldenModel model{"mixed", {bumpy_ball(3), far, alone}, {}};
    model.options.tile_count = 2;
    return model;
}

GoldenModel colored() {
    SemiRegularMesh ball = bumpy_ball(2);
    for (std::size_t v = 0; v < ball.positions.size(); ++v)
        ball.colors.push_back({static_cast<std::uint8_t>(3 * v), static_cast<std::uint8_t>(255 - v),
                               static_cast<std::uint8_t>(v * v), static_cast<std::uint8_t>(v % 2 == 0 ? 255 : 100)});
    GoldenModel model{"colors", {ball}, {}};
    model.options.keep_original = 10;
    return model;
}

/// Normals that are not the surface's, and two scalars, in tiles; a part without levels beside.
GoldenModel with_fields() {
    GoldenModel model{"fields", {bumpy_ball(3), bumpy_ball(0)}, {}};
    for (Vec3& p : model.parts[1].positions) p += Vec3{3, 0, 0};
    for (SemiRegularMesh& ball : model.parts) {
        ball.fields = {
            {FieldKind::Normals, "", {}}, {FieldKind::Scalar, "height", {}}, {FieldKind::Scalar, "step", {}}};
        for (const Vec3& p : ball.positions) {
            const Vec3 n = normalized(p + Vec3{p.y, 0, 0.5});
            for (std::size_t k = 0; k < 3; ++k) ball.fields[0].values.push_back(n[k]);
            ball.fields[1].values.push_back(1e6 + p.z);
            ball.fields[2].values.push_back(p.x > 0 ? -7 : 7);
        }
    }
    model.options.tile_count = 2;
    return model;
}

/// Two materials with colours, whose border has vertices of both.
GoldenModel in_two_colors() {
    GoldenModel model{"materials", {}, {}, rough_torus(31, 17, 0.01)};
    for (const Face& f : model.mesh.faces) model.mesh.materials.push_back(model.mesh.positions[f[0]].x < 0 ? 3 : 8);
    model.mesh.material_colors = {{3, {200, 30, 20, 255}}, {8, {10, 40, 220, 128}}};
    model.options.base_faces = 60;
    model.options.levels = 2;
    model.options.threads = 1;
    return model;
}

}  // namespace

std::vector<GoldenModel> golden_models() {
    std::vector<GoldenModel> models{mixed(), colored(), with_fields()};
    models.push_back({"fast", {colored().parts[0], with_fields().parts[0]}, {}});
    for (Vec3& p : models.back().parts[1].positions) p += Vec3{3, 0, 0};
    models.back().options.profile = Profile::Fast;
    models.push_back({"lossless", {bumpy_ball(3)}, {}});
    models.back().options.lossless = 12;
    for (unsigned kind = 0; kind < kTransformCount; ++kind) {
        GoldenModel model{
            std::string(transform_name(TransformKind{static_cast<std::uint8_t>(kind)})), {bumpy_ball(2)}, {}};
        model.options.transform.kind = TransformKind{static_cast<std::uint8_t>(kind)};
        models.push_back(std::move(model));
    }
    for (GoldenModel& model : models) {
        model.options.target_error = 1e-3;
        model.options.threads = 1;
    }
    models.push_back({"closing", {}, {}, rough_torus(41, 23, 0.003)});
    models.back().options.threads = 1;
    models.push_back({"plain", {}, {}, chequered_plate(12)});
    models.push_back({"preview", {}, {}, chequered_plate(10)});
    models.back().options.threads = 1;
    models.push_back(in_two_colors());
    return models;
}

std::string golden_file(const std::string& name) {
    return "golden_" + name + ".mvw";
}
std::string golden_mesh(const std::string& name) {
    return "golden_" + name + ".off";
}
std::string golden_digest(const std::string& name) {
    return "golden_" + name + ".digest";
}

}  // namespace mvw
