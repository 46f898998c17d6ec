// SPDX-License-Identifier: MIT
// Calibration: what a unit of work costs on one device, measured once and kept in a file.
#pragma once

#include "pipeline/planner/work.h"

#include <functional>
#include <string>

namespace plumb {

struct Calibration {
    UnitCosts costs = nominalCosts();
    double twinRay = 0;  // processor nanoseconds of the twin for a ray of the same scene; 0: not measured
    bool fromCache = false;
    bool steady = true;  // false: times of one picture differ so much that another process ran beside it; then it is not kept
    double ms = 0;       // time that it took
};

// Calibration of what `draw` draws with. `key`: device, driver and version in one line; a file that was made for another key, is not whole or
// holds anything but positive numbers is measured anew and replaced. Pictures of a ball are drawn in turns for at most about a second,
// after each was drawn once. What was measured beside other work is not kept.
Calibration calibrationOf(const std::string& key, const std::function<RenderResult(const Scene&, const RenderRequest&)>& draw);

// Calibration of an earlier call with that key. False: there is none, and nothing is measured.
bool keptCalibration(const std::string& key, Calibration& calibration);

// Text of the file, and whether a text is that of `key`; then `calibration` is it.
std::string calibrationText(const Calibration& calibration, const std::string& key);
bool readCalibration(const std::string& text, const std::string& key, Calibration& calibration);

}  // namespace plumb
