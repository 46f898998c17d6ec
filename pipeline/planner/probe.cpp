// SPDX-License-Identifier: MIT
#include "pipeline/planner/probe.h"

#include "pipeline/measure/error_bound.h"
#include "pipeline/render/camera.h"
#include "pipeline/render/render.h"
#include "pipeline/render/technique.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Standard deviations to either side that an estimate may be off.
constexpr double kDeviations = 3;

double processorMs() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

// Smallest side of at least side / shrink pixels whose middle lies on the middle of the whole: the pixels of the probe are then pixels of the
// picture, since the shrink is odd.
uint32_t sideOfProbe(uint32_t side, uint32_t shrink) {
    const uint32_t least = (side + shrink - 1) / shrink;
    return least + (side - least) % 2;
}

}  // namespace

Probe::Probe(const Scene& scene, const RenderRequest& base, uint64_t pixels, double factor, std::function<bool()> progress)
    : scene_(scene), base_(base), width_(base.width), height_(base.height), factor_(factor), progress_(std::move(progress)) {
    while (uint64_t(width_) * height_ > pixels && width_ > 1 && height_ > 1) {
        shrink_ += 2;
        width_ = sideOfProbe(base.width, shrink_);
        height_ = sideOfProbe(base.height, shrink_);
    }
    if (shrink_ == 1) return;
    small_ = scene;
    small_.camera->focalPixels = pinholeOf(*scene.camera, base.width, base.height, 1).focal / shrink_;
}

RenderRequest Probe::smaller(const RenderRequest& request) const {
    RenderRequest small = request;
    small.width = width_;
    small.height = height_;
    small.planes = kPlaneColour;
    small.onProgress = [this](double) { return !progress_ || progress_(); };
    return small;
}

const Checker& Probe::checkerOf(const RenderRequest& request) {
    std::unique_ptr<Checker>& checker = checkers_[request.samples];
    if (!checker) {
        checker = std::make_unique<Checker>(scene(), smaller(request), CheckPlan{}, [this](double) { return !progress_ || progress_(); });
        truthMs_ = std::max(truthMs_, checker->ms());
    }
    return *checker;
}

Estimate Probe::estimateOf(const FrameError& error) const {
    Estimate e;
    e.middle = figuresOf(error);
    for (double* figure : {&e.middle.max, &e.middle.p99, &e.middle.rms}) *figure *= factor_;
    e.low = e.high = e.middle;
    if (shrink_ == 1 || error.pixels == 0) return e;
    // The vertices of a smaller picture are snapped to larger steps, and its truth leaves out more pixels beside edges.
    e.low.max /= 2;
    std::vector<float> values;
    double squares = 0, fourth = 0;
    for (const float v : error.perPixel) {
        if (v > 0) values.push_back(v);
        squares += double(v) * v;
        fourth += double(v) * v * v * v;
    }
    const auto n = double(error.pixels);
    // Mean of the squares: its deviation is that of a square over the root of their number. The fourth powers of a few pixels are their own
    // largest error, hence `1 / n` beside it.
    const double variance = squares > 0 ? std::max(0.0, n * fourth / (squares * squares) - 1) / n : 0;
    const double off = kDeviations * std::sqrt(variance);
    e.low.rms = e.middle.rms * std::sqrt(std::max(0.0, 1 - off));
    e.high.rms = e.middle.rms * std::sqrt(1 + off);
    // 99 of 100: the binomial's deviation in ranks.
    values.resize(size_t(error.pixels), 0.0f);
    std::sort(values.begin(), values.end());
    const double spread = kDeviations * std::sqrt(n * 0.99 * 0.01);
    const auto at = [&](double rank) {
        return rank >= n ? 255.0 * factor_ : 255 * factor_ * double(values[size_t(std::clamp(rank, 0.0, n - 1))]);
    };
    e.low.p99 = std::min(e.middle.p99, at(0.99 * n - spread));
    e.high.p99 = std::max(e.middle.p99, at(0.99 * n + spread));
    // Wilson's interval.
    const double z = kDeviations * kDeviations, p = error.wrongShare(), centre = (p + z / (2 * n)) / (1 + z / n),
                 half = kDeviations / (1 + z / n) * std::sqrt(p * (1 - p) / n + z / (4 * n * n));
    // A share of the pixels beside edges is that share of fewer pixels where the picture is larger.
    e.middle.wrong = p / shrink_;
    e.low.wrong = std::max(0.0, centre - half) / shrink_;
    e.high.wrong = centre + half;
    e.high.max = 255 * factor_;  // of pixels between those of the probe nothing is known
    return e;
}

