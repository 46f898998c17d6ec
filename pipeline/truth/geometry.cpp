// SPDX-License-Identifier: MIT
#include "pipeline/truth/geometry.h"

#include "pipeline/scene/flattened.h"
#include "pipeline/scene/shape.h"
#include "pipeline/truth/real.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb::truth {

namespace {

constexpr double kUnit = 0x1p-53;  // u, unit round-off of binary64
// Factor for second-order terms. The bounds below are first order in u and are themselves computed in binary64 with fewer than 2^20
// operations.
constexpr double kSecondOrder = 1.0 + 0x1p-20;

// Terms above this many times their sum: the sum cancels, and binary64 would keep little of it.
constexpr double kCancels = 64;
// Share of the terms that is left of them in the error of a sum in binary128: four roundings of 2^-113, in parts of 5 u.
constexpr double kQuadShare = 0x1p-60;

// Magnitude |x| + |error of x|: no smaller than the true magnitude.
double reach(const Bounded& x) { return std::abs(x.value) + x.error; }

// Difference p q - r s. Each product is off by the errors of its factors and u of itself, the difference by u of itself: 2 u of both
// products in all.
Bounded productDifference(const Bounded& p, const Bounded& q, const Bounded& r, const Bounded& s) {
    const double pq = reach(p) * reach(q), rs = reach(r) * reach(s);
    const double propagated = reach(p) * q.error + p.error * reach(q) + reach(r) * s.error + r.error * reach(s);
    return {p.value * q.value - r.value * s.value, (propagated + 2 * kUnit * (pq + rs)) * kSecondOrder};
}

struct Cross {
    Bounded a, b, c;
};
Cross cross(const Corner& p, const Corner& q) {
    return {productDifference(p.y, q.w, p.w, q.y), productDifference(p.w, q.x, p.x, q.w), productDifference(p.x, q.y, p.y, q.x)};
}

// Dot product p . n: three products (u each) and two additions.
Bounded dotProduct(const Corner& p, const Cross& n) {
    const double sum = reach(p.x) * reach(n.a) + reach(p.y) * reach(n.b) + reach(p.w) * reach(n.c);
    const double propagated = reach(p.x) * n.a.error + p.x.error * reach(n.a) + reach(p.y) * n.b.error + p.y.error * reach(n.b) +
                              reach(p.w) * n.c.error + p.w.error * reach(n.c);
    return {p.x.value * n.a.value + p.y.value * n.b.value + p.w.value * n.c.value, (propagated + 3 * kUnit * sum) * kSecondOrder};
}

// Range of columns or rows whose sample may lie in [low, high] (centred coordinates).
void sampleRange(double low, double high, double size, int& first, int& last) {
    first = int(std::clamp(std::floor(low + size / 2 - 0.5), -1.0, size));
    last = int(std::clamp(std::ceil(high + size / 2 - 0.5), -1.0, size));
    first = std::max(first, 0);
    last = std::min(last, int(size) - 1);
}

}  // namespace

Pinhole::Pinhole(const Camera& camera, uint32_t pixelsX, uint32_t pixelsY, uint32_t side, double samplesMoved)
    : width(double(pixelsX) * side),
      height(double(pixelsY) * side),
      shift(samplesMoved),
      eye(camera.eye),
      right(camera.right),
      down(-camera.up),
      forward(camera.forward) {
    constexpr long double kPi = 3.14159265358979323846264338327950288L;
    focal = camera.focalPixels > 0 ? camera.focalPixels * side
                                   : double(height / 2 / std::tan(static_cast<long double>(camera.fovYDegrees) * kPi / 360));
    near = camera.near > 0 ? camera.near : std::ldexp(1.0, std::ilogb(camera.focusDistance) - 10);
}

