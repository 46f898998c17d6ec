// SPDX-License-Identifier: MIT
// scene.toml: what it means, how it is refused, and that its documentation is true. Golden numbers are those of the
// lecture notes' worked examples; their ids stand beside them.
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/gtc/matrix_access.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace plumb {
namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;
using test::TemporaryFolder;

constexpr double kDouble = 1e-12;  // implementation_tolerance of the worked examples, times max(1, |expected|)
constexpr double kFloat = 4e-6;

const std::string kTriangle = "\n[[mesh]]\nname = 'triangle'\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]\n";

Scene load(const std::string& text, const LoadOptions& options = {}) {
    TemporaryFolder folder;
    return readSceneToml(folder.write("scene.toml", text), options);
}

// The refusal of a file, without the folder's name; "" when it was loaded.
std::string refusal(const TemporaryFolder& folder, const std::string& text) {
    try {
        readSceneToml(folder.write("scene.toml", text), {});
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input) << error.what();
        std::string message = error.what();
        const std::string prefix = folder.path().string() + "/";
        if (message.starts_with(prefix)) message = message.substr(prefix.size());
        return message;
    }
}

void expectNear(const dvec3& got, const dvec3& want, double tolerance, const std::string& what) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], want[i], tolerance * std::max(1.0, std::abs(want[i]))) << what << " component " << i;
}

dvec3 apply(const dmat4& m, const dvec3& p) { return dvec3(m * dvec4(p, 1)); }

dmat4 transformOf(const std::string& list) {
    return load(kTriangle + "[[object]]\nmesh = 'triangle'\ntransform = [" + list + "]\n").objects.at(0).worldFromObject;
}

TEST(SceneToml, DefaultsAreThoseOfABareMesh) {
    const Scene scene = load(kTriangle);
    EXPECT_FALSE(scene.camera);
    EXPECT_FALSE(scene.leftHanded);
    EXPECT_FALSE(scene.background || scene.shading || scene.encoding);
    EXPECT_TRUE(scene.lights.empty());
    EXPECT_TRUE(scene.cullBackFaces);
    EXPECT_EQ(scene.ambient, glm::vec3(1));
    EXPECT_EQ(scene.size, glm::uvec2(0));
    ASSERT_EQ(scene.objects.size(), 1u) << "without [[object]] each mesh is one";
    EXPECT_EQ(scene.objects[0].name, "triangle");
    EXPECT_EQ(scene.materials.at(0).diffuse, Material{}.diffuse);
}

