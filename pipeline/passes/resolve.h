// SPDX-License-Identifier: MIT
// Resolve: samples of an ordered grid -> pixels, in linear light. Contract: shaders/shared/resolve.h.
#pragma once

#include "host/recorder.h"
#include "shaders/shared/resolve.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// Resolves a frame of samples. `samples`: linear RGB (3 floats each, background where nothing is drawn). `z`: their z bits. Both are (width
// side) x (height side), or (width + 1) x (height + 1) with `stride` 1 for side 2 (shared corners). stride 0: side. `pixels`: linear RGB.
// `rgba`: encoded.
void resolveCpu(uint32_t width, uint32_t height, uint32_t side, bool transparent, uint32_t encoding, std::span<const float> samples,
                std::span<const int> z, std::span<float> pixels, std::span<uint32_t> rgba, uint32_t threads, uint32_t stride = 0);

void recordResolve(Recorder& recorder, const gpu::ResolvePush& push, uint32_t encoding, bool linearOut, const Specialization& exact,
                   const RawBuffer& samplePlanes, const Buffer<uint32_t>& encodeTable, const Buffer<glm::uvec4>& colours,
                   const Buffer<glm::vec4>& linear);

}  // namespace plumb
