// SPDX-License-Identifier: MIT
// Choice of the device and its reason: the words of --device and --require-device over a list of devices.
#include "host/vulkan.h"

#include <fmt/core.h>
#include <cstdint>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace plumb {

namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

bool isGpu(const DeviceInfo& d) { return d.type == "discrete" || d.type == "integrated" || d.type == "virtual"; }

// Rank of a device under auto, best first: discrete, integrated, virtual GPU, lavapipe, other CPU device, anything else.
int rank(const DeviceInfo& d) {
    if (d.type == "discrete") return 0;
    if (d.type == "integrated") return 1;
    if (d.type == "virtual") return 2;
    return d.lavapipe ? 3 : d.type == "cpu" ? 4 : 5;
}

bool matches(const DeviceInfo& d, const std::string& word) {
    const std::string w = lower(word);
    if (w.empty() || w == "auto") return true;
    if (w == "lavapipe") return d.lavapipe;
    if (w == "gpu") return isGpu(d);
    if (w == "software") return d.type == "cpu";
    const auto digit = [](unsigned char c) { return std::isdigit(c) != 0; };
    if (w.size() <= 3 && std::all_of(w.begin(), w.end(), digit)) return d.index == uint32_t(std::stoul(w));
    std::string hex = w;
    std::erase(hex, '-');
    if (hex == d.uuid) return true;
    return lower(d.name).find(w) != std::string::npos || lower(d.driver).find(w) != std::string::npos;
}

const char* const kAdvice =
    "install a Vulkan driver: 'apt install mesa-vulkan-drivers' (lavapipe) and 'libvulkan1' are enough on a machine "
    "without GPU;\n"
    "if one is installed, look at VK_ICD_FILENAMES and VK_DRIVER_FILES. '--device twin' draws without Vulkan.";

}  // namespace

DeviceChoice chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& whyNone, const DeviceRequest& request) {
    const std::string prefer = request.prefer.empty() ? "auto" : request.prefer;
    const bool preferAuto = lower(prefer) == "auto", preferTwin = lower(prefer) == "twin";
    const bool requireAny = request.require.empty() || lower(request.require) == "auto";
    const bool requireTwin = lower(request.require) == "twin";
    const auto none = [&](const std::string& wanted) {
        std::string found;
        for (const DeviceInfo& d : devices)
            found += fmt::format("{}{} '{}' ({}{}{})", found.empty() ? "" : ", ", d.index, d.name, d.type,
                                 d.unusableBecause.empty() ? "" : "; unusable: ", d.unusableBecause);
        return deviceError(
            fmt::format("{}: no such device; {}", wanted,
                        devices.empty() ? fmt::format("{}\n{}", whyNone.empty() ? "none was found" : whyNone, kAdvice) : "found " + found));
    };

    DeviceChoice choice;
    if (preferTwin || (requireTwin && preferAuto)) {
        if (!requireAny && !requireTwin) throw deviceError(fmt::format("--require-device {} excludes --device twin", request.require));
        choice.twin = true;
        choice.reason = preferTwin ? "the CPU twin was asked for" : "the CPU twin is required";
        return choice;
    }
    if (requireTwin) throw deviceError(fmt::format("--require-device twin excludes --device {}", prefer));

    std::vector<const DeviceInfo*> candidates;
    bool preferExists = false;
    for (const DeviceInfo& d : devices) {
        const bool wanted = matches(d, prefer);
        preferExists = preferExists || wanted;
        if (!wanted)
            choice.notChosen.push_back(fmt::format("{}: is not '{}'", d.name, prefer));
        else if (!matches(d, request.require))
            choice.notChosen.push_back(fmt::format("{}: is not the required '{}'", d.name, request.require));
        else if (!d.unusableBecause.empty())
            choice.notChosen.push_back(fmt::format("{}: {}", d.name, d.unusableBecause));
        else
            candidates.push_back(&d);
    }
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto* a, const auto* b) { return rank(*a) < rank(*b); });
    if (candidates.empty()) {
        if (!preferAuto && !preferExists) throw none("--device " + prefer);
        if (!requireAny) throw none("--require-device " + request.require);
        if (!preferAuto) throw none("--device " + prefer);
        choice.twin = true;
        choice.reason = devices.empty() ? fmt::format("the CPU twin draws: {}", whyNone.empty() ? "no Vulkan device was found" : whyNone)
                                        : fmt::format("the CPU twin draws: no device is usable ({})", choice.notChosen.front());
        choice.advice = kAdvice;
        return choice;
    }
    choice.info = *candidates.front();
    for (size_t i = 1; i < candidates.size(); ++i)
        choice.notChosen.push_back(fmt::format("{}: '{}' comes before it", candidates[i]->name, choice.info.name));
    const std::string kind = isGpu(choice.info)     ? choice.info.type + " GPU"
                             : choice.info.lavapipe ? "lavapipe"
                                                    : choice.info.type + " device";
    choice.reason = preferAuto ? fmt::format("device {} '{}': the first usable {}{}", choice.info.index, choice.info.name, kind,
                                             isGpu(choice.info) ? "" : "; no usable GPU was found")
                               : fmt::format("device {} '{}': asked for as '{}'", choice.info.index, choice.info.name, prefer);
    return choice;
}

DeviceChoice Device::choose(const DeviceRequest& request) {
    // The twin needs no Vulkan, so no loader is touched for it.
    if (lower(request.prefer) == "twin") return chooseDevice({}, {}, request);
    std::string why;
    const std::shared_ptr<Instance> instance = Instance::acquire(validationWanted(request), why);
    std::vector<DeviceInfo> devices;
    if (instance)
        for (const VkPhysicalDevice physical : instance->physicalDevices()) devices.push_back(describe(physical, uint32_t(devices.size())));
    DeviceChoice choice = chooseDevice(devices, why, request);
    choice.keepAlive = instance;
    return choice;
}

}  // namespace plumb
