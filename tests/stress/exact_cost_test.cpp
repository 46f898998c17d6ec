// SPDX-License-Identifier: MIT
// What the corrected forms of exact.h cost beside the device's own, in a kernel that is bound by memory and in one that is bound by
// arithmetic. Both sides run in turns in random order; medians and quartiles of the ratios are printed, and only the bits are judged.
#include "host/recorder.h"
#include "tests/support/device_fixture.h"

#include <spirv/exact_cost.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <glm/glm.hpp>
#include <random>
#include <vector>

namespace plumb::test {
namespace {

constexpr uint32_t kCount = 1u << 21, kRounds = 41;

struct CostPush {
    uint32_t statusSlot, count;
};

using ExactCost = DeviceTest;

TEST_F(ExactCost, BesideTheDevicesOwn) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> around(0.75f, 1.5f);
    Buffer<glm::vec2> operands(device(), kCount, "operands");
    for (glm::vec2& v : operands.span()) v = {around(random), around(random)};
    Buffer<float> answers[2] = {Buffer<float>(device(), kCount, "own"), Buffer<float>(device(), kCount, "corrected")};
    std::printf("operation  steps  own ms  ratio of medians  quartiles of the ratios\n");
    for (const bool roots : {false, true})
        for (const uint32_t steps : {1u, 64u}) {
            std::vector<double> times[2], ratios;
            for (uint32_t round = 0; round <= kRounds; ++round) {
                double ms[2] = {};
                const uint32_t firstSide = random() % 2;
                for (const uint32_t side : {firstSide, 1 - firstSide}) {
                    Recorder recorder(device());
                    recorder.dispatch("exact", spirv::exact_cost, kCount, CostPush{0, kCount},
                                      {storage("Operands", operands), storage("Answers", answers[side])},
                                      {{"kSteps", steps}, {"kRoots", roots}, {"kNativeDivide", side == 0}, {"kNativeRoot", side == 0}});
                    const auto start = std::chrono::steady_clock::now();
                    recorder.run();
                    ms[side] = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
                }
                if (round == 0) continue;  // makes the pipelines
                for (const int side : {0, 1}) times[side].push_back(ms[side]);
                ratios.push_back(ms[1] / ms[0]);
            }
            EXPECT_EQ(std::memcmp(answers[0].data(), answers[1].data(), size_t(kCount) * sizeof(float)), 0);
            for (auto* list : {&times[0], &times[1], &ratios}) std::sort(list->begin(), list->end());
            std::printf("%-9s  %5u  %6.2f  %16.2f  %.2f to %.2f\n", roots ? "root" : "division", steps, times[0][kRounds / 2],
                        times[1][kRounds / 2] / times[0][kRounds / 2], ratios[kRounds / 4], ratios[3 * kRounds / 4]);
        }
}

}  // namespace
}  // namespace plumb::test
