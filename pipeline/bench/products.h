// SPDX-License-Identifier: MIT
// The products of shaders/shared/product.h: recorders of the device's kernels, and the twins.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/numbers.h"
#include "shaders/shared/long_transform.h"
#include "shaders/shared/product.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// Twins. `matrices`: the one that is applied first comes first; none copies.
void verticesCpu(std::span<const gpu::Rows> matrices, std::span<const glm::vec4> in, std::span<glm::vec4> out, uint32_t threads);
// x, y and w of the record's rows, and 1. Not of fp32.
void longVerticesCpu(Numbers numbers, const gpu::LongRecord& composite, std::span<const glm::vec4> in, std::span<glm::vec4> out,
                     uint32_t threads);
// One level of a tree: each `perLane` consecutive matrices become one, their product, or their sum where only loading is measured.
enum class Level { products, sums };
void chainLevelCpu(Level level, uint32_t perLane, std::span<const gpu::Rows> in, std::span<gpu::Rows> out, uint32_t threads);

// Results are stored by two: an odd count writes the last one twice.
inline uint64_t pairsOf(uint64_t vertices) { return (vertices + 1) / 2; }
inline std::span<glm::vec4> verticesOf(Buffer<gpu::VertexPair>& pairs, uint64_t count) {
    PLUMB_ASSERT(pairsOf(count) <= pairs.count());
    return {static_cast<glm::vec4*>(pairs.data()), size_t(count)};
}

// All vertices, in as many dispatches as the bindings of the device want. `matrixCount` of `matrices`; 0: they are copied.
void recordVertices(Recorder& recorder, const DeviceLimits& limits, uint32_t matrixCount, uint64_t count, const Buffer<glm::vec4>& in,
                    const Buffer<gpu::Rows>& matrices, const Buffer<gpu::VertexPair>& out);
// Nothing is loaded: vertex i of each dispatch (that of recordVertices) gets gpu::markOf(matrices[0], i).
void recordMarks(Recorder& recorder, const DeviceLimits& limits, uint64_t count, const Buffer<glm::vec4>& in,
                 const Buffer<gpu::Rows>& matrices, const Buffer<gpu::VertexPair>& out);
uint64_t verticesPerDispatch(const DeviceLimits& limits);
// Not of fp32; of fp64 only where lacksBinary64() (host/binary64.h) is empty.
void recordLongVertices(Recorder& recorder, const DeviceLimits& limits, Numbers numbers, uint64_t count, const Buffer<glm::vec4>& in,
                        const Buffer<gpu::LongRecord>& composite, const Buffer<gpu::VertexPair>& out);
// One level; `count` matrices become (count + perLane - 1) / perLane.
void recordChainLevel(Recorder& recorder, const DeviceLimits& limits, Level level, uint32_t perLane, uint64_t count,
                      const Buffer<gpu::Rows>& in, const Buffer<gpu::Rows>& out);

}  // namespace plumb
