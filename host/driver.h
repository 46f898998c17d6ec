// SPDX-License-Identifier: MIT
// What those need who ask a driver about itself, and those who plant a fault in one.
#pragma once

#include "host/device.h"
#include "host/program.h"

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// True when ballot, vote, shuffle and arithmetic of a subgroup are usable in compute, whatever its size.
bool hasSubgroupOperations(const Device& device);

// Changes the words of every module that the device loads, behind the folding of constants. A test plants a faulty driver so; a pipeline that
// is made already is made anew where its words change, and stays otherwise. The rewriter is called for each of these, and gives the same words
// each time.
using ModuleRewriter = std::function<void(std::string_view module, std::vector<uint32_t>& words)>;
void plantDriver(Device& device, ModuleRewriter rewriter);
// Makes the device load these words in place of every module of that name, before constants are folded.
void plantModules(Device& device, std::map<std::string, std::vector<uint32_t>, std::less<>> words);

// Shrinks limits of an open device, as PLUMB_LIMITS (Device::open) does, but for the memory. Throws Error(device) as that does.
void shrink(Device& device, const char* limits);
// Names of the modules that the device has run since it was opened, its self-test included.
const std::set<std::string, std::less<>>& modulesRun(const Device& device);

}  // namespace plumb
