// SPDX-License-Identifier: MIT
#include "pipeline/image/arrange.h"

#include "host/error.h"

#include <algorithm>
#include <cstdint>

namespace plumb {

namespace {

// Calls body(from's plane, to's plane, numbers a pixel) for each plane that `from` has.
template <class Body>
void eachPlane(const Frame& from, Frame& to, const Body& body) {
    forEachPlane([&](const auto& row, auto plane) {
        if (!(from.*plane).empty()) body(from.*plane, to.*plane, row.channels);
    });
}

constexpr uint32_t kNothing = 0xffffffffu;  // object_id where nothing is drawn

void countCovered(Frame& frame, bool any) {
    frame.coveredPixels = any ? uint64_t(frame.width) * frame.height : 0;
    if (!frame.object.empty())
        frame.coveredPixels = uint64_t(frame.object.size()) - uint64_t(std::count(frame.object.begin(), frame.object.end(), kNothing));
}

}  // namespace

Frame columnsOf(const Frame& frame, uint32_t firstColumn, uint32_t columns) {
    PLUMB_ASSERT(uint64_t(firstColumn) + columns <= frame.width);
    Frame part;
    part.width = columns;
    part.height = frame.height;
    eachPlane(frame, part, [&](const auto& source, auto& target, size_t channels) {
        target.reserve(size_t(columns) * frame.height * channels);
        for (uint32_t y = 0; y < frame.height; ++y) {
            const auto row = source.begin() + ptrdiff_t((size_t(y) * frame.width + firstColumn) * channels);
            target.insert(target.end(), row, row + ptrdiff_t(columns * channels));
        }
    });
    countCovered(part, frame.coveredPixels != 0);
    return part;
}

Frame fieldOf(const Frame& frame, Field field) {
    const uint32_t first = field == Field::odd ? 0 : 1;
    Frame part;
    part.width = frame.width;
    part.height = (frame.height + 1 - first) / 2;
    eachPlane(frame, part, [&](const auto& source, auto& target, size_t channels) {
        const size_t pitch = size_t(frame.width) * channels;
        for (uint32_t y = first; y < frame.height; y += 2)
            target.insert(target.end(), source.begin() + ptrdiff_t(y * pitch), source.begin() + ptrdiff_t((y + 1) * pitch));
    });
    countCovered(part, frame.coveredPixels != 0);
    return part;
}

Frame interlaced(const Frame& odd, const Frame& even) {
    PLUMB_ASSERT(odd.width == even.width && (odd.height == even.height || odd.height == even.height + 1));
    Frame whole;
    whole.width = odd.width;
    whole.height = odd.height + even.height;
    const auto weave = [&](const Frame& from, uint32_t first) {
        eachPlane(from, whole, [&](const auto& source, auto& target, size_t channels) {
            const size_t pitch = size_t(from.width) * channels;
            target.resize(size_t(whole.height) * pitch);
            for (uint32_t y = 0; y < from.height; ++y)
                std::copy_n(source.begin() + ptrdiff_t(y * pitch), pitch, target.begin() + ptrdiff_t((first + 2 * size_t(y)) * pitch));
        });
    };
    weave(odd, 0);
    weave(even, 1);
    whole.coveredPixels = odd.coveredPixels + even.coveredPixels;
    return whole;
}

Frame anaglyphOf(const Frame& left, const Frame& right) {
    PLUMB_ASSERT(left.width == right.width && left.height == right.height && left.linear.size() == right.linear.size());
    PLUMB_ASSERT(left.object.size() == left.rgba.size() && right.object.size() == right.rgba.size());
    Frame both;
    both.width = left.width;
    both.height = left.height;
    both.rgba.resize(left.rgba.size());
    for (size_t i = 0; i < both.rgba.size(); ++i) {
        both.rgba[i] = (left.rgba[i] & 0x000000ffu) | (right.rgba[i] & 0xffffff00u);
        both.coveredPixels += left.object[i] != kNothing || right.object[i] != kNothing;
    }
    both.linear = right.linear;
    for (size_t i = 0; i < both.linear.size(); i += 3) both.linear[i] = left.linear[i];
    return both;
}

}  // namespace plumb
