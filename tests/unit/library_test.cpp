// SPDX-License-Identifier: MIT
// The front door: what a Renderer says of itself, what a Picture saves, and a file as a scene with its request.
#include "host/error.h"
#include "pipeline/image/image.h"
#include "pipeline/library/open_scene.h"
#include "pipeline/library/renderer.h"
#include "pipeline/scene/look_at.h"
#include "pipeline/scene/mesh_arrays.h"
#include "tests/support/device_fixture.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;

Scene triangle() {
    const std::vector<float> positions = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
    const std::vector<uint32_t> triangles = {0, 1, 2};
    Scene scene;
    addObject(scene, addMesh(scene, {.positions = positions, .triangles = triangles}));
    scene.lights.push_back({});
    scene.camera = lookAt({0, 0, 5}, {0, 0, 0});
    return scene;
}

std::string refusalOf(Exit exit, const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), exit);
        return error.what();
    }
    return "accepted";
}

std::string bytesOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

using LibraryRenderer = test::DeviceTest;

TEST_F(LibraryRenderer, DrawsTheSameOnTheDeviceAndByTheTwinAndSaysWhichDrew) {
    Renderer device(test::DeviceEnvironment::request()), twin({.prefer = "twin"});
    const RenderRequest request{.width = 64, .height = 48, .planes = kPlaneColour | kPlaneDepth | kPlaneLinear};
    const Picture a = device.render(triangle(), request), b = twin.render(triangle(), request);
    EXPECT_EQ(a.frame.rgba, b.frame.rgba);
    EXPECT_EQ(a.frame.depth, b.frame.depth);
    EXPECT_EQ(a.frame.linear, b.frame.linear);
    EXPECT_GT(a.frame.coveredPixels, 0u);
    EXPECT_EQ(a.drawnBy, device.device()->info().name);
    EXPECT_EQ(a.reason, device.choice().reason);
    EXPECT_EQ(b.drawnBy, "CPU twin");
    EXPECT_EQ(twin.device(), nullptr);
    EXPECT_NE(b.reason, "");
    EXPECT_EQ(b.planes, request.planes);
    device.checkValidation();
}

TEST_F(LibraryRenderer, RefusesADeviceThatIsNotThere) {
    EXPECT_NE(refusalOf(Exit::device, [] { Renderer renderer({.require = "no such device"}); }), "accepted");
}

TEST_F(LibraryRenderer, RefusesASceneThatCannotBeDrawn) {
    Renderer twin({.prefer = "twin"});
    Scene scene = triangle();
    scene.camera.reset();
    EXPECT_NE(refusalOf(Exit::input, [&] { twin.render(scene); }).find("set Scene::camera"), std::string::npos);
    EXPECT_NE(refusalOf(Exit::usage, [&] { twin.render(triangle(), {.samples = 3}); }), "accepted");
    EXPECT_EQ(refusalOf(Exit::interrupted, [&] { twin.render(triangle(), {.onProgress = [](double) { return false; }}); }), "interrupted");
}

TEST(LibraryPicture, SavesByItsExtensionWhatItHas) {
    Renderer twin({.prefer = "twin"});
    const Picture picture = twin.render(triangle(), {.width = 16, .height = 12, .planes = kPlaneColour | kPlaneLinear | kPlaneDepth});
    const test::TemporaryFolder folder;
    const auto at = [&](const char* name) { return folder.path() / name; };
    picture.save(at("a.png"));
    EXPECT_EQ(readPng(at("a.png")).rgba, picture.frame.rgba);
    picture.save(at("d.npy"), kPlaneDepth);
    EXPECT_EQ(bytesOf(at("d.npy")).substr(0, 6), "\x93NUMPY");
    EXPECT_EQ(bytesOf(at("d.npy")).size() % 64, 16u * 12u * 4u % 64u);
    picture.save(at("c.npy"));
    EXPECT_NE(bytesOf(at("c.npy")).find("'|u1'"), std::string::npos);
    picture.save(at("all.EXR"));
    picture.save(at("named.exr"), kPlaneColour | kPlaneDepth);
    EXPECT_EQ(bytesOf(at("all.EXR")), bytesOf(at("named.exr")));
    picture.save(at("depth.exr"), kPlaneDepth);
    EXPECT_LT(bytesOf(at("depth.exr")).size(), bytesOf(at("all.EXR")).size());
}

TEST(LibraryPicture, RefusesWhatItLacksAndWritesNothing) {
    Renderer twin({.prefer = "twin"});
    const Picture picture = twin.render(triangle(), {.width = 16, .height = 12});
    const test::TemporaryFolder folder;
    const auto refusal = [&](const char* name, uint32_t planes) {
        const std::string said = refusalOf(Exit::usage, [&] { picture.save(folder.path() / name, planes); });
        EXPECT_FALSE(fs::exists(folder.path() / name)) << name;
        return said.substr(said.find("': ") + 3);
    };
    EXPECT_EQ(refusal("a.npy", kPlaneDepth), "the picture has no plane 'depth': ask for it when drawing");
    EXPECT_EQ(refusal("a.exr", kPlaneColour), "the picture has no plane 'linear': ask for it when drawing");
    EXPECT_EQ(refusal("a.exr", 0), "an .exr file holds linear colour and measures: ask for such planes when drawing");
    EXPECT_EQ(refusal("a.jpg", 0), "pictures are written as .png, .exr or .npy");
    EXPECT_EQ(refusalOf(Exit::usage, [&] { Picture().save(folder.path() / "a.png"); }).substr(0, 1), "'");
}

TEST(LibraryOpenScene, CompletesABareMeshAndKeepsWhatAFileStates) {
    const fs::path scenes = fs::path(PLUMB_SOURCE_DIR) / "scenes";
    const Scene mesh = openScene(scenes / "procedural" / "torus.stl", {.size = {32, 24}, .view = "front"});
    ASSERT_TRUE(mesh.camera.has_value());
    EXPECT_EQ(mesh.lights.size(), 2u);
    EXPECT_EQ(requestFor(mesh).width, 32u);
    EXPECT_EQ(requestFor(mesh).height, 24u);
    const Scene glass = openScene(scenes / "four-spheres.toml");
    const RenderRequest traced = requestFor(glass);
    EXPECT_EQ(traced.shading, Shading::ray);
    EXPECT_EQ(traced.maxDepth, glass.maxDepth);
    EXPECT_NE(refusalOf(Exit::input, [] { openScene("no-such-file.obj"); }).find("no-such-file.obj"), std::string::npos);
}

}  // namespace
}  // namespace plumb
