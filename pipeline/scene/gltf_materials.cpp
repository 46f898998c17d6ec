// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_materials.h"

#include "pipeline/scene/mesh.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

namespace plumb::gltf {
namespace {

constexpr double kMaxShininess = 1e6;

struct Factors {
    std::array<double, 4> base{1, 1, 1, 1};
    double metallic = 1, roughness = 1;
    std::array<double, 3> emissive{0, 0, 0};
    double emissiveStrength = 1;
    bool unlit = false;
};

void readSurface(const Value& value, const Reading& reading, Factors& factors) {
    if (const auto pbr = value.find("pbrMetallicRoughness")) {
        if (const auto factor = pbr->find("baseColorFactor")) factors.base = factor->numbers<4>(0, 1);
        if (const auto factor = pbr->find("metallicFactor")) factors.metallic = factor->number(0, 1);
        if (const auto factor = pbr->find("roughnessFactor")) factors.roughness = factor->number(0, 1);
        for (const char* texture : {"baseColorTexture", "metallicRoughnessTexture"})
            if (const auto used = pbr->find(texture)) reading.ignore(*used, "textures");
    }
    for (const char* texture : {"normalTexture", "occlusionTexture", "emissiveTexture"})
        if (const auto used = value.find(texture)) reading.ignore(*used, "textures");
    if (const auto factor = value.find("emissiveFactor")) factors.emissive = factor->numbers<3>(0, 1);
}

void readExtensions(const Value& value, const Reading& reading, Factors& factors, Material& material) {
    if (const auto extensions = value.find("extensions")) {
        factors.unlit = extensions->find("KHR_materials_unlit").has_value();
        if (const auto ior = extensions->find("KHR_materials_ior")) {
            material.refractiveIndex = 1.5f;
            // 0 stands for infinity in the extension; no ray of ours is refracted by it.
            if (const auto index = ior->find("ior")) material.refractiveIndex = float(std::max(1.0, index->number(0, 100)));
        }
        if (const auto strength = extensions->find("KHR_materials_emissive_strength"))
            if (const auto factor = strength->find("emissiveStrength")) factors.emissiveStrength = factor->number(0, kMaxCoordinate);
    }
    reading.ignoreExtensions(value, {"KHR_materials_unlit", "KHR_materials_ior", "KHR_materials_emissive_strength"});
}

// Metallic-roughness to Phong (docs/scene-format.md). The base colour is the diffuse colour whatever the metalness, because nothing is
// reflected here. n = 2 / a^2 - 2 with a = roughness^2; Ks is the height of that lobe, F0 (n + 2) / 8 = F0 / (4 a^2), at most 1.
void takeFactors(const Factors& factors, Material& material) {
    const double a = factors.roughness * factors.roughness;
    material.shininess = float(std::min(a > 0 ? 2 / (a * a) - 2 : kMaxShininess, kMaxShininess));
    for (int channel = 0; channel < 3; ++channel) {
        const double colour = factors.base[size_t(channel)];
        const double normalReflectance = 0.04 * (1 - factors.metallic) + colour * factors.metallic;  // F0; 0.04 is glTF B.2's
        const double peak = normalReflectance == 0 ? 0 : std::min(1.0, normalReflectance / (4 * a * a));
        material.diffuse[channel] = float(factors.unlit ? 0 : colour);
        material.ambient[channel] = float(factors.unlit ? 0 : 0.1 * colour);
        material.specular[channel] = float(factors.unlit ? 0 : peak);
        material.emission[channel] =
            float(std::min(1.0, (factors.unlit ? colour : 0) + factors.emissive[size_t(channel)] * factors.emissiveStrength));
    }
}

}  // namespace

void readMaterials(const Value& root, const Reading& reading) {
    reading.scene.materials.push_back(Material{});
    size_t i = 0;
    for (const Value& value : root.list("materials")) {
        Material material;
        material.name = fmt::format("material {}", i++);
        if (const auto name = value.find("name")) material.name = name->text();
        Factors factors;
        readSurface(value, reading, factors);
        readExtensions(value, reading, factors, material);
        if (const auto mode = value.find("alphaMode"))
            if (mode->text() != "OPAQUE") {
                reading.ignore(*mode, "alphaMode " + printable(mode->text(), 16));
                if (mode->text() == "BLEND") material.opacity = float(factors.base[3]);
            }
        if (const auto both = value.find("doubleSided"))
            if (both->boolean()) reading.scene.cullBackFaces = false;
        takeFactors(factors, material);
        reading.scene.materials.push_back(material);
    }
}

}  // namespace plumb::gltf
