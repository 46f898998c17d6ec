// SPDX-License-Identifier: MIT
// The command with a renderer that fails as PLUMB_FAULT says, so that the paths after a failure are walked by the real program:
// lost-once, lost (the device throws), nan (a NaN in a drawn pixel), differs (verify finds a difference).
#include "host/error.h"
#include "pipeline/render/evidence.h"
#include "pipeline/render/render.h"

#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

namespace plumb {
namespace {

std::string fault() {
    const char* value = std::getenv("PLUMB_FAULT");
    return value ? value : "";
}

int deviceCalls = 0;

}  // namespace

RenderResult renderGpu(Device&, const Scene& scene, const RenderRequest& request) {
    ++deviceCalls;
    if (fault() == "lost" || (fault() == "lost-once" && deviceCalls == 1)) throw renderError("VK_ERROR_DEVICE_LOST (planted)");
    RenderResult result = renderCpu(scene, request);
    if (fault() == "nan" && !result.frame.linear.empty()) result.frame.linear[3 * 100] = std::numeric_limits<float>::quiet_NaN();
    return result;
}

VerifyReport verifyRender(Device&, const Scene& scene, const RenderRequest& request) {
    VerifyReport report;
    report.twin = report.device = renderCpu(scene, request);
    report.equal = fault() != "differs";
    report.passes = {{"fill", report.equal}};
    report.planes = {{"colour", "aa", report.equal ? "aa" : "bb", report.equal ? 0u : 1u}};
    if (!report.equal) {
        report.device.frame.rgba[0] ^= 1;
        report.mismatches = {{"fill", true, "tile (0, 0), pixel (0, 0): twin has 0, device has 1 (planted)"}};
    }
    return report;
}

VerifyReport verifyRender(Device& device, const Scene& scene, const RenderRequest& request, std::vector<VerifyEvidence>&) {
    return verifyRender(device, scene, request);
}

}  // namespace plumb
