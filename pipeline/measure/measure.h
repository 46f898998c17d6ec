// SPDX-License-Identifier: MIT
// Measurement of every choice against one truth, with its time, on the user's own scene.
#pragma once

#include "pipeline/measure/axes.h"
#include "pipeline/measure/error_bound.h"
#include "pipeline/measure/telling.h"
#include "pipeline/render/bounds/rounding.h"
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
    bool deviceThere = true;    // false: choices that need a device are absent
    std::string noBinary64;     // why the device draws nothing in binary64, and choices of it are absent; empty: it does
    uint32_t repetitions = 31;  // rounds wanted; the time may allow fewer
    double limitMs = 120000;    // limit of the whole command: errors and the truth count too
    double beforeMs = 0;        // part of the limit spent before the measurement began
    double afterMs = 0;         // part of the limit kept for later work
    uint64_t seed = 0;          // seed of the order of rounds
    uint32_t truthSamples = 0;  // samples a pixel of the one truth; 0: the most that any choice of any axis takes
    size_t tables = 1;          // measurements that are read as one table: no row of any of them is told apart wrongly
    bool keepPictures = false;  // frames and errors by pixel, for the report
    std::function<RenderResult(const Scene&, const Setting&)> draw;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

struct Times {
    std::vector<double> ms;  // one a round, in order
    // Median; none below kLeastForMedian, because a value between two times is not called their median.
    std::optional<double> median() const;
    double min() const;
    double max() const;
};

enum class Told { faster, slower, notApart };
// Words "faster", "slower", "not told apart": than the default.
const char* nameOf(Told);

// Run: a distinct way to draw. Rows of several axes may share one (the default picture stands in every axis).
struct MeasuredRun {
    Setting setting;
    Times total;  // host time of a whole render, upload and readback included
    std::vector<std::pair<std::string, Times>> passes;
    // Interval of each round's time over the default's in the same round; none of fewer than kLeastForMedian rounds.
    std::optional<RatioInterval> ratio;
    Told told = Told::notApart;  // what `ratio` says
    // Error against the truth of the most samples. None for a wire frame, or where the limit left no time for that truth.
    std::optional<FrameError> error;
    std::optional<FrameError> alike;              // error against the truth at the picture's own samples
    std::optional<ErrorBound> bound;              // bound that `error` keeps; none for the default picture itself
    std::string boundWhy;                         // reason why there is no bound, or none of some figures
    std::optional<Rounding> rounding;             // error of float32 by itself
    std::vector<uint32_t> rgba;                   // picture, with keepPictures
    std::vector<RenderCounters::RayCounts> rays;  // rays of a traced picture by depth
    std::string refused;  // sentence of a renderer that does not draw this scene so; then the run is cut, and its rows are absent
    bool cut = false;     // true: the limit left no time for it
    std::string cutWhy;   // time that it would have needed
    std::string bytes;    // SHA-256 of the picture
};

struct Row {
    const Axis* axis = nullptr;
    const AxisChoice* choice = nullptr;
    bool baseline = false;      // true: the default picture
    std::optional<size_t> run;  // index into Measurement::runs; none: absent
    std::string why;            // reason why it is absent, was cut or has no error
    bool onFront = false;       // true: on the front of all rows; one answer for all rows of a run
    bool onAxisFront = false;   // true: on the front of the choices of its axis and the default
};

struct Measurement {
    std::vector<MeasuredRun> runs;  // the first is the default picture, the second the default again
    std::vector<Row> rows;          // the default again, then in the order of the axes; those that were cut are in `cut` instead
    std::vector<Row> cut;
    std::vector<size_t> front;   // rows, by rising time; a run that several rows share stands once. Empty below kLeastForMedian rounds
    std::optional<Truth> truth;  // the one truth, with the default picture's fill; none: the limit left no time for it, or a wire frame
    uint32_t repetitions = 0;    // rounds, each with every row that was not cut
    size_t comparisons = 0;      // runs that were timed beside the default, times MeasurePlan::tables
    double miss = 0;             // chance that one row's interval misses the true ratio; missOf()
    bool limitKept = true;       // false: the default picture alone took longer
    double totalMs = 0;
};

// Measures all choices. Each is drawn once with planes for its error and once without to warm up (both must have the same bytes:
// Error(failed) otherwise). Then all are timed in rounds, in an order in which every run follows every other equally often (rounds.h).
// The limit cuts rows, which are listed: first those that repeat the default's pixels and passes, then the axes by falling askedRank(),
// the slowest of an axis first. An error beyond its proved bound fails: Error(failed), with the row, the pixel and both numbers.
Measurement measure(const Scene& scene, const MeasurePlan& plan);

}  // namespace plumb
