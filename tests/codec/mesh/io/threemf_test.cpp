#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "codec/mesh/io/mesh_io.h"
#include "tests/support/archive.h"
#include "tests/support/program.h"

namespace mvw {
namespace {

using testing::HasSubstr;

const std::string kCore = R"(xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02")";
const std::string kTriangle =
    R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="2" z="0"/></vertices>)"
    R"(<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>)";

std::string model(const std::string& resources, const std::string& items) {
    return R"(<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" )" + kCore + "><resources>" + resources +
           "</resources><build>" + items + "</build></model>";
}

Result<Mesh> read(const Bytes& bytes) {
    CleanReport report;
    return read_mesh_from_memory(bytes, MeshFormat::ThreeMf, report);
}

Mesh mesh_of(const std::string& resources, const std::string& items) {
    Result<Mesh> mesh = read(threemf_of(model(resources, items)));
    EXPECT_TRUE(mesh.ok()) << mesh.error().message;
    return std::move(mesh).value();
}

TEST(ThreeMf, WhatIsBuiltStandsWhereItsTransformsSay) {
    const Mesh mesh = mesh_of(
        R"(<object id="1">)" + kTriangle +
            R"(</object><object id="2"><components>)"
            R"(<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 10 0 0"/><component objectid="1"/></components></object>)"
            R"(<object id="3">)" +
            kTriangle + "</object>",
        R"(<item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 5"/><item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>)");
    ASSERT_EQ(mesh.positions.size(), 9u);
    EXPECT_EQ(mesh.positions[0], (Vec3{10, 0, 5}));
    EXPECT_EQ(mesh.positions[1], (Vec3{10, 1, 5}));  // x goes to y: rows are the images of the axes
    EXPECT_EQ(mesh.positions[2], (Vec3{8, 0, 5}));
    EXPECT_EQ(mesh.positions[5], (Vec3{0, 2, 5}));
    EXPECT_EQ(mesh.positions[7], (Vec3{-1, 0, 0}));
    EXPECT_EQ(mesh.faces, (std::vector<Face>{{0, 1, 2}, {3, 4, 5}, {8, 7, 6}}));  // a mirrored face is turned
}

TEST(ThreeMf, PackagesOfOtherWritersAreRead) {
    CleanReport report;
    const Result<Mesh> mesh = read_mesh(test_data_folder() + "/package.3mf", report);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->positions.size(), 8u);
    EXPECT_EQ(mesh->faces.size(), 8u);
    EXPECT_EQ(mesh->positions[5], (Vec3{-5, 10, 0}));
    EXPECT_EQ(mesh->materials, (std::vector<std::uint32_t>{0, 0, 1, 2, 0, 0, 1, 2}));
    ASSERT_EQ(mesh->material_colors.size(), 3u);
    EXPECT_EQ(mesh->material_colors[2].color, (Rgba8{0x20, 0xC0, 0x20, 255}));
}

TEST(ThreeMf, WithoutItemsAllMeshesAreThere) {
    EXPECT_EQ(mesh_of(R"(<object id="a">)" + kTriangle + R"(</object><object id="b">)" + kTriangle + "</object>", "")
                  .faces.size(),
              2u);
}

TEST(ThreeMf, ComponentsMayBeInOtherParts) {
    const std::string outer =
        R"(<model )" + kCore +
        R"( xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06">)"
        R"(<resources><object id="1"><components><component p:path="/3D/Objects/a.model" objectid="7"/></components></object>)"
        R"(</resources><build><item objectid="1"/></build></model>)";
    const Bytes bytes = zip_of({{"3D/3dmodel.model", outer},  // no relationships: at the usual place
                                {"3D/objects/A.model", model(R"(<object id="7">)" + kTriangle + "</object>", "")}});
    const Result<Mesh> mesh = read(bytes);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->positions.size(), 3u);
}

TEST(ThreeMf, ColoursOfTrianglesAreThoseOfMaterials) {
    const std::string two =
        R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="2" z="0"/>)"
        R"(<vertex x="1" y="2" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/>)"
        R"(<triangle v1="1" v2="3" v3="2" pid="5" p1="1"/></triangles></mesh>)";
    const Mesh mesh = mesh_of(
        R"(<basematerials id="5"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#00FF0080"/>)"
        R"(</basematerials><object id="1" pid="5" pindex="0">)" +
            two + "</object>",
        R"(<item objectid="1"/>)");
    EXPECT_EQ(mesh.materials, (std::vector<std::uint32_t>{0, 1}));
    ASSERT_EQ(mesh.material_colors.size(), 2u);
    EXPECT_EQ(mesh.material_colors[0].color, (Rgba8{255, 0, 0, 255}));
    EXPECT_EQ(mesh.material_colors[1].color, (Rgba8{0, 255, 0, 128}));
    EXPECT_TRUE(mesh.colors.empty());
}

