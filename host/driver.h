// SPDX-License-Identifier: MIT
// What those need who ask a driver about itself, and those who plant a fault in one.
#pragma once

#include "host/device.h"

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace plumb {

// True when ballot, vote, shuffle and arithmetic of a subgroup are usable in compute, whatever its size.
bool hasSubgroupOperations(const Device& device);

// Changes the words of every module that the device loads from now on, behind the folding of constants. A test plants a faulty driver so;
// pipelines that are made already stay.
using ModuleRewriter = std::function<void(std::string_view module, std::vector<uint32_t>& words)>;
void plantDriver(Device& device, ModuleRewriter rewriter);

}  // namespace plumb
