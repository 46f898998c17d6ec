// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/bound.h"

#include "pipeline/render/bounds/bound_light.h"
#include "pipeline/render/bounds/face_moves.h"
#include "pipeline/render/technique.h"
#include "shaders/shared/shade.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <unordered_map>

namespace plumb {

namespace {

using glm::dvec3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

ColourBound notProved(const char* why) {
    ColourBound bound;
    bound.proved = false;
    bound.why = why;
    return bound;
}

bool isLit(const RenderRequest& request) { return request.shading != Shading::unlit && request.shading != Shading::wire; }

// Takes into `bound` the largest moves over the faces of `scene`, or of those in `shown`, and the moves of each pixel.
void takeMoves(const Scene& scene, const RenderRequest& request, const Frame* shown, ColourBound& bound) {
    const FaceMoves moves(scene, request);
    if (shown == nullptr) {
        moves.each([](uint32_t, uint32_t) { return true; },
                   [&](uint32_t, uint32_t, const FaceMoves::Move& move) {
                       bound.linear = glm::max(bound.linear, move.brighter);
                       bound.darker = glm::max(bound.darker, move.darker);
                   });
    } else {
        std::unordered_map<uint64_t, FaceMoves::Move> faces;
        const auto key = [](uint32_t object, uint32_t face) { return uint64_t(object) << 32 | face; };
        for (size_t at = 0; at < shown->object.size(); ++at)
            if (shown->object[at] != kNone) faces[key(shown->object[at], shown->primitive[at])] = {};
        moves.each([&](uint32_t object, uint32_t face) { return faces.count(key(object, face)) != 0; },
                   [&](uint32_t object, uint32_t face, const FaceMoves::Move& move) {
                       FaceMoves::Move& most = faces[key(object, face)];
                       most.brighter = glm::max(most.brighter, move.brighter);
                       most.darker = glm::max(most.darker, move.darker);
                   });
        bound.brighterAt.assign(3 * shown->object.size(), 0.0f);
        bound.darkerAt.assign(3 * shown->object.size(), 0.0f);
        for (size_t at = 0; at < shown->object.size(); ++at) {
            if (shown->object[at] == kNone) continue;
            const FaceMoves::Move& move = faces[key(shown->object[at], shown->primitive[at])];
            bound.linear = glm::max(bound.linear, move.brighter);
            bound.darker = glm::max(bound.darker, move.darker);
            for (size_t c = 0; c < 3; ++c) {  // float32 rounds them to nearest
                bound.brighterAt[3 * at + c] = float(move.brighter[glm::length_t(c)] * (1 + 0x1p-22));
                bound.darkerAt[3 * at + c] = float(move.darker[glm::length_t(c)] * (1 + 0x1p-22));
            }
        }
    }
    if (isFinite(bound.linear))
        bound.linear = glm::max(bound.linear, bound.darker);
    else
        bound = notProved(kLampTouches);
}

// The spheres of --fill notes: the device's power at the lamp's least distance from each, and two float32 evaluations of one sum of terms.
void takeSpheres(const Scene& scene, ColourBound& bound) {
    for (const SphereShape& sphere : scene.spheres) {
        const Material& m = scene.materials[sphere.material];
        dvec3 all = dvec3(m.ambient) * dvec3(scene.ambient) + dvec3(m.emission), move(0);
        for (const Light& light : scene.lights) {
            const double from = glm::length(sphere.centre - light.position);
            const double nearest = std::max(0.0, std::abs(from - sphere.radius) - std::ldexp(from + sphere.radius, -20));
            const dvec3 reaches = dvec3(light.intensity) * fadeAt(light, light.directional ? kInfinity : nearest);
            all += reaches * (dvec3(m.diffuse) + dvec3(m.specular));
            move += reaches * dvec3(m.specular) * double(gpu::nativePowerBound(m.shininess));
        }
        move += all * std::ldexp(16.0 * double(scene.lights.size() + 2), -24);
        bound.linear = glm::max(bound.linear, move);
        bound.darker = glm::max(bound.darker, move);
    }
    if (!isFinite(bound.linear)) bound = notProved(kLampTouches);
}

}  // namespace

ColourBound boundOfNative(const Scene& scene, const RenderRequest& request, const Frame* shown) {
    ColourBound bound;
    if (request.trade.nativeEncode && request.encoding == Encoding::srgb) bound.steps = 1;
    if (request.trade.specular != Trade::Specular::native || !isLit(request)) return bound;
    if (techniqueOf(scene, request).parallel) {
        takeSpheres(scene, bound);
        return bound;
    }
    RenderRequest alone = request;
    alone.trade.unitNormals = true;
    takeMoves(scene, alone, shown, bound);
    return bound;
}

ColourBound boundOfTrade(const Scene& scene, const RenderRequest& request, const Frame* shown) {
    const Trade& t = request.trade;
    const Technique::Vertices vertices = techniqueOf(scene, request).vertices;
    if (vertices == Technique::Vertices::none || vertices == Technique::Vertices::host)
        return notProved("only the raster shadings of --fill exact have bounds of their choices");
    if (t.vectors != Trade::Vectors::pixel)
        return notProved("a direction that is not the pixel's own may turn N.L's sign, and with it a highlight comes or goes at once");
    if (t.precision != Precision::fp32) return notProved("a vertex that is off by less may be snapped to the next 1/256 px");
    if (t.affine) return notProved("linear on the screen may be off by all that an attribute spans over a triangle");
    if (t.depthBits != 32) return notProved("triangles that fall together tie, and another one may be seen");
    if (t.subpixelBits != 8) return notProved("a vertex may move by 1/32 px, and its triangle with it");
    if (t.coarse) return notProved("a pixel may show its neighbour's colour");
    const bool rough = t.specular == Trade::Specular::schlick, shorter = !t.unitNormals && request.shading == Shading::phong;
    if (!isLit(request) || (!rough && !shorter)) return boundOfNative(scene, request, shown);
    if (rough)
        for (const Material& m : scene.materials)
            if (std::max({m.specular.x, m.specular.y, m.specular.z}) > 0 && m.shininess > 0 && m.shininess < 1)
                return notProved("Schlick's quotient has a bound for exponents from 1 up only");
    ColourBound bound;
    if (t.nativeEncode && request.encoding == Encoding::srgb) bound.steps = 1;
    takeMoves(scene, request, shown, bound);
    return bound;
}

}  // namespace plumb
