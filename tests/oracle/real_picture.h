// SPDX-License-Identifier: MIT
// A picture in real arithmetic, as near as a number type comes to it, from the formulas of docs/illumination.md. Polygons are met by the test of
// Moeller and Trumbore (Fast, minimum storage ray/triangle intersection, 1997), one after another. It shares no code with the truth or with the passes.
// A decision that lies within the type's own error makes the sample unsure.
#pragma once

#include "pipeline/scene/ray_shares.h"
#include "pipeline/scene/scene.h"
#include "tests/oracle/more_bits.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::oracle {

template <class N>
struct RealSample {
    bool sure = true;  // nothing that the colour depends on lies within the type's own error
    Triple<N> colour;  // linear RGB, not clamped
    N allowance = 0;   // no channel is further off for rays that were not followed
    uint32_t object = kNone, face = kNone;
    N depth = 0;  // planar, scene units; with rays the distance from the eye
};

// Light that reaches a point and the point formula; what raster and rays have in common.
template <class N>
class RealLight {
public:
    using V = Triple<N>;
    explicit RealLight(const Scene& scene) : scene_(scene) {
        for (const Light& light : scene.lights) {
            const V v = light.directional ? V(light.direction).unit() : V(light.position) - V(scene.camera->eye);
            lamps_.push_back({light.directional, v, V(light.intensity), light.directional ? 0 : int(light.attenuation)});
        }
    }
    struct Lamp {
        bool directional;
        V at;  // unit direction, or position relative to the eye
        V intensity;
        int fading;  // exponent of 1/d
    };
    const std::vector<Lamp>& lamps() const { return lamps_; }
    V base(const Material& m) const { return V(m.ambient) * V(scene_.ambient) + V(m.emission); }

    // Part of one lamp where N.L > 0, and 0 elsewhere. `open` is raised by no less than what may be there and not here, if N.L is within `near` of 0.
    V part(const Lamp& lamp, const Material& m, const V& position, const V& normal, const V& toViewer, double near, bool& open) const {
        const V way = lamp.directional ? lamp.at : lamp.at - position;
        const N distance = way.length();
        if (!lamp.directional && !(distance > 0)) {
            open = true;
            return {};
        }
        const V l = (1 / distance) * way;
        const N cosine = normal.dot(l);
        // A surface that shines at N.L = 0 has a step there; the diffuse part alone has none.
        if (double(magnitude(cosine)) <= near && V(m.specular).size() > 0) open = true;
        if (!(cosine > 0)) return {};
        const V r = 2 * cosine * normal - l;
        const N shine = power(r.dot(toViewer), N(m.shininess));
        N fade = 1;
        for (int i = 0; i < lamp.fading; ++i) fade = fade / distance;
        return fade * (lamp.intensity * (cosine * V(m.diffuse) + shine * V(m.specular)));
    }

private:
    const Scene& scene_;
    std::vector<Lamp> lamps_;
};

// Corners and normals of all triangles, relative to the eye on world axes.
template <class N>
struct RealTriangle {
    Triple<N> corner[3], normal[3];  // normals by the inverse transpose, of any length
    N reach = 0;                     // no smaller than the terms that a coordinate of a corner is the sum of
    uint32_t object = 0, face = 0, material = 0;
    bool mirrored = false;
};

template <class N>
std::vector<RealTriangle<N>> realTriangles(const Scene& scene) {
    using V = Triple<N>;
    std::vector<RealTriangle<N>> out;
    for (uint32_t o = 0; o < scene.objects.size(); ++o) {
        const glm::dmat4& m = scene.objects[o].worldFromObject;
        const TriangleMesh& mesh = scene.meshes[scene.objects[o].mesh];
        const V column[3] = {V(glm::dvec3(m[0])), V(glm::dvec3(m[1])), V(glm::dvec3(m[2]))}, eye(scene.camera->eye);
        const N determinant = column[0].dot(column[1].cross(column[2]));
        const N turn = determinant < 0 ? N(-1) : N(1);
        const V cofactor[3] = {turn * column[1].cross(column[2]), turn * column[2].cross(column[0]), turn * column[0].cross(column[1])};
        for (const TriangleMesh::Triangle& t : mesh.triangles) {
            RealTriangle<N> r;
            r.object = o;
            r.face = t.face;
            r.material = mesh.faceMaterial[t.face];
            r.mirrored = determinant < 0;
            for (int i = 0; i < 3; ++i) {
                const V p(mesh.statedAt(t.vertex[i])), n(mesh.normals[t.vertex[i]]), origin{glm::dvec3(m[3])};
                r.corner[i] = p.x * column[0] + p.y * column[1] + p.z * column[2] + (origin - eye);
                r.normal[i] = n.x * cofactor[0] + n.y * cofactor[1] + n.z * cofactor[2];
                r.reach = std::max(r.reach, magnitude(p.x) * column[0].size() + magnitude(p.y) * column[1].size() +
                                                magnitude(p.z) * column[2].size() + origin.size() + eye.size());
            }
            out.push_back(r);
        }
    }
    return out;
}

// Where a ray meets a triangle: numerators of the shares of corners 1 and 2 and of the distance over their common denominator, and what all of them are
// off by.
template <class N>
struct Meeting {
    N first, second, distance, over, slack;
};
template <class N>
Meeting<N> meetingOf(const Triple<N>& origin, const Triple<N>& d, const Triple<N> (&corner)[3], N reach, double unit) {
    const Triple<N> e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], t = origin - corner[0];
    const Triple<N> p = d.cross(e2), q = t.cross(e1);
    const N size = reach + origin.size();
    return {t.dot(p), d.dot(q), e2.dot(q), e1.dot(p), N(unit) * d.size() * size * size};
}

