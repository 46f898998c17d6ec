// SPDX-License-Identifier: MIT
// Asks a device: one dispatch a trait, answers read from mapped memory. A trait that fails says why; the others are asked all the same.
#include "host/buffer.h"
#include "host/driver.h"
#include "host/recorder.h"
#include "pipeline/fingerprint/execution.h"
#include "pipeline/fingerprint/fingerprint.h"
#include "shared/fingerprint.h"

#include <fmt/core.h>
#include <spirv/fingerprint.h>
#include <spirv/fingerprint_loose.h>
#include <spirv/fingerprint_run.h>
#include <spirv/fingerprint_subgroup.h>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr double kWatchdogMs = 60000;
constexpr uint32_t kLargestAnswers = 1u << 20;

class Asker {
public:
    Asker(Device& device, uint32_t samples)
        : device_(device),
          asked_(allQuestions(samples)),
          questions_(device, std::max(samples, 65536u), "questions"),
          answers_(device, kLargestAnswers, "answers") {}

    Answers ask(size_t trait) {
        Answers answers;
        try {
            answers.words = answersTo(traits()[trait], asked_[trait]);
        } catch (const Error& error) {  // the trait says so; the others stand
            answers.failure = error.what();
            answers.words.clear();
            recorder_.reset();
        }
        return answers;
    }

private:
    std::vector<uint32_t> answersTo(const Trait& trait, const Questions& asked) {
        switch (trait.kernel) {
            case Kernel::values:
                return values(spirv::fingerprint, trait, asked);
            case Kernel::loose:
                return values(spirv::fingerprint_loose, trait, asked);
            case Kernel::run:
                return trait.operation == gpu::kRunIndices   ? indices(asked)
                       : trait.operation == gpu::kRunAtomics ? atomics()
                                                             : runs(trait, asked);
            case Kernel::subgroup:
                return subgroups(trait);
            case Kernel::repeats:
                break;
        }
        if (repeats_.size() != trait.items) throw renderError("a trait before this one failed, so it could not be asked again");
        return repeats_;
    }

    Recorder& recorder() { return recorder_ ? *recorder_ : recorder_.emplace(device_); }

    std::vector<uint32_t> answersNow(size_t count) const {
        const std::span<const uint32_t> words = answers_.span();
        return {words.begin(), words.begin() + long(count)};
    }

    void upload(const Questions& asked) {
        const size_t count = std::min<size_t>(asked.questions.size(), questions_.count());
        for (size_t i = 0; i < count; ++i) {
            const Question& q = asked.questions[i];
            questions_.span()[i] = {q[0], q[1], q[2], q[3]};
        }
    }

    void dispatch(const Module& module, uint32_t operation, uint64_t invocations, uint32_t items, uint32_t base,
                  const Buffer<uint32_t>& answers) {
        recorder().dispatch("fingerprint", module, invocations, gpu::FingerprintPush{0, items, base},
                            {storage("Questions", questions_), storage("Answers", answers)}, {{"kOperation", operation}});
        recorder().run(kWatchdogMs);
    }

    std::vector<uint32_t> values(const Module& module, const Trait& trait, const Questions& asked) {
        const uint32_t items = uint32_t(asked.questions.size());
        upload(asked);
        answers_.fill(0);
        dispatch(module, trait.operation, items, items, 0, answers_);
        std::vector<uint32_t> first = answersNow(items);
        // Once more, over the answers that are there: what depends on memory that nobody wrote shows.
        dispatch(module, trait.operation, items, items, 0, answers_);
        uint32_t apart = 0;
        for (size_t i = 0; i < items; ++i) apart += answers_.span()[i] != first[i] ? 1 : 0;
        repeats_.push_back(apart);
        return first;
    }

    std::vector<uint32_t> runs(const Trait& trait, const Questions& asked) {
        const uint32_t items = uint32_t(asked.questions.size());
        const uint64_t invocations = trait.operation == gpu::kRunLoops ? uint64_t(items) * gpu::kRunLanes : items;
        upload(asked);
        answers_.fill(0);
        dispatch(spirv::fingerprint_run, trait.operation, invocations, items, 0, answers_);
        return answersNow(items);
    }

    std::vector<uint32_t> indices(const Questions& asked) {
        const uint32_t items = uint32_t(asked.questions.size());
        if (device_.limits().storageRangeBytes < uint64_t(kIndexWords) * 4)
            throw renderError(fmt::format("the device allows {} bytes of a storage buffer, and this needs {}",
                                          device_.limits().storageRangeBytes, uint64_t(kIndexWords) * 4));
        Buffer<uint32_t> words(device_, kIndexWords, "words of large indices");
        for (const Question& q : asked.questions) {
            words.span()[q[0]] = q[1] == 0 ? 0 : indexWord(q[0]);
            if (q[1] != 0) words.span()[q[2]] = 0;
        }
        upload(asked);
        dispatch(spirv::fingerprint_run, gpu::kRunIndices, uint64_t(items) * gpu::kRunLanes, items, 0, words);
        std::vector<uint32_t> got;
        for (const Question& q : asked.questions) got.push_back(words.span()[q[1] == 0 ? q[0] : q[2]]);
        return got;
    }

    std::vector<uint32_t> atomics() {
        for (uint32_t i = 0; i < kAtomicOperands; ++i) questions_.span()[i] = {atomicOperand(i), 0, 0, 0};
        std::copy(kAtomicStart.begin(), kAtomicStart.end(), answers_.span().begin());
        dispatch(spirv::fingerprint_run, gpu::kRunAtomics, kAtomicOperands, kAtomicOperands, kAtomicOperands, answers_);
        return answersNow(kAtomicWords);
    }

    std::vector<uint32_t> subgroups(const Trait& trait) {
        if (!hasSubgroupOperations(device_))
            throw renderError("the device has no shuffle, ballot, vote and arithmetic of subgroups in compute");
        answers_.fill(0);
        recorder().dispatch("fingerprint", spirv::fingerprint_subgroup, kSubgroupItems, gpu::FingerprintPush{0, kSubgroupItems, 0},
                            {storage("Answers", answers_)}, {{"kOperation", trait.operation}});
        recorder().run(kWatchdogMs);
        return answersNow(kSubgroupItems);
    }

    Device& device_;
    const std::vector<Questions>& asked_;
    std::optional<Recorder> recorder_;  // made anew after a failure
    Buffer<glm::uvec4> questions_;
    Buffer<uint32_t> answers_;
    std::vector<uint32_t> repeats_;  // words that differed, one number a trait that was asked twice
};

}  // namespace

Fingerprint ask(Device& device, uint32_t samples, const std::function<void(double)>& onProgress) {
    const auto start = std::chrono::steady_clock::now();
    Fingerprint fingerprint;
    fingerprint.device = device.info();
    fingerprint.samples = samples;
    Asker asker(device, samples);
    const size_t count = traits().size();
    for (size_t trait = 0; trait < count; ++trait) {
        fingerprint.answers.push_back(asker.ask(trait));
        if (onProgress) onProgress(double(trait + 1) / double(count));
    }
    fingerprint.timeMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return fingerprint;
}

}  // namespace plumb::fingerprint
