// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/gpu_frame.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/tile_lists.h"
#include "pipeline/passes/transform.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Clipped corners for which there is memory at first; more is made when needed.
constexpr uint64_t kClipCornersAtFirst = 4096;
// Tile-list entries and shaded tiles of one dispatch: about 20 ns and 2 us each on two cores, so well below 100 ms.
constexpr uint64_t kWorkPerDispatch = uint64_t(1) << 21;
constexpr uint64_t kWorkPerTile = 100;
// Least number of medium triangles for a dispatch of their own: cutting fewer into strips on the host costs less.
constexpr size_t kFewMedium = 2048;
constexpr size_t kFewStrips = size_t(1) << 16;  // fit any device

template <class T>
void put(Device& device, Buffer<T>& buffer, std::span<const T> from, const char* name) {
    buffer.reserve(device, std::max<uint64_t>(from.size(), 1), name);
    buffer.upload(from);
}

uint32_t planeCount(uint32_t planes) {
    return (planes & gpu::kFillPlaneZ ? 1 : 0) + (planes & gpu::kFillPlaneTriangle ? 1 : 0) + (planes & gpu::kFillPlaneLinear ? 3 : 0) +
           (planes & gpu::kFillPlaneNormal ? 3 : 0) + (planes & gpu::kFillPlaneSum ? 3 : 0);
}

}  // namespace

GpuFrame::GpuFrame(Device& device, const Prepared& prepared, double watchdogMs)
    : device_(device), prepared_(prepared), recorder_(device), watchdogMs_(watchdogMs) {
    recorder_.allow(prepared.plan.labels(RunsOn::device));
    put<uint32_t>(device, encodeTable_, srgbBucketTable(), "encode table");
}

uint64_t GpuFrame::chunkTriangles() const {
    const DeviceLimits& l = device_.limits();
    // Vertices that fit: three a triangle at worst, 16 bytes each in the screen and attributes buffers. The rest is left for clipped
    // corners and growth.
    const uint64_t vertices = std::min(l.storageRangeBytes / 16, l.texelElements);
    const uint64_t byRange = vertices / 5;
    const uint64_t byBudget = device_.memoryBudgetBytes() / 2 / 400;  // 400 bytes a triangle with three vertices of its own
    return std::max<uint64_t>(1, std::min(byRange, byBudget));
}

bool GpuFrame::fitsWhole(uint32_t planes) const {
    const DeviceLimits& l = device_.limits();
    const DrawList& list = prepared_.list;
    const uint64_t vertices = list.positions.size() + kClipCornersAtFirst, triangles = list.triangles.size(),
                   faces = list.facePositions.size();
    const auto reserved = [](uint64_t count) { return count + count / 4 + 16; };  // as Buffer::reserve does
    if (reserved(vertices) > std::min(l.storageRangeBytes / sizeof(glm::vec4), l.texelElements)) return false;
    if (reserved(std::max(triangles, faces)) > l.texelElements) return false;
    // Bytes of upload() and of the lists, if every triangle were drawn and in two tiles; then the bytes of a band's buffers.
    const uint64_t perVertex = (list.numbers == Numbers::fp32 ? 4 : 5) * sizeof(glm::vec4) + sizeof(uint32_t);
    const uint64_t perTriangle =
        (list.facePlaces.empty() ? 0 : sizeof(glm::vec4)) + sizeof(glm::uvec4) + sizeof(gpu::DrawTriangle) + 3 * sizeof(uint32_t);
    const uint64_t perFace = 3 * sizeof(glm::vec4) + sizeof(uint32_t);
    const uint64_t pixels = (uint64_t(list.frame.width) + 15) / 16 * 16 * ((uint64_t(list.frame.height) + 7) / 8 * 8);
    const uint64_t tiles = pixels / (gpu::kTileWidth * gpu::kTileHeight), room = roomOfTiles(triangles, tiles, mostEntries());
    const uint64_t geometry = reserved(vertices) * perVertex + reserved(triangles) * perTriangle + reserved(faces) * perFace +
                              reserved(tiles * room) * sizeof(uint32_t);
    const uint64_t held = reserved(pixels) * sizeof(uint32_t) * (1 + planeCount(withSum(planes)));
    const uint64_t budget = device_.memoryBudgetBytes() / 16 * 15;
    return geometry <= budget && std::min(held, device_.memoryBudgetBytes() / 2) <= budget - geometry;
}

