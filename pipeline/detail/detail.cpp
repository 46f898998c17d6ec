// SPDX-License-Identifier: MIT
#include "pipeline/detail/detail.h"

#include "host/error.h"
#include "pipeline/detail/projected_scale.h"
#include "pipeline/detail/simplify_mesh.h"
#include "pipeline/scene/shape.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr size_t kMostLines = 8;  // of objects in a plan

class Detailing {
public:
    Detailing(const Scene& scene, const DetailRequest& request) : scene_(scene), request_(request) {
        if (!(request.pixels > 0) || !std::isfinite(request.pixels))
            throw usageError(fmt::format("a deviation of {} pixels is not above 0", request.pixels));
        PLUMB_ASSERT(!request.cameras.empty() || scene.camera.has_value());
        if (request_.cameras.empty()) request_.cameras.push_back(*scene.camera);
    }

    Detail run() {
        out_.scene = scene_;
        out_.simplifier = detail::simplifierName();
        out_.redrawn.assign(scene_.objects.size(), false);
        std::map<uint32_t, std::vector<uint32_t>> users;  // objects by mesh
        for (uint32_t o = 0; o < scene_.objects.size(); ++o) {
            const detail::Allowed allowed = detail::allowedDeviation(scene_, o, request_.cameras, request_.size, request_.pixels);
            DetailRow row;
            row.object = o;
            row.triangles = row.drawn = scene_.meshes[scene_.objects[o].mesh].triangles.size();
            row.deviation = allowed.deviation;
            row.pixels = allowed.deviation * allowed.pixelsPerUnit;
            row.kept = allowed.why;
            scales_.push_back(allowed.pixelsPerUnit);
            if (row.kept.empty()) users[scene_.objects[o].mesh].push_back(o);
            out_.rows.push_back(row);
        }
        size_t done = 0;
        for (auto& [mesh, objects] : users) {
            drawMesh(mesh, objects);
            tell(double(++done) / double(users.size()));
        }
        return std::move(out_);
    }

private:
    void tell(double share) {
        told_ = share;
        if (request_.onProgress && !request_.onProgress(share)) throw Error(Exit::interrupted, "interrupted");
    }

    // Objects of one mesh by rising budget, in groups whose budgets are within a factor of 2: a group shares the mesh of its least.
    void drawMesh(uint32_t mesh, std::vector<uint32_t>& objects) {
        const auto allowed = [&](uint32_t o) { return out_.rows[o].deviation; };
        std::stable_sort(objects.begin(), objects.end(), [&](uint32_t a, uint32_t b) { return allowed(a) < allowed(b); });
        for (size_t first = 0; first < objects.size();) {
            size_t last = first + 1;
            while (last < objects.size() && allowed(objects[last]) <= 2 * allowed(objects[first])) ++last;
            drawGroup(mesh, {objects.begin() + ptrdiff_t(first), objects.begin() + ptrdiff_t(last)});
            first = last;
        }
    }

    void drawGroup(uint32_t mesh, const std::vector<uint32_t>& objects) {
        const TriangleMesh& whole = scene_.meshes[mesh];
        double deviation = out_.rows[objects.front()].deviation;
        std::optional<TriangleMesh> drawn;
        uint32_t segments = 0;
        if (whole.shape) {
            segments = segmentsFor(*whole.shape, deviation);
            GeneratedShape shape = *whole.shape;
            shape.segments = segments;
            deviation = deviationOf(shape);
            if (segments != whole.shape->segments) drawn = tessellated(whole, segments, request_.keepNumbers);
        } else {
            drawn = detail::simplified(whole, deviation, request_.threads, [this] { tell(told_); });
        }
        const uint32_t index = drawn ? uint32_t(out_.scene.meshes.size()) : mesh;
        const uint64_t triangles = drawn ? drawn->triangles.size() : whole.triangles.size();
        for (const uint32_t o : objects) {
            DetailRow& row = out_.rows[o];
            row.drawn = triangles;
            row.segments = segments;
            row.deviation = drawn || segments != 0 ? deviation : 0;
            row.pixels = row.deviation * scales_[o];
            if (!drawn) row.kept = segments != 0 ? "it has the segments that this takes" : "no triangle can be taken away";
            out_.redrawn[o] = drawn.has_value();
            out_.scene.objects[o].mesh = index;
        }
        if (drawn) out_.scene.meshes.push_back(std::move(*drawn));
    }

