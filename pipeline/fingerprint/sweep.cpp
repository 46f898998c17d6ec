// SPDX-License-Identifier: MIT
// Every float32 of six functions, an exponent and its two signs at a time. What costs most in the reference depends on the significand alone
// for the roots and the logarithm, so it is made once for all exponents; sine and cosine serve both signs.
#include "host/buffer.h"
#include "host/recorder.h"
#include "pipeline/fingerprint/fingerprint.h"
#include "pipeline/fingerprint/functions.h"
#include "pipeline/passes/parallel.h"
#include "shared/fingerprint.h"

#include <fmt/core.h>
#include <spirv/fingerprint_sweep.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr uint32_t kBlock = 1u << 23;  // floats of one sign and exponent
constexpr uint32_t kChunk = 1u << 17;
constexpr double kWatchdogMs = 60000;

enum Function : uint32_t { kSqrt, kInverseSqrt, kExp2, kLog2, kSin, kCos, kFunctions };
constexpr const char* kNames[kFunctions] = {"sqrt", "inversesqrt", "exp2", "log2", "sin", "cos"};

const Trait& traitNamed(const char* name) {
    const auto found = std::find_if(traits().begin(), traits().end(), [&](const Trait& t) { return std::string(t.name) == name; });
    PLUMB_ASSERT(found != traits().end());
    return *found;
}

// Results of [1, 4) for the roots, of [1, 2) for the logarithm: the top 64 bits of each.
class Reference {
public:
    Reference(Function function, uint32_t threads) : function_(function) {
        if (function == kExp2 || function == kSin || function == kCos) return;
        top_.resize(function == kLog2 ? kBlock : 2 * size_t(kBlock));
        parallelBands(top_.size(), kChunk, threads, [&](uint64_t begin, uint64_t end) {
            for (uint64_t i = begin; i < end; ++i) {
                const uint32_t x = 0x3f800000u + uint32_t(i);
                if (function == kLog2)
                    top_[i] = i == 0 ? 0 : fractionOf(log2Of(x));
                else
                    top_[i] = uint64_t((function == kSqrt ? rootOf(exactOf(x)) : inverseRootOf(exactOf(x))).mantissa >> 64);
            }
        });
    }

    // True value of the function at a normal number, which is positive for the roots and the logarithm.
    Exact of(uint32_t bits) const {
        const int exponent = exponentOf(bits), parity = exponent & 1, half = (exponent - parity) / 2;
        const uint32_t significand = bits & 0x7fffffu;
        const uint32_t reduced = uint32_t(parity) << 23 | significand;
        switch (function_) {
            case kSqrt:
                return {Exact::Kind::finite, false, true, half - 127, Wide(top_[reduced]) << 64};
            case kInverseSqrt:
                return {Exact::Kind::finite, false, true, -half - (reduced == 0 ? 127 : 128), Wide(top_[reduced]) << 64};
            case kLog2:
                return logarithm(bits, exponent, significand);
            case kExp2:
                if (exponent >= -40) return exp2Of(bits);
                return bits >> 31 != 0 ? justBelowOne() : Exact::finite(false, Wide(1) << 127, -127, true);
            case kSin:
                if (exponent >= -30) return sinOf(bits);
                return {Exact::Kind::finite, bits >> 31 != 0, true, exponentOf(bits) - 127, (Wide(significand | 0x800000u) << 104) - 1};
            default:
                return exponent >= -30 ? cosOf(bits) : justBelowOne();
        }
    }

private:
    static Exact justBelowOne() { return {Exact::Kind::finite, false, true, -128, ~Wide(0)}; }
    // Bits behind the point of a number in [0, 1).
    static uint64_t fractionOf(const Exact& x) { return uint64_t(x.mantissa >> 64 >> (-128 - x.exponent)); }
    Exact logarithm(uint32_t bits, int exponent, uint32_t significand) const {
        if (exponent == -1 || exponent == 0) return log2Of(bits);  // near 1 the result is small, and 64 bits are few
        const uint64_t fraction = top_[significand];
        const uint64_t whole = uint64_t(exponent < 0 ? -exponent - (fraction != 0 ? 1 : 0) : exponent);
        return Exact::finite(exponent < 0, Wide(whole) << 64 | (exponent < 0 ? 0 - fraction : fraction), -64, significand != 0);
    }

    Function function_;
    std::vector<uint64_t> top_;
};

struct Part {
    uint64_t error = 0, beyond = 0;
    uint32_t worst = ~0u, firstBeyond = ~0u;

    void take(const Trait& trait, uint32_t bits, const Exact& exact, uint32_t answer) {
        if (exact.isFinite() && exact.topExponent() < -126) return;  // a subnormal result may be flushed
        const uint64_t apart = distance(exact, answer);
        if (apart > error || worst == ~0u) error = apart, worst = bits;
        const uint64_t allowed = trait.allowed({bits, 0, 0, 0}, exact);
        if (allowed != kNoPromise && apart > allowed && beyond++ == 0) firstBeyond = bits;
    }
    void add(const Part& other) {
        if (other.error > error || (other.error == error && other.worst < worst)) error = other.error, worst = other.worst;
        beyond += other.beyond;
        firstBeyond = std::min(firstBeyond, other.firstBeyond);
    }
};

