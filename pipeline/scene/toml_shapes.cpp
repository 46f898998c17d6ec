// SPDX-License-Identifier: MIT
// Spheres and planes of a scene.
#include "pipeline/scene/toml_scene.h"

#include "pipeline/scene/affine.h"

#include <fmt/format.h>
#include <cmath>
#include <glm/glm.hpp>
#include <string>
#include <utility>

namespace plumb::scene_file {

using glm::dvec3;

void SceneFile::readSphere(const toml::table& table) {
    allowKeys(table, "[[sphere]]", {"name", "centre", "radius", "material"});
    SphereShape sphere;
    sphere.location = location(table);
    if (const auto* node = table.get("name")) sphere.name = stringOf(*node, "sphere.name");
    sphere.centre = vectorOf(required(table, "centre", "sphere"), "sphere.centre");
    const toml::node& radius = required(table, "radius", "sphere");
    sphere.radius = numberOf(radius, "sphere.radius");
    if (!(sphere.radius > 0)) refuse(radius, fmt::format("sphere.radius is {:g}, not above 0", sphere.radius));
    if (sphere.radius > kMaxCoordinate) refuse(radius, fmt::format("sphere.radius is {:g}, above 2^100", sphere.radius));
    if (const auto* node = table.get("material")) sphere.material = materialNamed(*node, "sphere.material");
    scene_.spheres.push_back(std::move(sphere));
}

void SceneFile::readPlane(const toml::table& table) {
    allowKeys(table, "[[plane]]", {"name", "point", "normal", "u", "u_range", "v_range", "two_sided", "material", "board"});
    PlaneShape plane;
    plane.location = location(table);
    if (const auto* node = table.get("name")) plane.name = stringOf(*node, "plane.name");
    plane.point = vectorOf(required(table, "point", "plane"), "plane.point");
    plane.normal = unitVector(axisOf(required(table, "normal", "plane"), "plane.normal"));
    // Axis u: the coordinate axis that is least along the normal, X first. Y = const has u = X and v = Z.
    dvec3 u(1, 0, 0);
    const dvec3 n = plane.normal;
    if (std::abs(n.x) > std::abs(n.y) || std::abs(n.x) > std::abs(n.z))
        u = std::abs(n.y) <= std::abs(n.z) ? dvec3(0, 1, 0) : dvec3(0, 0, 1);
    const auto* uNode = table.get("u");
    if (uNode) u = unitVector(axisOf(*uNode, "plane.u"));
    u -= n * glm::dot(n, u);
    if (largestMagnitude(u) < kMinCross) refuse(uNode ? *uNode : *table.get("normal"), "plane.u is parallel to plane.normal");
    plane.u = unitVector(u);
    plane.v = glm::cross(plane.u, n);
    const auto range = [&](const char* key, double& least, double& most) {
        const auto* node = table.get(key);
        if (!node) return;
        const std::string field = std::string("plane.") + key;
        const toml::array& ends = arrayOf(*node, field);
        if (ends.size() != 2) refuse(*node, fmt::format("{} has {} numbers, not 2", field, ends.size()));
        least = numberOf(ends[0], field + "[0]", -kMaxCoordinate, kMaxCoordinate);
        most = numberOf(ends[1], field + "[1]", -kMaxCoordinate, kMaxCoordinate);
        if (!(least < most)) refuse(*node, fmt::format("{} is empty: {:g} is not below {:g}", field, least, most));
    };
    range("u_range", plane.uMin, plane.uMax);
    range("v_range", plane.vMin, plane.vMax);
    if (const auto* node = table.get("two_sided")) plane.twoSided = booleanOf(*node, "plane.two_sided");
    if (const auto* node = table.get("material")) plane.material = materialNamed(*node, "plane.material");
    if (const auto* node = table.get("board")) {
        const toml::table& board = tableOf(*node, "plane.board");
        allowKeys(board, "plane.board", {"square", "material", "mirrored"});
        const toml::node& square = required(board, "square", "plane.board");
        plane.square = numberOf(square, "plane.board.square");
        if (!(plane.square > 0)) refuse(square, fmt::format("plane.board.square is {:g}, not above 0", plane.square));
        if (plane.square > kMaxCoordinate) refuse(square, fmt::format("plane.board.square is {:g}, above 2^100", plane.square));
        plane.otherMaterial = materialNamed(required(board, "material", "plane.board"), "plane.board.material");
        if (const auto* mirrored = board.get("mirrored")) plane.mirrored = booleanOf(*mirrored, "plane.board.mirrored");
    }
    scene_.planes.push_back(std::move(plane));
}

}  // namespace plumb::scene_file
