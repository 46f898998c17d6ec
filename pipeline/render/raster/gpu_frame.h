// SPDX-License-Identifier: MIT
// The device's side of a frame, step by step. Each step submits and waits; between steps the host adds up counts and completes lists,
// so no list loses an entry (decision 5). verify puts the twin's output between the steps.
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

#include "pipeline/passes/bin.h"
#include "pipeline/passes/cull.h"
#include "pipeline/passes/fill.h"
#include "pipeline/passes/resolve.h"
#include "pipeline/render/prepare.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// Thrown when the chunk or the band does not fit the device's ranges: the caller halves it.
struct TooLarge {
    std::string what;
};

// Least number of single-triangle tiles (half a million pixels) that are drawn by the kernel without loops; fewer do not pay for its
// compilation and a second dispatch.
inline constexpr size_t kOnesApart = 4096;

class GpuFrame {
public:
    GpuFrame(Device& device, const Prepared& prepared, double watchdogMs);

    // Begins to make the largest pipeline, that of a fill() with these choices and planes, for a picture without very large triangles.
    void prepare(FillChoices choices, uint32_t planes);
    // Uploads a chunk; buffers grow as needed.
    void upload(const DrawList& chunk);
    // Runs transform, illuminate and cull. `normals`: the attributes are world normals whatever the shading (normal plane).
    void transformAndCull(bool normals);
    // Runs the host step, set-up and clip. Throws TooLarge before anything is written. When the current band is the whole frame, small
    // triangles are binned at once.
    void setup();
    // Runs setup() for a caller that continues with bin(): where nothing is clipped, both are one submission.
    void setupForBin();
    // Clears the band's buffers to background.
    void beginBand(const gpu::FrameBox& band, uint32_t planes);
    // Bins the current chunk in the band. Throws TooLarge.
    void bin();
    // Fills, shades and encodes. `choices` as the plan says with planes, prior and colour set.
    void fill(FillChoices choices);
    // Averages the samples of each pixel in linear light and encodes them.
    void resolve(uint32_t encoding, bool transparent, bool linearOut);

    // Largest chunk and band that fit ranges, texel counts and the memory budget.
    uint64_t chunkTriangles() const;
    uint32_t bandRows(uint32_t planes) const;
    // True when the draw list fits one chunk by its actual vertex and face counts (chunkTriangles() assumes the worst case). setup() and
    // bin() may still throw TooLarge.
    bool fitsWhole(uint32_t planes) const;
    // Keeps the colours of all later bands of a picture, one band after another.
    void keepBands() { inPlace_ = true; }
    // Limits the entries of a tile's list (tests of overflow).
    void limitRoom(uint32_t most) { mostRoom_ = most; }
    // Rows of a band in place (a multiple of 8): as many as a binding takes. 0: all bands are too much for one buffer.
    uint32_t bandRowsInPlace() const;

    const Buffer<glm::uvec4>& colours() const { return colours_; }
    uint32_t rowPixels() const { return rowQuads_ * 4; }  // row pitch of colours(), in samples or resolved pixels
    // Words of the band, or of all bands so far after keepBands(). Row pitch: rowPixels()
    std::span<const uint32_t> colourWords() const;
    std::span<const uint32_t> plane(uint32_t slot) const;              // of the sample planes
    std::span<const uint32_t> resolvedColours() const;                 // row pitch: resolvedRowPixels()
    std::span<const uint32_t> resolvedLinear(uint32_t channel) const;  // float32
    uint32_t resolvedRowPixels() const { return resolvedQuads_ * 4; }

    Recorder& recorder() { return recorder_; }
    const DrawPlaces& places() const { return places_; }
    uint64_t binEntries() const { return binEntries_; }
    bool binned() const { return binned_; }                   // setup() has binned small triangles for the next bin()
    uint32_t overflowedTiles() const { return overflowed_; }  // overflowed tiles of the last bin()
    size_t stripCount() const { return strips_.size(); }      // strips of the last bin()
    uint64_t clippedDrawn() const { return clippedDrawn_; }

    // Buffers for verify: the output of a step, and the input of the next.
    std::span<gpu::ScreenVertex> screen() { return screen_.span(); }
    std::span<glm::vec4> carried() { return carried_.span(); }
    std::span<glm::vec4> faceColours() { return faceColours_.span(); }
    std::span<gpu::CullRecord> records() { return records_.span(); }
    std::span<gpu::DrawTriangle> draws() { return draws_.span(); }
    TileLists lists() const;  // lists of the last bin(), each ascending
    gpu::BinPush binPush() const;

private:
    bool clearsEmptyTiles() const;
    void clearEmptyTiles();
    void makeRoom();
    void makeStrips();
    void collectLists(uint32_t walked, bool binned);
    void listOverflowed(uint64_t end, uint32_t walked, bool binned);
    uint64_t mostEntries() const;
    void recordTiles(std::span<const glm::uvec4> tiles, const Buffer<glm::uvec4>& buffer, gpu::FillPush push, const FillChoices& choices);
    FillChoices onDevice(FillChoices choices) const;
    bool lightsInWindows() const;             // more lights than one dispatch adds up
    uint32_t withSum(uint32_t planes) const;  // planes with the sum of the lights, where they come in windows
    void checkFits(const char* what, uint64_t count, uint64_t elementBytes) const;

    Device& device_;
    const Prepared& prepared_;
    const DrawList* chunk_ = nullptr;
    Recorder recorder_;
    double watchdogMs_;
    DrawPlaces places_;
    uint64_t binEntries_ = 0, clippedDrawn_ = 0;
    uint32_t room_ = 0, mostRoom_ = 0xffffffffu, overflowed_ = 0;  // entries of a tile's list; overflowed tiles
    bool wide_ = false;
    bool inPlace_ = false;         // colours_ holds all bands
    uint64_t firstColour_ = 0;     // offset of the band in colours_
    bool binned_ = false;          // tiles_ and entries_ hold the small triangles of the chunk in this band
    bool carriedNormals_ = false;  // carried_ holds the world normals of what was uploaded
    gpu::FrameBox band_{};
    uint32_t tilesX_ = 0, tilesY_ = 0, rowQuads_ = 0, planeQuads_ = 0, resolvedQuads_ = 0, planes_ = 0;
    std::vector<glm::uvec4> strips_;
    std::vector<glm::uvec4> tileRecords_;

    Buffer<glm::vec4> trianglePlaces_;
    Buffer<glm::vec4> positions_, normals_, facePositions_, faceNormals_, carried_, faceColours_;
    Buffer<uint32_t> vertexMaterial_, faceMaterial_, triangleMaterial_, sources_, kinds_, tiles_, entries_, setupOverflow_, walkOverflow_,
        stripOverflow_, encodeTable_;
    Buffer<PlacedTriangle> medium_;
    Buffer<glm::uvec4> triangles_, stripBuffer_, tileBuffer_, aloneBuffer_, colours_, planeBuffer_, resolved_;
    Buffer<glm::vec4> resolvedLinear_;
    Buffer<gpu::ObjectRecord> objects_;
    Buffer<gpu::LongRecord> longs_;
    Buffer<glm::vec4> clipSpace_;
    Buffer<gpu::MaterialRecord> materials_;
    Buffer<gpu::LightRecord> lights_;
    Buffer<gpu::ScreenVertex> screen_;
    Buffer<gpu::CullRecord> records_;
    Buffer<gpu::DrawTriangle> draws_;
    Buffer<gpu::ClipJob> jobs_;
};

}  // namespace plumb
