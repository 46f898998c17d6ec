// SPDX-License-Identifier: MIT
// Meshes far from 0 are drawn as their near twins are, by every picture and on both sides; what float32 cannot hold is told. Measured against the file's
// own binary64 numbers through the object's matrix, which the truth composes by itself.
#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/scene/load.h"
#include "pipeline/truth/frame_error.h"
#include "tests/support/device_fixture.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kMostWrongTimes = 2;      // of the wrong faces of the same view of the mesh about 0
constexpr double kLeastAlikeShare = 0.99;  // of covered pixels, of a far mesh and its near twin

constexpr std::array<const char*, 5> kMeshes{"suzanne/suzanne.obj", "procedural/torus.obj", "procedural/gear.obj", "apple/apple.ply",
                                             "procedural/menger.off"};
constexpr std::array<double, 5> kFovs{0.1, 1, 10, 45, 90};

PolygonMesh read(const std::string& name) {
    const std::string path = std::string(PLUMB_SOURCE_DIR) + "/scenes/" + name;
    return path.ends_with(".obj") ? readObj(path, {}) : path.ends_with(".ply") ? readPly(path, {}) : readOff(path, {});
}

// The mesh with `offset` added to what its file says, and the object moved by `by` besides.
Scene sceneOf(const PolygonMesh& source, const dvec3& offset, const dvec3& by = dvec3(0)) {
    PolygonMesh mesh = source;
    for (size_t i = 0; i < source.positions.size(); ++i) mesh.positions.set(i, source.positions[i] + offset);
    Scene scene;
    scene.materials.emplace_back();
    Object object;
    object.name = source.name;
    object.worldFromObject[3] = glm::dvec4(by, 1);
    scene.meshes.push_back(finishMesh(std::move(mesh), scene.materials, 0, {}));
    scene.objects.push_back(object);
    return scene;
}

RenderRequest requestOf(uint32_t width, uint32_t height) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.planes = kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
    return r;
}

// The framed camera, as near or as far as its field of view needs for the same size in the picture.
void lookWith(Scene& scene, double fovDegrees, const dvec3& offset) {
    Camera& c = *scene.camera;
    const double distance = c.focusDistance * std::tan(c.fovYDegrees * kPi / 360) / std::tan(fovDegrees * kPi / 360);
    c.eye += c.forward * (c.focusDistance - distance) + offset;
    c.focusDistance = distance;
    c.fovYDegrees = fovDegrees;
}

uint64_t wrongFaces(const Scene& scene, const RenderRequest& request) {
    return errorOf(renderCpu(scene, request).frame, truthOf(scene, request), Encoding::srgb, false).wrongPrimitive;
}

class Far : public test::DeviceTest {};

// Offsets of 10^0 to 10^7 in x, fields of view of 0.1 to 90 degrees, five meshes: 200 views.
TEST_F(Far, NoOffsetAndNoFieldOfViewMakesMoreFacesWrongInSilence) {
    const RenderRequest request = requestOf(160, 120);
    int cases = 0, warned = 0;
    for (const char* name : kMeshes) {
        const PolygonMesh mesh = read(name);
        Scene near = sceneOf(mesh, dvec3(0));
        completeScene(near, {request.width, request.height}, "", true);
        for (const double fov : kFovs) {
            Scene base = near;
            lookWith(base, fov, dvec3(0));
            const uint64_t wrong = wrongFaces(base, request);
            for (int k = 0; k <= 7; ++k) {
                const dvec3 offset(std::pow(10.0, k), 0, 0);
                Scene away = sceneOf(mesh, offset);
                away.camera = near.camera;
                away.lights = near.lights;
                away.ambient = near.ambient;
                lookWith(away, fov, offset);
                ++cases;
                if (!vertexErrors(away, request).empty()) {
                    ++warned;
                    continue;
                }
                EXPECT_LE(double(wrongFaces(away, request)), kMostWrongTimes * double(wrong))
                    << fmt::format("{} + 10^{} at {} degrees", name, k, fov);
            }
        }
    }
    EXPECT_EQ(cases, 200);
    EXPECT_EQ(warned, 0) << "these meshes need no warning at any offset";
}

