// SPDX-License-Identifier: MIT
// What measure promises about its rows, rounds, limits and front, with the twin as the only renderer.
#include "pipeline/measure/measure.h"
#include "host/error.h"
#include "pipeline/measure/front.h"
#include "pipeline/measure/rounds.h"
#include "pipeline/measure/row_fronts.h"
#include "pipeline/measure/telling.h"
#include "tests/support/ray_scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// The rules of front.h, word by word, for points without a work in common.
bool beatenBySomePoint(const std::vector<FrontPoint>& points, size_t i) {
    const auto steps = [](double error) { return std::llround(error / kErrorStep); };
    const auto most = [&](const FrontPoint& p) {
        long long worst = steps(p.errorAtMostSamples);
        for (const FrontPoint& q : points)
            if (q.samples == p.samples && steps(q.errorAtItsSamples) <= steps(p.errorAtItsSamples))
                worst = std::max(worst, steps(q.errorAtMostSamples));
        return worst;
    };
    const auto nearer = [&](const FrontPoint& p, const FrontPoint& q) {
        return most(p) < most(q) || (most(p) == most(q) && steps(p.errorAtItsSamples) < steps(q.errorAtItsSamples));
    };
    for (const FrontPoint& other : points) {
        const bool faster = other.high < points[i].low, slower = points[i].high < other.low;
        if ((faster && !nearer(points[i], other)) || (!slower && nearer(other, points[i]))) return true;
    }
    return false;
}

TEST(Front, IsWhatItsRulesSay) {
    test::Random random(1);
    for (int trial = 0; trial < 1000; ++trial) {
        // The default's errors are its own, so that nothing is one with it.
        std::vector<FrontPoint> points(1 + random.below(12));
        points[0].errorAtItsSamples = points[0].errorAtMostSamples = 2.5;
        for (size_t i = 1; i < points.size(); ++i) {
            // Few distinct values, so that ties are common.
            const double low = 0.25 * double(1 + random.below(8));
            points[i] = {low,  low + 0.25 * double(random.below(4)), double(random.below(5)), double(random.below(5)), random.below(3), i,
                         false};
        }
        const std::vector<bool> front = frontOf(points);
        ASSERT_EQ(front.size(), points.size());
        EXPECT_NE(std::count(front.begin(), front.end(), true), 0) << "something is most accurate";
        for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(front[i], !beatenBySomePoint(points, i)) << trial << ' ' << i;
    }
    EXPECT_TRUE(frontOf({}).empty());
}

FrontPoint pointOf(double low, double high, double own, double most, size_t samples, size_t work) {
    return {low, high, own, most, samples, work, false};
}

TEST(Front, NeverPartsTheDefaultFromItself) {
    test::Random random(2);
    for (int trial = 0; trial < 1000; ++trial) {
        std::vector<FrontPoint> points = {pointOf(1, 1, 1, 3, 0, 0)};
        for (size_t i = 1; i < 10; ++i) {
            const double low = 0.25 * double(1 + random.below(8));
            const size_t work = random.below(5);
            points.push_back(pointOf(low, low + 0.25 * double(random.below(4)), work == 0 ? 1 : double(random.below(3)),
                                     work == 0 ? 3 : double(random.below(5)), work == 0 ? 0 : random.below(2), work));
        }
        points[4] = points[0];
        points[4].low = points[4].high = 0.5 + 0.25 * double(random.below(5));  // told apart wrongly, at times
        points[4].again = true;
        points[6].work = points[7].work = 9;
        points[7].low = points[6].high;  // they overlap
        points[7].high = points[7].low + 1;
        points[7].errorAtItsSamples = points[6].errorAtItsSamples, points[7].errorAtMostSamples = points[6].errorAtMostSamples,
        points[7].samples = points[6].samples;
        const std::vector<bool> front = frontOf(points);
        EXPECT_EQ(front[4], front[0]) << trial;
        EXPECT_EQ(front[7], front[6]) << trial;
    }
}

