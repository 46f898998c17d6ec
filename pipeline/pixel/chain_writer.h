// SPDX-License-Identifier: MIT
// Lines of a chain as they are written, and where two sides part.
#pragma once

#include "pipeline/pixel/line.h"
#include "pipeline/pixel/textbook.h"
#include "shaders/shared/ray.h"

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

inline std::vector<double> listOf(const glm::vec3& v) { return {double(v.x), double(v.y), double(v.z)}; }
inline std::vector<double> listOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

// Writes the lines of one chain in their order. A column without values keeps a reason.
class ChainWriter {
public:
    explicit ChainWriter(Chain& chain) : chain_(chain) {}

    // Begins a line. References stay valid until the next call.
    Line& add(const char* section, const std::string& name, const std::string& what);
    // Begins a line that the twin has.
    Line& twin(const char* section, const std::string& name, const std::string& what, std::vector<double> values,
               std::vector<std::string> how = {});
    Line* find(const std::string& name);
    // Fills the columns textbook and truth of the lines that have a value by their name.
    void take(const textbook::Values<float>& values);
    void take(const textbook::Values<Interval>& values);
    // States why every line without values of a side has none, unless the line said so itself.
    void close(const std::string& textbook, const std::string& device, const std::string& twin, const std::string& truth);
    // Finds the first line on which the device is not the twin, and the first decision of the twin that is not the truth's.
    void compare(bool deviceBounded);

private:
    Chain& chain_;
};

// Inputs of the illumination of one point by the passes.
struct LitPoint {
    gpu::Surface surface;
    gpu::MaterialRecord material;
    std::span<const gpu::LightRecord> lights;
    gpu::ShadeParts parts;
    double unit = 1;  // passes' lengths per scene unit
};
// Lines of section 16 for one point, by the passes' own functions. Names begin with `prefix`. Returns the sum.
gpu::Colour writeLit(ChainWriter& lines, const LitPoint& point, const std::string& prefix, const std::string& where);

}  // namespace plumb
