// SPDX-License-Identifier: MIT
// The planner against brute force. Random small scenes with budgets of every tightness: each combination of choices is drawn and held against the
// truth of every pixel. The planner's picture keeps its budget, costs little more than the cheapest that does, and is refused exactly where none does.
// PLUMB_SEED states another seed, PLUMB_CASE runs that scene alone. PLUMB_LONG=1 has 50 scenes with 6 budgets each.
#include "pipeline/planner/planner.h"
#include "host/error.h"
#include "pipeline/planner/calibration.h"
#include "pipeline/render/technique.h"
#include "pipeline/truth/decided.h"
#include "tests/support/budget_scenes.h"
#include "tests/support/scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;
using test::Random;
using test::randomRays;
using test::randomScene;

uint32_t numberOf(const char* name, uint32_t otherwise) {
    const char* stated = std::getenv(name);
    return stated ? uint32_t(std::strtoul(stated, nullptr, 10)) : otherwise;
}

RenderResult twinDraws(const Scene& scene, const RenderRequest& request) { return renderCpu(scene, request); }

// A picture of brute force.
struct Drawn {
    std::string words;
    double costMs = 0;
    BudgetFigures figures;
};

std::vector<Drawn> bruteForce(const Scene& scene, const RenderRequest& base, const UnitCosts& costs) {
    const Checker checker(scene, base, {});
    std::vector<Drawn> drawn;
    for (RenderRequest request : base.shading == Shading::ray ? test::everyTree(base) : test::everyCombination(base)) {
        try {
            refuse(scene, request);
        } catch (const Error&) {
            continue;
        }
        request.planes |= kCheckedPlanes;
        const RenderResult result = renderCpu(scene, request);
        const Work work = workOf(scene, request, countedOf(result, request));
        drawn.push_back({wordsOf(request.trade) + nameOf(request.shading), costOf(work, costs), checker.of(result.frame)});
    }
    return drawn;
}

// Cheapest that keeps the budget; none does: infinite.
double cheapest(const std::vector<Drawn>& drawn, const ErrorBudget& budget) {
    double least = std::numeric_limits<double>::infinity();
    for (const Drawn& d : drawn)
        if (keeps(d.figures, budget)) least = std::min(least, d.costMs);
    return least;
}

struct Tally {
    uint32_t budgets = 0, kept = 0, unreachable = 0, tried = 0, dear = 0;
    double worst = 0;
};

void compareWith(const std::vector<Drawn>& drawn, const Scene& scene, PlannerRequest request, Tally& tally) {
    ++tally.budgets;
    const double best = cheapest(drawn, request.error);
    try {
        const CheckedPicture picture = drawWithinError(scene, request, twinDraws);
        tally.tried += uint32_t(picture.tried.size());
        // Held against the truth of every pixel once more, by a checker of its own.
        RenderRequest full = picture.plan.chosen.request;
        full.planes |= kCheckedPlanes;
        const RenderResult result = renderCpu(scene, full);
        const BudgetFigures got = Checker(scene, request.base, {}).of(result.frame);
        EXPECT_TRUE(keeps(got, request.error)) << wordsOf(request.error) << " by " << picture.plan.chosen.words << ": max " << got.max;
        EXPECT_TRUE(picture.certified);
        EXPECT_EQ(picture.result.frame.rgba, result.frame.rgba);
        ASSERT_TRUE(std::isfinite(best)) << "brute force finds none for " << wordsOf(request.error);
        const double cost = costOf(workOf(scene, full, countedOf(result, full)), request.costs);
        EXPECT_GE(cost, best * (1 - 1e-12)) << "cheaper than brute force: it misses " << picture.plan.chosen.words;
        if (cost > 1.05 * best) {
            ++tally.dear;
            fmt::print("  scene {}: {} by '{}', {:.3f} of the best, probe every {}\n", scene.path, wordsOf(request.error),
                       picture.plan.chosen.words, cost / best, picture.plan.shrink);
            for (const Weighed& w : picture.plan.weighed)
                if (w.costMs < cost && w.error && excessOf(w.error->middle, request.error) < 2)
                    fmt::print("    cheaper: '{}', probe: max {:.3f} rms {:.3f} p99 {:.3f} wrong {:.5f}{}\n", w.words, w.error->middle.max,
                               w.error->middle.rms, w.error->middle.p99, w.error->middle.wrong, w.got ? ", drawn and beyond" : "");
        }
        tally.worst = std::max(tally.worst, cost / best);
        ++tally.kept;
    } catch (const Error& error) {
        ASSERT_EQ(error.exit(), Exit::budget) << error.what();
        EXPECT_FALSE(std::isfinite(best)) << wordsOf(request.error) << " is refused, and brute force keeps it: " << error.what();
        ++tally.unreachable;
    }
}

