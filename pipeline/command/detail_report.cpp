// SPDX-License-Identifier: MIT
#include "pipeline/command/detail_report.h"

#include "pipeline/command/interrupt.h"

#include <glm/glm.hpp>
#include <vector>

namespace plumb {

Detail detailOf(const Options& options, const Scene& scene, glm::uvec2 size, const std::vector<Viewpoint>& views, Progress& progress,
                double from, double to) {
    DetailRequest request;
    request.pixels = options.detail;
    request.size = size;
    for (const Viewpoint& view : views) request.cameras.push_back(view.camera);
    request.threads = options.threads;
    request.keepNumbers = false;  // errors are measured against the scene itself
    progress.begin("detail", from, to, Progress::kMoment);
    request.onProgress = [&progress](double share) {
        progress.update(share);
        return interruptedBy() == 0;
    };
    Detail detail = detailed(scene, request);
    progress.clear();
    return detail;
}

Json detailJson(const Detail& detail, double pixels, const Scene& scene) {
    Json json;
    json["pixels"] = pixels;
    json["simplifier"] = detail.simplifier;
    json["triangles"] = detail.triangles();
    json["drawnTriangles"] = detail.drawnTriangles();
    json["time_ms"] = detail.ms;
    json["objects"] = Json::array();
    for (const DetailRow& row : detail.rows) {
        Json object;
        object["object"] = row.object;
        object["name"] = scene.objects[row.object].name;
        object["triangles"] = row.triangles;
        object["drawnTriangles"] = row.drawn;
        object["segments"] = row.segments == 0 ? Json() : Json(row.segments);
        object["deviation"] = row.deviation;
        object["pixels"] = row.pixels;
        object["kept"] = row.kept.empty() ? Json() : Json(row.kept);
        json["objects"].push_back(object);
    }
    return json;
}

}  // namespace plumb
