// SPDX-License-Identifier: MIT
// Products of shaders/shared/product.h: recorders of the device's kernels, and the twins.
#pragma once

#include "host/recorder.h"
#include "pipeline/choices/trade.h"
#include "shaders/shared/long_transform.h"
#include "shaders/shared/product.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// Transforms on the CPU. `matrices`: in the order in which they are applied; none: vertices are copied.
void verticesCpu(std::span<const gpu::Rows> matrices, std::span<const glm::vec4> in, std::span<glm::vec4> out, uint32_t threads);
// Transforms on the CPU: x, y and w of the record's rows, and 1. Not for fp32.
void longVerticesCpu(Precision precision, const gpu::LongRecord& composite, std::span<const glm::vec4> in, std::span<glm::vec4> out,
                     uint32_t threads);
// Operation of a tree's level: each `perLane` consecutive matrices become one, their product, or their sum where only loading is measured.
enum class Level { products, sums };
void chainLevelCpu(Level level, uint32_t perLane, std::span<const gpu::Rows> in, std::span<gpu::Rows> out, uint32_t threads);

// Pairs of vertices, in which results are stored: an odd count writes the last vertex twice.
inline uint64_t pairsOf(uint64_t vertices) { return (vertices + 1) / 2; }
inline std::span<glm::vec4> verticesOf(Buffer<gpu::VertexPair>& pairs, uint64_t count) {
    PLUMB_ASSERT(pairsOf(count) <= pairs.count());
    return {static_cast<glm::vec4*>(pairs.data()), size_t(count)};
}

// Records all vertices, in as many dispatches as the bindings of the device need. The first `matrixCount` of `matrices` are applied; 0:
// vertices are copied.
void recordVertices(Recorder& recorder, const DeviceLimits& limits, uint32_t matrixCount, uint64_t count, const Buffer<glm::vec4>& in,
                    const Buffer<gpu::Rows>& matrices, const Buffer<gpu::VertexPair>& out);
// Records stores without loads: vertex i of each dispatch (those of recordVertices()) gets gpu::markOf(matrices[0], i).
void recordMarks(Recorder& recorder, const DeviceLimits& limits, uint64_t count, const Buffer<glm::vec4>& in,
                 const Buffer<gpu::Rows>& matrices, const Buffer<gpu::VertexPair>& out);
uint64_t verticesPerDispatch(const DeviceLimits& limits);
// Records the more accurate transforms. Not for fp32; for fp64 only where lacksBinary64() (host/binary64.h) is empty.
void recordLongVertices(Recorder& recorder, const DeviceLimits& limits, Precision precision, uint64_t count, const Buffer<glm::vec4>& in,
                        const Buffer<gpu::LongRecord>& composite, const Buffer<gpu::VertexPair>& out);
// Records one level; `count` matrices become (count + perLane - 1) / perLane.
void recordChainLevel(Recorder& recorder, const DeviceLimits& limits, Level level, uint32_t perLane, uint64_t count,
                      const Buffer<gpu::Rows>& in, const Buffer<gpu::Rows>& out);

}  // namespace plumb
