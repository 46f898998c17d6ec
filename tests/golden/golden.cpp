// SPDX-License-Identifier: MIT
#include "tests/golden/golden.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <utility>

namespace plumb::golden {
namespace {

std::set<std::string>& names() {
    static std::set<std::string> all;
    return all;
}

// First place where `got` is not within `allowed` of `want`; empty: none. NaN is never within.
std::string difference(const Json& got, const Json& want, double allowed, bool relative, const std::string& at = "") {
    if (want.is_array()) {
        if (!got.is_array() || got.size() != want.size()) return fmt::format("{}: shape differs: {} for {}", at, got.dump(), want.dump());
        for (size_t i = 0; i < want.size(); ++i) {
            std::string fault = difference(got[i], want[i], allowed, relative, fmt::format("{}[{}]", at, i));
            if (!fault.empty()) return fault;
        }
        return {};
    }
    if (!want.is_number() || !got.is_number())
        return got == want ? std::string() : fmt::format("{}: {} for {}", at, got.dump(), want.dump());
    const double x = got.get<double>(), y = want.get<double>();
    const double bound = relative ? allowed * std::max(1.0, std::abs(y)) : allowed;
    if (std::abs(x - y) <= bound) return {};
    return fmt::format("{}: {:.17g} instead of {:.17g}, off by {:.3g}, allowed {:.3g}", at, x, y, std::abs(x - y), bound);
}

// "0.1234" as a number; the elements of `printed` are strings.
bool withinPrint(const Json& printed, const Json& expected, const Json& allowed) {
    if (expected.is_array()) {
        if (!printed.is_array() || printed.size() != expected.size()) return false;
        for (size_t i = 0; i < expected.size(); ++i)
            if (!withinPrint(printed[i], expected[i], allowed.is_array() ? allowed[i] : allowed)) return false;
        return true;
    }
    // The expected value is itself binary64 rounded along its formula: 0 may stand there as 2e-16.
    const double p = std::strtod(printed.get<std::string>().c_str(), nullptr), e = expected.get<double>();
    return std::abs(p - e) <= allowed.get<double>() + tolerance().binary64 * std::max(1.0, std::abs(e));
}

const Json& entryNamed(const std::string& id) {
    for (const Json& entry : file()["examples"])
        if (entry["id"] == id) return entry;
    static const Json kNone = Json::object();
    ADD_FAILURE() << "the file has no entry " << id;
    return kNone;
}

}  // namespace

const Json& file() {
    static const Json kFile = [] {
        std::ifstream in(PLUMB_SOURCE_DIR "/tests/data/worked-examples.json");
        return Json::parse(in);
    }();
    return kFile;
}

const Tolerance& tolerance() {
    static const Tolerance kRead = [] {
        Tolerance t;
        const std::string text = file()["conventions"]["implementation_tolerance"].get<std::string>();
        const int found = std::sscanf(text.c_str(),
                                      "double: %lf * max(1,|expected|); float32: %lf * max(1,|expected|) unless an "
                                      "entry says otherwise; colours: %lf level",
                                      &t.binary64, &t.float32, &t.colourLevels);
        if (found != 3) ADD_FAILURE() << "conventions.implementation_tolerance reads otherwise: " << text;
        return t;
    }();
    return kRead;
}

Entry::Entry(const std::string& id) : entry_(entryNamed(id)), id_(id) {}
const Json& Entry::input(const std::string& name) const { return entry_.at("inputs").at(name); }
const Json& Entry::data(const std::string& name) const { return entry_.at("data").at(name); }

const Json& Entry::expected(const std::string& check) {
    for (const Json& c : entry_.at("checks"))
        if (c["name"] == check) {
            read_.insert(check);
            return c["expected"];
        }
    ADD_FAILURE() << id_ << " has no check '" << check << "'";
    static const Json kNone;
    return kNone;
}

void Entry::compare(const std::string& check, const Json& value, double allowed, bool relative) {
    const std::string fault = difference(value, expected(check), allowed, relative);
    EXPECT_EQ(fault, "") << id_ << ", " << check;
}

void Entry::finish() const {
    for (const Json& c : entry_.at("checks"))
        EXPECT_TRUE(read_.contains(c["name"].get<std::string>()))
            << id_ << ": no test reads the check '" << c["name"].get<std::string>() << "'";
}

bool registerEntry(const char* id) { return names().insert(id).second; }
const std::set<std::string>& registered() { return names(); }

namespace {

TEST(GoldenFile, EveryEntryHasATest) {
    std::set<std::string> inFile;
    for (const Json& entry : file()["examples"]) {
        const std::string id = entry["id"].get<std::string>();
        EXPECT_TRUE(inFile.insert(id).second) << id << " stands twice in the file";
        EXPECT_TRUE(registered().contains(id)) << id << " has no test";
    }
    for (const std::string& id : registered()) EXPECT_TRUE(inFile.contains(id)) << "a test names " << id << ", which the file has not";
    std::printf("%zu entries, %zu with a test\n", inFile.size(), registered().size());
}

TEST(GoldenFile, TheComparisonNotices) {
    const Json want = {{1.0, 2.0}, {3.0, 1e6}};
    const double allowed = tolerance().binary64;
    EXPECT_EQ(difference(want, want, allowed, true), "");
    EXPECT_EQ(difference({{1.0, 2.0}, {3.0, 1e6 * (1 + allowed / 2)}}, want, allowed, true), "");
    EXPECT_NE(difference({{1.0, 2.0}, {3.0, 1e6 * (1 + 2 * allowed)}}, want, allowed, true), "");
    EXPECT_NE(difference({{1.0, 2.0 + 3 * allowed}, {3.0, 1e6}}, want, allowed, true), "");
    EXPECT_NE(difference({{1.0, 2.0}}, want, allowed, true), "") << "another shape";
    EXPECT_NE(difference({{1.0, 2.0}, {3.0, std::nan("")}}, want, allowed, true), "");
    EXPECT_NE(difference({{1.0, 2.0}, {3.0, nullptr}}, want, allowed, true), "");
    EXPECT_NE(difference(2, 1, 0, false), "");
}

TEST(GoldenFile, CountsAreThoseThatItStates) {
    size_t checks = 0;
    std::map<std::string, size_t> kinds;
    for (const Json& entry : file()["examples"]) {
        checks += entry["checks"].size();
        ++kinds[entry["kind"].get<std::string>()];
    }
    const Json& counts = file()["counts"];
    EXPECT_EQ(file()["examples"].size(), counts["examples"].get<size_t>());
    EXPECT_EQ(checks, counts["checks"].get<size_t>());
    for (const char* kind : {"worked", "claim", "derived", "scene"}) EXPECT_EQ(kinds[kind], counts[kind].get<size_t>()) << kind;
}

// `printed` is evidence about the notes, not about us: it lies within half a unit of its last digit exactly where the file says so.
TEST(GoldenFile, PrintedValuesDisagreeWhereTheFileSaysSo) {
    std::set<std::pair<std::string, std::string>> disagree;
    for (const Json& entry : file()["examples"])
        for (const Json& c : entry["checks"]) {
            if (c["printed"].is_null()) continue;
            const std::string id = entry["id"].get<std::string>(), name = c["name"].get<std::string>();
            const bool within = withinPrint(c["printed"], c["expected"], c["tolerance"]);
            EXPECT_EQ(within, c["agrees"].get<bool>()) << id << ", " << name;
            if (!c["agrees"].get<bool>()) disagree.emplace(id, name);
        }
    std::set<std::pair<std::string, std::string>> stated;
    for (const Json& row : file()["printed_values_that_disagree"]) stated.emplace(row[0].get<std::string>(), row[1].get<std::string>());
    EXPECT_EQ(disagree, stated);
}

}  // namespace
}  // namespace plumb::golden
