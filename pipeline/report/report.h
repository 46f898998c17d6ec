// SPDX-License-Identifier: MIT
// Measurement as one HTML file that needs nothing else: no network, no library, every picture and the raw JSON inside.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// Picture of a choice: encoded RGBA8 as Frame::rgba, row 0 on top.
struct ReportPicture {
    std::string axis, choice;  // axis and choice of the rows that drew it; several rows with one picture name it once each
    uint32_t width = 0, height = 0;
    std::vector<uint32_t> rgba;
};

// Largest file; pictures that do not fit are left out, and the page says which.
inline constexpr size_t kMostReportBytes = 2'000'000;
// Most pixels of a picture. Larger pictures show every n-th pixel of every n-th row: true pixels, fewer of them.
inline constexpr uint32_t kMostReportPixels = 640 * 480;

// HTML of a measurement. `measurement`: the object of `plumb measure --json` (docs/outputs.md). `truth` and `pictures` have one size. A
// picture whose axis and choice no row has is an error of ours. Colour only: alpha is dropped.
std::string reportHtml(const nlohmann::ordered_json& measurement, const ReportPicture& truth, std::span<const ReportPicture> pictures);

}  // namespace plumb
