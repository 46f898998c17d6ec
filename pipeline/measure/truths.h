// SPDX-License-Identifier: MIT
// Truths of one scene, each made when it is first asked for, and only while there is time.
#pragma once

#include "pipeline/measure/axes.h"
#include "pipeline/truth/truth.h"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace plumb {

class Truths {
public:
    // `base`: request of the default picture. `elapsedMs`: time that the limit counts. `alive`: called now and then while a truth is made; may
    // throw. Scene and base must outlive it.
    Truths(const Scene& scene, const RenderRequest& base, std::function<double()> elapsedMs, std::function<void()> alive)
        : scene_(scene), base_(base), elapsedMs_(std::move(elapsedMs)), alive_(std::move(alive)) {}

    // Truth of `samples` a pixel; null when it would not be there at `untilMs`. The notes' fill samples whole coordinates, and so does the truth
    // that it is held against: those of a picture of `drawn` samples.
    const Truth* at(uint32_t samples, Fill fill, uint32_t drawn, Sampling sampling, double untilMs);
    // True when the truth at a picture's own samples has been asked for.
    bool has(const RenderRequest& request) const;
    // The most that a truth took for each of its samples a pixel; 0 before the first.
    double msPerSample() const { return msPerSample_; }

private:
    const Scene& scene_;
    const RenderRequest& base_;
    std::function<double()> elapsedMs_;
    std::function<void()> alive_;
    // By samples, fill, samples drawn, sampling; none: there was no time for it.
    std::map<std::tuple<uint32_t, Fill, uint32_t, Sampling>, std::optional<Truth>> truths_;
    double msPerSample_ = 0;
};

}  // namespace plumb
