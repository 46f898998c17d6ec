// SPDX-License-Identifier: MIT
#include "host/replay.h"

#include "host/error.h"
#include "host/vulkan.h"

#include <fmt/format.h>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

void witnessDispatches(Device& device, DispatchWitness witness) { device.impl().witness = std::move(witness); }

namespace {

// A push block of N words. Recorders take a struct, so that its size is known where it is written; a record knows it when it is read.
template <size_t N>
struct Words {
    uint32_t word[N];
};
using Run = void (*)(Recorder&, const DispatchRecord&, const Module&, const std::vector<Binding>&, const Specialization&);
template <size_t N>
void runWith(Recorder& recorder, const DispatchRecord& record, const Module& module, const std::vector<Binding>& bindings,
             const Specialization& constants) {
    Words<N> push;
    std::memcpy(&push, record.push.data(), sizeof push);
    recorder.dispatch(record.label.c_str(), module, record.items, push, bindings, constants);
}
template <size_t... N>
constexpr std::array<Run, sizeof...(N)> runsOf(std::index_sequence<N...>) {
    return {runWith<N + 1>...};
}
std::string named(const std::string& name, const std::string& otherwise) { return name.empty() ? otherwise : name; }
constexpr auto kRuns = runsOf(std::make_index_sequence<64>());  // by the words of the push block, from 1

}  // namespace

DispatchRecord replay(Device& device, const DispatchRecord& record, double watchdogMs) {
    const Module module{record.module, record.words, ""};
    const Reflection reflection = reflect(module, record.constants);
    if (reflection.bindings.size() != record.bindings.size() + 1)
        throw renderError(fmt::format("{}: its words have {} bindings, and {} are kept", record.module, reflection.bindings.size(),
                                      record.bindings.size() + 1));
    if (record.push.empty() || record.push.size() > kRuns.size())
        throw renderError(fmt::format("{}: a push block of {} words, 1 to {} are taken", record.module, record.push.size(), kRuns.size()));
    Specialization constants;
    for (size_t i = 0; i < reflection.specializationIds.size(); ++i) {
        const auto value = record.constants.find(reflection.specializationIds[i]);
        if (value == record.constants.end())
            throw renderError(fmt::format("{}: constant {} has no value", record.module, reflection.specializationIds[i]));
        constants[named(reflection.specializationNames[i], unnamedConstant(value->first))] = value->second;
    }
    DispatchRecord result = record;
    result.failure.clear();
    std::vector<RawBuffer> buffers;
    std::vector<std::string> names;
    std::vector<Binding> bindings;
    for (const DispatchRecord::Bound& bound : record.bindings) {
        buffers.emplace_back(device, bound.before.size(), "replayed");
        if (!bound.before.empty()) std::memcpy(buffers.back().data(), bound.before.data(), bound.before.size());
    }
    for (size_t i = 1; i < reflection.bindings.size(); ++i)
        names.push_back(named(reflection.bindings[i].name, unnamedBinding(reflection.bindings[i].binding)));
    for (size_t i = 0; i < buffers.size(); ++i)
        bindings.push_back(
            {names[i].c_str(), &buffers[i], record.bindings[i].view, record.bindings[i].elementBytes, 0, record.bindings[i].before.size()});
    Recorder recorder(device);
    try {
        kRuns[record.push.size() - 1](recorder, record, module, bindings, constants);
        recorder.run(watchdogMs);
    } catch (const Error& error) {
        if (error.exit() != Exit::failed) throw;
        result.failure = error.what();
    }
    for (size_t i = 0; i < buffers.size(); ++i) {
        const auto* first = static_cast<const std::byte*>(buffers[i].data());
        result.bindings[i].after.assign(first, first + record.bindings[i].before.size());
    }
    return result;
}

}  // namespace plumb