bool GpuFrame::lightsInWindows() const {
    return prepared_.choices.shading == gpu::kShadingPhong && prepared_.list.lights.size() > lightsPerWindow(prepared_.choices);
}

uint32_t GpuFrame::withSum(uint32_t planes) const { return planes | (lightsInWindows() ? gpu::kFillPlaneSum : 0u); }

uint32_t GpuFrame::bandRows(uint32_t planes) const {
    planes = withSum(planes);
    const DeviceLimits& l = device_.limits();
    const uint64_t pitch = (uint64_t(prepared_.list.frame.width) + 15) / 16 * 16;
    // Words that fit: reserve() takes a quarter more and 16 elements of four words.
    const uint64_t words = (std::min({l.storageRangeBytes / 4, l.texelElements, device_.memoryBudgetBytes() / 4 / 4}) - 64) / 5 * 4;
    const uint64_t rows = words / (pitch * std::max(1u, planeCount(planes))) / 8 * 8;
    return uint32_t(std::clamp<uint64_t>(rows, 8, uint64_t(1) << 19));
}

uint32_t GpuFrame::bandRowsInPlace() const {
    const DeviceLimits& l = device_.limits();
    const uint64_t pitch = (uint64_t(prepared_.list.frame.width) + 15) / 16 * 16,
                   rows = (uint64_t(prepared_.list.frame.height) + 7) / 8 * 8;
    const uint64_t bytes = pitch * rows * sizeof(uint32_t);
    if (bytes + bytes / 4 > std::min(l.allocationBytes, device_.memoryBudgetBytes() / 2)) return 0;
    return uint32_t(std::min(rows, l.storageRangeBytes / sizeof(uint32_t) / pitch / 8 * 8));
}

void GpuFrame::checkFits(const char* what, uint64_t count, uint64_t elementBytes) const {
    const DeviceLimits& l = device_.limits();
    // Size after reserve(), which takes a quarter more.
    if ((count + count / 4 + 16) * elementBytes > l.storageRangeBytes || count + count / 4 + 16 > l.texelElements)
        throw TooLarge{fmt::format("{} {} of {} bytes exceed a binding of the device", count, what, elementBytes)};
}

