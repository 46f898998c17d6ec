// SPDX-License-Identifier: MIT
#include "host/selftest.h"

#include "host/buffer.h"
#include "host/cache.h"
#include "host/recorder.h"
#include "host/vulkan.h"

#include <spirv/canary.h>
#include <spirv/selftest.h>
#include <algorithm>
#include <cstdint>

#include <fmt/core.h>
#include <string_view>

#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

namespace plumb {

static_assert(FLT_EVAL_METHOD == 0, "the host's own arithmetic must be plain IEEE float32");

namespace {

bool sameFloat(float a, float b) { return gpu::ubitsOf(a) == gpu::ubitsOf(b) || (a == 0 && b == 0); }

uint64_t fnv1a(std::string_view text) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text) hash = (hash ^ uint8_t(c)) * 0x100000001b3u;
    return hash;
}

// Sets the failure that the full vectors show; canaries have their own.
void setFailure(SelfTest& verdict) {
    if (!verdict.exactAddMul)
        verdict.failure = "the device does not round + - * of float32 to nearest even";
    else if (!verdict.exactConversions)
        verdict.failure = "the device does not convert between int and float, or multiply 32 x 32 bits, exactly";
    else if (!verdict.nativeDivideIsExact && !verdict.emulatedDivideIsExact)
        verdict.failure = "no form of division is exact on the device";
    else if (!verdict.nativeRootIsExact && !verdict.emulatedRootIsExact)
        verdict.failure = "no form of the square root is exact on the device";
    else
        verdict.failure.clear();
}

void runCanaries(Device& device, Recorder& recorder, SelfTest& verdict) {
    Buffer<gpu::CanaryAnswer> answers(device, gpu::kCanaryLanes, "canary answers");
    answers.fill(0);
    recorder.dispatch("canary", spirv::canary, gpu::kCanaryLanes, gpu::SelfTestPush{0, gpu::kCanaryIterations},
                      {storage("Answers", answers)});
    recorder.run();
    const std::span<const gpu::CanaryAnswer> got = answers.span();
    verdict.loopLimit = 0;
    bool divide = true, root = true;
    for (uint32_t lane = 0; lane < gpu::kCanaryLanes; ++lane) {
        // Iterations that ran. Where lavapipe cuts a loop its variables disagree by one; the state tells how many really ran.
        uint32_t state = lane, done = 0;
        while (done < gpu::kCanaryIterations && (done == 0 || state != got[lane].state)) state = gpu::nextState(state), ++done;
        if (state != got[lane].state || done + 1 < got[lane].iterations || got[lane].iterations < done)
            throw renderError(fmt::format("lane {} of the canary counts {} iterations, but its state {:#x} is not theirs", lane,
                                          got[lane].iterations, got[lane].state));
        if (done < gpu::kCanaryIterations) verdict.loopLimit = verdict.loopLimit == 0 ? done : std::min(verdict.loopLimit, done);
        const float x = gpu::canaryOperand(lane, gpu::kCanaryIterations), y = gpu::canaryOperand(lane, gpu::kCanaryIterations * 7u);
        if (!sameFloat(got[lane].sum, x + y) || !sameFloat(got[lane].product, x * y)) verdict.exactAddMul = false;
        divide = divide && sameFloat(got[lane].quotient, x / y);
        root = root && sameFloat(got[lane].root, std::sqrt(x));
    }
    verdict.nativeDivideIsExact = verdict.nativeDivideIsExact && divide;
    verdict.nativeRootIsExact = verdict.nativeRootIsExact && root;
    setFailure(verdict);
}

SelfTest runVectors(Device& device, Recorder& recorder) {
    const std::vector<gpu::SelfTestVector> vectors = selfTestVectors();
    Buffer<gpu::SelfTestVector> operands(device, vectors.size(), "self-test operands");
    Buffer<gpu::SelfTestAnswer> answers(device, vectors.size(), "self-test answers");
    operands.upload(vectors);
    answers.fill(0xffffffffu);
    recorder.dispatch("selftest", spirv::selftest, vectors.size(), gpu::SelfTestPush{0, 0},
                      {storage("Vectors", operands), storage("Answers", answers)});
    recorder.run();
    return judgeSelfTest(vectors, answers.span());
}

std::string cacheKey(Device& device) {
    const DeviceInfo& info = device.info();
    return fmt::format("{} {:x} {} | {} | {}", info.uuid, device.impl().driverVersion, spirv::selftest.sha256, info.name, info.driverInfo);
}

}  // namespace

std::vector<gpu::SelfTestVector> selfTestVectors() {
    uint32_t state = 2463534242u;  // Marsaglia's xorshift32
    const auto random = [&] {
        state ^= state << 13;
        state ^= state >> 17;
        return state ^= state << 5;
    };
    const auto significand = [&] {
        const uint32_t bits = random();
        switch (bits >> 30) {
            case 0:
                return bits & 7u;  // just above a power of two
            case 1:
                return 0x7fffffu - (bits & 7u);  // just below
            case 2:
                return ((1u << (bits >> 8) % 23u) + (bits & 3u)) & 0x7fffffu;  // few bits set
            default:
                return bits & 0x7fffffu;
        }
    };
    const auto real = [&](uint32_t lowestExponent, uint32_t exponents) {
        const uint32_t bits = random();
        return gpu::realOf(int((bits & 0x80000000u) | (127u + lowestExponent + bits % exponents) << 23 | significand()));
    };
    std::vector<gpu::SelfTestVector> vectors(gpu::kSelfTestVectors);
    for (uint32_t i = 0; i < vectors.size(); ++i) {
        gpu::SelfTestVector& v = vectors[i];
        // Exponents: half of the pairs near each other, where sums cancel and round; half anywhere in [2^-60, 2^60].
        v.x = i % 2 == 0 ? real(0u, 4u) : real(0u - 60u, 120u);
        v.y = i % 2 == 0 ? real(0u - 24u, 48u) : real(0u - 60u, 120u);
        v.i = random();
        v.j = random();
        if (i % 4 == 1) v.i = 0u - (v.i & 3u), v.j = 0x80000000u - (v.j & 3u);
        v.converted = real(0u - 8u, 39u);
    }
    return vectors;
}

