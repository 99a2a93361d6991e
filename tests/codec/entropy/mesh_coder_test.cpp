#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "codec/enc_base.h"
#include "codec/entropy/dec_mesh.h"
#include "codec/entropy/enc_mesh.h"
#include "codec/remesh/remesh.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

struct OnGrid {
    BaseMesh mesh;
    std::vector<GridPoint> grid;
    unsigned bits;
};

OnGrid on_grid(const Mesh& mesh, unsigned bits) {
    const Box box = bounding_box(mesh);
    OnGrid out{BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces).value(), {}, bits};
    for (const Vec3& p : mesh.positions) {
        const Vec3 q = (p - box.center()) * (std::ldexp(1.0, static_cast<int>(bits)) / box.diagonal());
        out.grid.push_back({static_cast<int>(std::lround(q.x)), static_cast<int>(std::lround(q.y)),
                            static_cast<int>(std::lround(q.z))});
    }
    return out;
}

/// On a grid of about so many cells an edge.
OnGrid with_cells(const Mesh& mesh, double cells) {
    double edges = 0;
    for (const Face& f : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) edges += length(mesh.positions[f[k]] - mesh.positions[f[(k + 1) % 3]]);
    const double edge = edges / (3 * static_cast<double>(mesh.faces.size())) / bounding_box(mesh).diagonal();
    return on_grid(mesh, static_cast<unsigned>(std::lround(std::log2(cells / edge))));
}

bool has_boundary(const BaseMesh& mesh) {
    return 2 * mesh.edge_count() != 3 * mesh.face_count();
}

/// Bytes of a mesh that comes back with each face and corner where the encoder says that it comes from.
std::size_t expect_back(const OnGrid& in) {
    const EncodedMesh coded = encode_mesh(in.mesh, in.grid, in.bits);
    EXPECT_FALSE(coded.bytes.empty());
    const Result<GridMesh> back =
        decode_mesh(coded.bytes, in.mesh.vertex_count(), in.mesh.face_count(), has_boundary(in.mesh), in.bits);
    EXPECT_TRUE(back.ok());
    if (!back.ok() || back->faces.size() != in.mesh.face_count()) return 0;
    std::vector<std::uint32_t> sources = coded.origin.face;
    std::sort(sources.begin(), sources.end());
    for (std::uint32_t f = 0; f < sources.size(); ++f) EXPECT_EQ(sources[f], f);
    for (std::uint32_t f = 0; f < back->faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = back->faces[f][k];
            EXPECT_EQ(coded.origin.vertex[v], in.mesh.faces()[coded.origin.face[f]][(k + coded.origin.corner[f]) % 3]);
            EXPECT_EQ(back->grid[v], in.grid[coded.origin.vertex[v]]);
        }
    return coded.bytes.size();
}

/// Without some of its faces; vertices that no face is left at are gone.
Mesh with_holes(const Mesh& mesh, unsigned seed, double share) {
    std::mt19937 random(seed);
    Mesh holed = mesh;
    std::erase_if(holed.faces, [&](const Face&) { return std::uniform_real_distribution<>()(random) < share; });
    CleanReport report;
    return clean(std::move(holed), report);
}

Mesh beside(const Mesh& a, const Mesh& b) {
    Mesh out = a;
    const auto offset = static_cast<std::uint32_t>(a.positions.size());
    out.positions.insert(out.positions.end(), b.positions.begin(), b.positions.end());
    for (const Face& f : b.faces) out.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
    return out;
}

TEST(MeshCoder, SurfacesOfAnyGenusComeBack) {
    for (const unsigned bits : {1u, 4u, 8u, 13u, 24u}) {
        expect_back(on_grid(icosphere(0), bits));
        expect_back(on_grid(icosphere(2), bits));
        expect_back(on_grid(torus(9, 5), bits));
        expect_back(on_grid(unit_cube(), bits));
    }
}

TEST(MeshCoder, BoundariesAndComponentsComeBack) {
    expect_back(on_grid(unit_square(), 6));
    for (unsigned seed = 0; seed < 20; ++seed)
        for (const double share : {0.02, 0.2, 0.5}) {
            expect_back(on_grid(with_holes(torus(17, 9), seed, share), 7));
            expect_back(on_grid(beside(with_holes(icosphere(2), seed, share), moved(torus(5, 4), {3, 0, 0})), 7));
        }
}

