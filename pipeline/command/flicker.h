// SPDX-License-Identifier: MIT
// Flicker of a turntable: how far a pixel changes from one picture to the next. A highlight of flat or Gouraud shading flashes when an object turns;
// Phong's moves.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/render/frame.h"

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Change between two pictures, in steps of 1/255 of the stored code, over the pixels that show the same object in both. Outlines are left out: what
// moves there is the object.
struct FlickerStep {
    uint32_t from = 0, to = 0;  // numbers of the pictures
    uint64_t pixels = 0;        // that show the same object in both
    double max = 0, rms = 0;    // of a pixel's largest channel; of all channels
    uint32_t x = 0, y = 0;      // pixel of the largest change
};

class Flicker {
public:
    // Pictures in their order, with kPlaneObject. The last is compared with the first when all `count` are there: a turn has no end.
    explicit Flicker(uint32_t count) : count_(count) {}
    void add(const Frame& frame);

    const std::vector<FlickerStep>& steps() const { return steps_; }
    // The largest of all steps.
    FlickerStep largest() const;
    // Root mean square over all steps.
    double rms() const;
    Json json() const;
    std::string line() const;

private:
    struct Kept {
        std::vector<uint32_t> rgba, object;
        uint32_t width = 0;
    };
    void compare(const Kept& a, uint32_t from, const Kept& b, uint32_t to);

    const uint32_t count_;
    uint32_t seen_ = 0;
    Kept first_, last_;
    std::vector<FlickerStep> steps_;
};

}  // namespace plumb
