// SPDX-License-Identifier: MIT
#include "pipeline/compare/gate.h"

#include "host/error.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {
namespace {

struct Row {
    const char* name;
    Metric metric;
    bool larger, countsPixels;
};
constexpr std::array<Row, 14> kRows = {{{"max", Metric::max, false, false},
                                        {"mean", Metric::mean, false, false},
                                        {"rmse", Metric::rmse, false, false},
                                        {"psnr", Metric::psnr, true, false},
                                        {"ssim", Metric::ssim, true, false},
                                        {"flip", Metric::flip, false, false},
                                        {"flip_max", Metric::flipMax, false, false},
                                        {"deltae", Metric::deltaE, false, false},
                                        {"deltae_max", Metric::deltaEMax, false, false},
                                        {"ulp", Metric::ulp, false, false},
                                        {"differing", Metric::differing, false, true},
                                        {"region", Metric::region, false, true},
                                        {"nan", Metric::nan, false, true},
                                        {"over", Metric::over, false, true}}};

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
    throw usageError(
        fmt::format("--gate: '{}' is refused: {}; accepted: [PLANE.]METRIC<=VALUE, e.g. max<=2/255, flip<=0.02, "
                    "ssim>=0.99, over(4/255)<=0.1%, depth.ulp<=4",
                    printable(text, 80), why));
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

// Value of decimal ["/" decimal], finite, not below 0.
std::optional<double> numberOf(std::string_view text) {
    const auto decimal = [](std::string_view word) -> std::optional<double> {
        double value = 0;
        word = trimmed(word);
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value) || std::signbit(value)) return std::nullopt;
        return value;
    };
    const size_t slash = text.find('/');
    const std::optional<double> above = decimal(text.substr(0, slash));
    if (slash == text.npos || !above) return above;
    const std::optional<double> below = decimal(text.substr(slash + 1));
    if (!below || *below == 0) return std::nullopt;
    return *above / *below;
}

const Row& rowOf(Metric metric) {
    return *std::find_if(kRows.begin(), kRows.end(), [&](const Row& row) { return row.metric == metric; });
}

struct Measured {
    double value = 0;
    std::optional<Pixel> at;
};

std::optional<Measured> measured(const Gate& gate, const LayerDifference& layer) {
    const std::optional<Pixel> worst = layer.max ? std::optional(layer.maxAt) : layer.firstDiffering;
    const auto number = [&](const std::optional<double>& value, std::optional<Pixel> at) -> std::optional<Measured> {
        if (!value) return std::nullopt;
        return Measured{*value, at};
    };
    const auto perceived = [](const std::optional<Perceived>& p, bool mean) -> std::optional<Measured> {
        if (!p) return std::nullopt;
        return Measured{mean ? p->mean : p->worst, p->at};
    };
    switch (gate.metric) {
        case Metric::max:
            return number(layer.max, worst);
        case Metric::mean:
            return number(layer.mean, worst);
        case Metric::rmse:
            return number(layer.rmse, worst);
        case Metric::psnr:
            return number(layer.psnr, worst);
        case Metric::ssim:
            return perceived(layer.ssim, true);
        case Metric::flip:
            return perceived(layer.flip, true);
        case Metric::flipMax:
            return perceived(layer.flip, false);
        case Metric::deltaE:
            return perceived(layer.deltaE, true);
        case Metric::deltaEMax:
            return perceived(layer.deltaE, false);
        case Metric::ulp:
            return number(layer.ulp, layer.ulpAt);
        case Metric::differing:
            return Measured{double(layer.differing), layer.firstDiffering};
        case Metric::region:
            return Measured{double(layer.region.pixels), layer.region.least};
        case Metric::nan: {
            if (layer.a.kind != LayerKind::real) return std::nullopt;
            const bool inA = layer.nanA.pixels != 0;
            return Measured{double(std::max(layer.nanA.pixels, layer.nanB.pixels)),
                            layer.hasNan() ? std::optional(inA ? layer.nanA.first : layer.nanB.first) : std::nullopt};
        }
        case Metric::over: {
            if (layer.a.kind == LayerKind::id) return std::nullopt;
            const auto count = std::count_if(layer.error.begin(), layer.error.end(), [&](double e) { return e > gate.level; });
            return Measured{double(count), worst};
        }
    }
    return std::nullopt;
}

}  // namespace