struct Form {
    const char* name;
    Shading shading;
    Fill fill;
    Precision precision;
    WireView wire = WireView::seeThrough;
};
constexpr Form kForms[] = {{"phong", Shading::phong, Fill::exact, Precision::fp32},
                           {"flat", Shading::flat, Fill::exact, Precision::fp32},
                           {"gouraud", Shading::gouraud, Fill::exact, Precision::fp32},
                           {"phong in binary64", Shading::phong, Fill::exact, Precision::fp64},
                           {"phong in block integers", Shading::phong, Fill::exact, Precision::blockInteger},
                           {"rays", Shading::ray, Fill::exact, Precision::fp32},
                           {"notes, phong", Shading::phong, Fill::notes, Precision::fp32},
                           {"notes, flat", Shading::flat, Fill::notes, Precision::fp32},
                           {"wire", Shading::wire, Fill::exact, Precision::fp32},
                           {"wire, culled", Shading::wire, Fill::exact, Precision::fp32, WireView::culled},
                           {"wire, solid", Shading::wire, Fill::exact, Precision::fp32, WireView::solid}};

RenderRequest requestOf(const Form& form, uint32_t width, uint32_t height) {
    RenderRequest r = requestOf(width, height);
    r.shading = form.shading;
    r.fill = form.fill;
    r.wire = form.wire;
    if (form.shading != Shading::wire)
        r.trade.precision = form.precision;
    else
        r.planes = kPlaneColour;
    return r;
}

// The scene of a mesh at a map's coordinates, by itself or under a matrix that turns, mirrors and brings it back; lamps at points.
struct Twins {
    Scene near, far;
};
Twins twinsOf(const PolygonMesh& mesh, bool broughtBack) {
    const dvec3 offset(412345.67, 5287654.32, -4412.44);
    Twins t{sceneOf(mesh, dvec3(0)), sceneOf(mesh, offset)};
    if (broughtBack) {
        glm::dmat4 turn(1);
        turn[0] = {-0.6, 0.8, 0, 0};
        turn[1] = {0.8, 0.6, 0, 0};  // a mirror
        turn[2] = {0, 0, 1.5, 0};
        t.near.objects[0].worldFromObject = turn;
        turn[3] = glm::dvec4(-(glm::dmat3(turn) * offset), 1);
        t.far.objects[0].worldFromObject = turn;
    }
    completeScene(t.near, {240, 200}, "", true);
    Light lamp;
    lamp.directional = false;
    lamp.position = t.near.camera->eye + t.near.camera->up * 2.0;
    lamp.attenuation = Attenuation::inverse;
    t.near.lights.push_back(lamp);
    t.far.camera = t.near.camera;
    t.far.lights = t.near.lights;
    t.far.ambient = t.near.ambient;
    if (!broughtBack) {
        t.far.camera->eye += offset;
        t.far.lights.back().position += offset;
    }
    return t;
}

// Pixels that differ by more than one code.
uint64_t differing(const Frame& a, const Frame& b) {
    uint64_t count = 0;
    for (size_t i = 0; i < a.rgba.size(); ++i) {
        int most = 0;
        for (int shift = 0; shift < 24; shift += 8)
            most = std::max(most, std::abs(int(a.rgba[i] >> shift & 255) - int(b.rgba[i] >> shift & 255)));
        count += most > 1;
    }
    return count;
}

TEST_F(Far, EveryPictureIsThatOfTheNearTwin) {
    for (const char* name : {"suzanne/suzanne.obj", "procedural/gear.obj"}) {
        const PolygonMesh mesh = read(name);
        for (const bool broughtBack : {false, true}) {
            const Twins t = twinsOf(mesh, broughtBack);
            ASSERT_NE(t.far.meshes[0].origin, dvec3(0));
            for (const Form& form : kForms) {
                const RenderRequest request = requestOf(form, 240, 200);
                const Frame a = renderCpu(t.near, request).frame, b = renderCpu(t.far, request).frame;
                ASSERT_GT(a.coveredPixels, 1000u) << form.name;
                double allowed = (1 - kLeastAlikeShare) * double(a.coveredPixels);
                // Polygons of the notes' fill paint the pixels of an edge that they share, and the last bit of Z says whose colour stays: as many pixels
                // change when the near mesh moves by half a unit of float32.
                if (form.fill == Fill::notes) {
                    Twins moved = twinsOf(mesh, broughtBack);
                    moved.near.objects[0].worldFromObject[3].x += 0x1p-25;
                    allowed = std::max(allowed, kMostWrongTimes * double(differing(a, renderCpu(moved.near, request).frame)));
                    EXPECT_LT(allowed, 0.1 * double(a.coveredPixels)) << "still the same picture";
                }
                EXPECT_LE(double(differing(a, b)), allowed) << name << ", " << form.name << (broughtBack ? ", brought back" : "");
            }
        }
    }
}

