// SPDX-License-Identifier: MIT
#include "pipeline/measure/row_fronts.h"

#include "pipeline/measure/front.h"
#include "pipeline/measure/row_list.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace plumb {
namespace {

// The front among these runs, of which the first is the default; indices of runs.
std::vector<size_t> frontAmong(const Measurement& m, const std::vector<std::string>& works, const std::vector<size_t>& among) {
    std::map<std::pair<uint32_t, Sampling>, size_t> indices;
    std::map<std::string, size_t> workNumbers;
    std::vector<FrontPoint> points;
    std::vector<size_t> runs;
    for (const size_t i : among) {
        const MeasuredRun& run = m.runs[i];
        const RenderRequest& request = run.setting.request;
        if (run.cut || !run.alike || !run.ratio) continue;
        FrontPoint point;
        point.samples = indices.try_emplace({request.samples, samplingOf(request)}, indices.size()).first->second;
        if (!run.error && point.samples != 0) continue;  // no truth to compare other samples by
        point.low = run.ratio->low, point.high = run.ratio->high;
        point.errorAtItsSamples = run.alike->picture.rms;
        point.errorAtMostSamples = run.error ? run.error->picture.rms : 0;
        point.work = workNumbers.try_emplace(works[i], workNumbers.size()).first->second;
        point.again = run.setting.again;
        points.push_back(point);
        runs.push_back(i);
    }
    const std::vector<bool> front = frontOf(points);
    std::vector<size_t> out;
    for (size_t k = 0; k < runs.size(); ++k)
        if (front[k]) out.push_back(runs[k]);
    return out;
}

}  // namespace

void takeFronts(Measurement& m, const std::vector<std::string>& works) {
    std::vector<size_t> all;
    std::map<const Axis*, std::vector<size_t>> ofAxis;
    for (size_t i = 0; i < m.runs.size(); ++i) all.push_back(i);
    for (const Row& row : m.rows) {
        std::vector<size_t>& runs = ofAxis[row.axis];
        if (runs.empty()) runs.push_back(0);
        if (row.run && *row.run != 0) runs.push_back(*row.run);
    }
    std::vector<size_t> front = frontAmong(m, works, all);
    std::map<const Axis*, std::vector<size_t>> axisFront;
    for (const auto& [axis, runs] : ofAxis) axisFront[axis] = frontAmong(m, works, runs);
    const auto holds = [](const std::vector<size_t>& runs, size_t run) { return std::find(runs.begin(), runs.end(), run) != runs.end(); };
    for (Row& row : m.rows) {
        row.onFront = row.run && holds(front, *row.run);
        row.onAxisFront = row.run && holds(axisFront[row.axis], *row.run);
    }
    std::stable_sort(front.begin(), front.end(), [&](size_t a, size_t b) { return *m.runs[a].total.median() < *m.runs[b].total.median(); });
    for (const size_t run : front) {
        const auto row = std::find_if(m.rows.begin(), m.rows.end(), [&](const Row& candidate) { return candidate.run == run; });
        // The default has no row where no axis states it; the control, which is the same work, is on the front beside it.
        if (row != m.rows.end()) m.front.push_back(size_t(row - m.rows.begin()));
    }
}

}  // namespace plumb
