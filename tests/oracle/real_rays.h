// SPDX-License-Identifier: MIT
// A traced picture in real arithmetic, as near as a number type comes to it, from the text of docs/illumination.md: recursion, every shape asked for
// every ray. It shares no code with the truth or with the passes.
#pragma once

#include "tests/oracle/real_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <tuple>
#include <vector>

namespace plumb::oracle {

template <class N>
class RealRays {
public:
    using V = Triple<N>;
    // Rays that weigh less are not followed, and a tree of more rays is given up.
    static constexpr double kLeastWeight = 0x1p-40;
    static constexpr uint32_t kMostRays = 3000, kMostDepth = 200;

    RealRays(const Scene& scene, uint32_t width, uint32_t height, const glm::dvec3& sky)
        : scene_(scene), light_(scene), sky_(sky), triangles_(realTriangles<N>(scene)) {
        const Camera& camera = *scene.camera;
        const double focal =
            camera.focalPixels > 0
                ? camera.focalPixels
                : double(height / 2.0L / std::tan(Long(camera.fovYDegrees) * 3.14159265358979323846264338327950288L / 360));
        forward_ = N(focal) * V(camera.forward);
        right_ = V(camera.right);
        down_ = V(-camera.up);
        width_ = width;
        height_ = height;
        for (const Material& m : scene.materials) shares_.push_back(raySharesOf(m));
        for (const SphereShape& s : scene.spheres) centres_.push_back(V(s.centre) - V(camera.eye));
        for (const PlaneShape& p : scene.planes) points_.push_back(V(p.point) - V(camera.eye));
        for (const RealTriangle<N>& t : triangles_) {
            const V area = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]).unit();
            outward_.push_back(t.mirrored ? N(-1) * area : area);
        }
        brightest_ = N(std::max({sky.x, sky.y, sky.z}));
        V light;
        for (const auto& lamp : light_.lamps()) light = light + mostFade(lamp) * lamp.intensity;
        for (const Material& m : scene.materials) {
            const V most = light_.base(m) + light * (V(m.diffuse) + V(m.specular));
            brightest_ = std::max({brightest_, most.x, most.y, most.z});
        }
    }

    RealSample<N> look(uint32_t column, uint32_t row) {
        const N x = N(2 * int(column) + 1 - int(width_)) / 2, y = N(2 * int(row) + 1 - int(height_)) / 2;
        out_ = {};
        rays_ = 0;
        follow({V(), (forward_ + x * right_ + y * down_).unit(), 1, 1, Kind::none, 0, false});
        return out_;
    }

