// SPDX-License-Identifier: MIT
// Equal bytes, or the first difference by name: pass, index (or pixel), both values. NaN fails before anything is compared.
#pragma once

#include "pipeline/render/frame.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace plumb::test {

template <class T>
std::string valueOf(const T& value) {
    std::string text;
    for (size_t i = 0; i < sizeof(T) / 4; ++i) {
        uint32_t word;
        std::memcpy(&word, reinterpret_cast<const char*>(&value) + 4 * i, 4);
        text += fmt::format("{}{:08x}", i ? " " : "", word);
        if constexpr (std::is_same_v<T, float>) text += fmt::format(" ({:.9g})", value);
    }
    return text;
}

// `place` names an index, e.g. as a pixel.
template <class T, class Place>
void expectSame(const std::string& pass, std::span<const T> twin, std::span<const T> device, const Place& place) {
    ASSERT_EQ(twin.size(), device.size()) << pass << ": twin and device leave different numbers of values";
    size_t differing = 0, first = 0;
    for (size_t i = 0; i < twin.size(); ++i) {
        if constexpr (std::is_same_v<T, float>) {
            ASSERT_FALSE(std::isnan(twin[i]) || std::isnan(device[i])) << pass << ", " << place(i) << ": not a number";
        }
        // Bytes, not values: -0 is not 0.
        const auto bytesOf = [](const T& value) { return std::as_bytes(std::span<const T>(&value, 1)); };
        if (std::ranges::equal(bytesOf(twin[i]), bytesOf(device[i]))) continue;
        if (differing++ == 0) first = i;
    }
    EXPECT_EQ(differing, 0u) << pass << ", " << place(first) << ": twin has " << valueOf(twin[first]) << ", device has "
                             << valueOf(device[first]);
}
template <class T>
void expectSame(const std::string& pass, std::span<const T> twin, std::span<const T> device) {
    expectSame<T>(pass, twin, device, [](size_t i) { return fmt::format("index {}", i); });
}

template <class T>
void expectSamePlane(const std::string& name, uint32_t width, uint32_t channels, const std::vector<T>& want, const std::vector<T>& got) {
    expectSame<T>(name, want, got, [&](size_t i) {
        return fmt::format("pixel ({}, {}) channel {}", i / channels % width, i / channels / width, i % channels);
    });
}

// Every plane of two frames, but those in `leaveOut`.
inline void expectSameFrame(const Frame& want, const Frame& got, uint32_t leaveOut = 0) {
    ASSERT_EQ(want.width, got.width);
    ASSERT_EQ(want.height, got.height);
    const uint32_t w = want.width;
    EXPECT_EQ(want.coveredPixels, got.coveredPixels);
    expectSamePlane("colour", w, 1, want.rgba, got.rgba);
    if (!(leaveOut & kPlaneLinear)) expectSamePlane("linear", w, 3, want.linear, got.linear);
    if (!(leaveOut & kPlaneDepth)) expectSamePlane("depth", w, 1, want.depth, got.depth);
    if (!(leaveOut & kPlaneDistance)) expectSamePlane("distance", w, 1, want.distance, got.distance);
    if (!(leaveOut & kPlaneNormal)) expectSamePlane("normal", w, 3, want.normal, got.normal);
    if (!(leaveOut & kPlaneObject)) expectSamePlane("object_id", w, 1, want.object, got.object);
    if (!(leaveOut & kPlanePrimitive)) expectSamePlane("primitive_id", w, 1, want.primitive, got.primitive);
    if (!(leaveOut & kPlaneZ)) expectSamePlane("z", w, 1, want.z, got.z);
    if (!(leaveOut & kPlaneTriangle)) expectSamePlane("triangle", w, 1, want.triangle, got.triangle);
}

inline constexpr uint32_t kEveryPlane =
    kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneDistance | kPlaneNormal | kPlaneObject | kPlanePrimitive | kPlaneZ | kPlaneTriangle;

}  // namespace plumb::test
