#include "codec/remesh/recognize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// The same mesh with vertices, faces and the first corner of each face in random order.
Mesh shuffled(const Mesh& mesh, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint32_t> to(mesh.positions.size());
    std::iota(to.begin(), to.end(), 0u);
    std::shuffle(to.begin(), to.end(), random);
    Mesh out = mesh;
    for (std::size_t v = 0; v < to.size(); ++v) out.positions[to[v]] = mesh.positions[v];
    std::shuffle(out.faces.begin(), out.faces.end(), random);
    for (Face& f : out.faces) {
        for (std::uint32_t& v : f) v = to[v];
        std::rotate(f.begin(), f.begin() + random() % 3, f.end());
    }
    return out;
}

/// Faces whatever their order and first corner.
std::multiset<Face> face_set(const std::vector<Face>& faces) {
    std::multiset<Face> out;
    for (Face f : faces) {
        std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
        out.insert(f);
    }
    return out;
}

void expect_recognized(const Mesh& mesh, std::uint32_t base_faces, unsigned levels) {
    const Recognition recognition = recognize(mesh, 1);
    ASSERT_EQ(recognition.meshes.size(), 1u);
    const Recognized* found = recognition.meshes.data();
    EXPECT_EQ(found->levels, levels);
    EXPECT_EQ(found->base.face_count(), base_faces);
    ASSERT_EQ(found->vertices.size(), mesh.positions.size());
    EXPECT_EQ(std::set<std::uint32_t>(found->vertices.begin(), found->vertices.end()).size(), mesh.positions.size());
    std::vector<Face> faces = triangles_at_level(found->base, found->levels);
    for (Face& f : faces)
        for (std::uint32_t& v : f) v = found->vertices[v];
    EXPECT_EQ(face_set(faces), face_set(mesh.faces));
}

TEST(Recognize, FindsTheBaseWhateverTheOrder) {
    for (unsigned seed = 1; seed < 6; ++seed) {
        expect_recognized(shuffled(icosphere(4), seed), 20, 4);
        expect_recognized(shuffled(plain(bumpy_ball(5)), seed), 8, 5);
    }
}

TEST(Recognize, TakesTheMostLevelsOfARegularSurface) {
    expect_recognized(shuffled(grid_mesh(16), 1), 2, 4);
    expect_recognized(shuffled(torus(24, 16), 1), 48, 2);  // 12 faces would join two vertices by two edges
}

TEST(Recognize, RefusesWhatWasNotQuadrisected) {
    EXPECT_TRUE(recognize(tetrahedron_mesh(), 1).meshes.empty());
    EXPECT_TRUE(recognize(grid_mesh(15), 1).meshes.empty());
    Mesh holed = icosphere(3);
    for (const std::ptrdiff_t f : {900, 600, 300, 0}) holed.faces.erase(holed.faces.begin() + f);
    EXPECT_TRUE(recognize(holed, 1).meshes.empty());
    std::mt19937 random(2);
    for (int k = 0; k < 20; ++k) {  // one edge turned
        Mesh mesh = icosphere(2);
        const std::uint32_t f = random() % mesh.faces.size();
        const std::uint32_t a = mesh.faces[f][0], b = mesh.faces[f][1], c = mesh.faces[f][2];
        for (Face& g : mesh.faces) {
            for (std::size_t s = 0; s < 3; ++s) {
                if (g[s] != b || g[(s + 1) % 3] != a) continue;
                const std::uint32_t d = g[(s + 2) % 3];
                mesh.faces[f] = {c, a, d};
                g = {d, b, c};
                s = 3;
            }
        }
        EXPECT_TRUE(recognize(mesh, 1).meshes.empty());
    }
}

struct SemiRegularModel {
    const char* file;
    std::uint32_t base_faces;
    unsigned levels;
};

TEST(Recognize, FindsTheLevelsOfRealModels) {
    constexpr SemiRegularModel kModels[] = {{"sr_bunny_oct7.ply", 8, 7},
                                            {"sr_canyon_513.ply.zst", 2, 9},
                                            {"sr_boat.obj", 2026, 2},
                                            {"sr_club.ply", 299, 3},
                                            {"sr_stell.ply", 60, 4}};
    MVW_SKIP_WITHOUT_MODELS();
    for (const SemiRegularModel& model : kModels) {
        SCOPED_TRACE(model.file);
        expect_recognized(shuffled(clean_model(model.file), 4), model.base_faces, model.levels);
    }
}

TEST(Recognize, TakesEachComponentByItself) {
    const Mesh two = join(moved(icosphere(3), {3, 0, 0}), plain(bumpy_ball(3)));
    const Mesh mesh =
        shuffled(join(join(two, moved(tetrahedron_mesh(), {0, 9, 0})), moved(icosphere(1), {9, 0, 0})), 8);
    const Recognition found = recognize(mesh, 2);
    ASSERT_EQ(found.meshes.size(), 1u);
    EXPECT_EQ(found.meshes[0].levels, 3u);
    EXPECT_EQ(found.meshes[0].base.face_count(), 28u);
    EXPECT_EQ(std::count(found.mesh_of_component.begin(), found.mesh_of_component.end(), kNone), 2);
}

}  // namespace
}  // namespace mvw
