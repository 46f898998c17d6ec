// SPDX-License-Identifier: MIT
// plumb replay: the dispatch of a capsule again, so many times; what it leaves is counted. Another result than the expected is a verdict
// (exit 1), not a failure.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/library/renderer.h"
#include "pipeline/scene/text.h"
#include "pipeline/suite/capsule.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb {
namespace {

const char* wordOf(suite::Outcome outcome) {
    static constexpr const char* kWords[] = {"as expected", "as captured", "neither", "failed"};
    return kWords[size_t(outcome)];
}

// One distinct result and how often it came.
struct Result {
    std::string hash, text;
    suite::Outcome outcome;
    uint32_t times = 0;
};

// What the compared values of a run say.
std::string valuesText(const suite::Capsule& capsule, const DispatchRecord& run) {
    if (!run.failure.empty()) return run.failure;
    if (capsule.elementBytes == 0) return "";
    const std::vector<std::byte> values = suite::valuesOf(capsule, run);
    if (values.empty()) return "the compared values are made from the result on the host, and are not judged here";
    const suite::ValueDifference found = suite::differenceOf(capsule.expected, values, capsule.elementBytes);
    if (found.differing == 0) return fmt::format("all {} values are those of the twin", found.count);
    return fmt::format("{} of {} values differ, {} {} first: expected {}, got {}", found.differing, found.count, capsule.element,
                       found.first, suite::wordsOf(capsule.expected, found.first, capsule.elementBytes),
                       suite::wordsOf(values, found.first, capsule.elementBytes));
}

std::vector<Result> runsOf(const Options& options, Device& device, const suite::Capsule& capsule) {
    std::vector<Result> results;
    Progress progress(options.progress, options.quiet);
    progress.begin("replay", 0, 1);
    for (uint32_t n = 0; n < options.times; ++n) {
        stopIfInterrupted();
        const DispatchRecord run = replay(device, capsule.dispatch, options.watchdogMs);
        const std::string hash = suite::hashOf(run);
        auto found = std::find_if(results.begin(), results.end(), [&](const Result& r) { return r.hash == hash; });
        if (found == results.end())
            found = results.insert(results.end(), {hash, valuesText(capsule, run), suite::outcomeOf(capsule, run), 0});
        ++found->times;
        progress.update(double(n + 1) / double(options.times));
    }
    progress.clear();
    std::stable_sort(results.begin(), results.end(), [](const Result& a, const Result& b) { return a.times > b.times; });
    return results;
}

}  // namespace

Exit replayCommand(const Options& options) {
    if (options.inputs.size() != 1)
        throw usageError(fmt::format("`plumb replay` needs one capsule, and {} are given", options.inputs.size()));
    const std::string folder = printable(options.inputs[0]);
    const suite::Capsule capsule = suite::readCapsule(options.inputs[0]);
    Renderer renderer(deviceRequestOf(options));
    if (renderer.device() == nullptr)
        throw deviceError(fmt::format("a capsule runs on a Vulkan device, and there is none: {}", renderer.choice().reason));
    Device& device = *renderer.device();
    const suite::Json captured = capsule.about.value("device", suite::Json::object());
    const std::string from = captured.value("name", "");
    if (const uint32_t lanes = captured.value("subgroupSize", 0u); lanes != device.limits().subgroupSize)
        say(options,
            fmt::format("the capsule is of a device with subgroups of {}, and this one has {}", lanes, device.limits().subgroupSize));
    const std::vector<Result> results = runsOf(options, device, capsule);
    renderer.checkValidation();
    std::string text = fmt::format("{}: {} in module {}, {} invocations, {} buffers, captured on {}\n  {}\n", folder,
                                   printable(capsule.pass), printable(capsule.dispatch.module), capsule.dispatch.items,
                                   capsule.dispatch.bindings.size(), printable(from), printable(capsule.what));
    text += fmt::format("{} runs on {}: {} distinct result{}\n", options.times, printable(device.info().name), results.size(),
                        results.size() == 1 ? "" : "s");
    Json json;
    json["tool"] = toolJson();
    json["device"] = deviceJson(renderer);
    json["capsule"] = options.inputs[0];
    json["pass"] = capsule.pass;
    json["module"] = capsule.dispatch.module;
    json["runs"] = options.times;
    json["results"] = Json::array();
    bool right = true;
    for (const Result& r : results) {
        right = right && r.outcome == suite::Outcome::expected;
        text += fmt::format("  {} x {}, {}{}{}\n", r.times, r.hash.substr(0, 16), wordOf(r.outcome), r.text.empty() ? "" : ": ",
                            printable(r.text, 400));
        json["results"].push_back({{"times", r.times}, {"sha256", r.hash}, {"outcome", wordOf(r.outcome)}, {"what", r.text}});
    }
    json["equal"] = right;
    FileBatch files;
    finish(options, files, options.json && options.jsonFile.empty() ? "" : text, {json});
    return right ? Exit::done : Exit::overGate;
}

}  // namespace plumb
