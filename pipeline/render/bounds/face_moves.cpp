// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/face_moves.h"

#include "pipeline/render/prepare.h"
#include "shaders/shared/shade.h"
#include "shaders/shared/transform.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {
namespace {

using glm::dvec3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What becomes of a pixel's normal that is interpolated between unit normals and not made unit, T, where the default's, D, is the unit vector of the
// same sum with each corner's normal as long as the object's transform leaves it.
struct NormalMove {
    double length = 0;        // T is at least this long, and at most 1
    double turn = kHalfTurn;  // between T and D at most
    static constexpr double kHalfTurn = 3.14159265358979323846;
};

// A dozen float32 operations lie between the corners' normals and a pixel's, none of which loses more than a few u of the sum of what is added. That sum is
// 1 / length of the result, so its direction is off by less than 64 u / length.
constexpr double kDirectionError = 0x1p-18;

// `world`: the corners' normals as the transform pass leaves them.
NormalMove moveOfNormals(const dvec3 (&world)[3]) {
    dvec3 unit[3];
    double least = kInfinity, most = 0;
    for (int i = 0; i < 3; ++i) {
        const double length = glm::length(world[i]);
        if (!(length > 0) || !std::isfinite(length)) return {};
        unit[i] = world[i] / length;
        least = std::min(least, length);
        most = std::max(most, length);
    }
    // Least length: with weights a_i that sum to 1 and c the least cosine between two of the unit normals u_i,
    // |sum a_i u_i|^2 >= c + (1 - c) sum a_i^2 >= (1 + 2 c) / 3.
    const double c = std::min({glm::dot(unit[0], unit[1]), glm::dot(unit[1], unit[2]), glm::dot(unit[2], unit[0])});
    NormalMove move;
    move.length = std::sqrt(std::clamp((1 + 2 * c) / 3, 0.0, 1.0));
    if (move.length < 1.0 / 256) return {};
    // D's weights are a_i times the lengths, so the two sets of weights are at most log r apart in Hilbert's metric, r the ratio of the largest length to
    // the least. That metric is the cross-ratio on the line through both, with the edges of the corners' cone. Two directions at an angle of t with a
    // cross-ratio r between them enclose at most 2 atan(k tan(t / 2)), k = (sqrt(r) - 1) / (sqrt(r) + 1); t is at most the largest angle between two
    // corners where that is below a right one.
    const double k = (std::sqrt(most / least) - 1) / (std::sqrt(most / least) + 1);
    if (c > 0) move.turn = 2 * std::atan(k * std::sqrt((1 - std::min(c, 1.0)) / (1 + c)));
    // The weights differ by at most 2 k together, and T is at least `length` long.
    if (2 * k < move.length) move.turn = std::min(move.turn, std::asin(2 * k / move.length));
    move.turn = std::min(move.turn + kDirectionError / move.length, NormalMove::kHalfTurn);
    return move;
}

// The largest cosine between `axis`, a unit vector, and a direction from `apex` to a point that is at most `aside` from the triangle.
double mostCosine(const dvec3& apex, const dvec3& axis, const dvec3 (&p)[3], double aside) {
    dvec3 toward[3], middle(0);
    double nearest = distanceToTriangle(apex, p[0], p[1], p[2]);
    if (!(nearest > aside)) return 1;
    for (int i = 0; i < 3; ++i) {
        toward[i] = glm::normalize(p[i] - apex);
        middle += toward[i];
    }
    if (!(glm::length(middle) > 0.5)) return 1;
    middle = glm::normalize(middle);
    // A cap below a right angle is convex: with the corners it holds the triangle.
    double cosine = 1;
    for (const dvec3& t : toward) cosine = std::min(cosine, glm::dot(middle, t));
    if (!(cosine > 0)) return 1;
    const double apart =
        std::acos(std::clamp(glm::dot(middle, axis), -1.0, 1.0)) - std::acos(std::min(cosine, 1.0)) - std::asin(aside / nearest);
    return std::cos(std::max(0.0, apart - 0x1p-20));
}

bool anyShine(const Material& m) { return std::max({m.specular.x, m.specular.y, m.specular.z}) > 0; }

constexpr int kIntervals = 32;
// x^n begins at x = 2^-20 (specularPower), and its two evaluations are off by 3 2^-23 each.
constexpr double kLeastPower = 0x1p-19;

// Move of the power where both are lit. x = 1 - delta is R.V for the default. For the trade, with E the unit vector of T, R' = 2 (T.L) T - L gives
// x' = x_E - 2 (1 - s^2) (E.L) ((E.V) - s^2 (E.L)).
//   x' below x_E: (E.L) (1 - s^2 (E.L)) is at most 1 / (4 s^2), and at most 1 - s^2 where its maximum 1 / (2 s^2) is beyond 1.
//   x' above x_E: E.V < s^2 E.L, which an E that faces away from the viewer has, too. With a the angle of L to E, b that of V, R and V enclose at least
//     b - a. Where that is a right angle, (E.L) (s^2 (E.L) - (E.V)) reaches (s^2 + sqrt(1 + s^4)) / 2; where it is more, x_E is negative, counts as 0,
//     and x' is no more than this allows.
// x_E is x for a normal that is turned: R turns by twice that at most, so x by 2 sin(turn).
// Both hang on x. With g the angle between R and V, V and E enclose a - g to a + g, so x' - x_E is at most (1 - s^2) (s^2 - x + sqrt(1 + s^4 - 2 s^2 x)),
// which falls with x, and x_E - x' at most (1 - s^2) (x - s^2 + sqrt(1 + s^4 - 2 s^2 x)), largest at x = 1 / (2 s^2). The power's move is then the largest
// of those over intervals of x.
double powerBound(const Material& m, double s2, double turned) {
    const auto n = double(m.shininess);
    if (n == 0) return 0;  // 1 for both
    if (n < 1) return 1;
    const double below = s2 >= 0.5 ? (1 - s2) / (2 * s2) : 2 * (1 - s2) * (1 - s2);
    const double above = (1 - s2) * (s2 + std::sqrt(1 + s2 * s2));
    const double error = 2 * turned + std::ldexp(64.0, -24), x = std::min(1.0, std::max(below, above) + error);
    const double anywhere = std::min(1.0, 1 - std::pow(1 - x, n) + kLeastPower);
    if (anywhere < 2.0 / kIntervals) return anywhere;  // narrower than the intervals
    const auto root = [&](double at) { return std::sqrt(std::max(0.0, 1 + s2 * s2 - 2 * s2 * at)); };
    double worst = 0, first = 0;
    for (int k = 1; k <= kIntervals; ++k) {  // of equal length in x^n
        const double last = std::pow(double(k) / kIntervals, 1 / n), low = std::max(0.0, first - error), high = std::min(1.0, last + error);
        const double steepest = s2 > 0 ? std::clamp(1 / (2 * s2), low, high) : high;
        const double rise = (1 - s2) * std::max(0.0, s2 - low + root(low)), fall = (1 - s2) * std::max(0.0, steepest - s2 + root(steepest));
        worst = std::max({worst, std::pow(std::min(1.0, high + rise), n) - double(k - 1) / kIntervals,
                          double(k) / kIntervals - std::pow(std::max(0.0, low - fall), n)});
        first = last;
    }
    return std::min(anywhere, worst + kLeastPower);
}

enum class Side { lit, dark, either };
// Whether N.L > 0 for D and T alike, wherever in the triangle: N is a sum of the corners' normals with weights above 0, divided by at most 1.
Side sideOf(const Light& light, const dvec3 (&corner)[3], const dvec3 (&normal)[3], double aside, double error) {
    bool allLit = true, allDark = true;
    for (const dvec3& n : normal) {
        const double length = glm::length(n);
        for (const dvec3& p : corner) {
            const dvec3 toward = light.directional ? light.direction : light.position - p;
            const double margin = error * glm::length(toward) + (light.directional ? 0 : 2 * aside), cosine = glm::dot(n, toward) / length;
            allLit &= cosine > margin;
            allDark &= cosine < -margin;
        }
    }
    return allLit ? Side::lit : allDark ? Side::dark : Side::either;
}

}  // namespace

