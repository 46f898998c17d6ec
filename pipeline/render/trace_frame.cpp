// SPDX-License-Identifier: MIT
#include "pipeline/render/trace_frame.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/resolve.h"
#include "pipeline/render/stopwatch.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace plumb {

namespace {

constexpr uint64_t kTwinBandSamples = uint64_t(1) << 22;
// lavapipe ends loops after 65,535 iterations of a subgroup, without a word.
constexpr uint64_t kLoopLimit = 60000;
// Object tests of one dispatch: about 4 ns each on two cores, so below 100 ms.
constexpr uint64_t kWorkPerDispatch = uint64_t(1) << 24;
constexpr uint64_t kUsualRays = 3;             // of a sample, when that is estimated
constexpr uint64_t kUsualNodes = 100;
constexpr uint32_t kListedRaysPerDispatch = 32;
constexpr uint64_t kWaitingBytes = uint64_t(64) << 20;

void countParts(const TraceScene& traced, RenderCounters& c) {
    c.triangles = c.drawnTriangles = traced.triangles.size() / 2;
    c.vertices = traced.corners.size() / 2;
    c.objectsDrawn = c.objects;
}

void addCounts(std::span<const uint64_t> words, uint32_t maxDepth, RenderCounters& c) {
    c.rays.resize(maxDepth);
    for (uint32_t depth = 0; depth < maxDepth; ++depth) {
        const uint64_t* at = &words[size_t(depth) * gpu::kCountKinds];
        c.rays[depth].primary += at[gpu::kCountPrimary];
        c.rays[depth].reflected += at[gpu::kCountReflected];
        c.rays[depth].refracted += at[gpu::kCountRefracted];
        c.rays[depth].feelers += at[gpu::kCountFeelers];
    }
    c.undecidedRays += words[gpu::kCountUndecided];
}

// Planes of the frame from samples; the sample of a pixel is (side / 2, side / 2), as for every shading.
class TracePlanes {
public:
    TracePlanes(const Prepared& p, const Scene& scene, uint32_t planes, Frame& frame) : p_(p), scene_(scene), planes_(planes), frame_(frame) {
        PlaneWriter(p, planes & ~uint32_t(kPlaneTriangle), frame);  // as if nothing were drawn
        uint32_t triangles = 0;
        for (const Object& object : scene.objects) {
            firstOfObject_.push_back(triangles);
            triangles += uint32_t(scene.meshes[object.mesh].triangles.size());
        }
    }
    void write(uint32_t x, uint32_t y, uint32_t distanceBits, uint32_t object, const float* normal) {
        if (distanceBits == 0) return;
        const size_t at = size_t(y) * frame_.width + x;
        const double distance = double(gpu::realOf(int(distanceBits))) / p_.unit, side = p_.side;
        const uint32_t middle = p_.side / 2;
        const double centre = middle + 0.5;
        const glm::dvec3 ray = glm::dvec3(p_.rayOrigin) + glm::dvec3(p_.rayX) * (x * side + centre) +
                               glm::dvec3(p_.rayY) * (y * side + centre);
        const float depth = float(distance / std::sqrt(glm::dot(ray, ray)));
        if (planes_ & kPlaneDistance) frame_.distance[at] = float(distance);
        if (planes_ & kPlaneDepth) frame_.depth[at] = depth;
        if (planes_ & kPlaneZ) frame_.z[at] = p_.near / depth;
        if (planes_ & kPlaneNormal) std::copy(normal, normal + 3, frame_.normal.begin() + ptrdiff_t(3 * at));
        const uint32_t whole = uint32_t(scene_.spheres.size() + scene_.planes.size());
        uint32_t sceneObject = uint32_t(scene_.objects.size()) + object, primitive = 0;  // a sphere or plane is one primitive
        if (object >= whole) {
            const uint32_t triangle = object - whole;
            sceneObject = uint32_t(std::upper_bound(firstOfObject_.begin(), firstOfObject_.end(), triangle) - firstOfObject_.begin()) - 1;
            primitive = scene_.meshes[scene_.objects[sceneObject].mesh].triangles[triangle - firstOfObject_[sceneObject]].face;
        }
        if (planes_ & kPlaneObject) frame_.object[at] = sceneObject;
        if (planes_ & kPlanePrimitive) frame_.primitive[at] = primitive;
    }

private:
    const Prepared& p_;
    const Scene& scene_;
    uint32_t planes_;
    Frame& frame_;
    std::vector<uint32_t> firstOfObject_;      // triangles before each object
};

void report(const RenderRequest& request, double done) {
    if (request.onProgress && !request.onProgress(done)) throw Error(Exit::interrupted, "interrupted");
}

}  // namespace

