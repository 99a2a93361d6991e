// Attributes through the program: what is encoded, said, listed and exported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/normals.h"
#include "tests/support/models.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A ball with a scalar and normals, in a file and encoded with these options.
struct EncodedBall {
    ScratchFolder folder;
    std::string mvw = folder / "ball.mvw";
    ProgramRun run;

    explicit EncodedBall(std::vector<std::string> options) {
        Mesh mesh = icosphere(3);
        mesh.fields = {{FieldKind::Normals, "", {}}, {FieldKind::Scalar, "height", {}}};
        for (const Vec3& p : mesh.positions) {
            mesh.fields[0].values.insert(mesh.fields[0].values.end(), {p.x, p.y, p.z});
            mesh.fields[1].values.push_back(p.z);
        }
        EXPECT_TRUE(write_mesh(folder / "ball.ply", mesh).ok());
        options.insert(options.begin(), {"encode", folder / "ball.ply", mvw, "--json"});
        run = run_mvw(options);
        EXPECT_EQ(run.exit_code, 0) << run.errors;
    }
    [[nodiscard]] std::vector<std::string> attributes() const {
        return nlohmann::json::parse(run_mvw({"info", mvw, "--json"}).out)["attributes"];
    }
    [[nodiscard]] Mesh decoded(const std::string& name, ProgramRun& decoding,
                               std::vector<std::string> options = {}) const {
        options.insert(options.begin(), {"decode", mvw, folder / name});
        decoding = run_mvw(options);
        CleanReport report;
        return read_mesh(folder / name, report).value();
    }
};

TEST(AttributeCommands, EncodeCountsThemAndInfoListsThem) {
    const EncodedBall ball({"--normals"});
    const auto json = nlohmann::json::parse(ball.run.out);
    ASSERT_EQ(json["attributes"].size(), 2u);
    EXPECT_EQ(json["attributes"][1]["name"], "height");
    EXPECT_GT(json["attributes"][1]["bytes"], 0);
    EXPECT_THAT(ball.attributes(), ElementsAre("normal", "height"));
    EXPECT_THAT(run_mvw({"info", ball.mvw}).out, HasSubstr("attribute height"));
    EXPECT_EQ(run_mvw({"verify", ball.mvw}).exit_code, 0);
    EXPECT_THAT(EncodedBall({}).attributes(), ElementsAre("height"));
    EXPECT_THAT(EncodedBall({"--no-scalars"}).attributes(), IsEmpty());
}

TEST(AttributeCommands, AFinerFieldErrorTakesMoreBytes) {
    const auto bytes = [](const EncodedBall& ball) {
        return nlohmann::json::parse(ball.run.out)["attributes"][0]["bytes"].get<int>();
    };
    EXPECT_GT(bytes(EncodedBall({"--field-error", "1e-5"})), bytes(EncodedBall({"--field-error", "0.05"})));
}

TEST(AttributeCommands, DecodeExportsThemAndSaysWhatAFormatCannotHold) {
    const EncodedBall ball({"--normals"});
    ProgramRun run;
    EXPECT_EQ(ball.decoded("out.ply", run).fields.size(), 2u);
    EXPECT_EQ(run.errors, "");
    EXPECT_EQ(ball.decoded("out.glb", run).fields.size(), 2u);
    EXPECT_EQ(run.errors, "");
    const Mesh obj = ball.decoded("out.obj", run);
    ASSERT_EQ(obj.fields.size(), 1u);
    EXPECT_EQ(obj.fields[0].kind, FieldKind::Normals);
    EXPECT_THAT(run.errors, HasSubstr("cannot hold attribute height"));
    EXPECT_TRUE(ball.decoded("out.stl", run).fields.empty());
    EXPECT_THAT(run.errors, HasSubstr("cannot hold attribute normal"));
}

TEST(AttributeCommands, DecodeComputesNormalsOnRequest) {
    const EncodedBall ball({"--no-scalars"});
    ProgramRun run;
    EXPECT_TRUE(ball.decoded("out.ply", run).fields.empty());
    const Mesh mesh = ball.decoded("out.ply", run, {"--normals"});
    ASSERT_EQ(mesh.fields.size(), 1u);
    const std::vector<Vec3> expected = vertex_normals(mesh.positions, mesh.faces);
    for (std::size_t v = 0; v < expected.size(); ++v) EXPECT_NEAR(mesh.fields[0].values[3 * v], expected[v].x, 1e-3);
}

TEST(AttributeCommands, ATexturedCowIsColouredAndTheReportSaysSo) {
    MVW_SKIP_WITHOUT_MODELS();
    const ScratchFolder folder;
    const std::string spot = models_folder() + "/spot/spot_triangulated.obj";
    const std::string texture = models_folder() + "/spot/spot_texture.png";
    const ProgramRun run = run_mvw({"encode", spot, folder / "spot.mvw", "--texture", texture});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.out, ContainsRegex("colours of [0-9]+ vertices from images, which are not kept themselves"));
    EXPECT_THAT(run.out, HasSubstr("bytes for attribute color"));
    for (const std::string name : {"spot.ply", "spot.obj", "spot.glb"}) {
        EXPECT_EQ(run_mvw({"decode", folder / "spot.mvw", folder / name}).exit_code, 0);
        CleanReport report;
        const Mesh mesh = read_mesh(folder / name, report).value();
        ASSERT_EQ(mesh.colors.size(), mesh.positions.size()) << name;
        // The tips of the horns are what is highest.
        std::size_t top = 0;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            if (mesh.positions[v].y > mesh.positions[top].y) top = v;
        EXPECT_NEAR(mesh.colors[top].r, 157, 25) << name;
        EXPECT_NEAR(mesh.colors[top].b, 53, 25) << name;
    }
    const ProgramRun wrong =
        run_mvw({"encode", models_folder() + "/koala.ply", folder / "k.mvw", "--texture", texture});
    EXPECT_EQ(wrong.exit_code, 1);
    EXPECT_THAT(wrong.errors, HasSubstr("colours nothing"));
}

}  // namespace
}  // namespace mvw