TEST(Front, IsNotDecidedByEdges) {
    // depth=16 of a picture of one sample: 0.730 off by itself, 0.289 the default; against 16 samples its edges happen to cancel some of that.
    const std::vector<FrontPoint> points = {pointOf(1, 1, 0.289, 8.871, 0, 0), pointOf(0.8, 1.2, 0.730, 8.870, 0, 1),
                                            pointOf(2, 3, 0.287, 4.3, 1, 2), pointOf(1.5, 1.7, 0.289, 8.872, 2, 3),
                                            pointOf(0.7, 0.9, 0.73, 8.860, 0, 4)};
    EXPECT_EQ(frontOf(points), (std::vector<bool>{true, false, true, false, true}))
        << "four samples are nearer; what is told to be faster may be further off";
}

// No axis need state the default as a row: then the control stands for it.
TEST(Front, OfRowsNamesTheControlForADefaultWithoutARow) {
    Measurement m;
    m.runs.resize(3);
    for (size_t i = 0; i < m.runs.size(); ++i) {
        const double share = i == 2 ? 2 : 1;  // the third takes twice the time
        m.runs[i].total.ms.assign(31, 10 * share);
        m.runs[i].ratio = RatioInterval{share, share, share};
        m.runs[i].alike = m.runs[i].error = FrameError{};
    }
    m.runs[1].setting.again = true;
    m.rows.resize(2);
    m.rows[0].run = 1;
    m.rows[1].run = 2;
    takeFronts(m, {"default", "default", "threads"});
    EXPECT_EQ(m.front, std::vector<size_t>{0});
    EXPECT_TRUE(m.rows[0].onFront);
    EXPECT_FALSE(m.rows[1].onFront);
}

// P(Binomial(count, 1/2) < k) by counting, for few tosses.
double chanceBelow(uint32_t count, uint32_t k) {
    uint64_t hits = 0;
    for (uint32_t tosses = 0; tosses < 1u << count; ++tosses) hits += uint32_t(std::popcount(tosses)) < k;
    return double(hits) / double(1u << count);
}

TEST(Interval, MissesNoMoreOftenThanItSays) {
    for (const size_t comparisons : {1, 3, 5, 12, 28, 40}) {
        const double miss = missOf(comparisons);
        EXPECT_LE(miss * double(comparisons), 1 - kConfidenceOfTable + 1e-15);
        EXPECT_LE(miss, 1 - kConfidenceOfRow);
        for (uint32_t count = 1; count <= 20; ++count) {
            const uint32_t rank = rankOf(count, miss);
            EXPECT_LE(2 * chanceBelow(count, rank), miss) << count;
            EXPECT_GT(2 * chanceBelow(count, rank + 1), miss) << "the narrowest that holds; " << count;
        }
        const uint32_t least = roundsToTell(miss);
        EXPECT_GT(rankOf(least, miss), 0u);
        EXPECT_EQ(rankOf(least - 1, miss), 0u);
    }
    EXPECT_EQ(roundsToTell(missOf(1)), 8u);
    EXPECT_EQ(roundsToTell(missOf(28)), 11u);
}

TEST(Interval, IsOfOrderStatistics) {
    EXPECT_FALSE(intervalOf({1, 2}, 0.01));
    const RatioInterval few = *intervalOf({3, 1, 2}, 0.01);
    EXPECT_EQ(few.median, 2);
    EXPECT_FALSE(few.bounded());
    EXPECT_TRUE(few.holdsOne()) << "too few rounds tell nothing";
    // 2 P(Binomial(15) < 3) = 242/32768 = 0.0074, with the next 0.035.
    std::vector<double> ratios;
    for (int i = 15; i > 0; --i) ratios.push_back(i);
    const RatioInterval many = *intervalOf(ratios, 0.01);
    EXPECT_EQ(many.median, 8);
    EXPECT_EQ(many.low, 3);
    EXPECT_EQ(many.high, 13);
    EXPECT_FALSE(many.holdsOne());
}

