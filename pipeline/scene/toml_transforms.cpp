// SPDX-License-Identifier: MIT
// Transforms of an object, in order of application.
#include "pipeline/scene/toml_scene.h"

#include "pipeline/scene/affine.h"

#include <fmt/format.h>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb::scene_file {

using glm::dmat4;
using glm::dvec3;

// Reads a rotation: about an axis through a point (Rodrigues), or about the line through two points (the notes' seven matrices).
SceneFile::Placement SceneFile::readRotate(const toml::node& node, const std::string& field) const {
    const toml::table& rotate = tableOf(node, field);
    allowKeys(rotate, field, {"axis", "degrees", "through", "from", "to"});
    const double degrees = numberOf(required(rotate, "degrees", field), field + ".degrees");
    if (const auto* fromNode = rotate.get("from")) {
        for (const char* key : {"axis", "through"})
            if (const auto* other = rotate.get(key)) refuse(*other, fmt::format("{0}.{1} beside {0}.from", field, key));
        const dvec3 from = vectorOf(*fromNode, field + ".from");
        const toml::node& toNode = required(rotate, "to", field);
        Placement placement{dmat4(1.0), lineSteps(from, vectorOf(toNode, field + ".to"), degrees)};
        if (placement.steps.empty()) refuse(toNode, field + ".to is the same point as from: two equal points have no line");
        for (const Step3& step : placement.steps) placement.matrix = step.matrix * placement.matrix;
        return placement;
    }
    if (const auto* to = rotate.get("to")) refuse(*to, fmt::format("{0}.to without {0}.from", field));
    const dvec3 axis = unitVector(axisOf(required(rotate, "axis", field), field + ".axis"));
    const Step3 step = rotateStep(axis, degrees);
    const auto* through = rotate.get("through");
    if (!through) return {step.matrix, {step}};
    const dvec3 point = vectorOf(*through, field + ".through");
    return {about(point, step.matrix), aboutSteps(point, step)};
}

// Centre of `about`: a point, or "centre", the visual centre of the object's mesh as the transforms before this one leave it.
dvec3 SceneFile::centreOf(const toml::node& about, const std::string& field, uint32_t mesh, const dmat4& before) const {
    if (!about.is_string()) return vectorOf(about, field);
    const std::string word = stringOf(about, field);
    if (word != "centre" && word != "center")
        refuse(about, fmt::format("{} is '{}', not a point or \"centre\"", field, printable(word, 40)));
    if (mesh == kNone) refuse(about, field + " is the centre of an object without a mesh");
    const TriangleMesh& of = scene_.meshes[mesh];
    if (of.positions.empty()) refuse(about, field + " is the centre of a mesh without vertices");
    std::vector<dvec3> points;
    points.reserve(of.positions.size());
    for (const glm::vec3& p : of.positions) points.push_back(transformed(before, of.origin + dvec3(p)));
    return visualCentre(std::span<const dvec3>(points));
}

SceneFile::Placement SceneFile::readTransform(const toml::table& table, const std::string& field, uint32_t mesh,
                                              const dmat4& before) const {
    allowKeys(table, field, {"translate", "rotate_x", "rotate_y", "rotate_z", "rotate", "scale", "matrix", "about"});
    const toml::node* aboutNode = table.get("about");
    if (table.size() != (aboutNode ? 2u : 1u))
        refuse(table, fmt::format("{} holds {} transforms; write one a table, in order of application", field,
                                  table.size() - (aboutNode ? 1 : 0)));
    Step3 step;
    bool canBeAbout = true;
    if (const auto* node = table.get("translate")) {
        step = translateStep(vectorOf(*node, field + ".translate"));
        canBeAbout = false;
    } else if (const auto* node = table.get("rotate_x")) {
        step = rotateXStep(numberOf(*node, field + ".rotate_x"));
    } else if (const auto* node = table.get("rotate_y")) {
        step = rotateYStep(numberOf(*node, field + ".rotate_y"));
    } else if (const auto* node = table.get("rotate_z")) {
        step = rotateZStep(numberOf(*node, field + ".rotate_z"));
    } else if (const auto* node = table.get("rotate")) {
        if (aboutNode) refuse(*aboutNode, field + ".about goes with rotate_x, rotate_y, rotate_z and scale");
        return readRotate(*node, field + ".rotate");
    } else if (const auto* node = table.get("scale")) {
        const dvec3 factors = node->is_array() ? vectorOf(*node, field + ".scale")
                                               : dvec3(numberOf(*node, field + ".scale", -kMaxCoordinate, kMaxCoordinate));
        step = scaleStep(factors);
    } else {
        const toml::node& matrix = *table.get("matrix");
        const std::string name = field + ".matrix";
        const toml::array& entries = arrayOf(matrix, name);
        if (entries.size() != 16) refuse(matrix, fmt::format("{} has {} numbers, not 16", name, entries.size()));
        double rows[16];
        for (size_t i = 0; i < 16; ++i) rows[i] = numberOf(entries[i], fmt::format("{}[{}]", name, i), -kMaxCoordinate, kMaxCoordinate);
        if (rows[12] != 0 || rows[13] != 0 || rows[14] != 0 || rows[15] != 1)
            refuse(matrix, name + ": the last row is not 0, 0, 0, 1 (rows of a matrix for column vectors)");
        step = matrixStep(fromRows(rows));
        canBeAbout = false;
    }
    if (!aboutNode) return {step.matrix, {step}};
    if (!canBeAbout) refuse(*aboutNode, field + ".about goes with rotate_x, rotate_y, rotate_z and scale");
    const dvec3 point = centreOf(*aboutNode, field + ".about", mesh, before);
    return {about(point, step.matrix), aboutSteps(point, step)};
}

// Reads transforms in order of application: the first of the list acts on the object first.
SceneFile::Placement SceneFile::readTransforms(const toml::node& node, const std::string& field, uint32_t mesh) const {
    Placement all;
    size_t i = 0;
    for (const toml::node& element : arrayOf(node, field)) {
        const std::string name = fmt::format("{}[{}]", field, i++);
        const toml::table& table = tableOf(element, name);
        if (table.empty() || (table.size() == 1 && table.contains("about"))) refuse(element, name + " holds no transform");
        const Placement next = readTransform(table, name, mesh, all.matrix);
        all.matrix = next.matrix * all.matrix;
        all.steps.insert(all.steps.end(), next.steps.begin(), next.steps.end());
        if (!entriesUsable(all.matrix)) refuse(element, name + ": the matrix so far has entries above 2^100");
    }
    return all;
}

}  // namespace plumb::scene_file
