// SPDX-License-Identifier: MIT
#include "pipeline/passes/scanline.h"

#include "host/error.h"

#include <fmt/core.h>
#include <spirv/scanline.h>
#include <spirv/scanpaint.h>
#include <algorithm>
#include <utility>

namespace plumb {

void recordScanSpans(Recorder& recorder, const gpu::ScanPush& push, const Specialization& exact, const Buffer<gpu::ScanPolygon>& polygons,
                     const Buffer<gpu::ScanEdge>& edges, const Buffer<gpu::ScanCorner>& corners, const Buffer<gpu::ScanSpan>& spans) {
    recorder.dispatch("scanline", spirv::scanline, push.polygonCount, push,
                      {storage("Polygons", polygons), storage("Edges", edges), storage("Corners", corners), storage("Spans", spans)},
                      exact);
}

void recordScanPaint(Recorder& recorder, const gpu::ScanPush& push, const Specialization& exact, const Buffer<gpu::ScanPolygon>& polygons,
                     const Buffer<gpu::ScanSpan>& spans, const Buffer<float>& z, const Buffer<uint32_t>& owner,
                     const Buffer<glm::vec3>& attributes) {
    recorder.dispatch("scanpaint", spirv::scanpaint, uint64_t(push.height), push,
                      {storage("Polygons", polygons), storage("Spans", spans), storage("Depths", z), storage("Owners", owner),
                       storage("Attributes", attributes)},
                      exact);
}

ScanCanvas scanlineGpu(Device& device, Recorder& recorder, const ScanList& list, const Specialization& exact, double watchdogMs,
                       std::vector<gpu::ScanSpan>* spansOut) {
    const uint64_t pixels = uint64_t(list.width) * uint64_t(list.height), range = device.limits().storageRangeBytes;
    const std::pair<const char*, uint64_t> needs[] = {{"pixels", pixels * sizeof(glm::vec3)},
                                                      {"lines", list.spans * sizeof(gpu::ScanSpan)},
                                                      {"corners", list.corners.size() * sizeof(gpu::ScanCorner)},
                                                      {"polygons", list.polygons.size() * sizeof(gpu::ScanPolygon)}};
    for (const auto& [what, bytes] : needs)
        if (bytes > range)
            throw renderError(fmt::format("--fill notes: {} of {} bytes exceed a binding of the device ({} bytes); the twin draws it", what,
                                          bytes, range));
    ScanCanvas canvas;
    Buffer<float> z(device, pixels, "scanline Z");
    Buffer<uint32_t> owner(device, pixels, "scanline owners");
    Buffer<glm::vec3> attributes(device, pixels, "scanline values");
    z.fill(gpu::ubitsOf(gpu::kScanFarthest));
    owner.fill(gpu::kNoPolygon);
    attributes.fill(0);
    const uint32_t count = uint32_t(list.polygons.size());
    if (spansOut) spansOut->clear();
    if (count == 0) {
        recorder.skip("scanline", "no polygon is left to fill");
        recorder.skip("scanpaint", "no polygon is left to fill");
    } else {
        Buffer<gpu::ScanPolygon> polygons(device, count, "polygons");
        Buffer<gpu::ScanEdge> edges(device, list.edges.size(), "edge tables");
        Buffer<gpu::ScanCorner> corners(device, list.corners.size(), "corners");
        Buffer<gpu::ScanSpan> spans(device, std::max<uint64_t>(1, list.spans), "lines");
        polygons.upload(list.polygons);
        edges.upload(list.edges);
        corners.upload(list.corners);
        recordScanSpans(recorder, {0, 0, count, list.width, list.height, list.zBuffer}, exact, polygons, edges, corners, spans);
        for (uint32_t first = 0; first < count;) {
            const uint32_t end = scanSliceEnd(list, first);
            recordScanPaint(recorder, {0, first, end - first, list.width, list.height, list.zBuffer}, exact, polygons, spans, z, owner,
                            attributes);
            first = end;
        }
        recorder.run(watchdogMs);
        if (spansOut) spansOut->assign(spans.span().begin(), spans.span().begin() + ptrdiff_t(list.spans));
    }
    canvas.z.assign(z.span().begin(), z.span().end());
    canvas.owner.assign(owner.span().begin(), owner.span().end());
    canvas.attributes.assign(attributes.span().begin(), attributes.span().end());
    return canvas;
}

}  // namespace plumb
