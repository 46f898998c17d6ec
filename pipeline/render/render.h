// SPDX-License-Identifier: MIT
// A scene becomes a picture: on the device or by the twin, same arguments, same bytes.
#pragma once

#include "host/device.h"
#include "host/pass_time.h"
#include "pipeline/choices/choices.h"
#include "pipeline/choices/trade.h"
#include "pipeline/render/frame.h"
#include "pipeline/render/plan.h"
#include "pipeline/scene/scene.h"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// Where rays pass through a pixel, how they spread, and how their colours add up (traced pictures; docs/rays.md).
struct RayChoices {
    using Sampling = plumb::Sampling;  // adaptive: 16 samples where a pixel's corners differ by more than kCornerLevels
    Sampling sampling = Sampling::grid;
    float jitterReflect = 0, jitterRefract = 0, jitterShadow = 0;  // length of the noise added to unit directions, 0 to 1/2
    uint32_t seed = 0;                                             // seed of the noise and of Sampling::random
    // True: colours are cut to whole levels after each ray, as the notes' C program adds them. Needs Encoding::linear.
    bool cutLevels = false;
};
inline constexpr int kCornerLevels = 4;  // steps of an encoded channel of 8 bits

// Who stated a choice, in the words of the plan; empty: nobody. No picture depends on it.
struct Stated {
    std::string shading;                         // the whole sentence, where the scene asks for rays without naming them
    std::string sampling, jitter, seed, levels;  // "--seed", "the scene; --seed overrides"
};

// Limits for tests. 0 and false: as the device, its memory and the scene ask. No byte of a picture depends on them.
struct TestKnobs {
    uint64_t chunkTriangles = 0;  // most triangles (of wire frames: edges) in one upload
    uint32_t bandRows = 0;        // most rows of pixels in one band
    uint32_t rayLimit = 0;        // most rays that a sample follows in one dispatch; above 0 the list form traces them
    bool keepEverything = false;  // nothing is dropped that a plan would drop
    bool float32Only = false;     // no object is transformed in more than float32; changes bytes
};

struct RenderRequest {
    uint32_t width = 640, height = 480;  // pixels
    Shading shading = Shading::phong;
    Fill fill = Fill::exact;
    WireView wire = WireView::seeThrough;
    bool wirePerPolygon = false;  // each edge as often as polygons have it (section 2 of the notes); WireView::solid always does
    Encoding encoding = Encoding::srgb;
    uint32_t samples = 1;  // samples a pixel in an ordered grid: 1, 4 or 16
    Trade trade;
    bool distantViewer = false;      // one vector toward the viewer for all points (raster shadings); --fill notes also culls by it
    glm::vec3 background{0.0f};      // linear RGB
    bool transparent = false;        // RGBA output, background alpha 0
    uint32_t planes = kPlaneColour;  // Plane bits
    uint32_t threads = 0;            // twin: 0 = all
    // Called with the finished share, 0 to 1. False cancels: Error(interrupted).
    std::function<bool(double)> onProgress;
    double watchdogMs = 60000;  // longest wait for one submission; longer is Error(failed)
    uint32_t maxDepth = 5;      // longest chain of rays, 1 to 64 (traced pictures)
    float minWeight = 0;        // least weight of a ray that is followed
    RayChoices rays;
    bool repeated = false;  // drawn many times: kernels that take longer to make may be faster, objects out of view stay; changes no byte
    Stated stated;
    TestKnobs knobs;
};

struct RenderCounters {
    uint64_t objects = 0, objectsDrawn = 0, vertices = 0, triangles = 0;  // of the scene; objectsDrawn: those with something in the view
    uint64_t culledBackFace = 0, culledZeroArea = 0, culledOutside = 0, clipped = 0, drawnTriangles = 0;
    uint64_t transformed = 0;            // vertices of triangles and lines that are transformed, each as often as it is
    uint64_t lightsAdded = 0;            // lights added up at illuminations before rays: illuminations times the lights of the plan
    uint64_t illuminations = 0;          // flat: faces, Gouraud: vertices, Phong: shaded samples
    uint64_t polygons = 0, normals = 0;  // fill notes: faces met; a normal a face, and one a corner where corners are shaded
    uint64_t chunks = 0, bands = 0, binEntries = 0, edges = 0;
    struct RayCounts {
        uint64_t primary = 0, reflected = 0, refracted = 0, shadowRays = 0;
    };
    std::vector<RayCounts> rays;  // by depth, first the primary rays'; empty unless rays were traced
    uint64_t refinedPixels = 0;   // RayChoices::Sampling::adaptive: pixels whose corners differ
    uint64_t undecidedRays = 0;   // parallel to a plane within rounding: counted as no hit
};

