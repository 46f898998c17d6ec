// SPDX-License-Identifier: MIT
#include "pipeline/bench/products.h"

#include "pipeline/passes/parallel.h"

#include <spirv/chain.h>
#include <spirv/vertices.h>
#include <spirv/vertices_block.h>
#include <spirv/vertices_block_int64.h>
#include <spirv/vertices_double.h>
#include <spirv/vertices_double_int64.h>
#include <spirv/vertices_int64.h>
#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {
namespace {

// Most elements of `bytes` bytes and `texels` texels that one binding takes, a multiple of `unit`.
uint64_t mostOfBinding(const DeviceLimits& limits, uint64_t bytes, uint64_t texels, uint64_t unit) {
    const uint64_t most = std::min(limits.storageRangeBytes / bytes, limits.texelElements / texels) / unit * unit;
    if (most == 0) throw renderError("a binding of the device is too small for the products");
    return most;
}

// Invocations from which a large workgroup is used. A large one is cheaper, but one that holds all invocations runs on one processor.
constexpr uint64_t kManyLanes = 4096;
constexpr uint32_t kLargeGroup = 64, kSmallGroup = 8;

struct VerticesKernel {
    const Module& narrow;
    const Module& int64;  // the same kernel with stores of 64 bits
    Specialization constants;
};

void recordPairs(Recorder& recorder, const DeviceLimits& limits, const VerticesKernel& kernel, uint64_t count, const Buffer<glm::vec4>& in,
                 const Binding& matrices, const Buffer<gpu::VertexPair>& out) {
    PLUMB_ASSERT(pairsOf(count) <= out.count());
    const uint64_t most = verticesPerDispatch(limits);
    for (uint64_t first = 0; first < count; first += most) {
        const uint64_t here = std::min(most, count - first), pairs = pairsOf(here);
        recorder.dispatch(
            "vertices", limits.int64 ? kernel.int64 : kernel.narrow, (pairs + gpu::kPairsPerLane - 1) / gpu::kPairsPerLane,
            gpu::VerticesPush{0, uint32_t(here)},
            {texels("vertices", in, View::texelF32x4, first * 16, here * 16), matrices, storage("Results", out, first / 2, pairs)},
            kernel.constants);
    }
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

void longVerticesCpu(Precision precision, const gpu::LongRecord& composite, std::span<const glm::vec4> in, std::span<glm::vec4> out,
                     uint32_t threads) {
    PLUMB_ASSERT(precision != Precision::fp32);
    parallelBands(in.size(), 65536, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = begin; i < end; ++i)
            out[i] = glm::vec4(precision == Precision::fp64 ? gpu::doubleClip(composite, in[i]) : gpu::blockClip(composite, in[i]), 1.0f);
    });
}

void chainLevelCpu(Level level, uint32_t perLane, std::span<const gpu::Rows> in, std::span<gpu::Rows> out, uint32_t threads) {
    parallelBands(out.size(), 16, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t lane = begin; lane < end; ++lane) {
            const std::span<const gpu::Rows> factors = in.subspan(lane * perLane, std::min<uint64_t>(perLane, in.size() - lane * perLane));
            gpu::Rows product = factors[0];
            for (const gpu::Rows& factor : factors.subspan(1))
                product = level == Level::products ? gpu::timesMatrix(product, factor) : gpu::sumOfRows(product, factor);
            out[lane] = product;
        }
    });
}

uint64_t verticesPerDispatch(const DeviceLimits& limits) { return mostOfBinding(limits, sizeof(glm::vec4), 1, 4096); }

void recordVertices(Recorder& recorder, const DeviceLimits& limits, uint32_t matrixCount, uint64_t count, const Buffer<glm::vec4>& in,
                    const Buffer<gpu::Rows>& matrices, const Buffer<gpu::VertexPair>& out) {
    PLUMB_ASSERT(matrixCount <= gpu::kMostMatrices);
    recordPairs(recorder, limits, {spirv::vertices, spirv::vertices_int64, {{"kMatrices", matrixCount}, {"kLoads", true}}}, count, in,
                storage("Matrices", matrices), out);
}

void recordMarks(Recorder& recorder, const DeviceLimits& limits, uint64_t count, const Buffer<glm::vec4>& in,
                 const Buffer<gpu::Rows>& matrices, const Buffer<gpu::VertexPair>& out) {
    recordPairs(recorder, limits, {spirv::vertices, spirv::vertices_int64, {{"kMatrices", 1}, {"kLoads", false}}}, count, in,
                storage("Matrices", matrices), out);
}

void recordLongVertices(Recorder& recorder, const DeviceLimits& limits, Precision precision, uint64_t count, const Buffer<glm::vec4>& in,
                        const Buffer<gpu::LongRecord>& composite, const Buffer<gpu::VertexPair>& out) {
    PLUMB_ASSERT(precision != Precision::fp32);
    const Specialization oneMatrix = {{"kMatrices", 1}, {"kLoads", true}};
    const VerticesKernel kernel = precision == Precision::fp64
                                      ? VerticesKernel{spirv::vertices_double, spirv::vertices_double_int64, oneMatrix}
                                      : VerticesKernel{spirv::vertices_block, spirv::vertices_block_int64, oneMatrix};
    recordPairs(recorder, limits, kernel, count, in, storage("Longs", composite), out);
}

void recordChainLevel(Recorder& recorder, const DeviceLimits& limits, Level level, uint32_t perLane, uint64_t count,
                      const Buffer<gpu::Rows>& in, const Buffer<gpu::Rows>& out) {
    PLUMB_ASSERT(perLane >= 2 && perLane <= gpu::kMostPerLane);
    // Ends of a chunk must meet the alignment of a binding, at most 256 bytes: four products.
    const uint64_t most = count * sizeof(gpu::Rows) <= limits.storageRangeBytes && count * 4 <= limits.texelElements
                              ? count
                              : mostOfBinding(limits, sizeof(gpu::Rows), 4, uint64_t(perLane) * 4);
    for (uint64_t first = 0; first < count; first += most) {
        const uint64_t here = std::min(most, count - first), lanes = (here + perLane - 1) / perLane;
        const Specialization constants = {{"kMultiplies", level == Level::products},
                                          {"kLocalSizeX", lanes > kManyLanes ? kLargeGroup : kSmallGroup},
                                          {"kPerLane", std::min(perLane, gpu::kFactorsPerStep + 1)}};
        recorder.dispatch(
            "chain", spirv::chain, lanes, gpu::ChainPush{0, uint32_t(here), perLane, uint32_t(lanes)},
            {texels("factors", in, View::texelF32x4, first * 64, here * 64), storage("Products", out, first / perLane, lanes)}, constants);
    }
}

}  // namespace plumb
