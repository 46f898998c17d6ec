// SPDX-License-Identifier: MIT
#include "pipeline/render/bound.h"

#include "pipeline/scene/ray_shares.h"
#include "shaders/shared/encode.h"
#include "shaders/shared/fill.h"
#include "shaders/shared/shade.h"

#include <cstdint>
#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace plumb {

namespace {

using glm::dvec3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// From a point to the nearest of a triangle (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5).
double distanceToTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
                 d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return glm::length(ap);
    if (d3 >= 0 && d4 <= d3) return glm::length(bp);
    if (d6 >= 0 && d5 <= d6) return glm::length(cp);
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(ap - ab * (d1 / (d1 - d3)));
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(ap - ac * (d2 / (d2 - d6)));
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return glm::length(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    const double sum = va + vb + vc;
    return sum > 0 ? glm::length(ap - (ab * vb + ac * vc) / sum) : 0;
}

template <class Visit>
void eachTriangle(const Scene& scene, const Visit& visit) {
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        for (const TriangleMesh::Triangle& t : mesh.triangles) visit(object, mesh, t);
    }
}

// The most light of all lamps that any surface can get, in each channel: attenuation by the least distance to a triangle, less what float32 may
// move a corner by (2^-20 of its distance from the origin of the scene).
dvec3 mostLight(const Scene& scene) {
    dvec3 sum(0);
    for (const Light& light : scene.lights) {
        double fade = 1;
        if (!light.directional && light.attenuation != Attenuation::none) {
            double nearest = kInfinity, reach = 0;
            eachTriangle(scene, [&](const Object& object, const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
                dvec3 p[3];
                for (int i = 0; i < 3; ++i)
                    p[i] = dvec3(object.worldFromObject * glm::dvec4(mesh.positions[t.vertex[size_t(i)]], 1));
                for (const dvec3& corner : p) reach = std::max(reach, glm::length(corner - scene.camera->eye));
                nearest = std::min(nearest, distanceToTriangle(light.position, p[0], p[1], p[2]));
            });
            // Rays meet these, too; a bounded plane is part of the whole one.
            for (const SphereShape& s : scene.spheres) {
                nearest = std::min(nearest, std::abs(glm::length(s.centre - light.position) - s.radius));
                reach = std::max(reach, glm::length(s.centre - scene.camera->eye) + s.radius);
            }
            for (const PlaneShape& p : scene.planes) {
                nearest = std::min(nearest, std::abs(glm::dot(p.normal, light.position - p.point)));
                reach = std::max(reach, glm::length(light.position - scene.camera->eye));
            }
            nearest = std::max(0.0, nearest - std::ldexp(reach, -20));
            fade = nearest == kInfinity ? 0 : 1 / std::pow(nearest, int(light.attenuation));
        }
        sum += dvec3(light.intensity) * fade;
    }
    return sum;
}

// The least square of the length of a normal that is interpolated between the unit normals of a triangle's corners: with weights a_i that sum to 1
// and c the least cosine between two of them, |sum a_i n_i|^2 >= c + (1 - c) sum a_i^2 >= (1 + 2 c) / 3.
double leastSquaredNormal(const Scene& scene) {
    double least = 1;
    eachTriangle(scene, [&](const Object& object, const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
        const glm::dmat3 n = glm::inverse(glm::transpose(glm::dmat3(object.worldFromObject)));
        dvec3 unit[3];
        for (int i = 0; i < 3; ++i) {
            unit[i] = n * dvec3(mesh.normals[t.vertex[size_t(i)]]);
            const double length = glm::length(unit[i]);
            if (!(length > 0) || !std::isfinite(length)) return void(least = 0);
            unit[i] /= length;
        }
        const double c = std::min({glm::dot(unit[0], unit[1]), glm::dot(unit[1], unit[2]), glm::dot(unit[2], unit[0])});
        least = std::min(least, std::max(0.0, (1 + 2 * c) / 3));
    });
    return least;
}

// The largest of what a material makes of a bound of its power and of its diffuse part, times the light that there is.
template <class PowerBound>
dvec3 times(const Scene& scene, const dvec3& light, double diffuse, const PowerBound& power) {
    dvec3 most(0);
    for (const Material& m : scene.materials)
        for (int c = 0; c < 3; ++c) {
            const double shine = m.specular[c] > 0 ? double(m.specular[c]) * power(m.shininess) : 0;
            most[c] = std::max(most[c], light[c] * (double(m.diffuse[c]) * diffuse + shine));
        }
    return most;
}

