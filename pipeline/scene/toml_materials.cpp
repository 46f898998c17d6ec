// SPDX-License-Identifier: MIT
#include "pipeline/scene/toml_scene.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::scene_file {

namespace {

constexpr double kMaxShininess = 1e6;
// Largest sum of weights. Weights that add up to 1 in decimals may exceed it by a rounding of each.
constexpr double kLargestWeightSum = 1 + 4 * 0x1p-53;

}  // namespace

void SceneFile::readMaterial(const toml::table& table) {
    allowKeys(
        table, "[[material]]",
        {"name", "ambient", "diffuse", "specular", "emission", "shininess", "opacity", "ior", "density", "reflect", "transmit", "local"});
    const toml::node& nameNode = required(table, "name", "material");
    Material material;
    material.name = stringOf(nameNode, "material.name");
    const bool restatesDefault = material.name == "default" && !defaultStated_;
    if (materials_.contains(material.name) && !restatesDefault)
        refuse(nameNode, fmt::format("material.name '{}' is taken", printable(material.name, 64)));
    const auto colour = [&](const char* key, glm::vec3& into) {
        if (const auto* node = table.get(key)) into = colourOf(*node, std::string("material.") + key, 1);
    };
    colour("ambient", material.ambient);
    colour("diffuse", material.diffuse);
    colour("specular", material.specular);
    colour("emission", material.emission);
    if (const auto* node = table.get("shininess")) material.shininess = float(numberOf(*node, "material.shininess", 0, kMaxShininess));
    if (const auto* node = table.get("opacity")) material.opacity = float(numberOf(*node, "material.opacity", 0, 1));
    if (const auto* node = table.get("ior")) material.refractiveIndex = float(numberOf(*node, "material.ior", 0.01, 100));
    if (const auto* node = table.get("density")) {
        if (table.contains("ior")) refuse(*node, "material.density beside material.ior: they are two names of one number");
        material.refractiveIndex = float(numberOf(*node, "material.density", 0.01, 100));
    }
    readWeights(table, material);
    if (restatesDefault) {
        scene_.materials[0] = material;
        defaultStated_ = true;
        return;
    }
    materials_[material.name] = uint32_t(scene_.materials.size());
    scene_.materials.push_back(material);
}

// Reads the shares of the mirrored, the refracted and the local colour. Opacity below 1 lets its rest pass unless `transmit` says
// otherwise.
void SceneFile::readWeights(const toml::table& table, Material& material) const {
    const auto weight = [&](const char* key, double fallback) {
        const auto* node = table.get(key);
        return node ? numberOf(*node, std::string("material.") + key, 0, 1) : fallback;
    };
    const double reflect = weight("reflect", 0), transmit = weight("transmit", 1.0 - double(material.opacity));
    const double local = weight("local", std::max(0.0, 1 - reflect - transmit));
    if (!(reflect + transmit + local <= kLargestWeightSum))
        refuse(table, fmt::format("material '{}': reflect {:g}, transmit {:g} and local {:g} add up to more than 1",
                                  printable(material.name, 64), reflect, transmit, local));
    material.reflect = float(reflect);
    material.transmit = float(transmit);
    material.local = float(local);
    material.statesRays = reflect > 0 || (table.get("transmit") && transmit > 0);
}

uint32_t SceneFile::materialNamed(const toml::node& node, const std::string& field) const {
    const std::string name = stringOf(node, field);
    const auto found = materials_.find(name);
    if (found != materials_.end()) return found->second;
    std::vector<std::string_view> known;
    for (const auto& [key, index] : materials_) {
        (void)index;
        known.push_back(key);
    }
    refuse(node, fmt::format("{} names the unknown material '{}'{}", field, printable(name, 64), suggestion(name, known)));
}

}  // namespace plumb::scene_file
