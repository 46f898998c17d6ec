// SPDX-License-Identifier: MIT
// A line of an opened pixel: one number, vector or matrix of the lecture notes' chain, as each side has it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Values of one side. A side that does not compute a value says why, and has none.
struct Column {
    std::vector<double> values;  // exact: float32 and integers are binary64 numbers
    std::string why;             // reason why there are no values; empty where there are
    bool has() const { return !values.empty(); }
};

struct Line {
    std::string section;  // of the lecture notes; empty: a step of the passes that they do not have
    std::string name;     // unique in a chain; other lines' expressions use it
    std::string what;     // one phrase, with the unit
    // One expression a value of the twin, in names of lines before it; empty: the value is given. Every +, -, *, / is rounded to float32, but
    // for those in exact(...), which round once at its end where it stands inside a float32 operation.
    std::vector<std::string> how;
    Column textbook, device, twin, truth;
    std::vector<double> bound;  // of the truth's values, each within it
    bool decision = false;      // true: 1 is yes and 0 is no
};

// One polygon at one pixel, from its vertices to what it leaves there.
struct Chain {
    std::string title;
    uint32_t object = 0, face = 0, triangle = 0;  // object of the scene, face of its mesh, triangle of its mesh
    std::vector<Line> lines;
    // First line on which two sides part. Empty: none does.
    std::string deviceParts;  // the device from the twin, as equal bits or beyond the bound of its own functions
    std::string truthParts;   // a decision of the twin from the truth's
};

// Triangle that covers the pixel's sample on some side.
struct Candidate {
    uint32_t object = 0, face = 0, triangle = 0;
    Column twinZ, truthZ;  // n / w; larger is nearer
    double truthBound = 0;
    bool twinSees = false, deviceSees = false, truthSees = false;  // the nearest on that side
    std::string lost;                                              // why the twin shows another; empty: it shows this
};

// What a side shows at a pixel.
struct Shown {
    bool there = false;  // false: that side was not asked, `why` says the reason
    std::string why;
    uint32_t object = 0xffffffffu, face = 0xffffffffu;
    double depth = 0, linear[3] = {0, 0, 0}, linearBound[3] = {0, 0, 0};
    double code[3] = {0, 0, 0}, codeBound[3] = {0, 0, 0};  // truth: not rounded
};

struct OpenedPixel {
    uint32_t x = 0, y = 0;
    bool pixel = true;  // false: a polygon or a vertex is opened without one
    std::string technique;
    std::vector<Chain> chains;
    std::vector<Candidate> candidates;
    Shown device, twin, truth;
    std::vector<std::string> explains;  // one sentence each: where sides part, or that they do not
};

}  // namespace plumb
