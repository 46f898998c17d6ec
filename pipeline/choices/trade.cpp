// SPDX-License-Identifier: MIT
#include "pipeline/choices/trade.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

namespace plumb {

const TradeChoice& TradeAxis::chosen(const Trade& trade) const {
    const auto found = std::find_if(choices.begin(), choices.end(), [&](const TradeChoice& choice) { return choice.isChosen(trade); });
    PLUMB_ASSERT(found != choices.end());
    return *found;
}

const TradeAxis* tradeAxis(std::string_view name) {
    const auto found = std::find_if(std::begin(kTradeAxes), std::end(kTradeAxes), [&](const TradeAxis& axis) { return name == axis.name; });
    return found == std::end(kTradeAxes) ? nullptr : found;
}

std::string wordsOf(const Trade& trade) {
    std::string words;
    for (const TradeAxis& axis : kTradeAxes) words += fmt::format("{}{}={}", words.empty() ? "" : " ", axis.name, axis.chosen(trade).word);
    return words;
}

Verdict verdictOf(const Trade& trade) {
    Verdict weakest = Verdict::bits;
    for (const TradeAxis& axis : kTradeAxes) weakest = std::max(weakest, axis.chosen(trade).verdict);
    return weakest;
}

}  // namespace plumb
