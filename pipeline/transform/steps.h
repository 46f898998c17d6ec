// SPDX-License-Identifier: MIT
// Elementary transforms with their names, as steps of a chain. Numbers in names are the shortest that read back as the same double.
#pragma once

#include "pipeline/transform/chain.h"

#include <glm/glm.hpp>
#include <vector>

namespace plumb {

using Step2 = Step<glm::dmat3>;
using Step3 = Step<glm::dmat4>;

Step2 translateStep(const glm::dvec2& by);
Step3 translateStep(const glm::dvec3& by);
Step2 scaleStep(const glm::dvec2& factors);
Step3 scaleStep(const glm::dvec3& factors);
Step2 rotateStep(double degrees);
Step3 rotateXStep(double degrees);
Step3 rotateYStep(double degrees);
Step3 rotateZStep(double degrees);
Step3 rotateStep(const glm::dvec3& unitAxis, double degrees);
template <class Matrix>
Step<Matrix> matrixStep(const Matrix& m) {
    return {"matrix", m};
}

// Steps of an in-place transform: T(-point), the step, T(point).
std::vector<Step2> aboutSteps(const glm::dvec2& point, const Step2&);
std::vector<Step3> aboutSteps(const glm::dvec3& point, const Step3&);
// Steps of lineRotation(), seven; empty when the points are the same.
std::vector<Step3> lineSteps(const glm::dvec3& from, const glm::dvec3& to, double degrees);

}  // namespace plumb
