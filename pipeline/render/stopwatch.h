// SPDX-License-Identifier: MIT
// Adds the host time of a scope to the pass of that name.
#pragma once

#include "host/recorder.h"

#include <chrono>
#include <vector>

namespace plumb {

// Adds `ms` to the entry of that pass, or a new one.
inline void addTime(std::vector<PassTime>& times, const char* pass, double ms) {
    for (PassTime& t : times)
        if (t.pass == pass) {
            t.ms += ms;
            ++t.dispatches;
            return;
        }
    times.push_back({pass, ms, 1});
}

class Stopwatch {
public:
    Stopwatch(std::vector<PassTime>* times, const char* pass) : times_(times), pass_(pass) {}
    Stopwatch(const Stopwatch&) = delete;
    ~Stopwatch() {
        if (times_) addTime(*times_, pass_, elapsedMs());
    }
    double elapsedMs() const { return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count(); }

private:
    std::vector<PassTime>* times_;
    const char* pass_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace plumb
