// SPDX-License-Identifier: MIT
// Two fingerprints: which traits differ, where first, and whether Vulkan allows both answers.
#include "pipeline/fingerprint/file.h"

#include <fmt/core.h>
#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb::fingerprint {

namespace {

// Differences of a function that both were asked for with every float.
void compareSweeps(const Fingerprint& left, const Fingerprint& right, std::vector<Difference>& found) {
    for (const Sweep& a : left.sweeps) {
        const auto b = std::find_if(right.sweeps.begin(), right.sweeps.end(), [&](const Sweep& s) { return s.trait == a.trait; });
        if (b == right.sweeps.end()) continue;
        Difference d{.trait = a.trait + ", every float", .what = "every float32 of this function, in blocks of a sign and an exponent"};
        if (a.failure != b->failure || a.blocks.size() != b->blocks.size()) {
            d.differing = 1;
            d.question = "all";
            d.left = a.failure.empty() ? "answered" : a.failure;
            d.right = b->failure.empty() ? "answered" : b->failure;
        }
        for (size_t i = 0; i < std::min(a.blocks.size(), b->blocks.size()); ++i) {
            const SweepBlock &l = a.blocks[i], &r = b->blocks[i];
            if (l.hash == r.hash || d.differing++ != 0) continue;
            d.question = fmt::format("in the block of {}", floatText(l.first));
            d.left = fmt::format("{} ULP at {}: {}", ulpText(l.error), floatText(l.worst), floatText(l.worstAnswer));
            d.right = fmt::format("{} ULP at {}: {}", ulpText(r.error), floatText(r.worst), floatText(r.worstAnswer));
        }
        if (d.differing == 0) continue;
        const auto trait = std::find_if(traits().begin(), traits().end(), [&](const Trait& t) { return t.name == a.trait; });
        if (trait != traits().end()) d.planes = trait->planes, d.allowance = trait->allowance;
        d.leftAllowed = a.beyond == 0 && a.failure.empty();
        d.rightAllowed = b->beyond == 0 && b->failure.empty();
        found.push_back(d);
    }
}

}  // namespace

std::string floatText(uint32_t bits) { return fmt::format("{:08x} ({})", bits, std::bit_cast<float>(bits)); }

std::string ulpText(uint64_t error) {
    if (error == kNoPromise) return "no promise";
    if (error >= kMostUlps) return "all";
    const double ulps = double(error) / double(kUlp);
    return ulps < 1e6 ? fmt::format("{:.3f}", ulps) : fmt::format("{:.3g}", ulps);
}

std::string questionText(const Trait& trait, const Question& q) {
    static constexpr const char* kNames[] = {"x", "y", "z", "w"};
    size_t floats = 0, words = 0;
    switch (trait.operands) {
        case Operands::none:
            break;
        case Operands::one:
        case Operands::two:
        case Operands::three:
        case Operands::four:
            floats = size_t(trait.operands) - size_t(Operands::none);
            break;
        case Operands::oneWord:
            words = 1;
            break;
        case Operands::twoWords:
            words = 2;
            break;
        case Operands::steps:
            words = 4;
            break;
    }
    std::string text;
    // A last operand that says which operation is meant is a number, not a float.
    const bool chooses = floats == 4 && q[3] < 16;
    for (size_t i = 0; i < std::max(floats, words); ++i) {
        if (chooses && i == 2) continue;
        const bool number = i >= floats || (chooses && i == 3);
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", kNames[i], number ? fmt::to_string(q[i]) : floatText(q[i]));
    }
    return text;
}

std::string answerText(const Trait& trait, uint32_t answer) {
    const bool words = trait.operands == Operands::oneWord || trait.operands == Operands::twoWords || trait.operands == Operands::steps;
    const bool number = trait.reads == Reads::number || (trait.reads == Reads::asOperands && words && !trait.inUlp());
    return number ? fmt::format("{:08x} ({})", answer, answer) : floatText(answer);
}

std::vector<Difference> differences(const Fingerprint& left, const Fingerprint& right) {
    std::vector<Difference> found;
    const std::vector<Questions>& asked = allQuestions(left.samples);
    for (size_t t = 0; t < traits().size(); ++t) {
        const Trait& trait = traits()[t];
        const Answers &a = left.answers[t], &b = right.answers[t];
        if (a.failure == b.failure && a.words == b.words) continue;
        Difference d{.trait = trait.name, .what = trait.what, .planes = trait.planes, .allowance = trait.allowance};
        if (!a.failure.empty() || !b.failure.empty()) {
            d.differing = 1;
            d.question = "all";
            d.left = a.failure.empty() ? "answered" : a.failure;
            d.right = b.failure.empty() ? "answered" : b.failure;
            d.leftAllowed = a.failure.empty();
            d.rightAllowed = b.failure.empty();
            found.push_back(d);
            continue;
        }
        for (size_t i = 0; i < a.words.size(); ++i) {
            if (a.words[i] == b.words[i] || d.differing++ != 0) continue;
            const Question& q = asked[t].questions[i];
            d.question = questionText(trait, q);
            d.left = answerText(trait, a.words[i]);
            d.right = answerText(trait, b.words[i]);
            d.leftAllowed = judge(trait, q, a.words[i]).isAllowed();
            d.rightAllowed = judge(trait, q, b.words[i]).isAllowed();
        }
        found.push_back(d);
    }
    compareSweeps(left, right, found);
    return found;
}

}  // namespace plumb::fingerprint
