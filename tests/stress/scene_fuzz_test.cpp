// SPDX-License-Identifier: MIT
// Differential fuzzing of whole scenes: whatever a scene holds, device and twin leave the same planes or refuse it in the same words, and a part of them
// is held against the truth. First every scene of tests/data/fuzz/, which once failed; then random ones.
//
//   PLUMB_FUZZ_SEED=n     another sequence (printed; scene i of seed n is the same scene always)
//   PLUMB_FUZZ_SCENE=i    this one alone
//   PLUMB_FUZZ_SCENES=n   so many
//   PLUMB_FUZZ_FIND=1     ends with the first that fails, as it is
//
// A scene that fails is reduced and written beside this program, with the command that shows it.
#include "tests/stress/scene_fuzz.h"

#include "host/error.h"
#include "pipeline/cli/options.h"
#include "pipeline/command/request.h"
#include "pipeline/command/views.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"
#include "tests/stress/scene_truth.h"
#include "tests/support/device_fixture.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kSeed = 1, kLongSeed = 2, kScenes = 500, kLongScenes = 10000;
// Below these the fuzz would show nothing: of the scenes, those that are drawn rather than refused, and of these, those that show something; of the scenes
// of the truth, those whose pixels it can judge.
constexpr double kLeastDrawn = 0.9, kLeastSeen = 0.6, kLeastJudged = 0.3;
// Shares say something from so many scenes on.
constexpr uint64_t kScenesForShares = 200;
constexpr uint32_t kReductions = 400;  // runs of a failing scene
constexpr uint64_t kMostFailures = 5;  // then the run ends

uint64_t stated(const char* name, uint64_t fallback) {
    const char* text = std::getenv(name);
    return text && *text ? std::strtoull(text, nullptr, 10) : fallback;
}

enum class Outcome { equal, refused, differs, refusedApart, beyondTruth };
const char* nameOf(Outcome o) {
    constexpr const char* kNames[] = {"equal", "refused", "device and twin differ", "refused on one side, or in other words",
                                      "further from the truth than its bound"};
    return kNames[size_t(o)];
}

struct Case {
    Outcome outcome = Outcome::equal;
    std::string what;
    bool seen = false;
    TruthReport truth;
    bool fails() const { return outcome > Outcome::refused; }
};

// The sentence of a refusal, or "" when it draws.
std::string refusalOf(const std::function<void()>& draw) {
    try {
        draw();
    } catch (const Error& e) {
        return fmt::format("exit {}: {}", int(e.exit()), e.what());
    }
    return "";
}

std::vector<std::string> wordsOf(const std::string& line) {
    std::istringstream words(line);
    return {std::istream_iterator<std::string>(words), {}};
}

// As `plumb verify FILE FLAGS` does it.
Case run(Device& device, const fs::path& file, const std::string& flags, bool truth) {
    Case r;
    std::vector<std::string> arguments{"verify", file.string()};
    for (const std::string& word : wordsOf(flags)) arguments.push_back(word);
    Scene scene;
    RenderRequest request;
    r.what = refusalOf([&] {
        const Options options = parseOptions(arguments);
        scene = loadScene({file}, loadOptionsOf(options));
        const glm::uvec2 size = sizeOf(scene, options);
        const std::vector<Viewpoint> views = viewsOf(scene, size, options, false);
        scene.camera = views.at(0).camera;
        request = requestOf(options, scene, size);
        request.threads = 1;  // so small a picture takes longer to share out
    });
    if (!r.what.empty()) {
        r.outcome = Outcome::refused;  // before there are sides
        return r;
    }
    VerifyReport report;
    r.what = refusalOf([&] { report = verifyRender(device, scene, request); });
    if (!r.what.empty()) {
        const std::string twin = refusalOf([&] { renderCpu(scene, request); }), gpu = refusalOf([&] { renderGpu(device, scene, request); });
        r.outcome = twin == gpu && (twin == r.what || twin.empty()) ? Outcome::refused : Outcome::refusedApart;
        if (r.outcome == Outcome::refusedApart)
            r.what = fmt::format("the twin: {}; the device: {}", twin.empty() ? "draws" : twin, gpu.empty() ? "draws" : gpu);
        return r;
    }
    r.seen = report.twin.frame.coveredPixels > 0;
    if (!report.equal) {
        r.outcome = Outcome::differs;
        r.what = fmt::format("{}: {}", report.mismatches.front().pass, report.mismatches.front().what);
        return r;
    }
    if (!truth) return r;
    r.truth = request.shading == Shading::ray ? holdRaysAgainstTruth(scene, request, report.device.frame)
                                              : holdAgainstTruth(scene, request, report.device.frame);
    if (r.truth.fault.empty()) return r;
    r.outcome = Outcome::beyondTruth;
    r.what = r.truth.fault;
    return r;
}

class SceneFuzz : public DeviceTest {
protected:
    Case runScene(const FuzzScene& scene) {
        const fs::path file = folder_.write("scene.toml", scene.text());
        return run(device(), file, scene.flagsText(), scene.heldAgainstTruth);
    }

