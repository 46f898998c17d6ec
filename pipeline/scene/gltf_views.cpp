// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_views.h"

#include "pipeline/scene/affine.h"
#include "pipeline/scene/scene.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

namespace plumb::gltf {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;

// Lights of glTF are in lux and candela and its diffuse BRDF is colour / pi; ours is the colour.
static constexpr double kIntensityPerLux = 1 / 3.14159265358979323846;

// True when LoadOptions::camera is the number of this camera, from 0 in the order of the nodes, or the name of it or its node.
static bool isChosen(const std::string& choice, size_t number, const Value& camera, const Value& node) {
    if (choice == fmt::format("{}", number)) return true;
    for (const Value* named : {&camera, &node})
        if (const auto name = named->find("name"); name && name->text() == choice) return true;
    return false;
}

void readCamera(const Value& index, const Value& node, const std::vector<Value>& cameras, const dmat4& worldFromNode,
                const Reading& reading) {
    const Value& value = cameras[index.index(cameras.size(), "cameras")];
    const Value typeValue = value.required("type");
    if (typeValue.text() == "orthographic") return reading.ignore(value, "orthographic cameras");
    if (typeValue.text() != "perspective") typeValue.refuse(fmt::format("'{}' is no type of camera", printable(typeValue.text(), 40)));
    const std::string& choice = reading.options.camera;
    const size_t number = reading.cameras++;
    if (!choice.empty() && (reading.scene.camera || !isChosen(choice, number, value, node))) return;
    if (reading.scene.camera) return reading.ignore(index, "cameras after the first");
    const Value perspective = value.required("perspective");
    Camera camera;
    camera.fovYDegrees = perspective.required("yfov").number(0, 3.14159265358979323846) * (180 / 3.14159265358979323846);
    if (camera.fovYDegrees < 1e-3 || camera.fovYDegrees > 179)
        perspective.refuse(fmt::format("yfov is {:g} degrees, outside 0.001 to 179", camera.fovYDegrees));
    camera.near = perspective.required("znear").number(0, kMaxCoordinate);
    if (camera.near == 0) perspective.refuse("znear is 0");
    // A camera looks along its -Z with +Y up (glTF 3.10.2); scales of its node do not distort it.
    const dvec3 back(worldFromNode[2]), up(worldFromNode[1]);
    camera.eye = dvec3(worldFromNode[3]);
    if (largestMagnitude(back) == 0 || largestMagnitude(up) == 0) index.refuse("the node of the camera has a scale of 0");
    camera.forward = -unitVector(back);
    const dvec3 right = glm::cross(camera.forward, unitVector(up));
    if (largestMagnitude(right) < kMinCross) index.refuse("the node of the camera has no inverse");
    camera.right = unitVector(right);
    camera.up = glm::cross(camera.right, camera.forward);
    reading.scene.camera = camera;
}

void readLight(const Value& index, const std::vector<Value>& lights, const dmat4& worldFromNode, const Reading& reading) {
    const Value& value = lights[index.index(lights.size(), "lights")];
    const Value typeValue = value.required("type");
    const std::string& type = typeValue.text();
    Light light;
    light.location = value.location();
    if (type == "directional") {
        light.direction = dvec3(worldFromNode[2]);  // it shines along -Z, so +Z is toward it
        if (largestMagnitude(light.direction) == 0) index.refuse("the node of the light has a scale of 0");
    } else if (type == "point" || type == "spot") {
        light.directional = false;
        light.position = dvec3(worldFromNode[3]);
        light.attenuation = Attenuation::inverseSquare;
        if (type == "spot") reading.ignore(value, "cones of spot lights");
        if (const auto range = value.find("range")) reading.ignore(*range, "ranges of lights");
    } else {
        typeValue.refuse(fmt::format("'{}' is no type of light", printable(type, 40)));
    }
    std::array<double, 3> colour{1, 1, 1};
    if (const auto factor = value.find("color")) colour = factor->numbers<3>(0, kMaxCoordinate);
    double intensity = 1;
    if (const auto factor = value.find("intensity")) intensity = factor->number(0, kMaxCoordinate);
    for (int channel = 0; channel < 3; ++channel) {
        const double product = colour[size_t(channel)] * intensity * kIntensityPerLux;
        if (product > kMaxCoordinate) value.refuse("color times intensity is above 2^100");
        light.intensity[channel] = float(product);
    }
    reading.scene.lights.push_back(light);
}

void focusCamera(Scene& scene) {
    dvec3 least(kMaxCoordinate), most(-kMaxCoordinate);
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        for (int corner = 0; corner < 8; ++corner) {
            const dvec4 at(corner & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, corner & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                           corner & 4 ? mesh.boundsMax.z : mesh.boundsMin.z, 1);
            const dvec3 world(worldFromMesh(scene, object) * at);
            least = glm::min(least, world);
            most = glm::max(most, world);
        }
    }
    const double distance = glm::length((least + most) * 0.5 - scene.camera->eye);
    if (distance > 0 && std::isfinite(distance)) scene.camera->focusDistance = distance;
}

}  // namespace plumb::gltf
