// SPDX-License-Identifier: MIT
#include "pipeline/cli/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <unistd.h>

namespace plumb {

Progress::Progress(ProgressMode mode, bool quiet, std::FILE* stream) : mode_(mode), stream_(stream), start_(Clock::now()) {
    if (mode_ == ProgressMode::automatic) mode_ = ::isatty(::fileno(stream)) != 0 ? ProgressMode::bar : ProgressMode::none;
    if (quiet) mode_ = ProgressMode::none;
}

Progress::~Progress() { clear(); }

std::string Progress::timeLeft(double fraction, double elapsedSeconds) {
    if (!(fraction > 0.01) || elapsedSeconds < 0.5) return "";
    const auto seconds = int64_t(std::ceil(elapsedSeconds * (1 - fraction) / fraction));
    return seconds < 3600 ? fmt::format("{}:{:02} left", seconds / 60, seconds % 60)
                          : fmt::format("{}:{:02}:{:02} left", seconds / 3600, seconds / 60 % 60, seconds % 60);
}

void Progress::begin(const std::string& task) {
    task_ = task;
    start_ = Clock::now();
    last_ = {};
    lastTenth_ = -1;
    update(0);
}

void Progress::update(double fraction) {
    if (mode_ == ProgressMode::none) return;
    fraction = std::clamp(fraction, 0.0, 1.0);
    const auto now = Clock::now();
    const int tenth = int(fraction * 10);
    if (mode_ == ProgressMode::plain) {
        if (tenth == lastTenth_) return;
        lastTenth_ = tenth;
        fmt::print(stream_, "{}: {} %\n", task_, tenth * 10);
        std::fflush(stream_);
        return;
    }
    if (now - last_ < std::chrono::milliseconds(100) && !(fraction == 1 && lastTenth_ != 10)) return;
    last_ = now;
    lastTenth_ = tenth;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    if (mode_ == ProgressMode::json) {
        // The task is one of our own phrases: letters, digits, blanks and slashes, so it needs no escapes.
        fmt::print(stream_, "{{\"progress\":{:.4f},\"task\":\"{}\",\"elapsed_s\":{:.3f}}}\n", fraction, task_, elapsed);
    } else {
        constexpr int kWidth = 30;
        const int filled = int(fraction * kWidth);
        fmt::print(stream_, "\r\x1b[K{} [{}{}] {:3.0f} %  {}", task_, std::string(size_t(filled), '#'), std::string(size_t(kWidth - filled), '.'), fraction * 100,
                   timeLeft(fraction, elapsed));
        shown_ = true;
    }
    std::fflush(stream_);
}

void Progress::clear() {
    if (!shown_) return;
    std::fputs("\r\x1b[K", stream_);
    std::fflush(stream_);
    shown_ = false;
}

}  // namespace plumb
