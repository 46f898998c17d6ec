// SPDX-License-Identifier: MIT
// Extremes along which a scene is driven: one row an axis and direction, each with the value that it moves, how far, and how.
#pragma once

#include "pipeline/render/render.h"
#include "pipeline/scene/scene.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace plumb::stress {

// A picture to be drawn. The scene has a camera.
struct Picture {
    Scene scene;
    RenderRequest request;
};

// Furthest value of an axis, and what sets it.
struct Reach {
    double value = 0;
    std::string why;  // noun phrase: "the least field of view that the format takes"
};

struct AxisRow {
    const char* name;                       // word of --axis; the two directions of an axis share it
    const char* title;                      // what is moved, for people
    const char* unit;                       // unit of the values, printed behind them; "": scene units, or a plain number
    bool rises;                             // true: it gets harder as the value rises
    bool whole;                             // true: values are whole numbers
    std::string (*absent)(const Picture&);  // reason why the axis does not apply to the picture; "": it does
    // Value in the picture as it is. None: the picture has no such thing, and the axis adds it.
    std::optional<double> (*present)(const Picture&);
    double (*from)(const Picture&);  // value that powers of two are counted from; the first one tried lies a factor 2 beyond it
    Reach (*reach)(const Picture&);
    // Value at which the axis is as easy as can be. Null: nothing easier than the present value can be drawn.
    double (*mildest)(const Picture&);
    void (*move)(Picture&, double value);  // gives the picture that value
};

// Every row, in the order in which margins are printed.
std::span<const AxisRow> axisRows();
// Rows of the axes with these names, in the order of the table; all rows for no name. Throws Error(usage) with the accepted names.
std::vector<const AxisRow*> rowsOf(const std::vector<std::string>& names);

}  // namespace plumb::stress
