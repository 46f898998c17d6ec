// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/vertex_error.h"

#include "pipeline/render/bounds/vertex_arithmetic.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/camera.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/text.h"
#include "shared/bounds.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using glm::dvec3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnit = 0x1p-24, kUnit64 = 0x1p-53;  // unit round-offs
// float32 rounds each entry of a row, three products and three sums (long_transform.h: 4.01 u, and half an ULP of each entry).
constexpr double kRow = gpu::kRowUnits * kUnit;
// The composite in binary64: the origin through the matrix (three products and three sums), less the eye, along an axis (three products, two sums), the scale.
constexpr double kComposite = 12 * kUnit64;
// A cut of an edge is P + t (Q - P) in float32, t a quotient of two differences.
constexpr double kCut = 6 * kUnit;
// Division and the middle of the screen: three roundings of at most half a screen, and the middle itself.
constexpr double kProjection = 4 * kUnit;

// How far a number along one axis of the camera may be off: at a mesh position p, |entries| . |p| + constant.
struct Row {
    double x[4] = {};        // the row: scale * axis . (column of the composite)
    double entries[3] = {};  // of the error that grows with |p|
    double lost[3] = {};     // what the file's numbers lost at load: at most this, and at most an entry's u |p|
    double constant = 0;     // of the error that does not
    double finalUnit = 0;    // of the result's own magnitude: its last rounding
    double at(const dvec3& p) const { return (x[0] * p.x + x[1] * p.y) + (x[2] * p.z + x[3]); }
    double error(const dvec3& magnitude, double result) const {
        double sum = constant + finalUnit * std::abs(result);
        for (int k = 0; k < 3; ++k) sum += entries[k] * magnitude[k] + std::abs(x[k]) * std::min(lost[k], kUnit * magnitude[k]);
        return sum;
    }
};

enum class Arithmetic { fp32, blockInteger, fp64, ray, host };

struct Projected {
    double x = 0, y = 0, w = 0, errorX = 0, errorY = 0, errorW = 0;
};
Projected between(const Projected& a, const Projected& b, double t) {
    const auto mix = [t](double p, double q) { return p + (q - p) * t; };
    return {mix(a.x, b.x), mix(a.y, b.y), mix(a.w, b.w), mix(a.errorX, b.errorX), mix(a.errorY, b.errorY), mix(a.errorW, b.errorW)};
}

class Bound {
public:
    Bound(const Scene& scene, const RenderRequest& request, uint32_t object, Arithmetic arithmetic)
        : mesh_(scene.meshes[scene.objects[object].mesh]), arithmetic_(arithmetic) {
        const Camera& camera = *scene.camera;
        halfX_ = request.width / 2.0;
        halfY_ = request.height / 2.0;
        const double focal = focalOf(camera, request.height);
        near_ = nearOf(camera);
        reach_ = glm::max(glm::abs(dvec3(mesh_.boundsMin)), glm::abs(dvec3(mesh_.boundsMax)));
        const Object& o = scene.objects[object];
        const glm::dmat4 composite = worldFromMesh(scene, o);
        rowX_ = rowOf(o.worldFromObject, composite, camera.eye, camera.right, focal);
        rowY_ = rowOf(o.worldFromObject, composite, camera.eye, camera.up, focal);
        rowW_ = rowOf(o.worldFromObject, composite, camera.eye, camera.forward, 1);
    }

    // The most over what the view holds of the mesh. Where all of it stays within `enough`, a bound that need not be the least.
    double most(double enough) const {
        if (mesh_.positions.empty()) return 0;
        const double ofBox = box();
        if (ofBox <= enough) return ofBox;
        std::vector<Projected> projected;
        projected.reserve(mesh_.positions.size());
        for (const glm::vec3& p : mesh_.positions) projected.push_back(project(dvec3(p)));
        double worst = 0, settled = 0;
        for (const TriangleMesh::Triangle& t : mesh_.triangles) {
            const std::array<Projected, 3> corners{projected[t.vertex[0]], projected[t.vertex[1]], projected[t.vertex[2]]};
            if (outside(corners)) continue;
            const double atMost = rough(corners);
            if (atMost <= enough)
                settled = std::max(settled, atMost);
            else if (atMost > worst)
                worst = std::max(worst, visible(corners));
        }
        return std::max(worst, settled);
    }

private:
    Row rowOf(const glm::dmat4& object, const glm::dmat4& composite, const dvec3& eye, const dvec3& axis, double scale) const {
        Row row;
        for (int k = 0; k < 3; ++k) row.x[k] = scale * glm::dot(axis, dvec3(composite[k]));
        row.x[3] = scale * glm::dot(axis, dvec3(composite[3]) - eye);
        double sum = std::abs(row.x[3]), largest = 0;
        for (int k = 0; k < 3; ++k) {
            sum += std::abs(row.x[k]) * reach_[k];
            largest = std::max(largest, std::abs(row.x[k]));
        }
        const double farthest = std::max({reach_.x, reach_.y, reach_.z});
        switch (arithmetic_) {
            case Arithmetic::fp32:
                for (int k = 0; k < 3; ++k) row.entries[k] = kRow * std::abs(row.x[k]);
                row.constant = kRow * std::abs(row.x[3]);
                break;
            case Arithmetic::blockInteger:  // long_transform.h
                row.constant = 6.01 * 0x1p-30 * largest * farthest + 0x1p-29 * std::abs(row.x[3]);
                row.finalUnit = kUnit;
                break;
            case Arithmetic::fp64:
                row.constant = 4.01 * kUnit64 * sum;
                row.finalUnit = kUnit;
                break;
            case Arithmetic::ray:  // one rounding along each axis of the world; project() adds it
            case Arithmetic::host:
                break;
        }
        for (int k = 0; k < 3; ++k) row.lost[k] = mesh_.lost[k];
        for (int j = 0; j < 3; ++j) {
            double size = std::abs(object[3][j]) + std::abs(eye[j]);
            for (int k = 0; k < 3; ++k) size += std::abs(object[k][j]) * (std::abs(mesh_.origin[k]) + reach_[k]);
            row.constant += kComposite * scale * std::abs(axis[j]) * size;
        }
        if (arithmetic_ == Arithmetic::ray)
            for (int j = 0; j < 3; ++j) {
                row.constant += kUnit * scale * std::abs(axis[j]) * std::abs(composite[3][j] - eye[j]);
                for (int k = 0; k < 3; ++k) row.entries[k] += kUnit * scale * std::abs(axis[j]) * std::abs(composite[k][j]);
            }
        return row;
    }