Corner Geometry::corner(uint32_t object, uint32_t vertex) const {
    const Object& o = scene_.objects[object];
    const glm::dvec3 p = scene_.meshes[o.mesh].statedAt(vertex);
    Corner corner;
    // Error on world axes relative to the eye: each coordinate is the sum of three products and one difference, 5 u of the sum of their
    // magnitudes at most.
    glm::dvec3 magnitude;
    for (int j = 0; j < 3; ++j) {
        const double origin = o.worldFromObject[3][j] - pinhole_.eye[j];
        double sum = origin, size = std::abs(origin);
        for (int k = 0; k < 3; ++k) {
            sum += o.worldFromObject[k][j] * p[k];
            size += std::abs(o.worldFromObject[k][j] * p[k]);
        }
        corner.fromEye[j] = sum;
        magnitude[j] = size;
    }
    if (glm::length(magnitude) > kCancels * glm::length(corner.fromEye)) {
        // A mesh far from 0, or a camera: products of binary64 numbers are exact in binary128, and four roundings are left.
        for (int j = 0; j < 3; ++j) {
            Quad sum = Quad(o.worldFromObject[3][j]) - Quad(pinhole_.eye[j]);
            for (int k = 0; k < 3; ++k) sum += Quad(o.worldFromObject[k][j]) * Quad(p[k]);
            corner.fromEye[j] = double(sum);
            magnitude[j] = std::abs(corner.fromEye[j]) + kQuadShare * magnitude[j];
        }
    }
    corner.fromEyeError = 5 * kUnit * glm::length(magnitude) * kSecondOrder;
    // Error along a camera axis: three products, two additions and the scale are 4 u more of |axis| . magnitude, which is no less than
    // |axis| . |fromEye|.
    const auto along = [&](const glm::dvec3& axis, double scale) {
        double sum = 0, size = 0;
        for (int j = 0; j < 3; ++j) {
            sum += axis[j] * corner.fromEye[j];
            size += std::abs(axis[j]) * magnitude[j];
        }
        return Bounded{scale * sum, 9 * kUnit * scale * size * kSecondOrder};
    };
    corner.x = along(pinhole_.right, pinhole_.focal);
    corner.y = along(pinhole_.down, pinhole_.focal);
    corner.w = along(pinhole_.forward, 1);
    return corner;
}

std::array<Exact, 3> Geometry::exactCorner(uint32_t object, uint32_t vertex) const {
    const Object& o = scene_.objects[object];
    const glm::dvec3 p = scene_.meshes[o.mesh].statedAt(vertex);
    std::array<Exact, 3> fromEye;
    for (int j = 0; j < 3; ++j) {
        fromEye[size_t(j)] = Exact(o.worldFromObject[3][j]) - pinhole_.eye[j];
        for (int k = 0; k < 3; ++k) fromEye[size_t(j)] = fromEye[size_t(j)] + Exact(o.worldFromObject[k][j]) * p[k];
    }
    const auto along = [&](const glm::dvec3& axis, double scale) {
        return (fromEye[0] * axis.x + fromEye[1] * axis.y + fromEye[2] * axis.z) * scale;
    };
    return {along(pinhole_.right, pinhole_.focal), along(pinhole_.down, pinhole_.focal), along(pinhole_.forward, 1)};
}

ExactTriangle Geometry::exactly(const Triangle& t) const {
    std::array<std::array<Exact, 3>, 3> p;
    for (size_t i = 0; i < 3; ++i) p[i] = exactCorner(t.object, t.vertex[i]);
    ExactTriangle e;
    for (size_t i = 0; i < 3; ++i) {
        const auto &q = p[(i + 1) % 3], &r = p[(i + 2) % 3];
        e.a[i] = q[1] * r[2] - q[2] * r[1];
        e.b[i] = q[2] * r[0] - q[0] * r[2];
        e.c[i] = q[0] * r[1] - q[1] * r[0];
    }
    e.volume = p[0][0] * e.a[0] + p[0][1] * e.b[0] + p[0][2] * e.c[0];
    if (e.volume.sign() < 0) {
        for (int i = 0; i < 3; ++i) e.a[i] = e.a[i].negated(), e.b[i] = e.b[i].negated(), e.c[i] = e.c[i].negated();
        e.volume = e.volume.negated();
    }
    return e;
}