TEST(RoundOrder, HasEachRunOnceAndEachForerunnerEquallyOften) {
    for (const size_t count : {1, 2, 3, 4, 7, 10, 29}) {
        const size_t rounds = count % 2 != 0 ? 2 * count : count;
        RoundOrder order(7), other(8);
        bool differs = false;
        for (int square = 0; square < 2; ++square) {
            std::map<std::pair<size_t, size_t>, size_t> pairs;
            for (size_t r = 0; r < rounds; ++r) {
                const std::vector<size_t> round = order.next(count);
                differs |= round != other.next(count);
                ASSERT_EQ(std::set<size_t>(round.begin(), round.end()).size(), count);
                EXPECT_EQ(*std::max_element(round.begin(), round.end()), count - 1);
                for (size_t i = 1; i < count; ++i) ++pairs[{round[i - 1], round[i]}];
            }
            EXPECT_EQ(pairs.size(), count * (count - 1));
            for (const auto& [pair, times] : pairs)
                EXPECT_EQ(times, rounds / count) << pair.first << " before " << pair.second << " of " << count;
        }
        EXPECT_EQ(differs, count > 2) << "the seed matters";
    }
    RoundOrder one(7), again(7);
    for (int r = 0; r < 20; ++r) EXPECT_EQ(one.next(9), again.next(9)) << "a seed is an order";
}

TEST(Times, HaveMedianMinAndMax) {
    EXPECT_EQ((Times{{5, 1, 3}}).median(), 3);
    EXPECT_EQ((Times{{5, 1, 3, 2}}).median(), 2.5);
    EXPECT_FALSE((Times{{5, 1}}).median()) << "what lies between two times is no median";
    EXPECT_EQ((Times{{5, 1, 3}}).min(), 1);
    EXPECT_EQ((Times{{5, 1, 3}}).max(), 5);
}

