// SPDX-License-Identifier: MIT
#include "pipeline/truth/illumination.h"

#include "pipeline/scene/flattened.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb::truth {

namespace {

double lengthOf(const glm::dvec3& v) { return std::hypot(v.x, v.y, v.z); }
double along(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Unit vector; 0 for the zero vector.
glm::dvec3 unit(const glm::dvec3& v) {
    const double length = lengthOf(v);
    return length > 0 ? v / length : glm::dvec3(0);
}

}  // namespace

Illumination::Illumination(const Scene& scene, const Geometry& geometry) : scene_(scene), geometry_(geometry) {
    for (const Light& light : scene.lights) {
        Lamp lamp;
        lamp.directional = light.directional;
        lamp.position = light.directional ? unit(light.direction) : light.position - geometry.pinhole().eye;
        lamp.intensity = glm::dvec3(light.intensity);
        if (!light.directional)
            lamp.power = light.attenuation == Attenuation::inverse ? 1 : light.attenuation == Attenuation::inverseSquare ? 2 : 0;
        lamps_.push_back(lamp);
    }
    for (const Object& object : scene.objects) {
        // Inverse transpose up to a positive factor: cofactors times the determinant's sign.
        glm::dmat3 m(object.worldFromObject), n;
        double largest = 0;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(m[c][r]));
        if (largest > 0) m /= largest;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) {
                const int c1 = (c + 1) % 3, c2 = (c + 2) % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3;
                n[c][r] = m[c1][r1] * m[c2][r2] - m[c1][r2] * m[c2][r1];
            }
        if (mirrors(object.worldFromObject)) n = -n;
        normalFromObject_.push_back(n);
    }
}

Illumination::Seen Illumination::at(uint32_t index, double x, double y) const {
    const Triangle& t = geometry_.triangles()[index];
    const TriangleMesh& mesh = scene_.meshes[scene_.objects[t.object].mesh];
    double weight[3], sum = 0;
    for (int i = 0; i < 3; ++i) {
        weight[i] = std::max(0.0, t.a[i] * x + t.b[i] * y + t.c[i]);  // a sample on an edge must not get a negative weight
        sum += weight[i];
    }
    glm::dvec3 normal(0), position(0);
    double w = 0;
    for (size_t i = 0; i < 3; ++i) {
        const double share = sum > 0 ? weight[i] / sum : 1.0 / 3;
        const Corner corner = geometry_.corner(t.object, t.vertex[i]);
        normal += share * glm::dvec3(mesh.normals[t.vertex[i]]);
        position += share * corner.fromEye;
        w += share * corner.w.value;
    }
    const uint32_t material = mesh.faceMaterial[mesh.triangles[t.triangle].face];
    const glm::dvec3 towardViewer = scene_.distantViewer.value_or(false) ? -unit(scene_.camera->forward) : unit(-position);
    return {colourOf(material, position, unit(normalFromObject_[t.object] * normal), towardViewer), w};
}

glm::dvec3 Illumination::colourOf(uint32_t material, const glm::dvec3& position, const glm::dvec3& n, const glm::dvec3& v) const {
    const Material& m = scene_.materials[material];
    glm::dvec3 colour = glm::dvec3(m.ambient) * glm::dvec3(scene_.ambient) + glm::dvec3(m.emission);
    for (const Lamp& lamp : lamps_) {
        const glm::dvec3 toLamp = lamp.directional ? lamp.position : lamp.position - position;
        const double distance = lamp.directional ? 1 : lengthOf(toLamp);
        const glm::dvec3 l = lamp.directional ? toLamp : unit(toLamp);
        const double cosine = along(n, l);
        if (!(cosine > 0)) continue;
        const double reflected = along(2 * cosine * n - l, v);
        const double shine = m.shininess == 0 ? 1 : reflected > 0 ? std::pow(reflected, double(m.shininess)) : 0;
        const double fade = lamp.power == 0 ? 1 : lamp.power == 1 ? 1 / distance : 1 / (distance * distance);
        colour += fade * lamp.intensity * (glm::dvec3(m.diffuse) * cosine + glm::dvec3(m.specular) * shine);
    }
    return colour;
}

}  // namespace plumb::truth
