// SPDX-License-Identifier: MIT
// One face in its own plane, seen so that it is counter-clockwise, cut into triangles: a fan where it is convex, else the triangles of its
// ears (O'Rourke, Computational Geometry in C, 1.4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace plumb {

// Most tests of a corner against a triangle for one face. Ear clipping takes corners * reflex corners of them: a second in the
// worst case, and enough for any outline of 13,000 corners.
inline constexpr uint64_t kMaxCornerTests = uint64_t(1) << 28;

class FaceCutter {
public:
    struct Point {
        double x, y;
        bool operator==(const Point&) const = default;
    };
    using Cut = std::array<uint32_t, 3>;  // corners of the face, from 0

    std::vector<Point> points;  // in: the corners, projected
    std::vector<Cut> cuts;      // out: points.size() - 2 of them, or none

    enum class Outcome { done, selfCrossing, tooLarge };  // tooLarge: more than kMaxCornerTests; there are no cuts
    Outcome run();
    void fan(uint32_t corners);

private:
    bool turnsOnce() const;
    double turnAt(uint32_t i) const;
    bool isEar(uint32_t i);
    void cutOff(uint32_t i);
    void collectReflex();
    bool askAll();
    Outcome clipEars();
    Outcome fallBack(uint32_t at, uint32_t left);

    std::vector<uint32_t> before_, after_, reflex_;
    std::vector<char> gone_, ear_;
    uint64_t tests_ = 0;
};

}  // namespace plumb
