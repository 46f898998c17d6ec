// SPDX-License-Identifier: MIT
// What answers say: errors, allowances, decades, the hash.
#include "pipeline/fingerprint/fingerprint.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/scene/sha256.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr int kLeastDecade = -38;
// Smallest float32 of each decade: literals are rounded to nearest, so the first may lie an ULP outside of its decade.
constexpr std::array<float, 77> kDecades = {
    1e-38f, 1e-37f, 1e-36f, 1e-35f, 1e-34f, 1e-33f, 1e-32f, 1e-31f, 1e-30f, 1e-29f, 1e-28f, 1e-27f, 1e-26f, 1e-25f, 1e-24f, 1e-23f,
    1e-22f, 1e-21f, 1e-20f, 1e-19f, 1e-18f, 1e-17f, 1e-16f, 1e-15f, 1e-14f, 1e-13f, 1e-12f, 1e-11f, 1e-10f, 1e-9f,  1e-8f,  1e-7f,
    1e-6f,  1e-5f,  1e-4f,  1e-3f,  1e-2f,  1e-1f,  1e0f,   1e1f,   1e2f,   1e3f,   1e4f,   1e5f,   1e6f,   1e7f,   1e8f,   1e9f,
    1e10f,  1e11f,  1e12f,  1e13f,  1e14f,  1e15f,  1e16f,  1e17f,  1e18f,  1e19f,  1e20f,  1e21f,  1e22f,  1e23f,  1e24f,  1e25f,
    1e26f,  1e27f,  1e28f,  1e29f,  1e30f,  1e31f,  1e32f,  1e33f,  1e34f,  1e35f,  1e36f,  1e37f,  1e38f};

bool hasDecades(const Trait& trait) { return trait.inUlp() && trait.operands != Operands::oneWord; }

bool isAlternative(const Alternative& a, const Question& q, uint32_t answer) { return a.word(q) == answer; }

std::string hashOfText(const std::string& text) { return sha256Hex(std::as_bytes(std::span(text))); }

// Errors of a trait in ULP, and their decades.
void judgeUlps(const Trait& trait, const Questions& asked, const std::vector<uint32_t>& words, Finding& finding) {
    std::vector<Judged> judged(words.size());
    parallelBands(words.size(), 256, threadCount(0), [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = begin; i < end; ++i) judged[i] = judge(trait, asked.questions[i], words[i]);
    });
    std::map<int, Decade> decades;
    for (uint32_t i = 0; i < words.size(); ++i) {
        const Judged& j = judged[i];
        finding.differing += words[i] != asked.expected[i] ? 1 : 0;
        if (i == 0 || j.error > finding.error) finding.error = j.error, finding.worst = i, finding.allowed = j.allowed;
        if (!j.isAllowed() && finding.beyond++ == 0) finding.firstBeyond = i;
        if (!hasDecades(trait)) continue;
        const int power = decadeOf(asked.questions[i][0]);
        auto [found, fresh] = decades.try_emplace(power, Decade{power, j.error, j.allowed, i});
        if (!fresh && j.error > found->second.error) found->second = {power, j.error, j.allowed, i};
    }
    for (const auto& [power, decade] : decades) finding.decades.push_back(decade);
    finding.verdict = finding.beyond != 0 ? Verdict::beyond : Verdict::within;
    finding.text = finding.beyond != 0      ? "beyond what Vulkan allows"
                   : finding.differing == 0 ? "correctly rounded"
                                            : "within what Vulkan allows";
}

void judgeWords(const Trait& trait, const Questions& asked, const std::vector<uint32_t>& words, Finding& finding) {
    for (uint32_t i = 0; i < words.size(); ++i) {
        if (words[i] != asked.expected[i] && finding.differing++ == 0) finding.worst = i;
        if (!judge(trait, asked.questions[i], words[i]).isAllowed() && finding.beyond++ == 0) finding.firstBeyond = i;
    }
    finding.text = "mixed";
    for (const Alternative& a : trait.alternatives) {
        bool all = true;
        for (uint32_t i = 0; i < words.size() && all; ++i) all = isAlternative(a, asked.questions[i], words[i]);
        if (!all) continue;
        finding.text = a.name;
        break;
    }
    if (trait.finding) finding.text = trait.finding(words);
    finding.allowed = trait.free ? kNoPromise : 0;
    finding.verdict = finding.beyond != 0 ? Verdict::beyond : trait.free ? Verdict::open : Verdict::within;
}

}  // namespace

int decadeOf(uint32_t bits) {
    const float x = std::bit_cast<float>(bits & 0x7fffffffu);
    const auto above = std::upper_bound(kDecades.begin(), kDecades.end(), x);
    return kLeastDecade - 1 + int(above - kDecades.begin());
}

Judged judge(const Trait& trait, const Question& question, uint32_t answer) {
    if (!trait.inUlp()) {
        if (isAlternative(trait.alternatives[0], question, answer)) return {0, trait.free ? kNoPromise : 0};
        for (const Alternative& a : trait.alternatives)
            if (a.allowed && isAlternative(a, question, answer)) return {kUlp, kNoPromise};
        return {kUlp, trait.free ? kNoPromise : 0};
    }
    const Exact exact = trait.exact(question);
    const Exact scale = trait.scale ? trait.scale(question) : exact;
    uint64_t error = distance(exact, answer, scale);
    if (trait.wraps) {
        // The remainder next to 0 and that next to y are neighbours.
        const Exact y = exactOf(question[1]);
        error = std::min({error, distance(plus(exact, y), answer, scale), distance(plus(exact, negated(y)), answer, scale)});
    }
    return {error, trait.allowed(question, exact)};
}

Finding findingOf(const Trait& trait, const Questions& asked, const Answers& answers) {
    Finding finding;
    if (!answers.failure.empty()) {
        finding.verdict = Verdict::failed;
        finding.text = answers.failure;
        return finding;
    }
    if (trait.inUlp())
        judgeUlps(trait, asked, answers.words, finding);
    else
        judgeWords(trait, asked, answers.words, finding);
    return finding;
}

std::string hashOf(const Trait& trait, const Answers& answers) {
    std::string text = std::string(trait.name) + "\n" + answers.failure + "\n";
    for (const uint32_t word : answers.words)
        for (int byte = 0; byte < 32; byte += 8) text += char(word >> byte & 255u);  // the same on a machine of either byte order
    return hashOfText(text);
}

std::string hashOf(const Fingerprint& fingerprint) {
    std::string text = "plumb-fingerprint " + std::to_string(kVersion) + " " + std::to_string(fingerprint.samples) + "\n";
    for (size_t i = 0; i < fingerprint.answers.size(); ++i) text += hashOf(traits()[i], fingerprint.answers[i]) + "\n";
    for (const Sweep& sweep : fingerprint.sweeps) {
        text += sweep.trait + " " + sweep.failure + "\n";
        for (const SweepBlock& block : sweep.blocks) text += block.hash + "\n";
    }
    return hashOfText(text);
}

}  // namespace plumb::fingerprint
