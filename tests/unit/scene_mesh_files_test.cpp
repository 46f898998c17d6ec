// SPDX-License-Identifier: MIT
// The mesh readers on what is well formed: real files, every form of the formats, the same mesh in four of them.
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"
#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;
using glm::vec3;
using test::TemporaryFolder;
namespace fs = std::filesystem;

const fs::path kScenes = fs::path(PLUMB_SOURCE_DIR) / "scenes";

PolygonMesh readMesh(const fs::path& path, const LoadOptions& options = {}) {
    const std::string extension = path.extension().string();
    return extension == ".obj"   ? readObj(path, options)
           : extension == ".ply" ? readPly(path, options)
           : extension == ".stl" ? readStl(path, options)
                                 : readOff(path, options);
}

PolygonMesh readText(const std::string& name, const std::string& text, const LoadOptions& options = {}) {
    const TemporaryFolder folder;
    return readMesh(folder.write(name, text), options);
}

TriangleMesh finish(const PolygonMesh& mesh) {
    std::vector<Material> materials(1);
    return finishMesh(mesh, materials, 0, {});
}

template <class T>
void put(std::string& bytes, T value, bool bigEndian = false) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (bigEndian) std::reverse(raw, raw + sizeof(T));
    bytes.append(raw, sizeof(T));
}

// Triangles as positions, so that meshes whose vertices are numbered otherwise compare equal.
std::vector<std::array<float, 9>> trianglesOf(const TriangleMesh& mesh) {
    std::vector<std::array<float, 9>> out;
    for (const auto& t : mesh.triangles) {
        std::array<float, 9> flat;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) flat[3 * size_t(i) + size_t(j)] = mesh.positions[t.vertex[i]][j];
        out.push_back(flat);
    }
    return out;
}

TEST(SceneMeshFiles, RealOnesHaveTheCountsOfTheirSources) {
    struct Row {
        const char* path;
        size_t faces, triangles, edges;
    };
    // Counted in the files by a few lines of Python (undirected pairs of distinct positions), or by construction.
    const Row rows[] = {{"suzanne/suzanne.obj", 3936, 3936, 5946},
                        {"cornell/cornell_box.obj", 17, 34, 36},
                        {"mug/mug.obj", 24544, 24544, 36816},
                        {"apple/apple.ply", 1704, 1704, 2568},
                        {"procedural/icosphere.ply", 20 * 256, 20 * 256, 30 * 256},
                        {"procedural/menger.off", 1056, 2112, 2112},
                        {"procedural/gear.obj", 98, 2 * 94 + 2 * 96, 288},
                        {"procedural/slivers.stl", 1010, 1010, 2025},
                        {"procedural/torus.obj", 2304, 2304, 3456}};
    for (const Row& row : rows) {
        const TriangleMesh mesh = finish(readMesh(kScenes / row.path));
        EXPECT_EQ(mesh.faceNormal.size(), row.faces) << row.path;
        EXPECT_EQ(mesh.triangles.size(), row.triangles) << row.path;
        EXPECT_EQ(mesh.edges.size(), row.edges) << row.path;
        EXPECT_EQ(mesh.degenerateFaces + mesh.flushedDenormals + mesh.selfCrossingFaces + mesh.repairedNormals, 0u) << row.path;
    }
}

TEST(SceneMeshFiles, TheSameMeshInFourFormatsHasTheSameTrianglesAndNormals) {
    const TriangleMesh obj = finish(readMesh(kScenes / "procedural/torus.obj"));
    for (const char* name : {"procedural/torus.ply", "procedural/torus.stl", "procedural/torus.off"}) {
        const TriangleMesh other = finish(readMesh(kScenes / name));
        EXPECT_EQ(trianglesOf(obj), trianglesOf(other)) << name;
        EXPECT_EQ(obj.positions, other.positions) << name;
        EXPECT_EQ(obj.normals, other.normals) << name;
        EXPECT_EQ(obj.edges, other.edges) << name;
    }
}

