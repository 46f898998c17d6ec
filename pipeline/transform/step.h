// SPDX-License-Identifier: MIT
// Elementary transform of a chain.
#pragma once

#include <string>

namespace plumb {

template <class Matrix>
struct Step {
    std::string name;  // as people write it: "T(1, 2, 3)", "R_Z(90)"
    Matrix matrix;     // elementary, for column vectors
};

}  // namespace plumb
