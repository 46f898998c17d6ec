// SPDX-License-Identifier: MIT
// What a module's specialization constants decide, decided before the driver reads it: a branch on a constant keeps the side that is taken, and
// what nobody calls or names any more is left out. lavapipe's front end translates, inlines and unrolls the other side first and drops it then.
#pragma once

#include "host/program.h"

#include <cstdint>
#include <vector>

namespace plumb {

// A module that does what `module` does where its constants have the values of `constants` or their defaults. No instruction that stays is
// changed but branches and phis; decorations stay with what they decorate; names are left out. Constant ids are those of `module`.
// Throws Error(device) naming the module where the words are not SPIR-V.
std::vector<uint32_t> foldConstants(const Module& module, const ConstantsById& constants);

}  // namespace plumb
