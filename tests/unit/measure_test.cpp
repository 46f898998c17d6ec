// SPDX-License-Identifier: MIT
// What measure promises about its rows, rounds, limits and front, with the twin as the only renderer.
#include "pipeline/measure/measure.h"
#include "host/error.h"
#include "pipeline/measure/pareto.h"
#include "tests/support/ray_scenes.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

TEST(Pareto, IsWhatBruteForceFinds) {
    test::Random random(1);
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<TradePoint> points(random.below(20));
        // Few distinct values, so that ties and equal points are common.
        for (TradePoint& p : points) p = {double(random.below(6)), double(random.below(6))};
        std::set<size_t> expected;
        for (size_t i = 0; i < points.size(); ++i) {
            bool beaten = false;
            for (const TradePoint& q : points)
                beaten |= q.time <= points[i].time && q.error <= points[i].error &&
                          (q.time < points[i].time || q.error < points[i].error);
            if (!beaten) expected.insert(i);
        }
        const std::vector<size_t> front = paretoFront(points);
        EXPECT_EQ(std::set<size_t>(front.begin(), front.end()), expected);
        EXPECT_EQ(front.size(), expected.size());
        for (size_t i = 1; i < front.size(); ++i) EXPECT_LE(points[front[i - 1]].time, points[front[i]].time);
    }
}

TEST(Times, HaveMedianMinAndMax) {
    EXPECT_EQ((Times{{5, 1, 3}}).median(), 3);
    EXPECT_EQ((Times{{5, 1, 3, 2}}).median(), 2.5);
    EXPECT_EQ((Times{{5, 1, 3}}).min(), 1);
    EXPECT_EQ((Times{{5, 1, 3}}).max(), 5);
}

TEST(Axes, HaveDistinctNamesAndReasons) {
    std::set<std::string> names;
    for (const Axis& axis : axes()) {
        EXPECT_TRUE(names.insert(axis.name).second) << axis.name;
        EXPECT_EQ(&axisOf(axis.name), &axis);
        std::set<std::string> choices;
        for (const Choice& choice : axis.choices) {
            EXPECT_TRUE(choices.insert(choice.name).second) << axis.name;
            EXPECT_STRNE(choice.why, "") << axis.name << ' ' << choice.name;
        }
    }
    for (const char* name : {"shading", "fill", "interpolation", "specular", "normals", "light-vector", "transform",
                             "depth", "encode", "samples", "trace-depth", "trace-cutoff", "rate", "subpixel"})
        EXPECT_NO_THROW(axisOf(name)) << "the product names this axis";
    try {
        axisOf("shadings");
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::usage);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
}

// The twin draws; `log` gets the words of each plain draw, in order.
MeasurePlan planOf(std::vector<std::string>* log) {
    MeasurePlan plan;
    plan.base.request.width = 96;
    plan.base.request.height = 64;
    plan.base.twin = true;
    plan.deviceThere = false;
    plan.repetitions = 3;
    for (const Axis& axis : axes()) plan.axes.push_back(&axis);
    plan.draw = [log](const Scene& scene, const Setting& setting) {
        if (log && setting.request.planes == kPlaneColour) log->push_back(wordsOf(setting));
        return renderCpu(scene, setting.request);
    };
    return plan;
}

