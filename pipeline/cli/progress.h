// SPDX-License-Identifier: MIT
// Progress on standard error: a bar with the time left, lines to read, JSON lines, or nothing. At most ten updates a second.
// A standard error that cannot be written is no failure: what was to be shown is lost, nothing else.
#pragma once

#include "pipeline/cli/options.h"

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace plumb {

class Progress {
public:
    // `automatic` is a bar when `stream` is a terminal. `quiet` shows nothing.
    Progress(ProgressMode, bool quiet, std::FILE* stream = stderr);
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress();  // clears the bar

    // Begins a task that is a part of the whole, e.g. "render 3/24" from 2/24 to 3/24. The share of the whole is shown; its clock starts
    // with the task that begins at 0. It never falls: repeated work (a device opened afresh) shows its earlier share.
    void begin(const std::string& task, double from = 0, double to = 1,
               std::chrono::milliseconds after = {});  // nothing is shown before `after`
    void rename(const std::string& task) { task_ = task; }
    static constexpr std::chrono::milliseconds kMoment{300};
    void update(double fraction);  // 0..1 of the task
    void clear();                  // before anything else is printed

    // Estimate of the seconds left, from the time that `fraction` took; none while it is too early.
    static std::optional<double> secondsLeft(double fraction, double elapsedSeconds);
    static std::string clock(double seconds);  // "1:02", "2:30:00"

private:
    using Clock = std::chrono::steady_clock;
    ProgressMode mode_;
    std::FILE* stream_;
    std::string task_;
    Clock::time_point start_, last_, show_;
    double from_ = 0, to_ = 1;  // part of the task in the whole
    double shownShare_ = 0;
    int lastTenth_ = -1;
    bool told_ = false;  // the end of the whole
    bool shown_ = false;
};

}  // namespace plumb
