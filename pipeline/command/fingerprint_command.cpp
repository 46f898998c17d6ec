// SPDX-License-Identifier: MIT
// plumb devices --fingerprint: what the picked device does with numbers. --compare: what two devices do differently; a difference is a
// verdict (exit 1), not a failure.
#include "pipeline/command/fingerprint_command.h"

#include "pipeline/cli/progress.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/request.h"
#include "pipeline/fingerprint/file.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/library/renderer.h"
#include "pipeline/report/fingerprint_page.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {
namespace {

namespace fp = fingerprint;

constexpr uint64_t kMostFileBytes = uint64_t(64) << 20;

std::string rowOfTrait(const fp::Trait& trait, const fp::Questions& asked, const fp::Finding& finding) {
    const char* const mark = finding.verdict == fp::Verdict::beyond ? "!" : finding.verdict == fp::Verdict::failed ? "?" : " ";
    const std::string measured = finding.verdict == fp::Verdict::failed ? "-" : trait.inUlp() ? fp::ulpText(finding.error) : "";
    const std::string allowed = trait.inUlp() && finding.verdict != fp::Verdict::failed ? fp::ulpText(finding.allowed) : "";
    std::string text = fmt::format("{} {:<22} {:>10} {:>10}  {}", mark, trait.name, measured, allowed, finding.text);
    if (!trait.inUlp() && finding.differing != 0 && finding.text == "mixed")
        text += fmt::format(": {} of {} differ", finding.differing, asked.questions.size());
    if (finding.verdict == fp::Verdict::beyond || (trait.inUlp() && finding.differing != 0))
        text += fmt::format(
            ", first at {}",
            fp::questionText(trait, asked.questions[finding.verdict == fp::Verdict::beyond ? finding.firstBeyond : finding.worst]));
    return text + "\n";
}

std::string textOf(const fp::Fingerprint& f, std::span<const fp::Finding> findings) {
    std::string text = fmt::format("{}, {} {}\n  {:<22} {:>10} {:>10}  {}\n", printable(f.device.name), printable(f.device.driver),
                                   printable(f.device.driverInfo), "trait", "ULP", "allowed", "what the device does");
    std::array<size_t, 4> counts{};
    std::string_view group;
    for (size_t i = 0; i < findings.size(); ++i) {
        const fp::Trait& trait = fp::traits()[i];
        if (group != trait.group) text += fmt::format("{}\n", group = trait.group);
        text += rowOfTrait(trait, fp::allQuestions(f.samples)[i], findings[i]);
        ++counts[size_t(findings[i].verdict)];
    }
    for (const fp::Sweep& sweep : f.sweeps) {
        uint64_t error = 0;
        uint32_t worst = 0;
        for (const fp::SweepBlock& b : sweep.blocks)
            if (b.error > error && b.error < kMostUlps) error = b.error, worst = b.worst;
        text += fmt::format("{} {}, every float: ", sweep.beyond != 0 ? "!" : sweep.failure.empty() ? " " : "?", sweep.trait);
        text +=
            !sweep.failure.empty() ? sweep.failure : fmt::format("at most {} ULP, first at {}", fp::ulpText(error), fp::floatText(worst));
        text += sweep.beyond != 0
                    ? fmt::format("; {} beyond what Vulkan allows, first at {}\n", sweep.beyond, fp::floatText(sweep.firstBeyond))
                    : "\n";
    }
    text += fmt::format("{} traits: {} within what Vulkan allows, {} where it promises nothing, {} beyond (!), {} not answered (?)\n",
                        findings.size(), counts[0], counts[2], counts[1], counts[3]);
    return text + fmt::format("hash {}\n", fp::hashOf(f));
}

std::string sideText(const std::string& answer, bool allowed) {
    return fmt::format("{}{}", answer, allowed ? "" : "  (Vulkan does not allow it)");
}

}  // namespace

