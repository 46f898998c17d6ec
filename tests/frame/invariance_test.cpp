// SPDX-License-Identifier: MIT
// Whole pictures: the same bytes on both sides, however the work is cut, whatever the plan drops, and under changes of the scene that
// cannot change the picture.
#include "host/error.h"
#include "pipeline/render/bounds/bound.h"
#include "shaders/shared/shade.h"
#include "tests/support/compare.h"
#include "tests/support/device_fixture.h"
#include "tests/support/scenes.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cfenv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

namespace plumb::test {
namespace {

RenderRequest requestOf(const SceneCase& c, Shading shading = Shading::phong, uint32_t samples = 1) {
    RenderRequest r;
    r.width = c.width;
    r.height = c.height;
    r.shading = shading;
    r.samples = samples;
    r.background = {0.1f, 0.5f, 0.02f};
    r.planes = kEveryPlane;
    if (shading == Shading::wire) r.planes = kPlaneColour | kPlaneLinear | kPlaneObject | kPlanePrimitive;
    return r;
}

const SceneCase kSoup{"soupLarge", soupLarge, 131, 67};
const SceneCase kInside{"inside", inside, 131, 67};
const SceneCase kSheet{"sheet", sheetOf24, 131, 67};
const SceneCase kSparse{"sparse", [](View v) { return soup(v, 6, 9, 6); }, 131, 67};  // most tiles are empty

class Frames : public DeviceTest {
protected:
    // Device and twin leave the same bytes, and not an empty picture; returns the twin's.
    Frame both(const Scene& scene, const RenderRequest& request) { return both(device(), scene, request); }
    static Frame both(Device& d, const Scene& scene, const RenderRequest& request) {
        const RenderResult twin = renderCpu(scene, request), gpu = renderGpu(d, scene, request);
        expectSameFrame(twin.frame, gpu.frame);
        EXPECT_GT(twin.frame.coveredPixels, 0u) << "an empty picture shows nothing";
        EXPECT_EQ(twin.counters.drawnTriangles, gpu.counters.drawnTriangles);
        return twin.frame;
    }
};

// Every shading of the raster.
std::vector<Shading> rasterShadings() {
    std::vector<Shading> shadings;
    for (const Choice<Shading>& row : kShadings)
        if (row.value != Shading::ray) shadings.push_back(row.value);
    return shadings;
}

TEST_F(Frames, AreEqualInEveryShadingWithEverySampleCount) {
    for (const SceneCase& row : {kSoup, kInside})
        for (Shading shading : rasterShadings())
            for (uint32_t samples : {1u, 4u, 16u}) {
                const bool transparent = (shading == Shading::phong) == (samples == 4);  // both with every count, over the shadings
                SCOPED_TRACE(fmt::format("{}, shading {}, {} samples, transparent {}", row.name, nameOf(shading), samples, transparent));
                RenderRequest request = requestOf(row, shading, samples);
                request.transparent = transparent;
                if (transparent) request.encoding = Encoding::linear;
                both(row.scene(), request);
            }
}

TEST_F(Frames, AreEqualWithEveryTrade) {
    std::vector<Trade> trades = {{.specular = Trade::Specular::schlick, .depthBits = 16, .unitNormals = false, .coarse = true}};
    for (const TradeAxis& axis : kTradeAxes)
        for (const TradeChoice& choice : axis.choices.subspan(1))
            if (choice.verdict == Verdict::bits) choice.choose(trades.emplace_back());
    for (const SceneCase& row : {kSoup, kInside})
        for (const Shading shading : {Shading::flat, Shading::gouraud, Shading::phong}) {
            if (row.build == kInside.build && shading != Shading::phong) continue;  // each is a kernel to compile
            const Scene scene = row.scene();
            const Frame plain = both(scene, requestOf(row, shading));
            for (const Trade& trade : trades) {
                SCOPED_TRACE(fmt::format("{}, shading {}, {}", row.name, nameOf(shading), wordsOf(trade)));
                RenderRequest request = requestOf(row, shading);
                request.trade = trade;
                const Frame traded = both(scene, request);
                // Shown on the picture in which there is a highlight, perspective and much that overlaps; 24 bits and 1 - n/w show in its depth alone; this
                // scene has no transform that could round, below.
                if (row.build != kSoup.build || shading != Shading::phong || trade.precision != Precision::fp32) continue;
                const bool inDepth = trade.depthBits == 24 || trade.depthBits == Trade::kStandardDepth;
                EXPECT_NE(inDepth ? plain.z : plain.linear, inDepth ? traded.z : traded.linear) << "the choice changed nothing";
            }
        }
}

// An object far from its own origin, near the eye: there the transform decides where a vertex lies. With chunks, and triangles that are clipped.
TEST_F(Frames, AreEqualInLongNumbersWhereFloat32MovesVertices) {
    for (const SceneCase& row : {kSoup, kInside}) {
        Scene scene = row.scene();
        for (TriangleMesh& mesh : scene.meshes) {
            for (glm::vec3& p : mesh.positions) p.x += 4096.0f;
            mesh.boundsMin.x += 4096.0f;
            mesh.boundsMax.x += 4096.0f;
        }
        for (Object& object : scene.objects) {
            object.worldFromObject[3] -= object.worldFromObject[0] * 4096.0;
            object.worldFromObject[0].x *= 1 + 0x1p-30;  // no float32
        }
        RenderRequest inFloat32 = requestOf(row);
        inFloat32.knobs.float32Only = true;  // else the plan takes more for the objects by itself
        const Frame plain = both(scene, inFloat32);
        for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
            RenderRequest request = requestOf(row);
            request.trade.precision = precision;
            const Frame longer = both(scene, request);
            EXPECT_NE(plain.linear, longer.linear) << "the choice changed nothing";
            request.knobs.chunkTriangles = row.build == kInside.build ? 7 : 500;
            request.knobs.bandRows = 24;
            expectSameFrame(longer, renderGpu(device(), scene, request).frame);
        }
    }
}

// Directions of faces and vertices, however many lights there are (windows of four), with and without places and attenuation, in chunks and bands.
TEST_F(Frames, AreEqualWithDirectionsOfFacesAndVertices) {
    for (const Trade::Vectors vectors : {Trade::Vectors::face, Trade::Vectors::vertex})
        for (const size_t lights : {2u, 5u}) {
            SCOPED_TRACE(fmt::format("vectors {}, {} lights", int(vectors), lights));
            Scene scene = kInside.scene();
            const std::vector<Light> kinds = scene.lights;
            ASSERT_FALSE(kinds.empty());
            scene.lights.clear();
            for (size_t i = 0; i < lights; ++i) {
                Light light = kinds[i % kinds.size()];
                light.directional = i % 3 == 1;
                light.direction = {0.3, 0.5, 1 + double(i)};
                light.position = {double(i) - 3, 2, 1 - double(i)};
                light.attenuation = Attenuation(i % 3);
                scene.lights.push_back(light);
            }
            RenderRequest request = requestOf(kInside);
            request.trade.vectors = vectors;
            request.trade.affine = lights == 2;
            request.trade.unitNormals = lights != 2;
            const Frame whole = both(scene, request);
            if (lights == 5 && vectors == Trade::Vectors::face) {  // places of faces are those of the chunk
                request.knobs.chunkTriangles = 30;
                request.knobs.bandRows = 40;
                expectSameFrame(whole, renderGpu(device(), scene, request).frame);
            }
            request.trade.coarse = true;
            EXPECT_THROW(renderCpu(scene, request), Error);
        }
    // A lamp at a corner shines from nowhere there, and nothing is not a number.
    Scene scene = kSoup.scene();
    for (const Trade::Vectors vectors : {Trade::Vectors::face, Trade::Vectors::vertex}) {
        Light lamp = scene.lights[0];
        lamp.directional = false;
        lamp.attenuation = Attenuation::inverseSquare;
        const TriangleMesh& mesh = scene.meshes[0];
        lamp.position = vectors == Trade::Vectors::face ? glm::dvec3(scene.objects[0].worldFromObject * glm::dvec4(mesh.faceCentre[0], 1))
                                                        : glm::dvec3(scene.objects[0].worldFromObject * glm::dvec4(mesh.positions[0], 1));
        scene.lights = {lamp};
        RenderRequest request = requestOf(kSoup);
        request.trade.vectors = vectors;
        for (const float x : both(scene, request).linear) ASSERT_FALSE(std::isnan(x));
    }
}

// Shading once in 2 x 2 pixels: the blocks lie in the frame, however it is cut into bands, with odd sizes and with samples.
TEST_F(Frames, AreEqualWhenShadedCoarsely) {
    for (const auto& [row, samples] : {std::pair(kSoup, 1u), std::pair(kInside, 4u)}) {
        const Scene scene = row.scene();
        RenderRequest request = requestOf(row, Shading::phong, samples);
        request.trade.coarse = true;
        const Frame want = both(scene, request);
        request.knobs.bandRows = 9;
        expectSameFrame(want, both(scene, request));
        request.knobs.chunkTriangles = 3;
        EXPECT_THROW(renderGpu(device(), scene, request), Error) << "the pixel that is shaded is not known in the first chunk";
    }
    // A sum that goes on in a second window of lights.
    Scene scene = kSoup.scene();
    Light dim = scene.lights[0];
    dim.intensity *= 1e-3f;
    scene.lights.assign(gpu::kLightsPerWindow + 3, dim);
    RenderRequest request = requestOf(kSoup);
    request.trade.coarse = true;
    both(scene, request);
}

// What the device's own power draws lies within its bound of the twin's, which differs from it: neither is the other by construction.
TEST_F(Frames, OfTheDevicesOwnFunctionsStayWithinTheirBound) {
    for (const auto& [row, shading, samples] :
         {std::tuple(kSoup, Shading::gouraud, 1u), std::tuple(kInside, Shading::flat, 1u), std::tuple(kSoup, Shading::phong, 4u)}) {
        const Scene scene = row.scene();
        RenderRequest request = requestOf(row, shading, samples);
        request.trade.specular = Trade::Specular::native;
        request.trade.nativeEncode = true;
        const VerifyReport report = verifyRender(device(), scene, request);
        EXPECT_TRUE(report.equal) << (report.mismatches.empty() ? "" : report.mismatches[0].what);
        EXPECT_TRUE(report.bounded);
        EXPECT_EQ(report.boundSteps, 1);
        for (const VerifyPlane& plane : report.planes) {
            EXPECT_EQ(plane.beyond, 0u) << plane.name;
            if (plane.name != "linear" && plane.name != "colour") {
                EXPECT_EQ(plane.differing, 0u) << plane.name;
            }
        }
    }
    // Schlick's quotient is further away than the bound of the power: the comparison can fail.
    const Scene scene = kSoup.scene();
    RenderRequest request = requestOf(kSoup);
    request.trade.specular = Trade::Specular::native;
    const double bound = boundOfNative(scene, request).linear.x;
    const std::vector<float> native = renderGpu(device(), scene, request).frame.linear;
    request.trade.specular = Trade::Specular::schlick;
    const std::vector<float> schlick = renderGpu(device(), scene, request).frame.linear;
    double apart = 0;
    for (size_t i = 0; i < native.size(); ++i) apart = std::max(apart, std::abs(double(native[i]) - double(schlick[i])));
    EXPECT_GT(apart, bound);
    EXPECT_GT(bound, 0);
}

// A library that was linked with -ffast-math, or a host program, may leave any of these behind.
TEST_F(Frames, DoNotDependOnTheCallersFloatEnvironment) {
    const SceneCase row{"inside", inside, 131, 67};
    const Scene scene = row.scene();
    const Frame want = both(scene, requestOf(row));
    for (const int rounding : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        SCOPED_TRACE(rounding);
        ASSERT_EQ(std::fesetround(rounding), 0);
        const Frame got = both(scene, requestOf(row));
        EXPECT_EQ(std::fegetround(), rounding) << "the caller's rounding is put back";
        std::fesetround(FE_TONEAREST);
        expectSameFrame(want, got);
    }
#ifdef __SSE2__
    constexpr unsigned kFlushToZero = 0x8000, kSubnormalsAreZero = 0x0040;
    const unsigned found = _mm_getcsr();
    _mm_setcsr(found | kFlushToZero | kSubnormalsAreZero);
    const Frame got = both(scene, requestOf(row));
    const unsigned left = _mm_getcsr();
    _mm_setcsr(found);
    EXPECT_EQ(left & (kFlushToZero | kSubnormalsAreZero), kFlushToZero | kSubnormalsAreZero) << "the caller's flags are put back";
    expectSameFrame(want, got);
#endif
}

TEST_F(Frames, AreEqualAtAwkwardSizes) {
    for (const SceneCase& row : sceneCases()) {
        SCOPED_TRACE(nameOf(row));
        both(row.scene(), requestOf(row));
    }
}

TEST_F(Frames, DoNotDependOnChunksAndBands) {
    for (const SceneCase& row : {kSoup, kInside, kSheet})
        for (Shading shading : {Shading::wire, Shading::flat, Shading::gouraud, Shading::phong}) {
            const Scene scene = row.scene();
            const Frame whole = renderGpu(device(), scene, requestOf(row, shading)).frame;
            ASSERT_GT(whole.coveredPixels, 0u);
            const std::pair<uint64_t, uint32_t> cuts[] = {{1, 0}, {7, 0}, {500, 0}, {0, 8}, {0, 24}, {0, 64}, {7, 24}, {500, 8}};
            for (const auto& [chunk, rows] : cuts) {
                if (chunk && chunk < 10 && scene.meshes[0].triangles.size() > 100) continue;  // hundreds of submissions: the others do it
                if (chunk == 500 && rows == 8 && shading != Shading::phong) continue;
                SCOPED_TRACE(fmt::format("{}, shading {}, chunks of {}, bands of {} rows", row.name, int(shading), chunk, rows));
                RenderRequest request = requestOf(row, shading);
                request.knobs.chunkTriangles = chunk;
                request.knobs.bandRows = rows;
                expectSameFrame(whole, renderGpu(device(), scene, request).frame);
            }
        }
}

// A scene that stays draws its bands in place, as often as asked.
TEST_F(Frames, OfAResidentSceneDoNotDependOnBands) {
    for (const SceneCase& row : {kSoup, kInside, kSheet, kSparse}) {
        const Scene scene = row.scene();
        RenderRequest request = requestOf(row, Shading::phong);
        request.background = {0.25f, 0.5f, 0.125f};
        request.transparent = true;
        request.planes = kPlaneColour;
        const Frame whole = renderGpu(device(), scene, request).frame;
        for (uint32_t rows : {0u, 8u, 24u}) {
            SCOPED_TRACE(fmt::format("{}, bands of {} rows", row.name, rows));
            request.knobs.bandRows = rows;
            // Buffers are recycled: what the resident scene finds shall not be its own picture, or empty tiles need not be cleared.
            RenderRequest other = request;
            other.background = {0.5f, 0.125f, 0.25f};
            renderGpu(device(), scene, other);
            ResidentScene resident(device(), scene, request);
            for (int again = 0; again < 2; ++again) {
                const ResidentScene::Picture picture = resident.draw();
                ASSERT_TRUE(resident.resident());
                ASSERT_EQ(picture.height, whole.height);
                EXPECT_EQ(resident.counters().bands, rows ? (whole.height + rows - 1) / rows : 1u);
                for (uint32_t y = 0; y < whole.height; ++y)
                    ASSERT_TRUE(std::equal(picture.pixels + size_t(y) * picture.pitch,
                                           picture.pixels + size_t(y) * picture.pitch + whole.width,
                                           whole.rgba.begin() + ptrdiff_t(size_t(y) * whole.width)))
                        << "row " << y;
            }
        }
    }
}

TEST_F(Frames, DoNotDependOnChunksAndBandsOfSamples) {
    const Scene scene = kInside.scene();
    for (uint32_t samples : {4u, 16u}) {
        const Frame whole = both(scene, requestOf(kInside, Shading::phong, samples));
        for (const auto& [chunk, rows] : {std::pair<uint64_t, uint32_t>{7, 0}, {0, 8}, {30, 24}}) {
            SCOPED_TRACE(fmt::format("{} samples, chunks of {}, bands of {} rows", samples, chunk, rows));
            RenderRequest request = requestOf(kInside, Shading::phong, samples);
            request.knobs.chunkTriangles = chunk;
            request.knobs.bandRows = rows;
            expectSameFrame(whole, renderGpu(device(), scene, request).frame);
        }
    }
}

// Only colour asked for: the kernel keeps no plane, unless chunks make it.
TEST_F(Frames, ColourAloneIsTheSameColour) {
    for (uint32_t samples : {1u, 4u}) {
        const Scene scene = kSoup.scene();
        RenderRequest request = requestOf(kSoup, Shading::phong, samples);
        const Frame all = renderGpu(device(), scene, request).frame;
        request.planes = kPlaneColour;
        for (uint64_t chunk : {0u, 7u}) {
            request.knobs.chunkTriangles = chunk;
            const Frame colour = renderGpu(device(), scene, request).frame;
            expectSamePlane("colour", all.width, 1, all.rgba, colour.rgba);
            EXPECT_EQ(all.coveredPixels, colour.coveredPixels);
        }
    }
}

TEST_F(Frames, DoNotDependOnTheTwinsThreadsAndBands) {
    for (Shading shading : rasterShadings()) {
        RenderRequest request = requestOf(kInside, shading, 4);
        request.threads = 1;
        const Frame one = renderCpu(kInside.scene(), request).frame;
        ASSERT_GT(one.coveredPixels, 0u);
        for (uint32_t threads : {2u, 3u, 8u}) {
            request.threads = threads;
            request.knobs.bandRows = threads * 5;
            expectSameFrame(one, renderCpu(kInside.scene(), request).frame);
        }
    }
}

// Devices whose limits are far below a scene's needs: more chunks and bands, the same bytes.
TEST_F(Frames, DoNotDependOnLimits) {
    for (const char* limits :
         {"storageRange=262144", "texelElements=65536", "storageRange=1048576,texelElements=131072", "groupCount=64"}) {
        SCOPED_TRACE(limits);
        const std::unique_ptr<Device> small = DeviceEnvironment::open(limits);
        uint64_t cuts = 0;
        for (const SceneCase& row : {SceneCase{"soupSmall", soupSmall, 131, 67}, SceneCase{"sheet", sheetOf24, 333, 211}, kInside})
            for (Shading shading : {Shading::gouraud, Shading::phong}) {
                SCOPED_TRACE(nameOf(row));
                const RenderRequest request = requestOf(row, shading);
                const Frame whole = renderCpu(row.scene(), request).frame;
                ASSERT_GT(whole.coveredPixels, 0u);
                const RenderResult got = renderGpu(*small, row.scene(), request);
                expectSameFrame(whole, got.frame);
                cuts = std::max(cuts, got.counters.chunks * got.counters.bands);
            }
        if (std::string(limits) == "storageRange=262144") {
            EXPECT_GT(cuts, 1u) << "the limits cut nothing: this row shows nothing";
        }
        expectNoValidationMessages(*small);
    }
}

// What the plan drops cannot change a byte: the same picture with everything kept. `triangle` counts over the objects that are
// drawn, so it may differ behind a dropped one.
void expectDropsNothingVisible(Device& device, const Scene& scene, const char* dropped, uint32_t leaveOut = 0) {
    for (Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
        SCOPED_TRACE(fmt::format("{}, shading {}", dropped, int(shading)));
        RenderRequest request = requestOf(kSoup, shading);
        const RenderResult lean = renderGpu(device, scene, request);
        const bool named = std::any_of(lean.plan.dropped.begin(), lean.plan.dropped.end(),
                                       [&](const Plan::Drop& d) { return d.what.find(dropped) != std::string::npos; });
        EXPECT_TRUE(named || shading == Shading::unlit) << "the plan does not name the drop";
        expectSameFrame(renderCpu(scene, request).frame, lean.frame);
        request.knobs.keepEverything = true;
        const RenderResult full = renderGpu(device, scene, request);
        expectSameFrame(full.frame, lean.frame, leaveOut);
        expectSameFrame(full.frame, renderCpu(scene, request).frame);
        EXPECT_GT(full.frame.coveredPixels, 0u);
    }
}

class Drops : public DeviceTest {};
TEST_F(Drops, NoLight) {
    Scene s = kSoup.scene();
    s.lights.clear();
    expectDropsNothingVisible(device(), s, "illumination");
}
TEST_F(Drops, NoSpecular) {
    Scene s = kSoup.scene();
    for (Material& m : s.materials) m.specular = glm::vec3(0);
    expectDropsNothingVisible(device(), s, "specular");
}
TEST_F(Drops, NoDiffuse) {
    Scene s = kSoup.scene();
    for (Material& m : s.materials) m.diffuse = glm::vec3(0);
    expectDropsNothingVisible(device(), s, "diffuse");
}
TEST_F(Drops, NothingReflects) {
    Scene s = kSoup.scene();
    for (Material& m : s.materials) m.diffuse = m.specular = glm::vec3(0);
    expectDropsNothingVisible(device(), s, "illumination");
}
TEST_F(Drops, NoPointLight) {
    Scene s = kSoup.scene();
    s.lights.resize(1);
    expectDropsNothingVisible(device(), s, "surface position");
}
TEST_F(Drops, ALightOfIntensityZero) {
    Scene s = kSoup.scene();
    s.lights[2].intensity = glm::vec3(0);
    expectDropsNothingVisible(device(), s, "light");
}
TEST_F(Drops, AnObjectOutsideTheView) {
    // Beyond each of the five sides of the view, behind the others in the list, then before them.
    const glm::dvec3 places[] = {{0, 0, 40}, {-500, 0, -3}, {500, 0, -3}, {0, -500, -3}, {0, 500, -3}};
    for (const glm::dvec3& place : places) {
        Scene s = kSoup.scene();
        Object away = s.objects[0];
        away.name = "away";
        away.worldFromObject[3] = glm::dvec4(place, 1);
        s.objects.push_back(away);
        expectDropsNothingVisible(device(), s, "away");
        std::swap(s.objects[0], s.objects[1]);
        expectDropsNothingVisible(device(), s, "away", kPlaneTriangle);
    }
}

// Changes of the scene that cannot change the picture, bit for bit.
class Metamorphic : public Frames {};

// Depth and distance scale; everything else stays. Exact, because every step is a product, a quotient or a root of powers of two
// apart, and nothing leaves the normal range.
TEST_F(Metamorphic, ScalingEverythingByAPowerOfTwo) {
    for (const SceneCase& row : {kSoup, kInside})
        for (Shading shading : rasterShadings()) {
            Scene plain = row.scene();
            for (Light& l : plain.lights) l.attenuation = Attenuation::none;
            plain.camera->eye = {0.125, -0.25, 0.5};
            for (Light& l : plain.lights) l.position += plain.camera->eye;
            plain.objects[0].worldFromObject[3] = glm::dvec4(plain.camera->eye, 1);
            const RenderRequest request = requestOf(row, shading);
            const Frame want = both(plain, request);
            for (int k : {-40, -3, 5, 40}) {
                SCOPED_TRACE(fmt::format("{}, shading {}, times 2^{}", row.name, int(shading), k));
                const double by = std::ldexp(1.0, k);
                Scene scaled = plain;
                for (TriangleMesh& m : scaled.meshes) {
                    for (glm::vec3& p : m.positions) p *= float(by);
                    for (glm::vec3& p : m.faceCentre) p *= float(by);
                    m.boundsMin *= float(by);
                    m.boundsMax *= float(by);
                }
                scaled.objects[0].worldFromObject[3] = glm::dvec4(plain.camera->eye * by, 1);
                scaled.camera->eye *= by;
                scaled.camera->near *= by;
                for (Light& l : scaled.lights) l.position *= by;
                Frame got = both(scaled, request);
                for (float& d : got.depth) d /= float(by);
                for (float& d : got.distance) d /= float(by);
                expectSameFrame(want, got);
            }
        }
}

// At exact screen positions: `count` triangles, each at a depth of its own, none of which ties.
std::vector<Corners> exactTriangles(View v, uint32_t count, double shiftX, double shiftY) {
    Random r(59);
    std::vector<Corners> t(count);
    for (uint32_t i = 0; i < count; ++i) {
        // A power of two keeps x w exact; the depth within an octave would not: pixels are whole multiples of 1/16, so w may be any
        // multiple of 1/8 below 16.
        const double w = 1 + i / 8.0;
        const double x = std::floor(r(20, v.width - 20)), y = std::floor(r(20, v.height - 20));
        for (glm::vec3& p : t[i]) p = v.pointAt(x + std::floor(r(-256, 256)) / 16 + shiftX, y + std::floor(r(-256, 256)) / 16 + shiftY, w);
    }
    return t;
}

TEST_F(Metamorphic, ShiftingByWholePixels) {
    const SceneCase row{"exact", nullptr, 131, 67};
    const RenderRequest request = requestOf(row, Shading::unlit);
    const Frame want = both(sceneOf(exactTriangles(row.view(), 60, 0, 0)), request);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {-5, 3}, {17, -9}}) {
        SCOPED_TRACE(fmt::format("by ({}, {})", dx, dy));
        const Frame got = both(sceneOf(exactTriangles(row.view(), 60, dx, dy)), request);
        size_t drawn = 0;
        for (int y = 0; y < int(row.height); ++y)
            for (int x = 0; x < int(row.width); ++x) {
                const int fromX = x - dx, fromY = y - dy;
                if (fromX < 0 || fromY < 0 || fromX >= int(row.width) || fromY >= int(row.height)) continue;
                const size_t a = size_t(fromY) * row.width + size_t(fromX), b = size_t(y) * row.width + size_t(x);
                ASSERT_EQ(want.triangle[a], got.triangle[b]) << "pixel (" << x << ", " << y << ")";
                ASSERT_EQ(std::bit_cast<uint32_t>(want.z[a]), std::bit_cast<uint32_t>(got.z[b])) << "pixel (" << x << ", " << y << ")";
                ASSERT_EQ(want.rgba[a], got.rgba[b]) << "pixel (" << x << ", " << y << ")";
                drawn += got.triangle[b] != kNone;
            }
        EXPECT_GT(drawn, 0u);
    }
}