TEST(ThreeMf, ColoursOfCornersAreThoseOfVertices) {
    const std::string mixed =
        R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="2" z="0"/></vertices>)"
        R"(<triangles><triangle v1="0" v2="1" v3="2" pid="9" p1="0" p2="1" p3="2"/></triangles></mesh>)";
    const Mesh mesh =
        mesh_of(R"(<m:colorgroup xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02" id="9">)"
                R"(<m:color color="#102030"/><m:color color="#405060FF"/><m:color color="#70809000"/></m:colorgroup>)"
                R"(<object id="1">)" +
                    mixed + "</object>",
                R"(<item objectid="1"/>)");
    EXPECT_EQ(mesh.colors,
              (std::vector<Rgba8>{{0x10, 0x20, 0x30, 255}, {0x40, 0x50, 0x60, 255}, {0x70, 0x80, 0x90, 255}}));
}

TEST(ThreeMf, ElementsOfOtherSpacesAreNoMesh) {
    const std::string slices =
        R"(<s:slicestack xmlns:s="http://schemas.microsoft.com/3dmanufacturing/slice/2015/07" id="4"><s:slice><s:vertices>)"
        R"(<s:vertex x="1" y="2"/></s:vertices></s:slice></s:slicestack>)";
    EXPECT_EQ(mesh_of(slices + R"(<object id="1">)" + kTriangle + slices + "</object>", R"(<item objectid="1"/>)")
                  .positions.size(),
              3u);
}

TEST(ThreeMf, WhatIsWrongIsSaid) {
    const auto reason = [](const Bytes& bytes) {
        const Result<Mesh> mesh = read(bytes);
        return mesh.ok() ? std::string("read") : mesh.error().message;
    };
    const auto of = [&](const std::string& resources, const std::string& items) {
        return reason(threemf_of(model(resources, items)));
    };
    const std::string object = R"(<object id="1">)" + kTriangle + "</object>", item = R"(<item objectid="1"/>)";
    Bytes cut = threemf_of(model(object, item));
    cut.resize(cut.size() / 2);
    EXPECT_THAT(reason(cut), HasSubstr("is no ZIP archive"));
    EXPECT_THAT(reason(zip_of({{"readme", "no model"}})), HasSubstr("3D/3dmodel.model: cannot be read"));
    EXPECT_THAT(reason(threemf_of("<model")), HasSubstr("3D/m.model: line 1: "));
    EXPECT_THAT(reason(threemf_of("<!DOCTYPE model [<!ENTITY a \"aaaa\">]><model/>")),
                HasSubstr("declares a document type"));
    EXPECT_THAT(of("", ""), HasSubstr("has no faces"));
    EXPECT_THAT(of(object, R"(<item objectid="2"/>)"), HasSubstr("there is no object 2"));
    EXPECT_THAT(of(R"(<object id="1"><components><component xmlns:p="http://schemas.microsoft.com/3dmanufacturing/)"
                   R"(production/2015/06" p:path="/a.model" objectid="1"/></components></object>)",
                   item),
                HasSubstr("a.model: cannot be read"));
    Bytes many_ends = threemf_of(model(object, item));
    for (int k = 0; k < 20; ++k)
        for (const char c : {'P', 'K', '\5', '\6'}) many_ends.push_back(static_cast<std::byte>(c));
    EXPECT_THAT(reason(many_ends), HasSubstr("ends in too many places"));
    EXPECT_THAT(of(object + object, item), HasSubstr("two objects of one id"));
    EXPECT_THAT(of(R"(<object id="1"><mesh><vertices><vertex x="0" y="0"/></vertices></mesh></object>)", item),
                HasSubstr("a vertex needs three coordinates"));
    EXPECT_THAT(of(R"(<object id="1"><mesh><triangles><triangle v1="0" v2="1"/></triangles></mesh></object>)", item),
                HasSubstr("a triangle needs three vertices"));
    EXPECT_THAT(
        of(R"(<object id="1"><mesh><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>)", item),
        HasSubstr("names vertex 0 of 0"));
    EXPECT_THAT(of(object, R"(<item objectid="1" transform="1 0 0"/>)"), HasSubstr("twelve numbers"));
    EXPECT_THAT(of(R"(<object id="1"><components><component objectid="1"/></components></object>)", item),
                HasSubstr("too deep"));
}

