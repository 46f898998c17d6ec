// SPDX-License-Identifier: MIT
#include "pipeline/measure/row_list.h"
#include "pipeline/render/technique.h"

#include <cstddef>
#include <string>
#include <vector>

namespace plumb {
namespace {

// A wire frame is a drawing, and has no truth.
constexpr const char* kWireWhy = "a wire frame has no truth: its lines are a drawing, not the picture of a surface";

// What the notes' fill does not have. Null: nothing is missing.
const char* notesLack(const Setting& setting) {
    const RenderRequest& r = setting.request;
    if (r.fill != Fill::notes || !hasTruth(r)) return nullptr;
    Trade other = r.trade;
    other.specular = Trade().specular;
    return other != Trade{} ? "the notes' fill has no such choice" : nullptr;
}

// What a picture of rays has and a raster picture has not, and the other way round. Null: nothing is missing.
const char* scopeLacks(const Axis& axis, const Setting& base, const Setting& setting) {
    const bool traced = isTraced(base.request);
    if (traced && axis.scope == Scope::raster) return "not applicable: a choice of the raster passes, and this picture is traced";
    if (!traced && axis.scope == Scope::rays) return "not applicable: nothing is traced in a raster picture; measure with --shading ray";
    if (!traced && isTraced(setting.request))
        return "not applicable: rays see shadows and mirrors, which the truth of a raster picture has not; measure with --shading ray";
    return nullptr;
}

// Index of the run that draws a setting; equal settings share one.
size_t runOf(Measurement& m, const Setting& setting) {
    const std::string words = wordsOf(setting);
    for (size_t i = 0; i < m.runs.size(); ++i)
        if (wordsOf(m.runs[i].setting) == words) return i;
    m.runs.push_back({});
    m.runs.back().setting = setting;
    return m.runs.size() - 1;
}

}  // namespace

void listRuns(Measurement& m, const MeasurePlan& plan) {
    runOf(m, plan.base);
    std::vector<const Axis*> axes = {&controlAxis()};
    for (const Axis* axis : plan.axes)
        if (axis != &controlAxis()) axes.push_back(axis);
    for (const Axis* axis : axes)
        for (const AxisChoice& choice : axis->choices) {
            Row row;
            row.axis = axis;
            row.choice = &choice;
            if (choice.apply == nullptr) {
                const char* outside = scopeLacks(*axis, plan.base, plan.base);
                row.why = outside != nullptr ? outside : choice.why;
            } else {
                Setting setting = plan.base;
                choice.apply(setting);
                if (const char* outside = scopeLacks(*axis, plan.base, setting); outside != nullptr) {
                    row.why = outside;
                } else if (const char* lacks = notesLack(setting); lacks != nullptr) {
                    row.why = lacks;
                } else if (!setting.twin && !plan.deviceThere) {
                    row.why = "no device draws here";
                } else if (!setting.twin && setting.request.trade.precision == Precision::fp64 && !plan.noBinary64.empty()) {
                    row.why = plan.noBinary64;
                } else {
                    row.run = runOf(m, setting);
                    row.baseline = *row.run == 0;
                    if (!hasTruth(setting.request)) row.why = kWireWhy;
                }
            }
            m.rows.push_back(row);
        }
}

}  // namespace plumb
