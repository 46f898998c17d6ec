// SPDX-License-Identifier: MIT
// The products of shaders/shared/product.h: recorders of the device's kernels, and the twin.
#pragma once

#include "host/recorder.h"
#include "shaders/shared/product.h"

#include <span>

namespace plumb {

// Twin. `matrices`: the one that is applied first comes first.
void verticesCpu(std::span<const gpu::Rows> matrices, std::span<const glm::vec4> in, std::span<glm::vec4> out, uint32_t threads);
// One level of a tree: each `perLane` consecutive matrices become one.
void chainLevelCpu(uint32_t perLane, std::span<const gpu::Rows> in, std::span<gpu::Rows> out, uint32_t threads);

// All vertices, in as many dispatches as the bindings of the device want.
void recordVertices(Recorder& recorder, const DeviceLimits& limits, uint32_t matrixCount, uint64_t count, const Buffer<glm::vec4>& in,
                    const Buffer<gpu::Rows>& matrices, const Buffer<glm::vec4>& out);
// One level; `count` matrices become (count + perLane - 1) / perLane.
void recordChainLevel(Recorder& recorder, const DeviceLimits& limits, uint32_t perLane, uint64_t count, const Buffer<gpu::Rows>& in,
                      const Buffer<gpu::Rows>& out);

}  // namespace plumb
