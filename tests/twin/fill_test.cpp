// SPDX-License-Identifier: MIT
// Fill, shade and encode are one kernel; the twin does them one after another.
#include "pipeline/passes/encode.h"
#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::test {
namespace {

class FillTwin : public SceneRows {};

void compareFill(Device& device, const SceneCase& row, const Scene& scene, Shading shading, Encoding encoding, int bandRows,
                 bool distantViewer = false, bool repeated = false) {
    RenderRequest request = requestOf(row, shading);
    request.repeated = repeated;
    request.distantViewer = distantViewer;
    request.encoding = encoding;
    request.background = {0.1f, 0.5f, 0.02f};
    PassFrame f(device, scene, request);
    f.takeTwin();
    size_t covered = 0;
    for (int firstRow = 0; firstRow < int(row.height); firstRow += bandRows) {
        const gpu::FrameBox band = f.band(firstRow, bandRows);
        f.frame.beginBand(band, kPassPlanes);
        f.frame.bin();
        FillChoices choices = f.p.choices;
        choices.write = kPassPlanes;
        f.frame.fill(choices);
        const size_t width = row.width, pixels = width * size_t(band.rows);
        std::vector<int> z(pixels);
        std::vector<uint32_t> draw(pixels), triangle(pixels, gpu::kNoTriangle), colour(pixels, f.p.background & 0xffffffu);
        std::vector<float> linear(3 * pixels);
        fillCpu(band, f.twin.draws, f.twin.screen, z, draw, 1);
        for (size_t i = 0; i < pixels; ++i)
            if (!draw[i]) std::copy_n(&f.p.backgroundLinear[0], 3, &linear[3 * i]);
        shadeCpu(band, f.p.list, f.p.choices, f.twin.draws, f.twin.screen,
                 f.p.choices.shading == gpu::kShadingFlat ? f.twin.faceColours : f.twin.attributes, z, draw, linear, {}, 1);
        std::vector<int> gotZ(pixels);
        std::vector<uint32_t> gotTriangle(pixels), gotColour(pixels);
        std::vector<float> gotLinear(3 * pixels);
        for (size_t i = 0; i < pixels; ++i) {
            if (draw[i]) {
                ++covered;
                triangle[i] = f.twin.draws[draw[i] - 1].source;
                colour[i] = encodePixelCpu(f.p.choices.encoding, &linear[3 * i], 255);
            }
            const size_t word = i / width * f.frame.rowPixels() + i % width;
            gotZ[i] = int(f.frame.plane(0)[word]);
            gotTriangle[i] = f.frame.plane(1)[word];
            gotColour[i] = f.frame.colourWords()[word];
            for (uint32_t k = 0; k < 3; ++k) gotLinear[3 * i + k] = gpu::realOf(int(f.frame.plane(2 + k)[word]));
        }
        const auto pixel = [&](size_t channels) {
            return [=](size_t i) {
                return fmt::format("pixel ({}, {}) channel {}", i / channels % width, i / channels / width + size_t(firstRow),
                                   i % channels);
            };
        };
        expectSame<int>("fill: z bits", z, gotZ, pixel(1));
        expectSame<uint32_t>("fill: triangle", triangle, gotTriangle, pixel(1));
        expectSame<float>("shade: linear", linear, gotLinear, pixel(3));
        expectSame<uint32_t>("encode: colour", colour, gotColour, pixel(1));
    }
    EXPECT_GT(covered, 0u) << "no pixel is covered: this row shows nothing";
}

TEST_P(FillTwin, LeavesTheSameBytes) {
    const int all = int(GetParam().height);
    for (Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
        SCOPED_TRACE(fmt::format("shading {}", int(shading)));
        compareFill(device(), GetParam(), GetParam().scene(), shading, Encoding::srgb, all);
    }
    SCOPED_TRACE("lights unrolled");
    compareFill(device(), GetParam(), GetParam().scene(), Shading::phong, Encoding::srgb, all, false, true);
}
TEST_P(FillTwin, LeavesTheSameBytesInBandsOfEightRows) {
    compareFill(device(), GetParam(), GetParam().scene(), Shading::phong, Encoding::linear, 8);
}

INSTANTIATE_TEST_SUITE_P(Scenes, FillTwin, ::testing::ValuesIn(sceneCases()), [](const auto& info) { return nameOf(info.param); });

// Variants of the kernel that only a scene with so many lights and materials asks for.
class FillVariant : public DeviceTest {};
TEST_F(FillVariant, EveryNumberOfLightsAndMaterials) {
    const SceneCase row{"soupLarge", soupLarge, 131, 67};
    for (size_t lights : {0u, 1u, 2u, 4u, 17u})
        for (size_t materials : {1u, 3u})
            for (bool specular : {false, true}) {
                SCOPED_TRACE(fmt::format("{} lights, {} materials, specular {}", lights, materials, specular));
                Scene scene = row.scene();
                const std::vector<Light> kinds = scene.lights;
                scene.lights.clear();
                for (size_t i = 0; i < lights; ++i) scene.lights.push_back(kinds[(i + materials) % kinds.size()]);
                Random random(43);
                scene.meshes[0] = soupOf(
                    std::vector<Corners>(1, {row.view().pointAt(2, 3, 2), row.view().pointAt(9, 60, 5), row.view().pointAt(125, 33, 1)}), 1,
                    &random);
                if (materials > 1) scene.meshes[0] = row.scene().meshes[0];
                if (!specular)
                    for (Material& m : scene.materials) m.specular = glm::vec3(0);
                for (const bool repeated : {false, true})
                    compareFill(device(), row, scene, Shading::phong, Encoding::srgb, int(row.height), false, repeated);
            }
}

// More lights than one dispatch adds up: windows, also where tiles' lists come in slices, chunks or bands, give the sum of one loop.
TEST_F(FillVariant, LightsComeInWindows) {
    const SceneCase row{"soupLarge", soupLarge, 67, 35};
    for (size_t lights : {size_t(gpu::kLightsPerWindow), size_t(gpu::kLightsPerWindow) + 1, size_t(gpu::kLightsPerWindow) * 2 + 40}) {
        SCOPED_TRACE(fmt::format("{} lights", lights));
        Scene scene = row.scene();
        const std::vector<Light> kinds = scene.lights;
        scene.lights.clear();
        for (size_t i = 0; i < lights; ++i) {
            scene.lights.push_back(kinds[i % kinds.size()]);
            scene.lights.back().intensity *= float(1 + i % 7) / float(lights);
        }
        compareFill(device(), row, scene, Shading::phong, Encoding::srgb, 16);
    }
}
TEST_F(FillVariant, TwentyThousandLightsAreNoLimit) {
    const SceneCase row{"soupLarge", soupLarge, 23, 17};
    Scene scene = row.scene();
    const std::vector<Light> kinds = scene.lights;
    scene.lights.clear();
    for (size_t i = 0; i < 20000; ++i) {
        scene.lights.push_back(kinds[i % kinds.size()]);
        scene.lights.back().intensity *= float(1 + i % 7) / 20000;
    }
    for (Shading shading : {Shading::flat, Shading::gouraud, Shading::phong}) {
        SCOPED_TRACE(fmt::format("shading {}", int(shading)));
        RenderRequest request = requestOf(row, shading);
        request.planes = kEveryPlane;
        const Frame want = renderCpu(scene, request).frame;
        request.knobs.chunkTriangles = uint32_t(std::max<size_t>(1, scene.meshes[0].triangles.size() / 3));
        const Frame got = renderGpu(device(), scene, request).frame;
        EXPECT_EQ(want.rgba, got.rgba);
        EXPECT_EQ(want.linear, got.linear);
        EXPECT_EQ(want.normal, got.normal);
        EXPECT_EQ(want.triangle, got.triangle);
    }
}
TEST_F(FillVariant, ADistantViewer) {
    const SceneCase row{"soupLarge", soupLarge, 131, 67};
    for (Shading shading : {Shading::flat, Shading::gouraud, Shading::phong})
        compareFill(device(), row, row.scene(), shading, Encoding::srgb, int(row.height), true);
}

// A wall that fills the frame but for its left side, and little before it: nearly every tile has one triangle.
Scene wall(View v) {
    const double right = v.width + 9, low = v.height + 9;
    return sceneOf({{v.pointAt(3, -9, 2), v.pointAt(right, -9, 4), v.pointAt(right, low, 7)},
                    {v.pointAt(3, -9, 2), v.pointAt(right, low, 7), v.pointAt(14, low, 3)},
                    {v.pointAt(200, 90, 1), v.pointAt(260, 300, 1), v.pointAt(320, 110, 1.5)}});
}
TEST_F(FillVariant, TilesOfOneTriangleApart) {
    const SceneCase row{"wall", wall, 1088, 528};
    PassFrame f(device(), row.scene(), requestOf(row));
    f.takeTwin();
    f.frame.beginBand(f.band(0, int(row.height)), kPassPlanes);
    f.frame.bin();
    f.frame.recorder().run(kWatchdogMs);
    const std::vector<uint32_t> counts = f.frame.lists().counts;
    ASSERT_GE(size_t(std::count(counts.begin(), counts.end(), 1u)), kOnesApart) << "not enough of them: this shows nothing";
    for (Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
        SCOPED_TRACE(fmt::format("shading {}", int(shading)));
        compareFill(device(), row, row.scene(), shading, Encoding::srgb, int(row.height), false, true);
    }
    // Without planes and places nobody asks for depth.
    Scene directional = row.scene();
    for (Light& light : directional.lights) light = {.directional = true, .direction = {0.2, 0.3, 1}, .intensity = light.intensity};
    for (const bool repeated : {false, true}) {
        RenderRequest request = requestOf(row);
        request.planes = kPlaneColour;
        request.repeated = repeated;
        EXPECT_EQ(renderCpu(directional, request).frame.rgba, renderGpu(device(), directional, request).frame.rgba);
    }
}

// Forty layers over the whole frame, level and slanted, from the nearest and from the farthest: most of a tile's list lies behind what covers it.
Scene layers(View v, bool nearestFirst) {
    std::vector<Corners> soup;
    const double right = v.width + 9, low = v.height + 9;
    for (int i = 0; i < 20; ++i) {
        const double depth = nearestFirst ? 2 + i / 2 : 12 - i / 2;  // each twice: ties
        const double far = depth + (i % 3 == 0 ? 0.75 : 0);
        soup.push_back({v.pointAt(-9, -9, depth), v.pointAt(right, -9, far), v.pointAt(right, low, depth)});
        soup.push_back({v.pointAt(-9, -9, depth), v.pointAt(right, low, depth), v.pointAt(-9, low, far)});
    }
    soup.push_back({v.pointAt(30, 20, 1.5), v.pointAt(80, 25, 1.75), v.pointAt(50, 50, 30)});
    return sceneOf(soup);
}
// Groups of layers behind one that covers the frame, each with something before it: whatever the order of groups in a list, eight that are hidden come
// before one that is seen.
Scene layersAmongOthers(View v) {
    std::vector<Corners> soup;
    const double right = v.width + 9, low = v.height + 9;
    for (int group = 0; group < 6; ++group) {
        for (int i = 0; i < 10; ++i) {
            const double depth = i == 0 ? 5 : 8 + i;
            soup.push_back({v.pointAt(-9, -9, depth), v.pointAt(right, -9, depth), v.pointAt(right, low, depth)});
            soup.push_back({v.pointAt(-9, -9, depth), v.pointAt(right, low, depth), v.pointAt(-9, low, depth)});
        }
        soup.push_back({v.pointAt(9 + 3 * group, 5, 4 - 0.4 * group), v.pointAt(120, 20 + 5 * group, 4 - 0.4 * group),
                        v.pointAt(40, 63 - 4 * group, 4 - 0.4 * group)});
    }
    return sceneOf(soup);
}
TEST_F(FillVariant, WhatLiesBehindALayerIsLeftOut) {
    for (const SceneCase& row : {SceneCase{"layersAmongOthers", layersAmongOthers, 131, 67},
                                 SceneCase{"nearestFirst", [](View v) { return layers(v, true); }, 131, 67},
                                 SceneCase{"farthestFirst", [](View v) { return layers(v, false); }, 131, 67}}) {
        SCOPED_TRACE(row.name);
        compareFill(device(), row, row.scene(), Shading::phong, Encoding::srgb, int(row.height));
    }
}

// Equal depths: the lower triangle wins, whatever the order in which a tile's list holds them.
TEST_F(FillVariant, GivesTiesToTheLowerTriangle) {
    const SceneCase row{"equalDepths", equalDepths, 131, 67};
    RenderRequest request = requestOf(row);
    request.planes = kEveryPlane;
    const Frame frame = renderGpu(device(), row.scene(), request).frame;
    size_t drawn = 0;
    for (size_t i = 0; i < frame.triangle.size(); ++i) {
        if (frame.triangle[i] == kNone) continue;
        ++drawn;
        ASSERT_EQ(frame.triangle[i] % 3, 0u) << "pixel (" << i % row.width << ", " << i / row.width
                                             << "): a repetition won over the first of its kind";
    }
    EXPECT_GT(drawn, 0u);
}

// Fans around a point: no pixel inside is lost or drawn by two, also where edges run through pixel centres.
TEST_F(FillVariant, SharedEdgesLoseNoPixelAndShareNone) {
    const SceneCase row{"throughCentres", throughCentres, 131, 67};
    const Prepared p = prepare(row.scene(), requestOf(row));
    const TwinGeometry g = twinGeometry(p.list, p.choices, false, 1);
    const size_t pixels = size_t(row.width) * row.height;
    // Coverage of each triangle alone adds up to the coverage of its fan.
    std::vector<uint32_t> times(pixels), fan(pixels);
    std::vector<int> z(pixels);
    std::vector<uint32_t> draw(pixels);
    size_t exact = 0;
    for (size_t first = 0; first + 6 <= p.list.triangles.size(); first += 6) {
        std::fill(times.begin(), times.end(), 0u);
        for (const gpu::DrawTriangle& d : g.draws) {
            if (d.source < first || d.source >= first + 6) continue;
            const std::vector<gpu::DrawTriangle> one = {d};
            fillCpu(p.list.frame, one, g.screen, z, draw, 1);
            for (size_t i = 0; i < pixels; ++i) times[i] += draw[i] != 0;
        }
        const glm::uvec4 t = p.list.triangles[first];
        const gpu::ScreenVertex centre = g.screen[t.x];
        const int cx = (centre.x - 128) >> 8, cy = (centre.y - 128) >> 8;
        for (int y = cy - 2; y <= cy + 2; ++y)
            for (int x = cx - 2; x <= cx + 2; ++x) {
                if (x < 0 || y < 0 || x >= int(row.width) || y >= int(row.height)) continue;
                ++exact;
                ASSERT_EQ(times[size_t(y) * row.width + size_t(x)], 1u)
                    << "pixel (" << x << ", " << y << ") of the fan at triangle " << first;
            }
        if (first > 6 * 40) break;  // all offsets have come up
    }
    EXPECT_GT(exact, 0u);
}

}  // namespace
}  // namespace plumb::test
