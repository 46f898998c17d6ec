// SPDX-License-Identifier: MIT
#include "pipeline/report/report.h"

#include "host/error.h"
#include "pipeline/image/image.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

namespace plumb {

extern const char* const kReportPage;  // page.html, made into C++ by the build

namespace {

using Json = nlohmann::ordered_json;

std::string base64(std::span<const std::byte> bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? uint32_t(bytes[i + k]) : 0);
        for (size_t k = 0; k < 4; ++k) text += k <= bytes.size() - i ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

// Picture of every n-th pixel and row.
Frame thinned(const ReportPicture& picture, uint32_t n) {
    Frame frame;
    frame.width = (picture.width + n - 1) / n;
    frame.height = (picture.height + n - 1) / n;
    for (uint32_t y = 0; y < picture.height; y += n)
        for (uint32_t x = 0; x < picture.width; x += n) frame.rgba.push_back(picture.rgba[size_t(y) * picture.width + x]);
    return frame;
}

// Difference to the truth modulo 256, which the page undoes: mostly zeros, so a small fraction of the picture itself, without any loss.
Frame apart(const Frame& picture, const Frame& truth) {
    Frame frame = picture;
    for (size_t i = 0; i < frame.rgba.size(); ++i) {
        uint32_t pixel = 0xff000000u;
        for (int shift = 0; shift < 24; shift += 8) pixel |= (((picture.rgba[i] >> shift) - (truth.rgba[i] >> shift)) & 0xffu) << shift;
        frame.rgba[i] = pixel;
    }
    return frame;
}

std::string pngOf(const Frame& frame) { return base64(encodePng(frame, {}, {})); }

// JSON text inside a <script>: no "</" may end it and no "<!--" may open a comment.
std::string inScript(const Json& json) {
    std::string text;
    for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
        if (c == '<')
            text += "\\u003c";
        else
            text += c;
    }
    return text;
}

void fill(std::string& page, const std::string& mark, const std::string& text) {
    const size_t at = page.find(mark);
    PLUMB_ASSERT(at != page.npos);
    page.replace(at, mark.size(), text);
}

}  // namespace

std::string reportHtml(const Json& measurement, const ReportPicture& truth, std::span<const ReportPicture> pictures) {
    PLUMB_ASSERT(truth.rgba.size() == size_t(truth.width) * truth.height && !truth.rgba.empty());
    uint32_t n = 1;
    while (uint64_t(truth.width / n) * (truth.height / n) > kMostReportPixels) ++n;
    const Frame base = thinned(truth, n);

    std::string page = kReportPage;
    const std::string data = inScript(measurement);
    Json shown;
    shown["every"] = n;
    shown["size"] = {base.width, base.height};
    shown["truth"] = pngOf(base);
    shown["apart"] = Json::array();
    shown["of"] = Json::object();  // "axis/choice": index in `apart`
    shown["leftOut"] = Json::array();
    size_t bytes = page.size() + data.size() + shown["truth"].get_ref<const std::string&>().size() + 65536;

    std::set<std::string> known, front;
    for (const Json& row : measurement.at("rows")) {
        const std::string name = row.at("axis").get<std::string>() + "/" + row.at("choice").get<std::string>();
        known.insert(name);
        if (row.value("onFront", false) || row.value("baseline", false)) front.insert(name);
    }
    // Order of the pictures: front and default first, so that they are never among those left out.
    std::vector<const ReportPicture*> order;
    for (const ReportPicture& picture : pictures) order.push_back(&picture);
    std::stable_partition(order.begin(), order.end(), [&](const ReportPicture* p) { return front.count(p->axis + "/" + p->choice) != 0; });
    std::map<std::vector<uint32_t>, size_t> indices;
    for (const ReportPicture* picture : order) {
        const std::string name = picture->axis + "/" + picture->choice;
        PLUMB_ASSERT(known.count(name) != 0 && picture->width == truth.width && picture->height == truth.height);
        const Frame thin = thinned(*picture, n);
        auto [found, fresh] = indices.try_emplace(thin.rgba, shown["apart"].size());
        if (fresh) {
            std::string png = pngOf(apart(thin, base));
            if (bytes + png.size() > kMostReportBytes) {
                indices.erase(found);
                shown["leftOut"].push_back(name);
                continue;
            }
            bytes += png.size();
            shown["apart"].push_back(std::move(png));
        }
        shown["of"][name] = found->second;
    }
    fill(page, "{{pictures}}", inScript(shown));
    fill(page, "{{measurement}}", data);
    return page;
}

}  // namespace plumb
