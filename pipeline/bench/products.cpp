// SPDX-License-Identifier: MIT
#include "pipeline/bench/products.h"

#include "pipeline/passes/parallel.h"

#include <spirv/chain.h>
#include <spirv/vertices.h>

namespace plumb {
namespace {

// The most elements of `bytes` bytes and `texels` texels that one binding takes, a multiple of `unit`.
uint64_t mostOfBinding(const DeviceLimits& limits, uint64_t bytes, uint64_t texels, uint64_t unit) {
    const uint64_t most = std::min(limits.storageRangeBytes / bytes, limits.texelElements / texels) / unit * unit;
    if (most == 0) throw renderError("a binding of the device is too small for the products");
    return most;
}

}  // namespace

void verticesCpu(std::span<const gpu::Rows> matrices, std::span<const glm::vec4> in, std::span<glm::vec4> out, uint32_t threads) {
    parallelBands(in.size(), 65536, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = begin; i < end; ++i) {
            glm::vec4 p = in[i];
            for (const gpu::Rows& m : matrices) p = gpu::timesVector(m, p);
            out[i] = p;
        }
    });
}

void chainLevelCpu(uint32_t perLane, std::span<const gpu::Rows> in, std::span<gpu::Rows> out, uint32_t threads) {
    parallelBands(out.size(), 16, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t lane = begin; lane < end; ++lane) {
            const std::span<const gpu::Rows> factors = in.subspan(lane * perLane, std::min<uint64_t>(perLane, in.size() - lane * perLane));
            gpu::Rows product = factors[0];
            for (const gpu::Rows& factor : factors.subspan(1)) product = gpu::timesMatrix(product, factor);
            out[lane] = product;
        }
    });
}

void recordVertices(Recorder& recorder, const DeviceLimits& limits, uint32_t matrixCount, uint64_t count, const Buffer<glm::vec4>& in,
                    const Buffer<gpu::Rows>& matrices, const Buffer<glm::vec4>& out) {
    PLUMB_ASSERT(matrixCount >= 1 && matrixCount <= gpu::kMostMatrices);
    const uint64_t most = mostOfBinding(limits, sizeof(glm::vec4), 1, 4096);
    for (uint64_t first = 0; first < count; first += most) {
        const uint64_t here = std::min(most, count - first);
        recorder.dispatch("vertices", spirv::vertices, here, gpu::VerticesPush{0, uint32_t(here)},
                          {texels(in, View::texelF32x4, first * 16, here * 16), storage(matrices), storage(out, first, here)}, {{2, matrixCount}});
    }
}

void recordChainLevel(Recorder& recorder, const DeviceLimits& limits, uint32_t perLane, uint64_t count, const Buffer<gpu::Rows>& in,
                      const Buffer<gpu::Rows>& out) {
    PLUMB_ASSERT(perLane >= 2 && perLane <= gpu::kMostPerLane);
    // Both ends of a chunk must meet the alignment of a view; 64 products are 4 KiB.
    const uint64_t most = count * sizeof(gpu::Rows) <= limits.storageRangeBytes && count * 4 <= limits.texelElements
                              ? count
                              : mostOfBinding(limits, sizeof(gpu::Rows), 4, uint64_t(perLane) * 64);
    for (uint64_t first = 0; first < count; first += most) {
        const uint64_t here = std::min(most, count - first), lanes = (here + perLane - 1) / perLane;
        recorder.dispatch("chain", spirv::chain, lanes, gpu::ChainPush{0, uint32_t(here), perLane, uint32_t(lanes)},
                          {texels(in, View::texelF32x4, first * 64, here * 64), storage(out, first / perLane, lanes)});
    }
}

}  // namespace plumb