// Raster: Phong at every sample, perspective, vertices where they are.
template <class N>
class RealRaster {
public:
    using V = Triple<N>;
    // Error of a decision, relative to the sum of magnitudes of its terms: 2^16 round-offs.
    static constexpr double kDecision = 65536 * kRoundOff<N>;

    // Samples of a picture of `width` x `height` pixels with `side` samples along a pixel's edge.
    RealRaster(const Scene& scene, uint32_t width, uint32_t height, uint32_t side)
        : scene_(scene), light_(scene), width_(width * side), height_(height * side), triangles_(realTriangles<N>(scene)) {
        const Camera& camera = *scene.camera;
        focal_ = camera.focalPixels > 0
                     ? camera.focalPixels * side
                     : double(height_ / 2.0L / std::tan(Long(camera.fovYDegrees) * 3.14159265358979323846264338327950288L / 360));
        near_ = camera.near > 0 ? camera.near : std::ldexp(1.0, std::ilogb(camera.focusDistance) - 10);
        const V right(camera.right), down(-camera.up), forward(camera.forward);
        for (const RealTriangle<N>& t : triangles_) {
            Flat flat;
            for (int i = 0; i < 3; ++i)
                flat.corner[i] = {N(focal_) * right.dot(t.corner[i]), N(focal_) * down.dot(t.corner[i]), forward.dot(t.corner[i])};
            flat.reach = t.reach * std::max(N(focal_), N(1)) * 2;
            bound(flat);
            flat_.push_back(flat);
        }
    }

    RealSample<N> look(int column, int row) const {
        const V d(N(2 * column + 1 - int(width_)) / 2, N(2 * row + 1 - int(height_)) / 2, 1), eye;
        RealSample<N> out;
        N nearest = 0, nearestSlack = 0, rival = -1;
        int best = -1;
        Meeting<N> at{};
        for (size_t i = 0; i < flat_.size(); ++i) {
            const Flat& f = flat_[i];
            if (double(d.x) < f.low[0] || double(d.x) > f.high[0] || double(d.y) < f.low[1] || double(d.y) > f.high[1]) continue;
            Meeting<N> m = meetingOf(eye, d, f.corner, f.reach, kDecision);
            const N third = m.over - m.first - m.second, least = std::min({m.first, m.second, third}),
                    most = std::max({m.first, m.second, third});
            if (least < -m.slack && most > m.slack) continue;  // missed
            if (magnitude(m.over) <= m.slack) {
                out.sure = false;  // seen from its edge
                continue;
            }
            const bool front = (m.over > 0) != (triangles_[i].mirrored != scene_.leftHanded);
            if (scene_.cullBackFaces && !front) continue;
            bool sure = least > m.slack || most < -m.slack;
            const N w = m.distance / m.over, slack = m.slack * (f.reach + magnitude(w)) / magnitude(m.over);
            if (w < N(near_) - slack) continue;
            sure = sure && w > N(near_) + slack;
            if (best < 0 || w < nearest) {
                if (best >= 0) rival = rival < 0 ? nearest - nearestSlack : std::min(rival, nearest - nearestSlack);
                best = int(i), nearest = w, nearestSlack = slack, at = m;
                out.sure = out.sure && sure;
            } else {
                rival = rival < 0 ? w - slack : std::min(rival, w - slack);
                out.sure = out.sure && (sure || w - slack > nearest + nearestSlack);
            }
        }
        if (best < 0) return out;
        out.sure = out.sure && (rival < 0 || rival > nearest + nearestSlack);
        shade(triangles_[size_t(best)], at, nearest, out);
        return out;
    }

private:
    struct Flat {
        V corner[3];  // camera axes: to the right and down times the focal length, forward
        N reach = 0;
        double low[2], high[2];  // box of the samples that may meet it, from the middle
    };
    void bound(Flat& f) const {
        for (int k = 0; k < 2; ++k) f.low[k] = -INFINITY, f.high[k] = INFINITY;
        for (const V& c : f.corner)
            if (double(c.z) < near_) return;
        for (int k = 0; k < 2; ++k) {
            double low = INFINITY, high = -INFINITY;
            for (const V& c : f.corner) low = std::min(low, double(c.at(k) / c.z)), high = std::max(high, double(c.at(k) / c.z));
            f.low[k] = low - 1, f.high[k] = high + 1;
        }
    }
    void shade(const RealTriangle<N>& t, const Meeting<N>& m, N w, RealSample<N>& out) const {
        const N u = m.first / m.over, v = m.second / m.over, rest = 1 - u - v;
        const V position = rest * t.corner[0] + u * t.corner[1] + v * t.corner[2];
        const V normal = (rest * t.normal[0] + u * t.normal[1] + v * t.normal[2]).unit();
        const V toViewer = scene_.distantViewer.value_or(false) ? (N(-1) * V(scene_.camera->forward)).unit() : (N(-1) * position).unit();
        const Material& material = scene_.materials[t.material];
        out.object = t.object;
        out.face = t.face;
        out.depth = w;
        out.colour = light_.base(material);
        bool open = false;
        for (const auto& lamp : light_.lamps())
            out.colour = out.colour + light_.part(lamp, material, position, normal, toViewer, kDecision, open);
        out.sure = out.sure && !open;
    }

    const Scene& scene_;
    RealLight<N> light_;
    uint32_t width_, height_;
    double focal_ = 0, near_ = 0;
    std::vector<RealTriangle<N>> triangles_;
    std::vector<Flat> flat_;
};

}  // namespace plumb::oracle