void GpuFrame::upload(const DrawList& chunk) {
    chunk_ = &chunk;
    carriedNormals_ = false;
    put<glm::vec4>(device_, positions_, chunk.positions, "positions");
    put<glm::vec4>(device_, normals_, chunk.normals, "normals");
    put<glm::uvec4>(device_, triangles_, chunk.triangles, "triangles");
    put<gpu::ObjectRecord>(device_, objects_, chunk.objects, "objects");
    if (chunk.numbers != Numbers::fp32) {
        put<gpu::LongRecord>(device_, longs_, chunk.longs, "long rows");
        clipSpace_.reserve(device_, std::max<uint64_t>(1, chunk.positions.size()), "clip space");
    }
    put<gpu::MaterialRecord>(device_, materials_, chunk.materials, "materials");
    put<gpu::LightRecord>(device_, lights_, chunk.lights, "lights");
    std::vector<uint32_t> materialOf(chunk.triangles.size());
    const bool flat = prepared_.choices.shading == gpu::kShadingFlat;
    for (size_t t = 0; t < materialOf.size(); ++t) materialOf[t] = flat ? chunk.triangleFace[t] : chunk.triangles[t].w;
    std::vector<glm::vec4> places(chunk.facePlaces.empty() ? 1 : chunk.triangles.size());
    if (!chunk.facePlaces.empty())
        for (size_t t = 0; t < places.size(); ++t) places[t] = chunk.facePlaces[chunk.triangleFace[t]];
    put<glm::vec4>(device_, trianglePlaces_, places, "places of faces");
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
    carried_.reserve(device_, corners, "carried values");
    records_.reserve(device_, (chunk.triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane, "cull records");
}

void GpuFrame::transformAndCull(bool normals) {
    const FillChoices& choices = prepared_.choices;
    const bool gouraud = choices.shading == gpu::kShadingGouraud && !normals;
    // World normals do not depend on the camera, so they stay from picture to picture of one upload.
    const bool carryNormals = choices.shading == gpu::kShadingPhong || normals;
    const bool writeNormals = carryNormals && !carriedNormals_;
    for (const DrawList::Range& r : chunk_->ranges) {
        if (r.vertexCount == 0) continue;
        const gpu::TransformPush push{0, r.firstVertex, r.vertexCount, r.record, chunk_->viewport};
        const Normals carry = writeNormals ? normalsCarried(choices, normals) : Normals::none;
        if (chunk_->numbers == Numbers::fp32)
            recordTransform(recorder_, push, carry, {}, positions_, normals_, objects_, screen_, carried_);
        else
            recordLongTransform(recorder_, device_, push, carry, {}, positions_, normals_, objects_, screen_, carried_,
                                {chunk_->numbers, longs_, clipSpace_});
        const uint32_t lightCount = uint32_t(chunk_->lights.size());
        if (gouraud)
            recordIlluminate(recorder_, {0, r.firstVertex, r.vertexCount, r.record, 0, lightCount, chunk_->towardViewer}, choices.parts, {},
                             positions_, normals_, vertexMaterial_, objects_, materials_, lights_, carried_);
        if (choices.shading == gpu::kShadingFlat && !normals && r.faceCount)
            recordIlluminate(recorder_, {0, r.firstFace, r.faceCount, r.record, 0, lightCount, chunk_->towardViewer}, choices.parts, {},
                             facePositions_, faceNormals_, faceMaterial_, objects_, materials_, lights_, faceColours_);
    }
    recordCull(recorder_, {0, uint32_t(chunk_->triangles.size()), chunk_->cullBackFaces, chunk_->frame}, {}, triangles_, screen_, records_);
    carriedNormals_ = false;
    recorder_.run(watchdogMs_);
    carriedNormals_ = carryNormals;
}

void GpuFrame::setupForBin() {
    const uint64_t lanes = (chunk_->triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane;
    places_ = placeDraws(records_.span().first(lanes), *chunk_, uint32_t(chunk_->positions.size()));
    const uint64_t corners = chunk_->positions.size() + places_.clippedVertices;
    checkFits("drawn triangles", places_.drawCount, sizeof(gpu::DrawTriangle));
    checkFits("vertices", corners, sizeof(glm::vec4));
    if (corners > screen_.count()) {  // more clipped triangles than usual: keep the transformed vertices
        const std::vector<gpu::ScreenVertex> screen(screen_.span().begin(), screen_.span().end());
        const std::vector<glm::vec4> carried(carried_.span().begin(), carried_.span().end());
        screen_.reserve(device_, corners, "screen vertices");
        carried_.reserve(device_, corners, "carried values");
        screen_.upload(screen);
        carried_.upload(carried);
    }
    draws_.reserve(device_, places_.drawCount, "draw list");
    sources_.reserve(device_, std::max(1u, places_.drawCount), "drawn triangles");
    listDrawn(std::as_const(records_).span().first(lanes), sources_.span().first(places_.drawCount));
    const uint32_t tiles = tilesX_ * tilesY_;
    binned_ = band_.firstRow == 0 && band_.rows == chunk_->frame.height && band_.width == chunk_->frame.width;
    setupOverflow_.reserve(device_, binned_ ? std::max(1u, places_.drawCount) : 1, "overflow bits of the set-up");
    tiles_.reserve(device_, std::max(1u, tiles), "tiles");
    entries_.reserve(device_, 1, "tile lists");
    if (binned_) makeRoom();
    recordSetup(recorder_, {0, places_.drawCount, binned_ ? tilesX_ : 0, room_, chunk_->frame}, chunk_->cullBackFaces == 0, {}, triangles_,
                screen_, sources_, draws_, tiles_, entries_, setupOverflow_);
    wide_ = places_.wide;
    clippedDrawn_ = 0;
    if (places_.jobs.empty()) return recorder_.skip("clip", "no triangle crosses the near plane or leaves the guard band");
    put<gpu::ClipJob>(device_, jobs_, places_.jobs, "clip jobs");
    kinds_.reserve(device_, places_.jobs.size(), "clip kinds");
    recordClip(recorder_, {0, uint32_t(places_.jobs.size()), chunk_->cullBackFaces, chunk_->frame, chunk_->viewport}, {}, triangles_,
               positions_, objects_, jobs_, screen_, carried_, draws_, kinds_, chunk_->numbers == Numbers::fp32 ? nullptr : &clipSpace_);
    recorder_.run(watchdogMs_);
    for (size_t j = 0; j < places_.jobs.size(); ++j) {
        wide_ |= kinds_.span()[j] & 1;
        clippedDrawn_ += kinds_.span()[j] >> 1;
    }
}

void GpuFrame::setup() {
    setupForBin();
    recorder_.run(watchdogMs_);
}

void GpuFrame::beginBand(const gpu::FrameBox& band, uint32_t planes) {
    band_ = band;
    planes_ = planes = withSum(planes);
    binned_ = false;
    tilesX_ = uint32_t(band.width + gpu::kTileWidth - 1) / gpu::kTileWidth;
    tilesY_ = uint32_t(band.rows + gpu::kTileHeight - 1) / gpu::kTileHeight;
    rowQuads_ = tilesX_ * gpu::kTileWidth / 4;
    planeQuads_ = rowQuads_ * tilesY_ * gpu::kTileHeight;
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

gpu::BinPush GpuFrame::binPush() const {
    gpu::BinPush push{};
    push.tilesX = tilesX_;
    push.tilesY = tilesY_;
    push.room = room_;
    push.firstClippedVertex = uint32_t(chunk_->positions.size());
    push.frame = band_;
    return push;
}

uint64_t GpuFrame::mostEntries() const {
    const DeviceLimits& l = device_.limits();
    return (std::min({l.storageRangeBytes / 4, l.texelElements, device_.memoryBudgetBytes() / 16 / 4}) - 64) / 5 * 4;
}

void GpuFrame::makeRoom() {
    const uint32_t tiles = tilesX_ * tilesY_;
    room_ = std::min(mostRoom_, roomOfTiles(places_.drawCount, tiles, mostEntries()));
    tiles_.reserve(device_, tiles, "tiles");
    entries_.reserve(device_, uint64_t(tiles) * room_, "tile lists");
    std::fill_n(tiles_.span().begin(), tiles, 0u);
}

// The host cuts boxes of large triangles into strips, one invocation each. On the device every large triangle would have to test every tile
// row.
void GpuFrame::makeStrips() {
    strips_.clear();
    const gpu::BinPush push = binPush();
    const std::span<const gpu::ScreenVertex> screen = std::as_const(screen_).span();
    const auto add = [&](uint32_t place, uint32_t a, uint32_t b, uint32_t c) {
        addStrips(push, place, boxInBand(push, screen[a], screen[b], screen[c]), strips_);
    };
    const auto addPlaced = [&](const PlacedTriangle& p) {
        const glm::uvec4& corners = chunk_->triangles[p.triangle];
        add(p.place, corners.x, corners.y, corners.z);
    };
    std::for_each(places_.large.begin(), places_.large.end(), addPlaced);
    if (binned_ && places_.medium.size() < kFewMedium) std::for_each(places_.medium.begin(), places_.medium.end(), addPlaced);
    for (const gpu::ClipJob& job : places_.jobs)
        for (uint32_t place = job.place; place < job.place + gpu::kClipFan; ++place) {
            const uint32_t* v = std::as_const(draws_).span()[place].vertex;
            if (v[0] != v[1]) add(place, v[0], v[1], v[2]);
        }
}

void GpuFrame::bin() {
    makeStrips();
    // Run the recorded commands first: the calls below may reallocate their buffers, or throw TooLarge and start over with a smaller chunk.
    if (!binned_ || strips_.size() > kFewStrips) recorder_.run(watchdogMs_);
    if (!binned_) makeRoom();
    const bool mediumWalk = binned_ && places_.medium.size() >= kFewMedium;
    const uint32_t walked = mediumWalk ? uint32_t(places_.medium.size()) : binned_ ? 0u : places_.drawCount;
    checkFits("strips of large triangles", strips_.size(), sizeof(glm::uvec4));
    put<PlacedTriangle>(device_, medium_, mediumWalk ? std::span<const PlacedTriangle>(places_.medium) : std::span<const PlacedTriangle>(),
                        "medium triangles");
    put<glm::uvec4>(device_, stripBuffer_, strips_, "strips");
    walkOverflow_.reserve(device_, std::max(1u, walked), "overflow bits of triangles");
    stripOverflow_.reserve(device_, std::max<uint64_t>(1, strips_.size()), "overflow bits of strips");
    recordBin(recorder_, binPush(), {walked, mediumWalk, uint32_t(strips_.size()), wide_}, {},
              {draws_, screen_, medium_, stripBuffer_, tiles_, entries_, walkOverflow_, stripOverflow_});
    recorder_.run(watchdogMs_);
    collectLists(walked, std::exchange(binned_, false));
}

void GpuFrame::collectLists(uint32_t walked, bool binned) {
    const std::span<const uint32_t> counts = std::as_const(tiles_).span();
    tileRecords_.clear();
    binEntries_ = 0;
    overflowed_ = 0;
    uint64_t end = uint64_t(tilesX_) * tilesY_ * room_;
    for (uint32_t y = 0, t = 0; y < tilesY_; ++y)
        for (uint32_t x = 0; x < tilesX_; ++x, ++t) {
            const uint32_t count = counts[t];
            if (count == 0) continue;
            const bool overflowed = count > room_;
            tileRecords_.emplace_back(x | y << 16, uint32_t(overflowed ? end : uint64_t(t) * room_), count, 0u);
            binEntries_ += count;
            overflowed_ += overflowed;
            end += overflowed ? count : 0;
        }
    if (overflowed_) listOverflowed(end, walked, binned);
}

void GpuFrame::listOverflowed(uint64_t end, uint32_t walked, bool binned) {
    if (end > entries_.count()) {
        // only when the buffer must grow: the 25 % that reserve() added may hold the list although checkFits() would refuse it
        checkFits("tile-list entries", end, 4);
        const std::vector<uint32_t> entries(entries_.span().begin(), entries_.span().end());
        entries_.reserve(device_, end, "tile lists");
        entries_.upload(entries);
    }
    const auto tileOf = [&](const glm::uvec4& record) { return (record.x >> 16) * tilesX_ + (record.x & 0xffffu); };
    OverflowedTiles overflowed(binPush(), entries_.span().first(end));
    for (const glm::uvec4& record : tileRecords_)
        if (record.z > room_) overflowed.move(tileOf(record), record.y);
    const std::span<const gpu::DrawTriangle> draws = std::as_const(draws_).span();
    const std::span<const gpu::ScreenVertex> screen = std::as_const(screen_).span();
    if (binned) overflowed.addSetUp(std::as_const(setupOverflow_).span().first(places_.drawCount), draws, screen);
    const bool listed = binned && walked != 0;
    overflowed.addWalked(std::as_const(walkOverflow_).span().first(walked),
                         listed ? std::span<const PlacedTriangle>(places_.medium) : std::span<const PlacedTriangle>(), draws, screen);
    overflowed.addStrips(std::as_const(stripOverflow_).span().first(strips_.size()), strips_);
    for (const glm::uvec4& record : tileRecords_)
        if (record.z > room_ && overflowed.endOf(tileOf(record)) != record.y + record.z)
            throw renderError("bin: an overflowed tile's list is not complete");
}

TileLists GpuFrame::lists() const {
    TileLists lists;
    lists.counts.assign(size_t(tilesX_) * tilesY_, 0);
    for (const glm::uvec4& record : tileRecords_) {
        lists.counts[(record.x >> 16) * tilesX_ + (record.x & 0xffffu)] = record.z;
        const auto first = entries_.span().begin() + ptrdiff_t(record.y);
        lists.entries.insert(lists.entries.end(), first, first + ptrdiff_t(record.z));
        std::sort(lists.entries.end() - ptrdiff_t(record.z), lists.entries.end());
    }
    return lists;
}

FillChoices GpuFrame::onDevice(FillChoices choices) const {
    choices.wide = wide_;
    choices.subgroupSize = device_.limits().subgroupShuffle ? device_.limits().subgroupSize : 0;
    choices.planes = planes_;
    return choices;
}

void GpuFrame::prepare(FillChoices choices, uint32_t planes) {
    planes_ = withSum(planes);
    if (lightsInWindows()) return;  // several pipelines
    prepareFill(recorder_, onDevice(choices), prepared_.list.towardViewer != glm::vec3(0), {});
}

// True when only tiles without a list must be cleared. The fill writes every pixel of a tile with a list, so where one draw makes the
// picture the others are all that is left.
bool GpuFrame::clearsEmptyTiles() const { return inPlace_ && planes_ == 0; }

void GpuFrame::clearEmptyTiles() {
    const uint32_t background = prepared_.background & 0xffffffu, pitch = rowPixels();
    uint32_t* pixels = static_cast<uint32_t*>(colours_.data()) + firstColour_ * 4;
    const auto clear = [&](uint32_t row, uint32_t from, uint32_t to) {  // tiles of a tile row
        for (uint32_t y = row * gpu::kTileHeight; y < (row + 1) * gpu::kTileHeight; ++y)
            std::fill(pixels + size_t(y) * pitch + size_t(from) * gpu::kTileWidth,
                      pixels + size_t(y) * pitch + size_t(to) * gpu::kTileWidth, background);
    };
    auto next = tileRecords_.begin();  // in the order of tiles
    for (uint32_t row = 0; row < tilesY_; ++row) {
        uint32_t first = 0;
        for (; next != tileRecords_.end() && next->x >> 16 == row; ++next) {
            const uint32_t column = next->x & 0xffffu;
            if (first < column) clear(row, first, column);
            first = column + 1;
        }
        if (first < tilesX_) clear(row, first, tilesX_);
    }
}

void GpuFrame::fill(FillChoices choices) {
    if (clearsEmptyTiles()) clearEmptyTiles();
    if (tileRecords_.empty()) recorder_.skip("fill", "no triangle is drawn");
    choices = onDevice(choices);
    const bool lit = choices.shading == gpu::kShadingPhong && (choices.parts.diffuse || choices.parts.specular);
    const uint32_t lightCount = lit ? uint32_t(chunk_->lights.size()) : 0;
    // Slices of the longest list. A list too long for one invocation is drawn in slices over the planes, as chunks are.
    uint32_t slices = 1;
    for (const glm::uvec4& tile : tileRecords_) slices = std::max(slices, (tile.z + gpu::kTileListLimit - 1) / gpu::kTileListLimit);
    if (slices > 1 && !(choices.write & gpu::kFillPlaneZ)) throw TooLarge{"a tile's list needs slices"};
    gpu::FillPush push{};
    push.firstRow = uint32_t(band_.firstRow);
    push.rowQuads = rowQuads_;
    push.planeQuads = planeQuads_;
    push.background = prepared_.background & 0xffffffu;  // alpha 0: nothing drawn; the host makes it opaque
    push.firstTriangle = chunk_->firstTriangle;
    push.near = chunk_->viewport.near;
    push.rayOrigin = chunk_->rayOrigin;
    push.rayX = chunk_->rayX;
    push.rayY = chunk_->rayY;
    push.backgroundLinear = prepared_.backgroundLinear;
    push.toward = chunk_->towardViewer;
    push.frameEnd = {band_.width, band_.firstRow + band_.rows};
    // rate=1/2 needs final visibility: a later chunk or slice could cover the shaded pixel of a 2 x 2 square.
    if (choices.coarse && (choices.prior || slices > 1))
        throw renderError("rate=1/2 draws a picture in one piece only, and this one takes several chunks of triangles: leave it out");
    // Tiles with one triangle have a kernel of their own, without loops. It is worth compiling where it has much to do.
    const size_t ones = size_t(std::count_if(tileRecords_.begin(), tileRecords_.end(), [](const glm::uvec4& tile) { return tile.z == 1; }));
    const bool apart = ones >= kOnesApart && 2 * ones >= tileRecords_.size();
    for (uint32_t slice = 0; slice < slices; ++slice) {
        std::vector<glm::uvec4> tiles, alone;
        for (glm::uvec4 tile : tileRecords_) {
            const uint32_t skip = slice * gpu::kTileListLimit;
            if (tile.z <= skip) continue;
            const bool one = apart && tile.z == 1;
            tile.y += skip;
            tile.z = std::min(tile.z - skip, gpu::kTileListLimit);
            (one ? alone : tiles).push_back(tile);
        }
        put<glm::uvec4>(device_, tileBuffer_, tiles, "tile records");
        put<glm::uvec4>(device_, aloneBuffer_, alone, "tiles of one triangle");
        // Light windows before the last write the colour sum but not z: triangles tied with a z already stored would lose in the next
        // window.
        push.firstLight = 0;
        do {
            push.lightCount = std::min(lightCount - push.firstLight, lightsPerWindow(choices));
            FillChoices window = choices;
            if (choices.vectors != gpu::kVectorsPixel) {
                window.lightCount = push.lightCount;
                window.lightKinds = kindsOf(std::span(chunk_->lights).subspan(push.firstLight, push.lightCount));
            }
            if (push.firstLight + push.lightCount < lightCount) {
                window.write = gpu::kFillPlaneSum;
                window.colour = false;
            }
            recordTiles(tiles, tileBuffer_, push, window);
            window.one = true;
            recordTiles(alone, aloneBuffer_, push, window);
            push.firstLight += push.lightCount;
        } while (push.firstLight < lightCount);
        recorder_.run(watchdogMs_);
        choices.prior = true;
    }
}

// Records tiles in dispatches that are neither long nor too many.
void GpuFrame::recordTiles(std::span<const glm::uvec4> tiles, const Buffer<glm::uvec4>& buffer, gpu::FillPush push,
                           const FillChoices& choices) {
    const FillBuffers buffers{draws_,       screen_,      choices.shading == gpu::kShadingFlat ? faceColours_ : carried_,
                              buffer,       entries_,     triangleMaterial_,
                              materials_,   lights_,      encodeTable_,
                              colours_,     planeBuffer_, trianglePlaces_,
                              firstColour_, planeQuads_};
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

void GpuFrame::resolve(uint32_t encoding, bool transparent, bool linearOut) {
    const uint32_t side = prepared_.side;
    const uint32_t rows = uint32_t(band_.rows) / side;
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

std::span<const uint32_t> GpuFrame::colourWords() const {
    return {static_cast<const uint32_t*>(colours_.data()), size_t(inPlace_ ? firstColour_ + planeQuads_ : planeQuads_) * 4};
}
std::span<const uint32_t> GpuFrame::plane(uint32_t slot) const {
    return {static_cast<const uint32_t*>(planeBuffer_.data()) + size_t(slot) * planeQuads_ * 4, size_t(planeQuads_) * 4};
}
std::span<const uint32_t> GpuFrame::resolvedColours() const {
    return {static_cast<const uint32_t*>(resolved_.data()), size_t(resolved_.count()) * 4};
}
std::span<const uint32_t> GpuFrame::resolvedLinear(uint32_t channel) const {
    const size_t quads = size_t(resolvedQuads_) * size_t(band_.rows) / prepared_.side;
    return {static_cast<const uint32_t*>(resolvedLinear_.data()) + channel * quads * 4, quads * 4};
}

}  // namespace plumb
