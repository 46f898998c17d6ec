// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_rest.h"

#include "host/error.h"

#include <fmt/core.h>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

namespace plumb::gltf {

using glm::dmat3;
using glm::dmat4;
using glm::dvec3;

static dvec3 vectorOf(const Accessor& from, size_t element, const char* name) {
    dvec3 v;
    for (int i = 0; i < 3; ++i) {
        v[i] = from.component(element, i);
        if (!std::isfinite(v[i])) throw inputError(from.location, fmt::format("element {}: {} is not finite", element, name));
    }
    return v;
}

static Accessor accessorOf(const Value& index, const char* name, size_t vertices, int components, Accessors& accessors) {
    Accessor accessor = accessors.at(index);
    if (accessor.components != components) index.refuse(fmt::format("{} has {} numbers, not {}", name, accessor.components, components));
    if (accessor.count != vertices) index.refuse(fmt::format("{} has {} elements, POSITION has {}", name, accessor.count, vertices));
    return accessor;
}

std::vector<double> weightsIn(const Value& owner) {
    constexpr double kMost = 1e6;
    std::vector<double> weights;
    for (const Value& weight : owner.list("weights")) weights.push_back(weight.number(-kMost, kMost));
    return weights;
}

RestVertices::RestVertices(const Value& primitive, const Rest& rest, size_t vertices, Accessors& accessors, const Reading& reading)
    : rest_(rest) {
    readTargets(primitive, vertices, accessors);
    if (!rest.joints.empty()) readInfluences(primitive, vertices, accessors, reading);
}

// A target of weight 0 changes nothing, and is not looked at.
void RestVertices::readTargets(const Value& primitive, size_t vertices, Accessors& accessors) {
    const std::vector<Value> targets = primitive.list("targets");
    for (size_t i = 0; i < targets.size() && i < rest_.weights.size(); ++i) {
        if (rest_.weights[i] == 0) continue;
        Target target{rest_.weights[i], {}, {}};
        for (const auto& [name, into] : {std::pair{"POSITION", &target.position}, {"NORMAL", &target.normal}})
            if (const auto index = targets[i].find(name)) {
                const Accessor accessor = accessorOf(*index, name, vertices, 3, accessors);
                if (accessor.hasData()) *into = accessor;
            }
        targets_.push_back(std::move(target));
    }
}

void RestVertices::readInfluences(const Value& primitive, size_t vertices, Accessors& accessors, const Reading& reading) {
    const Value attributes = primitive.required("attributes");
    for (int set = 0;; ++set) {
        const std::string jointsName = fmt::format("JOINTS_{}", set), weightsName = fmt::format("WEIGHTS_{}", set);
        const auto joints = attributes.find(jointsName.c_str()), weights = attributes.find(weightsName.c_str());
        if (!joints || !weights) break;
        Influence influence{accessorOf(*joints, jointsName.c_str(), vertices, 4, accessors),
                            accessorOf(*weights, weightsName.c_str(), vertices, 4, accessors)};
        if (influence.weights.hasData()) influences_.push_back(std::move(influence));
    }
    if (influences_.empty()) reading.pass(primitive, "has a skin but neither joints nor weights; it stands where its node does");
}

// Mean of the joints by their weights. Writers round weights, so their sum is divided out.
dmat4 RestVertices::worldFromVertex(size_t vertex) const {
    dmat4 sum(0.0);
    double total = 0;
    for (const Influence& influence : influences_)
        for (int i = 0; i < 4; ++i) {
            const double weight = influence.weights.component(vertex, i);
            if (!(std::abs(weight) <= 1e6))
                throw inputError(influence.weights.location, fmt::format("element {}: a weight is {}", vertex, weight));
            if (weight == 0) continue;
            const double joint = influence.joints.hasData() ? influence.joints.component(vertex, i) : 0;
            if (!(joint >= 0 && joint < double(rest_.joints.size())))
                throw inputError(influence.joints.location,
                                 fmt::format("element {}: the joint is {}; the skin has {}", vertex, joint, rest_.joints.size()));
            sum += rest_.joints[size_t(joint)] * weight;
            total += weight;
        }
    return total > 0 ? sum * (1 / total) : rest_.worldFromNode;
}

dvec3 RestVertices::position(size_t vertex, dvec3 stated) const {
    for (const Target& target : targets_)
        if (target.position) stated += target.weight * vectorOf(*target.position, vertex, "POSITION of a morph target");
    if (rest_.joints.empty()) return stated;
    return dvec3(worldFromVertex(vertex) * glm::dvec4(stated, 1));
}

dvec3 RestVertices::normal(size_t vertex, dvec3 stated) const {
    for (const Target& target : targets_)
        if (target.normal) stated += target.weight * vectorOf(*target.normal, vertex, "NORMAL of a morph target");
    if (rest_.joints.empty()) return stated;
    // The cofactors are the inverse transpose times the determinant, and exist where the inverse does not.
    const dmat3 m(worldFromVertex(vertex));
    const dvec3 turned = glm::cross(m[1], m[2]) * stated.x + glm::cross(m[2], m[0]) * stated.y + glm::cross(m[0], m[1]) * stated.z;
    const double length = std::sqrt(glm::dot(turned, turned));
    if (!(length > 0) || !std::isfinite(length)) return dvec3(0);
    return turned * ((mirrored(vertex) ? -1 : 1) / length);
}

bool RestVertices::mirrored(size_t vertex) const { return !rest_.joints.empty() && glm::determinant(dmat3(worldFromVertex(vertex))) < 0; }

}  // namespace plumb::gltf
