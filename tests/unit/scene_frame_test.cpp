// SPDX-License-Identifier: MIT
// A bare mesh is framed and lit: the object covers 35 to 80 % of the shorter side, touches no border, and less than 1 %
// of its pixels are black or clipped. Shown on every mesh of the repository, from projected vertices and from a picture.
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "tests/support/plain_picture.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
namespace fs = std::filesystem;

constexpr double kPi = 3.14159265358979323846;

std::vector<fs::path> committedMeshes() {
    std::vector<fs::path> out;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PLUMB_SOURCE_DIR) / "scenes"))
        if (const std::string extension = entry.path().extension().string();
            extension == ".obj" || extension == ".ply" || extension == ".stl" || extension == ".off")
            out.push_back(entry.path());
    std::sort(out.begin(), out.end());
    return out;
}

struct Extent {
    dvec2 least{1e300}, most{-1e300};  // pixels
    double nearest = 1e300;            // planar depth
};

Extent extentOf(const Scene& scene, double width, double height) {
    const Camera& camera = *scene.camera;
    const double focal = height / 2 / std::tan(camera.fovYDegrees * kPi / 360);
    Extent extent;
    for (const Object& object : scene.objects)
        for (const vec3& position : scene.meshes[object.mesh].positions) {
            const dvec3 p = dvec3(worldFromMesh(scene, object) * glm::dvec4(position, 1)) - camera.eye;
            const double z = glm::dot(p, camera.forward);
            extent.nearest = std::min(extent.nearest, z);
            const dvec2 at(width / 2 + focal * glm::dot(p, camera.right) / z, height / 2 - focal * glm::dot(p, camera.up) / z);
            extent.least = glm::min(extent.least, at);
            extent.most = glm::max(extent.most, at);
        }
    return extent;
}

void expectOrthonormal(const Camera& camera, bool leftHanded) {
    EXPECT_NEAR(glm::length(camera.right), 1, 1e-12);
    EXPECT_NEAR(glm::length(camera.up), 1, 1e-12);
    EXPECT_NEAR(glm::length(camera.forward), 1, 1e-12);
    EXPECT_NEAR(glm::dot(camera.up, camera.forward), 0, 1e-12);
    EXPECT_NEAR(glm::length(glm::cross(camera.right, camera.up) + (leftHanded ? -1.0 : 1.0) * camera.forward), 0, 1e-12);
}

void expectFramed(Scene& scene, glm::uvec2 size, const std::string& view, const std::string& what) {
    scene.camera.reset();
    completeScene(scene, size, view, true);
    expectOrthonormal(*scene.camera, scene.leftHanded);
    const Extent extent = extentOf(scene, size.x, size.y);
    const double shorter = std::min(size.x, size.y);
    const dvec2 share = (extent.most - extent.least) / shorter;
    EXPECT_GE(std::max(share.x, share.y), 0.35) << what;
    EXPECT_LE(std::max(share.x, share.y), 0.80) << what;
    EXPECT_GT(extent.least.x, 0) << what;
    EXPECT_GT(extent.least.y, 0) << what;
    EXPECT_LT(extent.most.x, size.x) << what;
    EXPECT_LT(extent.most.y, size.y) << what;
    EXPECT_EQ(scene.camera->near, 0) << what;
    EXPECT_GT(extent.nearest, scene.camera->focusDistance / 1024) << what << ": nothing is nearer than the near plane that is derived";
}

const glm::uvec2 kSizes[] = {{640, 480}, {1920, 1080}, {333, 211}, {512, 512}, {480, 640}, {300, 2000}, {4000, 100}};

TEST(SceneFrame, EveryCommittedMeshIsFramedAtEverySizeAndView) {
    const std::vector<fs::path> meshes = committedMeshes();
    ASSERT_GE(meshes.size(), 11u);
    for (const fs::path& path : meshes) {
        Scene scene = loadScene({path}, {});
        for (const glm::uvec2 size : kSizes)
            for (const char* view : {"", "front", "back", "left", "right", "top", "bottom", "iso", "-40,60", "725,-90"})
                expectFramed(scene, size, view, fmt::format("{} at {}x{} view '{}'", path.filename().string(), size.x, size.y, view));
    }
}

