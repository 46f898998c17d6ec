// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/canvas.h"

#include "host/error.h"
#include "pipeline/passes/encode.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

namespace {

// Tile-list entries and shaded tiles of one dispatch: about 20 ns and 2 us each on two cores, so well below 100 ms.
constexpr uint64_t kWorkPerDispatch = uint64_t(1) << 21;
constexpr uint64_t kWorkPerTile = 100;

}  // namespace

Canvas::Canvas(Device& device, Recorder& recorder, const Prepared& prepared, double watchdogMs)
    : device_(device), recorder_(recorder), prepared_(prepared), watchdogMs_(watchdogMs) {
    put<uint32_t>(device, encodeTable_, srgbBucketTable(), "encode table");
}

bool Canvas::lightsInWindows() const {
    return prepared_.choices.shading == gpu::kShadingPhong && prepared_.list.lights.size() > lightsPerWindow(prepared_.choices);
}

uint32_t Canvas::withSum(uint32_t planes) const { return planes | (lightsInWindows() ? gpu::kFillPlaneSum : 0u); }

void Canvas::begin(const Tiles& tiles, uint32_t planes) {
    planes_ = planes = withSum(planes);
    const gpu::FrameBox& band = tiles.band();
    rowQuads_ = tiles.across() * gpu::kTileWidth / 4;
    planeQuads_ = rowQuads_ * tiles.down() * gpu::kTileHeight;
    // Rows above the band: in place, the bands of a picture lie one after another in one buffer.
    const uint64_t above = inPlace_ ? uint64_t(band.firstRow) * rowQuads_ : 0;
    const uint64_t rows =
        inPlace_ ? (uint64_t(prepared_.list.frame.height) + gpu::kTileHeight - 1) / gpu::kTileHeight * gpu::kTileHeight : 0;
    firstColour_ = above;
    colours_.reserve(device_, std::max<uint64_t>(planeQuads_, rows * rowQuads_), "colours");
    planeBuffer_.reserve(device_, std::max<uint64_t>(1, uint64_t(planeQuads_) * planeCount(planes)), "planes");
    if (clearsEmptyTiles())
        recorder_.skip("clear", "the host clears the tiles without triangles");
    else
        recorder_.fill("clear", colours_, prepared_.background & 0xffffffu, firstColour_ * 16, uint64_t(planeQuads_) * 16);
    uint64_t slot = 0;
    const uint64_t bytes = uint64_t(planeQuads_) * 16;
    const auto clear = [&](uint32_t word) { recorder_.fill("clear", planeBuffer_, word, slot++ * bytes, bytes); };
    if (planes & gpu::kFillPlaneZ) clear(0);
    if (planes & gpu::kFillPlaneTriangle) clear(gpu::kNoTriangle);
    if (planes & gpu::kFillPlaneLinear)
        for (int i = 0; i < 3; ++i) clear(gpu::ubitsOf(prepared_.backgroundLinear[i]));
    if (planes & gpu::kFillPlaneNormal)
        for (int i = 0; i < 3; ++i) clear(0);
}

FillChoices Canvas::onDevice(FillChoices choices, bool wide) const {
    choices.wide = wide;
    choices.subgroupSize = device_.limits().subgroupShuffle ? device_.limits().subgroupSize : 0;
    choices.planes = planes_;
    return choices;
}

void Canvas::prepare(FillChoices choices, uint32_t planes) {
    planes_ = withSum(planes);
    if (lightsInWindows()) return;  // several pipelines
    prepareFill(recorder_, onDevice(choices, false), prepared_.list.towardViewer != glm::vec3(0), {});
}

// True when only tiles without a list must be cleared. The fill writes every pixel of a tile with a list, so where one draw makes the
// picture the others are all that is left.
bool Canvas::clearsEmptyTiles() const { return inPlace_ && planes_ == 0; }

