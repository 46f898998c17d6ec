// SPDX-License-Identifier: MIT
// The two ways of `plumb devices` that are about numbers.
#pragma once

#include "pipeline/command/command.h"

namespace plumb {

Exit fingerprintCommand(const Options&);          // --fingerprint
Exit compareFingerprintsCommand(const Options&);  // --compare

}  // namespace plumb
