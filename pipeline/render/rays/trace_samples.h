// SPDX-License-Identifier: MIT
// What both sides of a traced picture share: how samples lie, which pixels need more of them, planes of the frame from samples.
#pragma once

#include "pipeline/render/rays/trace_frame.h"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// A pixel (x, y) is resolved from the samples (x stride + i, y stride + j), i and j below side.
struct SampleGrid {
    uint32_t sampling = gpu::kSampleGrid;
    uint32_t side = 1, stride = 1;   // 2 and 1 where pixels share their corners
    uint32_t anchor = 0;             // i and j of the sample that stands for the pixel in the planes
    uint32_t width = 0, height = 0;  // samples

    // Rows of samples that n rows of pixels need, and how many of them the rows of pixels above have, too.
    uint32_t rowsFor(uint32_t n) const { return (n - 1) * stride + side; }
    uint32_t overlap() const { return side - stride; }
};
SampleGrid sampleGridOf(const Prepared& prepared, const RenderRequest& request);

// Sampling::adaptive: side of the grid of samples of a pixel whose corners differ.
inline constexpr uint32_t kFineSide = 4;
// x | y << 16 of the pixels of a band whose corners differ by more than kCornerLevels in an encoded channel, or are not all covered or all bare.
// colour(x, y) and covered(x, y) are of sample y of the band.
std::vector<uint32_t> pixelsWithDifferentCorners(uint32_t width, uint32_t firstRow, uint32_t rows, uint32_t encoding,
                                                 const std::function<glm::vec3(uint32_t, uint32_t)>& colour,
                                                 const std::function<bool(uint32_t, uint32_t)>& covered, uint32_t threads);
// The push of `count` such pixels: kFineSide rows of their samples.
gpu::TracePush finePushOf(const gpu::TracePush& push, uint32_t count);

// Planes of the frame; the sample of a pixel is the grid's anchor.
class TracePlanes {
public:
    TracePlanes(const Prepared& prepared, const Scene& scene, const RenderRequest& request, const SampleGrid& grid, Frame& frame);
    void write(uint32_t x, uint32_t y, uint32_t distanceBits, uint32_t object, const float* normal);

private:
    const Prepared& p_;
    const Scene& scene_;
    const uint32_t planes_, seed_;
    const SampleGrid grid_;
    Frame& frame_;
    std::vector<uint32_t> firstOfObject_;  // triangles before each object
};

void countParts(const TraceScene& traced, RenderCounters& counters);
// `words`: gpu::kCounters of the pass.
void addRayCounts(std::span<const uint64_t> words, uint32_t maxDepth, RenderCounters& counters);
void reportTrace(const RenderRequest& request, double done);

}  // namespace plumb
