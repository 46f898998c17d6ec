// SPDX-License-Identifier: MIT
// Metrics, each in a file of its own. compare.cpp calls them in turn.
#pragma once

#include "pipeline/compare/compare.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

// Brings both layers to the same channels: grey becomes R G B when the other has it, missing alpha is opaque, 8 bits become 16. False when
// there is no common form; `why` then says so.
bool bringTogether(Layer& a, Layer& b, std::string& why);

// Takes max, mean, rmse, psnr, over, differing, region, error, NaN. The layers have one form.
void takeNorms(const Layer& a, const Layer& b, uint32_t width, uint32_t height, const CompareOptions&, LayerDifference&);
// Takes the largest distance in representable numbers.
void takeUlp(const Layer& a, const Layer& b, uint32_t width, LayerDifference&);
// Largest region of the pixels whose flag is not 0.
Region largestRegion(const std::vector<uint8_t>& differs, uint32_t width, uint32_t height);
// Steps from a to b among floating-point numbers of 16, 32 or 64 bits; both zeros are one number. Neither is NaN; both are representable.
double ulpDistance(double a, double b, int bits);

struct Rgb {
    double r = 0, g = 0, b = 0;
};

// Colour layer as a display shows it. Values beyond [0, 1] are clamped, since these measures are of a display; NaN counts as 0.
struct Seen {
    uint32_t width = 0, height = 0;
    std::vector<float> red, green, blue;  // linear light, 0 to 1
};
// Layer as a display shows it. `ground`: what a transparent picture lies on, 0 black or 1 white.
Seen seen(const Layer&, uint32_t width, uint32_t height, double ground);

double linearFromSrgb(double code);  // IEC 61966-2-1, both in [0, 1]
double srgbFromLinear(double light);

// SSIM (Wang et al. 2004): 11x11 Gaussian windows of sigma 1.5 that lie in the picture, K1 = 0.01, K2 = 0.03, of the luma 0.299 R' + 0.587
// G' + 0.114 B' of the encoded colours. Absent when no window lies in the picture.
std::optional<Perceived> ssimOf(const Seen& a, const Seen& b, const CompareOptions&);
// LDR-FLIP (Andersson et al. 2020); the map has one error a pixel, row by row.
Perceived flipOf(const Seen& a, const Seen& b, const CompareOptions&, std::vector<float>& map);
// CIEDE2000 of every pixel, kL = kC = kH = 1, D65.
Perceived deltaEOf(const Seen& a, const Seen& b, const CompareOptions&);

struct Lab {
    double l = 0, a = 0, b = 0;
};
double ciede2000(const Lab&, const Lab&);
Lab labFromLinear(const Rgb&);

}  // namespace plumb
