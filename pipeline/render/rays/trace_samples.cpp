// SPDX-License-Identifier: MIT
#include "pipeline/render/rays/trace_samples.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <mutex>
#include <span>
#include <vector>

namespace plumb {

SampleGrid sampleGridOf(const Prepared& p, const RenderRequest& request) {
    using Sampling = RayChoices::Sampling;
    SampleGrid g;
    g.side = g.stride = p.side;
    g.anchor = p.side / 2;
    switch (request.rays.sampling) {
        case Sampling::grid:
            break;
        case Sampling::centre:
            g.sampling = gpu::kSampleCentre;
            break;
        case Sampling::random:
            g.sampling = gpu::kSampleRandom;
            break;
        case Sampling::notes:
            g.sampling = gpu::kSampleNotes;
            break;
        case Sampling::corners:
        case Sampling::adaptive:
            g.sampling = gpu::kSampleCorner;
            g.side = 2;
            g.stride = 1;
            g.anchor = 0;
            break;
    }
    g.width = g.pitch = (p.width - 1) * g.stride + g.side;
    g.height = g.rowsFor(p.height);
    return g;
}

std::vector<uint32_t> pixelsWithDifferentCorners(uint32_t width, uint32_t firstRow, uint32_t rows, uint32_t encoding,
                                                 const std::function<glm::vec3(uint32_t, uint32_t)>& colour,
                                                 const std::function<bool(uint32_t, uint32_t)>& covered, uint32_t threads) {
    // Alpha says whether the sample is covered.
    std::vector<uint32_t> codes(size_t(width + 1) * (rows + 1));
    parallelBands(rows + 1, 8, threads, [&](uint64_t begin, uint64_t end) {
        for (auto y = uint32_t(begin); y < end; ++y)
            for (uint32_t x = 0; x <= width; ++x) {
                const glm::vec3 c = colour(x, y);
                codes[size_t(y) * (width + 1) + x] = encodePixelCpu(encoding, &c.x, covered(x, y) ? 255 : 0);
            }
    });
    const auto far = [](uint32_t a, uint32_t b) {
        for (int shift = 0; shift < 32; shift += 8)
            if (std::abs(int(a >> shift & 255) - int(b >> shift & 255)) > kCornerLevels) return true;
        return false;
    };
    std::vector<uint32_t> pixels;
    for (uint32_t y = 0; y < rows; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const uint32_t* row = &codes[size_t(y) * (width + 1) + x];
            const uint32_t corner[4] = {row[0], row[1], row[width + 1], row[width + 2]};
            bool differ = false;
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < i; ++j) differ |= far(corner[i], corner[j]);
            if (differ) pixels.push_back(x | (firstRow + y) << 16);
        }
    return pixels;
}

gpu::TracePush finePushOf(const gpu::TracePush& push, uint32_t count) {
    gpu::TracePush fine = push;
    fine.rayX /= float(kFineSide);  // a power of two: the rays of --samples 16, to the bit
    fine.rayY /= float(kFineSide);
    fine.width = fine.rowWords = count * kFineSide;
    fine.planeWords = fine.rowWords * kFineSide;
    fine.firstRow = 0;
    return fine;
}

RaySeen::RaySeen(const Prepared& p, const Scene& scene, const RenderRequest& request, const SampleGrid& grid)
    : p_(p), scene_(scene), seed_(request.rays.seed), grid_(grid) {
    uint32_t triangles = 0;
    for (const Object& object : scene.objects) {
        firstOfObject_.push_back(triangles);
        triangles += uint32_t(scene.meshes[object.mesh].triangles.size());
    }
}

const RaySeen& RaySeen::at(uint32_t x, uint32_t y, uint32_t distanceBits, uint32_t object, const glm::vec3& normal) {
    x_ = x;
    y_ = y;
    distance_ = double(gpu::realOf(int(distanceBits))) / p_.unit;
    object_ = object;
    normal_ = normal;
    return *this;
}

float RaySeen::depth() const {
    const uint32_t column = x_ * grid_.stride + grid_.anchor, row = y_ * grid_.stride + grid_.anchor,
                   key = gpu::keyOfSample(column, row, seed_);
    const glm::dvec3 ray = glm::dvec3(p_.rayOrigin) + glm::dvec3(p_.rayX) * double(gpu::columnOf(grid_.sampling, column, p_.side, key)) +
                           glm::dvec3(p_.rayY) * double(gpu::rowOf(grid_.sampling, row, p_.side, key));
    return float(distance_ / std::sqrt(glm::dot(ray, ray)));
}

uint32_t RaySeen::meshObject() const {
    const uint32_t triangle = object_ - wholeShapes();
    return uint32_t(std::upper_bound(firstOfObject_.begin(), firstOfObject_.end(), triangle) - firstOfObject_.begin()) - 1;
}

uint32_t RaySeen::object() const { return object_ < wholeShapes() ? uint32_t(scene_.objects.size()) + object_ : meshObject(); }

uint32_t RaySeen::primitive() const {
    if (object_ < wholeShapes()) return 0;  // a sphere or plane is one primitive
    const uint32_t object = meshObject(), triangle = object_ - wholeShapes() - firstOfObject_[object];
    return scene_.meshes[scene_.objects[object].mesh].triangles[triangle].face;
}

void countParts(const TraceScene& traced, RenderCounters& c) {
    c.triangles = c.drawnTriangles = traced.triangles.size() / 2;
    c.vertices = traced.corners.size() / 2;
    c.objectsDrawn = c.objects;
}

void addRayCounts(std::span<const uint64_t> words, uint32_t maxDepth, RenderCounters& c) {
    c.rays.resize(maxDepth);
    for (uint32_t depth = 0; depth < maxDepth; ++depth) {
        const uint64_t* at = &words[size_t(depth) * gpu::kCountKinds];
        c.rays[depth].primary += at[gpu::kCountPrimary];
        c.rays[depth].reflected += at[gpu::kCountReflected];
        c.rays[depth].refracted += at[gpu::kCountRefracted];
        c.rays[depth].shadowRays += at[gpu::kCountShadowRays];
    }
    c.undecidedRays += words[gpu::kCountUndecided];
}

void reportTrace(const RenderRequest& request, double done) {
    if (request.onProgress && !request.onProgress(done)) throw Error(Exit::interrupted, "interrupted");
}

}  // namespace plumb