std::string hashOfAnswers(std::span<const uint32_t> answers, uint32_t threads) {
    std::vector<uint64_t> chunks(answers.size() / kChunk);
    const auto mix = [](uint64_t hash, uint64_t word) {
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        return hash ^ hash >> 29;
    };
    parallelBands(chunks.size(), 1, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t c = begin; c < end; ++c)
            for (uint32_t i = 0; i < kChunk; ++i) chunks[c] = mix(chunks[c], answers[c * kChunk + i]);
    });
    uint64_t hash = 0;
    for (const uint64_t chunk : chunks) hash = mix(hash, chunk);
    return fmt::format("{:016x}", hash);
}

// Outside of what the function has a value for, and at subnormal numbers, Vulkan promises nothing that could be judged here.
bool isJudged(Function function, uint32_t first) {
    const uint32_t field = first >> 23 & 255u;
    return field != 0 && field != 255 && (first >> 31 == 0 || function == kExp2 || function == kSin || function == kCos);
}

// Both signs of an exponent: answers[0] of the positive numbers, answers[1] of the others.
void judgeBlocks(Function function, const Reference& reference, uint32_t field, const std::array<std::span<const uint32_t>, 2>& answers,
                 uint32_t threads, Sweep& into) {
    const Trait& trait = traitNamed(kNames[function]);
    const std::array<uint32_t, 2> first = {field << 23, 0x80000000u | field << 23};
    std::array<Part, 2> all;
    std::mutex mutex;
    if (isJudged(function, first[0]))
        parallelBands(kBlock, kChunk, threads, [&](uint64_t begin, uint64_t end) {
            std::array<Part, 2> part;
            for (uint64_t i = begin; i < end; ++i) {
                const uint32_t bits = first[0] + uint32_t(i), other = first[1] + uint32_t(i);
                const Exact exact = reference.of(bits);
                part[0].take(trait, bits, exact, answers[0][i]);
                if (!isJudged(function, other)) continue;
                part[1].take(trait, other,
                             function == kExp2  ? reference.of(other)
                             : function == kSin ? negated(exact)
                                                : exact,
                             answers[1][i]);
            }
            const std::lock_guard lock(mutex);
            for (size_t s = 0; s < 2; ++s) all[s].add(part[s]);
        });
    for (size_t s = 0; s < 2; ++s) {
        SweepBlock block;
        block.first = first[s];
        block.error = all[s].error;
        block.worst = all[s].worst == ~0u ? first[s] : all[s].worst;
        block.worstAnswer = answers[s][block.worst - first[s]];
        block.hash = hashOfAnswers(answers[s], threads);
        if (all[s].beyond != 0 && into.beyond == 0) into.firstBeyond = all[s].firstBeyond;
        into.beyond += all[s].beyond;
        into.blocks.push_back(block);
    }
}

}  // namespace

std::vector<Sweep> sweep(Device& device, uint32_t threads, const std::function<void(double)>& onProgress, std::vector<uint32_t> fields) {
    std::vector<Sweep> sweeps;
    threads = threadCount(threads);
    if (fields.empty())
        for (uint32_t field = 0; field < 256; ++field) fields.push_back(field);
    std::optional<Recorder> recorder(std::in_place, device);
    Buffer<uint32_t> positive(device, kBlock, "answers of positive floats"), others(device, kBlock, "answers of negative floats");
    for (uint32_t f = 0; f < kFunctions; ++f) {
        const Function function = Function(f);
        Sweep& one = sweeps.emplace_back();
        one.trait = kNames[function];
        try {
            const Reference reference(function, threads);
            for (size_t at = 0; at < fields.size(); ++at) {
                for (const uint32_t sign : {0u, 1u})
                    recorder->dispatch(
                        "fingerprint", spirv::fingerprint_sweep, kBlock, gpu::FingerprintPush{0, kBlock, sign << 31 | fields[at] << 23},
                        {storage("Answers", sign == 0 ? positive : others)}, {{"kOperation", traitNamed(kNames[function]).operation}});
                recorder->run(kWatchdogMs);
                judgeBlocks(function, reference, fields[at], {positive.span(), others.span()}, threads, one);
                if (onProgress) onProgress((double(f) + double(at + 1) / double(fields.size())) / kFunctions);
            }
        } catch (const Error& error) {
            if (error.exit() != Exit::failed) throw;  // an interrupt
            one.failure = error.what();               // the function says so; the others stand
            recorder.emplace(device);
        }
    }
    return sweeps;
}

}  // namespace plumb::fingerprint
