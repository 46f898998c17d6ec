// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/sides.h"

#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/stage_check.h"
#include "pipeline/render/stopwatch.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

namespace plumb {

namespace {

// Points that are given relative to the eye already, in the world's axes.
gpu::ObjectRecord identityRecord() {
    gpu::ObjectRecord o{};
    o.world0 = o.normal0 = {1, 0, 0, 0};
    o.world1 = o.normal1 = {0, 1, 0, 0};
    o.world2 = o.normal2 = {0, 0, 1, 0};
    return o;
}
std::vector<gpu::ObjectRecord> withIdentity(const Prepared& p) {
    std::vector<gpu::ObjectRecord> objects = p.list.objects;
    objects.push_back(identityRecord());
    return objects;
}

class TwinSide : public NotesSide {
public:
    TwinSide(const Prepared& p, const RenderRequest& request, RenderResult& result)
        : p_(p), threads_(threadCount(request.threads)), result_(result), objects_(withIdentity(p)) {}
    std::vector<glm::vec4> illuminate(const NotesPoints& points, uint32_t record) override {
        const Stopwatch watch(&result_.times, "illuminate");
        std::vector<glm::vec4> colours(points.positions.size());
        const gpu::IlluminatePush push{0,
                                       0,
                                       uint32_t(colours.size()),
                                       std::min(record, uint32_t(objects_.size() - 1)),
                                       0,
                                       uint32_t(p_.list.lights.size()),
                                       p_.list.towardViewer};
        illuminateCpu(push, p_.choices.parts, points.positions, points.normals, points.materials, objects_, p_.list.materials,
                      p_.list.lights, colours, threads_);
        return colours;
    }
    ScanCanvas paint(const ScanList& list) override {
        const Stopwatch watch(&result_.times, "scanline");
        return scanlineCpu(list);
    }

private:
    const Prepared& p_;
    uint32_t threads_;
    RenderResult& result_;
    std::vector<gpu::ObjectRecord> objects_;
};

template <class T>
Buffer<T> uploaded(Device& device, std::span<const T> from, const char* name) {
    Buffer<T> buffer(device, std::max<size_t>(1, from.size()), name);
    buffer.upload(from);
    return buffer;
}

class DeviceSide : public NotesSide {
public:
    DeviceSide(Device& device, const Prepared& p, const RenderRequest& request, RenderResult& result)
        : device_(device),
          result_(result),
          p_(p),
          watchdogMs_(request.watchdogMs),
          recorder_(device),
          objects_(uploaded<gpu::ObjectRecord>(device, withIdentity(p), "objects")),
          materials_(uploaded<gpu::MaterialRecord>(device, p.list.materials, "materials")),
          lights_(uploaded<gpu::LightRecord>(device, p.list.lights, "lights")) {
        recorder_.allow(p.plan.labels(RunsOn::device));
    }
    std::vector<glm::vec4> illuminate(const NotesPoints& points, uint32_t record) override {
        const DeviceLimits& l = device_.limits();
        const uint64_t most = std::min<uint64_t>({l.storageRangeBytes / sizeof(glm::vec4), l.texelElements, uint64_t(1) << 20});
        std::vector<glm::vec4> all;
        for (uint64_t first = 0; first < points.positions.size(); first += most) {
            const uint64_t count = std::min<uint64_t>(most, points.positions.size() - first);
            const auto positions = uploaded<glm::vec4>(device_, std::span(points.positions).subspan(first, count), "points");
            const auto normals = uploaded<glm::vec4>(device_, std::span(points.normals).subspan(first, count), "point normals");
            const auto materials = uploaded<uint32_t>(device_, std::span(points.materials).subspan(first, count), "point materials");
            Buffer<glm::vec4> colours(device_, count, "point colours");
            const gpu::IlluminatePush push{0,
                                           0,
                                           uint32_t(count),
                                           std::min(record, uint32_t(p_.list.objects.size())),
                                           0,
                                           uint32_t(p_.list.lights.size()),
                                           p_.list.towardViewer};
            recordIlluminate(recorder_, push, p_.choices.parts, {}, positions, normals, materials, objects_, materials_, lights_, colours);
            recorder_.run(watchdogMs_);
            all.insert(all.end(), colours.span().begin(), colours.span().begin() + ptrdiff_t(count));
        }
        return all;
    }
    ScanCanvas paint(const ScanList& list) override { return paint(list, nullptr); }
    ScanCanvas paint(const ScanList& list, std::vector<gpu::ScanSpan>* spans) {
        return scanlineGpu(device_, recorder_, list, {}, watchdogMs_, spans);
    }
    void finish() override {
        const std::vector<PassTime> times = recorder_.takeTimes();
        result_.times.insert(result_.times.end(), times.begin(), times.end());
        for (const auto& [step, why] : recorder_.takeSkipped()) result_.plan.skip(step, why);
    }

private:
    Device& device_;
    RenderResult& result_;
    const Prepared& p_;
    double watchdogMs_;
    Recorder recorder_;
    Buffer<gpu::ObjectRecord> objects_;
    Buffer<gpu::MaterialRecord> materials_;
    Buffer<gpu::LightRecord> lights_;
};

class CheckedSide : public NotesSide {
public:
    CheckedSide(Device& device, const Prepared& p, const RenderRequest& request, RenderResult& result, StageCheck& check)
        : twin_(p, request, result), device_(device, p, request, result), check_(check) {}
    std::vector<glm::vec4> illuminate(const NotesPoints& points, uint32_t record) override {
        std::vector<glm::vec4> colours = twin_.illuminate(points, record);
        check_.compareColours("colour of point", colours, device_.illuminate(points, record));
        return colours;
    }
    ScanCanvas paint(const ScanList& list) override {
        ScanCanvas want = twin_.paint(list);
        std::vector<gpu::ScanSpan> spans;
        const ScanCanvas got = device_.paint(list, &spans);
        const std::vector<gpu::ScanSpan> wantSpans = scanSpansCpu(list);
        check_.compare<gpu::ScanSpan>("scanline", "line", wantSpans, spans);
        // The second kernel reads what the first left: it is judged where that is the twin's.
        if (wantSpans.size() == spans.size() && std::equal(spans.begin(), spans.end(), wantSpans.begin(), sameBits<gpu::ScanSpan>)) {
            check_.compare<uint32_t>("scanpaint", "polygon of sample", want.owner, got.owner);
            check_.compare<float>("scanpaint", "z of sample", want.z, got.z);
            check_.compare<glm::vec3>("scanpaint", "attributes of sample", want.attributes, got.attributes);
        }
        return want;
    }

private:
    TwinSide twin_;
    DeviceSide device_;
    StageCheck& check_;
};

}  // namespace

std::unique_ptr<NotesSide> checkedSideOf(Device& device, const Prepared& prepared, const RenderRequest& request, RenderResult& result,
                                         StageCheck& check) {
    return std::make_unique<CheckedSide>(device, prepared, request, result, check);
}

std::unique_ptr<NotesSide> notesSideOf(Device* device, const Prepared& prepared, const RenderRequest& request, RenderResult& result) {
    if (device == nullptr) return std::make_unique<TwinSide>(prepared, request, result);
    return std::make_unique<DeviceSide>(*device, prepared, request, result);
}

}  // namespace plumb
