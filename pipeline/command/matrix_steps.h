// SPDX-License-Identifier: MIT
// Steps of `plumb matrix` as words of the command line: "rotate_z=90:about=3,2,0".
#pragma once

#include "pipeline/transform/steps.h"

#include <string>
#include <vector>

namespace plumb {

// Steps of words `what=value`, then `:part=value` for each further part. A step in place or about a line becomes its elementary matrices.
// Space: translate=X,Y,Z  scale=S|X,Y,Z[:about=P]  rotate_x|rotate_y|rotate_z=DEGREES[:about=P]
//        rotate=DEGREES:axis=V[:through=P]  rotate=DEGREES:from=P:to=P  matrix=16 numbers, rows of a matrix for column vectors
// Plane: translate=X,Y  scale=S|X,Y[:about=P]  rotate=DEGREES[:about=P]  matrix=9 numbers
// Throws Error(usage): one line with the number of the word, the word and the part that is refused.
std::vector<Step3> stepsInSpace(const std::vector<std::string>& words);
std::vector<Step2> stepsInPlane(const std::vector<std::string>& words);

}  // namespace plumb