const char* nameOf(Metric metric) { return rowOf(metric).name; }

Gate parseGate(const std::string& text) {
    Gate gate;
    gate.text = text;
    const size_t at = text.find_first_of("<>");
    if (at == text.npos) refuse(text, "'<=', '<', '>=' or '>' is missing");
    std::string_view left = trimmed(std::string_view(text).substr(0, at)), right = std::string_view(text).substr(at + 1);
    gate.larger = text[at] == '>';
    gate.strict = !right.starts_with('=');
    if (!gate.strict) right.remove_prefix(1);

    std::string_view level;
    const size_t bracket = left.find('(');
    if (bracket != left.npos) {
        if (left.back() != ')') refuse(text, "')' is missing");
        level = left.substr(bracket + 1, left.size() - bracket - 2);
        left = left.substr(0, bracket);
    }
    const size_t dot = left.rfind('.');  // names of planes may have dots
    if (dot != left.npos) {
        gate.layer = std::string(left.substr(0, dot));
        left = left.substr(dot + 1);
        if (gate.layer.empty()) refuse(text, "the name of a plane is missing before '.'");
    }
    const auto row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return left == r.name; });
    if (row == kRows.end()) {
        std::vector<const char*> names;
        for (const Row& r : kRows) names.push_back(r.name);
        refuse(text, fmt::format("'{}' is no metric ({})", printable(left, 40), fmt::join(names, ", ")));
    }
    gate.metric = row->metric;
    if ((gate.metric == Metric::over) != (bracket != std::string_view::npos))
        refuse(text, gate.metric == Metric::over ? "over needs a level, as in over(4/255)" : "only over takes a level");
    if (gate.metric == Metric::over) {
        const std::optional<double> value = numberOf(level);
        if (!value) refuse(text, fmt::format("'{}' is no level", printable(level, 40)));
        gate.level = *value;
    }
    if (gate.larger != row->larger)
        refuse(text,
               fmt::format("{} is better when {}: use '{}='", row->name, row->larger ? "larger" : "smaller", row->larger ? ">" : "<"));
    right = trimmed(right);
    if (right.ends_with('%')) {
        if (!row->countsPixels) refuse(text, "'%' is of the pixels, for differing, region, nan and over");
        gate.share = true;
        right.remove_suffix(1);
    }
    const std::optional<double> limit = numberOf(right);
    if (!limit) refuse(text, fmt::format("'{}' is no number of at least 0", printable(right, 40)));
    gate.limit = gate.share ? *limit / 100 : *limit;
    return gate;
}

std::vector<GateResult> judge(const std::vector<Gate>& gates, const Comparison& comparison) {
    std::vector<GateResult> results;
    for (const Gate& gate : gates) {
        const size_t before = results.size();
        bool found = false;
        for (const LayerDifference& layer : comparison.layers) {
            if (!gate.layer.empty() && gate.layer != layer.name) continue;
            found = true;
            std::optional<Measured> m = measured(gate, layer);
            if (!m) continue;
            if (gate.share) m->value /= double(layer.pixels);
            const bool within = gate.larger ? m->value >= gate.limit : m->value <= gate.limit;
            const bool held = within && !(gate.strict && m->value == gate.limit);
            results.push_back({&gate, layer.name, m->value, held, m->at});
        }
        // True when one side lacks the plane. That is a difference, which is reported elsewhere.
        const auto lacks = [&](const std::vector<std::string>& names) {
            return std::find(names.begin(), names.end(), gate.layer) != names.end();
        };
        if (results.size() != before || lacks(comparison.onlyA) || lacks(comparison.onlyB)) continue;
        if (!gate.layer.empty() && !found) refuse(gate.text, fmt::format("there is no plane '{}'", printable(gate.layer, 40)));
        if (comparison.layers.empty()) continue;
        refuse(gate.text, gate.metric == Metric::ssim ? "these pictures have no ssim, which needs colour and 11x11 pixels"
                                                      : fmt::format("these pictures have no {}", nameOf(gate.metric)));
    }
    return results;
}

bool nanIsJudged(const std::vector<Gate>& gates, const std::string& layer) {
    return std::any_of(gates.begin(), gates.end(),
                       [&](const Gate& gate) { return gate.metric == Metric::nan && (gate.layer.empty() || gate.layer == layer); });
}

}  // namespace plumb