TEST(SceneMeshFiles, ObjTakesEveryFormOfACorner) {
    const std::string head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvn 0 0 1\nvn 0 1 0\n";
    for (const char* face : {"f 1 2 3", "f 1/1 2/2 3/1", "f -3 -2 -1", "f -3/-2 2/2 -1/1"}) {
        const PolygonMesh mesh = readText("m.obj", head + face);
        ASSERT_EQ(mesh.corners.size(), 3u) << face;
        for (uint32_t c = 0; c < 3; ++c) {
            EXPECT_EQ(mesh.corners[c].position, c) << face;
            EXPECT_EQ(mesh.corners[c].normal, kNone) << face;
        }
    }
    for (const char* face : {"f 1//1 2//2 3//1", "f 1/1/1 2/2/2 3/1/1", "f -3//-2 -2//-1 -1//-2", "f\t1//1   2//2 3//1 # a comment"}) {
        const PolygonMesh mesh = readText("m.obj", head + face + "\n");
        ASSERT_EQ(mesh.corners.size(), 3u) << face;
        EXPECT_EQ(mesh.corners[0].normal, 0u) << face;
        EXPECT_EQ(mesh.corners[1].normal, 1u) << face;
        EXPECT_EQ(mesh.corners[2].normal, 0u) << face;
    }
}

TEST(SceneMeshFiles, ObjLinesEndAndContinueInEveryWay) {
    const std::string lines[] = {"v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"};
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        std::string text;
        for (const std::string& line : lines) text += line + end;
        EXPECT_EQ(readText("m.obj", text).corners.size(), 3u);
    }
    EXPECT_EQ(readText("m.obj", "v 0 0 0\nv 1 0 \\\n0\nv 0 1 0\nf 1 \\\r\n 2 3").corners.size(), 3u);
    EXPECT_EQ(readText("m.obj", "\n#C:\\\nv 0 0 0 # D:\\\nv 1 0 0\nv 0 1 0\nf 1 2 3").corners.size(), 3u) << "comments do not continue";
    EXPECT_EQ(readText("m.obj", "v 0 0 0\ncurv 0 1 \\\n1 2\nv 1 0 0\nv 0 1 0\nf 1 2 3").ignored.size(), 1u) << "what is skipped does";
}

TEST(SceneMeshFiles, ObjIndicesMayNameWhatComesLater) {
    const PolygonMesh mesh = readText("m.obj", "f 1//1 2//1 3//1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n");
    EXPECT_EQ(mesh.corners.size(), 3u);
}

TEST(SceneMeshFiles, ObjNumbersAreReadInEverySpelling) {
    const PolygonMesh mesh = readText("m.obj", "v +1 -1e0 1.5E+2\nv .5 5. 1e-2\nv 1e-50 -1e-50 -0\nv 1 2 3 0.5\nf 1 2 3\n");
    EXPECT_EQ(mesh.positions[0], dvec3(1, -1, 150));
    EXPECT_EQ(mesh.positions[1], dvec3(0.5, 5, 0.01));
    EXPECT_EQ(mesh.positions[2].x, 1e-50) << "kept until finishMesh counts it";
    EXPECT_EQ(mesh.positions[2].y, -1e-50);
    EXPECT_EQ(mesh.positions[3], dvec3(1, 2, 3));
}