private:
    enum class Kind { none, sphere, plane, triangle };
    struct Ray {
        V origin, d;
        N weight;
        uint32_t depth;
        Kind kind;  // what it starts on, which one, and whether it runs inside of that sphere
        uint32_t index;
        bool inside;
    };
    struct Hit {
        Kind kind = Kind::none;
        uint32_t index = 0;
        N t = -1;
        bool inside = false;  // the ray runs with the outward normal
        bool open = false;    // within the error of being there or not
        uint32_t material = 0;
        N share[3] = {};
    };

    // The largest factor by which a lamp's light reaches a surface: infinite where the lamp may touch one.
    N mostFade(const typename RealLight<N>::Lamp& lamp) const {
        if (lamp.fading == 0) return 1;
        N least = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < scene_.spheres.size(); ++i)
            least = std::min(least, magnitude((centres_[i] - lamp.at).length() - N(scene_.spheres[i].radius)));
        for (size_t i = 0; i < scene_.planes.size(); ++i)
            least = std::min(least, magnitude(V(scene_.planes[i].normal).dot(points_[i] - lamp.at)));
        for (const RealTriangle<N>& t : triangles_) {
            const N away = (t.corner[0] - lamp.at).length();
            least = std::min(least,
                             std::max(N(0), away - std::max((t.corner[1] - t.corner[0]).length(), (t.corner[2] - t.corner[0]).length())));
        }
        N fade = 1;
        for (int i = 0; i < lamp.fading; ++i) fade = fade / least;
        return least > 0 ? fade : N(std::numeric_limits<double>::infinity());
    }

    // Relative error of a decision at a depth: 2^12 round-offs, times 64 a hit.
    double near(const Ray& r) const {
        double off = 4096 * kRoundOff<N>;
        for (uint32_t i = 0; i < r.depth && off < 0x1p-24; ++i) off *= 64;
        return std::min(off, 0x1p-24);
    }

    Hit sphere(uint32_t i, const Ray& r) const {
        const SphereShape& s = scene_.spheres[i];
        Hit h;
        h.kind = Kind::sphere;
        h.index = i;
        h.material = s.material;
        const bool on = r.kind == Kind::sphere && r.index == i;
        if (on && !r.inside) return h;
        const V f = r.origin - centres_[i];
        const N b = f.dot(r.d), radius = s.radius, c = f.dot(f) - radius * radius, square = b * b - c,
                size = f.dot(f) + radius * radius + centres_[i].dot(centres_[i]);
        const N off = N(near(r)) * size;
        if (square < -off) return h;
        h.open = square <= off || (!on && magnitude(c) <= off);
        const N root = squareRoot(square > 0 ? square : N(0));
        h.inside = on || c < 0;
        h.t = h.inside ? root - b : -b - root;
        return h;
    }
    Hit plane(uint32_t i, const Ray& r) const {
        const PlaneShape& p = scene_.planes[i];
        Hit h;
        h.kind = Kind::plane;
        h.index = i;
        if (r.kind == Kind::plane && r.index == i) return h;
        const V n(p.normal), way = points_[i] - r.origin;
        const N slope = n.dot(r.d), height = n.dot(way), off = N(near(r));
        if (magnitude(slope) <= off) {
            h.open = true;
            h.t = magnitude(height) <= off * (way.size() + points_[i].size()) ? N(0) : magnitude(height) / (2 * off);
            return h;
        }
        if (!p.twoSided && slope > 0) return h;
        const N t = height / slope;
        const N tOff = off * (way.size() + points_[i].size() + magnitude(t)) / magnitude(slope);
        if (t < -tOff) return h;
        h.inside = slope > 0;
        h.open = t <= tOff;
        const V q = t * r.d - way;
        const N u = q.dot(V(p.u)), v = q.dot(V(p.v));
        for (const auto& [at, least, most] : {std::tuple(u, p.uMin, p.uMax), std::tuple(v, p.vMin, p.vMax)}) {
            if (at < N(least) - tOff || at > N(most) + tOff) return {Kind::plane, i};
            h.open = h.open || at < N(least) + tOff || at > N(most) - tOff;
        }
        h.t = t;
        h.material = p.material;
        if (p.square > 0) {
            bool other = u < 0;
            const N period = 2 * N(p.square);
            for (const N at : {u, v}) {
                const N size = magnitude(at), within = size - period * wholeOf(size / period);
                other = other != (within > N(p.square));
                for (const N line : {N(0), N(p.square), period}) h.open = h.open || magnitude(within - line) <= tOff;
            }
            if (v < 0 && !p.mirrored) other = !other;
            if (other) h.material = p.otherMaterial;
        }
        return h;
    }
    Hit triangle(uint32_t i, const Ray& r) const {
        Hit h;
        h.kind = Kind::triangle;
        h.index = i;
        if (r.kind == Kind::triangle && r.index == i) return h;
        const RealTriangle<N>& t = triangles_[i];
        const Meeting<N> m = meetingOf(r.origin, r.d, t.corner, t.reach, near(r));
        const N third = m.over - m.first - m.second, least = std::min({m.first, m.second, third}),
                most = std::max({m.first, m.second, third});
        if (least < -m.slack && most > m.slack) return h;
        h.material = t.material;
        if (magnitude(m.over) <= m.slack) {
            h.open = true;
            h.t = 0;
            return h;
        }
        const N at = m.distance / m.over, tOff = m.slack * (t.reach + r.origin.size() + magnitude(at)) / magnitude(m.over);
        if (at < -tOff) return h;
        h.open = !(least > m.slack || most < -m.slack) || at <= tOff;
        h.t = at;
        h.share[1] = m.first / m.over;
        h.share[2] = m.second / m.over;
        h.share[0] = 1 - h.share[1] - h.share[2];
        h.inside = r.d.dot(outward_[i]) > 0;
        return h;
    }
    template <class Body>
    void each(const Ray& r, const Body& body) const {
        for (uint32_t i = 0; i < scene_.spheres.size(); ++i) body(sphere(i, r));
        for (uint32_t i = 0; i < scene_.planes.size(); ++i) body(plane(i, r));
        for (uint32_t i = 0; i < triangles_.size(); ++i) body(triangle(i, r));
    }

    Hit nearest(const Ray& r) {
        Hit best;
        N rival = std::numeric_limits<double>::infinity();
        each(r, [&](const Hit& h) {
            if (h.t < 0 && !h.open) return;
            if (h.open) rival = std::min(rival, h.t);
            if (!(h.t > 0)) return;
            if (best.kind == Kind::none || h.t < best.t) {
                if (best.kind != Kind::none) rival = std::min(rival, best.t);
                best = h;
            } else {
                rival = std::min(rival, h.t);
            }
        });
        if (best.kind == Kind::none ? rival < std::numeric_limits<double>::infinity()
                                    : best.open || rival <= best.t * (1 + N(near(r)) * 4096))
            out_.sure = false;
        return best;
    }

    struct Surface {
        V position, geometric, normal, bends;
        bool inside = false;
    };
    Surface surfaceOf(const Ray& r, const Hit& h) {
        Surface s;
        s.position = r.origin + h.t * r.d;
        s.inside = h.inside;
        const N turn = h.inside ? N(-1) : N(1);
        if (h.kind == Kind::sphere) s.geometric = turn * (s.position - centres_[h.index]).unit();
        if (h.kind == Kind::plane) s.geometric = turn * V(scene_.planes[h.index].normal);
        s.normal = s.bends = s.geometric;
        if (h.kind != Kind::triangle) return s;
        const RealTriangle<N>& t = triangles_[h.index];
        s.geometric = s.bends = turn * outward_[h.index];
        s.normal = turn * (h.share[0] * t.normal[0].unit() + h.share[1] * t.normal[1].unit() + h.share[2] * t.normal[2].unit()).unit();
        const RayShares& shares = shares_[h.material];
        if (shares.reflect > 0 || shares.transmit > 0) bend(r, s);
        return s;
    }
    static N leastSlope(const Ray& r, const Surface& s) { return std::min(N(0x1p-10), magnitude(r.d.dot(s.geometric)) / 2); }
    void bend(const Ray& r, Surface& s) {
        const N off = N(near(r)) * 64, lean = s.normal.dot(s.geometric);
        if (magnitude(lean - N(1) / 16) <= off) out_.sure = false;
        if (lean <= N(1) / 16) return;
        const N c = std::max(N(0), -r.d.dot(s.normal)), least = leastSlope(r, s);
        const V m = r.d + 2 * c * s.normal;
        const N slope = m.dot(s.geometric);
        if (magnitude(slope - least) <= off) out_.sure = false;
        if (slope >= least) {
            s.bends = s.normal;
            return;
        }
        const V b = (m + (least - slope) * s.geometric).unit() - r.d;
        if (magnitude(b.length() - N(0x1p-18)) <= off) out_.sure = false;
        if (b.length() >= N(0x1p-18)) s.bends = b.unit();
    }

    N reaching(const Ray& shadow, const N& end) {
        N share = 1;
        bool open = false;
        each(shadow, [&](const Hit& h) {
            if (h.t < 0 && !h.open) return;
            const N factor = N(shares_[h.material].transmit), off = N(near(shadow)) * 4096 * (end < 1e300 ? end : N(1));
            if (h.t > end + off) return;
            const bool counts = h.kind != Kind::triangle || factor == 0 || h.inside;
            if (h.open || magnitude(h.t - end) <= off) open = true;
            if (h.t > 0 && h.t < end && counts) share = share * factor;
        });
        if (open) out_.sure = false;
        return share;
    }

    V local(const Ray& r, const Hit& h, const Surface& s) {
        const Material& m = scene_.materials[h.material];
        V colour = light_.base(m);
        for (const auto& lamp : light_.lamps()) {
            const V way = lamp.directional ? lamp.at : lamp.at - s.position;
            const V l = way.unit();
            const N above = s.geometric.dot(l), off = N(near(r)) * 64;
            bool open = magnitude(above) <= off;
            const V part = light_.part(lamp, m, s.position, s.normal, N(-1) * r.d, double(off), open);
            if (open) out_.sure = false;
            if (!(above > 0) || !(part.size() > 0)) continue;
            N share = 1;
            if (scene_.shadows)
                share = reaching({s.position, l, 1, r.depth + 1, h.kind, h.index, s.inside},
                                 lamp.directional ? N(std::numeric_limits<double>::infinity()) : way.length());
            colour = colour + share * part;
        }
        return colour;
    }

    void follow(const Ray& r) {
        if (++rays_ > kMostRays || r.depth > kMostDepth || !out_.sure) {
            out_.sure = false;
            return;
        }
        const Hit h = nearest(r);
        if (!out_.sure) return;
        if (h.kind == Kind::none) {
            out_.colour = out_.colour + r.weight * V(sky_);
            return;
        }
        const Surface s = surfaceOf(r, h);
        if (r.depth == 1) note(h);
        const RayShares& shares = shares_[h.material];
        if (shares.local > 0) out_.colour = out_.colour + r.weight * N(shares.local) * local(r, h, s);
        if (shares.reflect == 0 && shares.transmit == 0) return;
        const N index = scene_.materials[h.material].refractiveIndex, q = s.inside ? index : 1 / index, k = -r.d.dot(s.bends),
                g = 1 - q * q * (1 - k * k);
        if (shares.transmit > 0 && magnitude(g) <= N(near(r)) * 64 * (1 + q * q)) out_.sure = false;
        const bool total = shares.transmit > 0 && g <= 0;
        const N mirror = N(shares.reflect) + (total ? N(shares.transmit) : N(0));
        send({s.position, (r.d + 2 * k * s.bends).unit(), r.weight * mirror, r.depth + 1, h.kind, h.index, s.inside});
        if (shares.transmit == 0 || total) return;
        V bent = q * r.d + (q * k - squareRoot(g)) * s.bends;
        if (h.kind == Kind::triangle && index != 1) {
            const N missing = leastSlope(r, s) + bent.dot(s.geometric);
            if (missing > 0) bent = bent - missing * s.geometric;
        }
        send({s.position, bent.unit(), r.weight * N(shares.transmit), r.depth + 1, h.kind, h.index, !s.inside});
    }
    void send(const Ray& child) {
        if (child.weight == 0) return;
        if (double(child.weight) < kLeastWeight) {
            out_.allowance = out_.allowance + child.weight * brightest_;
            return;
        }
        follow(child);
    }
    void note(const Hit& h) {
        out_.depth = h.t;
        out_.face = 0;
        const auto objects = uint32_t(scene_.objects.size()), spheres = uint32_t(scene_.spheres.size());
        out_.object = h.kind == Kind::sphere  ? objects + h.index
                      : h.kind == Kind::plane ? objects + spheres + h.index
                                              : triangles_[h.index].object;
        if (h.kind == Kind::triangle) out_.face = triangles_[h.index].face;
    }

    const Scene& scene_;
    RealLight<N> light_;
    glm::dvec3 sky_;
    std::vector<RealTriangle<N>> triangles_;
    std::vector<V> outward_, centres_, points_;
    std::vector<RayShares> shares_;
    V forward_, right_, down_;
    uint32_t width_ = 0, height_ = 0, rays_ = 0;
    N brightest_ = 0;
    RealSample<N> out_;
};

}  // namespace plumb::oracle