gpu::TracePush tracePushOf(const Prepared& p, const RenderRequest& request, const TraceScene& traced) {
    gpu::TracePush push{};
    push.width = uint32_t(p.list.frame.width);
    push.sphereCount = uint32_t(traced.spheres.size());
    push.planeCount = uint32_t(traced.planes.size());
    push.lightCount = uint32_t(traced.lights.size());
    push.nodeCount = uint32_t(traced.nodes.size() / 2);
    push.reach = traced.reach;
    push.maxDepth = std::clamp(request.maxDepth, 1u, gpu::kRayDepthLimit);
    push.minWeight = request.minWeight;
    push.rayLimit = push.maxDepth;
    push.first = 1;
    push.background = p.background;
    push.rayOrigin = p.rayOrigin;
    push.rayX = p.rayX;
    push.rayY = p.rayY;
    push.sky = p.backgroundLinear;
    return push;
}

void traceFrameCpu(const Prepared& p, const Scene& scene, const RenderRequest& request, RenderResult& result) {
    const TraceScene traced = traceSceneOf(scene, p);
    const TraceChoices choices = traceChoicesOf(scene, request, p, traced);
    gpu::TracePush push = tracePushOf(p, request, traced);
    TracePlanes planes(p, scene, request.planes, result.frame);
    const uint32_t threads = threadCount(request.threads), side = p.side, width = push.width, height = uint32_t(p.list.frame.height);
    uint32_t bandRows = uint32_t(std::max<uint64_t>(side, kTwinBandSamples / width / side * side));
    if (request.bandRows) bandRows = request.bandRows * side;
    std::vector<uint32_t> distance, object;
    std::vector<float> linear, normal, resolved;
    std::vector<int> covered;
    std::vector<uint64_t> counters(gpu::kCounters);
    for (uint32_t firstRow = 0; firstRow < height; firstRow += bandRows) {
        report(request, double(firstRow) / height);
        const uint32_t rows = std::min(bandRows, height - firstRow);
        const size_t samples = size_t(rows) * width;
        distance.resize(samples);
        object.resize(samples);
        linear.resize(3 * samples);
        normal.resize(request.planes & kPlaneNormal ? 3 * samples : 0);
        push.firstItem = firstRow * width;
        push.itemCount = uint32_t(samples);
        {
            const Stopwatch watch(&result.times, "trace");
            traceCpu(push, traced, choices, {distance, object, linear, normal}, counters, threads);
        }
        const Stopwatch watch(&result.times, side > 1 ? "resolve" : "encode");
        const uint32_t pixelRows = rows / side, firstPixelRow = firstRow / side;
        const size_t first = size_t(firstPixelRow) * p.width, pixels = size_t(pixelRows) * p.width;
        const std::span<uint32_t> rgba(result.frame.rgba.data() + first, pixels);
        if (side > 1) {
            covered.assign(distance.begin(), distance.end());
            resolved.resize(3 * pixels);
            resolveCpu(p.width, pixelRows, side, request.transparent, choices.encoding, linear, covered, resolved, rgba, threads);
        } else {
            for (size_t i = 0; i < pixels; ++i)
                if (distance[i]) rgba[i] = encodePixelCpu(choices.encoding, &linear[3 * i], 255);
        }
        if (request.planes & kPlaneLinear)
            std::copy_n((side > 1 ? resolved : linear).begin(), 3 * pixels, result.frame.linear.begin() + ptrdiff_t(3 * first));
        for (uint32_t y = 0; y < pixelRows; ++y)
            for (uint32_t x = 0; x < p.width; ++x) {
                bool any = false;
                for (uint32_t k = 0; k < side * side; ++k) any |= distance[size_t(y * side + k / side) * width + x * side + k % side] != 0;
                result.frame.coveredPixels += any;
                const size_t at = size_t(y * side + side / 2) * width + x * side + side / 2;
                planes.write(x, firstPixelRow + y, distance[at], object[at], normal.empty() ? nullptr : &normal[3 * at]);
            }
        ++result.counters.bands;
    }
    addCounts(counters, push.maxDepth, result.counters);
    countParts(traced, result.counters);
}