TEST(SceneMeshFiles, ObjColoursAreReadAndNamedAsNotDrawn) {
    const PolygonMesh mesh = readText("m.obj", "v 0 0 0\nv 1 0 0 1 0.5 0.25\nv 0 1 0\nf 1 2 3\n");
    ASSERT_EQ(mesh.colours.size(), 3u);
    EXPECT_EQ(mesh.colours[0], vec3(1));
    EXPECT_EQ(mesh.colours[1], vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(mesh.ignored, std::vector<std::string>{"vertex colours"});
}

TEST(SceneMeshFiles, ObjSmoothingGroupsAreKept) {
    const PolygonMesh mesh =
        readText("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ns 7\nf 1 2 3\ns off\nf 1 2 3\ns 0\nf 1 2 3\ns on\nf 1 2 3\n");
    EXPECT_EQ(mesh.faceSmoothing, (std::vector<uint32_t>{kNone, 7, 0, 0, 1}));
    EXPECT_TRUE(readText("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").faceSmoothing.empty());
}

TEST(SceneMeshFiles, ObjNamesEachKindOfUndrawnThingOnce) {
    const PolygonMesh mesh =
        readText("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 1\nl 2 3\ncurv 0 1 1 2\ncurv 0 1 1 2\nvp 1 2\ng a b\no c\nf 1 2 3\n");
    EXPECT_EQ(mesh.ignored, (std::vector<std::string>{"lines (l)", "points (p)", "OBJ statement curv", "OBJ statement vp"}));
}

const std::string kTriangleOf = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(SceneMeshFiles, MtlGivesPhongMaterials) {
    const TemporaryFolder folder;
    folder.write(
        "a.mtl",
        "# two\r\nnewmtl red one\r\n  Ka 0.1 0.2 0.3\r\n\tKd 1 0 0\r\nKs 0.5\r\nKe 0 0 0.25\r\nNs 96.5\r\nNi 1.45\r\nd 0.75\r\nillum 2\r\n"
        "map_Kd brick.png\r\nmap_Kd -s 1 1 1 wall.png\r\nnewmtl flat\r\nKs 1 1 1\r\nTr 0.25\r\nillum 1\r\nnewmtl unused\r\nKd 7 7 7\r\n");
    const PolygonMesh mesh = readObj(
        folder.write("m.obj", kTriangleOf + "f 1 2 3\nusemtl flat\nmtllib a.mtl\nf 1 2 3\nusemtl red one\nf 1 2 3\nusemtl flat\nf 1 2 3\n"),
        {});
    EXPECT_EQ(mesh.faceMaterial, (std::vector<uint32_t>{kNone, 0, 1, 0})) << "materials in order of use";
    ASSERT_EQ(mesh.materials.size(), 2u);
    EXPECT_EQ(mesh.materials[0].name, "flat");
    EXPECT_EQ(mesh.materials[0].specular, vec3(0)) << "illum 1 has no highlight";
    EXPECT_EQ(mesh.materials[0].opacity, 0.75f);
    const Material& red = mesh.materials[1];
    EXPECT_EQ(red.name, "red one");
    EXPECT_EQ(red.ambient, vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(red.diffuse, vec3(1, 0, 0));
    EXPECT_EQ(red.specular, vec3(0.5f));
    EXPECT_EQ(red.emission, vec3(0, 0, 0.25f));
    EXPECT_EQ(red.shininess, 96.5f);
    EXPECT_EQ(red.refractiveIndex, 1.45f);
    EXPECT_EQ(red.opacity, 0.75f);
    EXPECT_EQ(red.illum, 2);
    EXPECT_EQ(mesh.ignored, (std::vector<std::string>{"MTL statement map_Kd", "transparency (d, Tr)"}));
    EXPECT_TRUE(mesh.warnings.empty()) << "what no face uses warns nobody: " << mesh.warnings[0];
}

TEST(SceneMeshFiles, MtlValuesOutsideTheRangeAreClampedAndCounted) {
    const TemporaryFolder folder;
    folder.write("a.mtl", "newmtl a\nKd 2 0.5 0.5\nNs 1e9\n");
    const PolygonMesh mesh = readObj(folder.write("m.obj", kTriangleOf + "mtllib a.mtl\nusemtl a\nf 1 2 3\n"), {});
    EXPECT_EQ(mesh.materials.at(0).diffuse, vec3(1, 0.5f, 0.5f));
    EXPECT_EQ(mesh.materials.at(0).shininess, 1e6f);
    ASSERT_EQ(mesh.warnings.size(), 1u);
    EXPECT_NE(mesh.warnings[0].find("material 'a'"), std::string::npos) << mesh.warnings[0];
}

TEST(SceneMeshFiles, MaterialLibrariesMayBeSeveralAndHaveBlanksInTheirNames) {
    const TemporaryFolder folder;
    folder.write("a.mtl", "newmtl a\nKd 0.1 0.1 0.1\n");
    folder.write("b.mtl", "newmtl b\nKd 0.2 0.2 0.2\nnewmtl a\nKd 0.9 0.9 0.9\n");
    folder.write("with blanks.mtl", "newmtl c\nKd 0.3 0.3 0.3\n");
    const PolygonMesh mesh = readObj(
        folder.write("m.obj",
                     kTriangleOf + "mtllib a.mtl b.mtl\nmtllib with blanks.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"),
        {});
    ASSERT_EQ(mesh.materials.size(), 3u);
    EXPECT_EQ(mesh.materials[0].diffuse.x, 0.1f) << "the first definition of a name counts";
    EXPECT_EQ(mesh.materials[1].diffuse.x, 0.2f);
    EXPECT_EQ(mesh.materials[2].diffuse.x, 0.3f);
    EXPECT_TRUE(mesh.warnings.empty());
}

TEST(SceneMeshFiles, AMissingMaterialLibraryIsOneCountedWarning) {
    const TemporaryFolder folder;
    const fs::path path =
        folder.write("m.obj", kTriangleOf + "mtllib none.mtl\nmtllib also.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nf 1 2 3\n");
    const PolygonMesh mesh = readObj(path, {});
    ASSERT_EQ(mesh.warnings.size(), 1u);
    EXPECT_EQ(mesh.warnings[0], path.string() + ":4:8: material library 'none.mtl' is missing; 3 faces have the default material");
    EXPECT_EQ(mesh.faceMaterial, (std::vector<uint32_t>{kNone, kNone, kNone}));
    LoadOptions strict;
    strict.strict = true;
    EXPECT_THROW(readObj(path, strict), Error);
}

TEST(SceneMeshFiles, StrictRefusesWhatWouldBeIgnoredWithItsPlace) {
    LoadOptions strict;
    strict.strict = true;
    const TemporaryFolder folder;
    const fs::path path = folder.write("m.obj", kTriangleOf + "f 1 2 3\nl 1 2\n");
    try {
        readObj(path, strict);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input);
        EXPECT_EQ(error.what(), path.string() + ":5:1: lines (l) would be ignored (--strict)");
    }
}

std::string binaryStl(const std::string& header, const std::vector<std::array<float, 12>>& facets) {
    std::string bytes = header;
    bytes.resize(80, ' ');
    put(bytes, uint32_t(facets.size()));
    for (const auto& facet : facets) {
        for (float x : facet) put(bytes, x);
        put(bytes, uint16_t(0));
    }
    return bytes;
}

TEST(SceneMeshFiles, StlIsToldApartBySizeNotByTheWordSolid) {
    const std::string ascii =
        "solid a name with facet in it\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n "
        "endfacet\nendsolid a name\n";
    EXPECT_EQ(readText("m.stl", ascii).positions, (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(readText("m.stl", binaryStl("solid by a bad exporter", {{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}})).positions,
              (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    std::string shouted = ascii;
    for (char& c : shouted) c = char(std::toupper(c));
    EXPECT_EQ(readText("m.stl", shouted + "\n" + ascii).faceMaterial.size(), 2u) << "keywords in capitals, two solids";
}

TEST(SceneMeshFiles, OffTakesItsHeadersAndComments) {
    const char* texts[] = {
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "OFF 3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2",
        "# first\nOFF # here\n# counts\n3 1 3 # of them\n0 0 0 # a\n\n1 0 0\n0 1 0\n3 0 1 2 # f\n# end\n",
        "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
        "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2\n",
        "CNOFF\r\n3 1 0\r\n0 0 0 0 0 1 1.0 0 0\r\n1 0 0 0 0 1 0 1.0 0\r\n0 1 0 0 0 1 0 0 1.0\r\n3 0 1 2 0.5 0.5 0.5\r\n",
        "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n",
    };
    for (const char* text : texts) {
        const PolygonMesh mesh = readText("m.off", text);
        EXPECT_EQ(mesh.positions, (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})) << text;
        EXPECT_EQ(mesh.faceFirst, (std::vector<uint32_t>{0, 3})) << text;
        const std::string first(text, 2);
        EXPECT_EQ(mesh.normals.size(), first == "NO" || first == "CN" ? 3u : 0u) << text;
        if (first == "CO" || first == "CN") {
            ASSERT_EQ(mesh.colours.size(), 3u) << text;
            EXPECT_EQ(mesh.colours[1], vec3(0, 1, 0)) << text;
        }
    }
}

TEST(SceneMeshFiles, PlyTakesAnyTypesInAnyOrder) {
    const std::string ascii =
        "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x\nelement material 2\nproperty uchar r\nproperty list short double "
        "weights\n"
        "element vertex 3\nproperty uchar blue\nproperty double z\nproperty float32 nz\nproperty float x\nproperty float nx\nproperty "
        "uint8 red\n"
        "property float ny\nproperty short y\nproperty uint8 green\nproperty list uchar uchar tags\nelement face 1\nproperty uchar flags\n"
        "property list ushort uint32 vertex_index\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
        "9 2 0.5 1e300\n7 0\n255 0 1 0 0 51 0 0 0 0\n0 0 1 1 0 0 0 0 255 1 4\n0 0 1 0 0 0 0 1 0 2 5 6\n4 3 0 1 2\n0 1\n";
    const PolygonMesh mesh = readText("m.ply", ascii);
    EXPECT_EQ(mesh.positions, (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(mesh.normals, (std::vector<vec3>(3, vec3(0, 0, 1))));
    EXPECT_EQ(mesh.colours[0], vec3(0.2f, 0, 1));
    EXPECT_EQ(mesh.corners[2].position, 2u);
    EXPECT_EQ(mesh.corners[2].normal, 2u);
    EXPECT_EQ(mesh.ignored.size(), 5u);  // material, tags, flags, edge, colours

    for (const bool big : {false, true}) {
        std::string binary = ascii.substr(0, ascii.find("end_header\n") + 11);
        binary.replace(binary.find("ascii"), 5, big ? "binary_big_endian" : "binary_little_endian");
        const auto vertex = [&](uint8_t blue, float x, uint8_t red, int16_t y, uint8_t green, int tags) {
            put(binary, blue);
            put(binary, 0.0, big);
            put(binary, 1.0f, big);
            put(binary, x, big);
            put(binary, 0.0f, big);
            put(binary, red);
            put(binary, 0.0f, big);
            put(binary, y, big);
            put(binary, green);
            put(binary, uint8_t(tags));
            for (int i = 0; i < tags; ++i) put(binary, uint8_t(4 + i));
        };
        put(binary, uint8_t(9)), put(binary, int16_t(2), big), put(binary, 0.5, big), put(binary, 1e300, big);
        put(binary, uint8_t(7)), put(binary, int16_t(0), big);
        vertex(255, 0, 51, 0, 0, 0);
        vertex(0, 1, 0, 0, 255, 1);
        vertex(0, 0, 0, 1, 0, 2);
        put(binary, uint8_t(4)), put(binary, uint16_t(3), big);
        for (uint32_t i = 0; i < 3; ++i) put(binary, i, big);
        put(binary, int32_t(0), big), put(binary, int32_t(1), big);
        const PolygonMesh same = readText("m.ply", binary);
        EXPECT_EQ(same.positions, mesh.positions) << big;
        EXPECT_EQ(same.normals, mesh.normals) << big;
        EXPECT_EQ(same.colours, mesh.colours) << big;
        EXPECT_EQ(same.faceFirst, mesh.faceFirst) << big;
        EXPECT_TRUE(same.warnings.empty()) << same.warnings[0];
    }
}

TEST(SceneMeshFiles, PlyFacesMayComeBeforeTheVertices) {
    const PolygonMesh mesh = readText("m.ply",
                                      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex "
                                      "3\nproperty float x\nproperty float y\n"
                                      "property float z\nend_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n");
    EXPECT_EQ(mesh.corners.size(), 3u);
}

TEST(SceneMeshFiles, PlyDataThatBeginsLikeALineEndIsData) {
    // The first byte of the data is 0x0a, after each kind of line end.
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        std::string bytes;
        for (const char* line : {"ply", "format binary_little_endian 1.0", "element vertex 3", "property uchar x", "property uchar y",
                                 "property uchar z", "element face 1", "property list uchar uchar vertex_indices", "end_header"})
            bytes += line + end;
        for (char c : {10, 0, 0, 11, 0, 0, 10, 1, 0, 3, 0, 1, 2}) bytes += c;
        const PolygonMesh mesh = readText("m.ply", bytes);
        EXPECT_EQ(mesh.positions[0], dvec3(10, 0, 0));
        EXPECT_EQ(mesh.corners.size(), 3u);
    }
}

TEST(SceneMeshFiles, ExtensionsAreReadInAnyCaseAndOthersRefused) {
    const TemporaryFolder folder;
    Scene scene;
    addMeshFile(scene, folder.write("A.OBJ", kTriangleOf + "f 1 2 3\n"), {});
    EXPECT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.materials.at(0).name, "default");
    EXPECT_THROW(addMeshFile(scene, folder.write("a.3ds", "x"), {}), Error);
    EXPECT_TRUE(isBareMesh("a.STL"));
    EXPECT_FALSE(isBareMesh("a.toml"));
}

TEST(SceneMeshFiles, SeveralMeshesAreSeveralObjectsOfOneScene) {
    const Scene scene = loadScene({kScenes / "procedural/torus.obj", kScenes / "procedural/gear.obj", kScenes / "apple/apple.ply"}, {});
    ASSERT_EQ(scene.objects.size(), 3u);
    EXPECT_EQ(scene.objects[1].name, "gear");
    EXPECT_EQ(scene.objects[2].mesh, 2u);
    ASSERT_EQ(scene.materials.size(), 2u) << "the default material is shared";
    EXPECT_EQ(scene.meshes[0].faceMaterial[0], scene.meshes[2].faceMaterial[0]);
    EXPECT_EQ(scene.materials[scene.meshes[1].faceMaterial[0]].name, "brass");
    try {
        loadScene({kScenes / "procedural/torus.obj", "x.toml"}, {});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::usage);
    }
}

TEST(SceneMeshFiles, RepairsAreCountedAsWarnings) {
    const TemporaryFolder folder;
    Scene scene;
    addMeshFile(scene, folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1e-40\nv 2 0 0\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1 2 4\n"), {});
    std::string all;
    for (const std::string& warning : scene.warnings) all += warning + "\n";
    EXPECT_NE(all.find(": 1 face has no area"), std::string::npos) << all;
    EXPECT_NE(all.find(": 3 corner normals"), std::string::npos) << all;
    EXPECT_NE(all.find(": 1 denormal number is"), std::string::npos) << all;
}

TEST(SceneMeshFiles, EveryMeshOfTheRepositoryHasItsLicenceBesideIt) {
    size_t meshes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(kScenes)) {
        const std::string extension = entry.path().extension().string();
        if (std::string(".obj .ply .stl .off .gltf .glb .mtl").find(extension) == std::string::npos || extension.empty()) continue;
        ++meshes;
        const fs::path licence = entry.path().parent_path() / "LICENSE";
        ASSERT_TRUE(fs::exists(licence)) << entry.path() << " has no LICENSE beside it";
        const std::string text = readWholeFile(licence);
        EXPECT_GT(text.size(), 500u) << licence;
        EXPECT_NE(text.find("opyright"), std::string::npos) << licence;
    }
    EXPECT_GE(meshes, 11u);
}

}  // namespace
}  // namespace plumb
