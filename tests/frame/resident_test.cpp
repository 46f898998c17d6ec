// SPDX-License-Identifier: MIT
// A resident scene draws every plane as renderGpu does, from every camera and with its objects anywhere, and says when it had to upload.
#include "host/error.h"
#include "tests/support/compare.h"
#include "tests/support/device_fixture.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/scenes.h"

#include <fmt/format.h>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

constexpr uint32_t kSeen = kEveryPlane & ~uint32_t(kPlaneTriangle);
const SceneCase kSoup{"soupLarge", soupLarge, 131, 67};
const SceneCase kInside{"inside", inside, 131, 67};

class Resident : public DeviceTest {
protected:
    // Draws the pose in both ways and compares every plane; `pose` is that of the scene from then on.
    void expectSameAt(ResidentScene& resident, Scene& scene, const RenderRequest& request, const Pose& pose) {
        if (pose.camera) scene.camera = pose.camera;
        for (size_t i = 0; i < pose.worldFromObject.size(); ++i) scene.objects[i].worldFromObject = pose.worldFromObject[i];
        const Frame want = renderGpu(device(), scene, request).frame;
        const ResidentScene::Picture picture = resident.draw(pose);
        ASSERT_NE(picture.frame, nullptr);
        expectSameFrame(want, *picture.frame);
        EXPECT_EQ(picture.pixels, picture.frame->rgba.data());
        EXPECT_EQ(picture.pitch, request.width);
        covered_ += want.coveredPixels;
    }
    uint64_t covered_ = 0;
};

// Cameras beside, above and within the scene of `first`.
std::vector<Camera> camerasFrom(const Camera& first) {
    std::vector<Camera> cameras;
    const double step = first.focusDistance;
    for (const glm::dvec3& by : {glm::dvec3(0.3, 0, 0), glm::dvec3(-0.2, 0.4, 0.1), glm::dvec3(0, 0, 0.4), glm::dvec3(0, 0, -2)}) {
        Camera camera = first;
        camera.eye += step * (by.x * first.right + by.y * first.up + by.z * first.forward);
        cameras.push_back(camera);
    }
    Camera wide = first;
    wide.focalPixels = 0;
    wide.fovYDegrees = 100;
    cameras.push_back(wide);
    return cameras;
}

RenderRequest requestOf(const SceneCase& row, Shading shading, uint32_t samples, uint32_t planes = kSeen) {
    RenderRequest request;
    request.width = row.width;
    request.height = row.height;
    request.shading = shading;
    request.samples = samples;
    request.background = {0.1f, 0.5f, 0.02f};
    request.planes = planes;
    return request;
}

TEST_F(Resident, DrawsEveryPlaneFromEveryCameraWithoutAnUpload) {
    for (const SceneCase& row : {kSoup, kInside})
        for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong})
            for (const uint32_t samples : {1u, 4u}) {
                if (shading != Shading::phong && (samples == 4 || row.build == kInside.build)) continue;  // each is a kernel to compile
                SCOPED_TRACE(fmt::format("{}, shading {}, {} samples", row.name, int(shading), samples));
                Scene scene = row.scene();
                RenderRequest request = requestOf(row, shading, samples);
                request.transparent = samples == 4 && shading == Shading::phong;
                const Camera first = *scene.camera;
                ResidentScene resident(device(), scene, request);
                expectSameAt(resident, scene, request, {});
                for (const Camera& camera : camerasFrom(first)) {
                    expectSameAt(resident, scene, request, {.camera = camera});
                    EXPECT_TRUE(resident.resident());
                }
                expectSameAt(resident, scene, request, {});  // stays where it was
                expectSameAt(resident, scene, request, {.camera = first});
                EXPECT_TRUE(resident.resident());
            }
    EXPECT_GT(covered_, 0u) << "empty pictures show nothing";
}