namespace {

class DeviceTrace {
public:
    DeviceTrace(Device& device, const Prepared& p, const Scene& scene, const RenderRequest& request, RenderResult& result)
        : device_(device), p_(p), request_(request), result_(result), traced_(traceSceneOf(scene, p)),
          choices_(traceChoicesOf(scene, request, p, traced_)), push_(tracePushOf(p, request, traced_)), recorder_(device),
          planes_(p, scene, request.planes, result.frame), counters_(gpu::kCounters) {
        exact_[0] = device.selfTest().nativeDivideIsExact;
        exact_[1] = device.selfTest().nativeRootIsExact;
        const uint64_t steps = stepsOfRay(traced_);
        if (steps > kLoopLimit)
            throw inputError(scene.path, fmt::format("{} spheres and planes with {} lights need {} loop steps a ray; a device takes {}",
                                                     traced_.surfaces.size(), traced_.lights.size(), steps, kLoopLimit));
        choices_.list |= steps * push_.maxDepth > kLoopLimit;
        if (choices_.list) {
            push_.rayLimit = uint32_t(std::clamp<uint64_t>(kLoopLimit / steps, 1, kListedRaysPerDispatch));
            if (request.rayLimit) push_.rayLimit = std::min(push_.rayLimit, request.rayLimit);
        }
        // A ray opens some hundred nodes of a tree, a node costs as much as an object.
        const uint64_t work = steps + (traced_.nodes.empty() ? 0 : kUsualNodes * (1 + traced_.lights.size()));
        samplesPerDispatch_ = std::clamp<uint64_t>(kWorkPerDispatch / (work * std::min<uint64_t>(push_.maxDepth, kUsualRays)), 64, 1u << 22);
        if (choices_.list)
            samplesPerDispatch_ = std::min(samplesPerDispatch_, std::max<uint64_t>(64, kWaitingBytes / (4ull * gpu::kWaitingWords * push_.maxDepth)));
        choices_.colour = p.side == 1;
        choices_.planes = p.side > 1 ? gpu::kTracePlaneDistance | gpu::kTracePlaneLinear : 0u;
        if (request.planes & (kPlaneDepth | kPlaneDistance | kPlaneZ | kPlaneObject | kPlanePrimitive | kPlaneNormal))
            choices_.planes |= gpu::kTracePlaneDistance | gpu::kTracePlaneObject;
        if (request.planes & kPlaneLinear) choices_.planes |= gpu::kTracePlaneLinear | gpu::kTracePlaneDistance;
        if (request.planes & kPlaneNormal) choices_.planes |= gpu::kTracePlaneNormal;
        slots_ = (choices_.planes & gpu::kTracePlaneDistance ? 1u : 0u) + (choices_.planes & gpu::kTracePlaneObject ? 1u : 0u) +
                 (choices_.planes & gpu::kTracePlaneLinear ? 3u : 0u) + (choices_.planes & gpu::kTracePlaneNormal ? 3u : 0u);
    }

