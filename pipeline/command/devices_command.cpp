// SPDX-License-Identifier: MIT
// plumb devices: the devices found, the one that would be picked and why not the others, and the self-test of each.
#include "pipeline/command/command.h"
#include "pipeline/command/fingerprint_command.h"
#include "pipeline/command/request.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb {
namespace {

struct Tested {
    SelfTest test;
    std::string failure;
    uint64_t budgetBytes = 0;
};

Tested tested(const DeviceInfo& info, const DeviceRequest& request) {
    Tested result;
    if (!info.unusableBecause.empty()) {
        result.failure = info.unusableBecause;
        return result;
    }
    try {
        DeviceChoice choice;
        choice.info = info;
        const Device device = Device::open(choice, request);
        result.test = device.selfTest();
        result.failure = result.test.failure;
        result.budgetBytes = device.memoryBudgetBytes();
    } catch (const Error& error) {  // a list names a broken device and goes on
        result.failure = error.what();
    }
    return result;
}

std::string yesNo(bool value) { return value ? "yes" : "no"; }

}  // namespace

Exit devicesCommand(const Options& options) {
    if (options.fingerprint) return fingerprintCommand(options);
    if (options.compare) return compareFingerprintsCommand(options);
    const DeviceRequest request = deviceRequestOf(options);
    std::string why;
    const std::vector<DeviceInfo> devices = Device::list(&why);
    const DeviceChoice choice = Device::choose(request);
    std::string text;
    Json json;
    json["tool"] = toolJson();
    json["devices"] = Json::array();
    if (devices.empty()) text += fmt::format("no Vulkan device: {}\n", why);
    for (const DeviceInfo& info : devices) {
        const bool picked = !choice.twin && choice.info.index == info.index;
        const Tested t = tested(info, request);
        if (picked && !t.failure.empty() && !options.requireDevice.empty())
            throw deviceError(fmt::format("'{}' cannot draw: {}", info.name, t.failure));
        text += fmt::format("{} {}  {}\n", picked ? "*" : " ", info.index, printable(info.name));
        text += fmt::format("     {}, {} {}, Vulkan {}, {}\n", info.type, printable(info.driver), printable(info.driverInfo),
                            info.apiVersion, info.uuid);
        text += t.failure.empty()
                    ? fmt::format("     self-test passed{}; native division exact: {}, native root exact: {}; memory budget {} MiB\n",
                                  t.test.fromCache ? " (kept from before)" : "", yesNo(t.test.nativeDivideIsExact),
                                  yesNo(t.test.nativeRootIsExact), t.budgetBytes >> 20)
                    : fmt::format("     cannot draw: {}\n", t.failure);
        json["devices"].push_back({{"index", info.index},
                                   {"name", info.name},
                                   {"type", info.type},
                                   {"driver", info.driver},
                                   {"driverInfo", info.driverInfo},
                                   {"api", info.apiVersion},
                                   {"uuid", info.uuid},
                                   {"lavapipe", info.lavapipe},
                                   {"picked", picked},
                                   {"unusable", t.failure},
                                   {"selfTest",
                                    {{"passed", t.failure.empty()},
                                     {"fromCache", t.test.fromCache},
                                     {"time_ms", t.test.timeMs},
                                     {"nativeDivideIsExact", t.test.nativeDivideIsExact},
                                     {"nativeRootIsExact", t.test.nativeRootIsExact},
                                     {"loopLimit", t.test.loopLimit}}}});
    }
    text += fmt::format("{} twin  the CPU reference, always there\n", choice.twin ? "*" : " ");
    text += fmt::format("picked: {}\n", choice.reason);
    for (const std::string& line : choice.notChosen) text += fmt::format("not picked: {}\n", line);
    if (!choice.advice.empty()) text += fmt::format("{}\n", choice.advice);
    json["picked"] = choice.twin ? Json("twin") : Json(choice.info.index);
    json["reason"] = choice.reason;
    json["notChosen"] = choice.notChosen;
    json["advice"] = choice.advice;
    if (!options.json || !options.jsonFile.empty()) printData(text);
    writeJson(options, {json});
    return Exit::done;
}

}  // namespace plumb