TEST_F(Far, DeviceAndTwinDrawTheSame) {
    const PolygonMesh mesh = read("suzanne/suzanne.obj");
    for (const bool broughtBack : {false, true}) {
        const Twins t = twinsOf(mesh, broughtBack);
        for (const Form& form : kForms) {
            const VerifyReport report = verifyRender(device(), t.far, requestOf(form, 96, 80));
            EXPECT_TRUE(report.equal) << form.name << ": " << (report.mismatches.empty() ? "" : report.mismatches[0].what);
        }
    }
}

// The camera that frames a far mesh is the near one, moved.
TEST_F(Far, FramingMovesWithTheMesh) {
    const PolygonMesh mesh = read("suzanne/suzanne.obj");
    const dvec3 offset(412345.67, 5287654.32, -4412.44);
    Scene near = sceneOf(mesh, dvec3(0)), far = sceneOf(mesh, offset);
    for (Scene* s : {&near, &far}) completeScene(*s, {240, 200}, "", true);
    // A few sums of binary64 numbers of the offset's size, and float32's rounding of either mesh, over the slope at which the eye backs off.
    const double size = glm::length(near.meshes[0].statedMax - near.meshes[0].statedMin);
    const double slack = (64 * 0x1p-53 * glm::length(offset) + 4 * 0x1p-24 * size) / std::tan(near.camera->fovYDegrees * kPi / 360);
    EXPECT_LT(glm::length(far.camera->eye - offset - near.camera->eye), slack);
    EXPECT_LT(std::abs(far.camera->focusDistance - near.camera->focusDistance), slack);
}

// The truth starts from the file's numbers: it sees what a mesh loses, and finds nothing where nothing is lost.
TEST_F(Far, TheErrorIsMeasuredAgainstTheFilesNumbers) {
    const PolygonMesh mesh = read("suzanne/suzanne.obj");
    const RenderRequest request = requestOf(160, 120);
    Scene scene = sceneOf(mesh, dvec3(1e6, 0, 0));
    completeScene(scene, {request.width, request.height}, "", true);
    const uint64_t right = wrongFaces(scene, request);
    // As it was: every vertex rounded where it lies, about 0.
    Scene rounded = scene;
    TriangleMesh& m = rounded.meshes[0];
    ASSERT_FALSE(m.stated.empty());
    for (size_t v = 0; v < m.positions.size(); ++v) m.positions[v] = glm::vec3(glm::vec3(m.stated[v]) - glm::vec3(m.origin));
    EXPECT_GT(wrongFaces(rounded, request), 100 * std::max<uint64_t>(1, right)) << "a wrong picture is not called right";
    Scene silent = rounded;
    silent.meshes[0].stated.clear();
    EXPECT_LT(wrongFaces(silent, request), 20 * std::max<uint64_t>(1, right)) << "what is measured above is what the file says";
}

// The truth of rays starts from the file's numbers, too.
TEST_F(Far, TheRaysTruthStartsFromTheFilesNumbers) {
    RenderRequest request = requestOf(80, 60);
    request.shading = Shading::ray;
    Scene scene = sceneOf(read("procedural/gear.obj"), dvec3(1e6, 0, 0));
    completeScene(scene, {request.width, request.height}, "", true);
    const uint64_t right = wrongFaces(scene, request);
    TriangleMesh& m = scene.meshes[0];
    ASSERT_FALSE(m.stated.empty());
    for (dvec3& p : m.stated) p.y += 0.25;
    EXPECT_GT(wrongFaces(scene, request), 10 * std::max<uint64_t>(1, right));
}

// --- what is told -----------------------------------------------------------------------------------------------------------------------

