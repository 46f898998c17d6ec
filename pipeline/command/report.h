// SPDX-License-Identifier: MIT
// Common parts of reports. Keys are stable; docs/outputs.md lists them.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/library/renderer.h"
#include "pipeline/scene/load.h"

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

struct SourceFile {
    std::string path, sha256;
    uint64_t bytes = 0;
};

// Facts from the pixels of a picture.
struct FrameFacts {
    uint64_t pixels = 0, covered = 0, distinctColours = 0, nan = 0, inf = 0;
    std::string firstFault;  // first NaN or infinity: plane, pixel, value
    double coveredShare() const { return pixels == 0 ? 0 : double(covered) / double(pixels); }
};

std::vector<SourceFile> sourcesOf(const std::vector<std::string>& paths, const LoadOptions&);
FrameFacts factsOf(const Frame&, bool countColours);  // uncounted, distinctColours is 0
// True when nearly nothing is covered, or the picture has one colour only.
bool isBlank(const FrameFacts&, double leastShare);

// Warning about a picture without a covered pixel, with the reason where the counts tell it.
std::string nothingSeen(const RenderCounters&);

Json hostJson();
Json sceneJson(const Scene&, const std::vector<SourceFile>&);
Json planJson(const Plan&);
// Defaults that the scene asks to be more accurate, with their bounds, and what no form keeps.
Json accuracyJson(const Plan&);
Json countersJson(const RenderCounters&);
Json cameraJson(const Camera&);
Json imageJson(const Frame&, const FrameFacts&, bool blank);
Json memoryJson(const Renderer&);
Json deviceJson(const Renderer&);

}  // namespace plumb
