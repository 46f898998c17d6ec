// SPDX-License-Identifier: MIT
// Plan: the steps that draw a picture, decided before anything runs, and the outcome of each. A step has one name, from the plan to the
// label of its dispatches, its time and its JSON. Recorders refuse labels that are no step of the plan, and close() refuses a plan that was
// not walked.
#pragma once

#include "host/pass_time.h"

#include <string>
#include <vector>

namespace plumb {

enum class RunsOn { device, twin, host };  // the twin is the processor's form of a pass; host code is the same for both sides
const char* nameOf(RunsOn side);

struct PlanStep {
    std::string name;  // name of the pass
    RunsOn side = RunsOn::device;
    std::string why;           // reason why the step is part of this picture
    std::string fusedIn = {};  // step whose kernel or function does this one's work, too; empty: it runs by itself
    std::string idle = {};     // after drawing: reason why it had nothing to do; empty where it did something
    bool ran = false;          // after drawing: true when it did something
};

struct Plan {
    struct Drop {
        std::string what, why;
        std::string row = {};    // name of its row of the table of drops (drops.h)
        std::string saves = {};  // work that is not done, in words; empty: counters say it after drawing
    };
    // A default that this scene asks to be more accurate: the cheapest form whose bound holds here.
    struct Raise {
        std::string what;    // choice, e.g. "precision"
        std::string of;      // object or part of the scene that asks for it
        std::string to;      // form that is taken
        std::string why;     // sentence with the bound of the usual form
        double usual = 0;    // bound of the usual form, in `unit`; +infinity: none
        double reached = 0;  // bound of the form that is taken
        std::string unit;    // of both bounds
    };
    std::vector<PlanStep> steps;  // in order; their names differ
    std::vector<Drop> dropped;    // steps that a picture of this kind has and this one does not need
    std::vector<Raise> raised;
    std::vector<std::string> warnings;  // what no form of this scene's numbers keeps
    std::vector<std::string> choices;   // e.g. "samples 4: the frame is drawn at 1280x960 and resolved"

    std::vector<std::string> names() const;
    // Appends `step`, or does nothing where a step of its name is there.
    void add(PlanStep step);
    // Names of the steps that run by themselves on `side`: the labels that a recorder of this plan may use.
    std::vector<std::string> labels(RunsOn side) const;
    // States that a step has nothing to do here. A name that is no step is ignored; a step that runs elsewhere in the same picture has run.
    void skip(const std::string& name, const std::string& why);
    // Closes the plan after drawing: marks the steps that ran by the labels of `times`. Throws Error(failed), one sentence, where something
    // ran that is no step of the plan, or a step neither ran nor stated that it had nothing to do.
    void close(const std::vector<PassTime>& times);
};

}  // namespace plumb