    void draw() {
        upload();
        const uint32_t width = push_.width, height = uint32_t(p_.list.frame.height), side = p_.side;
        push_.rowWords = (width + 3) / 4 * 4;
        const DeviceLimits& l = device_.limits();
        const uint64_t words = std::min({l.storageRangeBytes / 4, l.texelElements, device_.memoryBudgetBytes() / 16}) * 4 / 5 - 64;
        uint64_t bandRows = words / (uint64_t(push_.rowWords) * std::max(1u, slots_)) / side * side;
        if (bandRows == 0) throw renderError("a row of the picture exceeds the device's buffers");
        if (request_.bandRows) bandRows = std::min<uint64_t>(bandRows, uint64_t(request_.bandRows) * side);
        for (uint32_t firstRow = 0; firstRow < height; firstRow += uint32_t(bandRows)) {
            const uint32_t rows = uint32_t(std::min<uint64_t>(bandRows, height - firstRow));
            push_.firstRow = firstRow;
            push_.planeWords = push_.rowWords * rows;
            buffers_.colours.reserve(device_, push_.planeWords, "colours");
            buffers_.planeWords.reserve(device_, std::max<uint64_t>(1, uint64_t(push_.planeWords) * slots_), "planes");
            const uint64_t first = uint64_t(firstRow) * width, end = first + uint64_t(rows) * width;
            for (uint64_t at = first; at < end; at += samplesPerDispatch_) {
                report(request_, double(at) / (double(height) * width));
                traceSamples(at, uint32_t(std::min(samplesPerDispatch_, end - at)));
            }
            if (side > 1) resolve(rows / side);
            read(firstRow / side, rows / side);
            ++result_.counters.bands;
        }
        addCounts(counters_, push_.maxDepth, result_.counters);
        countParts(traced_, result_.counters);
        result_.times = recorder_.takeTimes();
    }

private:
    template <class T>
    void put(Buffer<T>& buffer, const std::vector<T>& from, const char* name) {
        buffer.reserve(device_, std::max<size_t>(from.size(), 1), name);
        buffer.fill(0);
        buffer.upload(from);
    }
    void upload() {
        put(buffers_.spheres, traced_.spheres, "spheres");
        put(buffers_.planes, traced_.planes, "planes of the scene");
        put(buffers_.surfaces, traced_.surfaces, "surfaces");
        put(buffers_.materials, traced_.materials, "materials");
        put(buffers_.lights, traced_.lights, "lights");
        put(buffers_.corners, traced_.corners, "corners");
        put(buffers_.triangles, traced_.triangles, "triangles");
        put(buffers_.nodes, traced_.nodes, "tree");
        put(buffers_.encodeTable, srgbBucketTable(), "encode table");
        buffers_.counters.reserve(device_, gpu::kCounters, "ray counters");
        buffers_.counters.fill(0);
        const uint64_t samples = choices_.list ? samplesPerDispatch_ : 1;
        buffers_.waiting.reserve(device_, samples * gpu::kWaitingWords * push_.maxDepth, "waiting rays");
        buffers_.states.reserve(device_, samples * gpu::kStateWords, "states of samples");
    }

    // Until no sample has a ray waiting.
    void traceSamples(uint64_t first, uint32_t count) {
        push_.firstItem = uint32_t(first);
        push_.itemCount = count;
        push_.first = 1;
        for (uint32_t unfinished = 1; unfinished != 0; push_.first = 0) {
            recordTrace(recorder_, push_, traced_, choices_, exact_, buffers_);
            recorder_.run(request_.watchdogMs);
            const std::span<uint32_t> words = buffers_.counters.span();
            unfinished = words[gpu::kCountUnfinished];
            for (size_t i = 0; i < counters_.size(); ++i) counters_[i] += words[i];
            buffers_.counters.fill(0);
            if (unfinished) report(request_, double(first) / (double(p_.list.frame.height) * push_.width));
        }
    }