struct RenderResult {
    Frame frame;
    Plan plan;
    RenderCounters counters;
    std::vector<PassTime> times;  // per pass, ms
    double totalMs = 0;           // host time of the whole render, upload and readback included
};

// True when the scene has spheres or planes, which no pass of triangles draws.
bool onlyRaysDraw(const Scene&);
// Reason to trace a scene: a shape that it has, or a material of an object that mirrors or refracts. Empty: there is none.
std::string raysAskedBy(const Scene&);
// Part of raysAskedBy() that a picture by `request` leaves out. Empty: nothing, as by rays, and of spheres that --fill notes draws.
std::string leftToRays(const Scene&, const RenderRequest&);

// The plan of the picture on that side, without drawing it.
Plan planRender(const Scene&, const RenderRequest&, RunsOn side);
RenderResult renderCpu(const Scene&, const RenderRequest&);  // the twin
RenderResult renderGpu(Device&, const Scene&, const RenderRequest&);

// Where a picture is seen from, and where its objects stand.
struct Pose {
    std::optional<Camera> camera = {};                 // nothing: as in the last draw, at first as in the scene
    std::span<const glm::dmat4> worldFromObject = {};  // one matrix an object, in the order of scene.objects; empty: as in the last draw
};

// A scene that stays on the device between pictures. A further picture costs its passes only: meshes are not uploaded again, and buffers and
// pipelines are kept. For whoever draws a scene more than once. The device outlives it; the scene is copied.
class ResidentScene {
public:
    // Valid until the next draw(). `pixels`: RGBA bytes, row 0 on top, `pitch` pixels from row to row. Where nothing but colour is asked for, the
    // device wrote them, alpha is the covered share of a pixel, and where nothing is drawn it is 0 over the background.
    struct Picture {
        const uint32_t* pixels = nullptr;
        uint32_t width = 0, height = 0, pitch = 0;
        const Frame* frame = nullptr;  // every plane that is asked for, as renderGpu draws it; null where only colour is
    };
    // Uploads. `request` as for renderGpu. Throws as renderGpu does.
    ResidentScene(Device& device, const Scene& scene, const RenderRequest& request);
    ~ResidentScene();
    ResidentScene(const ResidentScene&) = delete;
    ResidentScene& operator=(const ResidentScene&) = delete;

    // Draws by the pose. As renderGpu draws them, uploads included: a scene that needs several chunks, wire frames, the polygons of the notes,
    // and colour alone in several samples. Traced scenes are uploaded anew for a new pose. Throws Error(input) for a pose that cannot be drawn,
    // or Error(usage) for another number of matrices; the pose then stays as it was.
    Picture draw(const Pose& pose = {});
    bool resident() const;            // the last draw() uploaded no mesh: only matrices, lights, and what the passes' own host steps write
    RenderCounters counters() const;  // of the last draw()
    // The passes of one picture, each submitted by itself and timed by the host (Recorder::timeApart); draws it once more.
    std::vector<PassTime> timePasses();
    std::vector<PassTime> takeTimes();  // times of all draws since the last call

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Compares every pass on the twin's input, then the whole chain on each side's own output.
struct Mismatch {
    std::string pass;    // first pass (in data-flow order) that differs
    bool chain = false;  // found by the whole-chain comparison
    std::string what;    // one sentence: tile, pixel, both values, ULP distance, object, primitive
};
struct VerifyPlane {
    std::string name, twinSha256, deviceSha256;
    uint64_t differing = 0;
    uint64_t beyond = 0;  // values among them that differ by more than the bound of the device's own functions; without such a bound, all
};
struct VerifyReport {
    bool equal = false;                // true when no value is beyond: the same bytes, or within the bound of native choices
    bool bounded = false;              // true when the device's own functions draw (Trade::native()): colours have the next two bounds
    glm::dvec3 boundLinear{0};         // bound of a channel in linear light
    double boundSteps = 0;             // further bound in steps of the code
    std::vector<Mismatch> mismatches;  // empty when equal
    std::vector<VerifyPlane> planes;   // coverage, and every plane that a picture of this shading has
    std::vector<std::pair<std::string, bool>> passes;  // per pass on the twin's input
    RenderResult twin, device;
};
VerifyReport verifyRender(Device&, const Scene&, const RenderRequest&);

}  // namespace plumb