const Probe::Untraded& Probe::untraded(const RenderRequest& request) {
    const auto [found, isNew] = untraded_.try_emplace({request.shading, request.samples});
    if (!isNew) return found->second;
    RenderRequest plain = request;
    plain.planes |= kCheckedPlanes;
    found->second.frame = renderCpu(scene(), plain).frame;
    if (isTraced(request)) found->second.rays = std::make_unique<const BoundOfRays>(scene(), plain);
    return found->second;
}

ProvedErrors Probe::provedOf(const Candidate& candidate, uint32_t truthSamples) {
    const RenderRequest request = smaller(candidate.request);
    const bool traced = isTraced(request);
    RenderRequest plain = request, truth = candidate.request;
    plain.trade = {};
    if (traced) plain.maxDepth = base_.maxDepth, plain.minWeight = base_.minWeight;
    if (truthSamples != 0) truth.samples = truthSamples;
    const auto none = [](std::string why) { return ProvedErrors{false, 0, 0, 0, std::move(why)}; };
    if (request.encoding != Encoding::srgb) return none("bounds are those against an sRGB picture");
    if (traced ? request.maxDepth == plain.maxDepth && request.minWeight == plain.minWeight : request.trade == plain.trade)
        return none("nothing is traded: a shading, a depth and a cutoff that are asked for have no bound by themselves");
    ColourBound move;
    if (!traced) move = boundOfTrade(scene(), request, request.samples == 1 ? &untraded(plain).frame : nullptr);
    if (!move.proved) return none(move.why);
    ColourMoves moves(move.linear, move.darker);
    if (!move.brighterAt.empty()) moves = {std::move(move.brighterAt), std::move(move.darkerAt)};
    if (traced) {
        BoundOfRays::Moves rays = untraded(plain).rays->of(request);
        if (!rays.proved) return none(rays.why);
        moves = {std::move(rays.brighter), std::move(rays.darker)};
    }
    const Frame& base = untraded(plain).frame;
    const Checker& checker = checkerOf(truth);
    const ErrorBound bound = errorBoundOf(base, checker.truth(), request.transparent, moves, move.steps);
    ProvedErrors proved{true, 0, bound.p99, bound.rms, {}};
    const std::vector<uint8_t> decided = checker.decidedIn(base);
    for (size_t at = 0; at < bound.perPixel.size(); ++at)
        if (decided.empty() || decided[at] != 0) proved.max = std::max(proved.max, bound.perPixel[at]);
    return proved;
}

Counted Probe::counted(const Candidate& candidate) const {
    const RenderRequest request = smaller(candidate.request);
    return countedOf(renderCpu(scene(), request), request);
}

const Probed& Probe::of(const Candidate& candidate, bool error, uint32_t truthSamples) {
    const std::string key = candidate.words;
    if (const auto found = known_.find(key); found != known_.end() && (found->second.error || !error)) return found->second;
    RenderRequest request = smaller(candidate.request);
    if (error) request.planes |= kCheckedPlanes;
    const double before = processorMs();
    const RenderResult result = renderCpu(scene(), request);
    const double spent = processorMs() - before;
    Probed probed;
    probed.work = workOf(scene_, candidate.request, countedOf(result, request), shrink_);
    if (const double rays = raysOf(result.counters); rays > 0) {
        rays_ += rays;
        rayMs_ += spent;
        probed.rays = result.counters.rays;
        for (RenderCounters::RayCounts& r : probed.rays)
            for (uint64_t* count : {&r.primary, &r.reflected, &r.refracted, &r.shadowRays}) *count *= uint64_t(shrink_) * shrink_;
    }
    if (error) {
        RenderRequest truth = candidate.request;
        if (truthSamples != 0) truth.samples = truthSamples;
        probed.error = estimateOf(checkerOf(truth).errorOfFrame(result.frame));
    }
    return known_[key] = std::move(probed);
}

}  // namespace plumb
