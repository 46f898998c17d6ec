// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_materials.h"

#include "host/error.h"
#include "pipeline/scene/mesh.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>

namespace plumb::gltf {
namespace {

constexpr double kMaxShininess = 1e6;

struct Factors {
    std::array<double, 4> base{1, 1, 1, 1};  // base colour, or the diffuse one of specular-glossiness
    double metallic = 1, roughness = 1;
    std::optional<std::array<double, 3>> specular;  // F0 of specular-glossiness
    std::array<double, 3> emissive{0, 0, 0};
    double emissiveStrength = 1;
    bool unlit = false, baseTexture = false;
};

// Factor of [least, most]; one outside is clamped and named, since exporters write 1.00000012.
double factor(const Value& value, double least, double most, const Reading& reading) {
    const double stated = value.number(std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max());
    const double inside = std::clamp(stated, least, most);
    if (inside != stated)
        reading.tolerance.pass(
            "it is clamped", [&] { return value.location(); },
            [&] { return fmt::format("is {}, outside {:g} to {:g}; ", stated, least, most); });
    return inside;
}

template <size_t N>
std::array<double, N> factors(const Value& value, const Reading& reading) {
    std::array<double, N> all;
    for (size_t i = 0; i < N; ++i) all[i] = factor(value.elementOf(i, N), 0, 1, reading);
    return all;
}

void readSurface(const Value& value, const Reading& reading, Factors& of) {
    if (const auto pbr = value.find("pbrMetallicRoughness")) {
        if (const auto stated = pbr->find("baseColorFactor")) of.base = factors<4>(*stated, reading);
        if (const auto stated = pbr->find("metallicFactor")) of.metallic = factor(*stated, 0, 1, reading);
        if (const auto stated = pbr->find("roughnessFactor")) of.roughness = factor(*stated, 0, 1, reading);
        for (const char* texture : {"baseColorTexture", "metallicRoughnessTexture"})
            if (const auto used = pbr->find(texture)) reading.ignore(*used, "textures");
        of.baseTexture = pbr->find("baseColorTexture").has_value();
    }
    for (const char* texture : {"normalTexture", "occlusionTexture", "emissiveTexture"})
        if (const auto used = value.find(texture)) reading.ignore(*used, "textures");
    if (const auto stated = value.find("emissiveFactor")) of.emissive = factors<3>(*stated, reading);
    if (const auto texture = value.find("emissiveTexture"); texture && of.emissive != std::array<double, 3>{0, 0, 0}) {
        // The texture carries the picture, mostly black, and its factor is white: alone it would hide every shape.
        reading.pass(*texture, "is not drawn; the emissive factor is left out with it");
        of.emissive = {0, 0, 0};
    }
}

// KHR_materials_pbrSpecularGlossiness, whose values go before those of metallic-roughness.
void readSpecularGlossiness(const Value& value, const Reading& reading, Factors& of) {
    of.base = {1, 1, 1, 1};
    of.specular = {1, 1, 1};
    double glossiness = 1;
    if (const auto stated = value.find("diffuseFactor")) of.base = factors<4>(*stated, reading);
    if (const auto stated = value.find("specularFactor")) of.specular = factors<3>(*stated, reading);
    if (const auto stated = value.find("glossinessFactor")) glossiness = factor(*stated, 0, 1, reading);
    of.roughness = 1 - glossiness;
    for (const char* texture : {"diffuseTexture", "specularGlossinessTexture"})
        if (const auto used = value.find(texture)) reading.ignore(*used, "textures");
    of.baseTexture = value.find("diffuseTexture").has_value();
}

void readExtensions(const Value& value, const Reading& reading, Factors& of, Material& material) {
    if (const auto extensions = value.find("extensions")) {
        if (const auto unlit = extensions->find("KHR_materials_unlit")) {
            of.unlit = !of.baseTexture;
            if (of.baseTexture)
                reading.pass(*unlit, "its texture is not drawn; the material is lit, since its factor alone shows no shape");
        }
        if (const auto ior = extensions->find("KHR_materials_ior")) {
            material.refractiveIndex = 1.5f;
            // 0 stands for infinity in the extension; no ray of ours is refracted by it.
            if (const auto index = ior->find("ior"); index && index->number(0, kMaxCoordinate) == 0)
                material.refractiveIndex = 1;
            else if (index)
                material.refractiveIndex = float(factor(*index, 1, kMaxCoordinate, reading));
        }
        if (const auto strength = extensions->find("KHR_materials_emissive_strength"))
            if (const auto stated = strength->find("emissiveStrength")) of.emissiveStrength = factor(*stated, 0, kMaxCoordinate, reading);
        if (const auto gloss = extensions->find("KHR_materials_pbrSpecularGlossiness")) readSpecularGlossiness(*gloss, reading, of);
    }
    reading.ignoreExtensions(
        value, {"KHR_materials_unlit", "KHR_materials_ior", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness"});
}

// Metallic-roughness to Phong (docs/scene-format.md). The base colour is the diffuse colour whatever the metalness, because nothing is
// reflected here. n = 2 / a^2 - 2 with a = roughness^2; Ks is the height of that lobe, F0 (n + 2) / 8 = F0 / (4 a^2), at most 1.
void takeFactors(const Factors& of, Material& material) {
    const double a = of.roughness * of.roughness;
    material.shininess = float(std::min(a > 0 ? 2 / (a * a) - 2 : kMaxShininess, kMaxShininess));
    for (int channel = 0; channel < 3; ++channel) {
        const double colour = of.base[size_t(channel)];
        // F0; 0.04 is glTF B.2's
        const double normalReflectance = of.specular ? (*of.specular)[size_t(channel)] : 0.04 * (1 - of.metallic) + colour * of.metallic;
        const double peak = normalReflectance == 0 ? 0 : std::min(1.0, normalReflectance / (4 * a * a));
        material.diffuse[channel] = float(of.unlit ? 0 : colour);
        material.ambient[channel] = float(of.unlit ? 0 : 0.1 * colour);
        material.specular[channel] = float(of.unlit ? 0 : peak);
        material.emission[channel] = float(std::min(1.0, (of.unlit ? colour : 0) + of.emissive[size_t(channel)] * of.emissiveStrength));
    }
}

void readMaterial(const Value& value, const Reading& reading, Material& material) {
    if (const auto name = value.find("name")) material.name = name->text();
    Factors of;
    readSurface(value, reading, of);
    readExtensions(value, reading, of, material);
    if (const auto mode = value.find("alphaMode"))
        if (mode->text() != "OPAQUE") {
            reading.ignore(*mode, "alphaMode " + printable(mode->text(), 16));
            if (mode->text() == "BLEND") material.opacity = float(of.base[3]);
        }
    if (const auto both = value.find("doubleSided"))
        if (both->boolean()) reading.scene.cullBackFaces = false;
    takeFactors(of, material);
}

}  // namespace

Materials::Materials(const Value& root, const Reading& reading) : reading_(reading) {
    std::vector<Material>& materials = reading.scene.materials;
    materials.push_back(Material{});
    size_t i = 0;
    for (const Value& value : root.list("materials")) {
        Material material;
        material.name = fmt::format("material {}", i++);
        try {
            readMaterial(value, reading, material);
        } catch (const Error&) {
            if (reading.options.strict) throw;
            bad_.push_back({value, uint32_t(materials.size()), std::current_exception()});
        }
        materials.push_back(material);
    }
}

uint32_t Materials::of(const Value& primitive) {
    const auto stated = primitive.find("material");
    if (!stated) return 0;
    const uint32_t index = uint32_t(stated->index(reading_.scene.materials.size() - 1, "materials")) + 1;
    for (const Bad& bad : bad_)
        if (bad.index == index) std::rethrow_exception(bad.refusal);
    return index;
}

void Materials::passUnread() const {
    for (const Bad& bad : bad_) reading_.pass(bad.at, "cannot be read; nothing that is drawn has this material");
}

}  // namespace plumb::gltf
