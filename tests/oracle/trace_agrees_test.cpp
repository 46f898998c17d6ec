// SPDX-License-Identifier: MIT
// Raster and rays see the same primitive, and no ray passes between the triangles of a closed mesh.
#include "pipeline/passes/tree.h"
#include "pipeline/render/rays/trace_frame.h"
#include "tests/support/ray_scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

// The raster snaps vertices to 1/256 px: half of that. Before, float32 moves them by 2^-12 px at this size (docs/derivations.md#vertices):
// 12 u of coordinates below 2^7 px from the centre, twice, since both sides round.
constexpr double kEdge = 0x1p-9 + 0x1p-12;

class RasterAndRays : public ::testing::TestWithParam<std::string> {};

double distanceToSegment(glm::dvec2 p, glm::dvec2 a, glm::dvec2 b) {
    const glm::dvec2 e = b - a;
    const double length = glm::dot(e, e), t = length > 0 ? std::clamp(glm::dot(p - a, e) / length, 0.0, 1.0) : 0;
    return glm::length(p - a - t * e);
}

TEST_P(RasterAndRays, SeeTheSamePrimitive) {
    constexpr uint32_t kWidth = 211, kHeight = 157;
    Scene scene = committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes" / GetParam(), {kWidth, kHeight});
    scene.cullBackFaces = false;  // rays keep both sides
    RenderRequest request;
    request.width = kWidth;
    request.height = kHeight;
    request.maxDepth = 1;
    request.planes = kPlaneColour | kPlaneObject | kPlanePrimitive | kPlaneDepth;
    const Frame raster = renderCpu(scene, request).frame;
    request.shading = Shading::ray;
    const Frame rays = renderCpu(scene, request).frame;
    const Camera& camera = *scene.camera;
    const double focal = camera.focalPixels > 0 ? camera.focalPixels : kHeight / 2.0 / std::tan(glm::radians(camera.fovYDegrees / 2));
    // Projected triangles of a primitive.
    const auto nearEdge = [&](uint32_t object, uint32_t primitive, glm::dvec2 pixel) {
        if (object == kNone) return false;
        const Object& o = scene.objects[object];
        const TriangleMesh& mesh = scene.meshes[o.mesh];
        for (const TriangleMesh::Triangle& t : mesh.triangles) {
            if (t.face != primitive) continue;
            glm::dvec2 corner[3];
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3 p = glm::dvec3(o.worldFromObject * glm::dvec4(mesh.positions[t.vertex[k]], 1)) - camera.eye;
                const double w = glm::dot(p, camera.forward);
                corner[k] = {kWidth / 2.0 + focal * glm::dot(p, camera.right) / w, kHeight / 2.0 - focal * glm::dot(p, camera.up) / w};
            }
            for (int k = 0; k < 3; ++k)
                if (distanceToSegment(pixel, corner[k], corner[(k + 1) % 3]) <= kEdge) return true;
        }
        return false;
    };
    int differing = 0, covered = 0, equalDepth = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            const size_t i = size_t(y) * kWidth + x;
            covered += raster.object[i] != kNone;
            if (raster.object[i] == rays.object[i] && raster.primitive[i] == rays.primitive[i]) continue;
            ++differing;
            const glm::dvec2 pixel(x + 0.5, y + 0.5);
            if (nearEdge(raster.object[i], raster.primitive[i], pixel) || nearEdge(rays.object[i], rays.primitive[i], pixel)) continue;
            // Two surfaces at one place: the depth decides, which is known to 13 u of z (docs/accuracy.md#depth). A ray's distance is known as
            // well.
            const double a = raster.depth[i], b = rays.depth[i];
            if (std::isfinite(a) && std::isfinite(b) && std::abs(a - b) <= 32 * 0x1p-24 * a) {
                ++equalDepth;
                continue;
            }
            ADD_FAILURE() << fmt::format("pixel ({}, {}): raster has object {} primitive {} at {}, rays have object {} primitive {} at {}",
                                         x, y, int(raster.object[i]), int(raster.primitive[i]), a, int(rays.object[i]),
                                         int(rays.primitive[i]), b);
        }
    std::printf("%s: %d pixels covered, %d differ within %.5f px of an edge, %d of them at equal depth\n", GetParam().c_str(), covered,
                differing, kEdge, equalDepth);
    EXPECT_GT(covered, 1000);
}

