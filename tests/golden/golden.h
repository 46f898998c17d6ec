// SPDX-License-Identifier: MIT
// The worked examples of tests/data/worked-examples.json, executed from the file: no expected number is typed again here.
//
// GOLDEN(id) { ... } is the test of one entry. It compares a computed value with each check of the entry, under the tolerance that the
// file states (conventions.implementation_tolerance); a check that the test does not ask for fails it, and an entry without a test
// fails GoldenFile.EveryEntryHasATest.
#pragma once

#include <gtest/gtest.h>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace plumb::golden {

using Json = nlohmann::json;

const Json& file();
// From conventions.implementation_tolerance: relative to max(1, |expected|).
struct Tolerance {
    double binary64 = 0, float32 = 0, colourLevels = 0;
};
const Tolerance& tolerance();

class Entry {
public:
    explicit Entry(const std::string& id);
    const Json& input(const std::string& name) const;
    const Json& data(const std::string& name) const;
    const Json& expected(const std::string& check);  // counts as read: for derived comparisons
    // `value`: a number or nested lists of the shape of the check.
    void binary64(const std::string& check, const Json& value) { compare(check, value, tolerance().binary64, true); }
    void float32(const std::string& check, const Json& value) { compare(check, value, tolerance().float32, true); }
    void colour(const std::string& check, const Json& bytes) { compare(check, bytes, tolerance().colourLevels, false); }
    void exactly(const std::string& check, const Json& value) { compare(check, value, 0, false); }
    void finish() const;  // every check was read

private:
    void compare(const std::string& check, const Json& value, double allowed, bool relative);
    const Json& entry_;
    std::string id_;
    std::set<std::string> read_;
};

bool registerEntry(const char* id);
const std::set<std::string>& registered();

// Numbers of the file as vectors, and back.
template <class Vector>
Vector vectorOf(const Json& list) {
    Vector v(0);
    for (int i = 0; i < Vector::length() && i < int(list.size()); ++i) v[i] = list[size_t(i)].get<typename Vector::value_type>();
    return v;
}
template <class Vector>
std::vector<Vector> vectorsOf(const Json& lists) {
    std::vector<Vector> all;
    for (const Json& list : lists) all.push_back(vectorOf<Vector>(list));
    return all;
}
template <int n, class T>
Json jsonOf(const glm::vec<n, T>& v) {
    Json list = Json::array();
    for (int i = 0; i < n; ++i) list.push_back(v[i]);
    return list;
}
template <class Vector>
Json jsonOf(const std::vector<Vector>& all) {
    Json lists = Json::array();
    for (const Vector& v : all) lists.push_back(jsonOf(v));
    return lists;
}
// Rows as on paper.
template <int n>
Json jsonOf(const glm::mat<n, n, double>& m) {
    Json rows = Json::array();
    for (int row = 0; row < n; ++row) rows.push_back(jsonOf(glm::transpose(m)[row]));
    return rows;
}

#define GOLDEN(id)                                                                            \
    static void golden_##id(::plumb::golden::Entry&);                                         \
    [[maybe_unused]] static const bool registered_##id = ::plumb::golden::registerEntry(#id); \
    TEST(Golden, id) {                                                                        \
        ::plumb::golden::Entry entry(#id);                                                    \
        golden_##id(entry);                                                                   \
        entry.finish();                                                                       \
    }                                                                                         \
    static void golden_##id([[maybe_unused]] ::plumb::golden::Entry& e)

}  // namespace plumb::golden
