// SPDX-License-Identifier: MIT
// Tables of choices: a word has one value and a value one word, the first row of an axis is what a picture has that trades nothing, and a row moves
// what it says and no more.
#include "pipeline/choices/choices.h"
#include "pipeline/choices/planes.h"
#include "pipeline/choices/trade.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <string>

namespace plumb {
namespace {

template <class Rows>
void expectWordsAreDistinct(const Rows& rows) {
    std::set<std::string> words;
    for (const auto& row : rows) {
        EXPECT_TRUE(words.insert(row.word).second) << row.word;
        EXPECT_STRNE(row.word, "");
        EXPECT_STRNE(row.help, "") << row.word;
        if (row.alias[0] != '\0') {
            EXPECT_TRUE(words.insert(row.alias).second) << row.alias;
        }
    }
}

template <class Rows>
void expectATable(const Rows& rows) {
    expectWordsAreDistinct(rows);
    for (const auto& row : rows) {
        EXPECT_EQ(choiceOfWord(rows, row.word), &row) << row.word;
        EXPECT_EQ(&choiceOfValue(rows, row.value), &row) << row.word;
        EXPECT_STREQ(wordOf(rows, row.value), row.word);
        if (row.alias[0] != '\0') {
            EXPECT_EQ(choiceOfWord(rows, row.alias), &row) << row.alias;
        }
    }
    for (const char* other : {"", "no such word"}) EXPECT_EQ(choiceOfWord(rows, other), nullptr) << other;
}

TEST(Choices, HaveOneWordAValueAndOneValueAWord) {
    expectATable(kVerdicts);
    expectATable(kShadings);
    expectATable(kFills);
    expectATable(kWireViews);
    expectATable(kEdgeCounts);
    expectATable(kEncodings);
    expectATable(kSampleCounts);
    expectATable(kSamplings);
    expectATable(kLevelForms);
    expectATable(kViewers);
    expectATable(kAovs);
}

// Rows stand in the order of the enumerators, to the last of them: none is without a word.
template <class Value>
constexpr bool areInOrder(const auto& rows, Value last) {
    for (size_t i = 0; i < std::size(rows); ++i)
        if (size_t(rows[i].value) != i) return false;
    return std::size(rows) == size_t(last) + 1;
}
static_assert(areInOrder(kShadings, Shading::ray));
static_assert(areInOrder(kFills, Fill::notes));
static_assert(areInOrder(kWireViews, WireView::solid));
static_assert(areInOrder(kEncodings, Encoding::linear));
static_assert(areInOrder(kSamplings, Sampling::notes));

TEST(TradeAxes, BeginWithWhatTradesNothing) {
    std::set<std::string> names;
    for (const TradeAxis& axis : kTradeAxes) {
        SCOPED_TRACE(axis.name);
        EXPECT_TRUE(names.insert(axis.name).second);
        EXPECT_EQ(tradeAxis(axis.name), &axis);
        expectWordsAreDistinct(axis.choices);
        EXPECT_GT(axis.choices.size(), 1u) << "a choice";
        EXPECT_EQ(&axis.chosen(Trade{}), &axis.choices[0]);
    }
    EXPECT_EQ(tradeAxis("shading"), nullptr);
    EXPECT_EQ(tradeAxis(""), nullptr);
}

TEST(TradeAxes, MoveOneThingEach) {
    for (const TradeAxis& axis : kTradeAxes)
        for (const TradeChoice& choice : axis.choices) {
            SCOPED_TRACE(std::string(axis.name) + "=" + choice.word);
            Trade trade;
            choice.choose(trade);
            EXPECT_EQ(trade == Trade{}, &choice == &axis.choices[0]);
            for (const TradeAxis& other : kTradeAxes) EXPECT_EQ(&other.chosen(trade), &other == &axis ? &choice : &other.choices[0]);
            EXPECT_EQ(std::count_if(axis.choices.begin(), axis.choices.end(), [&](const TradeChoice& c) { return c.isChosen(trade); }), 1);
            EXPECT_EQ(choice.verdict, trade.native() ? Verdict::bounded : Verdict::bits)
                << "what the device's own functions draw is bounded";
            EXPECT_EQ(verdictOf(trade), choice.verdict);
        }
}

TEST(TradeAxes, AreWrittenWithEveryWord) {
    EXPECT_EQ(wordsOf(Trade{}),
              "specular=exact light-vector=pixel interpolation=perspective depth=reversed-32 subpixel=8 transform=fp32 normals=normalised "
              "rate=1 encode=threshold");
    EXPECT_EQ(wordsOf(Trade{.specular = Trade::Specular::native, .depthBits = 16, .coarse = true}),
              "specular=native light-vector=pixel interpolation=perspective depth=16 subpixel=8 transform=fp32 normals=normalised rate=1/2 "
              "encode=threshold");
    EXPECT_EQ(verdictOf(Trade{.depthBits = 16, .nativeEncode = true}), Verdict::bounded) << "the weakest";
}

}  // namespace
}  // namespace plumb