// Pictures instead of projections: how much they show, and how bright they are.
TEST(SceneFrame, EveryCommittedMeshFillsItsPictureAndNeitherClipsNorIsCrushed) {
    for (const fs::path& path : committedMeshes()) {
        Scene scene = loadScene({path}, {});
        constexpr int kWidth = 320, kHeight = 240;
        completeScene(scene, {kWidth, kHeight}, "", true);
        const test::PlainPicture picture = test::plainPicture(scene, kWidth, kHeight);
        int left = kWidth, right = -1, top = kHeight, bottom = -1;
        int64_t drawn = 0, black = 0, clipped = 0;
        double mean = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                if (!picture.drawn(x, y)) continue;
                left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
                const dvec3 c = picture.linear[size_t(y) * kWidth + size_t(x)];
                const glm::ivec3 code(test::srgb8(c.x), test::srgb8(c.y), test::srgb8(c.z));
                ++drawn;
                black += code == glm::ivec3(0);
                clipped += code.x == 255 || code.y == 255 || code.z == 255;
                mean += (code.x + code.y + code.z) / 3.0;
            }
        const double cover = double(std::max(right - left, bottom - top) + 1) / std::min(kWidth, kHeight);
        const std::string what = fmt::format("{}: {} pixels, {} black, {} clipped, mean {:.0f}, cover {:.2f}", path.filename().string(),
                                             drawn, black, clipped, mean / double(drawn), cover);
        RecordProperty(path.filename().string(), what);
        EXPECT_GE(cover, 0.35) << what;
        EXPECT_LE(cover, 0.80) << what;
        EXPECT_GT(std::min({left, top, kWidth - 1 - right, kHeight - 1 - bottom}), 0) << what;
        EXPECT_LT(double(black + clipped), 0.01 * double(drawn)) << what;
        EXPECT_GT(mean / double(drawn), 60) << what;
        EXPECT_LT(mean / double(drawn), 220) << what;
    }
}

TEST(SceneFrame, DefaultLightsClipNoUsualMaterialAndLeaveNoVisibleSurfaceDark) {
    Scene scene;
    completeScene(scene, {640, 480}, "", true);
    ASSERT_EQ(scene.lights.size(), 2u);
    const Camera& camera = *scene.camera;
    const dvec3 back = -camera.forward;
    Material white;
    white.ambient = white.diffuse = white.specular = vec3(1);
    Material matte;
    matte.ambient = vec3(0);
    matte.diffuse = vec3(1);
    for (const float shininess : {1.0f, 2.0f, 8.0f, 16.0f, 64.0f, 1000.0f}) {
        white.shininess = shininess;
        double brightest = 0, darkest = 1;
        for (int i = 0; i < 400; ++i)
            for (int j = 0; j < 400; ++j) {  // normals over the half sphere toward the eye
                const double a = 2 * kPi * i / 400, z = (j + 0.5) / 400;
                const double r = std::sqrt(1 - z * z);
                const dvec3 n = r * std::cos(a) * camera.right + r * std::sin(a) * camera.up + z * back;
                brightest = std::max(brightest, test::plainPhong(scene, white, n, back).x);
                if (z > 0.02) darkest = std::min(darkest, test::plainPhong(scene, matte, n, back).x);
            }
        EXPECT_GT(test::srgb8(brightest), 230) << "there is light to spare";
        EXPECT_LT(test::srgb8(brightest), 255) << "Ns " << shininess << ": " << brightest;
        EXPECT_GT(test::srgb8(darkest), 0) << darkest;
    }
}

TEST(SceneFrame, TheSidesOfABoxAreToldApartByTheirBrightness) {
    Scene scene;
    completeScene(scene, {640, 480}, "", true);
    Material matte;
    matte.ambient = vec3(0);
    matte.diffuse = vec3(1);
    const auto grey = [&](const dvec3& n) { return test::plainPhong(scene, matte, n, -scene.camera->forward).x; };
    EXPECT_NEAR(grey({0, 1, 0}), 0.37, 0.01);
    EXPECT_NEAR(grey({0, 0, 1}), 0.27, 0.01);
    EXPECT_NEAR(grey({1, 0, 0}), 0.08, 0.01);
}

TEST(SceneFrame, ViewsLookFromWhereTheySay) {
    Scene scene = loadScene({fs::path(PLUMB_SOURCE_DIR) / "scenes/procedural/icosphere.ply"}, {});
    const std::pair<const char*, dvec3> rows[] = {{"front", {0, 0, 1}},
                                                  {"back", {0, 0, -1}},
                                                  {"right", {1, 0, 0}},
                                                  {"left", {-1, 0, 0}},
                                                  {"top", {0, 1, 0}},
                                                  {"bottom", {0, -1, 0}},
                                                  {"90,0", {1, 0, 0}},
                                                  {"0,90", {0, 1, 0}},
                                                  {"iso", glm::normalize(dvec3(1, 1, 1))},
                                                  {"", {0.469846310392954, 0.342020143325669, 0.813797681349374}}};
    for (const auto& [view, direction] : rows) {
        const Camera camera = frameCamera(scene, 1, view);
        // The vertices of the sphere are not quite symmetric about the direction, and the eye is fitted to them.
        EXPECT_NEAR(glm::length(glm::normalize(camera.eye) - direction), 0, 1e-3) << view;
        EXPECT_NEAR(glm::length(camera.forward + direction), 0, 1e-12) << view;
        EXPECT_NEAR(camera.focusDistance, glm::length(camera.eye), 1e-3) << view;
    }
    EXPECT_GT(frameCamera(scene, 1, "top").up.z, -1.5);
    EXPECT_NEAR(frameCamera(scene, 1, "top").up.z, -1, 1e-12) << "the front is below in the view from above";
    for (const char* bad : {"side", "1", "1,", ",1", "1,2,3", "nan,0", "0,91", "1;2", "inf,0"}) {
        try {
            frameCamera(scene, 1, bad);
            ADD_FAILURE() << bad;
        } catch (const Error& error) {
            EXPECT_EQ(error.exit(), Exit::usage) << bad;
        }
    }
}