    Projected project(const dvec3& p) const {
        const dvec3 magnitude = glm::abs(p);
        const double x = rowX_.at(p), y = rowY_.at(p), w = rowW_.at(p);
        return {x, y, w, rowX_.error(magnitude, x), rowY_.error(magnitude, y), rowW_.error(magnitude, w)};
    }

    // Error in pixels of a point within (x, y) of the middle of the screen; without x and y, anywhere on the screen.
    double pixels(double errorX, double errorY, double errorW, double w, double x = 0, double y = 0) const {
        if (!(w > errorW)) return kInfinity;
        const double across = std::max(halfX_, std::abs(x)), down = std::max(halfY_, std::abs(y));
        return std::max((errorX + across * errorW) / (w - errorW) + kProjection * halfX_,
                        (errorY + down * errorW) / (w - errorW) + kProjection * halfY_);
    }

    // All of the mesh that lies at or beyond the near plane, anywhere on the screen.
    double box() const {
        double least = kInfinity, farthest[3] = {};
        for (int i = 0; i < 8; ++i) {
            const Projected p = project({i & 1 ? mesh_.boundsMax.x : mesh_.boundsMin.x, i & 2 ? mesh_.boundsMax.y : mesh_.boundsMin.y,
                                         i & 4 ? mesh_.boundsMax.z : mesh_.boundsMin.z});
            least = std::min(least, p.w);
            farthest[0] = std::max(farthest[0], std::abs(p.x));
            farthest[1] = std::max(farthest[1], std::abs(p.y));
            farthest[2] = std::max(farthest[2], std::abs(p.w));
        }
        const double w = std::max(least, near_), cut = least < near_ ? kCut : 0;
        return pixels(rowX_.error(reach_, farthest[0]) + cut * farthest[0], rowY_.error(reach_, farthest[1]) + cut * farthest[1],
                      rowW_.error(reach_, farthest[2]) + cut * farthest[2], w);
    }

    // The planes of the view as signed distances, inside at or above 0, each moved outward by how far the projection may be off: what is drawn outside may
    // belong inside.
    double distance(int plane, const Projected& p) const {
        switch (plane) {
            case 0:
                return p.w + p.errorW - near_;
            case 1:
                return p.x + halfX_ * p.w + (p.errorX + halfX_ * p.errorW);
            case 2:
                return halfX_ * p.w - p.x + (p.errorX + halfX_ * p.errorW);
            case 3:
                return p.y + halfY_ * p.w + (p.errorY + halfY_ * p.errorW);
            default:
                return halfY_ * p.w - p.y + (p.errorY + halfY_ * p.errorW);
        }
    }
    bool outside(const std::array<Projected, 3>& corners) const {
        for (int plane = 0; plane < 5; ++plane)
            if (std::all_of(corners.begin(), corners.end(), [&](const Projected& p) { return distance(plane, p) < 0; })) return true;
        return false;
    }
    // No less than visible(): the largest errors at the least depth.
    double rough(const std::array<Projected, 3>& corners) const {
        const double cut = cutOf(corners);
        Projected most;
        double least = kInfinity, largest[3] = {};
        for (const Projected& p : corners) {
            least = std::min(least, p.w);
            most.errorX = std::max(most.errorX, p.errorX), largest[0] = std::max(largest[0], std::abs(p.x));
            most.errorY = std::max(most.errorY, p.errorY), largest[1] = std::max(largest[1], std::abs(p.y));
            most.errorW = std::max(most.errorW, p.errorW), largest[2] = std::max(largest[2], std::abs(p.w));
        }
        most.errorX += cut * largest[0], most.errorY += cut * largest[1], most.errorW += cut * largest[2];
        const double w = std::max(least, near_ - most.errorW);
        if (!(w > 0)) return kInfinity;
        return pixels(most.errorX, most.errorY, most.errorW, w, halfX_ + (most.errorX + halfX_ * most.errorW) / w,
                      halfY_ + (most.errorY + halfY_ * most.errorW) / w);
    }
    double cutOf(const std::array<Projected, 3>& corners) const {
        const bool cut = arithmetic_ != Arithmetic::ray && arithmetic_ != Arithmetic::host &&
                         std::any_of(corners.begin(), corners.end(), [&](const Projected& p) { return p.w < near_; });
        return cut ? kCut : 0;
    }

