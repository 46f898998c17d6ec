// SPDX-License-Identifier: MIT
// What verify keeps of the values that differ, for whoever wants to find the dispatch that left them.
#pragma once

#include "pipeline/render/render.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Both sides' values of a comparison that failed, as bytes: of a pass, or of a plane.
struct VerifyEvidence {
    std::string pass, element;  // element: name of one value
    uint32_t elementBytes = 0;
    std::vector<std::byte> twin, device;  // of the same length
};

// verifyRender(), which also appends evidence in the order of mismatches. A mismatch in size or in counts has none.
VerifyReport verifyRender(Device&, const Scene&, const RenderRequest&, std::vector<VerifyEvidence>& evidence);

}  // namespace plumb
