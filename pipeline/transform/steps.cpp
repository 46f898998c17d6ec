// SPDX-License-Identifier: MIT
#include "pipeline/transform/steps.h"

#include <fmt/core.h>
#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {
namespace {

using glm::dvec2;
using glm::dvec3;

std::string call(const char* function, const dvec2& v) {
    return fmt::format("{}({}, {})", function, v.x + 0.0, v.y + 0.0);
}  // -0 becomes 0
std::string call(const char* function, const dvec3& v) { return fmt::format("{}({}, {}, {})", function, v.x + 0.0, v.y + 0.0, v.z + 0.0); }
std::string call(const char* function, double value) { return fmt::format("{}({})", function, value + 0.0); }

}  // namespace

Step2 translateStep(const dvec2& by) { return {call("T", by), translation(by)}; }
Step3 translateStep(const dvec3& by) { return {call("T", by), translation(by)}; }
Step2 scaleStep(const dvec2& factors) { return {call("S", factors), scaling(factors)}; }
Step3 scaleStep(const dvec3& factors) { return {call("S", factors), scaling(factors)}; }
Step2 rotateStep(double degrees) { return {call("R", degrees), rotation(degrees)}; }
Step3 rotateXStep(double degrees) { return {call("R_X", degrees), rotationX(degrees)}; }
Step3 rotateYStep(double degrees) { return {call("R_Y", degrees), rotationY(degrees)}; }
Step3 rotateZStep(double degrees) { return {call("R_Z", degrees), rotationZ(degrees)}; }
Step3 rotateStep(const dvec3& unitAxis, double degrees) {
    return {fmt::format("R({}; axis {}, {}, {})", degrees + 0.0, unitAxis.x + 0.0, unitAxis.y + 0.0, unitAxis.z + 0.0),
            rotation(unitAxis, degrees)};
}

std::vector<Step2> aboutSteps(const dvec2& point, const Step2& step) { return {translateStep(-point), step, translateStep(point)}; }
std::vector<Step3> aboutSteps(const dvec3& point, const Step3& step) { return {translateStep(-point), step, translateStep(point)}; }

std::vector<Step3> lineSteps(const dvec3& from, const dvec3& to, double degrees) {
    const auto m = lineRotation(from, to, degrees);
    if (!m) return {};
    const std::array<std::string, 7> names = {call("T", -from), "R_X(alpha)",  "R_Y(-beta)",   call("R_Z", degrees),
                                              "R_Y(beta)",      "R_X(-alpha)", call("T", from)};
    std::vector<Step3> steps;
    for (size_t i = 0; i < names.size(); ++i) steps.push_back({names[i], (*m)[i]});
    return steps;
}

}  // namespace plumb