    void resolve(uint32_t rows) {
        resolvedQuads_ = (p_.width + 3) / 4;
        const uint64_t quads = uint64_t(resolvedQuads_) * rows;
        const bool linearOut = request_.planes & kPlaneLinear;
        resolved_.reserve(device_, quads, "pixels");
        resolvedLinear_.reserve(device_, linearOut ? quads * 3 : 1, "linear pixels");
        gpu::ResolvePush push{};
        push.pixelQuads = uint32_t(quads);
        push.rowQuads = resolvedQuads_;
        push.sampleRowQuads = push_.rowWords / 4;
        push.samplePlaneQuads = push_.planeWords / 4;
        push.zSlot = 0;
        push.linearSlot = choices_.planes & gpu::kTracePlaneObject ? 2 : 1;
        push.side = p_.side;
        push.transparent = request_.transparent;
        recordResolve(recorder_, push, choices_.encoding, linearOut, exact_, buffers_.planeWords, buffers_.encodeTable, resolved_, resolvedLinear_);
        recorder_.run(request_.watchdogMs);
    }

    void read(uint32_t firstPixelRow, uint32_t rows) {
        const uint32_t side = p_.side, pitch = side > 1 ? resolvedQuads_ * 4 : push_.rowWords;
        const auto* words = static_cast<const uint32_t*>(side > 1 ? resolved_.data() : buffers_.colours.data());
        const std::span<const uint32_t> all = buffers_.planeWords.span();
        const auto plane = [&](uint32_t slot) { return all.data() + size_t(slot) * push_.planeWords; };
        const uint32_t opaque = request_.transparent ? 0u : 0xff000000u;
        const uint32_t linearSlot = choices_.planes & gpu::kTracePlaneObject ? 2 : 1;
        const uint32_t normalSlot = linearSlot + (choices_.planes & gpu::kTracePlaneLinear ? 3 : 0);
        Frame& out = result_.frame;
        for (uint32_t y = 0; y < rows; ++y)
            for (uint32_t x = 0; x < p_.width; ++x) {
                const size_t pixel = size_t(firstPixelRow + y) * p_.width + x;
                const uint32_t word = words[size_t(y) * pitch + x];
                out.rgba[pixel] = word | opaque;
                bool any = side == 1 && word >> 31 != 0;
                for (uint32_t k = 0; side > 1 && k < side * side; ++k)
                    any |= plane(0)[size_t(y * side + k / side) * push_.rowWords + x * side + k % side] != 0;
                out.coveredPixels += any;
                const size_t at = size_t(y * side + side / 2) * push_.rowWords + x * side + side / 2;
                for (uint32_t i = 0; i < 3 && (request_.planes & kPlaneLinear); ++i)
                    out.linear[3 * pixel + i] = side > 1 ? resolvedLinear(i, rows)[size_t(y) * pitch + x] : gpu::realOf(int(plane(linearSlot + i)[at]));
                if (!(choices_.planes & gpu::kTracePlaneObject)) continue;
                float normal[3] = {0, 0, 0};
                for (uint32_t i = 0; i < 3 && (request_.planes & kPlaneNormal); ++i) normal[i] = gpu::realOf(int(plane(normalSlot + i)[at]));
                planes_.write(x, firstPixelRow + y, plane(0)[at], plane(1)[at], normal);
            }
    }
    const float* resolvedLinear(uint32_t channel, uint32_t rows) const {
        return static_cast<const float*>(resolvedLinear_.data()) + size_t(channel) * resolvedQuads_ * 4 * rows;
    }

    Device& device_;
    const Prepared& p_;
    const RenderRequest& request_;
    RenderResult& result_;
    TraceScene traced_;
    TraceChoices choices_;
    gpu::TracePush push_;
    Recorder recorder_;
    TracePlanes planes_;
    std::vector<uint64_t> counters_;
    Specialization exact_;
    TraceBuffers buffers_;
    Buffer<glm::uvec4> resolved_;
    Buffer<glm::vec4> resolvedLinear_;
    uint64_t samplesPerDispatch_ = 0;
    uint32_t slots_ = 0, resolvedQuads_ = 0;
};

}  // namespace

void traceFrameGpu(Device& device, const Prepared& p, const Scene& scene, const RenderRequest& request, RenderResult& result) {
    DeviceTrace(device, p, scene, request, result).draw();
}

}  // namespace plumb
