// SPDX-License-Identifier: MIT
// Compares device and twin twice: each pass on the twin's input, and the whole chain on each side's own output.
#include "host/error.h"
#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/bounds/bound.h"
#include "pipeline/render/stage_check.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/sha256.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace plumb {

namespace {

constexpr size_t kSmallPlane = 1 << 18;  // values; the hash of so few takes as long as a thread's start

template <class T>
std::string hashOf(const std::vector<T>& v) {
    return sha256Hex(std::as_bytes(std::span<const T>(v)));
}

class Verifier {
public:
    Verifier(Device& device, const Scene& scene, const RenderRequest& request, std::vector<VerifyEvidence>* evidence)
        : device_(device), scene_(scene), request_(request), technique_(techniqueOf(scene, request)), check_(report_, evidence) {}

    VerifyReport run() {
        refuse(scene_, request_);
        if (request_.trade.native()) {
            const ColourBound bound = boundOfNative(scene_, request_);
            if (!bound.proved) throw usageError("verify: the device's own functions have no bound here: " + bound.why);
            report_.bounded = true;
            report_.boundLinear = bound.linear;
            report_.boundSteps = bound.steps;
        }
        pictureOf(scene_, request_, RunsOn::device)->verifyStages(device_, check_);
        chain();
        report_.equal = report_.mismatches.empty();
        return std::move(report_);
    }

private:
    // A code between those of the ends of what the colour may be, and as many steps beyond as the device's own curve may be off.
    bool codeAsNear(uint32_t code, float linear, size_t channel) const {
        const double off = report_.boundLinear[glm::length_t(channel)];
        const float ends[] = {float(double(linear) - off), float(double(linear) + off)};
        const uint32_t encoding = request_.encoding == Encoding::linear ? gpu::kEncodeLinear : gpu::kEncodeSrgb;
        const auto codeOf = [&](float x) {
            const float grey[3] = {x, x, x};
            return double(encodePixelCpu(encoding, grey, 0) & 0xff);
        };
        return code >= codeOf(ends[0]) - report_.boundSteps && code <= codeOf(ends[1]) + report_.boundSteps;
    }
    bool colourAsNear(uint32_t twin, uint32_t device, const float* linear) const {
        bool near = twin >> 24 == device >> 24;
        for (size_t c = 0; near && c < 3; ++c) near = codeAsNear(device >> (8 * c) & 0xff, linear[c], c);
        return near;
    }

    // within(i): the values differ, and may.
    template <class T, class Within>
    void comparePlane(const char* name, const std::vector<T>& twin, const std::vector<T>& device, uint32_t channels, const Within& within) {
        if (twin.empty() && device.empty()) return;  // pictures of this kind have no such plane
        VerifyPlane plane{name, "", "", 0};
        const bool small = twin.size() < kSmallPlane;
        parallelBands(2, 1, small ? 1 : threadCount(request_.threads), [&](uint64_t first, uint64_t end) {
            for (; first < end; ++first) (first == 0 ? plane.twinSha256 : plane.deviceSha256) = first == 0 ? hashOf(twin) : hashOf(device);
        });
        if (twin.size() != device.size()) {
            plane.differing = plane.beyond = std::max(twin.size(), device.size());
            report_.planes.push_back(plane);
            report_.mismatches.push_back({name, true, fmt::format("twin has {} values, device has {}", twin.size(), device.size())});
            return;
        }
        int64_t first = -1;
        bool finite = true;
        for (size_t i = 0; i < twin.size(); ++i) {
            bool bad = !sameBits(twin[i], device[i]);
            if constexpr (std::is_same_v<T, float>) {
                if (std::isnan(twin[i]) || std::isnan(device[i])) bad = true, finite = false;
            }
            if (!bad) continue;
            ++plane.differing;
            if (within(i)) continue;
            ++plane.beyond;
            if (first < 0) first = int64_t(i);
        }
        report_.planes.push_back(plane);
        if (first < 0) return;
        check_.keep<T>(technique_.wholePass != nullptr ? technique_.wholePass : name, name, twin, device);
        const size_t pixel = size_t(first) / channels, width = report_.twin.frame.width;
        const size_t x = pixel % width, y = pixel / width;
        std::string values = fmt::format("twin has {}, device has {}", twin[size_t(first)], device[size_t(first)]);
        if constexpr (std::is_same_v<T, float>)
            values += fmt::format(", {} ULP{}", ulpDistance(twin[size_t(first)], device[size_t(first)]), finite ? "" : "; not a number");
        report_.mismatches.push_back(
            {name, true,
             fmt::format("tile ({}, {}), pixel ({}, {}): {}; object {}, primitive {}; {} values differ{}", x / gpu::kTileWidth,
                         y / gpu::kTileHeight, x, y, values, int(report_.twin.frame.object[pixel]),
                         int(report_.twin.frame.primitive[pixel]), plane.differing,
                         report_.bounded ? fmt::format(", {} beyond the bound", plane.beyond) : "")});
    }

