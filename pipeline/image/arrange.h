// SPDX-License-Identifier: MIT
// Pictures made of pictures: parts of a frame, interlaced fields, stereo pairs in one picture, separations for print.
#pragma once

#include "pipeline/render/frame.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace plumb {

// Columns [firstColumn, + columns) of every plane that is there. coveredPixels follows the object plane (without one: all or none, as in
// `frame`).
Frame columnsOf(const Frame& frame, uint32_t firstColumn, uint32_t columns);

// Field of a picture. Lines are counted from 1 at the top, as in television: the odd field (shown first) has lines 1, 3, 5, ..., the even
// one 2, 4, 6, ... A picture of H lines has (H + 1) / 2 odd and H / 2 even ones.
enum class Field { odd, even };
Frame fieldOf(const Frame& frame, Field field);
Frame interlaced(const Frame& odd, const Frame& even);  // picture with these two fields

// Anaglyph: red as the left eye sees it, green and blue as the right eye does. Bytes are encoded channel by channel, so the linear plane
// and the encoded bytes agree. Colour planes only; a pixel is covered where either eye sees something (needs the object planes).
Frame anaglyphOf(const Frame& left, const Frame& right);

// Separations: one picture an ink, from the encoded bytes. Every channel of a pixel holds the share of ink: 0 none, 255 full.
enum class Inks { cmy, cmyk };
const std::vector<std::string_view>& namesOf(Inks);  // cyan, magenta, yellow(, black), in this order
Frame separationOf(const Frame& frame, Inks inks, size_t ink);

}  // namespace plumb
