// SPDX-License-Identifier: MIT
// A measurement as JSON, CSV, a table for people and one HTML file (docs/measure.md).
#pragma once

#include "pipeline/command/report.h"
#include "pipeline/library/renderer.h"
#include "pipeline/measure/measure.h"

#include <array>
#include <string>
#include <vector>

namespace plumb {

// Mean numbers of waiting processes over 1, 5 and 15 minutes; -1: not known.
using LoadAverages = std::array<double, 3>;
LoadAverages loadAverages();  // now

// What a reader must know before the figures are believed.
std::vector<std::string> notesOf(const Measurement& m, const MeasurePlan& plan, const LoadAverages& loadBefore,
                                 const LoadAverages& loadAfter);
Json contextJson(const Renderer& renderer, const Scene& scene, const std::vector<SourceFile>& sources, const MeasurePlan& plan,
                 const Measurement& m, const LoadAverages& loadBefore, const LoadAverages& loadAfter);
Json measurementJson(const Measurement& m, Json context, const std::vector<std::string>& notes);
// CSV with the figures of the JSON's rows. Errors are shares of full scale.
std::string csvOf(const Measurement& m);
// "0.943 .. 0.961", or that there were too few rounds.
std::string intervalText(const RatioInterval& ratio);
std::string tableOf(const Measurement& m, const std::string& title, const LoadAverages& load, const std::vector<std::string>& notes);
// Report of `json` with the pictures of the measurement. It must have its truth.
std::string htmlOf(const Measurement& m, const Json& json);

}  // namespace plumb
