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

void StageCheck::compareColours(const char* element, std::span<const glm::vec4> want, std::span<const glm::vec4> got) {
    std::vector<glm::vec4> near(got.begin(), got.end());
    for (size_t i = 0; i < std::min(want.size(), near.size()); ++i)
        if (asNear(want[i].x, near[i].x, 0) && asNear(want[i].y, near[i].y, 1) && asNear(want[i].z, near[i].z, 2)) near[i] = want[i];
    compare<glm::vec4>("illuminate", element, want, near);
}

}  // namespace plumb