// Two float32 evaluations of the same sum of terms: each light's product and the sum round a few times. 16 u of all that is added, a light.
dvec3 slack(const Scene& scene, const dvec3& light) {
    dvec3 most(0);
    for (const Material& m : scene.materials)
        for (int c = 0; c < 3; ++c)
            most[c] = std::max(most[c], double(m.ambient[c]) * double(scene.ambient[c]) + double(m.emission[c]) +
                                            light[c] * (double(m.diffuse[c]) + double(m.specular[c])));
    return most * std::ldexp(16.0 * double(scene.lights.size() + 1), -24);
}

// The most weight that a tree of rays may leave below `least`, its last rays `depth` deep: the worst sequence of materials, each of which mirrors, or lets
// pass, or both, or mirrors all of it.
class CutWeight {
public:
    CutWeight(const Scene& scene, double least, uint32_t depth) : least_(least), depth_(depth) {
        for (const Material& m : scene.materials) {
            const RayShares s = raySharesOf(m);
            if (s.reflect > 0 || s.transmit > 0) shares_.insert({double(s.reflect), double(s.transmit)});
        }
    }
    double most() { return least_ > 0 ? below(1, 1) : 0; }

private:
    static constexpr size_t kMostStates = 100000;

    double below(double weight, uint32_t depth) {
        if (depth >= depth_) return 0;
        const auto known = known_.find({weight, depth});
        if (known != known_.end()) return known->second;
        if (known_.size() > kMostStates) return weight;  // no more can be left of it
        double worst = 0;
        for (const auto& [reflect, transmit] : shares_) {
            worst = std::max(worst, child(weight * reflect, depth) + child(weight * transmit, depth));
            if (transmit > 0) worst = std::max(worst, child(weight * (reflect + transmit), depth));
        }
        return known_[{weight, depth}] = std::min(worst, weight);
    }
    // float32 multiplies weights: within 64 u of the cutoff it may decide either way.
    double child(double weight, uint32_t depth) {
        const double slack = std::ldexp(64.0, -24) * least_;
        double worst = 0;
        if (weight < least_ + slack) worst = weight;
        if (weight >= least_ - slack) worst = std::max(worst, below(weight, depth + 1));
        return worst;
    }

    const double least_;
    const uint32_t depth_;
    std::set<std::pair<double, double>> shares_;
    std::map<std::pair<double, uint32_t>, double> known_;
};

// Rays of a sample at most.
double mostRays(double sentOn, bool branching, double least, uint32_t depth) {
    double count = 0;
    for (uint32_t k = 0; k < depth; ++k) {
        const double heavy = least > 0 ? std::pow(sentOn, k) / least : kInfinity;
        count += branching ? std::min(std::ldexp(1.0, int(k)), heavy) : 1;
    }
    return count;
}

bool isLit(const RenderRequest& request) {
    return request.shading != Shading::unlit && request.shading != Shading::wire;
}

}  // namespace

ColourBound boundOfNative(const Scene& scene, const RenderRequest& request) {
    ColourBound bound;
    if (request.trade.nativeEncode && request.encoding == Encoding::srgb) bound.steps = 1;
    if (request.trade.specular != Trade::Specular::native || !isLit(request)) return bound;
    const dvec3 light = mostLight(scene);
    bound.linear =
        times(scene, light, 0, [](float n) { return double(gpu::nativePowerBound(n)); }) + slack(scene, light);
    if (!std::isfinite(bound.linear.x + bound.linear.y + bound.linear.z))
        return {false, dvec3(0), 0, "a light that fades with distance may touch a surface"};
    return bound;
}

