// SPDX-License-Identifier: MIT
// Adds the host time of a scope to the pass of that name.
#pragma once

#include "host/recorder.h"

#include <chrono>
#include <vector>

namespace plumb {

class Stopwatch {
public:
    Stopwatch(std::vector<PassTime>* times, const char* pass) : times_(times), pass_(pass) {}
    Stopwatch(const Stopwatch&) = delete;
    ~Stopwatch() {
        if (!times_) return;
        const double ms = elapsedMs();
        for (PassTime& t : *times_)
            if (t.pass == pass_) {
                t.ms += ms;
                ++t.dispatches;
                return;
            }
        times_->push_back({pass_, ms, 1});
    }
    double elapsedMs() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
    }

private:
    std::vector<PassTime>* times_;
    const char* pass_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace plumb
