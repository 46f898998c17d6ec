// SPDX-License-Identifier: MIT
// Fingerprint of a device: its answers to the questions of traits.h, and what they say. `plumb devices --fingerprint` prints it.
#pragma once

#include "host/device.h"
#include "pipeline/fingerprint/traits.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace plumb::fingerprint {

enum class Verdict : uint8_t { within, beyond, open, failed };  // open: Vulkan promises nothing

struct Decade {
    int power = 0;  // |x| in [10^power, 10^(power + 1))
    uint64_t error = 0, allowed = kNoPromise;
    uint32_t item = 0;  // first that reaches the error
};

// What the answers to one trait say.
struct Finding {
    Verdict verdict = Verdict::within;
    std::string text;               // "correctly rounded", "flushed to zero", ...
    uint64_t differing = 0;         // answers that are not the expected one
    uint64_t error = 0;             // largest, in 1/65536 ULP; 0 for a trait that is not in ULP
    uint32_t worst = 0;             // first item that reaches it, or the first that differs
    uint64_t allowed = kNoPromise;  // at that item
    uint64_t beyond = 0;            // answers that Vulkan does not allow
    uint32_t firstBeyond = 0;
    std::vector<Decade> decades;
};

struct Answers {
    std::vector<uint32_t> words;
    std::string failure;  // what the device said instead; empty: it answered
};

// Every float32 of one function, in blocks of a sign and an exponent.
struct SweepBlock {
    uint32_t first = 0;  // bits of the first float
    uint64_t error = 0;
    uint32_t worst = 0, worstAnswer = 0;
    std::string hash;  // of the answers
};
struct Sweep {
    std::string trait;
    std::string failure;
    uint64_t beyond = 0;  // answers that Vulkan does not allow
    uint32_t firstBeyond = 0;
    std::vector<SweepBlock> blocks;
};

struct Fingerprint {
    DeviceInfo device;
    uint32_t samples = kSamples;
    std::vector<Answers> answers;  // in the order of traits()
    std::vector<Sweep> sweeps;     // of --all-floats; else empty
    double timeMs = 0;
};

// Asks every trait. `onProgress` gets shares from 0 to 1, and may throw.
Fingerprint ask(Device&, uint32_t samples = kSamples, const std::function<void(double)>& onProgress = {});
// Asks for every float of sqrt, inversesqrt, exp2, log2, sin and cos. `fields`: exponent fields (0 to 255) to ask for; none: all.
std::vector<Sweep> sweep(Device&, uint32_t threads, const std::function<void(double)>& onProgress = {}, std::vector<uint32_t> fields = {});

Finding findingOf(const Trait&, const Questions&, const Answers&);
// Error of one answer and what is allowed there, in 1/65536 ULP; a trait that is not in ULP has errors of 0 and kUlp, and allows 0 or any.
struct Judged {
    uint64_t error = 0, allowed = kNoPromise;
    bool isAllowed() const { return allowed == kNoPromise || error <= allowed; }
};
Judged judge(const Trait&, const Question&, uint32_t answer);

// SHA-256 over the version, every trait's name and its answers or failure, and the sweeps.
std::string hashOf(const Fingerprint&);
std::string hashOf(const Trait&, const Answers&);

int decadeOf(uint32_t bits);  // of a normal number

}  // namespace plumb::fingerprint