TEST(Axes, HaveDistinctNamesAndReasons) {
    std::set<std::string> names;
    for (const Axis& axis : axes()) {
        EXPECT_TRUE(names.insert(axis.name).second) << axis.name;
        EXPECT_EQ(&axisOf(axis.name), &axis);
        std::set<std::string> choices;
        for (const AxisChoice& choice : axis.choices) {
            EXPECT_TRUE(choices.insert(choice.name).second) << axis.name;
            EXPECT_NE(choice.why, "") << axis.name << ' ' << choice.name;
        }
    }
    for (const TradeAxis& traded : kTradeAxes) {
        const Axis& axis = axisOf(traded.name);
        ASSERT_EQ(axis.choices.size(), traded.choices.size()) << traded.name;
        for (size_t i = 0; i < axis.choices.size(); ++i) {
            EXPECT_STREQ(axis.choices[i].name, traded.choices[i].word) << traded.name;
            Setting setting;
            axis.choices[i].apply(setting);
            EXPECT_TRUE(traded.choices[i].isChosen(setting.request.trade)) << traded.name << ' ' << traded.choices[i].word;
        }
    }
    for (const char* name : {"shading", "fill", "interpolation", "specular", "normals", "light-vector", "transform", "depth", "encode",
                             "samples", "trace-depth", "trace-cutoff", "rate", "subpixel"})
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
    EXPECT_TRUE(m.truth->traced);
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
    EXPECT_EQ(bounded, (std::set<std::string>{"trace-depth 1", "trace-depth 2", "trace-depth 3", "trace-depth 10", "trace-cutoff 0",
                                              "trace-cutoff 1/256", "trace-cutoff 1/100", "trace-cutoff 1/10"}))
        << "the depth of 5 is the stated one";
    for (const char* name : {"shading ray", "samples 4", "ray-sampling corners", "ray-sampling adaptive", "ray-sampling random",
                             "encoding linear", "threads 2"})
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
    EXPECT_EQ(m.truth->samples, 16u);
    // Suzanne has no generated shape, so the runs of the axis tessellation are refused.
    std::set<std::string> each;
    for (const MeasuredRun& run : m.runs) {
        EXPECT_EQ(!run.refused.empty(), run.setting.segments != 0) << run.refused;
        if (run.refused.empty()) EXPECT_TRUE(each.insert(wordsOf(run.setting)).second);
    }
    const size_t runs = each.size();
    EXPECT_GE(runs, 8u);
    // One warm-up each but for the default again, then three rounds, each with every run once.
    ASSERT_EQ(log.size(), 4 * runs - 1);
    std::vector<std::vector<std::string>> rounds;
    for (size_t r = 0; r < 3; ++r) {
        rounds.emplace_back(log.begin() + ptrdiff_t((r + 1) * runs - 1), log.begin() + ptrdiff_t((r + 2) * runs - 1));
        EXPECT_EQ(std::set<std::string>(rounds[r].begin(), rounds[r].end()), each);
    }
    EXPECT_TRUE(rounds[0] != rounds[1] && rounds[1] != rounds[2]) << "each round in another order";

    std::set<std::string> seen;
    size_t choices = 0, defaults = 0;
    for (const Axis& axis : axes()) choices += axis.choices.size();
    EXPECT_EQ(m.rows.size(), choices);
    for (const Row& row : m.rows) {
        const std::string name = std::string(row.axis->name) + " " + row.choice->name;
        EXPECT_TRUE(seen.insert(name).second);
        defaults += row.baseline;
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
    // Three rounds bound no interval, so nothing is told apart, and only the most accurate is on the front.
    EXPECT_GT(roundsToTell(m.miss), 3u);
    for (const Row& row : m.rows) {
        if (!row.run) continue;
        EXPECT_EQ(m.runs[*row.run].told, Told::notApart);
        EXPECT_EQ(row.onFront, (std::string(row.axis->name) == "samples" && std::string(row.choice->name) == "16"))
            << row.axis->name << ' ' << row.choice->name;
    }
    ASSERT_EQ(m.front.size(), 1u);
    EXPECT_STREQ(m.rows[0].choice->name, "default again");
    EXPECT_EQ(m.runs[1].error->picture.rms, m.runs[0].error->picture.rms);
}

// Draws once, and says that it took as long as `timeMs` has it.
struct FakeDraws {
    std::function<double(const Setting&)> timeMs;
    std::map<std::string, RenderResult> results;
    RenderResult operator()(const Scene& scene, const Setting& setting) {
        const std::string words = wordsOf(setting) + std::to_string(setting.request.planes);
        auto found = results.find(words);
        if (found == results.end()) found = results.emplace(words, renderCpu(scene, setting.request)).first;
        RenderResult result = found->second;
        result.totalMs = timeMs(setting);
        return result;
    }
};

// A machine that others use: it slows down and recovers, stalls now and then for much longer than a picture takes, and a run with many threads leaves it slow for what follows.
class BusyMachine {
public:
    explicit BusyMachine(uint32_t seed, double delay) : random_(seed), delay_(delay) {}
    double timeMs(const Setting& setting) {
        const bool heavy = setting.twin;
        double ms = heavy ? 40 : 10;
        if (setting.again) ms *= 1 + delay_;
        if (afterHeavy_) ms *= 1.3;
        afterHeavy_ = heavy;
        drift_ = std::clamp(drift_ + 0.02 * (uniform() - 0.5), -0.7, 0.7);
        ms *= std::exp(drift_) * (1 + 0.04 * (uniform() - 0.5));
        if (uniform() < 0.1) ms += 10 * (std::pow(uniform() + 1e-6, -1 / 1.1) - 1);  // no mean to speak of
        return ms;
    }

private:
    double uniform() { return double(random_.below(1u << 24)) / double(1u << 24); }
    test::Random random_;
    const double delay_;
    double drift_ = 0;
    bool afterHeavy_ = false;
};

// How often of `kTrials` the default again was told apart.
constexpr int kTrials = 40, kMostWrong = 2;
int toldApart(const std::vector<const Axis*>& axes, double delay, Told as, uint32_t rounds) {
    int told = 0;
    const Scene scene = test::committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/pyramid.toml", {16, 12});
    auto draws = std::make_shared<FakeDraws>();
    for (int trial = 0; trial < kTrials; ++trial) {
        BusyMachine machine(uint32_t(trial + 1), delay);
        draws->timeMs = [&machine](const Setting& setting) { return machine.timeMs(setting); };
        MeasurePlan plan;
        plan.base.request.width = 16;
        plan.base.request.height = 12;
        plan.axes = axes;
        plan.repetitions = rounds;
        plan.draw = [draws](const Scene& drawn, const Setting& setting) { return (*draws)(drawn, setting); };
        const Measurement m = measure(scene, plan);
        told += m.runs[1].told == as;
        for (const Row& row : m.rows)
            if (row.run == 1u) {
                EXPECT_EQ(row.onFront, std::any_of(m.rows.begin(), m.rows.end(), [](const Row& r) { return r.baseline && r.onFront; }))
                    << "never on the other side of the front";
            }
    }
    return told;
}

TEST(Measure, TellsTheDefaultFromItselfByNoListOfAxes) {
    for (const std::vector<const Axis*>& axes :
         {std::vector{&axisOf("depth")}, std::vector{&axisOf("transform"), &axisOf("specular"), &axisOf("renderer"), &axisOf("threads")},
          std::vector{&axisOf("renderer")}, std::vector{&axisOf("threads"), &axisOf("shading")}}) {
        const int apart = toldApart(axes, 0, Told::faster, 31) + toldApart(axes, 0, Told::slower, 31);
        EXPECT_LE(apart, kMostWrong) << axes[0]->name;
    }
}

// What heavy runs leave behind moves a ratio by 0.3, so a tenth beside them needs more rounds.
TEST(Measure, FindsADelayOfATenth) {
    EXPECT_GE(toldApart({&axisOf("depth")}, 0.1, Told::slower, 31), kTrials - kMostWrong);
    EXPECT_GE(toldApart({&axisOf("transform"), &axisOf("specular"), &axisOf("renderer"), &axisOf("threads")}, 0.1, Told::slower, 201),
              kTrials - kMostWrong);
}

TEST(Measure, HasOneTruthForEveryListOfAxes) {
    Scene scene = test::mirrors();
    MeasurePlan plan = planOf(nullptr);
    plan.repetitions = 1;
    plan.base.request.width = 48;
    plan.base.request.height = 32;
    plan.base.request.shading = Shading::ray;
    std::map<std::string, double> first;
    for (const std::vector<const Axis*>& axes :
         {std::vector{&axisOf("ray-sampling")}, std::vector{&axisOf("ray-sampling"), &axisOf("samples"), &axisOf("trace-depth")}}) {
        plan.axes = axes;
        const Measurement m = measure(scene, plan);
        EXPECT_EQ(m.truth->samples, 16u);
        for (const Row& row : m.rows) {
            if (row.axis != axes[0]) continue;
            const double rms = m.runs[*row.run].error->picture.rms;
            const auto [known, fresh] = first.try_emplace(row.choice->name, rms);
            EXPECT_EQ(known->second, rms) << row.choice->name;
        }
    }
    EXPECT_LT(first["adaptive"], first["grid"]) << "16 samples where corners differ";
}

TEST(Measure, HasNoFrontAndNoMedianOfTwoRounds) {
    MeasurePlan plan = planOf(nullptr);
    plan.repetitions = 2;
    plan.axes = {&axisOf("samples")};
    const Measurement m = measure(suzanne(), plan);
    EXPECT_EQ(m.repetitions, 2u);
    EXPECT_TRUE(m.front.empty());
    for (const Row& row : m.rows) {
        EXPECT_FALSE(row.onFront || row.onAxisFront);
        EXPECT_FALSE(m.runs[*row.run].total.median());
        EXPECT_FALSE(m.runs[*row.run].ratio);
    }
}

TEST(Measure, CutsAndListsWhatTheLimitLeavesNoTimeFor) {
    MeasurePlan plan = planOf(nullptr);
    plan.limitMs = 1;
    const Measurement m = measure(suzanne(), plan);
    EXPECT_FALSE(m.cut.empty());
    size_t choices = 0, timed = 0;
    for (const Axis& axis : axes()) choices += axis.choices.size();
    EXPECT_EQ(m.rows.size() + m.cut.size(), choices);
    for (const Row& row : m.cut) {
        EXPECT_FALSE(row.baseline);
        EXPECT_NE(row.why, "");
    }
    for (const Row& row : m.rows) timed += row.run.has_value();
    EXPECT_GT(timed, 0u) << "the default picture is always measured";
    EXPECT_EQ(m.repetitions, 1u);
    EXPECT_EQ(m.runs[0].total.ms.size(), 1u);
    EXPECT_FALSE(m.truth) << "no time for it";
    EXPECT_FALSE(m.limitKept) << "and even the default picture takes longer";
}

TEST(Measure, WithoutBinary64HasNoRowOfItAndSaysWhy) {
    for (const char* lacks : {"", "'a device' has no binary64"}) {
        MeasurePlan plan = planOf(nullptr);
        plan.base.request.width = 16;
        plan.base.request.height = 12;
        plan.base.twin = false;
        plan.deviceThere = true;
        plan.repetitions = 1;
        plan.noBinary64 = lacks;
        plan.axes = {&axisOf("transform")};
        plan.draw = [&](const Scene& scene, const Setting& setting) {
            EXPECT_TRUE(*lacks == '\0' || setting.request.trade.precision != Precision::fp64) << "drawn although the device lacks it";
            return renderCpu(scene, setting.request);
        };
        const Measurement m = measure(suzanne(), plan);
        const auto row =
            std::find_if(m.rows.begin(), m.rows.end(), [](const Row& r) { return r.choice->name == std::string_view("fp64"); });
        ASSERT_NE(row, m.rows.end());
        EXPECT_EQ(row->run.has_value(), *lacks == '\0');
        EXPECT_EQ(row->why, lacks);
    }
}

// A clock that only draws move would be better; here each draw sleeps, so that estimates are about right on a slow machine as well.
TEST(Measure, CutsWhatIsAskedLeastFirst) {
    constexpr auto kDraw = std::chrono::milliseconds(20);
    MeasurePlan plan = planOf(nullptr);
    plan.base.request.width = 16;
    plan.base.request.height = 12;
    plan.deviceThere = true;
    plan.repetitions = 21;
    auto draws = std::make_shared<FakeDraws>();
    draws->timeMs = [&](const Setting&) {
        std::this_thread::sleep_for(kDraw);
        return double(kDraw.count());
    };
    plan.draw = [draws](const Scene& scene, const Setting& setting) { return (*draws)(scene, setting); };
    // The errors of all, and then eleven rounds of about twelve runs: not of all thirty.
    plan.limitMs = double((2 * 30 + 11 * 12) * kDraw.count());
    const Measurement m = measure(suzanne(), plan);
    ASSERT_FALSE(m.cut.empty());
    std::set<std::string> kept, cut;
    for (const Row& row : m.rows)
        if (row.run && !row.baseline) kept.insert(row.axis->name);
    for (const Row& row : m.cut) cut.insert(row.axis->name);
    EXPECT_TRUE(kept.count("samples"));
    EXPECT_TRUE(cut.count("threads") && cut.count("renderer")) << "the default's pixels again";
    EXPECT_FALSE(cut.count("samples"));
    // Nothing that is asked less is kept where something that is asked more was cut, unless it is one of the repeats.
    for (const Row& gone : m.cut)
        for (const Row& row : m.rows)
            if (row.run && !row.baseline && m.runs[*row.run].bytes != m.runs[0].bytes && m.runs[*gone.run].bytes != m.runs[0].bytes &&
                !m.runs[*gone.run].bytes.empty()) {
                EXPECT_LE(askedRank(*row.axis), askedRank(*gone.axis)) << row.axis->name << " was kept, " << gone.axis->name << " cut";
            }
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
    for (const auto& [name, spoil] : {std::pair<std::string, std::function<void(Frame&)>>("encode native",
                                                                                          [](Frame& f) {
                                                                                              for (uint32_t& word : f.rgba) word ^= 0x20;
                                                                                          }),
                                      {"specular schlick", [](Frame& f) {
                                           for (size_t i = 0; i < f.linear.size(); ++i)
                                               f.linear[i] += i == 3 * (30 * 96 + 48) ? 0.5f : 0.0f;
                                       }}}) {
        plan.draw = [&](const Scene& scene, const Setting& setting) {
            RenderResult r = renderCpu(scene, setting.request);
            const bool mine =
                name[0] == 'e' ? setting.request.trade.nativeEncode : setting.request.trade.specular == Trade::Specular::schlick;
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
