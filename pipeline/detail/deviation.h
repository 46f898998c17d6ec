// SPDX-License-Identifier: MIT
// How far two surfaces of triangles are apart, proved in binary64. Positions are in one space and unit; float32 values, taken exactly.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::detail {

using Corners = std::array<glm::dvec3, 3>;

// Surface that distances are asked of: its triangles in a tree of boxes.
class Surface {
public:
    explicit Surface(std::vector<Corners> triangles);

    // True when every point of triangle `t` is proved to lie within `distance` of the surface. Distance to one triangle of the surface is a convex
    // function, so over `t` it is largest at a corner. Where no triangle is near enough to all three corners, `t` is halved, and each half asked. A
    // corner that is too far from all of them ends it: false.
    bool holds(const Corners& t, double distance) const;
    const std::vector<Corners>& triangles() const { return triangles_; }

private:
    struct Node {
        glm::dvec3 low, high;
        uint32_t first = 0, count = 0;  // triangles of a leaf
        uint32_t right = 0;             // of an inner node; the left child follows it
    };
    void build(uint32_t first, uint32_t last);
    enum class Answer { one, several, none };
    Answer ask(const Corners& t, double squared) const;

    std::vector<Corners> triangles_;
    std::vector<Node> nodes_;
    double slack_ = 0;  // rounding of a distance
};

// True when no point of either surface is further than `distance` from the other. `alive`: called by one thread now and then, may throw.
bool within(const Surface& a, const Surface& b, double distance, uint32_t threads, const std::function<void()>& alive);

}  // namespace plumb::detail
