// SPDX-License-Identifier: MIT
// Gates: limits that a comparison must not exceed.
//
//     gate   = [plane "."] metric ("<=" | "<" | ">=" | ">") value
//     metric = max | mean | rmse | psnr | ssim | flip | flip_max | deltae | deltae_max | ulp | differing | region | nan | over(number)
//     value  = number ["%"]          number = decimal ["/" decimal]
//
// ssim and psnr are better when larger and take ">=" or ">"; all others take "<=" or "<". "%" is of the pixels, for differing, region, nan
// and over. max, mean, rmse and the number of over are shares of full scale (2/255: two steps of 8 bits), or units of the plane where it
// has no scale. Without a plane, the gate is on every plane that has the metric.
#pragma once

#include "pipeline/compare/compare.h"

#include <optional>
#include <string>
#include <vector>

namespace plumb {

enum class Metric { max, mean, rmse, psnr, ssim, flip, flipMax, deltaE, deltaEMax, ulp, differing, region, nan, over };

struct Gate {
    std::string text;   // condition as written
    std::string layer;  // empty: every plane that has the metric
    Metric metric = Metric::max;
    double level = 0;     // number of over(number)
    bool larger = false;  // ">=" or ">"
    bool strict = false;  // "<" or ">"
    double limit = 0;     // a share of the pixels when `share`
    bool share = false;
};

struct GateResult {
    const Gate* gate = nullptr;
    std::string layer;
    double value = 0;  // in the unit of the limit
    bool held = false;
    std::optional<Pixel> at;  // the worst pixel
};

// Parses a gate. Throws Error(usage): one line with what is wrong and what is accepted.
Gate parseGate(const std::string& text);
// Results of the gates, one for each layer that a gate is on. Throws Error(usage) when there is no such layer.
std::vector<GateResult> judge(const std::vector<Gate>&, const Comparison&);
// True when a gate on "nan" covers the layer. A NaN that no such gate covers fails, whatever the other gates say.
bool nanIsJudged(const std::vector<Gate>&, const std::string& layer);

const char* nameOf(Metric);

}  // namespace plumb
