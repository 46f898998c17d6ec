// SPDX-License-Identifier: MIT
#include "pipeline/scene/toml_scene.h"

#include "pipeline/scene/area_light.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb::scene_file {

void SceneFile::readLight(const toml::table& table) {
    allowKeys(table, "[[light]]", {"type", "direction", "position", "edge_u", "edge_v", "points", "intensity", "attenuation"});
    enum class Kind { directional, point, area };
    const Kind kind = choiceOf<Kind>(required(table, "type", "light"), "light.type",
                                     {{"directional", Kind::directional}, {"point", Kind::point}, {"area", Kind::area}});
    if (kind == Kind::directional)
        for (const char* key : {"position", "attenuation"})
            if (const auto* node = table.get(key)) refuse(*node, fmt::format("light.{} needs type = \"point\"", key));
    if (kind != Kind::directional)
        if (const auto* node = table.get("direction")) refuse(*node, "light.direction needs type = \"directional\"");
    if (kind != Kind::area)
        for (const char* key : {"edge_u", "edge_v", "points"})
            if (const auto* node = table.get(key)) refuse(*node, fmt::format("light.{} needs type = \"area\"", key));
    Light light;
    light.location = location(table);
    light.directional = kind == Kind::directional;
    if (const auto* node = table.get("intensity")) light.intensity = colourOf(*node, "light.intensity", kMaxCoordinate);
    if (const auto* node = table.get("attenuation"))
        light.attenuation =
            choiceOf<Attenuation>(*node, "light.attenuation",
                                  {{"none", Attenuation::none}, {"1/d", Attenuation::inverse}, {"1/d^2", Attenuation::inverseSquare}});
    if (light.directional) light.direction = axisOf(required(table, "direction", "directional light"), "light.direction");
    if (kind == Kind::point) light.position = vectorOf(required(table, "position", "point light"), "light.position");
    if (kind == Kind::area)
        readArea(table, light);
    else
        scene_.lights.push_back(light);
}

// Reads an area light, which becomes point lights: k along a line, m times n on a rectangle.
void SceneFile::readArea(const toml::table& table, const Light& light) {
    AreaLight area;
    area.intensity = light.intensity;
    area.attenuation = light.attenuation;
    area.corner = vectorOf(required(table, "position", "area light"), "light.position");
    area.u = axisOf(required(table, "edge_u", "area light"), "light.edge_u");
    const auto* second = table.get("edge_v");
    if (second) area.v = axisOf(*second, "light.edge_v");
    const toml::node& points = required(table, "points", "area light");
    if (second) {
        const toml::array& counts = arrayOf(points, "light.points");
        if (counts.size() != 2)
            refuse(points, fmt::format("light.points has {} numbers, not 2: along edge_u and along edge_v", counts.size()));
        area.pointsU = uint32_t(integerOf(counts[0], "light.points[0]", 1, kMaxAreaPoints));
        area.pointsV = uint32_t(integerOf(counts[1], "light.points[1]", 1, kMaxAreaPoints));
    } else {
        area.pointsU = uint32_t(integerOf(points, "light.points", 1, kMaxAreaPoints));
    }
    if (area.pointsU * area.pointsV > kMaxAreaPoints)
        refuse(points,
               fmt::format("light.points makes {} points; an area light has at most {}", area.pointsU * area.pointsV, kMaxAreaPoints));
    for (Light& point : pointsOf(area)) {
        point.location = light.location;
        if (!(std::max({std::abs(point.position.x), std::abs(point.position.y), std::abs(point.position.z)}) <= kMaxCoordinate))
            refuse(table, "light: a point of it has a coordinate above 2^100");
        scene_.lights.push_back(point);
    }
}

}  // namespace plumb::scene_file
