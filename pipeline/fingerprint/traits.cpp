// SPDX-License-Identifier: MIT
#include "pipeline/fingerprint/traits.h"

#include "host/error.h"
#include "pipeline/passes/parallel.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string_view>
#include <vector>

namespace plumb::fingerprint {

Draw::Draw(const char* trait, uint32_t item) : state_(0xcbf29ce484222325u) {
    for (const char c : std::string_view(trait)) state_ = (state_ ^ uint8_t(c)) * 0x100000001b3u;  // FNV-1a
    state_ += uint64_t(item) * 0x9e3779b97f4a7c15u;
}

// Steele, Lea and Flood's SplitMix64.
uint32_t Draw::word() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return uint32_t((z ^ z >> 31) >> 32);
}

uint32_t Draw::significand() {
    const uint32_t bits = word();
    switch (bits >> 29) {
        case 0:
            return bits & 7u;  // just above a power of two
        case 1:
            return 0x7fffffu - (bits & 7u);  // just below one
        case 2:
            return ((1u << (bits >> 8) % 23u) + (bits & 3u)) & 0x7fffffu;  // few bits set
        default:
            return bits & 0x7fffffu;
    }
}

uint32_t Draw::real(int least, int most) {
    const uint32_t sign = word() & 0x80000000u;
    const uint32_t exponent = uint32_t(between(least, most) + 127);
    return sign | exponent << 23 | significand();
}

const std::vector<Trait>& traits() {
    static const std::vector<Trait> kTraits = [] {
        std::vector<Trait> list;
        addArithmetic(list);
        addConversions(list);
        addBehaviour(list);
        addIntegers(list);
        addExecution(list);
        return list;
    }();
    return kTraits;
}

Questions questionsOf(const Trait& trait, uint32_t samples) {
    Questions q;
    const uint32_t items = trait.items != 0 ? trait.items : samples;
    q.questions.resize(items);
    q.expected.resize(items);
    parallelBands(items, 256, threadCount(0), [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = begin; i < end; ++i) {
            q.questions[i] = trait.question(uint32_t(i));
            q.expected[i] = trait.inUlp() ? nearestFloat(trait.exact(q.questions[i])) : trait.alternatives.at(0).word(q.questions[i]);
        }
    });
    return q;
}

const std::vector<Questions>& allQuestions(uint32_t samples) {
    static std::mutex mutex;
    static std::map<uint32_t, std::vector<Questions>> made;
    const std::lock_guard lock(mutex);
    std::vector<Questions>& all = made[samples];
    if (all.empty())
        for (const Trait& trait : traits()) all.push_back(questionsOf(trait, samples));
    return all;
}

}  // namespace plumb::fingerprint
