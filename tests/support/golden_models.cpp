#include "tests/support/golden_models.h"

#include "tests/support/semi_regular_models.h"

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

}  // namespace

std::vector<GoldenModel> golden_models() {
    std::vector<GoldenModel> models{mixed(), colored()};
    models.push_back({"fast", {colored().parts[0], bumpy_ball(3)}, {}});
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
