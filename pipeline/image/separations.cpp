// SPDX-License-Identifier: MIT
#include "host/error.h"
#include "pipeline/image/arrange.h"
#include "pipeline/scene/colour.h"

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace plumb {

const std::vector<std::string_view>& namesOf(Inks inks) {
    static const std::vector<std::string_view> kThree = {"cyan", "magenta", "yellow"}, kFour = {"cyan", "magenta", "yellow", "black"};
    return inks == Inks::cmy ? kThree : kFour;
}

Frame separationOf(const Frame& frame, Inks inks, size_t ink) {
    PLUMB_ASSERT(ink < namesOf(inks).size());
    Frame out;
    out.width = frame.width;
    out.height = frame.height;
    out.coveredPixels = frame.coveredPixels;
    out.rgba.reserve(frame.rgba.size());
    for (const uint32_t pixel : frame.rgba) {
        const Rgb8 rgb = {uint8_t(pixel), uint8_t(pixel >> 8), uint8_t(pixel >> 16)};
        uint32_t amount;
        if (inks == Inks::cmy) {
            amount = 255u - rgb[ink];
        } else {
            const Cmyk8 all = cmykFromRgb(rgb);
            amount = ink == 0 ? all.c : ink == 1 ? all.m : ink == 2 ? all.y : all.k;
        }
        out.rgba.push_back(amount * 0x010101u | 0xff000000u);
    }
    return out;
}

}  // namespace plumb
