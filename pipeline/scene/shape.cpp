// SPDX-License-Identifier: MIT
#include "pipeline/scene/shape.h"

#include "host/error.h"
#include "pipeline/scene/teapot.h"

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Adds polygons corner by corner; each corner has its own normal by number.
class Polygons {
public:
    uint32_t point(const glm::dvec3& p) {
        mesh.positions.push_back(p);
        return count_++;
    }
    uint32_t normal(const glm::dvec3& n) {
        mesh.normals.push_back(glm::vec3(n));
        return uint32_t(mesh.normals.size() - 1);
    }
    void face(std::initializer_list<PolygonMesh::Corner> corners) {
        if (mesh.faceFirst.empty()) mesh.faceFirst.push_back(0);
        mesh.corners.insert(mesh.corners.end(), corners);
        end();
    }
    void end() {
        if (mesh.faceFirst.empty()) mesh.faceFirst.push_back(0);
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
    }
    PolygonMesh mesh;

private:
    uint32_t count_ = 0;
};

// Cosine and sine of k/n of a turn. The angle is taken from the nearest quarter, so that what is mirrored has the same digits.
glm::dvec2 onCircle(uint32_t k, uint32_t n) {
    const uint32_t quarters = (8 * (k % n) / n + 1) / 2;
    const double rest = 2 * kPi * (4.0 * (k % n) - double(quarters) * n) / (4.0 * n);
    const double c = std::cos(rest), s = std::sin(rest);
    const glm::dvec2 turned[] = {{c, s}, {-s, c}, {-c, -s}, {s, -c}};
    return turned[quarters % 4];
}

PolygonMesh sphere(double radius, uint32_t around) {
    Polygons out;
    const uint32_t stacks = around / 2;
    std::vector<uint32_t> rows;  // first corner of each ring between the poles
    const uint32_t top = out.point({0, radius, 0});
    out.normal({0, 1, 0});
    for (uint32_t j = 1; j < stacks; ++j) {
        const glm::dvec2 latitude = onCircle(j, 2 * stacks);  // cosine toward +Y, sine outward
        for (uint32_t i = 0; i < around; ++i) {
            const glm::dvec2 a = onCircle(i, around);
            const glm::dvec3 n(latitude.y * a.x, latitude.x, -latitude.y * a.y);
            const uint32_t p = out.point(radius * n);
            if (i == 0) rows.push_back(p);
            out.normal(n);
        }
    }
    const uint32_t bottom = out.point({0, -radius, 0});
    out.normal({0, -1, 0});
    const auto corner = [](uint32_t p) { return PolygonMesh::Corner{p, p}; };  // a normal a point, in the same order
    for (uint32_t i = 0; i < around; ++i) {
        const uint32_t next = (i + 1) % around;
        out.face({corner(top), corner(rows.front() + i), corner(rows.front() + next)});
        for (size_t j = 0; j + 1 < rows.size(); ++j)
            out.face({corner(rows[j] + i), corner(rows[j + 1] + i), corner(rows[j + 1] + next), corner(rows[j] + next)});
        out.face({corner(rows.back() + i), corner(bottom), corner(rows.back() + next)});
    }
    return std::move(out.mesh);
}

PolygonMesh cylinder(double radius, double length, uint32_t around) {
    Polygons out;
    const double half = length / 2;
    for (uint32_t i = 0; i < around; ++i) {
        const glm::dvec2 a = onCircle(i, around);
        out.point({radius * a.x, half, -radius * a.y});
        out.point({radius * a.x, -half, -radius * a.y});
        out.normal({a.x, 0, -a.y});
    }
    const uint32_t up = out.normal({0, 1, 0}), down = out.normal({0, -1, 0});
    for (uint32_t i = 0; i < around; ++i) {
        const uint32_t next = (i + 1) % around;
        out.face({{2 * i, i}, {2 * i + 1, i}, {2 * next + 1, next}, {2 * next, next}});
    }
    for (uint32_t i = 0; i < around; ++i) out.mesh.corners.push_back({2 * i, up});
    out.end();
    for (uint32_t i = around; i-- > 0;) out.mesh.corners.push_back({2 * i + 1, down});
    out.end();
    return std::move(out.mesh);
}

}  // namespace

SegmentRange segmentRangeOf(ShapeKind kind) {
    switch (kind) {
        case ShapeKind::sphere:
            return {4, 1024, 2};  // a million triangles
        case ShapeKind::cylinder:
            return {3, 4096, 1};
        case ShapeKind::teapot:
            break;
    }
    return {4, 256, 4};  // a quarter of a million
}

const char* nameOf(ShapeKind kind) {
    static constexpr const char* kNames[] = {"sphere", "cylinder", "teapot"};
    return kNames[size_t(kind)];
}

PolygonMesh polygonsOf(const GeneratedShape& shape) {
    switch (shape.kind) {
        case ShapeKind::sphere:
            return sphere(shape.radius, shape.segments);
        case ShapeKind::cylinder:
            return cylinder(shape.radius, shape.length, shape.segments);
        case ShapeKind::teapot:
            break;
    }
    return teapotPolygons(shape.segments / 4);
}

double deviationOf(const GeneratedShape& shape) {
    constexpr double kFloatUnit = 0x1p-24;
    const double sine = std::sin(kPi / shape.segments), half = std::sin(kPi / (2.0 * shape.segments));
    switch (shape.kind) {
        case ShapeKind::sphere:
            return shape.radius * (sine * sine + kFloatUnit);
        case ShapeKind::cylinder:  // 1 - cos x = 2 sin^2(x / 2)
            return shape.radius * 2 * half * half + std::hypot(shape.radius, shape.length / 2) * kFloatUnit;
        case ShapeKind::teapot:
            break;
    }
    return teapotDeviation(shape.segments / 4);
}

uint32_t segmentsFor(const GeneratedShape& shape, double deviation) {
    const SegmentRange range = segmentRangeOf(shape.kind);
    // Deviations fall with the segments. Bisection over the steps of the range.
    uint32_t low = 0, high = (range.most - range.least) / range.step;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        GeneratedShape tried = shape;
        tried.segments = range.least + middle * range.step;
        if (deviationOf(tried) <= deviation)
            high = middle;
        else
            low = middle + 1;
    }
    return range.least + low * range.step;
}

TriangleMesh tessellated(const TriangleMesh& mesh, uint32_t segments, bool keepNumbers) {
    PLUMB_ASSERT(mesh.shape != nullptr && !mesh.faceMaterial.empty());
    GeneratedShape shape = *mesh.shape;
    shape.segments = segments;
    PolygonMesh polygons = polygonsOf(shape);
    polygons.name = mesh.name;
    polygons.location = mesh.location;
    std::vector<Material> none;
    LoadOptions options;
    options.keepNumbers = keepNumbers;
    TriangleMesh out = finishMesh(std::move(polygons), none, mesh.faceMaterial.front(), options);
    out.shape = std::make_shared<GeneratedShape>(shape);
    return out;
}

bool standsForSolid(const Scene& scene, uint32_t object) {
    const Object& o = scene.objects[object];
    const TriangleMesh& mesh = scene.meshes[o.mesh];
    return mesh.shape != nullptr && mesh.shape->kind != ShapeKind::teapot && glm::determinant(glm::dmat3(worldFromMesh(scene, o))) != 0;
}

}  // namespace plumb