Exit fingerprintCommand(const Options& options) {
    Renderer renderer(deviceRequestOf(options));
    if (renderer.device() == nullptr)
        throw deviceError(fmt::format("a fingerprint is of a Vulkan device, and there is none: {}", renderer.choice().reason));
    if (!options.output.empty()) checkWritable(options.output, options.noClobber);
    Progress progress(options.progress, options.quiet);
    const auto tell = [&](double share) {
        progress.update(share);
        stopIfInterrupted();
    };
    progress.begin("fingerprint", 0, options.allFloats ? 0.02 : 1);
    fp::Fingerprint f = fp::ask(*renderer.device(), fp::kSamples, tell);
    if (options.allFloats) {
        progress.begin("every float", 0.02, 1);
        f.sweeps = fp::sweep(*renderer.device(), 0, tell);
    }
    progress.clear();
    renderer.checkValidation();
    std::vector<fp::Finding> findings;
    for (size_t i = 0; i < f.answers.size(); ++i)
        findings.push_back(fp::findingOf(fp::traits()[i], fp::allQuestions(f.samples)[i], f.answers[i]));
    const Json json = options.json || !options.output.empty() ? fp::jsonOf(f, findings, toolJson()) : Json();
    FileBatch files;
    if (!options.output.empty()) {
        const std::string page = fingerprintHtml(json);
        files.add(options.output, std::as_bytes(std::span(page)), options.noClobber);
    }
    const bool reportOnOutput = options.json && options.jsonFile.empty();
    finish(options, files, reportOnOutput ? "" : textOf(f, findings), {json});
    return Exit::done;
}

Exit compareFingerprintsCommand(const Options& options) {
    std::vector<fp::Fingerprint> both;
    for (const std::string& path : options.inputs) both.push_back(fp::fingerprintOf(printable(path), readInput(path, {}, kMostFileBytes)));
    if (both[0].samples != both[1].samples)
        throw inputError(printable(options.inputs[1]), fmt::format("has {} samples a trait, and '{}' has {}: make both with one program",
                                                                   both[1].samples, printable(options.inputs[0]), both[0].samples));
    const std::vector<fp::Difference> found = fp::differences(both[0], both[1]);
    Json json;
    json["schema"] = "plumb-fingerprint-compare-1";
    json["tool"] = toolJson();
    std::string text;
    for (size_t side = 0; side < 2; ++side) {
        const char* const name = side == 0 ? "left" : "right";
        const std::string hash = fp::hashOf(both[side]);
        text += fmt::format("{:<5} {}: {}, {} {}, hash {}\n", name, printable(options.inputs[side]), printable(both[side].device.name),
                            printable(both[side].device.driver), printable(both[side].device.driverInfo), hash.substr(0, 16));
        json[name] = {{"file", options.inputs[side]},
                      {"device", both[side].device.name},
                      {"driverInfo", both[side].device.driverInfo},
                      {"hash", hash}};
    }
    json["equal"] = found.empty();
    json["differences"] = Json::array();
    for (const fp::Difference& d : found) {
        text += fmt::format("{}: {} answer{}, first at {}\n  left   {}\n  right  {}\n  Vulkan {}\n  planes {}\n", d.trait, d.differing,
                            d.differing == 1 ? " differs" : "s differ", d.question, sideText(d.left, d.leftAllowed),
                            sideText(d.right, d.rightAllowed), d.allowance, d.planes);
        json["differences"].push_back({{"trait", d.trait},
                                       {"what", d.what},
                                       {"differing", d.differing},
                                       {"question", d.question},
                                       {"left", d.left},
                                       {"right", d.right},
                                       {"leftAllowed", d.leftAllowed},
                                       {"rightAllowed", d.rightAllowed},
                                       {"allowance", d.allowance},
                                       {"planes", d.planes}});
    }
    const size_t traits = fp::traits().size();
    text += found.empty() ? fmt::format("{} traits: all the same\n", traits) : fmt::format("{} traits: {} differ\n", traits, found.size());
    FileBatch files;
    finish(options, files, options.json && options.jsonFile.empty() ? "" : text, {json});
    return found.empty() ? Exit::done : Exit::overGate;
}

}  // namespace plumb
