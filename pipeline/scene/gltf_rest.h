// SPDX-License-Identifier: MIT
// Shape of a glTF's mesh at rest: morph targets by their stated weights, then the joints of a skin where the nodes stand.
#pragma once

#include "pipeline/scene/gltf_accessors.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

#include <cstddef>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace plumb::gltf {

// What a node says about the shape of its mesh.
struct Rest {
    std::vector<double> weights;  // of the morph targets, in their order; the rest are 0
    // Joint -> world from mesh; empty without a skin. With a skin the mesh stands in the world, and its node's own matrix does not count.
    std::vector<glm::dmat4> joints;
    glm::dmat4 worldFromNode{1.0};  // of vertices without a joint
};

// Weights of the morph targets that a mesh or a node states; empty where it states none.
std::vector<double> weightsIn(const Value& owner);

// Vertices of one primitive at rest.
class RestVertices {
public:
    // `vertices` is the number that POSITION has; `rest` must outlive this.
    RestVertices(const Value& primitive, const Rest& rest, size_t vertices, Accessors& accessors, const Reading& reading);
    glm::dvec3 position(size_t vertex, glm::dvec3 stated) const;
    glm::dvec3 normal(size_t vertex, glm::dvec3 stated) const;
    bool mirrored(size_t vertex) const;  // true where the joints turn the winding round

private:
    struct Target {
        double weight;
        std::optional<Accessor> position, normal;
    };
    struct Influence {
        Accessor joints, weights;  // four of each a vertex
    };
    void readTargets(const Value& primitive, size_t vertices, Accessors& accessors);
    void readInfluences(const Value& primitive, size_t vertices, Accessors& accessors, const Reading& reading);
    glm::dmat4 worldFromVertex(size_t vertex) const;

    const Rest& rest_;
    std::vector<Target> targets_;
    std::vector<Influence> influences_;
};

}  // namespace plumb::gltf
