// SPDX-License-Identifier: MIT
#include "pipeline/scene/teapot.h"

#include "host/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string_view>
#include <system_error>
#include <tuple>
#include <vector>

namespace plumb {

extern const char* const kTeapotPatches;  // patches.txt

namespace {

using Grid = std::array<glm::dvec3, 16>;  // control points: rows of four, then columns
using Weights = std::array<double, 4>;

constexpr double kOffAxis = 0.002;  // freeglut moves two points of the lid off the axis by that, to have a normal there
constexpr double kPlace = 0x1p20;   // corners are rounded to 1 / kPlace

std::vector<std::string_view> wordsOf(std::string_view line) {
    std::vector<std::string_view> words;
    for (size_t at = 0; (at = line.find_first_not_of(' ', at)) != line.npos;) {
        const size_t end = std::min(line.find(' ', at), line.size());
        words.push_back(line.substr(at, end - at));
        at = end;
    }
    return words;
}

template <class Number>
Number numberIn(std::string_view word) {
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    PLUMB_ASSERT(error == std::errc() && end == word.data() + word.size());
    return value;
}

// All patches, copies made. Four copies are turned about Z by quarters. Two are mirrored at Y = 0, rows reversed so that the outside stays.
std::vector<Grid> readPatches() {
    struct Row {
        int copies;
        std::array<size_t, 16> points;
    };
    std::vector<Row> rows;
    std::vector<glm::dvec3> points;
    for (std::string_view rest = kTeapotPatches; !rest.empty();) {
        const size_t end = std::min(rest.find('\n'), rest.size());
        const auto words = wordsOf(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (words.size() == 19 && words[0] == "patch") {
            Row row{numberIn<int>(words[2]), {}};
            for (size_t i = 0; i < 16; ++i) row.points[i] = numberIn<size_t>(words[3 + i]);
            rows.push_back(row);
        } else if (words.size() == 4 && words[0] == "point") {
            const glm::dvec3 p(numberIn<double>(words[1]), numberIn<double>(words[2]), numberIn<double>(words[3]));
            points.push_back(std::hypot(p.x, p.y) <= kOffAxis ? glm::dvec3(0, 0, p.z) : p);
        }
    }
    std::vector<Grid> patches;
    for (const Row& row : rows)
        for (int copy = 0; copy < row.copies; ++copy) {
            Grid grid;
            for (size_t i = 0; i < 16; ++i) {
                glm::dvec3 p = points.at(row.points[row.copies == 2 && copy == 1 ? i - i % 4 + (3 - i % 4) : i]);
                if (row.copies == 2 && copy == 1) p.y = -p.y;
                for (int q = 0; row.copies == 4 && q < copy; ++q) p = {-p.y, p.x, p.z};
                grid[i] = p;
            }
            patches.push_back(grid);
        }
    return patches;
}

const std::vector<Grid>& patches() {
    static const std::vector<Grid> kPatches = readPatches();
    return kPatches;
}

Weights bernstein(double t) {
    const double s = 1 - t;
    return {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
}
Weights slopes(double t) {
    const double s = 1 - t;
    return {-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t};
}

glm::dvec3 combined(const Grid& grid, const Weights& rows, const Weights& columns) {
    glm::dvec3 sum(0);
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j) sum += rows[i] * columns[j] * grid[4 * i + j];
    return sum;
}

// Unit normal; where a side of the patch is one point, that of a place close by.
glm::dvec3 normalAt(const Grid& grid, double u, double v) {
    constexpr double kLeast = 0x1p-20;
    for (const double nudge : {0.0, 0x1p-13, 0x1p-10}) {
        const double s = std::abs(u - nudge), t = std::abs(v - nudge);
        const glm::dvec3 n = glm::cross(combined(grid, bernstein(s), slopes(t)), combined(grid, slopes(s), bernstein(t)));
        if (const double length = glm::length(n); length > kLeast) return n / length;
    }
    PLUMB_ASSERT(false);  // no patch of the file
    return glm::dvec3(0);
}

glm::dvec3 upright(const glm::dvec3& p) { return {p.x, p.z, -p.y}; }  // +Z up becomes +Y up

}  // namespace

PolygonMesh teapotPolygons(uint32_t steps) {
    PolygonMesh mesh;
    std::map<std::tuple<double, double, double>, uint32_t> places;
    mesh.faceFirst.push_back(0);
    for (const Grid& grid : patches()) {
        std::vector<PolygonMesh::Corner> corners;
        for (uint32_t i = 0; i <= steps; ++i)
            for (uint32_t j = 0; j <= steps; ++j) {
                const double u = double(i) / steps, v = double(j) / steps;
                const glm::dvec3 p = glm::round(upright(combined(grid, bernstein(u), bernstein(v))) * kPlace) / kPlace + 0.0;
                glm::dvec3 n = upright(normalAt(grid, u, v));
                // On the axis four patches meet, and none of them knows the other's side.
                if (p.x == 0 && p.z == 0 && std::abs(n.y) > 0.9) n = {0, std::copysign(1.0, n.y), 0};
                const auto [place, isNew] = places.try_emplace({p.x, p.y, p.z}, uint32_t(mesh.positions.size()));
                if (isNew) mesh.positions.push_back(p);
                corners.push_back({place->second, uint32_t(mesh.normals.size())});
                mesh.normals.push_back(glm::vec3(n));
            }
        const auto triangle = [&](size_t a, size_t b, size_t c) {
            const uint32_t p = corners[a].position, q = corners[b].position, r = corners[c].position;
            if (p == q || q == r || r == p) return;
            for (const size_t k : {a, b, c}) mesh.corners.push_back(corners[k]);
            mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        };
        for (size_t i = 0; i < steps; ++i)
            for (size_t j = 0; j < steps; ++j) {
                const size_t at = i * (steps + 1) + j, below = at + steps + 1;
                triangle(at, at + 1, below + 1);
                triangle(at, below + 1, below);
            }
    }
    return mesh;
}

double teapotDeviation(uint32_t steps) {
    // Second derivatives of a bicubic patch are patches themselves, of 6 times the second differences of its control points, and 9 times the mixed
    // ones. No point of a patch is longer than its longest control point.
    double largest = 0;
    for (const Grid& g : patches()) {
        double uu = 0, uv = 0, vv = 0;
        for (size_t i = 0; i < 4; ++i)
            for (size_t j = 0; j < 4; ++j) {
                const size_t at = 4 * i + j;
                if (i + 2 < 4) uu = std::max(uu, 6 * glm::length(g[at] - 2.0 * g[at + 4] + g[at + 8]));
                if (j + 2 < 4) vv = std::max(vv, 6 * glm::length(g[at] - 2.0 * g[at + 1] + g[at + 2]));
                if (i + 1 < 4 && j + 1 < 4) uv = std::max(uv, 9 * glm::length(g[at] - g[at + 1] - g[at + 4] + g[at + 5]));
            }
        largest = std::max(largest, uu + 2 * uv + vv);
    }
    const double rounding = std::sqrt(3.0) * (0.5 / kPlace);  // float32 is finer than that below 4 units
    return largest / (8.0 * steps * steps) + rounding;
}

}  // namespace plumb