FaceMoves::FaceMoves(const Scene& scene, const RenderRequest& request)
    : scene_(scene),
      request_(request),
      list_(prepare(scene, request).list),
      points_(scene, request),
      native_(request.trade.specular == Trade::Specular::native),
      rough_(request.trade.specular == Trade::Specular::schlick),
      shorter_(!request.trade.unitNormals && request.shading == Shading::phong) {}

void FaceMoves::each(const Wanted& wanted, const Visit& visit) const {
    for (const DrawList::Range& range : list_.ranges) {
        const Object& object = scene_.objects[range.sceneObject];
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        const gpu::ObjectRecord& record = list_.objects[range.record];
        const glm::dmat4 toWorld = worldFromMesh(scene_, object);
        const auto positionOf = [&](const auto& p) { return dvec3(toWorld * glm::dvec4(dvec3(p), 1)); };
        const auto normalOf = [&](const glm::vec4& v) {
            const glm::vec3 n(v);
            return dvec3(gpu::rowTimesVector(record.normal0, n), gpu::rowTimesVector(record.normal1, n),
                         gpu::rowTimesVector(record.normal2, n));
        };
        for (const TriangleMesh::Triangle& t : mesh.triangles) {
            if (!wanted(range.sceneObject, t.face)) continue;
            dvec3 corner[3], normal[3];
            for (size_t i = 0; i < 3; ++i) {
                // Flat shading lights a face at its centre, which need not lie on a triangle of it.
                const bool flat = request_.shading == Shading::flat;
                corner[i] = flat ? positionOf(mesh.faceCentre[t.face]) : positionOf(mesh.positions[t.vertex[i]]);
                normal[i] = normalOf(flat ? list_.faceNormals[range.firstFace + t.face] : list_.normals[range.firstVertex + t.vertex[i]]);
            }
            visit(range.sceneObject, t.face, moveOf(scene_.materials[mesh.faceMaterial[t.face]], corner, normal));
        }
    }
}