    // Reduces, writes and names it.
    void tell(uint64_t seed, uint64_t index, const FuzzScene& scene, const Case& failed) {
        const FuzzScene least = reduced(
            scene, [&](const FuzzScene& s) { return runScene(s).outcome == failed.outcome; }, kReductions);
        const Case last = runScene(least);
        const fs::path file = fs::path(PLUMB_BINARY_DIR) / "tests/stress/scene_fuzz" / fmt::format("seed{}-scene{}.toml", seed, index);
        fs::create_directories(file.parent_path());
        std::ofstream(file) << least.text();
        ADD_FAILURE() << fmt::format(
            "scene {} of seed {}: {}: {}\n  reduced: {}\n  plumb verify {} {}\n  mend it, and keep the file under tests/data/fuzz/\n"
            "  again: PLUMB_FUZZ_SEED={} PLUMB_FUZZ_SCENE={}",
            index, seed, nameOf(failed.outcome), failed.what, last.what, file.string(), least.flagsText(), seed, index);
    }

    TemporaryFolder folder_;
};

// Each file as its first lines say: a line of flags is a run.
TEST_F(SceneFuzz, ScenesThatOnceFailedAreEqual) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(fs::path(PLUMB_SOURCE_DIR) / "tests/data/fuzz"))
        if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    uint64_t runs = 0;
    for (const fs::path& file : files) {
        std::ifstream in(file);
        uint64_t lines = 0;
        for (std::string line; std::getline(in, line) && line.starts_with(kFlagsLine); ++lines) {
            const std::string flags = line.substr(std::string(kFlagsLine).size());
            const Case r = run(device(), file, flags, false);
            EXPECT_EQ(r.outcome, Outcome::equal) << file << " " << flags << ": " << nameOf(r.outcome) << ": " << r.what;
            ++runs;
        }
        EXPECT_GT(lines, 0u) << file << " begins with no line '" << kFlagsLine << "FLAGS'";
    }
    EXPECT_GT(runs, 0u);
    fmt::print("scene fuzz: {} kept scenes, {} runs\n", files.size(), runs);
}

TEST_F(SceneFuzz, DeviceEqualsTwin) {
    const bool isLong = std::getenv("PLUMB_LONG") != nullptr;
    const uint64_t seed = stated("PLUMB_FUZZ_SEED", isLong ? kLongSeed : kSeed), alone = stated("PLUMB_FUZZ_SCENE", ~0ull);
    const uint64_t first = alone == ~0ull ? 0 : alone,
                   count = alone == ~0ull ? stated("PLUMB_FUZZ_SCENES", isLong ? kLongScenes : kScenes) : 1;
    fmt::print("scene fuzz: seed {}, scenes {} to {}\n", seed, first, first + count - 1);
    std::fflush(stdout);
    std::map<Outcome, uint64_t> outcomes;
    uint64_t seen = 0, failures = 0, run = 0;
    struct Held {
        uint64_t scenes = 0, judged = 0;
        TruthReport truth;
        std::string text() const {
            return fmt::format("{} of {} scenes judged, {} pixels, {} left open, error at most {:.3f} of its bound", judged, scenes,
                               truth.pixels, truth.left, truth.worst);
        }
    } raster, rays;
    std::map<std::string, uint64_t> refusals;
    for (uint64_t i = first; i < first + count && failures < kMostFailures; ++i, ++run) {
        const FuzzScene scene = fuzzScene(seed, i);
        const Case r = runScene(scene);
        ++outcomes[r.outcome];
        seen += r.seen;
        Held& held = scene.rays ? rays : raster;
        held.scenes += scene.heldAgainstTruth && r.outcome != Outcome::refused;
        held.judged += r.truth.pixels > 0;
        held.truth.pixels += r.truth.pixels;
        held.truth.left += r.truth.left;
        held.truth.worst = std::max(held.truth.worst, r.truth.worst);
        if (r.outcome == Outcome::refused) ++refusals[r.what.substr(r.what.find_last_of(':') + 1)];
        if (!r.fails()) continue;
        ++failures;
        if (std::getenv("PLUMB_FUZZ_FIND")) FAIL() << fmt::format("found by scene {}: {}: {}", i, nameOf(r.outcome), r.what);
        tell(seed, i, scene, r);
    }
    fmt::print("scene fuzz: {} scenes: {} equal ({} show something), {} refused alike, {} fail; against the truth: {}; of rays: {}\n", run,
               outcomes[Outcome::equal], seen, outcomes[Outcome::refused], failures, raster.text(), rays.text());
    for (const auto& [sentence, times] : refusals) fmt::print("  refused {:4}:{}\n", times, sentence);
    if (run < kScenesForShares) return;
    EXPECT_GE(double(run - outcomes[Outcome::refused]), kLeastDrawn * double(run)) << "too many are refused to show anything";
    EXPECT_GE(double(seen), kLeastSeen * double(run)) << "too many show nothing";
    for (const Held* held : {&raster, &rays})
        EXPECT_GE(double(held->judged), kLeastJudged * double(held->scenes)) << "the truth judges too few";
}

}  // namespace
}  // namespace plumb::test
