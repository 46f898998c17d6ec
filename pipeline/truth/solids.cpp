// SPDX-License-Identifier: MIT
#include "pipeline/truth/solids.h"

#include "pipeline/scene/shape.h"
#include "pipeline/truth/real.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <utility>

namespace plumb::truth {
namespace {

// A number with a bound of its error. Bounds are first order in u, computed in binary64, with a factor for what that leaves out.
template <class Real>
struct Near {
    Real value = 0;
    double error = 0;

    static constexpr double kUnit = kUnitOf<Real>;
    static constexpr double kRest = 1 + 0x1p-20;
    static double size(Real x) { return std::abs(double(x)); }
    double reach() const { return size(value) + error; }
    bool isOpen() const { return !(size(value) > error); }

    friend Near operator+(const Near& a, const Near& b) {
        const Real v = a.value + b.value;
        return {v, (a.error + b.error + kUnit * size(v)) * kRest};
    }
    Near operator-() const { return {-value, error}; }
    friend Near operator-(const Near& a, const Near& b) { return a + -b; }
    friend Near operator*(const Near& a, const Near& b) {
        const Real v = a.value * b.value;
        return {v, (a.reach() * b.error + a.error * size(b.value) + kUnit * size(v)) * kRest};
    }
    friend Near operator/(const Near& a, const Near& b) {
        const Real v = a.value / b.value;
        const double least = size(b.value) - b.error;
        return {v, least > 0 ? ((a.error + size(v) * b.error) / least + kUnit * size(v)) * kRest : double(INFINITY)};
    }
};

template <class Real>
Near<Real> rooted(const Near<Real>& a) {
    const double least = double(a.value) - a.error;
    const Real v = rootOf(a.value > 0 ? a.value : Real(0));
    const double moved = least > 0 ? a.error / (2 * std::sqrt(least)) : std::sqrt(a.reach());
    return {v, (moved + 2 * Near<Real>::kUnit * Near<Real>::size(v)) * Near<Real>::kRest};
}

template <class Real>
struct Vector {
    Near<Real> x, y, z;
};
template <class Real>
Vector<Real> vectorOf(const glm::dvec3& v) {
    return {{Real(v.x)}, {Real(v.y)}, {Real(v.z)}};
}
template <class Real>
Near<Real> along(const Vector<Real>& a, const Vector<Real>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
Vector<Real> across(const Vector<Real>& a, const Vector<Real>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
Vector<Real> added(const Vector<Real>& a, const Vector<Real>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
Vector<Real> scaled(const Vector<Real>& a, const Near<Real>& s) {
    return {a.x * s, a.y * s, a.z * s};
}

// One side of a body along the ray: where it is entered or left, by which surface.
template <class Real>
struct Passage {
    Near<Real> at;
    bool cap = false;
};

// A ray against one body, in one precision.
template <class Real>
class Meeting {
public:
    Meeting(const Solids::Body& body, const Pinhole& pinhole, double x, double y, bool cull) : body_(body) {
        const Near<Real> focal{Real(pinhole.focal)};
        direction_ = added(
            added(scaled(vectorOf<Real>(pinhole.right), Near<Real>{Real(x)}), scaled(vectorOf<Real>(pinhole.down), Near<Real>{Real(y)})),
            scaled(vectorOf<Real>(pinhole.forward), focal));
        // Inverse of the matrix by cofactors: rows are cross products of its columns over the determinant.
        const glm::dmat4& m = body.worldFromObject;
        const Vector<Real> c0 = vectorOf<Real>(glm::dvec3(m[0])), c1 = vectorOf<Real>(glm::dvec3(m[1])),
                           c2 = vectorOf<Real>(glm::dvec3(m[2]));
        rows_[0] = across(c1, c2);
        rows_[1] = across(c2, c0);
        rows_[2] = across(c0, c1);
        const Near<Real> determinant = along(c0, rows_[0]);
        for (Vector<Real>& row : rows_) row = {row.x / determinant, row.y / determinant, row.z / determinant};
        const Vector<Real> fromOrigin = {Near<Real>{Real(pinhole.eye.x)} - Near<Real>{Real(m[3].x)},
                                         Near<Real>{Real(pinhole.eye.y)} - Near<Real>{Real(m[3].y)},
                                         Near<Real>{Real(pinhole.eye.z)} - Near<Real>{Real(m[3].z)}};
        eye_ = {along(rows_[0], fromOrigin), along(rows_[1], fromOrigin), along(rows_[2], fromOrigin)};
        ray_ = {along(rows_[0], direction_), along(rows_[1], direction_), along(rows_[2], direction_)};
        if (!(body.cylinder ? meetCylinder() : meetSphere())) return;
        // Depth w = t f, and the front is seen first.
        const Near<Real> near{Real(pinhole.near)}, front = in_.at * focal, back = out_.at * focal;
        if (!isBelow(front, near)) {
            hit_ = in_;
            w_ = front;
        } else if (!cull && !isBelow(back, near)) {
            hit_ = out_;
            w_ = back;
        }
    }

    bool open() const { return open_; }
    bool met() const { return hit_.has_value(); }
    SolidHit hit() const {
        SolidHit hit;
        hit.object = body_.object;
        hit.material = body_.material;
        hit.w = inDouble(w_);
        const Vector<Real> place = scaled(direction_, hit_->at), p = added(eye_, scaled(ray_, hit_->at));
        hit.position = inDouble(place, hit.positionError);
        Vector<Real> n = p;
        const Near<Real> none{Real(0)};
        if (body_.cylinder && hit_->cap)
            n = {none, {Real(p.y.value > 0 ? 1 : -1)}, none};
        else if (body_.cylinder)
            n.y = none;
        // Normals go by the transposed inverse.
        double off = 0;
        const glm::dvec3 world = inDouble(added(added(scaled(rows_[0], n.x), scaled(rows_[1], n.y)), scaled(rows_[2], n.z)), off);
        const double length = glm::length(world);
        hit.normal = {world / length, turnedBy(off, length) + kUnitVectorError};
        return hit;
    }

private:
    static Bounded inDouble(const Near<Real>& a) {
        const double v = double(a.value);
        return {v, (a.error + kDoubleUnit * std::abs(v)) * kOwnRounding};
    }
    static glm::dvec3 inDouble(const Vector<Real>& v, double& off) {
        const Bounded x = inDouble(v.x), y = inDouble(v.y), z = inDouble(v.z);
        off = std::sqrt(x.error * x.error + y.error * y.error + z.error * z.error) * kOwnRounding;
        return {x.value, y.value, z.value};
    }
    bool isBelow(const Near<Real>& a, const Near<Real>& b) {
        const Near<Real> difference = a - b;
        open_ |= difference.isOpen();
        return difference.value < 0;
    }

    // Roots of a t^2 + 2 b t + c. False: the ray passes by.
    bool meetQuadric(const Near<Real>& a, const Near<Real>& b, const Near<Real>& c) {
        const Near<Real> d = b * b - a * c;
        open_ |= d.isOpen();
        if (!(d.value > 0)) return false;
        const Near<Real> root = rooted(d);
        in_ = {(-b - root) / a};
        out_ = {(-b + root) / a};
        return true;
    }
    bool meetSphere() {
        const Near<Real> r{Real(body_.radius)};
        return meetQuadric(along(ray_, ray_), along(eye_, ray_), along(eye_, eye_) - r * r);
    }
    bool meetCylinder() {
        const Near<Real> r{Real(body_.radius)}, half{Real(body_.half)};
        const Near<Real> a = ray_.x * ray_.x + ray_.z * ray_.z, c = eye_.x * eye_.x + eye_.z * eye_.z - r * r;
        const bool alongAxis = a.isOpen();  // the ray runs along the axis, and is inside or outside all the way
        if (alongAxis) {
            open_ |= c.isOpen();
            if (!(c.value < 0)) return false;
        } else if (!meetQuadric(a, eye_.x * ray_.x + eye_.z * ray_.z, c)) {
            return false;
        }
        if (ray_.y.isOpen()) {  // the ray runs across the axis, between the caps or not
            const bool above = isBelow(half, eye_.y), below = isBelow(eye_.y, -half);
            return !above && !below && !alongAxis;
        }
        Passage<Real> low{(-half - eye_.y) / ray_.y, true}, high{(half - eye_.y) / ray_.y, true};
        if (ray_.y.value < 0) std::swap(low, high);
        if (alongAxis) {
            in_ = low;
            out_ = high;
            return true;
        }
        if (isBelow(in_.at, low.at)) in_ = low;
        if (isBelow(high.at, out_.at)) out_ = high;
        return isBelow(in_.at, out_.at);
    }

    const Solids::Body& body_;
    Vector<Real> rows_[3], direction_, eye_,
        ray_;  // rows: of the inverse; direction: world axes, 1 sample at distance f; eye and ray: object space
    Passage<Real> in_, out_;
    std::optional<Passage<Real>> hit_;
    Near<Real> w_;
    bool open_ = false;
};

// Box on the screen of a body's own box, a sample wider; everywhere where the body reaches the near plane.
void boundOnScreen(Solids::Body& body, const Pinhole& pinhole) {
    const double h = body.cylinder ? body.half : body.radius;
    for (int i = 0; i < 2; ++i) body.low[i] = INFINITY, body.high[i] = -INFINITY;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 p(corner & 1 ? body.radius : -body.radius, corner & 2 ? h : -h, corner & 4 ? body.radius : -body.radius, 1);
        const glm::dvec3 fromEye = glm::dvec3(body.worldFromObject * p) - pinhole.eye;
        const double w = glm::dot(fromEye, pinhole.forward);
        const double at[2] = {pinhole.focal * glm::dot(fromEye, pinhole.right) / w, pinhole.focal * glm::dot(fromEye, pinhole.down) / w};
        for (int i = 0; i < 2; ++i) {
            body.low[i] = w > pinhole.near ? std::min(body.low[i], at[i] - 1) : -INFINITY;
            body.high[i] = w > pinhole.near ? std::max(body.high[i], at[i] + 1) : INFINITY;
        }
        if (!(w > pinhole.near)) return;
    }
}

}  // namespace

Solids::Solids(const Scene& scene, const Pinhole& pinhole) : scene_(scene), pinhole_(pinhole) {
    for (uint32_t o = 0; o < scene.objects.size(); ++o) {
        if (!standsForSolid(scene, o)) continue;
        const TriangleMesh& mesh = scene.meshes[scene.objects[o].mesh];
        Body body;
        body.object = o;
        body.material = mesh.faceMaterial.front();
        body.cylinder = mesh.shape->kind == ShapeKind::cylinder;
        body.radius = mesh.shape->radius;
        body.half = mesh.shape->length / 2;
        body.worldFromObject = scene.objects[o].worldFromObject;
        boundOnScreen(body, pinhole);
        bodies_.push_back(body);
    }
}

SolidHit Solids::look(double x, double y, Counts& counts) const {
    SolidHit best;
    for (const Body& body : bodies_) {
        if (x < body.low[0] || x > body.high[0] || y < body.low[1] || y > body.high[1]) continue;
        SolidHit hit;
        const Meeting<double> meeting(body, pinhole_, x, y, scene_.cullBackFaces);
        if (meeting.open()) {
            ++counts.redone;
            const Meeting<Quad> again(body, pinhole_, x, y, scene_.cullBackFaces);
            counts.undecided += again.open();
            if (again.met()) hit = again.hit();
        } else if (meeting.met()) {
            hit = meeting.hit();
        }
        if (hit.object == kNone) continue;
        counts.undecided += best.object != kNone && std::abs(best.w.value - hit.w.value) <= best.w.error + hit.w.error;
        if (best.object == kNone || hit.w.value < best.w.value) best = hit;
    }
    return best;
}

}  // namespace plumb::truth