Scene suzanne() { return test::committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/suzanne.toml", {96, 64}); }

TEST(Measure, OfRaysHasDepthAndCutoffWithTheirBounds) {
    Scene scene = test::mirrors();
    scene.cullBackFaces = true;
    MeasurePlan plan = planOf(nullptr);
    plan.repetitions = 2;
    plan.base.request.shading = Shading::ray;
    plan.base.request.background = *scene.background;
    plan.base.request.minWeight = 1.0f / 1024;
    const Measurement m = measure(scene, plan);
    EXPECT_TRUE(m.truth.traced);
    std::set<std::string> drawn, bounded;
    std::map<std::string, double> rms, rays;
    for (const Row& row : m.rows) {
        const std::string name = std::string(row.axis->name) + " " + row.choice->name;
        if (!row.run) {
            EXPECT_FALSE(row.why.empty()) << name;
            if (row.axis->scope == Scope::raster) {
                EXPECT_EQ(row.why.find("not applicable"), 0u) << name << ": " << row.why;
            }
            continue;
        }
        drawn.insert(name);
        const MeasuredRun& run = m.runs[*row.run];
        ASSERT_TRUE(run.error) << name;
        rms[name] = run.alike->unrounded.rms;
        for (const RenderCounters::RayCounts& depth : run.rays) rays[name] += double(depth.primary + depth.reflected + depth.refracted);
        if (!run.bound) continue;
        bounded.insert(name);
        EXPECT_LE(run.error->picture.max, run.bound->max) << name;
        EXPECT_LE(run.error->picture.p99, run.bound->p99) << name;
        EXPECT_LE(run.error->picture.mean, run.bound->mean) << name;
        EXPECT_LE(run.error->picture.rms, run.bound->rms) << name;
    }
    EXPECT_EQ(bounded, (std::set<std::string>{"trace-depth 1", "trace-depth 2", "trace-depth 3", "trace-depth 10", "trace-cutoff 0", "trace-cutoff 1/256",
                                              "trace-cutoff 1/100", "trace-cutoff 1/10"}))
        << "the depth of 5 is the stated one";
    for (const char* name : {"shading ray", "samples 4", "ray-sampling corners", "ray-sampling adaptive", "ray-sampling random", "encoding linear", "threads 2"})
        EXPECT_TRUE(drawn.count(name)) << name;
    EXPECT_FALSE(drawn.count("shading phong")) << "spheres and planes";
    // Claims P5 and P12: fewer rays, more error.
    EXPECT_GT(rms["trace-depth 1"], 2 * rms["trace-depth 2"]);
    EXPECT_GT(rms["trace-depth 2"], rms["trace-depth 3"]);
    EXPECT_GT(rays["trace-depth 3"], rays["trace-depth 2"]);
    EXPECT_EQ(rays["trace-depth 1"], 96 * 64);
    EXPECT_GT(rays["trace-cutoff 0"], rays["trace-cutoff 1/10"]);
    EXPECT_LE(rms["trace-cutoff 0"], rms["trace-cutoff 1/10"]);
}

TEST(Measure, OfARasterPictureSaysWhyNothingIsTraced) {
    MeasurePlan plan = planOf(nullptr);
    plan.axes = {&axisOf("trace-depth"), &axisOf("trace-cutoff"), &axisOf("ray-sampling"), &axisOf("shading")};
    plan.repetitions = 2;
    const Measurement m = measure(suzanne(), plan);
    size_t absent = 0;
    for (const Row& row : m.rows) {
        const bool rays = row.axis->scope == Scope::rays || std::string(row.choice->name) == "ray";
        EXPECT_EQ(!row.run, rays) << row.axis->name << ' ' << row.choice->name;
        absent += rays;
        if (rays) {
            EXPECT_NE(row.why.find("measure with --shading ray"), std::string::npos) << row.why;
        }
    }
    EXPECT_EQ(absent, 6u + 5u + 4u + 1u);
}

TEST(Measure, TimesAllInTurnAndComparesEachWithTheTruth) {
    std::vector<std::string> log;
    const MeasurePlan plan = planOf(&log);
    const Measurement m = measure(suzanne(), plan);
    EXPECT_TRUE(m.cut.empty());
    EXPECT_EQ(m.repetitions, 3u);
    EXPECT_EQ(m.truth.samples, 16u);
    const size_t runs = m.runs.size();
    EXPECT_GE(runs, 8u);
    // One warm-up each, then three rounds, each with every run once and in the same order.
    ASSERT_EQ(log.size(), 4 * runs);
    for (size_t i = 0; i < log.size(); ++i) EXPECT_EQ(log[i], wordsOf(m.runs[i % runs].setting));

    std::set<std::string> seen;
    size_t choices = 0, defaults = 0, fronts = 0;
    for (const Axis& axis : axes()) choices += axis.choices.size();
    EXPECT_EQ(m.rows.size(), choices);
    for (const Row& row : m.rows) {
        const std::string name = std::string(row.axis->name) + " " + row.choice->name;
        EXPECT_TRUE(seen.insert(name).second);
        defaults += row.baseline;
        fronts += row.onFront;
        if (!row.run) {
            EXPECT_FALSE(row.why.empty()) << name;
            EXPECT_FALSE(row.onFront) << name;
            continue;
        }
        const MeasuredRun& run = m.runs[*row.run];
        EXPECT_EQ(run.total.ms.size(), 3u) << name;
        EXPECT_FALSE(run.passes.empty()) << name;
        EXPECT_EQ(run.error.has_value(), name != "shading wire");
        if (!run.error) continue;
        // 0 would mean that something is compared with itself.
        EXPECT_GT(run.error->linear.max, 0) << name;
        EXPECT_GT(run.alike->linear.max, 0) << name;
        EXPECT_GT(run.alike->unrounded.rms, 0) << name;
        EXPECT_GT(run.error->picture.rms, 0) << name;
        // What is proved holds, and is said for the choices that have a proof and for no others.
        const std::set<std::string> proved = {"normals as-interpolated", "specular schlick", "specular native", "encode native"};
        EXPECT_EQ(run.bound.has_value(), proved.count(name) != 0) << name << ": " << run.boundWhy;
        if (run.bound) {
            const ErrorFigures& e = run.error->picture;
            EXPECT_LE(e.max, run.bound->max) << name;
            EXPECT_LE(e.p99, run.bound->p99) << name;
            EXPECT_LE(e.mean, run.bound->mean) << name;
            EXPECT_LE(e.rms, run.bound->rms) << name;
            EXPECT_GT(run.bound->rms, m.runs[0].error->unrounded.rms) << name;
        } else if (*row.run != 0) {
            EXPECT_NE(run.boundWhy, "") << name;
        }
        EXPECT_EQ(run.rounding.has_value(), name != "rate 1/2" && name != "fill notes") << name;
        if (run.rounding && name != "shading unlit") {
            EXPECT_GT(run.rounding->max, 0) << name;
        }
    }
    EXPECT_TRUE(seen.count("fill notes"));
    EXPECT_GE(defaults, 5u);
    EXPECT_TRUE(seen.count("renderer device"));
    // By brute force, over the rows: nothing is both faster and nearer than a row of the front, and something is than any other.
    EXPECT_GE(fronts, m.front.size());
    for (const Row& row : m.rows) {
        if (!row.run || !m.runs[*row.run].error) continue;
        const auto beats = [&](const MeasuredRun& a, const MeasuredRun& b) {
            const double ta = a.total.median(), tb = b.total.median(), ea = a.error->picture.rms,
                         eb = b.error->picture.rms;
            return ta <= tb && ea <= eb && (ta < tb || ea < eb);
        };
        bool beaten = false;
        for (const MeasuredRun& other : m.runs) beaten |= other.error && beats(other, m.runs[*row.run]);
        EXPECT_EQ(row.onFront, !beaten) << row.axis->name << ' ' << row.choice->name;
    }
    for (size_t i = 1; i < m.front.size(); ++i)
        EXPECT_LE(m.runs[*m.rows[m.front[i - 1]].run].total.median(), m.runs[*m.rows[m.front[i]].run].total.median());
}

TEST(Measure, CutsAndListsWhatTheLimitLeavesNoTimeFor) {
    MeasurePlan plan = planOf(nullptr);
    plan.limitMs = 1;
    const Measurement m = measure(suzanne(), plan);
    EXPECT_FALSE(m.cut.empty());
    size_t choices = 0, timed = 0;
    for (const Axis& axis : axes()) choices += axis.choices.size();
    EXPECT_EQ(m.rows.size() + m.cut.size(), choices);
    for (const Row& row : m.cut) EXPECT_FALSE(row.baseline);
    for (const Row& row : m.rows) timed += row.run.has_value();
    EXPECT_GT(timed, 0u) << "the default picture is always measured";
    EXPECT_EQ(m.repetitions, 2u);
    EXPECT_EQ(m.runs[0].total.ms.size(), 2u);
}

TEST(Measure, ListsWhatTheRendererDoesNotDrawAsAbsent) {
    MeasurePlan plan = planOf(nullptr);
    plan.draw = [](const Scene& scene, const Setting& setting) {
        if (setting.request.fill == Fill::notes) throw inputError("a mesh", "a face crosses itself");
        return renderCpu(scene, setting.request);
    };
    const Measurement m = measure(suzanne(), plan);
    size_t absent = 0;
    for (const Row& row : m.rows)
        if (std::string(row.choice->name) == "notes") {
            ++absent;
            EXPECT_FALSE(row.run);
            EXPECT_NE(row.why.find("crosses itself"), std::string::npos);
        }
    EXPECT_EQ(absent, 1u);
    plan.base.request.fill = Fill::notes;
    EXPECT_THROW(measure(suzanne(), plan), Error) << "the default picture must be drawn";
}

// A choice that does more than its proof says ends the measurement with row, pixel and both numbers.
TEST(Measure, EndsWhereAnErrorIsBeyondItsBound) {
    MeasurePlan plan = planOf(nullptr);
    plan.axes = {&axisOf("encode"), &axisOf("specular")};
    for (const auto& [name, spoil] : {std::pair<std::string, std::function<void(Frame&)>>("encode native", [](Frame& f) { for (uint32_t& word : f.rgba) word ^= 0x20; }),
                                      {"specular schlick", [](Frame& f) { for (size_t i = 0; i < f.linear.size(); ++i) f.linear[i] += i == 3 * (30 * 96 + 48) ? 0.5f : 0.0f; }}}) {
        plan.draw = [&](const Scene& scene, const Setting& setting) {
            RenderResult r = renderCpu(scene, setting.request);
            const bool mine = name[0] == 'e' ? setting.request.trade.nativeEncode : setting.request.trade.specular == Trade::Specular::schlick;
            if (mine && !r.frame.linear.empty()) spoil(r.frame);
            return r;
        };
        try {
            measure(suzanne(), plan);
            FAIL() << name << " is beyond its bound";
        } catch (const Error& error) {
            EXPECT_EQ(error.exit(), Exit::failed);
            const std::string words = error.what();
            EXPECT_NE(words.find("'" + name + "' at pixel ("), std::string::npos) << words;
            EXPECT_NE(words.find("beyond its proved bound"), std::string::npos) << words;
            if (name[0] == 's') {
                EXPECT_NE(words.find("(48, 30)"), std::string::npos) << words;
            }
        }
    }
}

TEST(Measure, RefusesPicturesThatCannotBeTrusted) {
    MeasurePlan plan = planOf(nullptr);
    plan.draw = [](const Scene& scene, const Setting& setting) {
        RenderResult r = renderCpu(scene, setting.request);
        if (!r.frame.linear.empty()) r.frame.linear[100] = std::nanf("");
        return r;
    };
    EXPECT_THROW(measure(suzanne(), plan), Error);
    plan.draw = [](const Scene& scene, const Setting& setting) {
        RenderResult r = renderCpu(scene, setting.request);
        if (r.frame.linear.empty()) r.frame.rgba[100] ^= 1;
        return r;
    };
    EXPECT_THROW(measure(suzanne(), plan), Error);
}

}  // namespace
}  // namespace plumb
