// SPDX-License-Identifier: MIT
#include "tests/stress/scene_truth.h"

#include "pipeline/truth/geometry.h"
#include "pipeline/truth/highlight_error.h"
#include "pipeline/truth/truth.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace plumb::test {

namespace {

using glm::dvec2;
using glm::dvec3;

// The bounds of the steps are those of tests/oracle/fill_oracle_test.cpp; here they meet the truth, which starts from vertices that are not snapped.
constexpr double kUnit = 0x1p-24;             // u, unit round-off of float32
constexpr double kRowError = 6 * kUnit;       // rows and positions rounded once, four products summed in order
constexpr double kSnapPixels = 0x1p-9;        // half a sub-pixel
constexpr double kDepthError = 12.2 * kUnit;  // of the largest corner's z, interpolated
constexpr double kRoot3 = 1.7320509;
constexpr double kNormalError = 10 * kUnit * kRoot3;
constexpr double kUnitLengthError = 6.5 * kUnit;
constexpr double kRayError = 5 * kUnit * kRoot3;
constexpr double kDistanceError = 11 * kUnit;
constexpr double kPowerError = (1.7e-7 + 4.5 * kUnit) / 2.718281828 + 7.5e-8 + 3 * kUnit;
constexpr double kPowerFloor = 0x1p-20;
constexpr double kFlushed = 0x1p-100;  // what underflow takes away, absolute
// The bounds are of first order. Angles and shares above kSmall are left open; below, what is left out is less than an eighth.
constexpr double kSmall = 0x1p-5, kSecondOrder = 1.125;
constexpr double kMostDistance = 1e15;  // pixels; a triangle that reaches further on the screen is clipped anyway

struct Placed {  // a triangle on the screen
    std::array<dvec2, 3> corner;
    double moved = 0;          // at most so far, in pixels, does the transform leave a corner from its true place
    double relativeDepth = 0;  // bound of a corner's 1/w, relative
};

double distanceToSegment(const dvec2& p, const dvec2& a, const dvec2& b) {
    const dvec2 d = b - a;
    const double square = glm::dot(d, d), t = square > 0 ? std::clamp(glm::dot(p - a, d) / square, 0.0, 1.0) : 0;
    return glm::length(p - a - d * t);
}

class Judgement {
public:
    Judgement(const Scene& scene, const RenderRequest& request, const Frame& frame)
        : scene_(scene),
          request_(request),
          frame_(frame),
          pinhole_(*scene.camera, request.width, request.height, 1),
          geometry_(scene, pinhole_) {}

