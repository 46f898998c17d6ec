// SPDX-License-Identifier: MIT
// A measurement as one HTML file that needs nothing else: no network, no library, every picture and the raw JSON inside.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// What a choice drew: encoded RGBA8 as Frame::rgba, row 0 on top.
struct ReportPicture {
    std::string axis, choice;  // of the rows that drew it; several rows with one picture name it once each
    uint32_t width = 0, height = 0;
    std::vector<uint32_t> rgba;
};

// The file stays below this; pictures that do not fit are left out, and the page says which.
inline constexpr size_t kMostReportBytes = 2'000'000;
// Larger pictures show every n-th pixel of every n-th row: true pixels, fewer of them.
inline constexpr uint32_t kMostReportPixels = 640 * 480;

// `measurement`: the object of `plumb measure --json` (docs/outputs.md). `truth` and `pictures` have one size; pictures of an axis and choice that no
// row has are an error of ours. Colour only: alpha is dropped.
std::string reportHtml(const nlohmann::ordered_json& measurement, const ReportPicture& truth, std::span<const ReportPicture> pictures);

}  // namespace plumb
