// SPDX-License-Identifier: MIT
#include "pipeline/choices/budget.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <charconv>
#include <cmath>

namespace plumb {
namespace {

constexpr double kFullScale = 255;  // steps

// "max, p99, rms, wrong".
std::string metricWords() { return fmt::format("{}", fmt::join(wordsIn(kErrorMetrics), ", ")); }

Error refused(std::string_view text, const std::string& why) {
    return usageError(
        fmt::format("--error: '{}' is refused: {}; accepted: E or E:METRIC by commas, E in steps of 1/255 (2 or 2/255; for "
                    "wrong a share, e.g. 0.1%), METRIC one of {}",
                    text, why, metricWords()));
}

// None: the text is no number of that kind.
std::optional<double> numberOf(std::string_view digits) {
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value) || value < 0) return std::nullopt;
    return value;
}

std::optional<double> stepsOf(std::string_view text) {
    constexpr std::string_view kOfScale = "/255";
    if (text.ends_with(kOfScale)) text.remove_suffix(kOfScale.size());
    const std::optional<double> steps = numberOf(text);
    return steps && *steps <= kFullScale ? steps : std::nullopt;
}

std::optional<double> shareOf(std::string_view text) {
    const bool percent = text.ends_with('%');
    if (percent) text.remove_suffix(1);
    const std::optional<double> value = numberOf(text);
    if (!value || *value > (percent ? 100 : 1)) return std::nullopt;
    return percent ? *value / 100 : *value;
}

void addOne(ErrorBudget& budget, std::string_view text) {
    const size_t colon = text.find(':');
    const std::string_view amount = text.substr(0, colon);
    const Choice<BudgetMember>* metric =
        colon == std::string_view::npos ? &kErrorMetrics[0] : choiceOfWord(kErrorMetrics, text.substr(colon + 1));
    if (metric == nullptr) throw refused(text, fmt::format("'{}' is no metric", text.substr(colon + 1)));
    const bool share = metric->value == &ErrorBudget::wrong;
    const std::optional<double> value = share ? shareOf(amount) : stepsOf(amount);
    if (!value) throw refused(text, fmt::format("'{}' is no {}", amount, share ? "share from 0 to 1" : "number of steps from 0 to 255"));
    std::optional<double>& limit = budget.*(metric->value);
    if (limit) throw refused(text, fmt::format("{} has a limit already, and one of the two contradicts the other", metric->word));
    limit = value;
}

}  // namespace

void addErrorBudget(ErrorBudget& budget, std::string_view text) {
    for (;;) {
        const size_t comma = text.find(',');
        addOne(budget, text.substr(0, comma));
        if (comma == std::string_view::npos) return;
        text.remove_prefix(comma + 1);
    }
}

void refuseBelowRounding(const ErrorBudget& budget, Encoding encoding) {
    // A colour lies up to half a byte from its byte, evenly spread: 99 of 100 within 0.495 and 1 / sqrt(12) rms. Of a linear byte, half a
    // step is up to 12.92 / 2 steps of the sRGB code, where the curve is steepest.
    const double half = encoding == Encoding::linear ? 0.5 * 12.92 : 0.5;
    const auto check = [](const std::optional<double>& limit, const char* metric, double least) {
        if (limit && *limit < least)
            throw usageError(
                fmt::format("--error: {:g}:{} is below the {:.4g} steps that rounding to bytes costs by itself", *limit, metric, least));
    };
    check(budget.max, "max", half);
    if (encoding == Encoding::linear) return;  // how much of the curve a picture uses is not known beforehand
    check(budget.p99, "p99", 0.99 * half);
    check(budget.rms, "rms", half / std::sqrt(3.0));
}

std::string wordsOf(const ErrorBudget& budget) {
    std::string words;
    for (const Choice<BudgetMember>& metric : kErrorMetrics) {
        const bool share = metric.value == &ErrorBudget::wrong;
        const std::optional<double> limit = share ? budget.wrongLimit() : budget.*(metric.value);
        if (!limit) continue;
        words += fmt::format("{}{} {:g}{}", words.empty() ? "" : ", ", metric.word, share ? 100 * *limit : *limit, share ? " %" : "");
    }
    return words;
}

}  // namespace plumb