FaceMoves::Move FaceMoves::moveOf(const Material& m, const dvec3 (&corner)[3], const dvec3 (&normal)[3]) const {
    const NormalMove move = moveOfNormals(normal);
    const double s = move.length, s2 = s * s, turned = std::sin(std::min(move.turn, NormalMove::kHalfTurn / 2));
    const double aside = points_.aside(corner);
    // |D.L - T.L| <= |D - T|, whose square (1 - |T|)^2 + 2 |T| (1 - cos turn) is largest at an end of |T|'s range.
    const double chord = 2 * (1 - std::cos(move.turn));
    const double diffuse = std::min(1.0, std::sqrt(std::max((1 - s) * (1 - s) + s * chord, chord)) + std::ldexp(16.0, -24));
    const double power = powerBound(m, s2, turned);
    dvec3 either(0), brighter(0), all = dvec3(m.ambient) * dvec3(scene_.ambient) + dvec3(m.emission);
    for (const Light& light : scene_.lights) {
        const Side side = sideOf(light, corner, normal, aside, kDirectionError / std::max(s, kDirectionError));
        if (side == Side::dark) continue;
        const dvec3 reaches =
            dvec3(light.intensity) * fadeAt(light, light.directional ? kInfinity : points_.fromLamp(light.position, corner));
        if (!isFinite(reaches)) return {dvec3(kInfinity), dvec3(kInfinity)};
        const dvec3 shine = reaches * dvec3(m.specular);
        all += reaches * (dvec3(m.diffuse) + dvec3(m.specular));
        if (!anyShine(m) && !shorter_) continue;
        if (native_) either += shine * double(gpu::nativePowerBound(m.shininess));
        if (rough_ && m.shininess != 0) brighter += shine * double(gpu::kSchlickExcess);  // x^0 is 1 for both; never darker
        if (!shorter_) continue;
        const double flip = side == Side::either && power < 1 && anyShine(m) ? flipBound(m, light, corner, aside, turned) : 0;
        either += reaches * dvec3(m.diffuse) * diffuse + shine * std::max(power, flip);
    }
    // Two float32 evaluations of the same sum of terms: each light's product and the sum round a few times. 16 u of all that is added, a light; as much
    // for the mean of 16 samples.
    either += all * std::ldexp(16.0 * double(scene_.lights.size() + 2), -24);
    return {either + brighter, either};
}

// Where one of D and T is lit and the other is not, all of a highlight comes or goes. N.L of the lit one is below sin(turn) then, and R.V below
// -L.V + 2 sin(turn).
double FaceMoves::flipBound(const Material& m, const Light& light, const dvec3 (&corner)[3], double aside, double turned) const {
    if (m.shininess < 1) return 1;  // (R.V)^0 is 1 for every R.V
    const dvec3& eye = scene_.camera->eye;
    const dvec3 viewer(list_.towardViewer);
    double cosine = 1;  // of -L.V at most
    if (light.directional) {
        const dvec3 toward = glm::normalize(light.direction);
        cosine = viewer == dvec3(0) ? mostCosine(eye, toward, corner, aside) : -glm::dot(toward, viewer);
    } else if (viewer != dvec3(0)) {
        cosine = mostCosine(light.position, viewer, corner, aside);
    } else {
        // (lamp - P).(eye - P) = |P - middle|^2 - half^2: negative only within the sphere between lamp and eye.
        const double half = glm::length(light.position - eye) / 2;
        const auto from = [&](const dvec3& to) { return std::max(0.0, distanceToTriangle(to, corner[0], corner[1], corner[2]) - aside); };
        const double middle = from((light.position + eye) / 2.0), lamp = from(light.position), near = from(eye);
        const double inside = half * half - middle * middle;
        cosine = inside <= 0 ? 0 : lamp * near > inside ? inside / (lamp * near) : 1;
    }
    const double x = cosine + 2 * turned + std::ldexp(64.0, -24);
    return x <= 0 ? 0 : std::pow(std::min(1.0, x), double(m.shininess)) + kLeastPower;
}

}  // namespace plumb
