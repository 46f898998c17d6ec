// SPDX-License-Identifier: MIT
// Comparisons of verify: values of the twin and the device, bit for bit or within the bound of the device's own functions.
#pragma once

#include "pipeline/render/evidence.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// Distance in representable floats; the sign bit is folded so that -0 and +0 are 0 apart.
uint64_t ulpDistance(float a, float b);

// True when every bit is the same: -0 is not +0, and a NaN equals itself only bit for bit.
template <class T>
bool sameBits(const T& a, const T& b) {
    const auto x = std::as_bytes(std::span<const T>(&a, 1)), y = std::as_bytes(std::span<const T>(&b, 1));
    return std::equal(x.begin(), x.end(), y.begin());
}

class StageCheck {
public:
    // Adds to report.passes and report.mismatches, and to `evidence` unless that is null. Colours are compared with the bound of the report.
    StageCheck(VerifyReport& report, std::vector<VerifyEvidence>* evidence) : report_(report), evidence_(evidence) {}

    // Compares the output of a pass on both sides. `element`: name of one of its values in a message.
    template <class T>
    void compare(const char* pass, const char* element, std::span<const T> want, std::span<const T> got) {
        const int64_t at = firstDifference(want, got);
        if (at < 0) return equal(pass);
        std::string what = fmt::format("{} {}: ", element, at);
        if (size_t(at) < want.size() && size_t(at) < got.size())
            what += fmt::format("twin has words {}, device has {}", wordsOf(want[size_t(at)]), wordsOf(got[size_t(at)]));
        else
            what += fmt::format("twin has {} of them, device has {}", want.size(), got.size());
        if (want.size() == got.size()) keep(pass, element, want, got);
        differs(pass, what);
    }
    // Keeps the bytes of both sides beside the mismatch that differs() adds.
    template <class T>
    void keep(const char* pass, const char* element, std::span<const T> want, std::span<const T> got) {
        if (evidence_ == nullptr) return;
        const auto bytesOf = [](std::span<const T> values) {
            const std::span<const std::byte> bytes = std::as_bytes(values);
            return std::vector<std::byte>(bytes.begin(), bytes.end());
        };
        evidence_->push_back({pass, element, uint32_t(sizeof(T)), bytesOf(want), bytesOf(got)});
    }
    // Compares colours of the pass illuminate, which may be as far apart as the bound.
    void compareColours(const char* element, std::span<const glm::vec4> want, std::span<const glm::vec4> got);
    bool coloursAsNear(const glm::vec4& twin, const glm::vec4& device) const;  // asNear() of each channel
    // True for the same bits, or values as near as the device's own functions must be.
    bool asNear(float twin, float device, size_t channel) const;

    void equal(const char* pass);
    void differs(const char* pass, const std::string& what);

private:
    // Index of the first element that differs, or -1.
    template <class T>
    static int64_t firstDifference(std::span<const T> want, std::span<const T> got) {
        if (want.size() != got.size()) return int64_t(std::min(want.size(), got.size()));
        for (size_t i = 0; i < want.size(); ++i)
            if (!sameBits(want[i], got[i])) return int64_t(i);
        return -1;
    }
    template <class T>
    static std::string wordsOf(const T& value) {
        std::string text;
        const auto* words = reinterpret_cast<const uint32_t*>(&value);
        for (size_t i = 0; i < sizeof(T) / 4; ++i) text += fmt::format("{}{:08x}", i ? " " : "", words[i]);
        return text;
    }
    std::pair<std::string, bool>& entryOf(const char* pass);

    VerifyReport& report_;
    std::vector<VerifyEvidence>* const evidence_;
};

}  // namespace plumb
