// SPDX-License-Identifier: MIT
// Spheres: the implicit sphere rendering of the lecture notes. Contract: shaders/shared/spheres.h.
#pragma once

#include "host/recorder.h"
#include "shaders/shared/spheres.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// Spheres of a canvas in their order, and for each row the spheres that meet it.
struct SphereList {
    SphereList(int canvasWidth, int canvasHeight) : width(canvasWidth), height(canvasHeight) {}

    // Adds a sphere. False: it does not meet the canvas and is left out.
    bool add(const gpu::SphereDisc& disc);
    // Makes the rows. Throws Error(input) when a row has more than gpu::kSpheresOfRow spheres, or all rows more than 2^31. It names the
    // first disc that is one too many by `locationOf(index)`, which says where a file states it.
    void close(const std::function<std::string(size_t)>& locationOf);

    int width = 0, height = 0;
    std::vector<gpu::SphereDisc> discs;
    std::vector<uint32_t> rowFirst, rowDiscs;  // height + 1; indices into discs
};

// Illumination of the spheres.
struct SphereLight {
    gpu::ShadeParts parts;
    std::span<const gpu::MaterialRecord> materials;
    std::span<const gpu::LightRecord> lights;
    bool wholeHeights = false;
    float unit = 1;  // length of a pixel in the passes' lengths, a power of two
};

// Result, a pixel: depth (gpu::kSphereFarthest: nothing), sphere (gpu::kNoSphere) and linear colour; w is 0.
struct SphereCanvas {
    std::vector<float> depth;
    std::vector<uint32_t> owner;
    std::vector<glm::vec4> colour;
};

// Draws on the CPU: sphere by sphere over a Z-buffer, then the illumination of the visible pixels.
SphereCanvas spheresCpu(const SphereList& list, const SphereLight& light, uint32_t threads);

// Draws on the device. Throws Error(failed) where the device has no memory left.
SphereCanvas spheresGpu(Device& device, Recorder& recorder, const SphereList& list, const SphereLight& light, const Specialization& exact,
                        double watchdogMs);

}  // namespace plumb
