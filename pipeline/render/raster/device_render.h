// SPDX-License-Identifier: MIT
// The device draws: bands of rows, chunks of triangles. The usual frame is one band and one chunk, each pixel written once; more
// chunks keep z, triangle and colour in planes between them, and give the same bytes.
#pragma once

#include "pipeline/render/planes.h"
#include "pipeline/render/raster/gpu_frame.h"

#include <cstdint>

namespace plumb {

class DeviceRender {
public:
    DeviceRender(Device& device, const Scene& scene, const RenderRequest& request)
        : device_(device), scene_(scene), request_(request), p_(prepare(scene, request)), frame_(device, p_, request.watchdogMs) {
        result_.plan = p_.plan;
        result_.counters = p_.counters;
        listen();
    }
    DeviceRender(const DeviceRender&) = delete;  // the recorder calls back
    DeviceRender& operator=(const DeviceRender&) = delete;

    // Nothing but colour, in one chunk that stays on the device; false when this picture needs more than that.
    bool drawInPlace();
    const GpuFrame& frame() const { return frame_; }
    GpuFrame& frame() { return frame_; }
    const RenderCounters& counters() const { return result_.counters; }

    RenderResult draw();

private:
    void listen();
    void drawBands(PlaneWriter& writer, uint32_t planes, uint32_t chunkSize);

    bool normalsApart(uint32_t planes) const;

    uint64_t chunkTriangles(uint32_t planes) const;  // of one upload
    FillChoices colourChoices(uint32_t planes, bool prior) const;
    void drawColours(uint32_t planes, bool prior);

    // Normals of a picture that is not shaded by them: the same triangles carrying normals, before z is written.
    void drawNormals(uint32_t planes, bool prior);

    void readBand(PlaneWriter& writer, const gpu::FrameBox& band, uint32_t planes);

    Device& device_;
    const Scene& scene_;
    RenderRequest request_;
    Prepared p_;
    GpuFrame frame_;
    RenderResult result_;
    bool uploaded_ = false;
    double done_ = 0;  // share of the picture, for onProgress
};

}  // namespace plumb