    TruthReport judge() {
        if (!place()) return report_;
        RenderRequest asked = request_;
        asked.threads = 1;
        const Truth truth = truthOf(scene_, asked);
        for (uint32_t y = 0; y < request_.height && report_.fault.empty(); ++y)
            for (uint32_t x = 0; x < request_.width && report_.fault.empty(); ++x) pixel(truth, x, y);
        return report_;
    }

private:
    // False when a triangle is clipped.
    bool place() {
        seenOf_.resize(scene_.objects.size());
        for (uint32_t o = 0; o < scene_.objects.size(); ++o) {
            const Object& object = scene_.objects[o];
            const TriangleMesh& mesh = scene_.meshes[object.mesh];
            const glm::dmat4 toWorld = worldFromMesh(scene_, object);
            struct Vertex {
                dvec2 at;
                double w, wError, moved, relativeDepth;
            };
            std::vector<Vertex> vertices;
            for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
                const truth::Corner c = geometry_.corner(o, v);
                const dvec3 local(mesh.positions[v]), origin = dvec3(toWorld[3]) - scene_.camera->eye;
                const auto sum = [&](const dvec3& axis, double scale) {
                    double s = std::abs(scale * glm::dot(axis, origin));
                    for (int k = 0; k < 3; ++k) s += std::abs(scale * glm::dot(axis, dvec3(toWorld[k])) * local[k]);
                    return s;
                };
                const double w = c.w.value, wSum = sum(pinhole_.forward, 1);
                const auto error = [&](const dvec3& axis, double q, double centre) {
                    return kRowError * (sum(axis, pinhole_.focal) + std::abs(q) * wSum) / w + kUnit * (std::abs(q) + std::abs(q + centre)) +
                           kSnapPixels;
                };
                Vertex out{{c.x.value / w, c.y.value / w}, w, kRowError * wSum, 0, kRowError * wSum / w + 2 * kUnit};
                out.moved =
                    std::hypot(error(pinhole_.right, out.at.x, pinhole_.width / 2), error(pinhole_.down, out.at.y, pinhole_.height / 2));
                vertices.push_back(out);
            }
            for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                Placed p;
                int behind = 0, before = 0;
                std::array<int, 4> beyond{};
                const double guardX = pinhole_.width / 2 + 8192, guardY = pinhole_.height / 2 + 8192;
                bool inside = true;
                for (size_t i = 0; i < 3; ++i) {
                    const Vertex& v = vertices[mesh.triangles[t].vertex[i]];
                    behind += v.w + v.wError < pinhole_.near;
                    before += v.w - v.wError >= pinhole_.near;
                    p.corner[i] = v.at;
                    p.moved = std::max(p.moved, v.moved);
                    p.relativeDepth = std::max(p.relativeDepth, v.relativeDepth);
                    beyond[0] += v.at.x<-guardX - v.moved, beyond[1] += v.at.x> guardX + v.moved;
                    beyond[2] += v.at.y<-guardY - v.moved, beyond[3] += v.at.y> guardY + v.moved;
                    inside &= std::abs(v.at.x) + v.moved < guardX && std::abs(v.at.y) + v.moved < guardY;
                }
                if (behind == 3) continue;
                if (before != 3) return false;
                if (std::find(beyond.begin(), beyond.end(), 3) != beyond.end()) continue;
                if (!inside || !(p.moved < kMostDistance)) return false;
                placed_.push_back(p);
                seenOf_[o].resize(mesh.triangles.size(), kNone);
                seenOf_[o][t] = uint32_t(placed_.size() - 1);
            }
        }
        return true;
    }

    // Snapped corners make of each triangle one that lies within `moved` of it; further from its border than that, it covers what it covered.
    bool besideAnEdge(const dvec2& p) const {
        return std::any_of(placed_.begin(), placed_.end(), [&](const Placed& t) {
            for (size_t i = 0; i < 3; ++i)
                if (distanceToSegment(p, t.corner[i], t.corner[(i + 1) % 3]) <= t.moved) return true;
            return false;
        });
    }

    struct Surface {
        const truth::Triangle* triangle;
        const Placed* placed;
        double inverse, error;    // 1 / w and how far the drawn one may be off
        double share[3], turned;  // of the corners; what `moved` makes of a share's numerator over the sum
    };

    void pixel(const Truth& truth, uint32_t x, uint32_t y) {
        const double px = pinhole_.x(int(x)), py = pinhole_.y(int(y));
        const size_t at = size_t(y) * request_.width + x;
        if (besideAnEdge({px, py})) return void(++report_.left);
        std::vector<Surface> surfaces;
        for (const truth::Triangle& t : geometry_.triangles()) {
            double e[3], sum = 0;
            bool covers = true;
            for (int i = 0; i < 3; ++i) {
                e[i] = t.a[i] * px + t.b[i] * py + t.c[i];
                covers &= e[i] > 0;
                sum += e[i];
            }
            if (!covers) continue;
            const uint32_t place = t.triangle < seenOf_[t.object].size() ? seenOf_[t.object][t.triangle] : kNone;
            if (place == kNone) continue;
            Surface s{&t, &placed_[place], t.sa * px + t.sb * py + t.sc, 0, {}, 0};
            double most = 0;
            for (size_t i = 0; i < 3; ++i) {
                s.share[i] = e[i] / sum;
                s.turned += s.placed->moved * (std::abs(t.a[i]) + std::abs(t.b[i])) / sum;
                const double w = geometry_.corner(t.object, t.vertex[i]).w.value;
                most = std::max(most, 1 / w);
            }
            s.error = s.placed->moved * (std::abs(t.sa) + std::abs(t.sb)) + most * (s.placed->relativeDepth + kDepthError);
            surfaces.push_back(s);
        }
        if (surfaces.empty()) {
            if (frame_.object[at] != kNone) return fail(x, y, fmt::format("object {} is drawn where nothing is", frame_.object[at]));
            for (int i = 0; i < 3; ++i)
                if (frame_.linear[3 * at + size_t(i)] != request_.background[i]) return fail(x, y, "another colour than the background");
            return void(++report_.pixels);
        }
        const auto best =
            std::max_element(surfaces.begin(), surfaces.end(), [](const Surface& a, const Surface& b) { return a.inverse < b.inverse; });
        if (frame_.object[at] == kNone) return fail(x, y, fmt::format("nothing is drawn over object {}", best->triangle->object));
        const Surface* drawn = nullptr;
        for (const Surface& s : surfaces)
            if (s.triangle->object == frame_.object[at] && faceOf(s) == frame_.primitive[at] && (!drawn || s.inverse > drawn->inverse))
                drawn = &s;
        if (!drawn)
            return fail(x, y, fmt::format("object {}, face {} is drawn and does not lie here", frame_.object[at], frame_.primitive[at]));
        const double got = 1 / double(frame_.depth[at]);
        if (!within(x, y, "1/w", got, drawn->inverse, drawn->error + 4 * kUnit * got)) return;
        if (best->inverse - drawn->inverse > (best->error + drawn->error) * kSecondOrder)
            return fail(x, y, fmt::format("object {}, face {} is nearer than what is drawn", best->triangle->object, faceOf(*best)));
        // Of surfaces that lie together, the truth shows the first, and float32 any.
        const auto together = [&](const Surface& s) { return best->inverse - s.inverse <= (best->error + s.error) * kSecondOrder; };
        if (std::count_if(surfaces.begin(), surfaces.end(), together) > 1) return void(++report_.left);
        colour(truth, *drawn, x, y, at);
    }

    uint32_t faceOf(const Surface& s) const {
        return scene_.meshes[scene_.objects[s.triangle->object].mesh].triangles[s.triangle->triangle].face;
    }

    void colour(const Truth& truth, const Surface& s, uint32_t x, uint32_t y, size_t at) {
        const truth::Triangle& t = *s.triangle;
        const Object& object = scene_.objects[t.object];
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        const Material& material = scene_.materials[mesh.faceMaterial[faceOf(s)]];
        // Normal. Sum e (n_i - n) is 0 at the sample; where the drawn triangle has the sample it is off by what `moved` makes of e.
        const glm::dmat3 toWorld = glm::transpose(glm::inverse(glm::dmat3(object.worldFromObject)));
        dvec3 n(0), position(0), corner[3];
        double magnitude = 0;
        for (size_t i = 0; i < 3; ++i) {
            const dvec3 file(mesh.normals[t.vertex[i]]);
            corner[i] = toWorld * file;
            n += corner[i] * s.share[i];
            position += geometry_.corner(t.object, t.vertex[i]).fromEye * s.share[i];
            for (int k = 0; k < 3; ++k) magnitude += s.share[i] * glm::length(toWorld[k]) * std::abs(file[k]);
        }
        const double length = glm::length(n);
        double spread = 0;
        for (const dvec3& c : corner) spread = std::max(spread, glm::length(c - n));
        const double turned = 2 * spread * (s.turned / std::max(1e-300, 1 - s.turned) + 2 * s.placed->relativeDepth) / length;
        const double normalError = kNormalError * magnitude / length + kUnitLengthError + turned;
        if (!(normalError < kSmall) || !(s.turned < kSmall)) return void(++report_.left);
        n /= length;
        const dvec3 toEye = -glm::normalize(position);
        const double far = glm::length(position), depth = glm::dot(pinhole_.forward, position);
        const double rayParts = 1 + (request_.width + double(x) + 1) / pinhole_.focal + (request_.height + double(y) + 1) / pinhole_.focal;
        const double rayError = kRayError * rayParts * depth / far;
        const double positionError = far * (kDistanceError + s.error / s.inverse + rayError);
        dvec3 colour = dvec3(material.ambient) * dvec3(scene_.ambient) + dvec3(material.emission), bound = colour * (2 * kUnit) + kFlushed;
        for (const Light& light : scene_.lights) {
            dvec3 l = light.directional ? light.direction : light.position - scene_.camera->eye - position;
            const double distance = light.directional ? 1 : glm::length(l);
            const double lightError =
                light.directional
                    ? kUnit * kRoot3
                    : (positionError + 2 * kUnit * (glm::length(light.position - scene_.camera->eye) + far)) / distance + kUnitLengthError;
            if (!(lightError < kSmall)) return void(++report_.left);
            l = glm::normalize(l);
            const int power = light.directional || light.attenuation == Attenuation::none ? 0
                              : light.attenuation == Attenuation::inverse                 ? 1
                                                                                          : 2;
            const double fade = std::pow(distance, -power), fadeError = power * lightError + 2 * kUnit;
            const double nl = glm::dot(n, l), nlError = normalError + lightError + 3 * kUnit;
            const double exponent = material.shininess, rv = glm::dot(2 * nl * n - l, toEye);
            const double shine = exponent == 0 ? 1 : std::pow(std::max(rv, 0.0), exponent);
            const double mirrorError = 2 * (normalError + nlError) + lightError + rayError + kUnitLengthError + 4 * kUnit;
            const double shineError = exponent == 0 ? 0 : truth::highlightError(exponent, mirrorError, kPowerFloor) + kPowerError;
            const bool lit = nl > 0, open = std::abs(nl) <= nlError;
            for (int i = 0; i < 3; ++i) {
                const double intensity = light.intensity[i] * fade;
                const double term = lit ? (material.diffuse[i] * nl + material.specular[i] * shine) * intensity : 0;
                colour[i] += term;
                bound[i] += intensity * (material.diffuse[i] * nlError +
                                         material.specular[i] * (lit || open ? std::min(1.0, shineError) + (open ? shine : 0) : 0)) +
                            (fadeError + (4 + double(scene_.lights.size())) * kUnit) * (term + colour[i]);
            }
        }
        ++report_.pixels;
        for (size_t i = 0; i < 3; ++i) {
            const double want = truth.linear[3 * at + i], off = bound[int(i)] * kSecondOrder;
            if (!within(x, y, "linear", double(frame_.linear[3 * at + i]), want, bound[int(i)])) return;
            // A byte: the code of a colour within the bound, rounded to the nearest.
            const double byte = double(frame_.rgba[at] >> (8 * i) & 0xff), low = codeOf(want - off), high = codeOf(want + off);
            if (byte < low - kHalfStep || byte > high + kHalfStep)
                return fail(x, y,
                            fmt::format("byte {} of channel {}; the truth is {:.4f}, {:.4f} to {:.4f} with its bound", byte, i,
                                        codeOf(want), low, high));
        }
    }
    static constexpr double kHalfStep = 0.5 + 0x1p-20;  // and what binary64's pow leaves
    double codeOf(double linear) const {
        return request_.encoding == Encoding::linear ? 255 * std::clamp(linear, 0.0, 1.0) : srgbCode(linear);
    }

    bool within(uint32_t x, uint32_t y, const char* what, double got, double want, double bound) {
        const double error = std::abs(got - want), most = bound * kSecondOrder;
        if (!(error <= most))
            return fail(x, y, fmt::format("{} is {:.9g}, the truth {:.9g}: {:.3g} apart, at most {:.3g}", what, got, want, error, most)),
                   false;
        report_.worst = std::max(report_.worst, most > 0 ? error / most : 0);
        return true;
    }
    void fail(uint32_t x, uint32_t y, const std::string& what) { report_.fault = fmt::format("pixel ({}, {}): {}", x, y, what); }

    const Scene& scene_;
    const RenderRequest& request_;
    const Frame& frame_;
    const truth::Pinhole pinhole_;
    const truth::Geometry geometry_;
    std::vector<Placed> placed_;
    std::vector<std::vector<uint32_t>> seenOf_;  // object, triangle: place in placed_
    TruthReport report_;
};

}  // namespace

TruthReport holdAgainstTruth(const Scene& scene, const RenderRequest& request, const Frame& frame) {
    return Judgement(scene, request, frame).judge();
}

}  // namespace plumb::test
