// SPDX-License-Identifier: MIT
// Scenes whose screen vertices are chosen: the focal length is one pixel and the eye the origin, so a vertex at sub-pixel (X, Y) and
// planar depth w has x = (X / 256 - width / 2) w. With w a power of two and |X| < 2^24 every step of the transform is exact.
#pragma once

#include "host/device.h"
#include "host/error.h"
#include "pipeline/render/render.h"

#include <gtest/gtest.h>
#include <array>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb::test {

struct ScreenPoint {
    double x, y;  // sub-pixels, y down
    double w = 1;
};

class ScreenScene {
public:
    ScreenScene(uint32_t width, uint32_t height) : width_(width), height_(height) {
        scene.path = "screen";
        Camera camera;
        camera.focalPixels = 1;
        camera.near = 0x1p-10;
        scene.camera = camera;
        Light light;
        light.direction = {0.25, 0.5, 1};
        scene.lights.push_back(light);
        scene.materials.emplace_back();
        scene.meshes.emplace_back();
        scene.objects.push_back({});
        request.width = width;
        request.height = height;
        request.planes = kPlaneColour | kPlaneLinear | kPlaneZ | kPlaneTriangle;
    }
    // Vertices at equal places are not shared: coverage must not need it.
    void add(const std::array<ScreenPoint, 3>& corners) {
        std::array<glm::vec3, 3> places;
        for (size_t i = 0; i < 3; ++i)
            places[i] = {float((corners[i].x / 256 - width_ / 2.0) * corners[i].w),
                         float(-(corners[i].y / 256 - height_ / 2.0) * corners[i].w), float(-corners[i].w)};
        addPlaces(places);
    }
    void addPlaces(const std::array<glm::vec3, 3>& places) {
        TriangleMesh& mesh = scene.meshes[0];
        const uint32_t first = uint32_t(mesh.positions.size()), face = uint32_t(mesh.faceCentre.size());
        for (const glm::vec3& p : places) {
            if (first == 0 && &p == places.data()) mesh.boundsMin = mesh.boundsMax = p;
            mesh.boundsMin = glm::min(mesh.boundsMin, p);
            mesh.boundsMax = glm::max(mesh.boundsMax, p);
            mesh.positions.push_back(p);
            mesh.normals.emplace_back(0, 0, 1);
            mesh.vertexMaterial.push_back(0);
        }
        mesh.triangles.push_back({{first, first + 1, first + 2}, face});
        mesh.faceCentre.push_back(places[0]);
        mesh.faceNormal.emplace_back(0, 0, 1);
        mesh.faceMaterial.push_back(0);
    }

    Scene scene;
    RenderRequest request;

private:
    double width_, height_;
};

// The pinned lavapipe, one a process; a missing one fails.
inline Device& lavapipe() {
    static Device device = [] {
        const DeviceRequest request;
        const DeviceChoice choice = Device::choose(request);
        if (choice.twin) throw deviceError("these tests need lavapipe: " + choice.reason);
        return Device::open(choice, request);
    }();
    return device;
}

template <class T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

// Every plane that the request leaves. Prints the first plane that differs.
inline void expectSameFrames(const Frame& a, const Frame& b, const std::string& what) {
    EXPECT_EQ(a.coveredPixels, b.coveredPixels) << what;
    EXPECT_TRUE(sameBytes(a.triangle, b.triangle)) << what << ": triangle";
    EXPECT_TRUE(sameBytes(a.z, b.z)) << what << ": z";
    EXPECT_TRUE(sameBytes(a.linear, b.linear)) << what << ": linear colour";
    EXPECT_TRUE(sameBytes(a.rgba, b.rgba)) << what << ": colour";
}

inline RenderResult expectDeviceEqualsTwin(const Scene& scene, const RenderRequest& request, const std::string& what) {
    RenderResult twin = renderCpu(scene, request);
    const RenderResult device = renderGpu(lavapipe(), scene, request);
    expectSameFrames(twin.frame, device.frame, what);
    for (const std::string& line : lavapipe().validationMessages()) ADD_FAILURE() << what << ": " << line;
    return twin;
}

}  // namespace plumb::test
