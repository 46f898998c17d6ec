// SPDX-License-Identifier: MIT
// One picture of a sweep: drawn, held against its truth, judged.
#pragma once

#include "pipeline/stress/stress.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>

namespace plumb::stress {

// Draws and judges pictures of one scene. Remembers each, since the arithmetics share pictures that need nothing beyond float32.
class Evaluator {
public:
    Evaluator(const Picture& picture, const StressPlan& plan);

    // The scene as it is. `float32`: no object is transformed in more, here and below.
    const Tried& itself(bool float32);
    // The scene with a value of an axis.
    const Tried& at(const AxisRow& axis, double value, bool float32);
    bool late() const;
    double elapsedMs() const;
    uint64_t pictures() const { return pictures_; }

private:
    Tried judge(const Picture& moved);

    const Picture& picture_;
    const StressPlan& plan_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::map<std::tuple<const AxisRow*, double, bool>, Tried> known_;
    std::optional<Tried> itself_[2];
    uint64_t pictures_ = 0;
};

}  // namespace plumb::stress
