// SPDX-License-Identifier: MIT
// One face in its own plane, seen so that it is counter-clockwise, cut into triangles: a fan where it is convex, else the triangles of its
// ears (O'Rourke, Computational Geometry in C, 1.4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace plumb {

// Most corners of a concave face. Ear clipping takes time corners * reflex corners: at this size half a second in the worst case.
inline constexpr uint32_t kMaxConcaveCorners = 8192;

class FaceCutter {
public:
    struct Point {
        double x, y;
        bool operator==(const Point&) const = default;
    };
    using Cut = std::array<uint32_t, 3>;  // corners of the face, from 0

    std::vector<Point> points;  // in: the corners, projected
    std::vector<Cut> cuts;      // out: points.size() - 2 of them

    enum class Outcome { done, selfCrossing, tooLarge };
    Outcome run();
    void fan(uint32_t corners);

private:
    bool turnsOnce() const;
    double turnAt(uint32_t i) const;
    bool isEar(uint32_t i) const;
    void cutOff(uint32_t i);
    void collectReflex();
    bool askAll();
    Outcome clipEars();
    Outcome fallBack(uint32_t at, uint32_t left);

    std::vector<uint32_t> before_, after_, reflex_;
    std::vector<char> gone_, ear_;
};

}  // namespace plumb