ColourBound boundOfDepth(const Scene& scene, const RenderRequest& base, const RenderRequest& request) {
    const auto none = [](const char* why) { return ColourBound{false, dvec3(0), 0, why}; };
    if (request.rays.cutLevels) return none("whole levels are cut after each ray");
    const dvec3 light = mostLight(scene);
    dvec3 brightest(request.background);
    double sentOn = 0;
    bool branching = false;
    for (const Material& m : scene.materials) {
        for (int c = 0; c < 3; ++c)
            brightest[c] = std::max(brightest[c], double(m.ambient[c]) * double(scene.ambient[c]) + double(m.emission[c]) + light[c] * (double(m.diffuse[c]) + double(m.specular[c])));
        const RayShares s = raySharesOf(m);
        sentOn = std::max(sentOn, double(s.reflect) + double(s.transmit));
        branching |= s.reflect > 0 && s.transmit > 0;
    }
    if (!std::isfinite(brightest.x + brightest.y + brightest.z)) return none("a light that fades with distance may touch a surface");
    double weight = 0;
    const uint32_t shallow = std::min(base.maxDepth, request.maxDepth), deep = std::max(base.maxDepth, request.maxDepth);
    if (shallow != deep) weight += std::pow(sentOn, shallow);
    if (base.minWeight != request.minWeight) {
        const double least = double(std::max(base.minWeight, request.minWeight)), other = double(std::min(base.minWeight, request.minWeight));
        weight += std::max(CutWeight(scene, least, deep).most(), CutWeight(scene, other, deep).most());
    }
    // Both pictures round each of their sums to u of it; products within them take fewer than 2^7 operations.
    const double rays = mostRays(sentOn, branching, double(std::min(base.minWeight, request.minWeight)), deep);
    ColourBound bound;
    bound.linear = brightest * (std::min(weight, 1.0) + (rays + 128) * std::ldexp(1.0, -23));
    return bound;
}

ColourBound boundOfTrade(const Scene& scene, const RenderRequest& request) {
    const Trade& t = request.trade;
    const auto none = [](const char* why) { return ColourBound{false, dvec3(0), 0, why}; };
    if (request.shading == Shading::ray || request.fill == Fill::notes)
        return none("only the raster shadings of --fill exact have bounds of their choices");
    if (t.vectors != Trade::Vectors::pixel)
        return none("a direction that is not the pixel's own may turn N.L's sign, and with it a highlight comes or goes at once");
    if (t.numbers != Numbers::fp32) return none("a vertex that is off by less may be snapped to the next 1/256 px");
    if (t.affine) return none("linear on the screen may be off by all that an attribute spans over a triangle");
    if (t.depthBits != 32) return none("triangles that fall together tie, and another one may be seen");
    if (t.subpixelBits != 8) return none("a vertex may move by 1/32 px, and its triangle with it");
    if (t.coarse) return none("a pixel may show its neighbour's colour");
    ColourBound bound = boundOfNative(scene, request);
    if (!bound.proved || !isLit(request)) return bound;
    const bool rough = t.specular == Trade::Specular::schlick,
               shorter = !t.unitNormals && request.shading == Shading::phong;
    if (!rough && !shorter) return bound;
    const dvec3 light = mostLight(scene);
    double least = 1;  // shininess of what shines
    for (const Material& m : scene.materials)
        if (std::max({m.specular.x, m.specular.y, m.specular.z}) > 0) least = std::min(least, double(m.shininess));
    if (rough) {
        if (least < 1) return none("Schlick's quotient has a bound for exponents from 1 up only");
        bound.linear += times(scene, light, 0, [](float) { return double(gpu::kSchlickExcess); });
    }
    if (shorter) {
        // A normal of length s: N.L falls by 1 - s at most. 1 - R.V becomes |R' - V|^2 / 2 with R' = 2 (N.L) N - L, |R'| <= 1, which differs by
        // 2 (1 - s^2) ((N.L)(N.V) - s^2 (N.L)^2), at most 2 (1 - s^2) either way; its power then by at most n times that for n >= 1.
        const double s2 = leastSquaredNormal(scene), moved = 2 * (1 - s2) + std::ldexp(64.0, -24);
        bound.linear += times(scene, light, 1 - std::sqrt(s2) + std::ldexp(16.0, -24), [&](float n) {
            return n == 0 ? 0 : n < 1 ? 1 : std::min(1.0, double(n) * moved);
        });
    }
    bound.linear += slack(scene, light);
    if (!std::isfinite(bound.linear.x + bound.linear.y + bound.linear.z))
        return none("a light that fades with distance may touch a surface");
    return bound;
}

}  // namespace plumb
