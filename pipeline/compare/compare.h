// SPDX-License-Identifier: MIT
// Comparison of two pictures, layer by layer. Every number is of decoded samples, never of bytes of a file.
//
// Samples of a code layer count as code / fullScale, so that a step of 8 bits is 1/255; those of a real layer count as they are. Nothing is
// ever resized.
#pragma once

#include "pipeline/compare/picture.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

struct Pixel {
    uint32_t x = 0, y = 0;
};

struct CompareOptions {
    uint32_t radius = 0;              // a pixel matches when the other picture has a matching pixel within this many columns and rows
    double pixelsPerDegree = 0;       // for FLIP; 0: kDefaultPixelsPerDegree
    std::vector<std::string> layers;  // names of the layers to compare; empty: all
    uint32_t threads = 0;             // 0: all; changes no number
    std::function<void()> onStep;     // called regularly; may throw to stop
};

// Default of FLIP: a monitor of 3840 pixels on 0.7 m, seen from 0.7 m (Andersson et al., "FLIP: A Difference Evaluator for Alternating
// Images", 2020): about 67.02.
inline constexpr double kDefaultPixelsPerDegree = 0.7 * 3840 / 0.7 * 3.14159265358979323846 / 180;

inline constexpr std::array<int, 4> kLevels = {1, 2, 4, 8};  // steps of 1/255

struct NotANumber {
    uint64_t pixels = 0;  // pixels with a NaN in any channel
    Pixel first;
};

struct Region {  // the largest set of differing pixels that are connected by sides or corners
    uint64_t pixels = 0;
    Pixel least, most;  // corners of its box, inclusive
};

struct Perceived {  // mean over pixels, and the worst
    double mean = 0, worst = 0;
    Pixel at;
};

// Differences of one layer. Pixels with a NaN on either side take part in no norm. Equal infinities do not differ; otherwise their
// difference is infinite.
struct LayerDifference {
    std::string name;
    Layer a, b;                         // without samples: the layers as the files state them
    uint64_t pixels = 0, compared = 0;  // pixels: all; compared: those without a NaN
    NotANumber nanA, nanB;
    uint64_t differing = 0;  // pixels in which any channel differs, NaN on one side included
    std::optional<Pixel> firstDiffering;
    // Norms of real and code layers, after the search of `radius`.
    std::optional<double> max, mean, rmse;  // over channels: largest, mean and root of mean square
    Pixel maxAt;
    uint32_t maxChannel = 0;
    double valueA = 0, valueB = 0;  // values at maxAt, in units of the layer
    std::vector<double> error;      // error of each pixel: the largest of its channels; NaN where a sample is NaN. Ids: 1 where they differ
    std::optional<double> psnr;     // dB, peak 1, colour only; infinite when equal
    std::array<uint64_t, 4> over{};  // pixels whose error is over kLevels / 255; code and colour
    Region region;
    // Largest distance of real layers in steps between neighbouring floats, of the wider type of the two; without search.
    std::optional<double> ulp;
    Pixel ulpAt;
    int ulpPrecision = 32;
    // Perceived differences of colour layers, without search. Transparent pictures are put on black and on white, and the worse counts.
    std::optional<Perceived> ssim;  // worst: the lowest window. Absent below 11x11
    std::optional<Perceived> flip;
    std::vector<float> flipMap;       // error of every pixel, when flip is there
    std::optional<Perceived> deltaE;  // CIEDE2000

    bool hasNan() const { return nanA.pixels + nanB.pixels != 0; }
};

struct Comparison {
    bool sameSize = true;                   // otherwise nothing more is compared
    std::string sizeDifference;             // "640x480 against 320x240"
    std::vector<std::string> onlyA, onlyB;  // layers that the other file lacks
    std::vector<LayerDifference> layers;

    bool equal() const;  // True when size, layers and samples are the same, without any NaN
};

// Compares two pictures. Throws Error(usage) when options.layers names a layer that neither has.
Comparison compare(const Picture& a, const Picture& b, const CompareOptions&);

}  // namespace plumb