TEST(SceneFrame, AnyAxisMayBeUpAndTheWorldLeftHanded) {
    Scene scene = loadScene({fs::path(PLUMB_SOURCE_DIR) / "scenes/suzanne/suzanne.obj"}, {});
    for (const bool leftHanded : {false, true})
        for (const dvec3 up : {dvec3(0, 1, 0), dvec3(0, 0, 1), dvec3(1, 0, 0), dvec3(0, -1, 0), dvec3(0, 0, -2), dvec3(3, 4, 5)}) {
            scene.up = up;
            scene.leftHanded = leftHanded;
            expectFramed(scene, {640, 480}, "", fmt::format("up {} {} {} left {}", up.x, up.y, up.z, leftHanded));
            EXPECT_GT(glm::dot(scene.camera->up, up), 0);
            const Camera front = frameCamera(scene, 1, "front");
            EXPECT_NEAR(glm::length(front.up - glm::normalize(up)), 0, 1e-12);
        }
    scene.up = {0, 0, 1};
    scene.leftHanded = false;
    EXPECT_NEAR(glm::length(frameCamera(scene, 1, "front").forward - dvec3(0, 1, 0)), 0, 1e-12) << "+Z up: the front is -Y";
    scene.up = {0, 1, 0};
    scene.leftHanded = true;
    EXPECT_NEAR(glm::length(frameCamera(scene, 1, "front").forward - dvec3(0, 0, 1)), 0, 1e-12)
        << "left-handed: the notes' viewer at (0, 0, -d)";
}

TEST(SceneFrame, ObjectsFarOutLargeSmallFlatOrSinglePointsAreFramed) {
    const test::TemporaryFolder folder;
    const auto load = [&](const std::string& text) { return loadScene({folder.write("m.obj", text + "f 1 2 3\n")}, {}); };
    for (const double scale : {1e-29, 1e-6, 1.0, 1e6, 1e29}) {
        Scene scene = load(fmt::format("v 0 0 0\nv {0} 0 0\nv 0 {0} {0}\n", scale));
        expectFramed(scene, {640, 480}, "", fmt::format("scale {}", scale));
    }
    Scene far = load("v 1e6 1e6 1e6\nv 1000001 1e6 1e6\nv 1e6 1000001 1e6\n");
    expectFramed(far, {640, 480}, "", "far from the origin");
    Scene flat = load("v 0 0 0\nv 1 0 0\nv 0 0 1\n");
    expectFramed(flat, {640, 480}, "front", "seen on its edge");
    Scene point = load("v 3 4 5\nv 3 4 5\nv 3 4 5\n");
    completeScene(point, {640, 480}, "", true);
    EXPECT_EQ(point.camera->focusDistance, 1.0);
    EXPECT_NEAR(glm::length(point.camera->eye + point.camera->forward - dvec3(3, 4, 5)), 0, 1e-12);
    Scene needle = load("v 0 0 0\nv 0 0 1\nv 0 0 2\n");
    completeScene(needle, {640, 480}, "front", true);
    EXPECT_GT(extentOf(needle, 640, 480).nearest, 0);
    Scene nothing;
    completeScene(nothing, {640, 480}, "", true);
    EXPECT_TRUE(nothing.camera.has_value());
}

TEST(SceneFrame, WhatTheSceneStatesIsKept) {
    Scene scene = loadScene({fs::path(PLUMB_SOURCE_DIR) / "scenes/apple/apple.ply"}, {});
    scene.camera = Camera{};
    scene.lights.resize(1);
    completeScene(scene, {640, 480}, "", true);
    EXPECT_EQ(scene.camera->eye, dvec3(0));
    EXPECT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.ambient, vec3(1));
    completeScene(scene, {640, 480}, "front", true);
    EXPECT_NE(scene.camera->eye, dvec3(0)) << "--view overrules the file's camera";
    Scene dark = loadScene({fs::path(PLUMB_SOURCE_DIR) / "scenes/apple/apple.ply"}, {});
    completeScene(dark, {640, 480}, "", false);
    EXPECT_TRUE(dark.lights.empty());
}

}  // namespace
}  // namespace plumb
