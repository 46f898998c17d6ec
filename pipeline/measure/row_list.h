// SPDX-License-Identifier: MIT
// Rows of a measurement, before anything is drawn.
#pragma once

#include "pipeline/measure/measure.h"
#include "pipeline/render/technique.h"

namespace plumb {

// Lists the rows of every choice, those of the control axis first, and the runs that they need. A row that cannot be drawn, or has no truth,
// says why.
void listRuns(Measurement& m, const MeasurePlan& plan);

// Sampling of a picture's own samples; only rays may lie elsewhere than in a grid.
inline Sampling samplingOf(const RenderRequest& request) { return isTraced(request) ? request.rays.sampling : Sampling::grid; }

}  // namespace plumb
