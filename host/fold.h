// SPDX-License-Identifier: MIT
// Folds a module's specialization constants before the driver reads it. A branch on a constant keeps only the side that is taken; functions
// and names that nothing uses any more are left out. Without this lavapipe's front end translates, inlines and unrolls the other side first
// and drops it then.
#pragma once

#include "host/program.h"

#include <cstdint>
#include <vector>

namespace plumb {

// Folded module: it does what `module` does where its constants have the values of `constants` or their defaults. Remaining instructions
// are unchanged but for branches and phis; decorations stay; names are left out. Constant ids are those of `module`. Throws Error(device)
// naming the module where the words are not SPIR-V.
std::vector<uint32_t> foldConstants(const Module& module, const ConstantsById& constants);

}  // namespace plumb
