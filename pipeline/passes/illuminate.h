// SPDX-License-Identifier: MIT
// Illuminate: colours of vertices (Gouraud) or of face centres (flat). Contract: shaders/shared/illuminate.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

void illuminateCpu(const gpu::IlluminatePush& push, const gpu::ShadeParts& parts, std::span<const glm::vec4> positions,
                   std::span<const glm::vec4> normals, std::span<const uint32_t> pointMaterials, std::span<const gpu::ObjectRecord> objects,
                   std::span<const gpu::MaterialRecord> materials, std::span<const gpu::LightRecord> lights, std::span<glm::vec4> colours,
                   uint32_t threads);

void recordIlluminate(Recorder& recorder, const gpu::IlluminatePush& push, const gpu::ShadeParts& parts, const Specialization& exact,
                      const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals, const Buffer<uint32_t>& pointMaterials,
                      const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::MaterialRecord>& materials,
                      const Buffer<gpu::LightRecord>& lights, const Buffer<glm::vec4>& colours);

// Reflectance of a material, with its base colour.
gpu::Reflectance reflectanceOf(const gpu::MaterialRecord& material);

}  // namespace plumb