SelfTest judgeSelfTest(std::span<const gpu::SelfTestVector> vectors, std::span<const gpu::SelfTestAnswer> answers) {
    PLUMB_ASSERT(vectors.size() == answers.size());
    SelfTest verdict;
    verdict.exactAddMul = verdict.exactConversions = true;
    verdict.nativeDivideIsExact = verdict.nativeRootIsExact = verdict.emulatedDivideIsExact = verdict.emulatedRootIsExact = true;
    for (size_t n = 0; n < vectors.size(); ++n) {
        const gpu::SelfTestVector& v = vectors[n];
        const gpu::SelfTestAnswer& a = answers[n];
        const float product = v.x * v.y;
        const uint64_t unsignedProduct = uint64_t(v.i) * v.j;
        const int64_t signedProduct = int64_t(int32_t(v.i)) * int32_t(v.j);
        const float quotient = v.x / v.y, root = std::sqrt(std::abs(v.x));
        verdict.exactAddMul = verdict.exactAddMul && sameFloat(a.sum, v.x + v.y) && sameFloat(a.difference, v.x - v.y) &&
                              sameFloat(a.product, product) && sameFloat(a.sumOfProducts, product + v.x);
        verdict.exactConversions = verdict.exactConversions && sameFloat(a.floatOfInt, float(int32_t(v.i))) &&
                                   sameFloat(a.floatOfUint, float(v.i)) && a.intOfFloat == int32_t(v.converted) &&
                                   a.uintOfFloat == uint32_t(std::abs(v.converted)) && a.unsignedHigh == uint32_t(unsignedProduct >> 32) &&
                                   a.unsignedLow == uint32_t(unsignedProduct) && a.signedHigh == int32_t(signedProduct >> 32) &&
                                   a.signedLow == int32_t(signedProduct);
        verdict.nativeDivideIsExact = verdict.nativeDivideIsExact && sameFloat(a.nativeQuotient, quotient);
        verdict.nativeRootIsExact = verdict.nativeRootIsExact && sameFloat(a.nativeRoot, root);
        verdict.emulatedDivideIsExact = verdict.emulatedDivideIsExact && sameFloat(a.emulatedQuotient, quotient);
        verdict.emulatedRootIsExact = verdict.emulatedRootIsExact && sameFloat(a.emulatedRoot, root);
    }
    setFailure(verdict);
    return verdict;
}

std::string selfTestCacheText(const SelfTest& verdict, const std::string& key) {
    const std::string body =
        fmt::format("plumbline self-test 1\n{}\n{:d} {:d} {:d} {:d} {:d} {:d}\n", key, verdict.exactAddMul, verdict.exactConversions,
                    verdict.nativeDivideIsExact, verdict.nativeRootIsExact, verdict.emulatedDivideIsExact, verdict.emulatedRootIsExact);
    return body + fmt::format("{:016x}\n", fnv1a(body));
}

bool readSelfTestCache(const std::string& text, const std::string& key, SelfTest& verdict) {
    // A text is accepted only if it is exactly what would be written for its verdict.
    std::istringstream lines(text);
    std::string version, storedKey;
    std::getline(lines, version);
    std::getline(lines, storedKey);
    SelfTest read;
    lines >> read.exactAddMul >> read.exactConversions >> read.nativeDivideIsExact >> read.nativeRootIsExact >>
        read.emulatedDivideIsExact >> read.emulatedRootIsExact;
    if (!lines || storedKey != key || selfTestCacheText(read, key) != text) return false;
    verdict = read;
    setFailure(verdict);
    return true;
}

SelfTest runSelfTest(Device& device, bool mayCache) {
    const auto start = std::chrono::steady_clock::now();
    Recorder recorder(device);
    const std::string key = cacheKey(device);
    std::filesystem::path file = mayCache ? cacheFolder() : std::filesystem::path();
    if (!file.empty()) file /= fmt::format("selftest-{:016x}", fnv1a(key));
    SelfTest verdict;
    bool cached = !file.empty() && readSelfTestCache(readCache(file), key, verdict);
    if (cached) {
        const SelfTest before = verdict;
        runCanaries(device, recorder, verdict);
        // False when a canary contradicts the stored verdict: the machine has changed under the key.
        cached = verdict.exactAddMul == before.exactAddMul && verdict.nativeDivideIsExact == before.nativeDivideIsExact &&
                 verdict.nativeRootIsExact == before.nativeRootIsExact;
    }
    if (!cached) {
        verdict = runVectors(device, recorder);
        if (!file.empty() && verdict.failure.empty()) writeCache(file, selfTestCacheText(verdict, key));
        runCanaries(device, recorder, verdict);
    }
    verdict.fromCache = cached;
    verdict.timeMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return verdict;
}

}  // namespace plumb
