// SPDX-License-Identifier: MIT
// What `plumb measure` says of a machine that is busy: two processes spin beside it. The default again must not be told apart from the default, and a tenth more
// time must be found. One printed line a run.
#include "pipeline/measure/measure.h"
#include "pipeline/scene/load.h"
#include "tests/support/device_fixture.h"
#include "tests/support/ray_scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr int kTrials = 40, kMostWrong = 2, kSpinning = 2;
constexpr double kDelay = 0.1;
// Beside two spinning processes a time varies by its own size, so a tenth takes many rounds. One number of rounds for both: neither is bought with the other.
constexpr uint32_t kRounds = 501;

class Spinning {
public:
    Spinning() {
        for (pid_t& process : processes_) {
            process = ::fork();
            if (process == 0)
                for (;;)
                    if (::getppid() == 1) ::_exit(0);
        }
    }
    Spinning(const Spinning&) = delete;
    Spinning& operator=(const Spinning&) = delete;
    ~Spinning() {
        for (const pid_t process : processes_) {
            ::kill(process, SIGKILL);
            ::waitpid(process, nullptr, 0);
        }
    }

private:
    std::array<pid_t, kSpinning> processes_{};
};

double msSince(std::chrono::steady_clock::time_point begun) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
}

// Another list each time; what is not drawn here (rays, wire) is absent.
std::vector<const Axis*> listOf(int trial) {
    static constexpr std::array<std::array<const char*, 2>, 8> kLists = {{{"depth", "specular"},
                                                                          {"transform", "specular"},
                                                                          {"renderer", "encode"},
                                                                          {"threads", "depth"},
                                                                          {"normals", "normals"},
                                                                          {"shading", "rate"},
                                                                          {"samples", "subpixel"},
                                                                          {"light-vector", "threads"}}};
    std::vector<const Axis*> axes;
    for (const char* name : kLists[size_t(trial) % kLists.size()])
        if (axes.empty() || axes.back() != &axisOf(name)) axes.push_back(&axisOf(name));
    return axes;
}

// The default again, with `delay` of the default's median added to each of its draws inside the time that is taken.
MeasuredRun againOf(const Scene& scene, int trial, double delay) {
    MeasurePlan plan;
    plan.base.request.width = 160;
    plan.base.request.height = 120;
    plan.axes = listOf(trial);
    plan.repetitions = kRounds;
    plan.limitMs = 3.6e6;
    plan.seed = uint64_t(trial);
    std::vector<double> defaults;
    const std::string words = wordsOf(plan.base);
    plan.draw = [&](const Scene& drawn, const Setting& setting) {
        RenderResult result =
            setting.twin ? renderCpu(drawn, setting.request) : renderGpu(*test::DeviceEnvironment::device(), drawn, setting.request);
        if (wordsOf(setting) == words) defaults.push_back(result.totalMs);
        if (setting.again && delay > 0) {
            const auto begun = std::chrono::steady_clock::now();
            while (msSince(begun) < delay * medianOf(defaults)) {
            }
            result.totalMs += msSince(begun);
        }
        return result;
    };
    const Measurement m = measure(scene, plan);
    const MeasuredRun& again = m.runs[1];
    fmt::print("delay {:.2f}, {}{}: default {:.2f} ms, again {:.3f} of it ({:.3f} .. {:.3f}), {} rounds, {} rows: {}\n", delay,
               plan.axes[0]->name, plan.axes.size() > 1 ? fmt::format(",{}", plan.axes[1]->name) : "", *m.runs[0].total.median(),
               again.ratio->median, again.ratio->low, again.ratio->high, m.repetitions, m.comparisons, nameOf(again.told));
    std::fflush(stdout);
    return again;
}

class MeasureNoise : public test::OnDevice<::testing::Test> {
protected:
    const Scene scene_ = test::committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/suzanne.toml", {160, 120});
    const Spinning spinning_;
};

TEST_F(MeasureNoise, TellsTheDefaultFromItselfInTwoOf40AtMost) {
    int wrong = 0;
    for (int trial = 0; trial < kTrials; ++trial) wrong += againOf(scene_, trial, 0).told != Told::notApart;
    fmt::print("not told apart: {} of {}\n", kTrials - wrong, kTrials);
    EXPECT_LE(wrong, kMostWrong);
}

TEST_F(MeasureNoise, FindsATenthIn38Of40AtLeast) {
    int found = 0;
    for (int trial = 0; trial < kTrials; ++trial) found += againOf(scene_, trial, kDelay).told == Told::slower;
    fmt::print("a delay of {:g} % found: {} of {}\n", 100 * kDelay, found, kTrials);
    EXPECT_GE(found, kTrials - kMostWrong);
}

}  // namespace
}  // namespace plumb
