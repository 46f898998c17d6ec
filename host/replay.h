// SPDX-License-Identifier: MIT
// Dispatches as bytes: seen while a picture is drawn, and run again from those bytes alone.
#pragma once

#include "host/recorder.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace plumb {

// One dispatch as the driver got it. Bindings are those of the module but its Status, by rising number from 1.
struct DispatchRecord {
    struct Bound {
        std::string name;  // as the shader calls it; words keep no names
        View view = View::storage;
        uint32_t elementBytes = 0;             // storage: stride of its array; texels: 0
        std::vector<std::byte> before, after;  // of the bound range; after is empty before the dispatch ran
    };
    std::string label, module;
    std::vector<uint32_t> words;  // SPIR-V, constants folded
    ConstantsById constants;
    uint64_t items = 0;          // invocations along x
    std::vector<uint32_t> push;  // the first word is the status slot
    std::vector<Bound> bindings;
    std::string failure;  // what the recorder said; empty: it ended
};

// Called after each dispatch of every recorder of the device, which then runs one by one. Empty: nobody is called.
using DispatchWitness = std::function<void(const DispatchRecord&)>;
void witnessDispatches(Device& device, DispatchWitness witness);

// Runs a record's words on its input. Returns it with what this device leaves, or with the failure. Throws Error(failed) for a record that
// does not fit its own words, or the device.
DispatchRecord replay(Device& device, const DispatchRecord& record, double watchdogMs);

}  // namespace plumb
