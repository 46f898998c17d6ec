// SPDX-License-Identifier: MIT
// Every choice against one truth, with its time, on the user's own scene.
#pragma once

#include "pipeline/measure/axes.h"
#include "pipeline/measure/error_bound.h"
#include "pipeline/render/rounding.h"
#include "pipeline/truth/frame_error.h"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

struct MeasurePlan {
    std::vector<const Axis*> axes;
    Setting base;               // the default picture; each choice changes one thing of it
    bool deviceThere = true;    // false: what needs one is absent
    uint32_t repetitions = 7;   // wanted; the time may allow fewer
    double limitMs = 120000;    // of the whole measurement
    bool keepPictures = false;  // frames and errors by pixel, for the report
    std::function<RenderResult(const Scene&, const Setting&)> draw;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

struct Times {
    std::vector<double> ms;  // of each repetition, in the order in which they were taken
    double median() const;
    double min() const;
    double max() const;
};

// A distinct way to draw; rows of several axes may share one (the default picture stands in every axis).
struct MeasuredRun {
    Setting setting;
    Times total;  // host time of a whole render, upload and readback included
    std::vector<std::pair<std::string, Times>> passes;
    std::optional<FrameError> error;  // against the one truth; none for a wire frame
    std::optional<FrameError> alike;  // against the truth at the picture's own samples
    std::optional<ErrorBound> bound;  // of `error`; none for the default picture itself. Below full scale, and `error` is within it
    std::string boundWhy;             // no bound, or none of some figures: why
    std::optional<Rounding> rounding; // what float32 costs by itself
    std::vector<uint32_t> rgba;       // keepPictures
    std::vector<RenderCounters::RayCounts> rays;  // by depth; of a traced picture
    std::string refused;              // what the renderer says who does not draw this scene so; then it is cut, and its rows are absent
    bool cut = false;                 // the limit left no time for it
};

struct Row {
    const Axis* axis = nullptr;
    const Choice* choice = nullptr;
    bool baseline = false;
    std::optional<size_t> run;  // none: absent
    std::string why;            // absent or without an error: why
    bool onFront = false;
};

struct Measurement {
    std::vector<MeasuredRun> runs;  // the first is the default picture
    std::vector<Row> rows;  // in the order of the axes; those that were cut are in `cut` instead
    std::vector<Row> cut;
    std::vector<size_t> front;  // rows, by rising time; a run that several rows share stands once
    Truth truth;                // with the fill of the default picture, of the most samples among the choices
    uint32_t repetitions = 0;   // that every row has
    double totalMs = 0;
};

// Each choice is drawn once with planes for its error and once without to warm up (both must have the same bytes: Error(failed) otherwise), then all
// are timed in turn, round by round, so that a slow minute of the machine meets all alike. An error beyond its proved bound fails: Error(failed), with the row, the
// pixel and both numbers. Where the limit leaves no time for two rounds of all, the
// slowest are cut and listed.
Measurement measure(const Scene& scene, const MeasurePlan& plan);

}  // namespace plumb