void Geometry::add(uint32_t object, uint32_t index, bool mirrored) {
    const TriangleMesh& mesh = scene_.meshes[scene_.objects[object].mesh];
    const TriangleMesh::Triangle& source = mesh.triangles[index];
    Triangle t;
    t.object = object;
    t.triangle = index;
    t.vertex = {source.vertex[0], source.vertex[mirrored ? 2 : 1], source.vertex[mirrored ? 1 : 2]};
    const Corner* p[3];
    for (size_t i = 0; i < 3; ++i) p[i] = &corners_[t.vertex[i]];
    const double near = pinhole_.near;
    bool behind = true;
    for (const Corner* q : p) behind &= q->w.value + q->w.error < near;
    if (behind) return;

    Cross n[3];
    for (int i = 0; i < 3; ++i) n[i] = cross(*p[(i + 1) % 3], *p[(i + 2) % 3]);
    const Bounded volume = dotProduct(*p[0], n[0]);
    // Sign of the front. Camera axes are right-handed seen from the eye (right, down, forward), so a front that runs counter-clockwise has
    // D < 0.
    int sign = volume.value > 0 ? 1 : -1;
    if (std::abs(volume.value) <= volume.error) {
        ++redone_;
        const auto exact = [&] {
            std::array<std::array<Exact, 3>, 3> e;
            for (size_t i = 0; i < 3; ++i) e[i] = exactCorner(object, t.vertex[i]);
            return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                    e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]))
                .sign();
        };
        sign = exact();
    }
    if (sign == 0 || (sign > 0 && scene_.cullBackFaces)) return;

    const double halfX = pinhole_.width / 2 + pinhole_.shift, halfY = pinhole_.height / 2 + pinhole_.shift;
    double total[3] = {0, 0, 0}, totalError = 0;
    for (int i = 0; i < 3; ++i) {
        t.a[i] = sign * n[i].a.value;
        t.b[i] = sign * n[i].b.value;
        t.c[i] = sign * n[i].c.value;
        // Error of E_i anywhere in the frame, |X| < halfX, |Y| < halfY: two products and two additions, 3 u of the sum of magnitudes.
        const double size = halfX * reach(n[i].a) + halfY * reach(n[i].b) + reach(n[i].c);
        t.error[i] = (halfX * n[i].a.error + halfY * n[i].b.error + n[i].c.error + 3 * kUnit * size) * kSecondOrder;
        total[0] += t.a[i];
        total[1] += t.b[i];
        total[2] += t.c[i];
        totalError += t.error[i] + 2 * kUnit * size;  // the sums of three add 2 u
    }
    const double depth = std::abs(volume.value), least = depth - volume.error;
    t.sa = total[0] / depth;
    t.sb = total[1] / depth;
    t.sc = total[2] / depth;
    // Error of S / D: the error of S over the least |D|, that of D times the largest quotient, and 4 u for division, products and
    // additions.
    const double largest = halfX * std::abs(t.sa) + halfY * std::abs(t.sb) + std::abs(t.sc);
    t.inverseError = least > 0 ? (totalError / least + largest * (volume.error / least + 4 * kUnit)) * kSecondOrder : INFINITY;
    if (!std::isfinite(t.inverseError)) t.inverseError = INFINITY;

    // Box of the samples that the triangle may cover. It encloses the corners, or the polygon that the near plane leaves, and is wider by
    // the corners' errors and one sample.
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    const auto widen = [&](double x, double y, double w, const Corner& by) {
        const double px = x / w, py = y / w;
        const double slack = 1 + (by.x.error + by.y.error + (std::abs(px) + std::abs(py)) * by.w.error) / w;
        low[0] = std::min(low[0], px - slack), high[0] = std::max(high[0], px + slack);
        low[1] = std::min(low[1], py - slack), high[1] = std::max(high[1], py + slack);
    };
    const double front = near / 2;  // a plane in front of the near plane: rounding does not bring the cut past that
    bool everywhere = false;
    for (int i = 0; i < 3; ++i) {
        const Corner &q = *p[i], &r = *p[(i + 1) % 3];
        everywhere |= q.w.error > near / 8;
        if (q.w.value >= front) widen(q.x.value, q.y.value, q.w.value, q);
        if ((q.w.value >= front) != (r.w.value >= front)) {
            const double s = (front - q.w.value) / (r.w.value - q.w.value);
            const Corner& worse = q.x.error + q.y.error + q.w.error > r.x.error + r.y.error + r.w.error ? q : r;
            widen(q.x.value + s * (r.x.value - q.x.value), q.y.value + s * (r.y.value - q.y.value), front, worse);
        }
    }
    if (everywhere) low[0] = low[1] = -INFINITY, high[0] = high[1] = INFINITY;
    const double shift = pinhole_.shift;
    sampleRange(low[0] + shift, high[0] + shift, pinhole_.width, t.firstColumn, t.lastColumn);
    sampleRange(low[1] + shift, high[1] + shift, pinhole_.height, t.firstRow, t.lastRow);
    if (t.firstColumn <= t.lastColumn && t.firstRow <= t.lastRow) triangles_.push_back(t);
}

