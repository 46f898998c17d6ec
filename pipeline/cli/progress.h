// SPDX-License-Identifier: MIT
// Progress on standard error: a bar with the time left, lines to read, JSON lines, or nothing. At most ten updates a second.
#pragma once

#include "pipeline/cli/options.h"

#include <chrono>
#include <cstdio>
#include <string>

namespace plumb {

class Progress {
public:
    // `automatic` is a bar when `stream` is a terminal. `quiet` shows nothing.
    Progress(ProgressMode, bool quiet, std::FILE* stream = stderr);
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress();                       // clears the bar

    void begin(const std::string& task);             // e.g. "render 3/24"
    void update(double fraction);                    // 0..1 of the task
    void clear();                                    // before anything else is printed

    // "1:02 left" from the time that `fraction` took; empty while it is too early to say.
    static std::string timeLeft(double fraction, double elapsedSeconds);

private:
    using Clock = std::chrono::steady_clock;
    ProgressMode mode_;
    std::FILE* stream_;
    std::string task_;
    Clock::time_point start_, last_;
    int lastTenth_ = -1;
    bool shown_ = false;
};

}  // namespace plumb