    void compareRays(const RenderCounters& a, const RenderCounters& b) {
        const auto differ = [&](const std::string& name, uint64_t twin, uint64_t device) {
            if (twin != device)
                report_.mismatches.push_back({"counters", true, fmt::format("{}: twin counts {}, device {}", name, twin, device)});
        };
        differ("depths of rays", a.rays.size(), b.rays.size());
        for (size_t i = 0; i < std::min(a.rays.size(), b.rays.size()); ++i) {
            differ(fmt::format("primary rays of depth {}", i + 1), a.rays[i].primary, b.rays[i].primary);
            differ(fmt::format("reflected rays of depth {}", i + 1), a.rays[i].reflected, b.rays[i].reflected);
            differ(fmt::format("refracted rays of depth {}", i + 1), a.rays[i].refracted, b.rays[i].refracted);
            differ(fmt::format("shadow rays of depth {}", i + 1), a.rays[i].shadowRays, b.rays[i].shadowRays);
        }
        differ("refined pixels", a.refinedPixels, b.refinedPixels);
        differ("undecided rays", a.undecidedRays, b.undecidedRays);
    }

    void compareCounts(const RenderResult& twin, const RenderResult& device) {
        const RenderCounters &a = twin.counters, &b = device.counters;
        const std::tuple<const char*, uint64_t, uint64_t> counts[] = {
            {"drawn triangles", a.drawnTriangles, b.drawnTriangles},
            {"back-facing", a.culledBackFace, b.culledBackFace},
            {"zero area", a.culledZeroArea, b.culledZeroArea},
            {"outside", a.culledOutside, b.culledOutside},
            {"clipped", a.clipped, b.clipped},
            {"illuminations", a.illuminations, b.illuminations},
            {"covered pixels", twin.frame.coveredPixels, device.frame.coveredPixels}};
        for (const auto& [name, want, got] : counts)
            if (want != got)
                report_.mismatches.push_back({"counters", true, fmt::format("{}: twin counts {}, device {}", name, want, got)});
        compareRays(a, b);
    }

    void chain() {
        RenderRequest request = request_;
        request.planes = technique_.planes;
        // The twin takes the first half of the progress.
        if (request_.onProgress) request.onProgress = [this](double done) { return request_.onProgress(done / 2); };
        report_.twin = renderCpu(scene_, request);
        if (request_.onProgress) request.onProgress = [this](double done) { return request_.onProgress((1 + done) / 2); };
        report_.device = renderGpu(device_, scene_, request);
        const Frame &t = report_.twin.frame, &d = report_.device.frame;
        const auto coverage = [](const Frame& f) {
            std::vector<uint32_t> c(f.object.size());
            for (size_t i = 0; i < c.size(); ++i) c[i] = f.object[i] != kNone;
            return c;
        };
        comparePlane("coverage", coverage(t), coverage(d), 1, [](size_t) { return false; });
        forEachPlane([&](const auto& row, auto plane) {
            comparePlane(row.name, t.*plane, d.*plane, row.channels, [&](size_t i) {
                if (row.plane == kPlaneLinear) return check_.asNear(t.linear[i], d.linear[i], i % 3);
                return row.plane == kPlaneColour && report_.bounded && colourAsNear(t.rgba[i], d.rgba[i], &t.linear[3 * i]);
            });
        });
        compareCounts(report_.twin, report_.device);
        if (technique_.wholePass != nullptr) report_.passes.push_back({technique_.wholePass, report_.mismatches.empty()});
    }

    Device& device_;
    const Scene& scene_;
    const RenderRequest request_;
    const Technique& technique_;
    VerifyReport report_;
    StageCheck check_;
};

}  // namespace

VerifyReport verifyRender(Device& device, const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    return Verifier(device, scene, request, nullptr).run();
}

VerifyReport verifyRender(Device& device, const Scene& scene, const RenderRequest& request, std::vector<VerifyEvidence>& evidence) {
    const PlainFloats plain;
    return Verifier(device, scene, request, &evidence).run();
}

}  // namespace plumb
