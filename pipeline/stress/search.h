// SPDX-License-Identifier: MIT
// Sweep of one axis in one arithmetic: powers of two outward, then bisection.
#pragma once

#include "pipeline/stress/evaluate.h"
#include "pipeline/stress/stress.h"

#include <functional>
#include <optional>

namespace plumb::stress {

// Margin of an axis. `onStep`: called before each picture with the share of the sweep that is done; may throw.
Margin sweep(Evaluator& evaluator, const Picture& picture, const AxisRow& axis, bool float32, const std::function<void(double)>& onStep);

}  // namespace plumb::stress
