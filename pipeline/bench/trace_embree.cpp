// SPDX-License-Identifier: MIT
#include "pipeline/bench/trace_peers.h"
#include "pipeline/passes/parallel.h"

#include "host/error.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>

#ifdef PLUMB_EMBREE
#include <dlfcn.h>
#include <embree3/rtcore.h>
#endif

namespace plumb::peers {

#ifdef PLUMB_EMBREE
namespace {

// Embree, opened when a benchmark needs it, so that the program starts without it.
struct Embree {
    void* library = ::dlopen("libembree3.so.3", RTLD_NOW | RTLD_LOCAL);
    bool whole = library != nullptr;
    template <class Function>
    Function find(const char* name) {
        void* address = library ? ::dlsym(library, name) : nullptr;
        whole = whole && address != nullptr;
        return reinterpret_cast<Function>(address);
    }
    decltype(&rtcNewDevice) newDevice = find<decltype(&rtcNewDevice)>("rtcNewDevice");
    decltype(&rtcReleaseDevice) releaseDevice = find<decltype(&rtcReleaseDevice)>("rtcReleaseDevice");
    decltype(&rtcGetDeviceError) getDeviceError = find<decltype(&rtcGetDeviceError)>("rtcGetDeviceError");
    decltype(&rtcNewScene) newScene = find<decltype(&rtcNewScene)>("rtcNewScene");
    decltype(&rtcReleaseScene) releaseScene = find<decltype(&rtcReleaseScene)>("rtcReleaseScene");
    decltype(&rtcSetSceneFlags) setSceneFlags = find<decltype(&rtcSetSceneFlags)>("rtcSetSceneFlags");
    decltype(&rtcSetSceneBuildQuality) setSceneBuildQuality = find<decltype(&rtcSetSceneBuildQuality)>("rtcSetSceneBuildQuality");
    decltype(&rtcCommitScene) commitScene = find<decltype(&rtcCommitScene)>("rtcCommitScene");
    decltype(&rtcNewGeometry) newGeometry = find<decltype(&rtcNewGeometry)>("rtcNewGeometry");
    decltype(&rtcSetNewGeometryBuffer) setNewGeometryBuffer = find<decltype(&rtcSetNewGeometryBuffer)>("rtcSetNewGeometryBuffer");
    decltype(&rtcCommitGeometry) commitGeometry = find<decltype(&rtcCommitGeometry)>("rtcCommitGeometry");
    decltype(&rtcAttachGeometry) attachGeometry = find<decltype(&rtcAttachGeometry)>("rtcAttachGeometry");
    decltype(&rtcReleaseGeometry) releaseGeometry = find<decltype(&rtcReleaseGeometry)>("rtcReleaseGeometry");
    decltype(&rtcIntersect1) intersect1 = find<decltype(&rtcIntersect1)>("rtcIntersect1");
};
const Embree& rtc() {
    static const Embree kOne;
    return kOne;
}

}  // namespace

struct EmbreeScene::Impl {
    RTCDevice device = rtc().newDevice(nullptr);
    RTCScene scene = rtc().newScene(device);
    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() {
        rtc().releaseScene(scene);
        rtc().releaseDevice(device);
    }
};

EmbreeScene::EmbreeScene(const TraceScene& from, bool robust) : impl_(std::make_unique<Impl>()) {
    rtc().setSceneFlags(impl_->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtc().setSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry mesh = rtc().newGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corners =
        static_cast<float*>(rtc().setNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, from.corners.size() / 2));
    auto* triangles =
        static_cast<uint32_t*>(rtc().setNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, from.triangles.size() / 2));
    for (size_t i = 0; i < from.corners.size() / 2; ++i)
        for (int k = 0; k < 3; ++k) corners[3 * i + size_t(k)] = from.corners[2 * i][k];
    for (size_t i = 0; i < from.triangles.size() / 2; ++i)
        for (int k = 0; k < 3; ++k) triangles[3 * i + size_t(k)] = from.triangles[2 * i][k];
    rtc().commitGeometry(mesh);
    rtc().attachGeometry(impl_->scene, mesh);
    rtc().releaseGeometry(mesh);
    rtc().commitScene(impl_->scene);
    if (rtc().getDeviceError(impl_->device) != RTC_ERROR_NONE) throw renderError("Embree refuses the mesh of the benchmark");
}
EmbreeScene::~EmbreeScene() = default;

void EmbreeScene::primaryRays(const gpu::TracePush& push, uint32_t height, std::span<uint32_t> triangle, uint32_t threads) const {
    parallelBands(height, 8, threads, [&](uint64_t begin, uint64_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        for (uint64_t y = begin; y < end; ++y)
            for (uint64_t x = 0; x < push.width; ++x) {
                const glm::vec3 d = gpu::primaryDirection(push.rayOrigin, push.rayX, push.rayY, float(x) + 0.5f, float(y) + 0.5f);
                RTCRayHit ray{};
                ray.ray.dir_x = d.x;
                ray.ray.dir_y = d.y;
                ray.ray.dir_z = d.z;
                ray.ray.tfar = gpu::kFarthestHit;
                ray.ray.mask = ~0u;
                ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                rtc().intersect1(impl_->scene, &context, &ray);
                triangle[y * push.width + x] = ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? gpu::kNoObject : ray.hit.primID;
            }
    });
}
bool hasEmbree(std::string& why) {
    if (!rtc().whole) why = "libembree3.so.3 is not there (Debian: libembree3-3)";
    return rtc().whole;
}
#else
struct EmbreeScene::Impl {};
EmbreeScene::EmbreeScene(const TraceScene&, bool) { throw renderError("this build found no Embree"); }
EmbreeScene::~EmbreeScene() = default;
void EmbreeScene::primaryRays(const gpu::TracePush&, uint32_t, std::span<uint32_t>, uint32_t) const {}
bool hasEmbree(std::string& why) {
    why = "the build found no Embree 3 (Debian: libembree-dev)";
    return false;
}
#endif

}  // namespace plumb::peers
