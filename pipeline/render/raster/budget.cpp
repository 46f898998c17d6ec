// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/budget.h"

#include "pipeline/passes/tile_lists.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

uint32_t planeCount(uint32_t planes) {
    return (planes & gpu::kFillPlaneZ ? 1 : 0) + (planes & gpu::kFillPlaneTriangle ? 1 : 0) + (planes & gpu::kFillPlaneLinear ? 3 : 0) +
           (planes & gpu::kFillPlaneNormal ? 3 : 0) + (planes & gpu::kFillPlaneSum ? 3 : 0);
}

uint64_t Budget::chunkTriangles() const {
    // Vertices that fit: three a triangle at worst, 16 bytes each in the screen and attributes buffers. The rest is left for clipped
    // corners and growth.
    const uint64_t vertices = std::min(limits_.storageRangeBytes / 16, limits_.texelElements);
    const uint64_t byRange = vertices / 5;
    const uint64_t byBudget = memoryBytes_ / 2 / 400;  // 400 bytes a triangle with three vertices of its own
    return std::max<uint64_t>(1, std::min(byRange, byBudget));
}

bool Budget::holdsWhole(const DrawList& list, uint32_t planes) const {
    const uint64_t vertices = list.positions.size() + kClipCornersAtFirst, triangles = list.triangles.size(),
                   faces = list.facePositions.size();
    const auto reserved = [](uint64_t count) { return count + count / 4 + 16; };  // as Buffer::reserve does
    if (reserved(vertices) > std::min(limits_.storageRangeBytes / sizeof(glm::vec4), limits_.texelElements)) return false;
    if (reserved(std::max(triangles, faces)) > limits_.texelElements) return false;
    // Bytes of upload() and of the lists, if every triangle were drawn and in two tiles; then the bytes of a band's buffers.
    const uint64_t perVertex = (list.anyLong ? 5 : 4) * sizeof(glm::vec4) + sizeof(uint32_t);
    const uint64_t perTriangle =
        (list.faceCentres.empty() ? 0 : sizeof(glm::vec4)) + sizeof(glm::uvec4) + sizeof(gpu::DrawTriangle) + 3 * sizeof(uint32_t);
    const uint64_t perFace = 3 * sizeof(glm::vec4) + sizeof(uint32_t);
    const uint64_t pixels = (uint64_t(list.frame.width) + 15) / 16 * 16 * ((uint64_t(list.frame.height) + 7) / 8 * 8);
    const uint64_t tiles = pixels / (gpu::kTileWidth * gpu::kTileHeight), room = roomOfTiles(triangles, tiles, mostEntries());
    const uint64_t geometry = reserved(vertices) * perVertex + reserved(triangles) * perTriangle + reserved(faces) * perFace +
                              reserved(tiles * room) * sizeof(uint32_t);
    const uint64_t held = reserved(pixels) * sizeof(uint32_t) * (1 + planeCount(planes));
    const uint64_t budget = memoryBytes_ / 16 * 15;
    return geometry <= budget && std::min(held, memoryBytes_ / 2) <= budget - geometry;
}

uint32_t Budget::bandRows(const gpu::FrameBox& frame, uint32_t planes) const {
    const uint64_t pitch = (uint64_t(frame.width) + 15) / 16 * 16;
    // Words that fit: reserve() takes a quarter more and 16 elements of four words.
    const uint64_t words = (std::min({limits_.storageRangeBytes / 4, limits_.texelElements, memoryBytes_ / 4 / 4}) - 64) / 5 * 4;
    const uint64_t rows = words / (pitch * std::max(1u, planeCount(planes))) / 8 * 8;
    return uint32_t(std::clamp<uint64_t>(rows, 8, uint64_t(1) << 19));
}

uint32_t Budget::bandRowsInPlace(const gpu::FrameBox& frame) const {
    const uint64_t pitch = (uint64_t(frame.width) + 15) / 16 * 16, rows = (uint64_t(frame.height) + 7) / 8 * 8;
    const uint64_t bytes = pitch * rows * sizeof(uint32_t);
    if (bytes + bytes / 4 > std::min(limits_.allocationBytes, memoryBytes_ / 2)) return 0;
    return uint32_t(std::min(rows, limits_.storageRangeBytes / sizeof(uint32_t) / pitch / 8 * 8));
}

uint64_t Budget::mostEntries() const {
    return (std::min({limits_.storageRangeBytes / 4, limits_.texelElements, memoryBytes_ / 16 / 4}) - 64) / 5 * 4;
}

void Budget::check(const char* what, uint64_t count, uint64_t elementBytes) const {
    // Size after reserve(), which takes a quarter more.
    if ((count + count / 4 + 16) * elementBytes > limits_.storageRangeBytes || count + count / 4 + 16 > limits_.texelElements)
        throw TooLarge{fmt::format("{} {} of {} bytes exceed a binding of the device", count, what, elementBytes)};
}

}  // namespace plumb