// A strip of `cells` squares of side 1 in the plane z = 0, from x = 0; one vertex far away makes the mesh as long as that.
Scene strip(double farthest, double eyeAt) {
    PolygonMesh mesh;
    mesh.name = "strip";
    mesh.faceFirst.push_back(0);
    const auto quad = [&](double x, double width) {
        const uint32_t first = uint32_t(mesh.positions.size());
        for (const auto& [dx, dy] : {std::pair(0.0, 0.0), std::pair(width, 0.0), std::pair(width, 1.0), std::pair(0.0, 1.0)})
            mesh.positions.push_back({x + dx + 0.1, dy, 0.0});
        for (uint32_t i = 0; i < 4; ++i) mesh.corners.push_back({first + i});
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(kNone);
    };
    quad(-farthest, 1);
    quad(farthest, 1);
    for (int i = -4; i < 4; ++i) quad(eyeAt + i, 1);
    Scene scene;
    scene.materials.emplace_back();
    Object object;
    object.name = "strip";
    scene.meshes.push_back(finishMesh(std::move(mesh), scene.materials, 0, {}));
    scene.objects.push_back(object);
    Camera camera;
    camera.eye = {eyeAt, 0.5, 4};
    camera.focusDistance = 4;
    scene.camera = camera;
    return scene;
}

TEST_F(Far, AMeshTooLargeForItsDetailIsTold) {
    const RenderRequest request = requestOf(160, 120);
    for (const double farthest : {1e2, 1e4, 1e7, 1e9}) {
        const Scene scene = strip(farthest, 0.9 * farthest);
        ASSERT_EQ(scene.meshes[0].origin, dvec3(0)) << "it lies about 0";
        const std::vector<VertexError> told = vertexErrors(scene, request);
        EXPECT_EQ(told.size(), farthest > 1e6 ? 1u : 0u) << farthest;
        if (told.empty()) continue;
        EXPECT_NE(sentenceOf(scene, told[0]).find("object 'strip'"), std::string::npos);
        EXPECT_NE(sentenceOf(scene, told[0]).find("px"), std::string::npos);
        // The part about 0 of the same mesh is drawn as it should be, and nothing is told of it.
        EXPECT_TRUE(vertexErrors(strip(farthest, 0), request).empty()) << farthest;
    }
}

// Positions of the object's vertices in pixels; clipped vertices count as off the screen.
std::vector<glm::dvec2> placesOf(const Scene& scene, const RenderRequest& request) {
    const Prepared p = prepare(scene, request);
    const TwinGeometry g = twinGeometry(p.list, p.choices, false, 1);
    std::vector<glm::dvec2> places;
    for (size_t v = 0; v < p.list.positions.size(); ++v)
        places.push_back(g.screen[v].outcode == 0 ? glm::dvec2(g.screen[v].x, g.screen[v].y) / 256.0 : glm::dvec2(1e30));
    return places;
}

// The bound holds: no vertex of the view lies further from where the file puts it. In long double, by the composite that the truth takes.
TEST_F(Far, NoVertexIsFurtherOffThanTheBoundSays) {
    double tightest = 0;
    for (const double farthest : {10.0, 1e3, 1e5, 1e7})
        for (const Precision precision : {Precision::fp32, Precision::blockInteger, Precision::fp64}) {
            Scene scene = strip(farthest, 0.77 * farthest);
            scene.objects[0].worldFromObject[0] *= 1.1;  // no float32
            scene.camera->eye.x *= 1.1;
            RenderRequest request = requestOf(160, 120);
            request.trade.precision = precision;
            const double bound = vertexErrorOf(scene, request, 0).pixels;
            const double snap = 0.5 / 256;
            const std::vector<glm::dvec2> drawn = placesOf(scene, request);
            const TriangleMesh& mesh = scene.meshes[0];
            const Camera& c = *scene.camera;
            const long double focal = request.height / 2.0L / std::tan(static_cast<long double>(c.fovYDegrees) * kPi / 360);
            for (size_t v = 0; v < mesh.positions.size(); ++v) {
                long double p[3];
                for (int j = 0; j < 3; ++j) {
                    p[j] = static_cast<long double>(scene.objects[0].worldFromObject[3][j]) - c.eye[j];
                    for (int k = 0; k < 3; ++k)
                        p[j] += static_cast<long double>(scene.objects[0].worldFromObject[k][j]) * mesh.statedAt(v)[k];
                }
                const long double x = focal * p[0] / -p[2] + request.width / 2.0L, y = -focal * p[1] / -p[2] + request.height / 2.0L;
                if (x < 0 || y < 0 || x > request.width || y > request.height) continue;
                const double off = double(std::max(std::abs(x - drawn[v].x), std::abs(y - drawn[v].y)));
                EXPECT_LE(off, bound + snap) << farthest << " " << int(precision) << " vertex " << v;
                tightest = std::max(tightest, (off - snap) / bound);
            }
        }
    EXPECT_GT(tightest, 0.01) << "a bound that is a hundred times too large warns of what nobody sees";
}

}  // namespace
}  // namespace plumb
