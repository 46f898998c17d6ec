// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/geometry.h"

#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/transform.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

void Geometry::upload(const DrawList& chunk) {
    chunk_ = &chunk;
    uploadView(true);
    put<glm::vec4>(device_, positions_, chunk.positions, "positions");
    put<glm::vec4>(device_, normals_, chunk.normals, "normals");
    put<glm::uvec4>(device_, triangles_, chunk.triangles, "triangles");
    if (chunk.anyLong) {
        clipSpace_.reserve(device_, std::max<uint64_t>(1, chunk.positions.size()), "clip space");
        clipSpace_.fill(0);  // of vertices in float32
    }
    put<gpu::MaterialRecord>(device_, materials_, chunk.materials, "materials");
    std::vector<uint32_t> materialOf(chunk.triangles.size());
    const bool flat = prepared_.choices.shading == gpu::kShadingFlat;
    for (size_t t = 0; t < materialOf.size(); ++t) materialOf[t] = flat ? chunk.triangleFace[t] : chunk.triangles[t].w;
    put<uint32_t>(device_, triangleMaterial_, materialOf, "triangle materials");
    if (prepared_.choices.shading == gpu::kShadingGouraud)
        put<uint32_t>(device_, vertexMaterial_, chunk.vertexMaterial, "vertex materials");
    if (flat) {
        put<glm::vec4>(device_, facePositions_, chunk.facePositions, "face positions");
        put<glm::vec4>(device_, faceNormals_, chunk.faceNormals, "face normals");
        put<uint32_t>(device_, faceMaterial_, chunk.faceMaterial, "face materials");
        faceColours_.reserve(device_, std::max<uint64_t>(1, chunk.facePositions.size()), "face colours");
    }
    const uint64_t corners = chunk.positions.size() + std::min<uint64_t>(kClipCornersAtFirst, chunk.positions.size() / 8 + 64);
    screen_.reserve(device_, corners, "screen vertices");
    attributes_.reserve(device_, corners, "attributes");
    records_.reserve(device_, (chunk.triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane, "cull records");
}

void Geometry::uploadView(bool objects) {
    const DrawList& chunk = *chunk_;
    if (objects) attributesAreNormals_ = false;
    put<gpu::ObjectRecord>(device_, objects_, chunk.objects, "objects");
    if (chunk.anyLong) put<gpu::LongRecord>(device_, longs_, chunk.longs, "long rows");
    put<gpu::LightRecord>(device_, lights_, chunk.lights, "lights");
    std::vector<glm::vec4> centres(chunk.faceCentres.empty() ? 1 : chunk.triangles.size());
    if (!chunk.faceCentres.empty())
        for (size_t t = 0; t < centres.size(); ++t) centres[t] = chunk.faceCentres[chunk.triangleFace[t]];
    put<glm::vec4>(device_, triangleCentres_, centres, "centres of faces");
}

void Geometry::transformAndCull(bool normals) {
    const FillChoices& choices = prepared_.choices;
    const bool gouraud = choices.shading == gpu::kShadingGouraud && !normals;
    // World normals do not depend on the camera, so they stay from picture to picture of one upload.
    const bool wantNormals = choices.shading == gpu::kShadingPhong || normals;
    const bool writeNormals = (wantNormals && !attributesAreNormals_) || choices.keepNormals;
    for (const DrawList::Range& r : chunk_->ranges) {
        if (r.vertexCount == 0) continue;
        const gpu::TransformPush push{0, r.firstVertex, r.vertexCount, r.record, chunk_->viewport};
        const Normals written = writeNormals ? normalsOfTransform(choices, normals) : Normals::none;
        if (r.precision == Precision::fp32)
            recordTransform(recorder_, push, written, {}, positions_, normals_, objects_, screen_, attributes_);
        else
            recordLongTransform(recorder_, device_, push, written, {}, positions_, normals_, objects_, screen_, attributes_,
                                {r.precision, longs_, clipSpace_});
        const uint32_t lightCount = uint32_t(chunk_->lights.size());
        if (gouraud)
            recordIlluminate(recorder_, {0, r.firstVertex, r.vertexCount, r.record, 0, lightCount, chunk_->towardViewer}, choices.parts, {},
                             positions_, normals_, vertexMaterial_, objects_, materials_, lights_, attributes_);
        if (choices.shading == gpu::kShadingFlat && !normals && r.faceCount)
            recordIlluminate(recorder_, {0, r.firstFace, r.faceCount, r.record, 0, lightCount, chunk_->towardViewer}, choices.parts, {},
                             facePositions_, faceNormals_, faceMaterial_, objects_, materials_, lights_, faceColours_);
    }
    recordCull(recorder_, {0, uint32_t(chunk_->triangles.size()), chunk_->cullBackFaces, chunk_->frame}, {}, triangles_, screen_, records_);
    attributesAreNormals_ = false;
    recorder_.run(watchdogMs_);
    attributesAreNormals_ = wantNormals;
}

void Geometry::assignSlots() {
    const uint64_t lanes = (chunk_->triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane;
    slots_ = drawSlotsOf(records_.span().first(lanes), *chunk_, uint32_t(chunk_->positions.size()));
    const uint64_t corners = chunk_->positions.size() + slots_.clippedVertices;
    budget_.check("drawn triangles", slots_.drawCount, sizeof(gpu::DrawTriangle));
    budget_.check("vertices", corners, sizeof(glm::vec4));
    if (corners > screen_.count()) {  // more clipped triangles than usual: keep the transformed vertices
        const std::vector<gpu::ScreenVertex> screen(screen_.span().begin(), screen_.span().end());
        const std::vector<glm::vec4> attributes(attributes_.span().begin(), attributes_.span().end());
        screen_.reserve(device_, corners, "screen vertices");
        attributes_.reserve(device_, corners, "attributes");
        screen_.upload(screen);
        attributes_.upload(attributes);
    }
    draws_.reserve(device_, slots_.drawCount, "draw list");
    sources_.reserve(device_, std::max(1u, slots_.drawCount), "drawn triangles");
    listDrawn(std::as_const(records_).span().first(lanes), sources_.span().first(slots_.drawCount));
}

void Geometry::setUp(const SetupTiles& tiles) {
    recordSetup(recorder_, {0, slots_.drawCount, tiles.tilesX, tiles.room, chunk_->frame}, chunk_->cullBackFaces == 0, {}, triangles_,
                screen_, sources_, draws_, tiles.tiles, tiles.entries, tiles.overflow);
    wide_ = slots_.wide;
    clippedDrawn_ = 0;
    if (slots_.jobs.empty()) return recorder_.skip("clip", "no triangle crosses the near plane or leaves the guard band");
    put<gpu::ClipJob>(device_, jobs_, slots_.jobs, "clip jobs");
    kinds_.reserve(device_, slots_.jobs.size(), "clip kinds");
    recordClip(recorder_, {0, uint32_t(slots_.jobs.size()), chunk_->cullBackFaces, chunk_->frame, chunk_->viewport}, {}, triangles_,
               positions_, objects_, jobs_, screen_, attributes_, draws_, kinds_, chunk_->anyLong ? &clipSpace_ : nullptr);
    recorder_.run(watchdogMs_);
    for (size_t j = 0; j < slots_.jobs.size(); ++j) {
        wide_ |= kinds_.span()[j] & 1;
        clippedDrawn_ += kinds_.span()[j] >> 1;
    }
}

}  // namespace plumb
