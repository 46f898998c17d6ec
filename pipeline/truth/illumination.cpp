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

// Unit vector; 0 for the zero vector.
glm::dvec3 unit(const glm::dvec3& v) {
    const double length = lengthOf(v);
    return length > 0 ? v / length : glm::dvec3(0);
}
// Direction of a vector that is within `off` of the true one.
Direction directionOf(const glm::dvec3& v, double off) {
    const double length = lengthOf(v);
    return {length > 0 ? v / length : glm::dvec3(0), turnedBy(off, length) + kUnitVectorError};
}

}  // namespace

Illumination::Illumination(const Scene& scene, const Geometry& geometry) : scene_(scene), geometry_(geometry) {
    for (const Light& light : scene.lights) {
        Lamp lamp;
        lamp.directional = light.directional;
        lamp.position = light.directional ? unit(light.direction) : light.position - geometry.pinhole().eye;
        lamp.intensity = glm::dvec3(light.intensity);
        lamp.away = lengthOf(lamp.position);
        if (!light.directional)
            lamp.power = light.attenuation == Attenuation::inverse ? 1 : light.attenuation == Attenuation::inverseSquare ? 2 : 0;
        lamps_.push_back(lamp);
    }
    for (const Object& object : scene.objects) {
        // Inverse transpose up to a positive factor: cofactors times the determinant's sign. An entry's error is u of each of its four
        // quotients, u of each product and u of the difference: 4 u of both products.
        glm::dmat3 m(object.worldFromObject);
        NormalMatrix n;
        double largest = 0, sizes = 0, errors = 0;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(m[c][r]));
        if (largest > 0) m /= largest;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) {
                const int c1 = (c + 1) % 3, c2 = (c + 2) % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3;
                n.m[c][r] = m[c1][r1] * m[c2][r2] - m[c1][r2] * m[c2][r1];
                const double error = 4 * kDoubleUnit * (std::abs(m[c1][r1] * m[c2][r2]) + std::abs(m[c1][r2] * m[c2][r1]));
                sizes += n.m[c][r] * n.m[c][r];
                errors += error * error;
            }
        n.size = std::sqrt(sizes) * kOwnRounding;
        n.error = std::sqrt(errors) * kOwnRounding;
        if (mirrors(object.worldFromObject)) n.m = -n.m;
        normalFromObject_.push_back(n);
    }
}

Illumination::Patch Illumination::patchOf(uint32_t index) const {
    const Triangle& t = geometry_.triangles()[index];
    const TriangleMesh& mesh = scene_.meshes[scene_.objects[t.object].mesh];
    Patch p;
    p.triangle = &t;
    p.object = t.object;
    p.material = mesh.faceMaterial[mesh.triangles[t.triangle].face];
    for (size_t i = 0; i < 3; ++i) {
        const Corner corner = geometry_.corner(t.object, t.vertex[i]);
        p.normal[i] = glm::dvec3(mesh.normals[t.vertex[i]]);
        p.fromEye[i] = corner.fromEye;
        p.w[i] = corner.w.value;
        p.edgeError += t.error[i];
        p.normalMost = std::max(p.normalMost, lengthOf(p.normal[i]));
        p.placeMost = std::max(p.placeMost, lengthOf(p.fromEye[i]));
        p.placeError = std::max(p.placeError, corner.fromEyeError);
        p.wMost = std::max(p.wMost, std::abs(corner.w.value));
        p.wError = std::max(p.wError, corner.w.error);
    }
    for (size_t i = 0; i < 3; ++i) {
        const size_t k = (i + 1) % 3;
        p.normalSpread = std::max(p.normalSpread, lengthOf(p.normal[i] - p.normal[k]));
        p.placeSpread = std::max(p.placeSpread, lengthOf(p.fromEye[i] - p.fromEye[k]) + 2 * p.placeError);
        p.wSpread = std::max(p.wSpread, std::abs(p.w[i] - p.w[k]) + 2 * p.wError);
    }
    return p;
}

