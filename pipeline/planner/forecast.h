// SPDX-License-Identifier: MIT
// Forecast of a traced picture: how many rays it follows and how long that takes, before it starts.
#pragma once

#include "pipeline/planner/planner.h"

#include <optional>
#include <string>
#include <vector>

namespace plumb {

struct RayForecast {
    PlannedPicture picture;  // as it is asked for, with its predicted rays and time
    double rays = 0;
    // A cutoff that follows fewer rays.
    struct Less {
        float minWeight = 0;
        double share = 1;             // of the rays that are left
        std::optional<double> steps;  // largest change of a pixel of the probe that is proved, in steps of 1/255; none: no proof
        std::string why;              // no proof
    };
    std::optional<Less> less;  // none: no cutoff leaves fewer
};

// Rays of `request.base` from a probe of about a million of them at most. Without unit costs of the device, the time is that of the twin on all
// processors.
RayForecast forecastRays(const Scene& scene, const PlannerRequest& request);

// Most rays that a picture can follow, whatever it shows; infinite where that is beyond all numbers. Costs nothing.
double mostRaysOf(const Scene& scene, const RenderRequest& request);

// Processor milliseconds of the twin for a traced picture, by a pilot of some hundred pixels. It takes a thousandth of that.
double pilotMs(const Scene& scene, const RenderRequest& request);

// "about 1.4e9 rays, about 7 min; --min-weight 1/256 leaves 0.4 % of them, at most 0.9 steps".
std::string sentenceOf(const RayForecast& forecast);

}  // namespace plumb
