// SPDX-License-Identifier: MIT
// Graphics pipeline of the device itself: the opponent of `plumb bench raster`, and a witness of the tests. The product draws no picture
// with it. One colour and one D32 attachment, one vertex buffer, triangles. A greater depth wins, the earlier triangle on a tie. Pixels
// without a triangle have colour `clearColour` and depth 0. Both attachments come back in mapped memory.
#pragma once

#include "host/buffer.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace plumb {

enum class VertexFormat : uint32_t { float3, float4, word };

struct VertexInput {  // its location is its index in the list
    VertexFormat format = VertexFormat::float4;
    uint32_t offset = 0;  // bytes in a vertex
};

struct GraphicsSetup {
    std::span<const uint32_t> vertexWords, fragmentWords;  // SPIR-V with entry point "main"
    uint32_t vertexBytes = 0;
    std::vector<VertexInput> inputs;
    bool wordColour = false;                  // R32_UINT instead of R8G8B8A8_UNORM
    bool cullBackFaces = false;               // front faces run counter-clockwise as seen (y down)
    uint32_t pushBytes = 0;                   // visible to both stages
    std::vector<uint32_t> fragmentConstants;  // specialization constants 0, 1, ... of the fragment module
};

struct GraphicsDraw {
    uint32_t firstIndex = 0, indexCount = 0;
    std::vector<uint32_t> push;  // words; pushBytes of them
};

struct GraphicsImpl;

class GraphicsPipeline {
public:
    // Throws Error(device) when the device's queue does not draw.
    GraphicsPipeline(Device& device, const GraphicsSetup& setup);
    ~GraphicsPipeline();
    GraphicsPipeline(const GraphicsPipeline&) = delete;
    GraphicsPipeline& operator=(const GraphicsPipeline&) = delete;

    // Records a frame of width x height: all draws, then the copies to the host. `viewport` is x, y, width, height in pixels. The
    // buffers must live until the last run().
    void record(uint32_t width, uint32_t height, const std::array<float, 4>& viewport, uint32_t clearColour, const RawBuffer& vertices,
                const Buffer<uint32_t>& indices, std::span<const GraphicsDraw> draws, bool copyDepth);
    // Submits what was recorded and waits. Throws Error(failed).
    void run(double watchdogMs = 60000);

    std::span<const uint32_t> colour() const;  // row 0 on top, no padding
    std::span<const float> depth() const;      // empty unless copied

private:
    std::unique_ptr<GraphicsImpl> impl_;
};

}  // namespace plumb
