// SPDX-License-Identifier: MIT
#include "pipeline/render/stage_check.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

uint64_t ulpDistance(float a, float b) {
    const auto ordered = [](float f) {
        const int64_t i = std::bit_cast<int32_t>(f);
        return i < 0 ? int64_t(INT32_MIN) - i : i;
    };
    return uint64_t(std::abs(ordered(a) - ordered(b)));
}

std::pair<std::string, bool>& StageCheck::entryOf(const char* pass) {
    const auto entry = std::find_if(report_.passes.begin(), report_.passes.end(), [&](const auto& p) { return p.first == pass; });
    return entry != report_.passes.end() ? *entry : report_.passes.emplace_back(pass, true);
}

void StageCheck::equal(const char* pass) { entryOf(pass); }

void StageCheck::differs(const char* pass, const std::string& what) {
    entryOf(pass).second = false;
    report_.mismatches.push_back({pass, false, what});
}

bool StageCheck::asNear(float twin, float device, size_t channel) const {
    if (!std::isfinite(twin) || !std::isfinite(device)) return false;
    return sameBits(twin, device) || std::abs(double(twin) - double(device)) <= report_.boundLinear[glm::length_t(channel)];
}

bool StageCheck::coloursAsNear(const glm::vec4& twin, const glm::vec4& device) const {
    return asNear(twin.x, device.x, 0) && asNear(twin.y, device.y, 1) && asNear(twin.z, device.z, 2);
}

void StageCheck::compareColours(const char* element, std::span<const glm::vec4> want, std::span<const glm::vec4> got) {
    std::vector<glm::vec4> expected(want.begin(), want.end());
    for (size_t i = 0; i < std::min(want.size(), got.size()); ++i)
        if (coloursAsNear(want[i], got[i])) expected[i] = got[i];
    compare<glm::vec4>("illuminate", element, expected, got);
}

}  // namespace plumb
