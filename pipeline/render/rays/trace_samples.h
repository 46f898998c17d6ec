// SPDX-License-Identifier: MIT
// Code that both sides of a traced picture share: the layout of samples, the pixels that need more of them, and planes from samples.
#pragma once

#include "pipeline/render/planes.h"
#include "pipeline/render/rays/trace_frame.h"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// The samples of a whole picture. Pixels that share their corners have a side of 2 and a stride of 1.
struct SampleGrid : SampleLayout {
    uint32_t sampling = gpu::kSampleGrid;
    uint32_t width = 0, height = 0;  // samples

    // Rows of samples that n rows of pixels need, and how many of them the rows of pixels above have, too.
    uint32_t rowsFor(uint32_t n) const { return (n - 1) * stride + side; }
    uint32_t overlap() const { return side - stride; }
    // Layout of these samples in rows of `words`.
    SampleLayout inRowsOf(uint32_t words) const { return {words, side, stride, anchor}; }
};
SampleGrid sampleGridOf(const Prepared& prepared, const RenderRequest& request);

// Sampling::adaptive: side of the grid of samples of a pixel whose corners differ.
inline constexpr uint32_t kFineSide = 4;
// Pixels of a band that need more samples, as x | y << 16. Their corners differ by more than kCornerLevels in an encoded channel, or some
// are covered and some not. colour(x, y) and covered(x, y) take column and row of a sample in the band.
std::vector<uint32_t> pixelsWithDifferentCorners(uint32_t width, uint32_t firstRow, uint32_t rows, uint32_t encoding,
                                                 const std::function<glm::vec3(uint32_t, uint32_t)>& colour,
                                                 const std::function<bool(uint32_t, uint32_t)>& covered, uint32_t threads);
// Push constants for `count` pixels with more samples: kFineSide rows of samples each.
gpu::TracePush finePushOf(const gpu::TracePush& push, uint32_t count);

// Values of a traced picture's planes at a pixel, from the distance and the object of the sample that stands for it.
class RaySeen : public SeenNothing {
public:
    RaySeen(const Prepared& prepared, const Scene& scene, const RenderRequest& request, const SampleGrid& grid);
    const RaySeen& at(uint32_t x, uint32_t y, uint32_t distanceBits, uint32_t object, const glm::vec3& normal);

    float z() const { return p_.near / depth(); }
    float depth() const;
    float distance() const { return float(distance_); }
    glm::vec3 normal() const { return normal_; }
    uint32_t object() const;
    uint32_t primitive() const;

private:
    uint32_t wholeShapes() const { return uint32_t(scene_.spheres.size() + scene_.planes.size()); }
    uint32_t meshObject() const;  // object of the scene that triangle object_ belongs to

    const Prepared& p_;
    const Scene& scene_;
    const uint32_t seed_;
    const SampleGrid grid_;
    std::vector<uint32_t> firstOfObject_;  // triangles before each object
    uint32_t x_ = 0, y_ = 0, object_ = 0;
    double distance_ = 0;
    glm::vec3 normal_{0};
};

void countParts(const TraceScene& traced, RenderCounters& counters);
// Adds the pass's counters to `counters`. `words`: gpu::kCounters of them.
void addRayCounts(std::span<const uint64_t> words, uint32_t maxDepth, RenderCounters& counters);
void reportTrace(const RenderRequest& request, double done);

}  // namespace plumb