// Every mesh file under scenes/, so that none is forgotten.
std::vector<std::string> committedMeshes() {
    const std::filesystem::path scenes = std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes";
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(scenes)) {
        const std::string extension = entry.path().extension().string();
        if (extension == ".obj" || extension == ".ply" || extension == ".off" || extension == ".stl" || extension == ".gltf" ||
            extension == ".glb")
            names.push_back(std::filesystem::relative(entry.path(), scenes).generic_string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

INSTANTIATE_TEST_SUITE_P(Meshes, RasterAndRays, ::testing::ValuesIn(committedMeshes()), [](const auto& info) {
    std::string name = info.param;
    std::replace_if(
        name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    return name;
});

// Row 15: rays from inside a closed mesh through its vertices and edges, at every scale and far from the origin: each meets it.
TEST(TraceStress, NoRayLeaksThroughAClosedMesh) {
    Random r(115);
    uint64_t asked = 0, leaks = 0;
    for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const double offset : {0.0, 1.0, 1e3, 1e6}) {
            Scene scene;
            addMeshFile(scene, std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/procedural/icosphere.ply", {});
            const TriangleMesh& mesh = scene.meshes[0];
            const glm::dvec3 centre = glm::dvec3(0.6, -0.5, 0.62) * offset * scale;
            std::vector<glm::vec3> corners;
            float reach = 0;
            for (const TriangleMesh::Triangle& t : mesh.triangles)
                for (const uint32_t v : t.vertex) {
                    corners.emplace_back(glm::vec3(centre + scale * glm::dvec3(mesh.positions[v])));
                    for (int k = 0; k < 3; ++k) reach = std::max(reach, std::abs(corners.back()[k]));
                }
            const TriangleTree tree = treeOfTriangles(corners);
            const std::vector<glm::uvec4>& nodes = tree.nodes;
            ASSERT_EQ(tree.leaves.size(), mesh.triangles.size());
            const auto floats = [](const glm::uvec4& words) {
                return glm::vec3(gpu::realOf(int(words.x)), gpu::realOf(int(words.y)), gpu::realOf(int(words.z)));
            };
            // A million radii away all boxes are alike, and every ray opens all of them.
            const bool all = std::getenv("PLUMB_LONG") != nullptr;
            const int rays = offset < 1e6 ? (all ? 1000000 : 66400) : all ? 100000 : 1000;  // 1,001,000 in all, or a million each
            for (int i = 0; i < rays; ++i) {
                const size_t triangle = size_t(r(0, double(mesh.triangles.size()) - 0.001));
                const glm::vec3 &a = corners[3 * triangle + size_t(i % 3)], &b = corners[3 * triangle + size_t((i + 1) % 3)];
                const glm::vec3 target = i % 2 ? a : a + (b - a) * float(r(0, 1));
                const glm::vec3 o(centre + scale * 0.3 * glm::dvec3(r.direction()));
                const glm::vec3 d = gpu::unitLength(
                    (target - o) * (1 / std::max({std::abs(target.x - o.x), std::abs(target.y - o.y), std::abs(target.z - o.z)})));
                const gpu::RayFrame frame = gpu::frameOfRay(o, d, reach);
                float t = gpu::kFarthestHit;
                uint32_t best = gpu::kNoObject, bruteBest = gpu::kNoObject;
                for (uint32_t child = 0; child < nodes.size() / 2;) {
                    const glm::uvec4 &low = nodes[2 * child], &high = nodes[2 * child + 1];
                    const bool open =
                        gpu::opens(gpu::entryOfBox(frame, floats(low), floats(high)), gpu::exitOfBox(frame, floats(low), floats(high)), t);
                    const bool leaf = low.w & gpu::kLeaf;
                    if (open && leaf) {
                        const uint32_t k = tree.leaves[low.w & ~gpu::kLeaf];
                        const gpu::TriangleHit hit = gpu::hitTriangle(frame, corners[3 * k], corners[3 * k + 1], corners[3 * k + 2], false);
                        if (gpu::isNearer(hit.t, k, t, best)) t = hit.t, best = k;
                    }
                    child = open && !leaf ? low.w * gpu::kNodeChildren : high.w;
                }
                ++asked;
                leaks += best == gpu::kNoObject;
                if (i % 500) continue;
                float bruteT = gpu::kFarthestHit;
                for (uint32_t k = uint32_t(corners.size() / 3); k-- > 0;) {
                    const gpu::TriangleHit hit = gpu::hitTriangle(frame, corners[3 * k], corners[3 * k + 1], corners[3 * k + 2], false);
                    if (gpu::isNearer(hit.t, k, bruteT, bruteBest)) bruteT = hit.t, bruteBest = k;
                }
                EXPECT_EQ(best, bruteBest) << "scale " << scale << ", offset " << offset << ", ray " << i;
            }
        }
    std::printf("row 15: %llu rays, %llu leaks\n", static_cast<unsigned long long>(asked), static_cast<unsigned long long>(leaks));
    EXPECT_EQ(leaks, 0u);
}

}  // namespace
}  // namespace plumb::test