TEST(MeshCoder, VerticesInOnePlaceAndTrianglesWithoutAreaComeBack) {
    OnGrid flat = on_grid(icosphere(2), 8);
    for (GridPoint& p : flat.grid) p = {0, 0, 0};
    expect_back(flat);
    for (std::size_t v = 0; v < flat.grid.size(); ++v) flat.grid[v] = {static_cast<int>(v % 7), 0, 0};
    expect_back(flat);
}

TEST(MeshCoder, CornersOfTheGridComeBack) {
    for (const unsigned bits : {3u, 24u}) {
        std::mt19937 random(5);
        OnGrid wild = on_grid(torus(12, 7), bits);
        for (GridPoint& p : wild.grid)
            for (int& x : p) x = (random() & 1u) != 0 ? 1 << bits : -(1 << bits);
        expect_back(wild);
    }
}

TEST(MeshCoder, AVertexWhereTwoSurfacesTouchIsRefused) {
    // Two tetrahedra that share vertex 0.
    const std::vector<Face> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3},
                                  {0, 5, 4}, {0, 4, 6}, {4, 5, 6}, {5, 0, 6}};
    const BaseMesh mesh = BaseMesh::create(7, faces).value();
    EXPECT_TRUE(encode_mesh(mesh, std::vector<GridPoint>(7), 4).bytes.empty());
    EXPECT_TRUE(encode_mesh(BaseMesh::create(5, {{0, 1, 2}}).value(), std::vector<GridPoint>(5), 4).bytes.empty());
}

TEST(MeshCoder, AnyBytesAreAMeshOrRefused) {
    std::mt19937 random(7);
    const OnGrid shape = on_grid(torus(9, 6), 7);
    const Bytes whole = encode_mesh(shape.mesh, shape.grid, 7).bytes;
    unsigned meshes = 0;
    for (int round = 0; round < 3000; ++round) {
        Bytes bytes = whole;
        for (int k = 0; k < 1 + round % 5; ++k) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
        if (round % 3 == 0) bytes.resize(random() % bytes.size());
        const std::uint32_t V = 3 + random() % 80, F = 1 + random() % 160;
        const unsigned bits = 1 + random() % 24;
        const Result<GridMesh> mesh = decode_mesh(bytes, V, F, random() % 2 == 0, bits);
        if (!mesh.ok()) continue;
        ++meshes;
        EXPECT_EQ(mesh->faces.size(), F);
        EXPECT_EQ(mesh->grid.size(), V);
        for (const Face& f : mesh->faces) EXPECT_LT(std::max({f[0], f[1], f[2]}), V);
        for (const GridPoint& p : mesh->grid)
            for (const int x : p) EXPECT_LE(std::abs(x), 1 << bits);
    }
    EXPECT_GT(meshes, 0u);
    EXPECT_FALSE(decode_mesh(whole, 54, 108, false, 25).ok());
}

TEST(MeshCoder, TakesFewerBytesThanDracoOnBasesOfScans) {
    MVW_SKIP_WITHOUT_MODELS();
    // The last one is none that it was trained on, and has thousands of base faces.
    for (const auto& [name, most] :
         {std::pair{"koala.ply", 0.9}, {"bob.obj", 0.9}, {"human.obj", 0.9}, {"dragon_res3.ply", 0.98}}) {
        RemeshOptions options;
        options.base_faces = 500;
        options.levels = 1;
        const RemeshResult result = remesh(clean_model(name), options);
        for (const SemiRegularMesh& part : result.parts) {
            const std::vector<Vec3> coarse(part.positions.begin(), part.positions.begin() + part.base.vertex_count());
            const OnGrid base = with_cells(mesh_of(coarse, part.base.faces()), 8);
            const Bytes by_draco = write_draco(part.base.faces(), base.grid, false, 0);
            const std::size_t bytes = expect_back(base);
            EXPECT_LT(static_cast<double>(bytes), most * static_cast<double>(by_draco.size())) << name;
        }
    }
}

}  // namespace
}  // namespace mvw
