// SPDX-License-Identifier: MIT
// plumb verify --suite: built-in scenes and checks, one line a test, and JUnit XML. A difference is a verdict (exit 1), not a failure.
#include "pipeline/command/suite_command.h"

#include "host/driver.h"
#include "pipeline/cli/progress.h"
#include "pipeline/command/capsules.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/version.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/library/renderer.h"
#include "pipeline/scene/text.h"
#include "pipeline/suite/reduce.h"
#include "pipeline/suite/suite.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

enum class Verdict { equal, differs, failed, left };

struct Outcome {
    std::string name;
    Verdict verdict = Verdict::equal;
    std::string what;  // what differs, why it failed, or why it was left out
    double seconds = 0;
};

const char* wordOf(Verdict verdict) {
    static constexpr const char* kWords[] = {"equal", "DIFFERS", "FAILED", "left out"};
    return kWords[size_t(verdict)];
}

std::string xmlText(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += uint8_t(c) < 0x20 && c != '\n' && c != '\t' ? '?' : c;
        }
    }
    return out;
}

class Suite {
public:
    Suite(const Options& options, Renderer& renderer)
        : options_(options), renderer_(renderer), progress_(options.progress, options.quiet), start_(std::chrono::steady_clock::now()) {}

    Exit run() {
        const std::span<const suite::PictureTest> pictures = suite::pictureTests();
        const std::span<const suite::ModuleTest> modules = suite::moduleTests();
        const size_t all = pictures.size() + modules.size();
        for (const suite::PictureTest& test : pictures) one(test.name, all, [&](Outcome& outcome) { draw(test, outcome); });
        for (const suite::ModuleTest& test : modules)
            one(test.name, all, [&](Outcome& outcome) {
                outcome.what = test.run(deviceOf(test.limits));
                if (!outcome.what.empty()) outcome.verdict = Verdict::differs;
            });
        progress_.clear();
        renderer_.checkValidation();
        return report();
    }

private:
    template <class Run>
    void one(const char* name, size_t all, const Run& run) {
        stopIfInterrupted();
        progress_.begin(fmt::format("{} {}/{}", name, outcomes_.size() + 1, all), double(outcomes_.size()) / double(all),
                        double(outcomes_.size() + 1) / double(all));
        const auto start = std::chrono::steady_clock::now();
        Outcome outcome{name, Verdict::equal, "", 0};
        try {
            run(outcome);
        } catch (const Error& error) {
            if (error.exit() == Exit::interrupted) throw;
            outcome.verdict = Verdict::failed;
            outcome.what = error.what();
        }
        outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        outcomes_.push_back(outcome);
        if (options_.json && options_.jsonFile.empty()) return;
        progress_.clear();
        printData(fmt::format("{:<9} {:<28} {:6.2f} s{}{}\n", wordOf(outcome.verdict), name, outcome.seconds,
                              outcome.what.empty() ? "" : "  ", printable(outcome.what, 400)));
    }

    // The device, or another one of its kind with fewer limits.
    Device& deviceOf(const std::string& limits) {
        if (limits.empty()) return *renderer_.device();
        const auto found = limited_.find(limits);
        if (found != limited_.end()) return found->second;
        Device device = Device::open(renderer_.choice(), deviceRequestOf(options_));
        shrink(device, limits.c_str());
        return limited_.emplace(limits, std::move(device)).first->second;
    }

    void draw(const suite::PictureTest& test, Outcome& outcome) {
        Device& device = deviceOf(test.limits);
        outcome.what = suite::lacks(device, test);
        if (!outcome.what.empty()) {
            outcome.verdict = Verdict::left;
            return;
        }
        const Scene scene = test.scene(test.width, test.height);
        RenderRequest request = suite::requestOf(test, options_.threads);
        request.watchdogMs = options_.watchdogMs;
        std::string pass;
        try {
            const VerifyReport report = verifyRender(device, scene, request);
            if (report.equal) return;
            outcome.verdict = Verdict::differs;
            pass = report.mismatches[0].pass;
            outcome.what = fmt::format("{}: {}", pass, report.mismatches[0].what);
        } catch (const Error& error) {
            if (error.exit() != Exit::failed || options_.capsule.empty()) throw;
            outcome.verdict = Verdict::failed;
            outcome.what = error.what();
            pass = suite::differingPass(device, scene, request);
        }
        if (options_.capsule.empty()) return;
        const std::filesystem::path folder = options_.capsule;
        outcome.what += "; " + writeCapsule(options_, device, scene, request, pass, folder / test.name, progress_);
    }

