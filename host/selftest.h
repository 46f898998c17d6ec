// SPDX-License-Identifier: MIT
// The start-up self-test: which parts of docs/accuracy.md's exact subset this device keeps. There is no out-of-bounds canary:
// without robustBufferAccess reading out of bounds is undefined and may lose a real GPU; modules clamp instead.
#pragma once

#include "host/device.h"
#include "shared/selftest.h"

#include <span>
#include <string>
#include <vector>

namespace plumb {

// Runs the canaries always, and the full vectors unless $XDG_CACHE_HOME/plumbline (else ~/.cache/plumbline) holds their verdict for this
// device, driver and module. A cache that is missing, corrupt or unwritable costs time only; a verdict that refuses the device is not
// stored. `mayCache` false: the full vectors run whatever is stored. Throws Error when the device cannot run a dispatch at all.
SelfTest runSelfTest(Device& device, bool mayCache = true);

// Operands of the self-test, kSelfTestVectors of them: significands at and around the ends, the others random; the same on every machine.
std::vector<gpu::SelfTestVector> selfTestVectors();

// Verdict on the device's answers. Zeros compare equal whatever their sign: the subset does not use the sign of zero.
SelfTest judgeSelfTest(std::span<const gpu::SelfTestVector> vectors, std::span<const gpu::SelfTestAnswer> answers);

// Text of the cache file, and its reading: false unless `text` is a whole, unaltered verdict for `key`.
std::string selfTestCacheText(const SelfTest& verdict, const std::string& key);
bool readSelfTestCache(const std::string& text, const std::string& key, SelfTest& verdict);

}  // namespace plumb