    const Scene& scene_;
    DetailRequest request_;
    Detail out_;
    std::vector<double> scales_;  // by object: pixels a unit of its mesh
    double told_ = 0;
};

// Meshes that no object has any more are emptied: nothing may upload them.
void dropUnused(Scene& scene) {
    std::vector<uint32_t> newOf(scene.meshes.size(), kNone);
    std::vector<TriangleMesh> used;
    for (Object& object : scene.objects) {
        uint32_t& index = newOf[object.mesh];
        if (index == kNone) {
            index = uint32_t(used.size());
            used.push_back(std::move(scene.meshes[object.mesh]));
        }
        object.mesh = index;
    }
    scene.meshes = std::move(used);
}

double millisecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

std::string nameIn(const Scene& scene, uint32_t object) {
    const std::string& name = scene.objects[object].name;
    return name.empty() ? fmt::format("object {}", object) : fmt::format("'{}'", printable(name, 64));
}

}  // namespace

uint64_t Detail::triangles() const {
    uint64_t sum = 0;
    for (const DetailRow& row : rows) sum += row.triangles;
    return sum;
}

uint64_t Detail::drawnTriangles() const {
    uint64_t sum = 0;
    for (const DetailRow& row : rows) sum += row.drawn;
    return sum;
}

std::vector<std::string> Detail::sentences(double pixels) const {
    std::vector<std::string> lines;
    const auto head = fmt::format("detail {:g} px: ", pixels);
    size_t more = 0;
    uint64_t moreTriangles = 0, moreDrawn = 0;
    std::map<std::string, std::vector<uint32_t>> kept;
    for (const DetailRow& row : rows) {
        if (!row.kept.empty()) kept[row.kept].push_back(row.object);
        if (!row.kept.empty() && row.pixels <= pixels) continue;
        if (lines.size() == kMostLines) {
            ++more;
            moreTriangles += row.triangles;
            moreDrawn += row.drawn;
            continue;
        }
        std::string line = head + fmt::format("{} is drawn with {} of {} triangles", nameIn(scene, row.object), row.drawn, row.triangles);
        if (row.segments != 0) line += fmt::format(", {} segments", row.segments);
        lines.push_back(line + fmt::format("; its outline moves by at most {:.3g} px", row.pixels));
    }
    if (more != 0) lines.push_back(head + fmt::format("{} more objects are drawn with {} of {} triangles", more, moreDrawn, moreTriangles));
    for (const auto& [why, objects] : kept)
        lines.push_back(head + (objects.size() == 1
                                    ? fmt::format("{} is kept: {}", nameIn(scene, objects.front()), why)
                                    : fmt::format("{} and {} more are kept: {}", nameIn(scene, objects.front()), objects.size() - 1, why)));
    return lines;
}

Detail detailed(const Scene& scene, const DetailRequest& request) {
    const auto start = std::chrono::steady_clock::now();
    Detail out = Detailing(scene, request).run();
    dropUnused(out.scene);
    out.ms = millisecondsSince(start);
    return out;
}

Detail tessellatedScene(const Scene& scene, uint32_t segments, bool keepNumbers) {
    const auto start = std::chrono::steady_clock::now();
    Detail out;
    out.scene = scene;
    out.redrawn.assign(scene.objects.size(), false);
    bool any = false;
    for (TriangleMesh& mesh : out.scene.meshes) {
        if (!mesh.shape) continue;
        any = true;
        const SegmentRange range = segmentRangeOf(mesh.shape->kind);
        const uint32_t wanted = std::clamp((segments + range.step - 1) / range.step * range.step, range.least, range.most);
        if (wanted != mesh.shape->segments) mesh = tessellated(mesh, wanted, keepNumbers);
    }
    if (!any) throw usageError("the scene has no generated shape ([[mesh]] with a shape)");
    for (uint32_t o = 0; o < scene.objects.size(); ++o) {
        const TriangleMesh &whole = scene.meshes[scene.objects[o].mesh], &drawn = out.scene.meshes[scene.objects[o].mesh];
        DetailRow row;
        row.object = o;
        row.triangles = whole.triangles.size();
        row.drawn = drawn.triangles.size();
        if (drawn.shape) {
            row.segments = drawn.shape->segments;
            row.deviation = deviationOf(*drawn.shape);
            out.redrawn[o] = row.segments != whole.shape->segments;
        }
        if (!out.redrawn[o]) row.kept = "it is not generated, or has that many segments";
        out.rows.push_back(row);
    }
    out.ms = millisecondsSince(start);
    return out;
}

}  // namespace plumb
