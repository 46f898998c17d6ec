// SPDX-License-Identifier: MIT
#include "pipeline/command/pixel_report.h"

#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {
namespace {

constexpr uint32_t kNobody = 0xffffffffu;

Json numberJson(double x) {
    if (std::isnan(x)) return "nan";
    if (std::isinf(x)) return x < 0 ? "-inf" : "inf";
    return x;
}
Json listJson(const std::vector<double>& values) {
    Json list = Json::array();
    for (const double x : values) list.push_back(numberJson(x));
    return list;
}
Json listJson(const double (&values)[3]) { return listJson(std::vector<double>(values, values + 3)); }
Json idJson(uint32_t id) { return id == kNobody ? Json() : Json(id); }

struct Side {
    const char* name;
    const Column Line::*column;
};
constexpr std::array<Side, 4> kSides = {
    {{"textbook", &Line::textbook}, {"device", &Line::device}, {"twin", &Line::twin}, {"truth", &Line::truth}}};

Json lineJson(const Line& line) {
    Json json;
    json["section"] = line.section;
    json["name"] = line.name;
    json["what"] = line.what;
    if (!line.how.empty()) json["how"] = line.how;
    if (line.decision) json["decision"] = true;
    Json why = Json::object();
    for (const Side& side : kSides) {
        const Column& column = line.*side.column;
        json[side.name] = column.has() ? listJson(column.values) : Json();
        if (!column.has()) why[side.name] = column.why;
    }
    json["bound"] = line.truth.has() ? listJson(line.bound) : Json();
    if (!why.empty()) json["not_computed"] = why;
    return json;
}

Json shownJson(const Shown& shown, bool truth) {
    if (!shown.there) return {{"not_computed", shown.why}};
    Json json;
    json["object"] = idJson(shown.object);
    json["polygon"] = idJson(shown.face);
    json["linear"] = listJson(shown.linear);
    json["code"] = listJson(shown.code);
    if (truth) {
        json["linear_bound"] = listJson(shown.linearBound);
        json["code_bound"] = listJson(shown.codeBound);
    }
    return json;
}

std::string shortly(double x) {
    if (x == std::floor(x) && std::abs(x) < 1e9) return fmt::format("{:.0f}", x + 0.0);
    return fmt::format("{:.9g}", x);
}

// Reasons of missing values, each told once, by number.
class Reasons {
public:
    size_t numberOf(const std::string& why) {
        const auto found = std::find(all_.begin(), all_.end(), why);
        if (found != all_.end()) return size_t(found - all_.begin()) + 1;
        all_.push_back(why);
        return all_.size();
    }
    std::string text() const {
        std::string text;
        for (size_t i = 0; i < all_.size(); ++i) text += fmt::format("  [{}] not computed: {}\n", i + 1, printable(all_[i]));
        return text;
    }

private:
    std::vector<std::string> all_;
};

std::string textOfLine(const Line& line, Reasons& reasons) {
    std::string text = fmt::format("{:<7} {}: {}\n", line.section.empty() ? "-" : line.section, line.name, line.what);
    size_t rows = 0;
    for (const Side& side : kSides) rows = std::max(rows, (line.*side.column).values.size());
    for (size_t i = 0; i < std::max<size_t>(rows, 1); ++i) {
        std::string row;
        for (const Side& side : kSides) {
            const Column& column = line.*side.column;
            std::string cell;
            if (i < column.values.size())
                cell = line.decision ? (column.values[i] == 1   ? "yes"
                                        : column.values[i] == 0 ? "no"
                                                                : "undecided")
                                     : shortly(column.values[i]);
            else if (i == 0 && !column.has())
                cell = fmt::format("[{}]", reasons.numberOf(column.why));
            row += fmt::format(" {:>16}", cell);
        }
        if (i < line.truth.values.size() && i < line.bound.size() && !line.decision) row += fmt::format(" +- {:.2g}", line.bound[i]);
        text += "       " + row + "\n";
    }
    return text;
}

std::string who(const Shown& shown) {
    if (!shown.there) return "not computed: " + shown.why;
    std::string face = shown.object == kNobody ? std::string("nothing") : fmt::format("object {}", shown.object);
    if (shown.face != kNobody) face += fmt::format(" polygon {}", shown.face);
    return fmt::format("{}, bytes {} {} {}", face, shortly(shown.code[0]), shortly(shown.code[1]), shortly(shown.code[2]));
}

}  // namespace

Json chainJson(const Chain& chain) {
    Json json;
    json["title"] = chain.title;
    json["object"] = idJson(chain.object);
    json["polygon"] = idJson(chain.face);
    json["triangle"] = idJson(chain.triangle);
    json["device_parts"] = chain.deviceParts.empty() ? Json() : Json(chain.deviceParts);
    json["truth_parts"] = chain.truthParts.empty() ? Json() : Json(chain.truthParts);
    json["lines"] = Json::array();
    for (const Line& line : chain.lines) json["lines"].push_back(lineJson(line));
    return json;
}

Json pixelJson(const OpenedPixel& opened) {
    Json json;
    json["pixel"] = opened.pixel ? Json({opened.x, opened.y}) : Json();
    json["technique"] = opened.technique;
    if (opened.pixel)
        json["shown"] = {
            {"device", shownJson(opened.device, false)}, {"twin", shownJson(opened.twin, false)}, {"truth", shownJson(opened.truth, true)}};
    json["explains"] = opened.explains;
    json["candidates"] = Json::array();
    for (const Candidate& c : opened.candidates)
        json["candidates"].push_back({{"object", idJson(c.object)},
                                      {"polygon", idJson(c.face)},
                                      {"triangle", idJson(c.triangle)},
                                      {"z_twin", c.twinZ.has() ? numberJson(c.twinZ.values[0]) : Json()},
                                      {"z_truth", c.truthZ.has() ? numberJson(c.truthZ.values[0]) : Json()},
                                      {"z_bound", c.truthZ.has() ? numberJson(c.truthBound) : Json()},
                                      {"seen_by_twin", c.twinSees},
                                      {"seen_by_device", c.deviceSees},
                                      {"seen_by_truth", c.truthSees},
                                      {"lost", c.lost}});
    json["chains"] = Json::array();
    for (const Chain& chain : opened.chains) json["chains"].push_back(chainJson(chain));
    return json;
}

std::string textOf(const Chain& chain) {
    Reasons reasons;
    std::string text =
        printable(chain.title) + "\n" + fmt::format("section{:>17} {:>16} {:>16} {:>16}\n", "textbook", "device", "twin", "truth +- bound");
    for (const Line& line : chain.lines) text += textOfLine(line, reasons);
    return text + reasons.text();
}

std::string textOf(const OpenedPixel& opened) {
    std::string text;
    if (opened.pixel) {
        text += fmt::format("pixel {},{} ({})\n  device: {}\n  twin:   {}\n  truth:  {}\n", opened.x, opened.y, opened.technique,
                            who(opened.device), who(opened.twin), who(opened.truth));
        for (const std::string& one : opened.explains) text += "  " + printable(one) + "\n";
    }
    for (const Candidate& c : opened.candidates) {
        text += fmt::format("  covers it: object {} polygon {}, n/w twin {} truth {}{}\n", c.object, c.face,
                            c.twinZ.has() ? fmt::format("{:.9g}", c.twinZ.values[0]) : "none",
                            c.truthZ.has() ? fmt::format("{:.12g}", c.truthZ.values[0]) : "none",
                            c.lost.empty() ? ", shown" : "; lost: " + c.lost);
    }
    for (const Chain& chain : opened.chains) text += textOf(chain);
    return text;
}

}  // namespace plumb