Illumination::Seen Illumination::at(const Patch& p, double x, double y) const {
    const Triangle& t = *p.triangle;
    double weight[3], sum = 0;
    for (int i = 0; i < 3; ++i) {
        weight[i] = std::max(0.0, t.a[i] * x + t.b[i] * y + t.c[i]);  // a sample on an edge must not get a negative weight
        sum += weight[i];
    }
    glm::dvec3 normal(0), position(0);
    double w = 0;
    for (size_t i = 0; i < 3; ++i) {
        const double share = sum > 0 ? weight[i] / sum : 1.0 / 3;
        normal += share * p.normal[i];
        position += share * p.fromEye[i];
        w += share * p.w[i];
    }
    // Shares are off by 2 E / sum together, E the errors of the edge functions, and true ones and these are each 1 together. So half of that
    // times the spread of the corners is what they move. Rounding: 2 u of the sum of weights, a quotient, a product, two additions.
    const double moved = sum > 0 ? std::min(1.0, p.edgeError / sum) : 1.0;
    const auto off = [&](double spread, double most) { return (moved * spread + 6 * kDoubleUnit * most) * kOwnRounding; };
    const double positionError = off(p.placeSpread, p.placeMost) + p.placeError * kOwnRounding;
    const double wError = off(p.wSpread, p.wMost) + p.wError * kOwnRounding;

    const NormalMatrix& m = normalFromObject_[p.object];
    const double normalError = off(p.normalSpread, p.normalMost), length = lengthOf(normal);
    const glm::dvec3 world = m.m * normal;
    const double worldError = ((m.size + m.error) * normalError + (m.error + 3 * kDoubleUnit * m.size) * length) * kOwnRounding;
    const Direction toViewer =
        scene_.distantViewer.value_or(false) ? directionOf(-scene_.camera->forward, 0) : directionOf(-position, positionError);
    return {colourOf(p.material, position, positionError, directionOf(world, worldError), toViewer), {w, wError}};
}

BoundedColour Illumination::colourOf(uint32_t material, const glm::dvec3& position, double positionError, const Direction& normal,
                                     const Direction& toViewer) const {
    const Material& m = scene_.materials[material];
    BoundedColour colour;
    colour.value = glm::dvec3(m.ambient) * glm::dvec3(scene_.ambient) + glm::dvec3(m.emission);
    for (const Lamp& lamp : lamps_) {
        const glm::dvec3 toLamp = lamp.directional ? lamp.position : lamp.position - position;
        const double distance = lamp.directional ? 1 : lengthOf(toLamp);
        Direction l{lamp.position, kUnitVectorError};
        double fade = 1, fadeError = 0;
        if (!lamp.directional) {
            // Lamp less eye, and that less the position: u of each difference.
            const double off = (positionError + kDoubleUnit * (lamp.away + distance)) * kOwnRounding;
            l = {distance > 0 ? toLamp / distance : glm::dvec3(0), turnedBy(off, distance) + kUnitVectorError};
            fade = lamp.power == 0 ? 1 : lamp.power == 1 ? 1 / distance : 1 / (distance * distance);
            // Where the lamp may be at the point itself, nothing bounds how bright it is.
            if (lamp.power > 0) fadeError = off < distance / 4 ? lamp.power * (off / (distance - 2 * off) + 8 * kDoubleUnit) : INFINITY;
        }
        LightPart part = lightPart(normal, l, toViewer, double(m.shininess));
        part.fade = fade;
        part.fadeError = fadeError;
        addPart(part, m.diffuse, m.specular, lamp.intensity, colour);
    }
    // Sums of positive terms: a rounding for each light, and those of the base.
    colour.error += colour.value * ((double(lamps_.size()) + 4) * kDoubleUnit) + kUnderflow;
    return colour;
}

}  // namespace plumb::truth
