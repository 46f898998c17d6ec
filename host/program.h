// SPDX-License-Identifier: MIT
// A compute program: an embedded SPIR-V module with its specialization constants. Bindings, strides,
// push-constant size and workgroup size are reflected from the words, so the host repeats nothing. Constants and
// bindings go by the names that the shader gives them: no number stands on both sides.
#pragma once

#include "host/module.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace plumb {

enum class BindingKind : uint32_t { storage, uniformTexel, uniformBuffer };
enum class TexelType : uint32_t { none, floating, unsignedInt, signedInt };

struct ReflectedBinding {
    uint32_t binding = 0;
    BindingKind kind = BindingKind::storage;
    uint32_t strideBytes = 0;  // stride of the runtime array's element; 0 for texel buffers
    TexelType texel = TexelType::none;
    std::string name;  // name of the texel buffer, or of the block
    bool readonly = false, writeonly = false;
};

struct Reflection {
    std::vector<ReflectedBinding> bindings;  // sorted by binding number; set 0 only
    uint32_t pushConstantBytes = 0;
    uint32_t localSize[3] = {1, 1, 1};        // default; a LocalSizeId is resolved against the constants given
    std::vector<uint32_t> specializationIds;  // sorted
    std::vector<std::string>
        // names of the constants in specializationIds; kLocalSizeX, Y, Z for local_size_x_id, ...; empty where the module has no names
        specializationNames;
};

// Values of a module's constants by constant_id, as Vulkan takes them.
using ConstantsById = std::map<uint32_t, uint32_t>;

// Reflection of a module's words. Throws Error(device) naming the module when they are not a compute module this reader understands.
Reflection reflect(const Module& module, const ConstantsById& constants = {});

// Values of a module's constants by their names in the shader: 32 bits each (bool 0/1, int, float bits). A pipeline is made only when every
// constant of its module is given, so that none keeps a default by mistake. kNativeDivide and kNativeRoot (shaders/shared/exact.h) may be
// left out. They default to the findings of the device's self-test.
using Specialization = std::map<std::string, uint32_t>;

}  // namespace plumb