TEST(SceneToml, ReadsEverySetting) {
    const Scene scene = load(
        "handedness = 'left'\nup = [0, 0, 2]\nambient = [0.1, 0.2, 0.3]\nbackground = '#ffffff'\nencoding = 'linear'\n"
        "shading = 'gouraud'\nsize = [640, 480]\ncull = false\n" +
        kTriangle);
    EXPECT_TRUE(scene.leftHanded);
    EXPECT_EQ(scene.up, dvec3(0, 0, 1));
    EXPECT_EQ(scene.ambient, glm::vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(scene.background, glm::vec3(1));
    EXPECT_EQ(scene.encoding, Encoding::linear);
    EXPECT_EQ(scene.shading, Shading::gouraud);
    EXPECT_EQ(scene.size, glm::uvec2(640, 480));
    EXPECT_FALSE(scene.cullBackFaces);
    EXPECT_EQ(scene.sha256.size(), 64u);
}

TEST(SceneToml, HexColoursAreSrgb) {
    const Scene scene = load("[[material]]\nname = 'm'\ndiffuse = '#8000ff'\nambient = 0.5\n" + kTriangle);
    const Material& m = scene.materials.at(1);
    EXPECT_FLOAT_EQ(m.diffuse.r, 0.21586050f);  // 128 in IEC 61966-2-1
    EXPECT_EQ(m.diffuse.g, 0.0f);
    EXPECT_EQ(m.diffuse.b, 1.0f);
    EXPECT_EQ(m.ambient, glm::vec3(0.5f)) << "a number is linear grey";
}

// Light is three numbers. A file that asks for a wavelength or a number of lumens is refused rather than given another light.
TEST(SceneToml, NoSpectrumIsModelled) {
    const TemporaryFolder folder;
    const std::string light = "[[light]]\ndirection = [0, 0, 1]\n";
    EXPECT_NE(refusal(folder, light + "wavelength = 555\n" + kTriangle).find("unknown key 'wavelength' in [[light]]"), std::string::npos);
    EXPECT_NE(refusal(folder, light + "lumens = 800\n" + kTriangle).find("unknown key 'lumens' in [[light]]"), std::string::npos);
    // Yellow has no place of its own in it: red and green are yellow.
    const Scene scene = load("[[material]]\nname = 'm'\ndiffuse = '#ffff00'\n" + kTriangle);
    EXPECT_EQ(scene.materials.at(1).diffuse, glm::vec3(1, 1, 0));
}

TEST(SceneToml, InksAreWhatTheyLeaveOfTheEncodedColour) {
    const auto diffuse = [](const std::string& colour) {
        return load("[[material]]\nname = 'm'\ndiffuse = " + colour + "\n" + kTriangle).materials.at(1).diffuse;
    };
    EXPECT_EQ(diffuse("{ cmy = [1, 0, 0] }"), diffuse("'#00ffff'"));
    EXPECT_EQ(diffuse("{ cmy = [0.2, 0.4, 0.6] }"), diffuse("'#cc9966'"));
    EXPECT_EQ(diffuse("{ cmyk = [0, 0, 0, 0.2] }"), diffuse("'#cccccc'"));
    EXPECT_EQ(diffuse("{ cmyk = [0, 1, 1, 0] }"), diffuse("'#ff0000'"));
    EXPECT_EQ(diffuse("{ cmyk = [0.3, 0.2, 0.1, 1] }"), glm::vec3(0)) << "full black leaves nothing";
}

TEST(SceneToml, AnAreaLightIsReadAsItsPoints) {
    const std::string lamp = "[[light]]\ntype = 'area'\nposition = [1, 2, 3]\nedge_u = [4, 0, 0]\nintensity = 8\n";
    const Scene line = load(lamp + "points = 2\n" + kTriangle);
    ASSERT_EQ(line.lights.size(), 2u);
    EXPECT_EQ(line.lights[1].position, dvec3(4, 2, 3));
    EXPECT_EQ(line.lights[1].intensity, glm::vec3(4));
    const Scene rectangle = load(lamp + "edge_v = [0, 0, 2]\npoints = [64, 64]\nattenuation = '1/d'\n" + kTriangle);
    ASSERT_EQ(rectangle.lights.size(), 4096u) << "as many as one may have";
    EXPECT_EQ(rectangle.lights[0].attenuation, Attenuation::inverse);
}

TEST(SceneToml, ChoicesOfDrawingAreRead) {
    const Scene scene = load("wire = 'solid'\nedges = 'polygons'\nviewer = 'distant'\n" + kTriangle);
    EXPECT_EQ(scene.wire, WireView::solid);
    EXPECT_EQ(scene.wirePerPolygon, true);
    EXPECT_EQ(scene.distantViewer, true);
    const Scene plain = load(kTriangle);
    EXPECT_FALSE(plain.wire || plain.wirePerPolygon || plain.distantViewer);
}

template <class Rows, class ValueOf>
void expectEveryWord(const std::string& key, const Rows& rows, const ValueOf& valueOf) {
    for (const auto& row : rows) EXPECT_EQ(valueOf(load(key + " = '" + row.word + "'\n" + kTriangle)), row.value) << key << ' ' << row.word;
}

TEST(SceneToml, EveryWordOfEveryChoiceIsRead) {
    expectEveryWord("shading", kShadings, [](const Scene& s) { return *s.shading; });
    expectEveryWord("fill", kFills, [](const Scene& s) { return *s.fill; });
    expectEveryWord("wire", kWireViews, [](const Scene& s) { return *s.wire; });
    expectEveryWord("edges", kEdgeCounts, [](const Scene& s) { return *s.wirePerPolygon; });
    expectEveryWord("viewer", kViewers, [](const Scene& s) { return *s.distantViewer; });
    expectEveryWord("encoding", kEncodings, [](const Scene& s) { return *s.encoding; });
    expectEveryWord("sampling", kSamplings, [](const Scene& s) { return *s.sampling; });
    expectEveryWord("encoding = 'linear'\nlevels", kLevelForms, [](const Scene& s) { return *s.cutLevels; });
}

TEST(SceneToml, TheNotesViewerStandsAtMinusD) {
    const Camera camera = load("handedness = 'left'\n[camera]\ndistance = 500\nnear = 2\n" + kTriangle).camera.value();
    EXPECT_EQ(camera.eye, dvec3(0, 0, -500));
    EXPECT_EQ(camera.forward, dvec3(0, 0, 1));
    EXPECT_EQ(camera.right, dvec3(1, 0, 0));
    EXPECT_EQ(camera.up, dvec3(0, 1, 0));
    EXPECT_EQ(camera.focalPixels, 500);
    EXPECT_EQ(camera.near, 2);
}

TEST(SceneToml, CamerasAreOrthonormalAndOfTheirHandedness) {
    for (const bool left : {false, true}) {
        const Camera camera =
            load(fmt::format("handedness = '{}'\n[camera]\neye = [3, 4, 5]\nat = [1, 1, -2]\nfov = 30\n", left ? "left" : "right") +
                 kTriangle)
                .camera.value();
        const glm::dmat3 axes(camera.right, camera.up, camera.forward);
        const glm::dmat3 products = glm::transpose(axes) * axes;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) EXPECT_NEAR(products[i][j], i == j, kDouble);
        expectNear(glm::cross(camera.right, camera.up), left ? camera.forward : -camera.forward, kDouble, "right x up");
        expectNear(camera.forward, dvec3(-2, -3, -7) / std::sqrt(62.0), kDouble, "forward");
        EXPECT_GT(camera.up.y, 0);
        EXPECT_EQ(camera.fovYDegrees, 30);
        EXPECT_NEAR(camera.focusDistance, std::sqrt(62.0), kDouble);
    }
}

TEST(SceneToml, CamerasFarAwayDoNotOverflow) {
    const Camera camera = load("[camera]\neye = [1e30, 0, 0]\nat = [-1e30, 0, 1]\n" + kTriangle).camera.value();
    expectNear(camera.forward, dvec3(-1, 0, 0), kDouble, "forward");
    EXPECT_NEAR(camera.focusDistance / 2e30, 1, kDouble);
}

TEST(SceneToml, LightsKeepTheirKind) {
    const Scene scene = load(
        "[[light]]\ntype = 'directional'\ndirection = [1, 1, -1]\nintensity = 0.7\n"
        "[[light]]\ntype = 'point'\nposition = [1, 2, 3]\nintensity = [9, 8, 7]\nattenuation = '1/d^2'\n" +
        kTriangle);
    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_TRUE(scene.lights[0].directional);
    EXPECT_EQ(scene.lights[0].direction, dvec3(1, 1, -1));
    EXPECT_EQ(scene.lights[0].intensity, glm::vec3(0.7f));
    EXPECT_FALSE(scene.lights[1].directional);
    EXPECT_EQ(scene.lights[1].position, dvec3(1, 2, 3));
    EXPECT_EQ(scene.lights[1].intensity, glm::vec3(9, 8, 7));
    EXPECT_EQ(scene.lights[1].attenuation, Attenuation::inverseSquare);
}

