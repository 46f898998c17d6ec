// SPDX-License-Identifier: MIT
#include "pipeline/command/report.h"

#include "pipeline/image/image.h"
#include "pipeline/scene/camera.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace plumb {
namespace {

uint64_t trianglesOf(const Scene& scene) {
    uint64_t triangles = 0;
    for (const Object& object : scene.objects) triangles += scene.meshes[object.mesh].triangles.size();
    return triangles;
}

uint64_t distinctColours(const std::vector<uint32_t>& rgba) {
    std::vector<uint64_t> seen((size_t(1) << 24) / 64);  // one bit a colour while all pixels have the same alpha
    const uint32_t alpha = rgba.empty() ? 0 : rgba[0] & 0xff000000u;
    uint64_t count = 0;
    for (const uint32_t pixel : rgba) {
        if ((pixel & 0xff000000u) != alpha) {
            std::vector<uint32_t> sorted = rgba;
            std::sort(sorted.begin(), sorted.end());
            return uint64_t(std::unique(sorted.begin(), sorted.end()) - sorted.begin());
        }
        uint64_t& word = seen[(pixel & 0xffffffu) / 64];
        const uint64_t bit = uint64_t(1) << pixel % 64;
        count += (word & bit) == 0;
        word |= bit;
    }
    return count;
}

void countFaults(FrameFacts& facts, const Frame& frame, const char* plane, const std::vector<float>& values,
                 bool infinityMeansNothingDrawn) {
    if (values.empty()) return;
    const size_t channels = values.size() / (size_t(frame.width) * frame.height);
    for (size_t i = 0; i < values.size(); ++i) {
        const float v = values[i];
        if (std::isfinite(v) || (infinityMeansNothingDrawn && v > 0)) continue;
        ++(std::isnan(v) ? facts.nan : facts.inf);
        if (!facts.firstFault.empty()) continue;
        const size_t pixel = i / channels;
        facts.firstFault = fmt::format("{} at pixel ({}, {}) is {}", plane, pixel % frame.width, pixel / frame.width, v);
        if (!frame.object.empty()) facts.firstFault += fmt::format(", object {}", frame.object[pixel]);
        if (!frame.primitive.empty()) facts.firstFault += fmt::format(", primitive {}", frame.primitive[pixel]);
    }
}

Json vectorJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

std::string nothingSeen(const RenderCounters& counters) {
    const uint64_t faces = counters.polygons != 0 ? counters.polygons : counters.triangles;
    const char* why = "";
    if (counters.objects != 0 && counters.objectsDrawn == 0)
        why = ": every object is outside the view";
    else if (faces != 0 && counters.culledBackFace == faces)
        why = ": every polygon faces away from the viewer; --cull off draws them";
    return fmt::format("plumb: warning: nothing is seen{}", why);
}

std::vector<SourceFile> sourcesOf(const std::vector<std::string>& paths, const LoadOptions& options) {
    std::vector<SourceFile> sources;
    for (const std::string& path : paths) {
        const std::string bytes = readInput(path, options);
        sources.push_back({path, sha256Hex(std::as_bytes(std::span(bytes))), bytes.size()});
    }
    return sources;
}

FrameFacts factsOf(const Frame& frame, bool countColours) {
    FrameFacts facts;
    facts.pixels = frame.rgba.size();
    facts.covered = frame.coveredPixels;
    if (countColours) facts.distinctColours = distinctColours(frame.rgba);
    forEachPlane([&](const auto& row, auto plane) {
        if constexpr (std::is_same_v<decltype(row.undrawn), float>)
            countFaults(facts, frame, row.name, frame.*plane, std::isinf(row.undrawn));
    });
    return facts;
}

bool isBlank(const FrameFacts& facts, double leastShare) {
    return facts.covered == 0 || facts.coveredShare() < leastShare || facts.distinctColours <= 1;
}

Json hostJson() {
    std::string vendor, model;
    std::ifstream cpuinfo("/proc/cpuinfo");
    for (std::string line; std::getline(cpuinfo, line) && (vendor.empty() || model.empty());) {
        const size_t colon = line.find(": ");
        if (colon == line.npos) continue;
        if (line.starts_with("vendor_id")) vendor = line.substr(colon + 2);
        if (line.starts_with("model name")) model = line.substr(colon + 2);
    }
    return {{"cpu_vendor", vendor}, {"cpu_model", model}, {"threads", std::thread::hardware_concurrency()}};
}

Json sceneJson(const Scene& scene, const std::vector<SourceFile>& sources) {
    Json json;
    json["path"] = sources.empty() ? scene.path : sources[0].path;
    json["sha256"] = sources.empty() ? scene.sha256 : sources[0].sha256;
    if (sources.size() > 1) {
        json["files"] = Json::array();
        for (const SourceFile& s : sources) json["files"].push_back({{"path", s.path}, {"sha256", s.sha256}, {"bytes", s.bytes}});
    }
    json["triangles"] = trianglesOf(scene);
    json["objects"] = scene.objects.size();
    if (!scene.spheres.empty()) json["spheres"] = scene.spheres.size();
    if (!scene.planes.empty()) json["planes"] = scene.planes.size();
    json["materials"] = scene.materials.size();
    json["lights"] = scene.lights.size();
    json["ignored"] = scene.ignored;
    json["warnings"] = scene.warnings;
    return json;
}

Json planJson(const Plan& plan) {
    Json skipped = Json::array();
    for (const Plan::Drop& drop : plan.dropped)
        skipped.push_back({{"pass", drop.what}, {"why", drop.why}, {"drop", drop.row}, {"saves", drop.saves}});
    Json steps = Json::array();
    for (const PlanStep& step : plan.steps) {
        Json one = {{"pass", step.name}, {"side", nameOf(step.side)}, {"why", step.why}, {"ran", step.ran}};
        one["fused_in"] = step.fusedIn.empty() ? Json() : Json(step.fusedIn);
        one["nothing_to_do"] = step.idle.empty() ? Json() : Json(step.idle);
        steps.push_back(std::move(one));
    }
    return {{"passes", plan.names()}, {"steps", steps}, {"skipped", skipped}, {"choices", plan.choices}};
}

Json accuracyJson(const Plan& plan) {
    Json raised = Json::array();
    const auto bound = [](double b) { return std::isfinite(b) ? Json(b) : Json(); };
    for (const Plan::Raise& r : plan.raised)
        raised.push_back({{"what", r.what},
                          {"object", r.of},
                          {"to", r.to},
                          {"why", r.why},
                          {"usual_bound", bound(r.usual)},
                          {"bound", bound(r.reached)},
                          {"unit", r.unit}});
    return {{"raised", raised}, {"warnings", plan.warnings}};
}

Json countersJson(const RenderCounters& c) {
    Json json = {{"objects", c.objects},
                 {"objectsDrawn", c.objectsDrawn},
                 {"vertices", c.vertices},
                 {"triangles", c.triangles},
                 {"culledBackFace", c.culledBackFace},
                 {"culledZeroArea", c.culledZeroArea},
                 {"culledOutside", c.culledOutside},
                 {"clipped", c.clipped},
                 {"drawnTriangles", c.drawnTriangles},
                 {"illuminations", c.illuminations},
                 {"transformed", c.transformed},
                 {"lightsAdded", c.lightsAdded},
                 {"polygons", c.polygons},
                 {"normals", c.normals},
                 {"edges", c.edges},
                 {"chunks", c.chunks},
                 {"bands", c.bands},
                 {"binEntries", c.binEntries}};
    if (c.rays.empty()) return json;
    Json& rays = json["rays"] = Json::array();
    for (const RenderCounters::RayCounts& r : c.rays)
        rays.push_back({{"primary", r.primary}, {"reflected", r.reflected}, {"refracted", r.refracted}, {"feelers", r.shadowRays}});
    json["undecidedRays"] = c.undecidedRays;
    json["refinedPixels"] = c.refinedPixels;
    return json;
}

Json cameraJson(const Camera& camera) {
    return {{"eye", vectorJson(camera.eye)},         {"right", vectorJson(camera.right)},
            {"up", vectorJson(camera.up)},           {"forward", vectorJson(camera.forward)},
            {"fovYDegrees", camera.fovYDegrees},     {"focalPixels", camera.focalPixels},
            {"focusDistance", camera.focusDistance}, {"near", nearOf(camera)}};
}

Json imageJson(const Frame& frame, const FrameFacts& facts, bool blank) {
    return {{"sha256_pixels", sha256Hex(std::as_bytes(std::span(frame.rgba)))},
            {"size", {frame.width, frame.height}},
            {"covered", facts.coveredShare()},
            {"covered_pixels", facts.covered},
            {"distinct_colours", facts.distinctColours},
            {"blank", blank},
            {"nan", facts.nan},
            {"inf", facts.inf}};
}

Json memoryJson(const Renderer& renderer) {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return {{"peak_bytes", uint64_t(usage.ru_maxrss) * 1024}, {"device_peak_bytes", renderer.devicePeakBytes()}};
}

Json deviceJson(const Renderer& renderer) {
    Json json;
    if (renderer.device() == nullptr) {
        json["name"] = "CPU twin";
        json["type"] = "twin";
    } else {
        const Device& device = *renderer.device();
        const DeviceInfo& info = device.info();
        const DeviceLimits& limits = device.limits();
        const SelfTest& test = device.selfTest();
        json["name"] = info.name;
        json["type"] = info.type;
        json["driver"] = info.driver;
        json["driverInfo"] = info.driverInfo;
        json["api"] = info.apiVersion;
        json["uuid"] = info.uuid;
        json["index"] = info.index;
        json["lavapipe"] = info.lavapipe;
        json["limits"] = {{"storageRangeBytes", limits.storageRangeBytes},
                          {"texelElements", limits.texelElements},
                          {"groupCount", limits.groupCount},
                          {"allocationBytes", limits.allocationBytes},
                          {"groupInvocations", limits.groupInvocations},
                          {"subgroupSize", limits.subgroupSize},
                          {"memoryBudgetBytes", device.memoryBudgetBytes()}};
        json["selfTest"] = {{"passed", test.failure.empty()},
                            {"fromCache", test.fromCache},
                            {"time_ms", test.timeMs},
                            {"nativeDivideIsExact", test.nativeDivideIsExact},
                            {"nativeRootIsExact", test.nativeRootIsExact},
                            {"loopLimit", test.loopLimit}};
    }
    json["reason"] = renderer.choice().reason;
    json["notChosen"] = renderer.choice().notChosen;
    return json;
}

}  // namespace plumb