    // The part of a triangle within the view (Sutherland and Hodgman), the errors moved along: a quotient of linear terms is largest at a corner.
    double visible(const std::array<Projected, 3>& corners) const {
        std::vector<Projected> polygon(corners.begin(), corners.end());
        if (const double cut = cutOf(corners); cut > 0) {
            double largest[3] = {};
            for (const Projected& p : corners)
                largest[0] = std::max(largest[0], std::abs(p.x)), largest[1] = std::max(largest[1], std::abs(p.y)),
                largest[2] = std::max(largest[2], std::abs(p.w));
            for (Projected& p : polygon) p.errorX += cut * largest[0], p.errorY += cut * largest[1], p.errorW += cut * largest[2];
        }
        for (int plane = 0; plane < 5 && !polygon.empty(); ++plane) {
            std::vector<Projected> kept;
            for (size_t i = 0; i < polygon.size(); ++i) {
                const Projected &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
                const double da = distance(plane, a), db = distance(plane, b);
                if (da >= 0) kept.push_back(a);
                if ((da >= 0) != (db >= 0)) kept.push_back(between(a, b, da / (da - db)));
            }
            polygon = std::move(kept);
        }
        double worst = 0;
        for (const Projected& p : polygon) worst = std::max(worst, pixels(p.errorX, p.errorY, p.errorW, p.w, p.x / p.w, p.y / p.w));
        return worst;
    }

    const TriangleMesh& mesh_;
    const Arithmetic arithmetic_;
    double halfX_ = 0, halfY_ = 0, near_ = 0;
    dvec3 reach_{0};  // largest |coordinate| of the mesh's positions
    Row rowX_, rowY_, rowW_;
};

Arithmetic arithmeticOf(const Technique& technique, Precision precision) {
    switch (technique.vertices) {
        case Technique::Vertices::none:
            return Arithmetic::ray;
        case Technique::Vertices::host:
            return Arithmetic::host;
        case Technique::Vertices::linesPass:
        case Technique::Vertices::transformPass:
            break;
    }
    return precision == Precision::fp64           ? Arithmetic::fp64
           : precision == Precision::blockInteger ? Arithmetic::blockInteger
                                                  : Arithmetic::fp32;
}

}  // namespace

double vertexPixels(const Scene& scene, const RenderRequest& request, uint32_t object, Precision precision, double enough) {
    return Bound(scene, request, object, arithmeticOf(techniqueOf(scene, request), precision)).most(enough);
}

std::string quotedObject(const Scene& scene, uint32_t index) {
    const Object& object = scene.objects[index];
    return object.name.empty() ? fmt::format("object {}", index) : fmt::format("'{}'", printable(object.name, 64));
}

std::string upTo(double pixels) { return std::isfinite(pixels) ? fmt::format("up to {:.2g} px", pixels) : std::string("any distance"); }

VertexError vertexErrorOf(const Scene& scene, const RenderRequest& request, uint32_t object) {
    const PlainFloats plain;
    return {object, vertexPixels(scene, request, object, vertexArithmetic(scene, request)[object].precision, 0)};
}

std::vector<VertexError> vertexErrors(const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    const std::vector<VertexArithmetic> drawn = vertexArithmetic(scene, request);
    std::vector<VertexError> errors;
    for (uint32_t i = 0; i < drawn.size(); ++i) {
        const double pixels = vertexPixels(scene, request, i, drawn[i].precision, kToldPixels);
        if (pixels > kToldPixels) errors.push_back({i, pixels});
    }
    return errors;
}

std::string sentenceOf(const Scene& scene, const VertexError& error) {
    const TriangleMesh& mesh = scene.meshes[scene.objects[error.object].mesh];
    const dvec3 size = dvec3(mesh.boundsMax) - dvec3(mesh.boundsMin);
    const bool named = !scene.objects[error.object].name.empty();
    return fmt::format("{}{}: float32 may move a vertex in this view by {}; its mesh is {:g} across, and the view shows a small part of it",
                       named ? "object " : "", quotedObject(scene, error.object), upTo(error.pixels), std::max({size.x, size.y, size.z}));
}

}  // namespace plumb