Geometry::Geometry(const Scene& scene, const Pinhole& pinhole) : scene_(scene), pinhole_(pinhole) {
    for (uint32_t o = 0; o < scene.objects.size(); ++o) {
        if (standsForSolid(scene, o)) continue;
        const TriangleMesh& mesh = scene.meshes[scene.objects[o].mesh];
        corners_.clear();
        for (uint32_t v = 0; v < mesh.positions.size(); ++v) corners_.push_back(corner(o, v));
        const bool mirrored = scene.leftHanded != mirrors(scene.objects[o].worldFromObject);
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) add(o, t, mirrored);
    }
}

const ExactTriangle& Judge::exactly(uint32_t index) {
    const auto found = known_.find(index);
    if (found != known_.end()) return found->second;
    if (known_.size() > 4096) known_.clear();
    return known_.emplace(index, geometry_.exactly(geometry_.triangles()[index])).first->second;
}

bool Judge::hits(uint32_t index, double x, double y) {
    const Triangle& t = geometry_.triangles()[index];
    bool doubtful = false;
    for (int i = 0; i < 3; ++i) {
        const double e = t.a[i] * x + t.b[i] * y + t.c[i];
        if (e < -t.error[i]) return false;
        doubtful |= !(e > t.error[i]);
    }
    if (doubtful) {
        ++redone_;
        const ExactTriangle& exact = exactly(index);
        for (int i = 0; i < 3; ++i) {
            const int sign = exact.edge(i, x, y).sign();
            if (sign < 0) return false;
            if (sign > 0) continue;
            const int right = exact.a[i].sign();  // E grows to the right: a left edge
            if (right < 0 || (right == 0 && exact.b[i].sign() <= 0)) return false;
        }
    }
    const double inverse = t.sa * x + t.sb * y + t.sc, limit = 1 / geometry_.pinhole().near;
    const double slack = t.inverseError + 2 * kUnit * limit;
    if (inverse - limit < -slack && inverse > slack) return true;
    if (inverse - limit > slack || inverse < -slack) return false;
    ++redone_;
    const ExactTriangle& exact = exactly(index);
    const Exact sum = exact.edge(0, x, y) + exact.edge(1, x, y) + exact.edge(2, x, y);
    return sum.sign() > 0 && (exact.volume - sum * geometry_.pinhole().near).sign() >= 0;
}

bool Judge::nearer(uint32_t index, uint32_t best, double x, double y) {
    const Triangle &t = geometry_.triangles()[index], &u = geometry_.triangles()[best];
    const double difference = (t.sa * x + t.sb * y + t.sc) - (u.sa * x + u.sb * y + u.sc);
    const double slack = (t.inverseError + u.inverseError) * kSecondOrder;
    if (std::abs(difference) > slack) return difference > 0;
    ++redone_;
    const ExactTriangle p = exactly(index), q = exactly(best);  // copies: the table may be emptied between the two
    const Exact pSum = p.edge(0, x, y) + p.edge(1, x, y) + p.edge(2, x, y), qSum = q.edge(0, x, y) + q.edge(1, x, y) + q.edge(2, x, y);
    const int sign = (pSum * q.volume - qSum * p.volume).sign();
    return sign > 0 || (sign == 0 && index < best);
}

}  // namespace plumb::truth
