// SPDX-License-Identifier: MIT
#include "tests/oracle/fixed_function.h"

#include "host/graphics.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <stdexcept>

#include <oracle_spirv/fixed_function_frag.h>
#include <oracle_spirv/fixed_function_vert.h>

namespace plumb::oracle {
namespace {

struct Vertex {
    ClipPosition position;
    uint32_t id;
};

Device openLavapipe() {
    DeviceRequest request;
    request.prefer = request.require = "lavapipe";
    Device device = Device::open(Device::choose(request), request);
    if (device.limits().subPixelBits != 8)
        throw std::runtime_error("fixed-function witness: lavapipe with another number of sub-pixel bits than 8");
    return device;
}

GraphicsSetup setupOf() {
    GraphicsSetup setup;
    setup.vertexWords = kFixedFunctionVert;
    setup.fragmentWords = kFixedFunctionFrag;
    setup.vertexBytes = sizeof(Vertex);
    setup.inputs = {{VertexFormat::float4, offsetof(Vertex, position)}, {VertexFormat::word, offsetof(Vertex, id)}};
    setup.wordColour = true;
    return setup;
}

}  // namespace

struct FixedFunction::Impl {
    Device device = openLavapipe();
    GraphicsPipeline pipeline{device, setupOf()};
    Buffer<Vertex> vertices;
    Buffer<uint32_t> indices;
};

FixedFunction::FixedFunction() : impl_(std::make_unique<Impl>()) {}
FixedFunction::~FixedFunction() = default;

DrawnFrame FixedFunction::draw(uint32_t width, uint32_t height, std::span<const ClipPosition> vertices, std::span<const uint32_t> ids) {
    if (vertices.size() != 3 * ids.size()) throw std::runtime_error("fixed-function witness: three vertices a triangle");
    if (float(std::max(width, height)) * kGuard > 16384.0f) throw std::runtime_error("fixed-function witness: the frame is too large");
    Impl& v = *impl_;
    v.vertices.reserve(v.device, std::max<size_t>(1, vertices.size()), "vertices");
    v.indices.reserve(v.device, std::max<size_t>(1, vertices.size()), "indices");
    for (size_t i = 0; i < vertices.size(); ++i) {
        const ClipPosition& p = vertices[i];
        v.vertices.span()[i] = {{p.x / kGuard, p.y / kGuard, p.z, p.w}, ids[i / 3]};
    }
    std::iota(v.indices.span().begin(), v.indices.span().end(), 0u);
    const float beside = (1.0f - kGuard) / 2.0f;
    const GraphicsDraw all{0, uint32_t(vertices.size()), {}};
    v.pipeline.record(width, height, {beside * float(width), beside * float(height), kGuard * float(width), kGuard * float(height)},
                      kNothingDrawn, v.vertices, v.indices, std::span(&all, vertices.empty() ? 0 : 1), true);
    v.pipeline.run();
    return {
        width, height, {v.pipeline.colour().begin(), v.pipeline.colour().end()}, {v.pipeline.depth().begin(), v.pipeline.depth().end()}};
}

}  // namespace plumb::oracle