// s083_matrix_*: the column-vector matrices of section 9.2, phi = 30 degrees.
TEST(SceneToml, TransformsAreTheNotesMatrices) {
    const double c = 0.8660254037844386, s = 0.5;
    const struct {
        const char* text;
        double rows[16];
    } cases[] = {
        {"{ translate = [4, 5, 6] }", {1, 0, 0, 4, 0, 1, 0, 5, 0, 0, 1, 6, 0, 0, 0, 1}},
        {"{ scale = [2, 3, 4] }", {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1}},
        {"{ rotate_z = 30 }", {c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
        {"{ rotate_y = 30 }", {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, 0, 1}},
        {"{ rotate_x = 30 }", {1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0, 0, 0, 0, 1}},
        {"{ rotate = { axis = [0, 0, 7], degrees = 30 } }", {c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
        {"{ rotate = { axis = [0, 1, 0], degrees = 30 } }", {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, 0, 1}},
        {"{ rotate = { axis = [1e-9, 0, 0], degrees = 30 } }", {1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0, 0, 0, 0, 1}},
        {"{ matrix = [1, 2, 3, 4,  0, 1, 5, 6,  0, 0, 1, 7,  0, 0, 0, 1] }", {1, 2, 3, 4, 0, 1, 5, 6, 0, 0, 1, 7, 0, 0, 0, 1}},
    };
    for (const auto& row : cases) {
        const dmat4 m = transformOf(row.text);
        for (int i = 0; i < 16; ++i) EXPECT_NEAR(m[i % 4][i / 4], row.rows[i], kDouble) << row.text << " entry " << i;
    }
}

TEST(SceneToml, QuarterTurnsAreExact) {
    const dmat4 m = transformOf(
        "{ rotate_z = 90 }, { rotate_z = -270 }, { rotate_x = 180 }, { rotate_x = 540 }, { rotate_y = -90 }, "
        "{ rotate_y = 450 }");
    const dvec3 p = apply(m, dvec3(1, 2, 3));
    EXPECT_EQ(p, dvec3(-1, -2, 3));
}

// s1022_composite_phi90: rotation by 90 degrees about the line through P1 (3,3,5) and P2.
TEST(SceneToml, RotatesAboutALineAsTheNotesDo) {
    const dmat4 m = transformOf("{ rotate = { axis = [3, 3.464101615137754, 2], degrees = 90, through = [3, 3, 5] } }");
    expectNear(apply(m, dvec3(4, 3, 5)), dvec3(3.36, 3.8156921938165302, 4.5471796769724495), kDouble, "test point");
    expectNear(apply(m, dvec3(3, 3, 5)), dvec3(3, 3, 5), kDouble, "P1");
    expectNear(apply(m, dvec3(6, 6.464101615137754, 7)), dvec3(6, 6.464101615137754, 7), kDouble, "P2");
}

TEST(SceneToml, TransformsApplyInTheOrderOfTheList) {
    const dmat4 m = transformOf("{ translate = [1, 0, 0] }, { scale = 2 }, { rotate_z = 90 }");
    EXPECT_EQ(apply(m, dvec3(0)), dvec3(0, 2, 0));
    expectNear(apply(transformOf("{ scale = 3, about = [1, 1, 1] }"), dvec3(1, 1, 2)), dvec3(1, 1, 4), kDouble, "about");
}

TEST(SceneToml, ChildrenFollowTheirParents) {
    const Scene scene = load(kTriangle +
                             "[[object]]\nname = 'hand'\nparent = 'arm'\nmesh = 'triangle'\ntransform = [{ translate = [10, 0, 0] }]\n"
                             "[[object]]\nname = 'arm'\ntransform = [{ rotate_z = 90 }, { translate = [0, 0, 5] }]\n"
                             "[[object.child]]\nname = 'elbow'\nmesh = 'triangle'\ntransform = [{ translate = [1, 0, 0] }]\n"
                             "[[object.child.child]]\nmesh = 'triangle'\ntransform = [{ scale = 2 }]\n");
    ASSERT_EQ(scene.objects.size(), 3u) << "a group is not drawn";
    EXPECT_EQ(scene.objects[0].name, "hand");
    expectNear(apply(scene.objects[0].worldFromObject, dvec3(0)), dvec3(0, 10, 5), kDouble, "hand");
    EXPECT_EQ(scene.objects[1].name, "elbow");
    expectNear(apply(scene.objects[1].worldFromObject, dvec3(1, 0, 0)), dvec3(0, 2, 5), kDouble, "elbow");
    EXPECT_EQ(scene.objects[2].name, "triangle") << "without a name, the mesh's";
    expectNear(apply(scene.objects[2].worldFromObject, dvec3(1, 0, 0)), dvec3(0, 3, 5), kDouble, "grandchild");
}

TEST(SceneToml, ObjectsReplaceMaterialsAndShareCopies) {
    const std::string object = "[[object]]\nmesh = 'triangle'\n";
    const Scene scene =
        load("[[material]]\nname = 'red'\n" + kTriangle + object + object + "material = 'red'\n" + object + "material = 'red'\n");
    ASSERT_EQ(scene.objects.size(), 3u);
    EXPECT_NE(scene.objects[0].mesh, scene.objects[1].mesh);
    EXPECT_EQ(scene.objects[1].mesh, scene.objects[2].mesh);
    EXPECT_EQ(scene.meshes[scene.objects[0].mesh].faceMaterial.at(0), 0u);
    EXPECT_EQ(scene.meshes[scene.objects[1].mesh].faceMaterial.at(0), 1u);
    for (const uint32_t material : scene.meshes[scene.objects[1].mesh].vertexMaterial) EXPECT_EQ(material, 1u);
}

TEST(SceneToml, FacesTakeTheirOwnMaterials) {
    const Scene scene = load(
        "[[material]]\nname = 'a'\n[[material]]\nname = 'default'\ndiffuse = 0.25\n[[material]]\nname = 'b'\n"
        "[[mesh]]\nname = 'm'\nvertices = [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]\nfaces = [[0,2,1],[0,1,3],[0,3,2]]\n"
        "face_materials = ['b', 'default', 'a']\n");
    EXPECT_EQ(scene.meshes.at(0).faceMaterial, (std::vector<uint32_t>{2, 0, 1}));
    EXPECT_EQ(scene.materials.size(), 3u);
    EXPECT_EQ(scene.materials[0].diffuse, glm::vec3(0.25f));
}

TEST(SceneToml, ReadsMeshFilesOnceAndReplacesTheirMaterials) {
    TemporaryFolder folder;
    folder.write("models/triangle.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const Scene scene = readSceneToml(folder.write("scene.toml",
                                                   "[[material]]\nname = 'red'\n"
                                                   "[[mesh]]\nname = 'plain'\nfile = 'models/triangle.off'\n"
                                                   "[[mesh]]\nname = 'red'\nfile = 'models/./triangle.off'\nmaterial = 'red'\n"),
                                      {});
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[scene.objects[1].mesh].faceMaterial.at(0), 1u);
}

TEST(SceneToml, AReplacedMaterialNeedsNoLibrary) {
    TemporaryFolder folder;
    folder.write("m.obj", "mtllib missing.mtl\nusemtl gold\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string mesh = "[[mesh]]\nname = 'm'\nfile = 'm.obj'\n";
    LoadOptions strict;
    strict.strict = true;
    EXPECT_THROW(readSceneToml(folder.write("scene.toml", mesh), strict), Error);
    const Scene scene = readSceneToml(folder.write("scene.toml", mesh + "material = 'red'\n[[material]]\nname = 'red'\n"), strict);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.meshes.at(0).faceMaterial.at(0), 1u);
}

// s12_pyramid_*, s142_project_a: normals of section 12.1 and the projection of A on a canvas of 400 x 400.
TEST(SceneToml, ThePyramidIsTheNotes) {
    const Scene scene = readSceneToml(PLUMB_SOURCE_DIR "/scenes/pyramid.toml", {});
    ASSERT_EQ(scene.objects.size(), 1u);
    const TriangleMesh& mesh = scene.meshes.at(scene.objects[0].mesh);
    EXPECT_EQ(mesh.triangles.size(), 6u);
    EXPECT_EQ(mesh.edges.size(), 8u);  // s02_pyramid_hierarchy
    const double h = 0.7071067811865476;
    const dvec3 normals[] = {{0, h, -h}, {0, h, h}, {-h, h, 0}, {h, h, 0}, {0, -1, 0}};
    ASSERT_EQ(mesh.faceNormal.size(), 5u);
    for (int f = 0; f < 5; ++f) expectNear(mesh.faceNormal[size_t(f)], normals[f], kFloat, fmt::format("face {}", f));
    // Sides that meet at 60 degrees stay apart: every vertex has the normal of its face.
    for (const auto& triangle : mesh.triangles)
        for (uint32_t vertex : triangle.vertex) expectNear(mesh.normals[vertex], mesh.faceNormal[triangle.face], kFloat, "vertex normal");
    EXPECT_EQ(mesh.boundsMin, glm::vec3(-50, -150, 50));
    EXPECT_EQ(mesh.boundsMax, glm::vec3(50, -100, 150));
    // Visible: N . V - D > 0 from (0, 0, -500); also the sense of the vertices on the screen, clockwise with y down.
    const Camera& camera = scene.camera.value();
    const bool visible[] = {true, false, true, true, false};
    bool seesA = false;
    for (const auto& triangle : mesh.triangles) {
        dvec3 corner[3];
        for (int i = 0; i < 3; ++i) corner[i] = mesh.positions[triangle.vertex[i]];
        const dvec3 normal(mesh.faceNormal[triangle.face]);
        EXPECT_EQ(glm::dot(normal, camera.eye - corner[0]) > 0, visible[triangle.face]);
        const auto screen = [&](const dvec3& p) {
            return glm::dvec2(200 + camera.focalPixels * p.x / (p.z - camera.eye.z), 200 - camera.focalPixels * p.y / (p.z - camera.eye.z));
        };
        const glm::dvec2 a = screen(corner[0]), b = screen(corner[1]), c = screen(corner[2]);
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);  // y down: > 0 is clockwise
        EXPECT_EQ(area > 0, visible[triangle.face]) << "face " << triangle.face;
        for (int i = 0; i < 3; ++i) {
            if (corner[i] != dvec3(0, -100, 100)) continue;
            expectNear(dvec3(screen(corner[i]), 0), dvec3(200, 283.3333333333333, 0), kDouble, "A");
            seesA = true;
        }
    }
    ASSERT_TRUE(seesA);
    EXPECT_EQ(scene.size, glm::uvec2(400, 400));
    EXPECT_EQ(scene.encoding, Encoding::linear);
}

// s171_cylinder_vertices, s171_cylinder_surface_normals, s172_polygon0_vertex_normals, s172_gouraud_setup_polygon0.
TEST(SceneToml, TheCylinderIsTheNotes) {
    const Scene scene = readSceneToml(PLUMB_SOURCE_DIR "/scenes/cylinder.toml", {});
    const Object& object = scene.objects.at(0);
    const TriangleMesh& mesh = scene.meshes.at(object.mesh);
    const double h = 0.7071067811865476;
    const dvec3 normals[] = {{0, 1, 0},   {h, h, 0},  {1, 0, 0},  {h, -h, 0}, {0, -1, 0},
                             {-h, -h, 0}, {-1, 0, 0}, {-h, h, 0}, {0, 0, -1}, {0, 0, 1}};
    ASSERT_EQ(mesh.faceNormal.size(), 10u);
    for (int f = 0; f < 10; ++f) expectNear(mesh.faceNormal[size_t(f)], normals[f], kFloat, fmt::format("face {}", f));
    // 32 smooth corners on 16 positions, and 16 more of the caps: one position, several normals.
    EXPECT_EQ(mesh.positions.size(), 32u);
    // Polygon 0 (F0, B0, B1, F1) after the transform.
    const dvec3 positions[] = {{-156.68961783754037, -56.066017177982104, 78.60562088682943},
                               {-15.268261600230868, 226.77669529663686, 323.55459516514725},
                               {71.334278778213, 226.77669529663686, 273.55459516514725},
                               {-70.08707745909649, -56.066017177982104, 28.605620886829428}};
    const dvec3 turned[] = {{-0.6580543152546858, 0.6532814824381883, -0.3744166434308837},
                            {0.004772832816497763, 0.6532814824381883, -0.7571000757959734}};
    int seen = 0;
    for (const auto& triangle : mesh.triangles) {
        if (triangle.face != 0) continue;
        for (uint32_t vertex : triangle.vertex) {
            const dvec3 world = apply(object.worldFromObject, mesh.positions[vertex]);
            const dvec3 normal = glm::dmat3(object.worldFromObject) * dvec3(mesh.normals[vertex]);
            for (int i = 0; i < 4; ++i) {
                if (glm::length(world - positions[i]) > 1) continue;
                expectNear(world, positions[i], kFloat, "position");
                expectNear(normal, turned[i / 2], kFloat, "normal");
                ++seen;
            }
        }
    }
    EXPECT_EQ(seen, 6);
}

struct BadScene {
    std::string text;   // '@' stands before the refused place
    std::string field;  // must be named
};

const std::string kMesh = "[[mesh]]\nname = 'm'\n";
const std::string kObject = kTriangle + "[[object]]\nmesh = 'triangle'\n";

std::vector<BadScene> badScenes() {
    const std::string material = "[[material]]\nname = 'm'\n";
    const std::string faces = "vertices = [[0,0,0],[1,0,0],[0,1,0]]\nfaces = ";
    std::vector<BadScene> rows = {
        // TOML itself
        {"ambient = @\n", "TOML"},
        {"ambient = 1 @2", "TOML"},
        {"[camera@", "TOML"},
        {"ambient = 1\nambient = @2", "TOML"},
        {"a = @'\xff'", "TOML"},
        // settings
        {"@ambiant = 1", "unknown key 'ambiant' in the scene; did you mean 'ambient'?"},
        {"@zzz = 1", "known: "},
        {"handedness = @'lefty'", "handedness is 'lefty'; did you mean 'left'?"},
        {"handedness = @1", "handedness is an integer"},
        {"up = @[0, 0, 0]", "up is the zero vector"},
        {"up = @[0, 1]", "up has 2 numbers"},
        {"up = @'y'", "up is a string"},
        {"up = [0, 1, @nan]", "up[2] is NaN"},
        {"ambient = @inf", "ambient is infinite"},
        {"ambient = @-0.5", "ambient is -0.5"},
        {"ambient = @'#12345'", "ambient is '#12345'"},
        {"ambient = @'#12345g'", "ambient"},
        {"ambient = @1979-05-27", "ambient is a date or time"},
        {"background = [0, @2, 0]", "background[1] is 2"},
        {"encoding = @'sRGB'", "did you mean 'srgb'?"},
        {"shading = @'fong'", "did you mean 'phong'?"},
        {"size = @[1, 2, 3]", "size has 3"},
        {"size = [@0, 1]", "size[0] is 0"},
        {"size = [640, @65537]", "size[1] is 65537"},
        {"size = [@640.0, 1]", "size[0] is a number, not an integer"},
        {"cull = @'no'", "cull is a string"},
        // camera
        {"camera = @3", "camera is an integer, not a table"},
        {"@[camera]\nat = [0,0,0]", "camera has no 'eye'"},
        {"@[camera]\neye = [0,0,0]", "camera has no 'at'"},
        {"[camera]\neye = [1,2,3]\nat = @[1,2,3]", "camera.at"},
        {"[camera]\neye = [0,5,0]\nat = @[0,0,0]", "camera.up is parallel"},
        {"[camera]\neye = [0,5,0]\nat = [0,0,5]\nup = @[0,1,-1]", "camera.up is parallel"},
        {"[camera]\neye = [0,5,0]\nat = [0,0,5]\nup = @[0,0,0]", "camera.up is the zero vector"},
        {"[camera]\neye = [0,0,1]\nat = [0,0,0]\nfov = @180", "camera.fov"},
        {"[camera]\neye = [0,0,1]\nat = [0,0,0]\nfov = @0", "camera.fov"},
        {"[camera]\neye = [0,0,1]\nat = [0,0,0]\nnear = @0", "camera.near is 0"},
        {"[camera]\neye = [0,0,@1e31]\nat = [0,0,0]", "camera.eye[2]"},
        {"[camera]\ndistance = @500", "camera.distance"},
        {"handedness = 'left'\n[camera]\ndistance = @0", "camera.distance is 0"},
        {"handedness = 'left'\n[camera]\ndistance = @-1", "camera.distance is -1"},
        {"handedness = 'left'\n[camera]\ndistance = 5\neye = @[0,0,0]", "camera.eye beside camera.distance"},
        {"[camera]\n@fovy = 3", "did you mean 'fov'?"},
        // materials
        {"@[[material]]\ndiffuse = 1", "material has no 'name'"},
        {"[[material]]\nname = @7", "material.name is an integer"},
        {material + "[[material]]\nname = @'m'", "material.name 'm' is taken"},
        {material + "@colour = 1", "unknown key 'colour' in [[material]]"},
        {material + "diffuse = @1.5", "material.diffuse is 1.5"},
        {material + "specular = @[1, 1]", "material.specular"},
        {material + "emission = [0, @'x', 0]", "material.emission[1] is a string"},
        {material + "shininess = @1000001", "material.shininess"},
        {material + "shininess = @-1", "material.shininess"},
        {material + "shininess = @nan", "material.shininess is NaN"},
        {material + "opacity = @2", "material.opacity"},
        {material + "ior = @0", "material.ior"},
        // rays
        {"max_depth = @0", "max_depth is 0, outside 1 to 64"},
        {"min_weight = @2", "min_weight is 2"},
        {"shadows = @1", "shadows is an integer"},
        {"sampling = @'corner'", "sampling is 'corner'; did you mean 'corners'?"},
        {"sampling = @4", "sampling is an integer, not a string"},
        {"jitter = @0.1", "jitter is a number, not a table"},
        {"jitter = @{}", "jitter holds nothing"},
        {"jitter = { @mirror = 0.1 }", "unknown key 'mirror' in jitter"},
        {"jitter = { reflect = @0.6 }", "jitter.reflect is 0.6, outside 0 to 0.5"},
        {"jitter = { refract = @-0.1 }", "jitter.refract is -0.1"},
        {"jitter = { shadow = @nan }", "jitter.shadow is NaN"},
        {"seed = @-1", "seed is -1, outside 0 to 4294967295"},
        {"seed = @4294967296", "seed is 4294967296"},
        {"seed = @1.5", "seed is a number, not an integer"},
        {"levels = @'whole'", "levels is 'whole'"},
        {"levels = @'cut'", "it goes with encoding = \"linear\""},
        {"encoding = 'srgb'\nlevels = @'cut'", "it goes with encoding"},
        {material + "density = @0", "material.density is 0"},
        {material + "density = @-1.5", "material.density is -1.5"},
        {material + "ior = 2\ndensity = @1.5", "two names of one number"},
        {material + "reflect = @-0.1", "material.reflect is -0.1"},
        {material + "transmit = @1.1", "material.transmit is 1.1"},
        {"@[[material]]\nname = 'm'\nreflect = 0.7\ntransmit = 0.5",
         "material 'm': reflect 0.7, transmit 0.5 and local 0 add up to more than 1"},
        {"@[[material]]\nname = 'm'\nreflect = 0.7\nlocal = 0.5", "add up to more than 1"},
        {"@[[sphere]]\nradius = 1", "sphere has no 'centre'"},
        {"@[[sphere]]\ncentre = [0,0,0]", "sphere has no 'radius'"},
        {"[[sphere]]\ncentre = [0,0,0]\nradius = @-1", "sphere.radius is -1, not above 0"},
        {"[[sphere]]\ncentre = [0,0,0]\nradius = @0", "sphere.radius is 0, not above 0"},
        {"[[sphere]]\ncentre = [0,0,0]\nradius = @nan", "sphere.radius is NaN"},
        {"[[sphere]]\ncentre = [0,0,0]\nradius = 1\nmaterial = @'gloss'", "unknown material 'gloss'"},
        {"[[sphere]]\n@center = [0,0,0]\nradius = 1", "did you mean 'centre'?"},
        {"[[plane]]\npoint = [0,0,0]\nnormal = @[0,0,0]", "plane.normal is the zero vector"},
        {"[[plane]]\npoint = [0,0,0]\nnormal = [0,1,0]\nu = @[0,2,0]", "plane.u is parallel to plane.normal"},
        {"[[plane]]\npoint = [0,0,0]\nnormal = [0,1,0]\nu_range = @[1,1]", "plane.u_range is empty"},
        {"[[plane]]\npoint = [0,0,0]\nnormal = [0,1,0]\nv_range = @[1]", "plane.v_range has 1 numbers"},
        {"[[plane]]\npoint = [0,0,0]\nnormal = [0,1,0]\nboard = { square = @0, material = 'default' }", "plane.board.square is 0"},
        {"[[plane]]\npoint = [0,0,0]\nnormal = [0,1,0]\nboard = @{ square = 1 }", "plane.board has no 'material'"},
        // lights
        {"@[[light]]\nintensity = 1", "light has no 'type'"},
        {"[[light]]\ntype = @'spot'", "light.type is 'spot'"},
        {"@[[light]]\ntype = 'directional'", "directional light has no 'direction'"},
        {"@[[light]]\ntype = 'point'", "point light has no 'position'"},
        {"[[light]]\ntype = 'directional'\ndirection = @[0, 0, 0]", "light.direction is the zero vector"},
        {"[[light]]\ntype = 'directional'\ndirection = [1,0,0]\nposition = @[0, 0, 0]", "light.position needs"},
        {"[[light]]\ntype = 'directional'\ndirection = [1,0,0]\nattenuation = @'1/d'", "light.attenuation needs"},
        {"[[light]]\ntype = 'point'\nposition = [0, 0, 0]\nattenuation = @'1/d2'", "did you mean '1/d"},
        {"[[light]]\ntype = 'point'\nposition = [0, 0, @-inf]", "light.position[2] is infinite"},
        {"[[light]]\ntype = 'point'\nposition = [0, 0, 0]\nintensity = [1, @-1, 1]", "light.intensity[1]"},
        // meshes
        {"@[[mesh]]\nfile = 'a.obj'", "mesh has no 'name'"},
        {"@[[mesh]]\nname = 'm'", "mesh 'm' has neither 'file' nor 'shape' nor 'vertices'"},
        {"@" + kMesh + "vertices = [[0,0,0]]", "mesh has no 'faces'"},
        {kMesh + "vertices = @3", "mesh.vertices is an integer"},
        {kMesh + "vertices = [[0,0,0], @[1,2,3,4]]\nfaces = []", "mesh.vertices[1] has 4 numbers"},
        {kMesh + "vertices = [[0,0,0], [1,@nan,2]]\nfaces = []", "mesh.vertices[1][1] is NaN"},
        {kMesh + "vertices = [[0,0,@-inf]]\nfaces = []", "mesh.vertices[0][2] is infinite"},
        {kMesh + "vertices = [[0,0,@1e300]]\nfaces = []", "mesh.vertices[0][2]"},
        {kMesh + faces + "@[]", "mesh.faces is empty"},
        {kMesh + faces + "[@[0, 1]]", "mesh.faces[0] has 2 vertices"},
        {kMesh + faces + "[[0, 1, @3]]", "mesh.faces[0][2] is 3, outside 0 to 2"},
        {kMesh + faces + "[[0, 1, @-1]]", "mesh.faces[0][2] is -1"},
        {kMesh + faces + "[[0, 1, @1.0]]", "mesh.faces[0][2] is a number, not an integer"},
        {kMesh + faces + "[[0, 1, 2], [0, 1, 2, @0]]", "mesh.faces[1] names vertex 0 twice"},
        {kMesh + "vertices = []\nfaces = [[@0, 1, 2]]", "mesh.faces[0][0]"},
        {kMesh + faces + "[[0, 1, 2]]\nmaterial = @'brass'", "mesh.material names the unknown material 'brass'"},
        {kMesh + faces + "[[0, 1, 2]]\nface_materials = @[]", "mesh.face_materials has 0 names for 1 faces"},
        {kMesh + faces + "[[0, 1, 2]]\nface_materials = [@'x']", "mesh.face_materials[0]"},
        {kMesh + faces + "[[0, 1, 2]]\nface_materials = @['default']\nmaterial = 'default'", "beside mesh.material"},
        {kMesh + faces + "[[0, 1, 2]]\ncrease = @200", "mesh.crease is 200"},
        {kMesh + "file = @'nowhere.obj'", "mesh.file 'nowhere.obj' does not exist"},
        {kMesh + "file = @'../up.obj'", "mesh.file"},
        {kMesh + "file = @'/etc/passwd'", "mesh.file"},
        {kMesh + "file = @3", "mesh.file is an integer"},
        {kMesh + "file = 'a.obj'\nvertices = @[]", "mesh.vertices beside mesh.file"},
        {kTriangle + "[[mesh]]\nname = @'triangle'\n", "mesh.name 'triangle' is taken"},
        // objects and transforms
        {kTriangle + "[[object]]\nmesh = @'triangel'", "did you mean 'triangle'?"},
        {kTriangle + "[[object]]\nmaterial = @'default'", "object.material without object.mesh"},
        {kObject + "material = @'brass'", "object.material names the unknown material 'brass'"},
        {kObject + "@tranform = []", "did you mean 'transform'?"},
        {kObject + "transform = @{ scale = 1 }", "object.transform is a table, not an array"},
        {kObject + "transform = [@3]", "object.transform[0] is an integer"},
        {kObject + "transform = [@{}]", "object.transform[0] holds no transform"},
        {kObject + "transform = [{ scale = 1 }, @{ scale = 1, rotate_x = 1 }]", "object.transform[1] holds 2 transforms"},
        {kObject + "transform = [{ @rotate_w = 1 }]", "unknown key 'rotate_w' in object.transform[0]"},
        {kObject + "transform = [{ translate = @[1, 0] }]", "object.transform[0].translate has 2"},
        {kObject + "transform = [{ translate = [1, 0, @nan] }]", "object.transform[0].translate[2] is NaN"},
        {kObject + "transform = [{ rotate_x = @inf }]", "object.transform[0].rotate_x is infinite"},
        {kObject + "transform = [{ rotate = { axis = @[0,0,0], degrees = 1 } }]", "object.transform[0].rotate.axis is the zero vector"},
        {kObject + "transform = [{ rotate = @{ axis = [0,0,1] } }]", "has no 'degrees'"},
        {kObject + "transform = [{ translate = [0,0,0], about = @[0,0,0] }]", "object.transform[0].about"},
        {kObject + "transform = [{ matrix = @[1] }]", "object.transform[0].matrix has 1 numbers"},
        {kObject + "transform = [{ matrix = @[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1] }]", "last row"},
        {kObject + "transform = [{ scale = 1e20 }, @{ scale = 1e20 }]", "object.transform[1]"},
        {kObject + "name = 'a'\n[[object]]\nname = @'a'\n", "object.name 'a' is taken"},
        {kObject + "parent = @'nobody'", "object.parent names the unknown object 'nobody'"},
        {kObject + "name = 'a'\nparent = @'a'", "object.parent: a -> a is a cycle"},
        {kObject + "name = 'a'\nparent = @'b'\n[[object]]\nname = 'b'\nparent = 'a'\n", "a -> b -> a is a cycle"},
        {kObject + "name = 'a'\n[[object.child]]\nparent = @'a'\n", "object.parent of a nested child"},
        {kObject + "child = @3", "object.child is an integer"},
    };
    return rows;
}

TEST(SceneToml, BadInputNamesPlaceAndField) {
    const std::vector<BadScene> rows = badScenes();
    ASSERT_GE(rows.size(), 40u);
    TemporaryFolder folder;
    for (const BadScene& row : rows) {
        const size_t mark = row.text.find('@');
        ASSERT_NE(mark, std::string::npos) << row.text;
        const std::string before = row.text.substr(0, mark), text = before + row.text.substr(mark + 1);
        const size_t line = size_t(std::count(before.begin(), before.end(), '\n')) + 1;
        const size_t column = mark - (line == 1 ? 0 : before.rfind('\n') + 1) + 1;
        const std::string message = refusal(folder, text);
        EXPECT_TRUE(message.starts_with(fmt::format("scene.toml:{}:{}: ", line, column))) << text << "\n-> " << message;
        EXPECT_NE(message.find(row.field), std::string::npos) << text << "\n-> " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

TEST(SceneToml, RefusesWhatHasNoSinglePlace) {
    TemporaryFolder folder;
    EXPECT_NE(refusal(folder, "").find("nothing to draw"), std::string::npos);
    EXPECT_NE(refusal(folder, kTriangle + "[[object]]\nname = 'group'\n").find("nothing to draw"), std::string::npos);
    EXPECT_NE(refusal(folder, "[material]\nname = 'm'\n" + kTriangle).find("write [[material]]"), std::string::npos);
    // Group scales multiply; the object that is drawn is named.
    EXPECT_NE(refusal(folder, kTriangle + "[[object]]\ntransform = [{ scale = 1e30 }]\n[[object.child]]\nmesh = 'triangle'\n"
                                          "transform = [{ scale = 1e30 }]\n")
                  .find("world matrix has entries above 2^100"),
              std::string::npos);
}

// 5.2 of the notes: a scale of 0 flattens. What has no surface left is said.
TEST(SceneToml, AMatrixWithoutInverseIsTaken) {
    TemporaryFolder folder;
    for (const char* transform : {"{ scale = [1, 1, 0] }", "{ scale = [1, 0, 1] }", "{ scale = 0 }",
                                  "{ matrix = [1,0,0,0, 0,1,0,0, 1,1,0,0, 0,0,0,1] }", "{ scale = [1e-20, 1e-20, 1] }"})
        EXPECT_EQ(refusal(folder, kObject + "transform = [" + transform + "]\n"), "") << transform;
}

TEST(SceneToml, DepthIsBoundedEverywhere) {
    TemporaryFolder folder;
    std::string keys, tables, arrays(100000, '['), chain = kTriangle;
    for (int i = 0; i < 100000; ++i) keys += "a.";
    EXPECT_NE(refusal(folder, keys + "a = 1").find("more than 64 parts"), std::string::npos);
    EXPECT_NE(refusal(folder, "[" + keys + "a]").find("more than 64 parts"), std::string::npos);
    EXPECT_NE(refusal(folder, "x = \"\"\"\n\\\" ' # \"\"\"\n" + keys + "a = 1").find("scene.toml:3:"), std::string::npos);
    EXPECT_NE(refusal(folder, "a = " + arrays).find("TOML"), std::string::npos);
    std::string header = "object";
    for (int i = 0; i < 66; ++i) {
        tables += "[[" + header + "]]\n";
        header += ".child";
    }
    EXPECT_NE(refusal(folder, kTriangle + tables), "");
    for (int i = 0; i < 5000; ++i) chain += fmt::format("[[object]]\nname = 'o{}'\nparent = 'o{}'\n", i, i + 1);
    chain += "[[object]]\nname = 'o5000'\nmesh = 'triangle'\n";
    EXPECT_NE(refusal(folder, chain).find("nested deeper than 64"), std::string::npos);
    // Dots that are no key.
    EXPECT_NO_THROW(load("# " + keys + "\n" + kTriangle + "[[object]]\nmesh = 'triangle'\nname = '" + keys.substr(0, 300) + "'\n"));
}

TEST(SceneToml, RefusesWhatIsNoFile) {
    TemporaryFolder folder;
    EXPECT_THROW(readSceneToml(folder.path() / "missing.toml", {}), Error);
    EXPECT_THROW(readSceneToml(folder.path(), {}), Error);
    EXPECT_THROW(readSceneToml("/dev/zero", {}), Error);
}

TEST(SceneToml, CutAtEveryByteItLoadsOrIsRefused) {
    std::ifstream stream(PLUMB_SOURCE_DIR "/scenes/pyramid.toml");
    std::stringstream whole;
    whole << stream.rdbuf();
    const std::string text = whole.str();
    TemporaryFolder folder;
    for (size_t bytes = 0; bytes < text.size(); bytes += 3) {
        const std::string message = refusal(folder, text.substr(0, bytes));
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        if (!message.empty()) {
            EXPECT_TRUE(message.starts_with("scene.toml:")) << message;
        }
    }
}

// Each block of docs/scene-format.md that opens with ```toml. The first is the preamble: it is put behind every block
// that has no [[mesh]] of its own.
std::vector<std::string> documentedBlocks() {
    std::ifstream stream(PLUMB_SOURCE_DIR "/docs/scene-format.md");
    std::vector<std::string> blocks;
    bool inside = false;
    for (std::string line; std::getline(stream, line);) {
        if (!inside && line == "```toml") {
            blocks.emplace_back();
            inside = true;
        } else if (inside && line == "```") {
            inside = false;
        } else if (inside) {
            blocks.back() += line + "\n";
        }
    }
    EXPECT_FALSE(inside) << "a block does not end";
    return blocks;
}

TEST(SceneToml, EveryExampleOfTheDocumentationLoads) {
    const std::vector<std::string> blocks = documentedBlocks();
    ASSERT_GE(blocks.size(), 10u);
    TemporaryFolder folder;
    folder.write("models/triangle.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    for (const std::string& block : blocks) {
        const std::string text = block.find("[[mesh]]") == block.npos ? block + "\n" + blocks[0] : block;
        EXPECT_EQ(refusal(folder, text), "") << text;
    }
}

TEST(SceneToml, EveryKeyHasAnExample) {
    std::string all;
    for (const std::string& block : documentedBlocks()) all += "\n" + block;
    for (const char* key : {"handedness",  "up",        "ambient",   "background", "encoding", "shading",        "size",       "cull",
                            "distance",    "eye",       "at",        "fov",        "near",     "name",           "diffuse",    "specular",
                            "emission",    "shininess", "opacity",   "ior",        "type",     "direction",      "position",   "intensity",
                            "attenuation", "file",      "vertices",  "faces",      "material", "face_materials", "crease",     "mesh",
                            "transform",   "parent",    "translate", "rotate_x",   "rotate_y", "rotate_z",       "rotate",     "axis",
                            "degrees",     "through",   "scale",     "matrix",     "about",    "max_depth",      "min_weight", "sampling",
                            "jitter",      "seed",      "levels",    "shadows",    "density",  "reflect",        "transmit",   "local",
                            "centre",      "radius",    "point",     "normal",     "u",        "u_range",        "v_range",    "two_sided",
                            "square",      "mirrored",  "board"})
        EXPECT_TRUE(all.find(fmt::format("\n{} =", key)) != all.npos || all.find(fmt::format(" {} =", key)) != all.npos) << key;
    EXPECT_NE(all.find("[[object.child]]"), all.npos);
}

TEST(SceneToml, ChoicesOfRaysAreKept) {
    TemporaryFolder folder;
    folder.write("s.toml",
                 "encoding = 'linear'\nsampling = 'adaptive'\njitter = { reflect = 0.25, shadow = 0.5 }\nseed = 4294967295\nlevels = "
                 "'cut'\n[[sphere]]\ncentre = [0,0,0]\nradius = 1\n");
    const Scene s = readSceneToml(folder.path() / "s.toml", {});
    EXPECT_EQ(s.sampling, Sampling::adaptive);
    EXPECT_EQ(s.jitterReflect, 0.25);
    EXPECT_FALSE(s.jitterRefract);
    EXPECT_EQ(s.jitterShadow, 0.5);
    EXPECT_EQ(s.seed, 0xffffffffu);
    EXPECT_EQ(s.cutLevels, true);
    folder.write("t.toml", "[[sphere]]\ncentre = [0,0,0]\nradius = 1\n");
    const Scene t = readSceneToml(folder.path() / "t.toml", {});
    EXPECT_FALSE(t.sampling || t.jitterReflect || t.jitterRefract || t.jitterShadow || t.seed || t.cutLevels);
}

TEST(SceneToml, EveryCommittedSceneLoads) {
    int scenes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(PLUMB_SOURCE_DIR "/scenes")) {
        if (entry.path().extension() != ".toml") continue;
        ++scenes;
        try {
            const Scene scene = readSceneToml(entry.path(), {});
            EXPECT_GT(scene.objects.size() + scene.spheres.size() + scene.planes.size(), 0u);
            EXPECT_TRUE(scene.warnings.empty()) << entry.path() << ": " << (scene.warnings.empty() ? "" : scene.warnings[0]);
            EXPECT_TRUE(scene.ignored.empty()) << entry.path() << ": " << (scene.ignored.empty() ? "" : scene.ignored[0]);
        } catch (const Error& error) {
            ADD_FAILURE() << error.what();
        }
    }
    EXPECT_GE(scenes, 2);
}

}  // namespace
}  // namespace plumb
