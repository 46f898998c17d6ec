// SPDX-License-Identifier: MIT
// The start-up self-test: what of docs/accuracy.md's exact subset this device keeps.
#pragma once

#include "host/device.h"

#include <cstdint>
#include <span>
#include <string>

namespace plumb {

// Canaries always; the full vectors unless $XDG_CACHE_HOME/plumbline (else ~/.cache/plumbline) holds their verdict for
// this device, driver and module. Throws Error when the device cannot run a dispatch at all.
SelfTest runSelfTest(Device& device);

}  // namespace plumb
