// SPDX-License-Identifier: MIT
// Bound of a picture's error where its choice has a proved one, and whether the error keeps it.
#pragma once

#include "pipeline/truth/frame_error.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// Largest moves of a default picture's colour by a choice, in linear light, a channel: alike everywhere, or three values a pixel.
class ColourMoves {
public:
    ColourMoves(const glm::dvec3& brighter, const glm::dvec3& darker) : brighterAll_(brighter), darkerAll_(darker) {}
    ColourMoves(std::vector<float> brighter, std::vector<float> darker) : brighter_(std::move(brighter)), darker_(std::move(darker)) {}
    double brighter(size_t pixel, size_t channel) const {
        return brighter_.empty() ? brighterAll_[glm::length_t(channel)] : double(brighter_[3 * pixel + channel]);
    }
    double darker(size_t pixel, size_t channel) const {
        return darker_.empty() ? darkerAll_[glm::length_t(channel)] : double(darker_[3 * pixel + channel]);
    }

private:
    glm::dvec3 brighterAll_{0}, darkerAll_{0};
    std::vector<float> brighter_, darker_;
};

// Bounds of the error figures in steps of the sRGB code, rounding to bytes included. A figure is kNoBound where the choice may leave any
// code in the pixel that decides the figure.
struct ErrorBound {
    static constexpr double kNoBound = std::numeric_limits<double>::infinity();
    double max = 0, mean = 0, rms = 0, p99 = 0;
    double brighter = 0, darker = 0;  // largest moves by the choice in linear light, either way; kNoBound from full scale on
    double steps = 0;                 // further move in steps of the code, either way
    std::vector<double> perPixel;     // 0 where neither picture nor truth shows anything
    // True when no figure has a bound.
    bool empty() const {
        return max == kNoBound && mean == kNoBound && rms == kNoBound && p99 == kNoBound && brighter == kNoBound && darker == kNoBound;
    }
    // Figures without a bound, and why; empty: each has one.
    std::string why() const;
};

// Bound of the error of a choice's picture. `base`: the default picture, sRGB, of the truth's size. A choice leaves a code between those of
// the darkest and the brightest colour that it may make of the default's. Half a step of rounding to bytes and `steps` are added at both
// ends; no code is outside 0 to 255. Alpha is the default's own.
ErrorBound errorBoundOf(const Frame& base, const Truth& truth, bool transparent, const ColourMoves& moves, double steps);

struct BoundBreach {
    std::string figure;     // max, mean, rms, p99 or linear
    uint32_t x = 0, y = 0;  // pixel furthest beyond its own bound; for mean and rms, the pixel with the largest error
    double error = 0, bound = 0;
    const char* unit = "steps of 1/255";
};
// First figure that is not within its bound; NaN is within none. None: all are.
std::optional<BoundBreach> breachOf(const FrameError& error, const ErrorBound& bound, uint32_t width);
// First pixel where `frame` is further from the default picture in linear light than the choice may move it.
std::optional<BoundBreach> breachOfMoves(const Frame& base, const Frame& frame, const ColourMoves& moves);

}  // namespace plumb
