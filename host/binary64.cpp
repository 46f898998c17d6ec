// SPDX-License-Identifier: MIT
#include "host/binary64.h"

#include "host/buffer.h"
#include "host/recorder.h"
#include "host/vulkan.h"

#include <spirv/selftest_double.h>
#include <cstdint>
#include <optional>

#include <fmt/core.h>

#include <bit>

namespace plumb {

namespace {

double doubleOf(uint32_t low, uint32_t high) { return std::bit_cast<double>(uint64_t(high) << 32 | low); }
bool same(double want, uint32_t low, uint32_t high) {
    return std::bit_cast<uint64_t>(want) == (uint64_t(high) << 32 | low) || (want == 0 && doubleOf(low, high) == 0);
}

}  // namespace

std::vector<gpu::DoubleVector> doubleVectors() {
    uint64_t state = 88172645463325252u;  // Marsaglia's xorshift64
    const auto random = [&] {
        state ^= state << 13;
        state ^= state >> 7;
        return state ^= state << 17;
    };
    // Random number with |x| in [2^lowest, 2^(lowest + exponents)).
    const auto number = [&](int lowest, uint32_t exponents) {
        const uint64_t bits = random();
        return (bits & (uint64_t(1) << 63)) | uint64_t(1023 + lowest + int((bits >> 52) % exponents)) << 52 | (random() >> 12);
    };
    std::vector<gpu::DoubleVector> vectors(gpu::kDoubleVectors);
    for (size_t i = 0; i < vectors.size(); ++i) {
        // Exponents: half of the pairs near each other, where sums cancel and round; half anywhere.
        uint64_t a = i % 2 == 0 ? number(0, 4) : number(-60, 120);
        const uint64_t b = i % 2 == 0 ? number(-30, 60) : number(-60, 120);
        // Low 29 bits, which float32 does not have: half a unit, and values next to it.
        if (i % 4 == 1) a = (a & ~uint64_t(0x1fffffff)) | (0x10000000 + i / 4 % 3 - 1);
        const auto x = float(std::bit_cast<double>(number(-20, 40)));
        vectors[i] = {uint32_t(a), uint32_t(a >> 32), uint32_t(b), uint32_t(b >> 32), x};
    }
    return vectors;
}

bool judgeDoubles(std::span<const gpu::DoubleVector> vectors, std::span<const gpu::DoubleAnswer> answers) {
    PLUMB_ASSERT(vectors.size() == answers.size());
    for (size_t i = 0; i < vectors.size(); ++i) {
        const gpu::DoubleVector& v = vectors[i];
        const gpu::DoubleAnswer& got = answers[i];
        const double a = doubleOf(v.aLow, v.aHigh), b = doubleOf(v.bLow, v.bHigh), product = a * double(v.x);
        const bool all = same(a + b, got.sumLow, got.sumHigh) && same(product, got.productLow, got.productHigh) &&
                         same(product + b, got.bothLow, got.bothHigh) && gpu::ubitsOf(float(a)) == gpu::ubitsOf(got.rounded);
        if (!all) return false;
    }
    return true;
}

std::string lacksBinary64(Device& device) {
    if (!device.limits().float64) return fmt::format("'{}' has no binary64 (shaderFloat64)", device.info().name);
    std::optional<bool>& exact = device.impl().exactBinary64;
    if (!exact) {
        const std::vector<gpu::DoubleVector> vectors = doubleVectors();
        Buffer<gpu::DoubleVector> operands(device, vectors.size(), "binary64 operands");
        Buffer<gpu::DoubleAnswer> answers(device, vectors.size(), "binary64 answers");
        operands.upload(vectors);
        answers.fill(0xffffffffu);
        Recorder recorder(device);
        recorder.dispatch("selftest", spirv::selftest_double, vectors.size(), gpu::SelfTestPush{0, 0},
                          {storage("Vectors", operands), storage("Answers", answers)});
        recorder.run();
        exact = judgeDoubles(vectors, answers.span());
    }
    return *exact ? std::string() : fmt::format("'{}' does not round binary64 to nearest even", device.info().name);
}

}  // namespace plumb
