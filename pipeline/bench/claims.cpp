// SPDX-License-Identifier: MIT
#include "pipeline/bench/claims.h"

#include "host/error.h"
#include "pipeline/scene/camera.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <numeric>

namespace plumb {

namespace {

constexpr uint32_t kWarmRounds = 2;

RenderRequest requestOf(Shading shading, const ClaimOptions& options) {
    RenderRequest request;
    request.width = options.width;
    request.height = options.height;
    request.shading = shading;
    request.watchdogMs = options.watchdogMs;
    return request;
}

// Claim P6, section 13: the fill is the expensive step.
ClaimTable fillingIsExpensive(Device& device, const Scene& scene, const ClaimOptions& options) {
    ClaimTable table{"P6",
                     "Filling polygons is the expensive step: it is done a pixel, the steps before it a vertex or a polygon.",
                     "One Phong picture, its passes submitted one by one and timed by the host; bin, fill and shade against all "
                     "passes before them.",
                     {},
                     {}};
    ResidentScene resident(device, scene, requestOf(Shading::phong, options));
    resident.draw();
    const RenderCounters counters = renderGpu(device, scene, requestOf(Shading::phong, options)).counters;
    std::vector<double> before, fill;
    for (uint32_t round = 0; round < kWarmRounds + options.rounds; ++round) {
        if (options.onProgress) options.onProgress(double(round) / (kWarmRounds + options.rounds));
        double sums[2] = {0, 0};
        for (const PassTime& pass : resident.timePasses())
            sums[pass.pass == "bin" || pass.pass.starts_with("fill") || pass.pass == "shade"] += pass.ms;
        if (round < kWarmRounds) continue;
        before.push_back(sums[0]);
        fill.push_back(sums[1]);
    }
    const Spread one = ratioOf(before, before);
    table.ways = {{"transform, cull, set-up", {{"vertices", counters.vertices}, {"triangles", counters.triangles}}, spreadOf(before), one},
                  {"bin, fill, shade", {{"pixels", counters.illuminations}}, spreadOf(fill), ratioOf(fill, before)}};
    if (counters.illuminations == 0) table.failure = "no pixel was filled";
    return table;
}

// Edges of the triangles, each once, because generated meshes have no list of edges.
std::vector<std::pair<uint32_t, uint32_t>> edgesOf(const TriangleMesh& mesh) {
    std::vector<std::pair<uint32_t, uint32_t>> edges;
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        for (size_t i = 0; i < 3; ++i) edges.push_back(std::minmax({t.vertex[i], t.vertex[(i + 1) % 3]}));
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

// Claim P7, section 3: lines stay lines, so two projections draw an edge.
class EdgePainter {
public:
    EdgePainter(const Scene& scene, const ClaimOptions& options)
        : width_(options.width), height_(options.height), canvas_(size_t(width_) * height_) {
        const Camera& c = *scene.camera;
        focal_ = focalOf(c, height_);
        for (const Object& object : scene.objects) {
            const TriangleMesh& mesh = scene.meshes[object.mesh];
            const glm::dmat4 toWorld = worldFromMesh(scene, object);
            const auto viewOf = [&](uint32_t v) {
                const glm::dvec3 p = glm::dvec3(toWorld * glm::dvec4(mesh.positions[v], 1)) - c.eye;
                return glm::dvec3(glm::dot(c.right, p), -glm::dot(c.up, p), glm::dot(c.forward, p));
            };
            for (const auto& e : edgesOf(mesh)) {
                const std::array ends = {viewOf(e.first), viewOf(e.second)};
                if (ends[0].z > 0 && ends[1].z > 0) edges_.push_back(ends);
            }
        }
    }

    void byEndPoints() {
        start();
        for (const auto& e : edges_) {
            const glm::dvec2 a = project(e[0]), b = project(e[1]);
            const int steps = stepsOf(a, b);
            glm::dvec2 p = a;
            const glm::dvec2 step = (b - a) / double(steps);
            for (int i = 0; i <= steps; ++i, p += step) paint(p);
        }
    }
    void byEveryPoint() {
        start();
        for (const auto& e : edges_) {
            const int steps = stepsOf(project(e[0]), project(e[1]));
            glm::dvec3 p = e[0];
            const glm::dvec3 step = (e[1] - e[0]) / double(steps);
            for (int i = 0; i <= steps; ++i, p += step) paint(project(p));
        }
        projections_ -= 2 * edges_.size();  // less the projections that found how many points an edge has
    }
    uint64_t edges() const { return edges_.size(); }
    uint64_t projections() const { return projections_; }
    uint64_t painted() const { return std::accumulate(canvas_.begin(), canvas_.end(), uint64_t(0)); }

private:
    void start() {
        projections_ = 0;
        std::fill(canvas_.begin(), canvas_.end(), uint8_t(0));
    }
    glm::dvec2 project(const glm::dvec3& p) {
        ++projections_;
        return {width_ / 2.0 + focal_ * p.x / p.z, height_ / 2.0 + focal_ * p.y / p.z};
    }
    static int stepsOf(const glm::dvec2& a, const glm::dvec2& b) {
        return std::max(1, int(std::min(1e6, std::ceil(std::max(std::abs(b.x - a.x), std::abs(b.y - a.y))))));
    }
    void paint(const glm::dvec2& p) {
        if (p.x >= 0 && p.x < width_ && p.y >= 0 && p.y < height_) canvas_[size_t(p.y) * width_ + size_t(p.x)] = 1;
    }

    uint32_t width_, height_;
    double focal_ = 0;
    std::vector<uint8_t> canvas_;
    std::vector<std::array<glm::dvec3, 2>> edges_;
    uint64_t projections_ = 0;
};

ClaimTable linesStayLines(const Scene& scene, const ClaimOptions& options) {
    ClaimTable table{"P7",
                     "Projecting end points and drawing lines on the screen is far cheaper than projecting every point of an edge.",
                     "All edges of the mesh, painted both ways by plain code of one thread on the host.",
                     {},
                     {}};
    EdgePainter painter(scene, options);
    painter.byEndPoints();
    table.ways.push_back({"end points, then 2-D lines",
                          {{"edges", painter.edges()}, {"projections", painter.projections()}, {"pixels", painter.painted()}},
                          {},
                          {}});
    painter.byEveryPoint();
    table.ways.push_back(
        {"every point", {{"edges", painter.edges()}, {"projections", painter.projections()}, {"pixels", painter.painted()}}, {}, {}});
    takeTurns(table, {[&] { painter.byEndPoints(); }, [&] { painter.byEveryPoint(); }}, options);
    if (table.ways[0].counts[2].second == 0 || table.ways[1].counts[2].second == 0) table.failure = "no pixel was painted";
    if (table.ways[0].counts[1].second != 2 * painter.edges()) table.failure = "end points: not two projections an edge";
    if (table.ways[1].counts[1].second < table.ways[0].counts[1].second) table.failure = "every point: fewer projections than two an edge";
    return table;
}

// Claim P8, section 12: of a closed convex object about half of the polygons face away.
ClaimTable cullingIsCheap(Device& device, const Scene& scene, const ClaimOptions& options) {
    ClaimTable table{"P8",
                     "Culling is a cheap first step: about half of the polygons of a closed convex object are left out "
                     "before anything is filled.",
                     "Phong pictures of the same scene, resident on the device, with and without culling.",
                     {},
                     {}};
    std::vector<std::unique_ptr<ResidentScene>> residents;
    std::vector<std::function<void()>> works;
    for (const bool cull : {true, false}) {
        Scene one = scene;
        one.cullBackFaces = cull;
        const RenderCounters c = renderGpu(device, one, requestOf(Shading::phong, options)).counters;
        table.ways.push_back({cull ? "culled" : "not culled",
                              {{"triangles", c.triangles}, {"back-facing", c.culledBackFace}, {"drawn", c.drawnTriangles}},
                              {},
                              {}});
        residents.push_back(std::make_unique<ResidentScene>(device, one, requestOf(Shading::phong, options)));
        works.emplace_back([resident = residents.back().get()] { resident->draw(); });
    }
    takeTurns(table, works, options);
    const double share = double(table.ways[0].counts[1].second) / double(table.ways[0].counts[0].second);
    // A viewer near a convex body sees less than half of it, and never more.
    if (share < 0.5) table.failure = fmt::format("only {:.1f} % of the triangles look away", 100 * share);
    if (table.ways[1].counts[1].second != 0) table.failure = "triangles were culled without culling";
    return table;
}

// Claim P9, section 17: one illumination a polygon, a vertex, a visible pixel.
ClaimTable shadingCosts(Device& device, const Scene& scene, const ClaimOptions& options) {
    ClaimTable table{"P9",
                     "Flat shading illuminates each polygon once, Gouraud each vertex, Phong each visible pixel; cost "
                     "rises in this order.",
                     "Pictures of the same scene, resident on the device.",
                     {},
                     {}};
    std::vector<std::unique_ptr<ResidentScene>> residents;
    std::vector<std::function<void()>> works;
    uint64_t faces = 0, vertices = 0;
    for (const Object& object : scene.objects) {
        faces += scene.meshes[object.mesh].faceCentre.size();
        vertices += scene.meshes[object.mesh].positions.size();
    }
    const std::pair<const char*, Shading> ways[] = {{"flat", Shading::flat}, {"Gouraud", Shading::gouraud}, {"Phong", Shading::phong}};
    for (const auto& [name, shading] : ways) {
        const RenderResult picture = renderGpu(device, scene, requestOf(shading, options));
        const uint64_t wanted = shading == Shading::flat ? faces : shading == Shading::gouraud ? vertices : picture.frame.coveredPixels;
        if (picture.counters.illuminations != wanted)
            table.failure = fmt::format("{}: {} illuminations, not {}", name, picture.counters.illuminations, wanted);
        table.ways.push_back({name, {{"illuminations", picture.counters.illuminations}}, {}, {}});
        residents.push_back(std::make_unique<ResidentScene>(device, scene, requestOf(shading, options)));
        works.emplace_back([resident = residents.back().get()] { resident->draw(); });
    }
    takeTurns(table, works, options);
    return table;
}

}  // namespace

// Runs every way once a round, a different one first each time, because the second way finds the caches of the first.
void takeTurns(ClaimTable& table, const std::vector<std::function<void()>>& works, const ClaimOptions& options) {
    PLUMB_ASSERT(works.size() == table.ways.size() && options.rounds >= 3);
    std::vector<std::vector<double>> ms(works.size());
    for (uint32_t round = 0; round < kWarmRounds + options.rounds; ++round) {
        if (options.onProgress) options.onProgress(double(round) / (kWarmRounds + options.rounds));
        for (size_t i = 0; i < works.size(); ++i) {
            const size_t way = (i + round) % works.size();
            const double time = msOf(works[way]);
            if (round >= kWarmRounds) ms[way].push_back(time);
        }
    }
    for (size_t i = 0; i < works.size(); ++i) {
        table.ways[i].ms = spreadOf(ms[i]);
        table.ways[i].ratio = ratioOf(ms[i], ms[0]);
    }
}

std::vector<ClaimTable> benchClaims(Device& device, const Scene& scene, const ClaimOptions& options) {
    return {fillingIsExpensive(device, scene, options), linesStayLines(scene, options), cullingIsCheap(device, scene, options),
            shadingCosts(device, scene, options)};
}

}  // namespace plumb
