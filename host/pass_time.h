// SPDX-License-Identifier: MIT
// Time that a pass of a picture took. A type of its own, so that a picture's times can be read without what records them.
#pragma once

#include <cstdint>
#include <string>

namespace plumb {

struct PassTime {
    std::string pass;  // label given to dispatch(); equal labels of one frame are added up
    double ms = 0;     // device time stamps; host time when the device has none
    uint32_t dispatches = 0;
};

}  // namespace plumb