TEST_F(Metamorphic, RotatingTheCornersOfTriangles) {
    for (const SceneCase& row : {kSoup, kSheet, SceneCase{"equalDepths", equalDepths, 131, 67}, SceneCase{"huge", huge, 131, 67}})
        for (Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
            SCOPED_TRACE(fmt::format("{}, shading {}", row.name, int(shading)));
            Scene scene = row.scene();
            const RenderRequest request = requestOf(row, shading);
            const Frame want = both(scene, request);
            uint32_t turn = 0;
            for (TriangleMesh::Triangle& t : scene.meshes[0].triangles) std::rotate(t.vertex, t.vertex + 1 + turn++ % 2, t.vertex + 3);
            expectSameFrame(want, both(scene, request));
        }
}

TEST_F(Metamorphic, PermutingTriangles) {
    const SceneCase row{"exact", nullptr, 131, 67};
    const Scene scene = sceneOf(exactTriangles(row.view(), 60, 0, 0));
    for (Shading shading : {Shading::flat, Shading::gouraud, Shading::phong}) {
        const RenderRequest request = requestOf(row, shading);
        const Frame want = both(scene, request);
        for (uint32_t seed : {1u, 2u}) {
            Scene permuted = scene;
            Random r(seed);
            auto& t = permuted.meshes[0].triangles;
            for (size_t i = t.size() - 1; i > 0; --i) std::swap(t[i], t[r.below(uint32_t(i + 1))]);
            expectSameFrame(want, both(permuted, request), kPlaneTriangle);  // faces keep their numbers, triangles do not
        }
    }
}

