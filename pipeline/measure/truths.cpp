// SPDX-License-Identifier: MIT
#include "pipeline/measure/truths.h"

#include "host/error.h"
#include "pipeline/measure/row_list.h"
#include "pipeline/render/technique.h"

#include <algorithm>
#include <utility>

namespace plumb {
namespace {

// A truth's progress is extrapolated from this share on.
constexpr double kFirstGuess = 0.1;

}  // namespace

const Truth* Truths::at(uint32_t samples, Fill fill, uint32_t drawn, Sampling sampling, double untilMs) {
    if (fill != Fill::notes) drawn = samples;
    const std::tuple key(samples, fill, drawn, sampling);
    auto found = truths_.find(key);
    if (found == truths_.end()) {
        const double begun = elapsedMs_();
        bool late = false;
        RenderRequest request = base_;
        request.fill = fill;
        request.shading = isTraced(base_) ? base_.shading : Shading::phong;
        request.rays.sampling = sampling;
        request.samples = samples;
        request.onProgress = [&](double done) {
            alive_();
            const double spent = elapsedMs_() - begun, whole = done >= kFirstGuess ? spent / done : spent;
            late = begun + whole > untilMs;
            return !late;
        };
        std::optional<Truth> truth;
        try {
            truth = truthOf(scene_, request, drawn);
        } catch (const Error& error) {
            if (!late || error.exit() != Exit::interrupted) throw;
        }
        msPerSample_ = std::max(msPerSample_, (elapsedMs_() - begun) / samples);
        found = truths_.emplace(key, std::move(truth)).first;
    }
    return found->second ? &*found->second : nullptr;
}

bool Truths::has(const RenderRequest& request) const {
    return truths_.count({request.samples, request.fill, request.samples, samplingOf(request)}) != 0;
}

}  // namespace plumb