    // Modules of the program that no device ran.
    std::vector<std::string> modulesNotRun() {
        std::set<std::string, std::less<>> run = modulesRun(*renderer_.device());
        for (const auto& [limits, device] : limited_) run.insert(modulesRun(device).begin(), modulesRun(device).end());
        std::vector<std::string> left;
        for (const auto& [name, sha256] : spirvModules())
            if (!run.contains(name)) left.emplace_back(name);
        return left;
    }

    std::string junit(double seconds) const {
        std::string cases;
        size_t differing = 0, failed = 0, left = 0;
        for (const Outcome& o : outcomes_) {
            cases += fmt::format("  <testcase classname=\"plumb.suite\" name=\"{}\" time=\"{:.3f}\"", xmlText(o.name), o.seconds);
            const char* const element = o.verdict == Verdict::differs ? "failure" : o.verdict == Verdict::failed ? "error" : "skipped";
            cases += o.verdict == Verdict::equal ? "/>\n" : fmt::format("><{} message=\"{}\"/></testcase>\n", element, xmlText(o.what));
            differing += o.verdict == Verdict::differs;
            failed += o.verdict == Verdict::failed;
            left += o.verdict == Verdict::left;
        }
        return fmt::format(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"plumb verify --suite\" hostname=\"{}\" tests=\"{}\" "
            "failures=\"{}\" "
            "errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n{}</testsuite>\n",
            xmlText(renderer_.name()), outcomes_.size(), differing, failed, left, seconds, cases);
    }

    Exit report() {
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        const std::vector<std::string> left = modulesNotRun();
        const size_t modules = spirvModules().size();
        size_t counts[4] = {};
        Json json;
        json["tool"] = toolJson();
        json["host"] = hostJson();
        json["device"] = deviceJson(renderer_);
        json["tests"] = Json::array();
        for (const Outcome& o : outcomes_) {
            ++counts[size_t(o.verdict)];
            json["tests"].push_back({{"name", o.name}, {"verdict", wordOf(o.verdict)}, {"what", o.what}, {"seconds", o.seconds}});
        }
        json["modules"] = {{"embedded", modules}, {"run", modules - left.size()}, {"not_run", left}};
        json["equal"] = counts[1] + counts[2] == 0;
        std::string text = fmt::format("{} tests on {}: {} equal, {} differ, {} failed, {} left out; {} of {} modules ran{}{}; {:.1f} s\n",
                                       outcomes_.size(), printable(renderer_.name()), counts[0], counts[1], counts[2], counts[3],
                                       modules - left.size(), modules, left.empty() ? "" : ", not ", fmt::join(left, ", "), seconds);
        FileBatch files;
        if (!options_.junit.empty()) {
            const std::string xml = junit(seconds);
            files.add(options_.junit, std::as_bytes(std::span(xml)), options_.noClobber);
        }
        finish(options_, files, options_.json && options_.jsonFile.empty() ? "" : text, {json});
        return counts[1] != 0 ? Exit::overGate : counts[2] != 0 ? Exit::failed : Exit::done;
    }

    const Options& options_;
    Renderer& renderer_;
    Progress progress_;
    const std::chrono::steady_clock::time_point start_;
    std::map<std::string, Device> limited_;  // by their limits
    std::vector<Outcome> outcomes_;
};

}  // namespace

Exit suiteCommand(const Options& options) {
    refuseCapsuleFolder(options);
    if (!options.junit.empty()) checkWritable(options.junit, options.noClobber);
    Renderer renderer(deviceRequestOf(options));
    if (renderer.device() == nullptr)
        throw deviceError(fmt::format("the suite compares a device with the twin, and there is no device: {}", renderer.choice().reason));
    if (options.verbose != 0) say(options, fmt::format("device: {}", renderer.choice().reason));
    return Suite(options, renderer).run();
}

}  // namespace plumb