void Canvas::clearEmptyTiles(const Tiles& tiles) {
    const uint32_t background = prepared_.background & 0xffffffu, pitch = rowPixels();
    uint32_t* pixels = static_cast<uint32_t*>(colours_.data()) + firstColour_ * 4;
    const auto clear = [&](uint32_t row, uint32_t from, uint32_t to) {  // tiles of a tile row
        for (uint32_t y = row * gpu::kTileHeight; y < (row + 1) * gpu::kTileHeight; ++y)
            std::fill(pixels + size_t(y) * pitch + size_t(from) * gpu::kTileWidth,
                      pixels + size_t(y) * pitch + size_t(to) * gpu::kTileWidth, background);
    };
    const std::span<const glm::uvec4> records = tiles.records();
    auto next = records.begin();  // in the order of tiles
    for (uint32_t row = 0; row < tiles.down(); ++row) {
        uint32_t first = 0;
        for (; next != records.end() && next->x >> 16 == row; ++next) {
            const uint32_t column = next->x & 0xffffu;
            if (first < column) clear(row, first, column);
            first = column + 1;
        }
        if (first < tiles.across()) clear(row, first, tiles.across());
    }
}

void Canvas::fill(FillChoices choices, Geometry& geometry, const Tiles& tiles) {
    if (clearsEmptyTiles()) clearEmptyTiles(tiles);
    if (tiles.records().empty()) recorder_.skip("fill", "no triangle is drawn");
    choices = onDevice(choices, geometry.wide());
    // Slices of the longest list. A list too long for one invocation is drawn in slices over the planes, as chunks are.
    uint32_t slices = 1;
    for (const glm::uvec4& tile : tiles.records()) slices = std::max(slices, (tile.z + gpu::kTileListLimit - 1) / gpu::kTileListLimit);
    if (slices > 1 && !(choices.write & gpu::kFillPlaneZ)) throw TooLarge{"a tile's list needs slices"};
    // rate=1/2 needs final visibility: a later chunk or slice could cover the shaded pixel of a 2 x 2 square.
    if (choices.coarse && (choices.prior || slices > 1))
        throw renderError("rate=1/2 draws a picture in one piece only, and this one takes several chunks of triangles: leave it out");
    const size_t ones = size_t(std::count_if(tiles.records().begin(), tiles.records().end(), [](const glm::uvec4& t) { return t.z == 1; }));
    const bool apart = ones >= kOnesApart && 2 * ones >= tiles.records().size();
    for (uint32_t slice = 0; slice < slices; ++slice) {
        std::vector<glm::uvec4> several, alone;
        for (glm::uvec4 tile : tiles.records()) {
            const uint32_t skip = slice * gpu::kTileListLimit;
            if (tile.z <= skip) continue;
            const bool one = apart && tile.z == 1;
            tile.y += skip;
            tile.z = std::min(tile.z - skip, gpu::kTileListLimit);
            (one ? alone : several).push_back(tile);
        }
        put<glm::uvec4>(device_, tileBuffer_, several, "tile records");
        put<glm::uvec4>(device_, aloneBuffer_, alone, "tiles of one triangle");
        recordWindows(choices, geometry, tiles, several, alone);
        recorder_.run(watchdogMs_);
        choices.prior = true;
    }
}

gpu::FillPush Canvas::pushOf(const Geometry& geometry, const gpu::FrameBox& band) const {
    const DrawList& chunk = geometry.chunk();
    gpu::FillPush push{};
    push.firstRow = uint32_t(band.firstRow);
    push.rowQuads = rowQuads_;
    push.planeQuads = planeQuads_;
    push.background = prepared_.background & 0xffffffu;  // alpha 0: nothing drawn; the host makes it opaque
    push.firstTriangle = chunk.firstTriangle;
    push.near = chunk.viewport.near;
    push.rayOrigin = chunk.rayOrigin;
    push.rayX = chunk.rayX;
    push.rayY = chunk.rayY;
    push.backgroundLinear = prepared_.backgroundLinear;
    push.toward = chunk.towardViewer;
    push.frameEnd = {band.width, band.firstRow + band.rows};
    return push;
}

