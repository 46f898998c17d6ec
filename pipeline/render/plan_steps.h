// SPDX-License-Identifier: MIT
// Steps of a picture's plan, as the ways to draw add them, with the steps that several of them have.
#pragma once

#include "pipeline/render/prepare.h"

#include <cstdint>

namespace plumb {

class StepList {
public:
    // Adds to prepared.plan. `side`: of the steps that are passes.
    StepList(const RenderRequest& request, Prepared& prepared, RunsOn side) : request_(request), p_(prepared), side_(side) {}

    bool onDevice() const { return side_ == RunsOn::device; }
    void add(const char* name, const char* why) { p_.plan.add({name, side_, why}); }
    void addOnHost(const char* name, const char* why) { p_.plan.add({name, RunsOn::host, why}); }
    // A step whose work is done in the kernel or function of the step `in`.
    void addFused(const char* name, const char* in, const char* why) { p_.plan.add({name, side_, why, in}); }
    // Illumination before the fill, for shadings that have it.
    void addIllumination();
    // Samples (so many a pixel) become pixels and linear light becomes code. `in`: the step whose kernel encodes single samples; empty: none.
    void addColours(uint32_t samples, RunsOn side, const char* in);

private:
    const RenderRequest& request_;
    Prepared& p_;
    const RunsOn side_;
};

}  // namespace plumb