TEST_F(Metamorphic, SplittingAMeshIntoTwoObjects) {
    for (const SceneCase& row : {kSoup, kInside, kSheet})
        for (Shading shading : rasterShadings()) {
            SCOPED_TRACE(fmt::format("{}, shading {}", row.name, int(shading)));
            const Scene scene = row.scene();
            const RenderRequest request = requestOf(row, shading);
            Scene split = scene;
            split.meshes.push_back(scene.meshes[0]);
            Object second = scene.objects[0];
            second.mesh = 1;
            split.objects.push_back(second);
            auto &a = split.meshes[0], &b = split.meshes[1];
            const auto half = ptrdiff_t(a.triangles.size() / 2), halfEdges = ptrdiff_t(a.edges.size() / 2);
            a.triangles.erase(a.triangles.begin() + half, a.triangles.end());
            b.triangles.erase(b.triangles.begin(), b.triangles.begin() + half);
            a.edges.erase(a.edges.begin() + halfEdges, a.edges.end());
            b.edges.erase(b.edges.begin(), b.edges.begin() + halfEdges);
            expectSameFrame(both(scene, request), both(split, request), kPlaneObject);
        }
}

TEST_F(Metamorphic, AddingWhatIsNotSeen) {
    for (Shading shading : rasterShadings()) {
        SCOPED_TRACE(fmt::format("shading {}", int(shading)));
        const Scene scene = kSoup.scene();
        const RenderRequest request = requestOf(kSoup, shading);
        const Frame want = both(scene, request);
        Scene more = scene;
        Object away = scene.objects[0];
        away.worldFromObject[3] = {0, 0, 100, 1};
        more.objects.push_back(away);
        Light dark = scene.lights[1];
        dark.intensity = glm::vec3(0);
        more.lights.push_back(dark);
        expectSameFrame(want, both(more, request));
        RenderRequest kept = request;
        kept.knobs.keepEverything = true;
        expectSameFrame(want, both(more, kept));
    }
}

}  // namespace
}  // namespace plumb::test