TEST_F(Resident, DrawsWithEveryChoiceThatDependsOnTheView) {
    std::vector<RenderRequest> requests(6, requestOf(kSoup, Shading::phong, 1));
    requests[0].trade.vectors = Trade::Vectors::face;
    requests[1].trade.vectors = Trade::Vectors::scene;
    requests[2].trade.precision = Precision::blockInteger;
    requests[3].trade.precision = Precision::fp64;
    requests[4].distantViewer = true;
    requests[5].knobs.bandRows = 24;
    for (size_t i = 0; i < requests.size(); ++i) {
        SCOPED_TRACE(i);
        Scene scene = kSoup.scene();
        const Camera first = *scene.camera;
        Light lamp;
        lamp.directional = false;
        lamp.position = first.eye + first.up * (0.3 * first.focusDistance);
        lamp.attenuation = Attenuation::inverse;
        scene.lights.push_back(lamp);
        ResidentScene resident(device(), scene, requests[i]);
        for (const Camera& camera : camerasFrom(first)) {
            expectSameAt(resident, scene, requests[i], {.camera = camera});
            EXPECT_TRUE(resident.resident());
        }
    }
}

TEST_F(Resident, MovesItsObjectsInAndOutOfViewWithoutAnUpload) {
    for (const Shading shading : {Shading::flat, Shading::phong}) {
        Scene scene = kSoup.scene();
        scene.objects.push_back(scene.objects[0]);
        const RenderRequest request = requestOf(kSoup, shading, 1);
        ResidentScene resident(device(), scene, request);
        const Camera& camera = *scene.camera;
        const glm::dmat4 own = scene.objects[0].worldFromObject;
        const double step = camera.focusDistance;
        const auto moved = [&](const glm::dvec3& by) {
            return glm::translate(glm::dmat4(1), step * (by.x * camera.right + by.y * camera.up + by.z * camera.forward)) * own;
        };
        const std::vector<std::vector<glm::dmat4>> poses = {{own, moved({0.3, 0.1, 0.2})},
                                                            {moved({100, 0, 0}), glm::scale(own, glm::dvec3(0.5, 2, 0.25))},
                                                            {moved({-0.2, 0, 0}), moved({0, 100, 0})},
                                                            {moved({0, 0, -50}), moved({0, 0, -50})},
                                                            {glm::rotate(own, 1.0, glm::dvec3(0.6, 0.8, 0)), own}};
        for (size_t i = 0; i < poses.size(); ++i) {
            SCOPED_TRACE(fmt::format("shading {}, pose {}", int(shading), i));
            expectSameAt(resident, scene, request, {.worldFromObject = poses[i]});
            EXPECT_TRUE(resident.resident());
        }
        expectSameAt(resident, scene, request, {.camera = camerasFrom(camera)[1], .worldFromObject = poses[0]});
        EXPECT_TRUE(resident.resident());
        // A mirror turns the triangles round: another list.
        const std::vector<glm::dmat4> mirrored = {glm::scale(own, glm::dvec3(-1, 1, 1)), own};
        expectSameAt(resident, scene, request, {.worldFromObject = mirrored});
        EXPECT_FALSE(resident.resident());
        expectSameAt(resident, scene, request, {});
        EXPECT_TRUE(resident.resident());
    }
}

// The index of a triangle counts the triangles of what is in view.
TEST_F(Resident, CountsTrianglesAsTheViewDoes) {
    Scene scene = kSoup.scene();
    scene.objects.push_back(scene.objects[0]);
    const RenderRequest request = requestOf(kSoup, Shading::phong, 1, kEveryPlane);
    ResidentScene resident(device(), scene, request);
    const glm::dmat4 own = scene.objects[0].worldFromObject;
    const glm::dmat4 away = glm::translate(glm::dmat4(1), 100 * scene.camera->focusDistance * scene.camera->right) * own;
    for (const auto& pose : {std::vector<glm::dmat4>{away, own}, {own, away}, {own, own}}) {
        expectSameAt(resident, scene, request, {.worldFromObject = pose});
        EXPECT_FALSE(resident.resident());
        expectSameAt(resident, scene, request, {});
        EXPECT_TRUE(resident.resident());
    }
}

