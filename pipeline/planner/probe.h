// SPDX-License-Identifier: MIT
// Probe: the scene at a fraction of its size, drawn by the twin, for what a choice costs and how wrong it is before the picture is drawn.
#pragma once

#include "pipeline/planner/candidates.h"
#include "pipeline/planner/check.h"
#include "pipeline/planner/work.h"
#include "pipeline/render/bounds/bound.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// A figure with what it may be in the whole picture, from its pixels in the probe.
struct Estimate {
    BudgetFigures low, middle, high;
};

// What the errors of a choice are proved not to exceed at the pixels of the probe, in steps; +infinity: no bound below full scale.
struct ProvedErrors {
    bool proved = false;
    double max = 0, p99 = 0, rms = 0;  // max: over the pixels that BudgetFigures::max is taken over
    std::string why;                   // not proved: one sentence
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
    // Proved errors of a choice of the trade, from the picture of its shading that trades nothing; of depth and cutoff, from the base picture.
    ProvedErrors provedOf(const Candidate& candidate, uint32_t truthSamples = 0);
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
    struct Untraded {
        Frame frame;                              // with kCheckedPlanes
        std::unique_ptr<const BoundOfRays> rays;  // of a traced picture
    };
    const Untraded& untraded(const RenderRequest& request);

    Scene small_;
    const Scene& scene_;
    const RenderRequest base_;
    uint32_t shrink_ = 1, width_, height_;
    double factor_;
    std::function<bool()> progress_;
    std::map<uint32_t, std::unique_ptr<Checker>> checkers_;  // by samples
    std::map<std::string, Probed> known_;
    std::map<std::pair<Shading, uint32_t>, Untraded> untraded_;  // by shading and samples
    double truthMs_ = 0, rayMs_ = 0, rays_ = 0;
};

}  // namespace plumb
