// SPDX-License-Identifier: MIT
// What part 4 of the notes describes without a number, in pictures of committed scenes.
#include "pipeline/scene/load.h"
#include "tests/support/ray_scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <glm/glm.hpp>
#include <set>
#include <string>
#include <utility>

namespace plumb::test {
namespace {

Scene sceneOf(const char* name, glm::uvec2 size) { return committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes" / name, size); }

RenderRequest requestOf(const Scene& scene, glm::uvec2 size, Shading shading = Shading::ray) {
    RenderRequest r;
    r.width = size.x;
    r.height = size.y;
    r.shading = shading;
    r.background = scene.background.value_or(glm::vec3(0));
    r.encoding = scene.encoding.value_or(Encoding::srgb);
    r.maxDepth = scene.maxDepth;
    r.minWeight = float(scene.minWeight);
    r.planes = kPlaneColour | kPlaneLinear | kPlaneObject | kPlaneDistance;
    return r;
}
glm::ivec3 codesOf(uint32_t word) { return {int(word & 255), int(word >> 8 & 255), int(word >> 16 & 255)}; }
uint32_t objectNamed(const Scene& scene, const std::string& name) {
    for (uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.objects[i].name == name) return i;
    for (uint32_t i = 0; i < scene.spheres.size(); ++i)
        if (scene.spheres[i].name == name) return uint32_t(scene.objects.size()) + i;
    ADD_FAILURE() << "no object is named " << name;
    return kNone;
}

// Row 71.
TEST(RayPictures, TheMirrorShowsTheSideThatIsTurnedAway) {
    constexpr glm::uvec2 kSize{160, 120};
    const Scene scene = sceneOf("gallery/mirror-behind.toml", kSize);
    const uint32_t mirror = objectNamed(scene, "glass");
    const auto blue = [&](const Frame& f) {
        int mirrored = 0, direct = 0;
        for (size_t i = 0; i < f.rgba.size(); ++i) {
            const glm::ivec3 c = codesOf(f.rgba[i]);
            if (c.b > 80 && c.b > 2 * c.r) ++(f.object[i] == mirror ? mirrored : direct);
        }
        return std::pair(mirrored, direct);
    };
    const auto [mirrored, direct] = blue(renderCpu(scene, requestOf(scene, kSize)).frame);
    EXPECT_GT(mirrored, 100);
    EXPECT_EQ(direct, 0) << "from the eye the side is hidden";
    const auto [flat, raster] = blue(renderCpu(scene, requestOf(scene, kSize, Shading::phong)).frame);
    EXPECT_EQ(flat + raster, 0) << "a raster picture has no such pixel";
    // Without the polygons that face away, as culling leaves them out, the mirror would show through the box.
    Scene culled = scene;
    TriangleMesh& box = culled.meshes[culled.objects[objectNamed(scene, "box")].mesh];
    std::erase_if(box.triangles, [&](const TriangleMesh::Triangle& t) {
        return glm::dot(glm::dvec3(box.faceNormal[t.face]), culled.camera->eye - glm::dvec3(box.faceCentre[t.face])) <= 0;
    });
    EXPECT_EQ(blue(renderCpu(culled, requestOf(culled, kSize)).frame).first, 0);
}

// Row 77: a ray is not spread, so what it meets decides the whole pixel.
TEST(RayPictures, OneRayAPixelHasNoValueBetweenTwoSurfaces) {
    constexpr glm::uvec2 kSize{96, 72};
    Scene scene = rayScene();
    scene.lights.clear();
    scene.spheres = {ball({0, 1, 0}, 1.3, 0)};
    RenderRequest request = requestOf(scene, kSize);
    const Frame hard = renderCpu(scene, request).frame;
    std::set<uint32_t> values(hard.rgba.begin(), hard.rgba.end());
    ASSERT_EQ(values.size(), 2u) << "the ball's colour and the sky's";
    const uint32_t inside = hard.rgba[size_t(36) * kSize.x + 48], outside = hard.rgba[0];
    request.samples = 16;
    const Frame soft = renderCpu(scene, request).frame;
    int between = 0;
    for (uint32_t y = 0; y < kSize.y; ++y)
        for (uint32_t x = 0; x < kSize.x; ++x) {
            const uint32_t value = soft.rgba[size_t(y) * kSize.x + x];
            if (value == inside || value == outside) {
                EXPECT_EQ(value, hard.rgba[size_t(y) * kSize.x + x]) << x << ", " << y;
                continue;
            }
            ++between;
            for (int c = 0; c < 3; ++c) {
                const int a = codesOf(inside)[c], b = codesOf(outside)[c], v = codesOf(value)[c];
                EXPECT_TRUE(v >= std::min(a, b) && v <= std::max(a, b)) << x << ", " << y;
            }
            // Pixels on the outline have a neighbour of the other side.
            bool edge = false;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    edge |= hard.rgba[size_t(int(y) + dy) * kSize.x + size_t(int(x) + dx)] != hard.rgba[size_t(y) * kSize.x + x];
            EXPECT_TRUE(edge) << x << ", " << y;
        }
    // The outline of a ball of radius r px crosses each of its columns and rows twice, and passes through about 8 r pixels.
    const Camera& c = *scene.camera;
    const double radius = kSize.y / 2.0 / std::tan(glm::radians(c.fovYDegrees / 2)) * 1.3 / std::sqrt(36 - 1.3 * 1.3);
    std::printf("%d pixels between two values, 8 r = %.0f\n", between, 8 * radius);
    EXPECT_GT(between, int(4 * radius));
    EXPECT_LE(between, int(8 * radius) + 8);
}

// Row 83: the pattern asks no tree, costs no shadow ray, and darkens as much of the ground to the same colour.
TEST(RayPictures, FakedShadowsLookLikeShadowsAndSendNoShadowRay) {
    constexpr glm::uvec2 kSize{160, 120};
    const Scene faked = sceneOf("gallery/faked-shadows.toml", kSize), real = sceneOf("gallery/true-shadows.toml", kSize);
    const RenderResult fake = renderCpu(faked, requestOf(faked, kSize, Shading::phong)), traced = renderCpu(real, requestOf(real, kSize));
    EXPECT_TRUE(fake.counters.rays.empty());
    ASSERT_FALSE(traced.counters.rays.empty());
    EXPECT_GT(traced.counters.rays[0].shadowRays, 1000u);
    const uint32_t ground = objectNamed(real, "ground"), lightGround = objectNamed(faked, "ground"),
                   darkGround = objectNamed(faked, "pattern");
    std::set<uint32_t> colours;
    int dark = 0, light = 0, darkFake = 0, lightFake = 0;
    uint32_t darkest = 0;
    for (size_t i = 0; i < traced.frame.rgba.size(); ++i) {
        if (traced.frame.object[i] == ground) colours.insert(traced.frame.rgba[i]);
        if (fake.frame.object[i] == darkGround) darkest = fake.frame.rgba[i], ++darkFake;
        lightFake += fake.frame.object[i] == lightGround;
    }
    ASSERT_EQ(colours.size(), 2u) << "a directional light on flat ground: lit, or in shadow";
    const uint32_t shadow = codesOf(*colours.begin()).r < codesOf(*colours.rbegin()).r ? *colours.begin() : *colours.rbegin();
    EXPECT_EQ(darkest, shadow) << "the faked shade is what a blocked shadow ray leaves";
    for (size_t i = 0; i < traced.frame.rgba.size(); ++i)
        if (traced.frame.object[i] == ground) ++(traced.frame.rgba[i] == shadow ? dark : light);
    const double share = double(dark) / (dark + light), faked01 = double(darkFake) / (darkFake + lightFake);
    std::printf("in shade: %.3f of the ground by shadow rays, %.3f faked; %llu shadow rays\n", share, faked01,
                static_cast<unsigned long long>(traced.counters.rays[0].shadowRays));
    EXPECT_GT(share, 0.2);
    EXPECT_LT(share, 0.8);
    EXPECT_NEAR(faked01, share, 0.1);
    // Visually compelling is not right: many a place is in the shade of nothing.
    int wrong = 0;
    for (size_t i = 0; i < traced.frame.rgba.size(); ++i)
        wrong += traced.frame.object[i] == ground && fake.frame.rgba[i] != traced.frame.rgba[i];
    EXPECT_GT(wrong, (dark + light) / 10);
}

// Row 85: full illumination, shadows and a board that reflects, each seen where it must be.
TEST(RayPictures, WhatTheProgramOmitsIsInTheCompleteScene) {
    constexpr glm::uvec2 kSize{1200, 1200};
    const Scene plain = sceneOf("notes-spheres.toml", kSize), complete = sceneOf("notes-spheres-complete.toml", kSize);
    const uint32_t board = uint32_t(plain.spheres.size());
    const auto coloursOf = [&](const Frame& f, bool ofBoard) {
        std::set<uint32_t> colours;
        for (size_t i = 0; i < f.rgba.size(); ++i)
            if (f.object[i] != kNone && (f.object[i] == board) == ofBoard) colours.insert(f.rgba[i]);
        return colours.size();
    };
    const Frame one = renderCpu(plain, requestOf(plain, kSize)).frame, other = renderCpu(complete, requestOf(complete, kSize)).frame;
    EXPECT_EQ(one.object, other.object) << "the same things stand in the same places";
    EXPECT_EQ(coloursOf(one, true), 2u) << "red and white";
    EXPECT_GT(coloursOf(other, true), 1000u);
    // Each omission by itself.
    const auto differing = [&](const Scene& without, bool ofBoard, bool darker) {
        const Frame f = renderCpu(without, requestOf(without, kSize)).frame;
        int count = 0;
        for (size_t i = 0; i < f.rgba.size(); ++i) {
            if (other.object[i] == kNone || (other.object[i] == board) != ofBoard || f.rgba[i] == other.rgba[i]) continue;
            ++count;
            if (!darker) continue;
            for (int c = 0; c < 3; ++c) {
                EXPECT_LE(codesOf(other.rgba[i])[c], codesOf(f.rgba[i])[c]);
            }
        }
        return count;
    };
    Scene lit = complete, matt = complete, dull = complete;
    lit.shadows = false;
    for (const uint32_t m : {complete.planes[0].material, complete.planes[0].otherMaterial}) matt.materials[m].reflect = 0;
    for (Material& m : dull.materials) m.specular = glm::vec3(0);
    const int shaded = differing(lit, true, true), mirrored = differing(matt, true, false), shining = differing(dull, false, false);
    std::printf("board: %d pixels in shadow, %d mirror something; spheres: %d shine\n", shaded, mirrored, shining);
    EXPECT_GT(shaded, 5000);
    EXPECT_GT(mirrored, 5000);
    EXPECT_GT(shining, 500);
}

// Row 86.
TEST(RayPictures, GlassTurnsTheShowcaseUpsideDownAndMetalsMirrorIt) {
    constexpr glm::uvec2 kSize{480, 320};
    const Scene scene = sceneOf("four-spheres.toml", kSize);
    const Frame f = renderCpu(scene, requestOf(scene, kSize)).frame;
    // The sky is blue (150, 150, 255), the board red and white: half of what they differ by.
    const auto nearSky = [&](uint32_t word) { return codesOf(word).b - codesOf(word).r > 52; };
    ASSERT_TRUE(nearSky(f.rgba[0]));
    const uint32_t glass = objectNamed(scene, "glass");
    uint32_t top = kSize.y, bottom = 0;
    for (uint32_t y = 0; y < kSize.y; ++y)
        for (uint32_t x = 0; x < kSize.x; ++x)
            if (f.object[size_t(y) * kSize.x + x] == glass) top = std::min(top, y), bottom = std::max(bottom, y);
    ASSERT_GT(bottom, top + 40);
    double share[2] = {}, count[2] = {};
    for (uint32_t y = top; y <= bottom; ++y)
        for (uint32_t x = 0; x < kSize.x; ++x) {
            const size_t at = size_t(y) * kSize.x + x;
            if (f.object[at] != glass || (y > top + (bottom - top) / 3 && y < bottom - (bottom - top) / 3)) continue;
            const int half = y < (top + bottom) / 2 ? 0 : 1;
            count[half] += 1;
            share[half] += nearSky(f.rgba[at]);
        }
    std::printf("sky in the glass: %.3f of its upper third, %.3f of its lower\n", share[0] / count[0], share[1] / count[1]);
    EXPECT_GT(share[1] / count[1], 0.25) << "the sky is below";
    EXPECT_GT(share[1] / count[1], 3 * share[0] / count[0]);
    // Each metal shows each other one: without it, pixels of the metal change.
    for (const char* name : {"blue", "green", "yellow"}) {
        Scene without = scene;
        const auto gone =
            std::find_if(without.spheres.begin(), without.spheres.end(), [&](const SphereShape& s) { return s.name == name; });
        gone->centre = {0, -1e3, 0};  // under the board
        const Frame other = renderCpu(without, requestOf(without, kSize)).frame;
        for (const char* in : {"blue", "green", "yellow"}) {
            if (std::string(in) == name) continue;
            const uint32_t metal = objectNamed(scene, in);
            int changed = 0;
            for (size_t i = 0; i < f.rgba.size(); ++i)
                changed += f.object[i] == metal && other.object[i] == metal && f.rgba[i] != other.rgba[i];
            EXPECT_GT(changed, 20) << name << " in " << in;
        }
    }
}

}  // namespace
}  // namespace plumb::test
