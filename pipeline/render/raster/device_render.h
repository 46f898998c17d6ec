// SPDX-License-Identifier: MIT
// The device draws: bands of rows, chunks of triangles. The usual frame is one band and one chunk, and each pixel is written once. Several
// chunks keep z, triangle and colour in planes between them. They give the same bytes.
#pragma once

#include "pipeline/render/planes.h"
#include "pipeline/render/raster/gpu_frame.h"
#include "pipeline/render/technique.h"

#include <cstdint>

namespace plumb {

class DeviceRender : public ResidentPicture {
public:
    DeviceRender(Device& device, const Prepared& prepared, const RenderRequest& request);
    DeviceRender(const DeviceRender&) = delete;  // the recorder calls back
    DeviceRender& operator=(const DeviceRender&) = delete;

    void draw(PlaneWriter& writer, RenderResult& result);

    // False where no picture of this kind stays: nothing is drawn, or colour alone has several samples.
    static bool stays(const Prepared& prepared, const RenderRequest& request) {
        return !prepared.list.triangles.empty() && (prepared.side == 1 || request.planes != kPlaneColour);
    }
    // Nothing but colour, in one chunk that stays on the device; false when this picture needs more than that.
    bool draw() override;
    ResidentScene::Picture pixels() const override;
    bool drawPlanes(Frame& out) override;
    void moved(bool objects) override {
        if (uploaded_) frame_.uploadView(objects);
    }
    RenderCounters counters() const override { return counters_; }
    Recorder& recorder() override { return frame_.recorder(); }

private:
    void listen();
    void drawBands(PlaneWriter& writer, Frame& out, uint32_t planes, uint32_t chunkSize);

    bool normalsApart(uint32_t planes) const;

    uint64_t chunkTriangles(uint32_t planes) const;  // triangles of one upload
    FillChoices colourChoices(uint32_t planes, bool prior) const;
    void drawColours(uint32_t planes, bool prior);

    // Normals of a picture that is not shaded by them: the same triangles with normals as attributes, before z is written.
    void drawNormals(uint32_t planes, bool prior);

    void readBand(PlaneWriter& writer, Frame& out, const gpu::FrameBox& band, uint32_t planes);

    const RenderRequest& request_;
    const Prepared& p_;
    GpuFrame frame_;
    RenderCounters counters_;
    bool uploaded_ = false;  // the whole list, as one chunk
    double done_ = 0;        // share of the picture, for onProgress
};

}  // namespace plumb
