// SPDX-License-Identifier: MIT
#include "pipeline/bench/trace_peers.h"
#include "pipeline/passes/parallel.h"

#include "host/error.h"

#ifdef PLUMB_EMBREE
#include <dlfcn.h>
#include <embree3/rtcore.h>
#endif

namespace plumb::peers {

#ifdef PLUMB_EMBREE
namespace {

// Opened when a benchmark asks, so that the program needs no Embree to start.
struct Embree {
    void* library = ::dlopen("libembree3.so.3", RTLD_NOW | RTLD_LOCAL);
    bool whole = library != nullptr;
    template <class Function>
    Function find(const char* name) {
        void* address = library ? ::dlsym(library, name) : nullptr;
        whole = whole && address != nullptr;
        return reinterpret_cast<Function>(address);
    }
#define PLUMB_RTC(name) decltype(&rtc##name) name = find<decltype(&rtc##name)>("rtc" #name)
    PLUMB_RTC(NewDevice);
    PLUMB_RTC(ReleaseDevice);
    PLUMB_RTC(GetDeviceError);
    PLUMB_RTC(NewScene);
    PLUMB_RTC(ReleaseScene);
    PLUMB_RTC(SetSceneFlags);
    PLUMB_RTC(SetSceneBuildQuality);
    PLUMB_RTC(CommitScene);
    PLUMB_RTC(NewGeometry);
    PLUMB_RTC(SetNewGeometryBuffer);
    PLUMB_RTC(CommitGeometry);
    PLUMB_RTC(AttachGeometry);
    PLUMB_RTC(ReleaseGeometry);
    PLUMB_RTC(Intersect1);
#undef PLUMB_RTC
};
const Embree& rtc() {
    static const Embree kOne;
    return kOne;
}

}  // namespace

struct EmbreeScene::Impl {
    RTCDevice device = rtc().NewDevice(nullptr);
    RTCScene scene = rtc().NewScene(device);
    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() {
        rtc().ReleaseScene(scene);
        rtc().ReleaseDevice(device);
    }
};

EmbreeScene::EmbreeScene(const TraceScene& from, bool robust) : impl_(std::make_unique<Impl>()) {
    rtc().SetSceneFlags(impl_->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtc().SetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry mesh = rtc().NewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corners = static_cast<float*>(
        rtc().SetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, from.corners.size() / 2));
    auto* triangles = static_cast<uint32_t*>(
        rtc().SetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, from.triangles.size() / 2));
    for (size_t i = 0; i < from.corners.size() / 2; ++i)
        for (int k = 0; k < 3; ++k) corners[3 * i + size_t(k)] = from.corners[2 * i][k];
    for (size_t i = 0; i < from.triangles.size() / 2; ++i)
        for (int k = 0; k < 3; ++k) triangles[3 * i + size_t(k)] = from.triangles[2 * i][k];
    rtc().CommitGeometry(mesh);
    rtc().AttachGeometry(impl_->scene, mesh);
    rtc().ReleaseGeometry(mesh);
    rtc().CommitScene(impl_->scene);
    if (rtc().GetDeviceError(impl_->device) != RTC_ERROR_NONE)
        throw renderError("Embree refuses the mesh of the benchmark");
}
EmbreeScene::~EmbreeScene() = default;

void EmbreeScene::primaryRays(const gpu::TracePush& push, uint32_t height, std::span<uint32_t> triangle,
                              uint32_t threads) const {
    parallelBands(height, 8, threads, [&](uint64_t begin, uint64_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        for (uint64_t y = begin; y < end; ++y)
            for (uint64_t x = 0; x < push.width; ++x) {
                const glm::vec3 d =
                    gpu::primaryDirection(push.rayOrigin, push.rayX, push.rayY, float(x) + 0.5f, float(y) + 0.5f);
                RTCRayHit ray{};
                ray.ray.dir_x = d.x;
                ray.ray.dir_y = d.y;
                ray.ray.dir_z = d.z;
                ray.ray.tfar = gpu::kFarthestHit;
                ray.ray.mask = ~0u;
                ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                rtc().Intersect1(impl_->scene, &context, &ray);
                triangle[y * push.width + x] =
                    ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? gpu::kNoObject : ray.hit.primID;
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
