// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/hand_over.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace plumb {

namespace {

template <class T>
void copy(const std::vector<T>& from, size_t count, std::span<T> to) {
    std::copy_n(from.begin(), count, to.begin());
}

}  // namespace

void handOverCulled(const TwinGeometry& twin, const DrawList& list, GpuFrame& frame) {
    copy(twin.screen, list.positions.size(), frame.screen());
    copy(twin.attributes, list.positions.size(), frame.attributes());
    copy(twin.faceColours, twin.faceColours.size(), frame.faceColours());
    copy(twin.records, twin.records.size(), frame.records());
}

void handOverSetUp(const TwinGeometry& twin, GpuFrame& frame) {
    copy(twin.screen, twin.screen.size(), frame.screen());
    copy(twin.attributes, twin.attributes.size(), frame.attributes());
    copy(twin.draws, twin.draws.size(), frame.draws());
}

}  // namespace plumb
