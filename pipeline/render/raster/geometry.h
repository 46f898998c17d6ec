// SPDX-License-Identifier: MIT
// The geometry of a chunk on the device: from its upload to its drawn triangles on the screen.
#pragma once

#include "pipeline/passes/cull.h"
#include "pipeline/render/prepare.h"
#include "pipeline/render/raster/budget.h"

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

template <class T>
void put(Device& device, Buffer<T>& buffer, std::span<const T> from, const char* name) {
    buffer.reserve(device, std::max<uint64_t>(from.size(), 1), name);
    buffer.upload(from);
}

// Tile lists in which the set-up pass puts small triangles.
struct SetupTiles {
    uint32_t tilesX = 0;  // tiles in a row; 0: it lists none
    uint32_t room = 0;    // entries a tile
    const Buffer<uint32_t>& tiles;
    const Buffer<uint32_t>& entries;
    const Buffer<uint32_t>& overflow;  // bits of triangles that a full tile did not take
};

class Geometry {
public:
    Geometry(Device& device, Recorder& recorder, const Prepared& prepared, const Budget& budget, double watchdogMs)
        : device_(device), recorder_(recorder), prepared_(prepared), budget_(budget), watchdogMs_(watchdogMs) {}

    // Uploads a chunk; buffers grow as needed. The chunk must live until the next upload.
    void upload(const DrawList& chunk);
    // Uploads what of the chunk depends on the camera, and on where its objects stand. `objects`: they stand elsewhere.
    void uploadView(bool objects);
    // Runs transform, illuminate and cull. `normals`: the attributes are world normals whatever the shading (normal plane).
    void transformAndCull(bool normals);
    // Runs the host's step: gives each drawn triangle its slot. Throws TooLarge before anything is written.
    void assignSlots();
    // Records set-up; where something is clipped, runs it and clip.
    void setUp(const SetupTiles& tiles);

    const DrawList& chunk() const { return *chunk_; }
    const DrawSlots& slots() const { return slots_; }
    bool wide() const { return wide_; }  // a triangle is too large for the fill's short arithmetic
    uint64_t clippedDrawn() const { return clippedDrawn_; }

    // Buffers that a step writes and the next one reads.
    Buffer<gpu::ScreenVertex>& screen() { return screen_; }
    Buffer<glm::vec4>& attributes() { return attributes_; }
    Buffer<glm::vec4>& faceColours() { return faceColours_; }
    Buffer<gpu::CullRecord>& records() { return records_; }
    Buffer<gpu::DrawTriangle>& draws() { return draws_; }
    const Buffer<uint32_t>& triangleMaterials() const { return triangleMaterial_; }
    const Buffer<gpu::MaterialRecord>& materials() const { return materials_; }
    const Buffer<gpu::LightRecord>& lights() const { return lights_; }
    const Buffer<glm::vec4>& triangleCentres() const { return triangleCentres_; }

private:
    Device& device_;
    Recorder& recorder_;
    const Prepared& prepared_;
    const Budget& budget_;
    const double watchdogMs_;
    const DrawList* chunk_ = nullptr;
    DrawSlots slots_;
    uint64_t clippedDrawn_ = 0;
    bool wide_ = false;
    bool attributesAreNormals_ = false;  // attributes_ holds the world normals of what was uploaded

    Buffer<glm::vec4> triangleCentres_;
    Buffer<glm::vec4> positions_, normals_, facePositions_, faceNormals_, attributes_, faceColours_;
    Buffer<uint32_t> vertexMaterial_, faceMaterial_, triangleMaterial_, sources_, kinds_;
    Buffer<glm::uvec4> triangles_;
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
