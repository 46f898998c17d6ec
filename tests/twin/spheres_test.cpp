// SPDX-License-Identifier: MIT
#include "pipeline/passes/spheres.h"

#include "host/error.h"
#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

class SpheresTwin : public DeviceTest {};

std::string noLocation(size_t) { return ""; }

struct Lit {
    std::vector<gpu::MaterialRecord> materials;
    std::vector<gpu::LightRecord> lights;
    SphereLight with(bool whole, const gpu::ShadeParts& parts = {true, true, true, gpu::kPowerExact}) const {
        return {parts, materials, lights, whole, 0.5f};
    }
};
Lit litOf(uint32_t lightCount) {
    Random r(43);
    Lit lit;
    for (float n : {0.0f, 1.0f, 32.0f, 1e6f})
        lit.materials.push_back({{0.01f, 0.02f, 0.03f}, n, {0.7f, 0.5f, 0.3f}, n == 0 ? 1.0f : 0.0f, {0.4f, 0.6f, 0.8f}, 0});
    for (uint32_t i = 0; i < lightCount; ++i) {
        const bool point = i % 4 != 0;
        glm::vec3 d = r.direction();
        d.z = -std::abs(d.z);
        lit.lights.push_back({point ? d * 40.0f : d, point ? 1.0f : 0.0f, {0.5f, 0.4f, 0.3f}, float(point ? (i - 1) % 4 : 0)});
    }
    return lit;
}

gpu::SphereDisc discAt(int column, int row, int radiusSquared, float depth, uint32_t material = 0) {
    gpu::SphereDisc d{};
    d.column = column;
    d.row = row;
    d.reach = int(std::sqrt(double(radiusSquared)));
    d.radiusSquared = radiusSquared;
    d.centre = {float(column) * 0.5f, float(row) * -0.5f, depth};
    d.depth = depth;
    d.material = material;
    return d;
}

SphereList listOf(int width, int height, uint32_t count, int reach, uint32_t seed) {
    Random r(seed);
    SphereList list(width, height);
    // Corners of each side met by one pixel, whole radii with pixels on the circle (3, 4), roots half way between whole numbers, the same
    // sphere twice (the first is seen), and the largest there is.
    list.add(discAt(-5, height / 2, 25, 100, 1));
    list.add(discAt(width + 4, height / 2, 25, 100, 1));
    list.add(discAt(width / 2, -5, 25, 100, 2));
    list.add(discAt(width / 2, height + 4, 25, 100, 2));
    for (int n : {1, 2, 6, 12, 25, 30}) list.add(discAt(3 + 2 * n, 6 + n, n, 90, uint32_t(n) % 4));
    list.add(discAt(width / 3, height / 3, 100, 80, 0));
    list.add(discAt(width / 3, height / 3, 100, 80, 3));
    list.add(discAt(width / 2, height / 2 + 4090, gpu::kSphereReach * gpu::kSphereReach, 9000, 1));
    for (uint32_t i = 0; i < count; ++i) {
        const auto whole = [&](double most) { return int(r(-0.2, 1.2) * most); };
        const int column = whole(width), row = whole(height);
        list.add(discAt(column, row, 1 + int(r.below(uint32_t(reach * reach))), float(60 + r.below(40)), r.below(4)));
    }
    list.close(noLocation);
    return list;
}

SphereCanvas expectSameCanvas(Device& device, const SphereList& list, const SphereLight& light) {
    SphereCanvas want = spheresCpu(list, light, 2);
    for (const Specialization& exact : exactForms(device)) {
        Recorder recorder(device);
        const SphereCanvas got = spheresGpu(device, recorder, list, light, exact, kWatchdogMs);
        const auto place = [&](size_t i) { return fmt::format("pixel ({}, {})", i % size_t(list.width), i / size_t(list.width)); };
        expectSame<float>("spheres: depth", want.depth, got.depth, place);
        expectSame<uint32_t>("spheres: sphere", want.owner, got.owner, place);
        expectSame<float>("spheres: colour", std::span<const float>(&want.colour[0].x, 4 * want.colour.size()),
                          std::span<const float>(&got.colour[0].x, 4 * got.colour.size()), [&](size_t i) { return place(i / 4); });
    }
    return want;
}

