// SPDX-License-Identifier: MIT
// Fingerprint of a device as one HTML file that needs nothing else.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace plumb {

// `fingerprint`: the object of `plumb devices --fingerprint --json` (docs/outputs.md). Its answers are left out of the page.
std::string fingerprintHtml(const nlohmann::ordered_json& fingerprint);

}  // namespace plumb
