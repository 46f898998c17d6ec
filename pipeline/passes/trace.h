// SPDX-License-Identifier: MIT
// Trace: rays from the eye, their reflections and refractions, and shadow rays to the lights. Contract: shaders/shared/trace.h.
#pragma once

#include "host/recorder.h"
#include "shaders/shared/encode.h"
#include "shaders/shared/trace.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// Scene of rays: in the passes' unit, relative to the eye. Objects count spheres first, then planes, then triangles.
struct TraceScene {
    std::vector<glm::vec4> spheres;  // centre, radius
    std::vector<float> powers;       // |centre|^2 - radius^2 of each sphere, rounded once
    std::vector<gpu::PlaneRecord> planes;
    std::vector<uint32_t> surfaces;     // material of each sphere and plane
    std::vector<glm::vec4> corners;     // two each: position, normal
    std::vector<glm::uvec4> triangles;  // two each: corners and material, bits of the geometric normal
    std::vector<glm::uvec4> nodes;      // nodes of the BVH: two words a child (tree.h)
    std::vector<glm::uvec4> leaves;     // leaves of the BVH, three words each
    uint32_t depth = 0;                 // depth of the BVH
    float reach = 0;                    // largest |coordinate| of a corner
    std::vector<gpu::TraceMaterial> materials;
    std::vector<gpu::LightRecord> lights;
    bool far = false;        // some sphere is farther than 256 of its radii from something else
    bool close = false;      // the eye is within 1/16 radius of the surface of some sphere
    bool branching = false;  // some material has two children
};

struct TraceChoices {
    uint32_t encoding = gpu::kEncodeSrgb;
    uint32_t planes = 0;  // gpu::kTracePlane bits
    bool colour = true;   // write the encoded sample
    bool list = false;    // keep waiting rays in a list; needed where a hit has two children
    bool shadows = true;
    bool mirrors = true, passes = true;  // mirrored and refracted rays are sent on; false: no hit asks for one
    bool count = true;
    uint32_t lanes = 0;  // device: invocations of a subgroup that work together (DeviceLimits::subgroupShuffle); 0: none
    bool tiles = false;  // device: samples of whole rows, in tiles (push.tileRows); not with `list`
    uint32_t sampling = gpu::kSampleGrid, side = 1;  // side: samples a pixel along an axis
    // x | y << 16: only the samples of these pixels, `side` rows of `side` a pixel; empty: those of all pixels
    std::span<const uint32_t> pixels;
    bool cutLevels = false;                                    // colours in whole levels; no material has two children and no ray waits
    float jitterMirror = 0, jitterPass = 0, jitterShadow = 0;  // amounts of noise, at most 1/2
    gpu::ShadeParts parts{true, true, true, gpu::kPowerExact};
};

// Output of the twin: one value a sample (three floats for linear and normal), row by row; normal may be empty.
struct TraceOutput {
    std::span<uint32_t> distance;  // bits; 0 where nothing is hit
    std::span<uint32_t> object;
    std::span<float> linear;
    std::span<float> normal;
};

// Traces on the CPU the samples that push.firstItem and itemCount name; output begins at firstItem. `counters`: gpu::kCounters words that
// are added to.
void traceCpu(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices, const TraceOutput& output,
              std::span<uint64_t> counters, uint32_t threads);

// One ray of a sample's tree as the twin follows it. Lengths in the passes' unit, positions relative to the eye.
struct TracedRay {
    uint32_t parent = gpu::kNoObject;  // index of the ray that sent it; kNoObject: it comes from the eye
    uint32_t kind = gpu::kCountPrimary, depth = 1;
    glm::vec3 origin{0}, direction{0};
    float weight = 1;
    uint32_t from = gpu::kNoObject;  // object that it starts on, and whether it runs inside of it
    bool inside = false;
    // Object of its hit; kNoObject: none, and the members below say nothing.
    uint32_t object = gpu::kNoObject, material = 0;
    float t = 0;
    bool within = false;                                    // it runs with the outward normal
    glm::vec3 point{0}, geometric{0}, normal{0}, bends{0};  // normals on the ray's side
    glm::vec3 shares{0};                                    // of a triangle's corners
    gpu::Children children{};
    bool slid = false;                // the refracted ray was given the least slope
    std::vector<float> lightReaches;  // for each light, the share of it that reaches the point; 0 where the light is behind the surface
    glm::vec3 sum{0};                 // the sample's colour when this ray's own part has been added
};
// Tree of the sample in column `column` and row `row` of the samples' grid, each ray before its children and the mirrored one first. Not with
// choices.cutLevels.
std::vector<TracedRay> traceTree(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices, uint32_t column,
                                 uint32_t row);

struct TraceBuffers {
    Buffer<glm::vec4> spheres;
    Buffer<float> powers;
    Buffer<gpu::PlaneRecord> planes;
    Buffer<uint32_t> surfaces;
    Buffer<gpu::TraceMaterial> materials;
    Buffer<gpu::LightRecord> lights;
    Buffer<glm::vec4> corners;
    Buffer<glm::uvec4> triangles, nodes, leaves;
    Buffer<uint32_t> encodeTable, pixels;
    Buffer<uint32_t> colours, planeWords;  // colours and planes of one band
    Buffer<uint32_t> counters;             // gpu::kCounters words
    Buffer<uint32_t> waiting, states;      // list form, for the samples of one dispatch
};

// Samples that an invocation traces one after another. A tile has two rows for each of them, and push.itemCount counts invocations.
uint32_t samplesOfInvocation(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices);
void recordTrace(Recorder& recorder, const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices,
                 const Specialization& exact, const TraceBuffers& buffers);

}  // namespace plumb
