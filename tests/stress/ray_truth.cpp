// SPDX-License-Identifier: MIT
#include "pipeline/truth/drawn.h"
#include "pipeline/truth/geometry.h"
#include "pipeline/truth/ray_world.h"
#include "pipeline/truth/rays.h"
#include "pipeline/truth/truth.h"
#include "tests/stress/scene_truth.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>

namespace plumb::test {

namespace {

// The bounds are of first order; what is left out is less than an eighth.
constexpr double kSecondOrder = 1.125;
constexpr double kHalfStep = 0.5 + 0x1p-20;  // and what binary64's pow leaves

class RayJudgement {
public:
    RayJudgement(const Scene& scene, const RenderRequest& request, const Frame& frame)
        : request_(request), frame_(frame), drawn_(truth::asDrawn(scene)) {}

    TruthReport judge() {
        const truth::Pinhole pinhole(*drawn_.scene.camera, request_.width, request_.height, 1);
        const truth::RayWorld world(drawn_.scene);
        truth::RayLimits limits;
        limits.maxDepth = request_.maxDepth;
        limits.leastWeight = double(request_.minWeight);
        truth::RayTruth rays(world, pinhole, glm::dvec3(request_.background), limits);
        for (uint32_t y = 0; y < request_.height && report_.fault.empty(); ++y)
            for (uint32_t x = 0; x < request_.width && report_.fault.empty(); ++x) {
                const truth::RayDrawn ray = rays.lookDrawn(pinhole.x(int(x)), pinhole.y(int(y)));
                const std::string fault = ray.decided ? pixel(ray, size_t(y) * request_.width + x) : "";
                ++(ray.decided ? report_.pixels : report_.left);
                if (!fault.empty()) report_.fault = fmt::format("pixel ({}, {}): {}", x, y, fault);
            }
        return report_;
    }

private:
    // What is wrong with the pixel, or "".
    std::string pixel(const truth::RayDrawn& ray, size_t at) {
        const truth::RaySeen& seen = ray.seen;
        if (frame_.object[at] != seen.object || frame_.primitive[at] != seen.primitive)
            return fmt::format("object {}, face {} is drawn; the ray meets {}, {}", frame_.object[at], frame_.primitive[at], seen.object,
                               seen.primitive);
        std::string fault;
        if (seen.object != kNone) within(fault, "distance", double(frame_.distance[at]) * drawn_.unit, seen.distance, ray.distanceError);
        for (int i = 0; i < 3 && fault.empty(); ++i) {
            const double want = seen.colour[i], bound = ray.bound[i];
            within(fault, "linear", double(frame_.linear[3 * at + size_t(i)]), want, bound);
            // A byte: the code of a colour within the bound, rounded to the nearest.
            const double byte = double(frame_.rgba[at] >> (8 * i) & 0xff), low = codeOf(want - bound * kSecondOrder),
                         high = codeOf(want + bound * kSecondOrder);
            if (fault.empty() && (byte < low - kHalfStep || byte > high + kHalfStep))
                fault = fmt::format("byte {} of channel {}; the truth is {:.4f}, {:.4f} to {:.4f} with its bound", byte, i, codeOf(want),
                                    low, high);
        }
        return fault;
    }
    double codeOf(double linear) const {
        return request_.encoding == Encoding::linear ? 255 * std::clamp(linear, 0.0, 1.0) : srgbCode(linear);
    }
    void within(std::string& fault, const char* what, double got, double want, double bound) {
        const double error = std::abs(got - want), most = bound * kSecondOrder;
        if (!(error <= most))
            fault = fmt::format("{} is {:.9g}, the truth {:.9g}: {:.3g} apart, at most {:.3g}", what, got, want, error, most);
        report_.worst = std::max(report_.worst, most > 0 ? error / most : 0);
    }

    const RenderRequest& request_;
    const Frame& frame_;
    const truth::DrawnScene drawn_;
    TruthReport report_;
};

}  // namespace

TruthReport holdRaysAgainstTruth(const Scene& scene, const RenderRequest& request, const Frame& frame) {
    return RayJudgement(scene, request, frame).judge();
}

}  // namespace plumb::test
