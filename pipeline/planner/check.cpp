// SPDX-License-Identifier: MIT
#include "pipeline/planner/check.h"

#include "pipeline/render/technique.h"
#include "pipeline/truth/decided.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>

namespace plumb {
namespace {

// A random sample of `count` of `pixels` pixels, each set as likely (Knuth's algorithm S).
std::vector<uint8_t> sampleOf(size_t pixels, uint64_t count, uint64_t seed) {
    std::vector<uint8_t> chosen(pixels, 0);
    std::mt19937_64 random(seed);
    uint64_t left = count;
    for (size_t at = 0; at < pixels && left > 0; ++at)
        if (double(random() >> 11) * 0x1p-53 * double(pixels - at) < double(left)) chosen[at] = 1, --left;
    return chosen;
}

constexpr double kMissed = 0.05;  // 1 minus the confidence

// Share p at which at most `found` of `sampled` are met with that chance: the sum of the binomial's first terms falls with p.
double shareOf(uint64_t found, uint64_t sampled, double wanted) {
    const auto n = double(sampled);
    const auto chance = [&](double p) {
        double sum = 0;
        for (uint64_t k = 0; k <= found; ++k)
            sum += std::exp(std::lgamma(n + 1) - std::lgamma(double(k) + 1) - std::lgamma(n - double(k) + 1) + double(k) * std::log(p) +
                            (n - double(k)) * std::log1p(-p));
        return sum;
    };
    double low = 0, high = 1;
    while (high - low > 1e-9 * high) {
        const double middle = (low + high) / 2;
        if (middle <= 0 || middle >= 1) break;
        (chance(middle) > wanted ? low : high) = middle;
    }
    return high;
}

}  // namespace

BudgetFigures figuresOf(const FrameError& error) {
    BudgetFigures f;
    f.max = error.decidedMax;
    f.x = error.decidedX;
    f.y = error.decidedY;
    f.p99 = error.picture.p99;
    f.rms = error.picture.rms;
    f.wrong = error.wrongShare();
    f.pixels = error.pixels;
    f.wrongPixels = error.wrongPrimitive;
    f.undecided = error.undecided;
    return f;
}

double excessOf(const BudgetFigures& figures, const ErrorBudget& budget) {
    double most = 0;
    const auto take = [&](const std::optional<double>& limit, double got) {
        if (!limit) return;
        const double share = got == 0 ? 0 : got / *limit;  // a limit of 0 is kept by 0 alone
        if (!(share <= most)) most = std::isnan(share) ? INFINITY : share;
    };
    take(budget.max, figures.max);
    take(budget.p99, figures.p99);
    take(budget.rms, figures.rms);
    take(budget.wrongLimit(), figures.wrong);
    return most;
}

double shareBelow(uint64_t found, uint64_t sampled) { return sampled == 0 || found >= sampled ? 1 : shareOf(found, sampled, kMissed); }

double shareAbove(uint64_t found, uint64_t sampled) { return found == 0 || sampled == 0 ? 0 : shareOf(found - 1, sampled, 1 - kMissed); }

Checker::Checker(const Scene& scene, const RenderRequest& request, const CheckPlan& plan, std::function<bool(double)> progress)
    : request_(request) {
    const size_t pixels = size_t(request.width) * request.height;
    if (plan.sampled != 0 && plan.sampled < pixels) wanted_ = sampleOf(pixels, plan.sampled, plan.seed);
    checked_ = wanted_.empty() ? pixels : plan.sampled;
    request_.onProgress = std::move(progress);
    if (!isTraced(request_)) {
        request_.shading = Shading::phong;
        decided_ = decidedPixels(scene, request_, snapOf(request_));
    }
    truth_ = truthOf(scene, request_, 0, wanted_);
}

std::vector<uint8_t> Checker::decidedIn(const Frame& frame) const {
    if (!truth_.traced) return decided_;
    // Rays snap nothing: the face that the picture shows tells which pixels float32 decides.
    std::vector<uint8_t> sameFace(frame.object.size());
    for (size_t at = 0; at < sameFace.size(); ++at)
        sameFace[at] = frame.object[at] == truth_.object[at] && frame.primitive[at] == truth_.primitive[at];
    return sameFace;
}

FrameError Checker::errorOfFrame(const Frame& frame) const {
    const std::vector<uint8_t> decided = decidedIn(frame);
    return errorOf(frame, truth_, request_.encoding, request_.transparent, {wanted_, decided});
}

BudgetFigures Checker::of(const Frame& frame) const { return figuresOf(errorOfFrame(frame)); }

}  // namespace plumb
