// SPDX-License-Identifier: MIT
// A compute program: an embedded SPIR-V module with its specialization constants. Bindings, strides,
// push-constant size and workgroup size are reflected from the words, so the host repeats nothing.
#pragma once

#include "host/module.h"

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

namespace plumb {

enum class BindingKind : uint32_t { storage, uniformTexel, uniformBuffer };
enum class TexelType : uint32_t { none, floating, unsignedInt, signedInt };

struct ReflectedBinding {
    uint32_t binding = 0;
    BindingKind kind = BindingKind::storage;
    uint32_t strideBytes = 0;          // of the runtime array's element; 0 for texel buffers
    TexelType texel = TexelType::none;
    std::string name;
    bool readonly = false, writeonly = false;
};

struct Reflection {
    std::vector<ReflectedBinding> bindings;  // sorted by binding number; set 0 only
    uint32_t pushConstantBytes = 0;
    uint32_t localSize[3] = {1, 1, 1};       // default; a LocalSizeId is resolved against the constants given
    std::vector<uint32_t> specializationIds; // sorted
    std::vector<std::string> specializationNames; // of the same constants; empty where the module has no names
};

// Throws Error(device) naming the module when the words are not a compute module this reader understands.
Reflection reflect(const Module& module, const std::map<uint32_t, uint32_t>& constants = {});

// constant_id -> 32-bit value (bool 0/1, int, float bits). kNativeDivide and kNativeRoot of shaders/shared/exact.h are
// set from the self-test by the recorder wherever a module has them and the caller does not give them.
using Specialization = std::map<uint32_t, uint32_t>;

}  // namespace plumb
