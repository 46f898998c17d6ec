// SPDX-License-Identifier: MIT
#include "pipeline/cli/progress.h"

#include <fmt/core.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

namespace plumb {

Progress::Progress(ProgressMode mode, bool quiet, std::FILE* stream) : mode_(mode), stream_(stream), start_(Clock::now()) {
    if (mode_ == ProgressMode::automatic) mode_ = ::isatty(::fileno(stream)) != 0 ? ProgressMode::bar : ProgressMode::none;
    if (quiet) mode_ = ProgressMode::none;
}

Progress::~Progress() { clear(); }

std::optional<double> Progress::secondsLeft(double fraction, double elapsedSeconds) {
    if (!(fraction > 0.01) || elapsedSeconds < 0.5) return std::nullopt;
    return elapsedSeconds * (1 - fraction) / fraction;
}

std::string Progress::clock(double exactSeconds) {
    const auto seconds = int64_t(std::lround(exactSeconds));
    return seconds < 3600 ? fmt::format("{}:{:02}", seconds / 60, seconds % 60)
                          : fmt::format("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
}

void Progress::begin(const std::string& task, double from, double to, std::chrono::milliseconds after) {
    task_ = task;
    from_ = from;
    to_ = to;
    if (from == 0) {
        start_ = Clock::now();
        last_ = {};
        shownShare_ = 0;
        lastTenth_ = -1;
        told_ = false;
    }
    show_ = after.count() > 0 ? Clock::now() + after : Clock::time_point{};
    update(0);
}

// Writes text. fmt::print throws when the stream cannot be written; fputs returns an error, which is ignored.
static void put(std::FILE* stream, const std::string& text) {
    std::fputs(text.c_str(), stream);
    std::fflush(stream);
}

void Progress::update(double fraction) {
    if (mode_ == ProgressMode::none) return;
    const double whole = shownShare_ = std::clamp(from_ + (to_ - from_) * std::clamp(fraction, 0.0, 1.0), shownShare_, 1.0);
    const auto now = Clock::now();
    if (now < show_) return;
    const int tenth = int(whole * 10);
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const std::optional<double> left = secondsLeft(whole, elapsed);
    if (mode_ == ProgressMode::plain) {
        if (tenth == lastTenth_) return;
        lastTenth_ = tenth;
        put(stream_, fmt::format("{}: {} %{}{}\n", task_, tenth * 10, tenth == 0 ? "" : fmt::format(", {} elapsed", clock(elapsed)),
                                 left && tenth < 10 ? fmt::format(", {} left", clock(*left)) : ""));
        return;
    }
    const bool atEnd = whole == 1 && !told_;
    if (now - last_ < std::chrono::milliseconds(100) && !atEnd) return;
    last_ = now;
    told_ = whole == 1;
    if (mode_ == ProgressMode::json) {
        // The task is one of our own phrases: letters, digits, blanks and slashes, so it needs no escapes.
        put(stream_, fmt::format("{{\"progress\":{:.4f},\"task\":\"{}\",\"elapsed_s\":{:.3f},\"left_s\":{}}}\n", whole, task_, elapsed,
                                 left ? fmt::format("{:.3f}", *left) : "null"));
        return;
    }
    constexpr int kWidth = 30;
    const int filled = int(whole * kWidth);
    put(stream_,
        fmt::format("\r\x1b[K{} [{}{}] {:3.0f} %  {}", task_, std::string(size_t(filled), '#'), std::string(size_t(kWidth - filled), '.'),
                    whole * 100, left ? fmt::format("{} elapsed, {} left", clock(elapsed), clock(*left)) : ""));
    shown_ = true;
}

void Progress::clear() {
    if (!shown_) return;
    std::fputs("\r\x1b[K", stream_);
    std::fflush(stream_);
    shown_ = false;
}

}  // namespace plumb