TEST(ThreeMf, DamageIsSeen) {
    const Bytes good = threemf_of(model(R"(<object id="1">)" + kTriangle + "</object>", R"(<item objectid="1"/>)"));
    std::size_t seen = 0;
    for (std::size_t at = 0; at < good.size(); ++at) {
        Bytes bad = good;
        bad[at] ^= std::byte{0x55};
        const Result<Mesh> mesh = read(bad);
        EXPECT_EQ(mesh.ok() ? mesh->faces.size() : 1, 1u) << at;  // dates and the like do not matter
        seen += mesh.ok() ? 0 : 1;
    }
    EXPECT_GT(seen, good.size() / 2);
}

TEST(ThreeMf, ModifiersAreNoSurface) {
    const std::string one = R"(<object id="1">)" + kTriangle + "</object>";
    const std::string other = R"(<object id="2" type="other">)" + kTriangle + "</object>";
    const std::string both =
        R"(<object id="3"><components><component objectid="1"/><component objectid="2"/></components></object>)";
    EXPECT_EQ(mesh_of(one + other + both, R"(<item objectid="3"/>)").faces.size(), 1u);
    EXPECT_EQ(mesh_of(one + other, "").faces.size(), 1u);
}

TEST(ThreeMf, ColoursThatAreNotKnownAreNamedOnce) {
    const std::string painted =
        R"(<mesh><vertices><vertex x=" 0" y="0 " z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="2" z="0"/>)"
        R"(</vertices><triangles><triangle v1="0" v2="1" v3="2" pid="9" p1="0" p2="1" p3="2"/></triangles></mesh>)";
    CleanReport report;
    const Result<Mesh> mesh = read_mesh_from_memory(
        threemf_of(model(
            R"(<m:texture2dgroup xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02" id="9"/>)"
            R"(<basematerials id="5"><base displaycolor="red"/></basematerials><object id="1">)" +
                painted + R"(</object><object id="2">)" + painted + "</object>",
            R"(<item objectid="1"/><item objectid="2"/>)")),
        MeshFormat::ThreeMf, report);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_TRUE(mesh->materials.empty());
    ASSERT_EQ(report.missing_textures.size(), 1u);
    EXPECT_THAT(report.missing_textures[0], HasSubstr("3MF"));
}

TEST(ThreeMf, ManyColoursAreThoseOfVertices) {
    std::string colors, vertices = R"(<vertex x="9" y="9" z="9"/>)", triangles;
    const auto attribute = [](const char* name, int value) {
        return std::string(" ") + name + "=\"" + std::to_string(value) + "\"";
    };
    for (int k = 0; k < 300; ++k) {
        colors += R"(<base displaycolor="#00)" + std::to_string(1000 + k) + R"("/>)";
        vertices += "<vertex" + attribute("x", k) + attribute("y", 0) + attribute("z", k % 2) + "/>";
        if (k < 298)
            triangles += "<triangle" + attribute("v1", k + 1) + attribute("v2", k + 2) + attribute("v3", k + 3) +
                         attribute("p1", k) + "/>";
    }
    const Mesh mesh =
        mesh_of(R"(<basematerials id="5">)" + colors + R"(</basematerials><object id="1" pid="5"><mesh><vertices>)" +
                    vertices + "</vertices><triangles>" + triangles + "</triangles></mesh></object>",
                R"(<item objectid="1"/>)");
    EXPECT_TRUE(mesh.material_colors.empty());
    ASSERT_EQ(mesh.colors.size(), 301u);
    EXPECT_EQ(mesh.colors[0], (Rgba8{255, 255, 255, 255}));  // in no triangle
    EXPECT_EQ(mesh.colors[1], (Rgba8{0, 0x10, 0x00, 255}));
}

TEST(ThreeMf, FewBytesUnfoldToNothingLarge) {
    std::string objects = R"(<object id="0">)" + kTriangle + "</object>";
    for (int k = 1; k < 30; ++k) {
        const std::string inner = R"(<component objectid=")" + std::to_string(k - 1) + R"("/>)";
        objects +=
            R"(<object id=")" + std::to_string(k) + R"("><components>)" + inner + inner + "</components></object>";
    }
    const Result<Mesh> bomb = read(threemf_of(model(objects, R"(<item objectid="29"/>)")));
    ASSERT_FALSE(bomb.ok());
    EXPECT_THAT(bomb.error().message, HasSubstr("places its meshes so often"));

    std::string vertices;
    for (int k = 0; k < 300'000; ++k) vertices += R"(<vertex x="0" y="0" z="0"/>)";
    const Result<Mesh> flood =
        read(threemf_of(model(R"(<object id="1"><mesh><vertices>)" + vertices + "</vertices></mesh></object>", "")));
    ASSERT_FALSE(flood.ok());
    EXPECT_THAT(flood.error().message, HasSubstr("too long for its archive"));
}

}  // namespace
}  // namespace mvw