// Light windows before the last write the colour sum but not z. A stored z would win ties against the same triangles in the next window.
void Canvas::recordWindows(const FillChoices& choices, Geometry& geometry, const Tiles& tiles, std::span<const glm::uvec4> several,
                           std::span<const glm::uvec4> alone) {
    const bool lit = choices.shading == gpu::kShadingPhong && (choices.parts.diffuse || choices.parts.specular);
    const std::vector<gpu::LightRecord>& lights = geometry.chunk().lights;
    const uint32_t lightCount = lit ? uint32_t(lights.size()) : 0;
    gpu::FillPush push = pushOf(geometry, tiles.band());
    do {
        push.lightCount = std::min(lightCount - push.firstLight, lightsPerWindow(choices));
        FillChoices window = choices;
        if (choices.vectors != gpu::kVectorsPixel) {
            window.lightCount = push.lightCount;
            window.lightKinds = kindsOf(std::span(lights).subspan(push.firstLight, push.lightCount));
        }
        if (push.firstLight + push.lightCount < lightCount) {
            window.write = gpu::kFillPlaneSum;
            window.colour = false;
        }
        recordTiles(geometry, tiles, several, tileBuffer_, push, window);
        window.one = true;
        recordTiles(geometry, tiles, alone, aloneBuffer_, push, window);
        push.firstLight += push.lightCount;
    } while (push.firstLight < lightCount);
}

// Records tiles in dispatches that are neither long nor too many.
void Canvas::recordTiles(Geometry& geometry, const Tiles& binned, std::span<const glm::uvec4> tiles, const Buffer<glm::uvec4>& buffer,
                         gpu::FillPush push, const FillChoices& choices) {
    const FillBuffers buffers{geometry.draws(),
                              geometry.screen(),
                              choices.shading == gpu::kShadingFlat ? geometry.faceColours() : geometry.attributes(),
                              buffer,
                              binned.entries(),
                              geometry.triangleMaterials(),
                              geometry.materials(),
                              geometry.lights(),
                              encodeTable_,
                              colours_,
                              planeBuffer_,
                              geometry.triangleCentres(),
                              firstColour_,
                              planeQuads_};
    const uint64_t perTile = kWorkPerTile * (1 + push.lightCount);
    uint32_t first = 0;
    uint64_t work = 0;
    for (uint32_t t = 0; t < tiles.size(); ++t) {
        work += tiles[t].z + perTile;
        // Tile offsets of a dispatch must meet minTexelBufferOffsetAlignment: 16 records are 256 bytes.
        if (t + 1 < tiles.size() && (work < kWorkPerDispatch || (t + 1) % 16)) continue;
        push.tileCount = t + 1 - first;
        recordFill(recorder_, push, choices, {}, buffers, first);
        first = t + 1;
        work = 0;
    }
}

void Canvas::resolve(const gpu::FrameBox& band, uint32_t encoding, bool transparent, bool linearOut) {
    const uint32_t side = prepared_.side;
    const uint32_t rows = resolvedRows_ = uint32_t(band.rows) / side;
    resolvedQuads_ = (prepared_.width + 3) / 4;
    const uint64_t quads = uint64_t(resolvedQuads_) * rows;
    resolved_.reserve(device_, quads, "pixels");
    resolvedLinear_.reserve(device_, linearOut ? quads * 3 : 1, "linear pixels");
    gpu::ResolvePush push{};
    push.pixelQuads = uint32_t(quads);
    push.rowQuads = resolvedQuads_;
    push.sampleRowQuads = rowQuads_;
    push.samplePlaneQuads = planeQuads_;
    push.zSlot = 0;
    push.linearSlot = planes_ & gpu::kFillPlaneTriangle ? 2 : 1;
    push.side = push.stride = side;
    push.transparent = transparent;
    recordResolve(recorder_, push, encoding, linearOut, {}, planeBuffer_, encodeTable_, resolved_, resolvedLinear_);
    recorder_.run(watchdogMs_);
}

std::span<const uint32_t> Canvas::colourWords() const {
    return {static_cast<const uint32_t*>(colours_.data()), size_t(inPlace_ ? firstColour_ + planeQuads_ : planeQuads_) * 4};
}
std::span<const uint32_t> Canvas::plane(uint32_t slot) const {
    return {static_cast<const uint32_t*>(planeBuffer_.data()) + size_t(slot) * planeQuads_ * 4, size_t(planeQuads_) * 4};
}
std::span<const uint32_t> Canvas::resolvedColours() const {
    return {static_cast<const uint32_t*>(resolved_.data()), size_t(resolved_.count()) * 4};
}
std::span<const uint32_t> Canvas::resolvedLinear(uint32_t channel) const {
    const size_t quads = size_t(resolvedQuads_) * resolvedRows_;
    return {static_cast<const uint32_t*>(resolvedLinear_.data()) + channel * quads * 4, quads * 4};
}

}  // namespace plumb
