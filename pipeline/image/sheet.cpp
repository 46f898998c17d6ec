// SPDX-License-Identifier: MIT
#include "host/error.h"
#include "pipeline/image/image.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plumb {

Frame contactSheet(std::span<const Frame> frames, uint32_t columns, uint32_t background, std::array<float, 3> backgroundLinear) {
    PLUMB_ASSERT(!frames.empty());
    const uint32_t cellWidth = frames[0].width, cellHeight = frames[0].height;
    bool linear = true;
    for (const Frame& frame : frames) {
        PLUMB_ASSERT(frame.width == cellWidth && frame.height == cellHeight);
        linear = linear && !frame.linear.empty();
    }
    const auto count = uint32_t(frames.size());
    if (columns == 0)
        for (columns = 1; columns * columns < count;) ++columns;
    const uint32_t rows = (count + columns - 1) / columns;
    Frame sheet;
    sheet.width = cellWidth * columns;
    sheet.height = cellHeight * rows;
    sheet.rgba.assign(size_t(sheet.width) * sheet.height, background);
    if (linear) {
        sheet.linear.resize(sheet.rgba.size() * 3);
        for (size_t i = 0; i < sheet.linear.size(); ++i) sheet.linear[i] = backgroundLinear[i % 3];
    }
    for (uint32_t i = 0; i < count; ++i) {
        sheet.coveredPixels += frames[i].coveredPixels;
        for (uint32_t y = 0; y < cellHeight; ++y) {
            const size_t from = size_t(y) * cellWidth;
            const size_t to = (size_t(i / columns) * cellHeight + y) * sheet.width + size_t(i % columns) * cellWidth;
            std::copy_n(frames[i].rgba.begin() + ptrdiff_t(from), cellWidth, sheet.rgba.begin() + ptrdiff_t(to));
            if (linear)
                std::copy_n(frames[i].linear.begin() + ptrdiff_t(from * 3), size_t(cellWidth) * 3,
                            sheet.linear.begin() + ptrdiff_t(to * 3));
        }
    }
    return sheet;
}

}  // namespace plumb
