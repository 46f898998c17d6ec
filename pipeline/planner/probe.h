// SPDX-License-Identifier: MIT
// Probe: the scene at a fraction of its size, drawn by the twin, for what a choice costs and how wrong it is before the picture is drawn.
#pragma once

#include "pipeline/planner/candidates.h"
#include "pipeline/planner/check.h"
#include "pipeline/planner/work.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

// A figure with what it may be in the whole picture, from its pixels in the probe.
struct Estimate {
    BudgetFigures low, middle, high;
};

struct Probed {
    Work work;                                    // of the whole picture
    std::optional<Estimate> error;                // none: no error was asked for
    std::vector<RenderCounters::RayCounts> rays;  // of the whole picture, by depth; empty for a raster picture
};

class Probe {
public:
    // Scene must outlive it. At most `pixels` pixels. `factor`: by which errors are multiplied; 1 but for tests.
    // `progress`: called now and then; false cancels with Error(interrupted).
    Probe(const Scene& scene, const RenderRequest& base, uint64_t pixels, double factor = 1, std::function<bool()> progress = {});

    // Every n-th pixel of every n-th row; 1: the whole picture.
    uint32_t shrink() const { return shrink_; }
    const Scene& scene() const { return shrink_ == 1 ? scene_ : small_; }
    RenderRequest smaller(const RenderRequest& request) const;
    // Drawn once for each candidate. With `error`, held against the truth of `truthSamples` a pixel (0: the candidate's own).
    const Probed& of(const Candidate& candidate, bool error, uint32_t truthSamples = 0);
    // Counts of one picture of the probe's size.
    Counted counted(const Candidate& candidate) const;
    // Milliseconds that the truth of the whole picture takes, from that of the probe; 0 before any was made.
    double truthMs() const { return truthMs_ * double(shrink_) * shrink_; }
    // Processor milliseconds of the twin for each ray of the probes; 0 before any was traced.
    double msPerRay() const { return rays_ > 0 ? rayMs_ / rays_ : 0; }
    size_t drawn() const { return known_.size(); }

private:
    const Checker& checkerOf(const RenderRequest& request);
    Estimate estimateOf(const FrameError& error) const;

    Scene small_;
    const Scene& scene_;
    uint32_t shrink_ = 1, width_, height_;
    double factor_;
    std::function<bool()> progress_;
    std::map<uint32_t, std::unique_ptr<Checker>> checkers_;  // by samples
    std::map<std::string, Probed> known_;
    double truthMs_ = 0, rayMs_ = 0, rays_ = 0;
};

}  // namespace plumb