TEST(Planner, ChoosesAsBruteForceDoes) {
    const bool thorough = std::getenv("PLUMB_LONG") != nullptr;
    const uint32_t seed = numberOf("PLUMB_SEED", 1), only = numberOf("PLUMB_CASE", UINT32_MAX), scenes = thorough ? 50 : 10;
    Tally tally;
    for (uint32_t i = only == UINT32_MAX ? 0 : only; i < (only == UINT32_MAX ? scenes : only + 1); ++i) {
        SCOPED_TRACE(fmt::format("PLUMB_SEED={} PLUMB_CASE={}", seed, i));
        Random random(seed * 1000003u + i);
        const bool rays = i % 5 == 4;  // every fifth is traced
        Scene scene = rays ? randomRays(random) : randomScene(random);
        scene.path = std::to_string(i);
        PlannerRequest request;
        request.checkMs = 1e9;
        request.base.width = 40 + random.below(60);
        request.base.height = 30 + random.below(50);
        if (rays) request.base.shading = Shading::ray;
        request.base.samples = random.below(5) == 0 ? 4 : 1;
        // Every second scene is planned by the whole picture, the others by a ninth of its pixels.
        if (i % 2 == 1) request.probePixels = uint64_t(request.base.width) * request.base.height / 8;
        const std::vector<Drawn> drawn = bruteForce(scene, request.base, request.costs);
        std::vector<BudgetFigures> figures;
        for (const Drawn& d : drawn) figures.push_back(d.figures);
        for (const ErrorBudget& budget : test::budgetsOf(figures, random)) {
            request.error = budget;
            compareWith(drawn, scene, request, tally);
            if (HasFatalFailure()) return;
        }
    }
    fmt::print("{} budgets: {} kept by {} pictures, {} unreachable; dearer than the best by more than 5 %: {}, at most {:.3f} of it\n",
               tally.budgets, tally.kept, tally.tried, tally.unreachable, tally.dear, tally.worst);
    EXPECT_GT(tally.kept, 0u);
    EXPECT_LE(20 * tally.dear, tally.kept);
}

TEST(Planner, TheCheckCatchesAnEstimateThatIsHalved) {
    Random random(7);
    const Scene scene = randomScene(random);
    PlannerRequest request;
    request.base.width = 80;
    request.base.height = 60;
    const std::vector<Drawn> drawn = bruteForce(scene, request.base, request.costs);
    // Three quarters of the error of the cheapest: half of that error keeps the limit wrongly.
    const Drawn& least = *std::min_element(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) { return a.costMs < b.costMs; });
    request.error.rms = 0.75 * least.figures.rms;
    request.checkMs = 1e9;
    const size_t honest = drawWithinError(scene, request, twinDraws).tried.size();
    request.estimateFactor = 0.5;
    const CheckedPicture deceived = drawWithinError(scene, request, twinDraws);
    EXPECT_EQ(honest, 1u);
    EXPECT_GT(deceived.tried.size(), 1u);
    EXPECT_FALSE(deceived.tried.front().kept);
    EXPECT_TRUE(keeps(deceived.got, request.error));
}

TEST(Planner, TheRuleOfThreeIsTheBoundOfNone) {
    // (1 - p)^n = 0.05.
    for (const uint64_t n : {10u, 300u, 3000u, 100000u}) {
        EXPECT_NEAR(shareBelow(0, n), 1 - std::pow(0.05, 1 / double(n)), 1e-8);
        EXPECT_LT(shareBelow(0, n), 3.0 / double(n));
        EXPECT_GT(shareBelow(1, n), shareBelow(0, n));
        EXPECT_NEAR(shareAbove(1, n), 1 - std::pow(0.95, 1 / double(n)), 1e-8);
    }
    EXPECT_EQ(shareBelow(0, 0), 1);
    EXPECT_EQ(shareAbove(0, 100), 0);
}

TEST(Planner, ACalibrationIsTakenWholeAndForItsKeyAlone) {
    Calibration written;
    for (size_t i = 0; i < kUnits; ++i) written.costs.of[i] = 1.5 + double(i) / 3;
    written.twinRay = 250.25;
    const std::string text = calibrationText(written, "device A, driver 1");
    Calibration read;
    ASSERT_TRUE(readCalibration(text, "device A, driver 1", read));
    EXPECT_EQ(read.costs.of, written.costs.of);
    EXPECT_EQ(read.twinRay, written.twinRay);
    EXPECT_TRUE(read.fromCache);
    EXPECT_FALSE(readCalibration(text, "device A, driver 2", read));
    EXPECT_FALSE(readCalibration("", "device A, driver 1", read));
    for (size_t at = 0; at < text.size(); ++at) {
        std::string damaged = text;
        damaged[at] = char(damaged[at] ^ 1);
        EXPECT_FALSE(readCalibration(damaged, "device A, driver 1", read)) << "byte " << at;
        EXPECT_FALSE(readCalibration(text.substr(0, at), "device A, driver 1", read)) << at << " bytes";
    }
}

// Every vertex of a soup moved by up to `aside` samples on the screen, along each axis, at its own depth.
Scene movedAside(const Scene& scene, double aside, Random& random) {
    Scene moved = scene;
    for (TriangleMesh& mesh : moved.meshes) {
        std::vector<dvec3> positions;
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            const dvec3 p = mesh.statedAt(v);
            const double pixel = -p.z / test::kFocal;
            positions.push_back(p + dvec3(random(-aside, aside), random(-aside, aside), 0) * pixel);
        }
        mesh.stated = std::move(positions);
    }
    return moved;
}

TEST(Planner, AFaceThatIsDecidedStaysWhereverItsVerticesStand) {
    constexpr double kAside = 0.25;  // samples: large, so that much changes
    uint64_t decided = 0, changed = 0;
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        Random random(seed);
        RenderRequest request;
        request.width = 64;
        request.height = 48;
        const Scene scene = test::soup({request.width, request.height}, seed, 40, 20);
        const std::vector<uint8_t> sure = decidedPixels(scene, request, kAside);
        const Truth truth = truthOf(scene, request);
        for (int turn = 0; turn < 8; ++turn) {
            const Truth other = truthOf(movedAside(scene, kAside, random), request);
            for (size_t at = 0; at < sure.size(); ++at) {
                const bool same = truth.object[at] == other.object[at] && truth.primitive[at] == other.primitive[at];
                EXPECT_TRUE(same || sure[at] == 0) << "seed " << seed << ", pixel " << at;
                decided += sure[at];
                changed += !same;
            }
        }
    }
    EXPECT_GT(decided, 1000u);
    EXPECT_GT(changed, 1000u);
}

}  // namespace
}  // namespace plumb
