// SPDX-License-Identifier: MIT
// What the error of a picture can be at most where its choice has a proved bound, and whether it is.
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

// What a choice may move the colour of a default picture by, in linear light, a channel: alike everywhere, or three values a pixel.
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

// Steps of the sRGB code, rounding to bytes included. A figure is kNoBound where the choice may leave any code in the pixel that the figure hangs on.
struct ErrorBound {
    static constexpr double kNoBound = std::numeric_limits<double>::infinity();
    double max = 0, mean = 0, rms = 0, p99 = 0;
    double linear = 0;             // what the choice may add, in linear light; kNoBound from full scale on
    double steps = 0;              // and in steps of the code, after that
    std::vector<double> perPixel;  // 0 where neither picture nor truth shows anything
    // Nothing is said by any figure.
    bool empty() const { return max == kNoBound && mean == kNoBound && rms == kNoBound && p99 == kNoBound && linear == kNoBound; }
    // Which figures say nothing, and why; empty: each says something.
    std::string why() const;
};

// `base`: the default picture, sRGB, of the truth's size. A choice leaves a code between those of the darkest and the brightest colour that it may make of the default's,
// half a step of rounding to bytes and `steps` beside them, and none outside 0 to 255; alpha is the default's own.
ErrorBound errorBoundOf(const Frame& base, const Truth& truth, bool transparent, const ColourMoves& moves, double steps);

struct BoundBreach {
    std::string figure;     // max, mean, rms, p99 or linear
    uint32_t x = 0, y = 0;  // the pixel that is furthest beyond its own bound; of mean and rms, the one with the largest error
    double error = 0, bound = 0;
    const char* unit = "steps of 1/255";
};
// The first figure that is not within its bound; not a number is within none. None: all are.
std::optional<BoundBreach> breachOf(const FrameError& error, const ErrorBound& bound, uint32_t width);
// Where `frame` is further from the default picture in linear light than the choice may move it.
std::optional<BoundBreach> breachOfMoves(const Frame& base, const Frame& frame, const ColourMoves& moves);

}  // namespace plumb
