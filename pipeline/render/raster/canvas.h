// SPDX-License-Identifier: MIT
// The colours and planes of a band on the device, and the passes that write them: fill and resolve.
#pragma once

#include "pipeline/passes/resolve.h"
#include "pipeline/render/raster/tiles.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// Least number of tiles with one triangle that are drawn by a kernel of their own, without loops. Half a million pixels cost many times what another
// dispatch does.
inline constexpr size_t kOnesApart = 4096;

class Canvas {
public:
    Canvas(Device& device, Recorder& recorder, const Prepared& prepared, double watchdogMs);

    // Begins to make the largest pipeline, that of a fill() with these choices and planes, for a picture without very large triangles.
    void prepare(FillChoices choices, uint32_t planes);
    // Clears the buffers of the tiles' band to background.
    void begin(const Tiles& tiles, uint32_t planes);
    // Fills, shades and encodes. `choices` as the plan says with planes, prior and colour set.
    void fill(FillChoices choices, Geometry& geometry, const Tiles& tiles);
    // Averages the samples of each pixel in linear light and encodes them.
    void resolve(const gpu::FrameBox& band, uint32_t encoding, bool transparent, bool linearOut);

    // The planes, and the sum of the lights where they come in windows.
    uint32_t withSum(uint32_t planes) const;
    // Keeps the colours of all further bands of a picture, one band after another.
    void keepBands() { inPlace_ = true; }

    const Buffer<glm::uvec4>& colours() const { return colours_; }
    uint32_t rowPixels() const { return rowQuads_ * 4; }  // row pitch of colours(), in samples or resolved pixels
    uint32_t resolvedRowPixels() const { return resolvedQuads_ * 4; }
    std::span<const uint32_t> colourWords() const;  // colours of the band, after keepBands() of all bands so far. Row pitch: rowPixels()
    std::span<const uint32_t> plane(uint32_t slot) const;              // words of a sample plane
    std::span<const uint32_t> resolvedColours() const;                 // row pitch: resolvedRowPixels()
    std::span<const uint32_t> resolvedLinear(uint32_t channel) const;  // float32

private:
    bool clearsEmptyTiles() const;
    void clearEmptyTiles(const Tiles& tiles);
    bool lightsInWindows() const;  // more lights than one dispatch adds up
    FillChoices onDevice(FillChoices choices, bool wide) const;
    gpu::FillPush pushOf(const Geometry& geometry, const gpu::FrameBox& band) const;
    void recordWindows(const FillChoices& choices, Geometry& geometry, const Tiles& tiles, std::span<const glm::uvec4> several,
                       std::span<const glm::uvec4> alone);
    void recordTiles(Geometry& geometry, const Tiles& binned, std::span<const glm::uvec4> tiles, const Buffer<glm::uvec4>& buffer,
                     gpu::FillPush push, const FillChoices& choices);

    Device& device_;
    Recorder& recorder_;
    const Prepared& prepared_;
    const double watchdogMs_;
    bool inPlace_ = false;      // colours_ holds all bands
    uint64_t firstColour_ = 0;  // index of the band's first colour in colours_, in units of 4
    uint32_t rowQuads_ = 0, planeQuads_ = 0, resolvedQuads_ = 0, resolvedRows_ = 0, planes_ = 0;
    Buffer<uint32_t> encodeTable_;
    Buffer<glm::uvec4> tileBuffer_, aloneBuffer_, colours_, planeBuffer_, resolved_;
    Buffer<glm::vec4> resolvedLinear_;
};

}  // namespace plumb