TEST_F(Resident, DrawsWhatCannotStayAsAWholeAndSaysSo) {
    RenderRequest chunks = requestOf(kInside, Shading::phong, 1), wire = requestOf(kInside, Shading::wire, 1),
                  notes = requestOf(kInside, Shading::phong, 1);
    chunks.knobs.chunkTriangles = 7;
    wire.planes = kPlaneColour | kPlaneLinear | kPlaneObject | kPlanePrimitive;
    notes.fill = Fill::notes;
    for (const RenderRequest& request : {chunks, wire, notes}) {
        SCOPED_TRACE(
            fmt::format("shading {}, fill {}, chunks of {}", int(request.shading), int(request.fill), request.knobs.chunkTriangles));
        Scene scene = kInside.scene();
        const Camera first = *scene.camera;
        ResidentScene resident(device(), scene, request);
        for (const Camera& camera : {first, camerasFrom(first)[0]}) {
            expectSameAt(resident, scene, request, {.camera = camera});
            EXPECT_FALSE(resident.resident());
        }
    }
}

TEST_F(Resident, KeepsATracedSceneForOneCamera) {
    Scene scene = kInside.scene();
    const Camera first = *scene.camera;
    for (const uint32_t samples : {1u, 4u}) {
        const RenderRequest request = requestOf(kInside, Shading::ray, samples);
        scene.camera = first;
        ResidentScene resident(device(), scene, request);
        for (int again = 0; again < 2; ++again) {
            expectSameAt(resident, scene, request, {});
            EXPECT_TRUE(resident.resident());
        }
        expectSameAt(resident, scene, request, {.camera = camerasFrom(first)[0]});
        EXPECT_FALSE(resident.resident());
        expectSameAt(resident, scene, request, {});
        EXPECT_TRUE(resident.resident());
    }
}

// Colour alone is left where the device wrote it; its alpha is coverage.
TEST_F(Resident, LeavesColourAloneInPlaceFromEveryCamera) {
    Scene scene = kSoup.scene();
    RenderRequest request = requestOf(kSoup, Shading::phong, 1, kPlaneColour);
    request.transparent = true;
    ResidentScene resident(device(), scene, request);
    for (const Camera& camera : camerasFrom(*scene.camera)) {
        scene.camera = camera;
        const Frame want = renderGpu(device(), scene, request).frame;
        const ResidentScene::Picture picture = resident.draw({.camera = camera});
        EXPECT_EQ(picture.frame, nullptr);
        EXPECT_TRUE(resident.resident());
        for (uint32_t y = 0; y < want.height; ++y)
            for (uint32_t x = 0; x < want.width; ++x)
                ASSERT_EQ(picture.pixels[size_t(y) * picture.pitch + x], want.rgba[size_t(y) * want.width + x]) << x << ", " << y;
    }
}

TEST_F(Resident, RefusesAPoseThatCannotBeDrawnAndKeepsTheLast) {
    Scene scene = kSoup.scene();
    const RenderRequest request = requestOf(kSoup, Shading::phong, 1);
    ResidentScene resident(device(), scene, request);
    expectSameAt(resident, scene, request, {.camera = camerasFrom(*scene.camera)[0]});
    const auto refusal = [&](const Pose& pose, Exit exit) {
        try {
            resident.draw(pose);
        } catch (const Error& error) {
            EXPECT_EQ(error.exit(), exit);
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    const std::vector<glm::dmat4> tooMany(scene.objects.size() + 1, glm::dmat4(1));
    EXPECT_EQ(refusal({.worldFromObject = tooMany}, Exit::usage),
              fmt::format("a pose has {} matrices, and the scene has {} objects", tooMany.size(), scene.objects.size()));
    Camera camera = *scene.camera;
    camera.eye.x = std::nan("");
    EXPECT_NE(refusal({.camera = camera}, Exit::input).find("eye has a coordinate that is no number"), std::string::npos);
    std::vector<glm::dmat4> matrices(scene.objects.size(), glm::dmat4(1));
    matrices[0][1][1] = std::numeric_limits<double>::infinity();
    EXPECT_NE(refusal({.worldFromObject = matrices}, Exit::input).find("worldFromObject has an entry"), std::string::npos);
    matrices[0] = glm::scale(glm::dmat4(1), glm::dvec3(0x1p90));  // in view, and further than the passes count
    EXPECT_NE(refusal({.worldFromObject = matrices}, Exit::input).find("it reaches further from the eye"), std::string::npos);
    expectSameAt(resident, scene, request, {});
    expectSameAt(resident, scene, request, {});
    EXPECT_TRUE(resident.resident());
}

}  // namespace
}  // namespace plumb::test