TEST_F(SpheresTwin, LeavesTheSameBytes) {
    const Lit lit = litOf(5);
    for (const bool whole : {false, true})
        for (const SphereList& list :
             {listOf(131, 67, 40, 20, 3), listOf(64, 64, 200, 9, 5), listOf(35, 129, 30, 60, 7), listOf(1, 1, 20, 9, 11)}) {
            SCOPED_TRACE(fmt::format("{}x{}, heights {}", list.width, list.height, whole ? "whole" : "exact"));
            const SphereCanvas canvas = expectSameCanvas(device(), list, lit.with(whole));
            EXPECT_LT(size_t(std::count(canvas.owner.begin(), canvas.owner.end(), gpu::kNoSphere)), canvas.owner.size())
                << "nothing is drawn";
        }
}

TEST_F(SpheresTwin, LeavesTheSameBytesWithPartsLeftOut) {
    const SphereList list = listOf(67, 45, 30, 20, 13);
    for (const gpu::ShadeParts& parts :
         {gpu::ShadeParts{true, false, false, gpu::kPowerExact}, gpu::ShadeParts{false, true, true, gpu::kPowerSchlick},
          gpu::ShadeParts{false, false, false, gpu::kPowerExact}})
        expectSameCanvas(device(), list, litOf(4).with(false, parts));
    expectSameCanvas(device(), list, litOf(0).with(true));
}

// The square of a distance of 2^16 pixels does not fit 32 bits: it would wrap to 0 and cover.
TEST_F(SpheresTwin, FarPixelsAreNotCovered) {
    SphereList list(65600, 1);
    list.add(discAt(0, 0, 9, 50));
    list.close(noLocation);
    const SphereCanvas canvas = expectSameCanvas(device(), list, litOf(1).with(true));
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 0u), 4);
}

TEST_F(SpheresTwin, AnEmptyListLeavesAnEmptyCanvas) {
    SphereList list(5, 3);
    EXPECT_FALSE(list.add(discAt(-6, 1, 25, 50))) << "one pixel beside the canvas";
    list.close(noLocation);
    const SphereCanvas canvas = expectSameCanvas(device(), list, litOf(1).with(true));
    EXPECT_EQ(canvas.owner, std::vector<uint32_t>(15, gpu::kNoSphere));
}

TEST_F(SpheresTwin, ManySpheresTakeSeveralDispatches) {
    SphereList list(640, 480);
    for (int i = 0; i < 600; ++i) list.add(discAt(320, 240, 200 * 200, float(50 + i % 7)));
    list.close(noLocation);
    Recorder recorder(device());
    const SphereLight light = litOf(1).with(true);
    const SphereCanvas got = spheresGpu(device(), recorder, list, light, exactForms(device())[0], kWatchdogMs),
                       want = spheresCpu(list, light, 2);
    EXPECT_GT(recorder.takeTimes().at(0).dispatches, 1u);
    expectSame<uint32_t>("spheres: sphere", want.owner, got.owner);
    EXPECT_EQ(std::count(got.owner.begin(), got.owner.end(), 0u),
              std::count(got.owner.begin(), got.owner.end(), got.owner[240 * 640 + 320]));
}

TEST(SpheresRules, ARowOfTooManySpheresIsRefused) {
    SphereList list(4, 3);
    for (int i = 0; i <= gpu::kSpheresOfRow; ++i) list.add(discAt(1, 1, 1, 50));
    try {
        list.close([](size_t disc) { return "scene.toml: sphere " + std::to_string(disc); });
        FAIL() << "one sphere too many is drawn";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input);
        EXPECT_EQ(std::string(error.what()).rfind(fmt::format("scene.toml: sphere {}: ", gpu::kSpheresOfRow), 0), 0u) << error.what();
    }
}

}  // namespace
}  // namespace plumb::test
