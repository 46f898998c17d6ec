// SPDX-License-Identifier: MIT
#include "pipeline/report/fingerprint_page.h"

#include "host/error.h"

#include <nlohmann/json.hpp>
#include <string>

namespace plumb {

extern const char* const kFingerprintPage;  // fingerprint.html, made into C++ by the build

std::string fingerprintHtml(const nlohmann::ordered_json& fingerprint) {
    nlohmann::ordered_json shown = fingerprint;
    for (auto& trait : shown.at("traits")) trait.erase("answers");
    // Inside a <script>: no "</" may end it and no "<!--" may open a comment.
    std::string data;
    for (const char c : shown.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
        if (c == '<')
            data += "\\u003c";
        else
            data += c;
    }
    std::string page = kFingerprintPage;
    const std::string mark = "{{fingerprint}}";
    const size_t at = page.find(mark);
    PLUMB_ASSERT(at != page.npos);
    return page.replace(at, mark.size(), data);
}

}  // namespace plumb
