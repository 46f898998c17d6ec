// SPDX-License-Identifier: MIT
// The device's side of a frame, step by step: the geometry of a chunk, the tiles of a band, the canvas of a band. Each step submits and
// waits. Between steps the host adds up counts and completes lists, so no list loses an entry (decision 5). verify puts the twin's output
// between the steps.
//
// Steps of a frame, and what each writes:
//   upload()            the chunk: vertices, triangles, objects, materials, lights
//   transformAndCull()  screen vertices, attributes (normals or colours), cull records
//   beginBand()         cleared colours and planes of the band
//   setup()             draw list, clipped corners; when the band is the frame, tile lists of small triangles
//   bin()               strips, tile lists, tile records; lists of overflowed tiles
//   fill()              colours and planes
//   resolve()           one colour a pixel from its samples
#pragma once

#include "pipeline/render/raster/canvas.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

class GpuFrame {
public:
    GpuFrame(Device& device, const Prepared& prepared, double watchdogMs);
    GpuFrame(const GpuFrame&) = delete;  // the parts keep references to the recorder
    GpuFrame& operator=(const GpuFrame&) = delete;

    void prepare(const FillChoices& choices, uint32_t planes) { canvas_.prepare(choices, planes); }
    // Uploads a chunk; buffers grow as needed.
    void upload(const DrawList& chunk) { geometry_.upload(chunk); }
    // Uploads what of the chunk depends on the camera and on where its objects stand (`objects`: their matrices too).
    void uploadView(bool objects) { geometry_.uploadView(objects); }
    void transformAndCull(bool normals) { geometry_.transformAndCull(normals); }
    // Runs the host step, set-up and clip. Throws TooLarge before anything is written. When the current band is the whole frame, small
    // triangles are binned at once.
    void setup();
    // setup() for a caller that goes on with bin(): where nothing is clipped, both are one submission.
    void setupForBin();
    // Clears the band's buffers to background.
    void beginBand(const gpu::FrameBox& band, uint32_t planes);
    // Bins the current chunk in the band. Throws TooLarge.
    void bin() { tiles_.bin(geometry_); }
    void fill(const FillChoices& choices) { canvas_.fill(choices, geometry_, tiles_); }
    void resolve(uint32_t encoding, bool transparent, bool linearOut) { canvas_.resolve(tiles_.band(), encoding, transparent, linearOut); }

    // Largest chunk and band that fit ranges, texel counts and the memory budget.
    uint64_t chunkTriangles() const { return budget_.chunkTriangles(); }
    uint32_t bandRows(uint32_t planes) const { return budget_.bandRows(prepared_.list.frame, canvas_.withSum(planes)); }
    bool fitsWhole(uint32_t planes) const { return budget_.holdsWhole(prepared_.list, canvas_.withSum(planes)); }
    uint32_t bandRowsInPlace() const { return budget_.bandRowsInPlace(prepared_.list.frame); }
    void keepBands() { canvas_.keepBands(); }
    void limitRoom(uint32_t most) { tiles_.limitRoom(most); }

    const Buffer<glm::uvec4>& colours() const { return canvas_.colours(); }
    uint32_t rowPixels() const { return canvas_.rowPixels(); }
    std::span<const uint32_t> colourWords() const { return canvas_.colourWords(); }
    std::span<const uint32_t> plane(uint32_t slot) const { return canvas_.plane(slot); }
    std::span<const uint32_t> resolvedColours() const { return canvas_.resolvedColours(); }
    std::span<const uint32_t> resolvedLinear(uint32_t channel) const { return canvas_.resolvedLinear(channel); }
    uint32_t resolvedRowPixels() const { return canvas_.resolvedRowPixels(); }

    Recorder& recorder() { return recorder_; }
    const DrawSlots& slots() const { return geometry_.slots(); }
    uint64_t clippedDrawn() const { return geometry_.clippedDrawn(); }
    uint64_t binEntries() const { return tiles_.entryCount(); }
    bool binned() const { return tiles_.binned(); }
    uint32_t overflowedTiles() const { return tiles_.overflowed(); }
    size_t stripCount() const { return tiles_.stripCount(); }  // strips of the last bin()

    // Buffers for verify: the output of a step, and the input of the next.
    std::span<gpu::ScreenVertex> screen() { return geometry_.screen().span(); }
    std::span<glm::vec4> attributes() { return geometry_.attributes().span(); }
    std::span<glm::vec4> faceColours() { return geometry_.faceColours().span(); }
    std::span<gpu::CullRecord> records() { return geometry_.records().span(); }
    std::span<gpu::DrawTriangle> draws() { return geometry_.draws().span(); }
    TileLists lists() const { return tiles_.lists(); }
    gpu::BinPush binPush() const { return tiles_.pushFor(geometry_); }

private:
    const Prepared& prepared_;
    const double watchdogMs_;
    const Budget budget_;
    Recorder recorder_;
    Geometry geometry_;
    Tiles tiles_;
    Canvas canvas_;
};

}  // namespace plumb
