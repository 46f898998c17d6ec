// SPDX-License-Identifier: MIT
// Scanline: the polygon fill of the lecture notes. Contract: shaders/shared/scanline.h.
#pragma once

#include "host/recorder.h"
#include "shaders/shared/scanline.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// Input of the fill: corners in pixels of the canvas, tables of edges, polygons in the order of painting.
struct ScanList {
    std::vector<gpu::ScanCorner> corners;
    std::vector<gpu::ScanEdge> edges;
    std::vector<gpu::ScanPolygon> polygons;
    int width = 0, height = 0;
    uint64_t spans = 0;    // lines of all polygons within the canvas
    bool zBuffer = true;   // false: later polygons paint over earlier ones
    std::string location;  // object that the next polygons belong to, and where its file states it; for refusals

    // Adds a convex polygon, corners in either sense around it, none beyond kScanFarthestPixel. False when there is nothing to paint.
    // Throws Error(input) for more than 2^31 lines.
    // The polygon's table is made here; a polygon less than a line high has none and is not painted. Only lines and columns of the canvas
    // are walked; their X is that of the whole polygon. More than kScanBlock lines or columns make several entries of `polygons`.
    bool add(std::span<const gpu::ScanCorner> polygon);
};

// Result of the fill, a pixel: Z (kScanFarthest: nothing painted), polygon (kNoPolygon), attributes (3 floats, 0).
struct ScanCanvas {
    std::vector<float> z;
    std::vector<uint32_t> owner;
    std::vector<glm::vec3> attributes;
};

// Fills on the CPU, polygon by polygon, as the notes do.
ScanCanvas scanlineCpu(const ScanList& list);
// Spans of all lines in the order of the device's.
std::vector<gpu::ScanSpan> scanSpansCpu(const ScanList& list);

// End of the polygons [first, end) that one dispatch of the second kernel may paint within its loop budget.
uint32_t scanSliceEnd(const ScanList& list, uint32_t first);
void recordScanSpans(Recorder& recorder, const gpu::ScanPush& push, const Specialization& exact, const Buffer<gpu::ScanPolygon>& polygons,
                     const Buffer<gpu::ScanEdge>& edges, const Buffer<gpu::ScanCorner>& corners, const Buffer<gpu::ScanSpan>& spans);
void recordScanPaint(Recorder& recorder, const gpu::ScanPush& push, const Specialization& exact, const Buffer<gpu::ScanPolygon>& polygons,
                     const Buffer<gpu::ScanSpan>& spans, const Buffer<float>& z, const Buffer<uint32_t>& owner,
                     const Buffer<glm::vec3>& attributes);
// Runs both kernels over the whole list. Throws Error(failed) where the device has no memory left.
ScanCanvas scanlineGpu(Device& device, Recorder& recorder, const ScanList& list, const Specialization& exact, double watchdogMs,
                       std::vector<gpu::ScanSpan>* spans);

}  // namespace plumb
