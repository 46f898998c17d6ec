// SPDX-License-Identifier: MIT
#include "pipeline/truth/spheres.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace plumb::truth {

namespace {

constexpr double kUnit = 0x1p-53;  // u, unit round-off of binary64
// Factor for second-order terms. The bounds below are first order in u and are themselves computed with a few roundings.
constexpr double kSecondOrder = 1.0 + 0x1p-20;

}  // namespace

Exact SphereTruth::exactRest(uint32_t sphere, double x, double y) const {
    const SphereShape& s = scene_.spheres[sphere];
    const glm::dvec3& eye = scene_.camera->eye;
    const Exact r = s.radius, dx = Exact(x) + Exact(eye.x) - Exact(s.centre.x), dy = Exact(-y) + Exact(eye.y) - Exact(s.centre.y);
    return r * r - dx * dx - dy * dy;
}

bool SphereTruth::covers(Front& front, double x, double y) {
    const SphereShape& s = scene_.spheres[front.sphere];
    const glm::dvec3& eye = scene_.camera->eye;
    // Error of x + eye - centre: u of the sum and of the result, in all at most 2 u of `size`; squared, 4 u of size * |d| and u of the
    // square.
    const double dx = x + eye.x - s.centre.x, dy = -y + eye.y - s.centre.y;
    const double sizeX = std::abs(x) + std::abs(eye.x) + std::abs(s.centre.x), sizeY = std::abs(y) + std::abs(eye.y) + std::abs(s.centre.y);
    const double squares = s.radius * s.radius + dx * dx + dy * dy;
    front.rest = s.radius * s.radius - dx * dx - dy * dy;
    const double moved = 2 * kUnit * sizeX, movedY = 2 * kUnit * sizeY;
    // Error of a square and two differences: 3 u of the squares.
    front.restError =
        (2 * std::abs(dx) * moved + moved * moved + 2 * std::abs(dy) * movedY + movedY * movedY + 3 * kUnit * squares) * kSecondOrder;
    if (std::abs(front.rest) > front.restError) {
        if (front.rest < 0) return false;
    } else {
        ++redone_;
        const Exact rest = exactRest(front.sphere, x, y);
        if (rest.sign() < 0) return false;
        front.rest = std::max(0.0, rest.rounded());
        front.restError = 4 * kUnit * front.rest;
    }
    const double root = std::sqrt(front.rest), away = s.centre.z - eye.z;
    front.depth = away - root;
    // Error of the depth. |sqrt(a) - sqrt(b)| <= |a - b| / sqrt(a), and never more than sqrt(|a - b|); a rounding each of the root and of
    // the two differences.
    const double rootError = root > 0 ? std::min(std::sqrt(front.restError), front.restError / root) : std::sqrt(front.restError);
    front.depthError =
        (rootError + kUnit * (root + std::abs(s.centre.z) + std::abs(eye.z) + std::abs(away) + std::abs(front.depth))) * kSecondOrder;
    return true;
}

// True when a's front is before b's. With A and B the two rests and D = b's centre - a's, A's front is nearer where D + sqrt(A) - sqrt(B) >
// 0.
bool SphereTruth::nearer(const Front& a, const Front& b, double x, double y) {
    if (std::abs(a.depth - b.depth) > (a.depthError + b.depthError) * kSecondOrder) return a.depth < b.depth;
    ++redone_;
    const Exact restA = exactRest(a.sphere, x, y), restB = exactRest(b.sphere, x, y);
    const Exact away = Exact(scene_.spheres[b.sphere].centre.z) - Exact(scene_.spheres[a.sphere].centre.z);
    const int roots = (restA - restB).sign();  // sign of sqrt(A) - sqrt(B)
    if (away.sign() == 0 || roots == 0 || away.sign() == roots) return away.sign() + roots > 0;
    // Opposite signs: |D| is compared with |sqrt(A) - sqrt(B)| by squares, D^2 with A + B - 2 sqrt(A B), so 2 sqrt(A B) with T = A + B -
    // D^2.
    const Exact t = restA + restB - away * away;
    const int gap = t.sign() < 0 ? 1 : (Exact(4) * restA * restB - t * t).sign();  // sign of |D| - |sqrt(A) - sqrt(B)|
    return gap > 0 ? away.sign() > 0 : gap < 0 && roots > 0;
}

SphereTruth::Seen SphereTruth::look(double x, double y) {
    Front best;
    for (uint32_t i = 0; i < scene_.spheres.size(); ++i) {
        Front front{i};
        if (covers(front, x, y) && (best.sphere == kNone || nearer(front, best, x, y))) best = front;
    }
    if (best.sphere == kNone) return {};
    const SphereShape& s = scene_.spheres[best.sphere];
    const glm::dvec3 toCentre = s.centre - scene_.camera->eye, outward(x - toCentre.x, -y - toCentre.y, -std::sqrt(best.rest));
    // Error of the outward vector: u of either difference on both axes, that of the root, which is what the depth is off by at most; of its
    // direction, and of the position, whose sums take u each.
    const glm::dvec3 eye = scene_.camera->eye;
    const double sizes = std::abs(x) + std::abs(y) + 2 * (std::abs(s.centre.x) + std::abs(eye.x) + std::abs(s.centre.y) + std::abs(eye.y));
    const double outwardError = (2 * kUnit * sizes + best.depthError) * kSecondOrder, length = std::hypot(outward.x, outward.y, outward.z);
    const double sum = std::abs(toCentre.x) + std::abs(toCentre.y) + std::abs(toCentre.z) + length;
    const double positionError = (outwardError + 2 * kUnit * (sum + std::abs(s.centre.z) + std::abs(eye.z))) * kSecondOrder;
    const Direction normal{length > 0 ? outward / length : glm::dvec3(0), turnedBy(outwardError, length) + kUnitVectorError};
    return {best.sphere,
            {best.depth, best.depthError},
            illumination_.colourOf(s.material, toCentre + outward, positionError, normal, {{0, 0, -1}, 0})};
}

}  // namespace plumb::truth
