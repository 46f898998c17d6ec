// SPDX-License-Identifier: MIT
#include "pipeline/render/gpu_frame.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/transform.h"

#include <algorithm>
#include <fmt/core.h>
#include <utility>

namespace plumb {

namespace {

// Room for clipped corners at first; more is made when more is needed.
constexpr uint64_t kClipCornersAtFirst = 4096;
// Tile-list entries and shaded tiles of one dispatch: about 20 ns and 2 us each on two cores, so well below 100 ms.
constexpr uint64_t kWorkPerDispatch = uint64_t(1) << 21;
constexpr uint64_t kWorkPerTile = 100;
constexpr size_t kFewLarge = 256;  // triangles: sorting fewer gains nothing

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
    exact_[0] = device.selfTest().nativeDivideIsExact;
    exact_[1] = device.selfTest().nativeRootIsExact;
    put<uint32_t>(device, encodeTable_, srgbBucketTable(), "encode table");
}

uint64_t GpuFrame::chunkTriangles() const {
    const DeviceLimits& l = device_.limits();
    // Three vertices a triangle at worst, 16 bytes each in the screen and carried buffers; the rest is left for clipped corners and growth.
    const uint64_t vertices = std::min(l.storageRangeBytes / 16, l.texelElements);
    const uint64_t byRange = vertices / 5;
    const uint64_t byBudget = device_.memoryBudgetBytes() / 2 / 400;  // 400 bytes a triangle with three vertices of its own
    return std::max<uint64_t>(1, std::min(byRange, byBudget));
}

bool GpuFrame::fitsWhole(uint32_t planes) const {
    const DeviceLimits& l = device_.limits();
    const DrawList& list = prepared_.list;
    const uint64_t vertices = list.positions.size() + kClipCornersAtFirst, triangles = list.triangles.size(), faces = list.facePositions.size();
    const auto reserved = [](uint64_t count) { return count + count / 4 + 16; };  // as Buffer::reserve does
    if (reserved(vertices) > std::min(l.storageRangeBytes / sizeof(glm::vec4), l.texelElements)) return false;
    if (reserved(std::max(triangles, faces)) > l.texelElements) return false;
    // Bytes of upload() and of the lists, were every triangle drawn and in two tiles; then what a band's buffers may take.
    const uint64_t perVertex = (list.numbers == Numbers::fp32 ? 4 : 5) * sizeof(glm::vec4) + sizeof(uint32_t);
    const uint64_t perTriangle = (list.facePlaces.empty() ? 0 : sizeof(glm::vec4)) + sizeof(glm::uvec4) + sizeof(gpu::DrawTriangle) + sizeof(glm::uvec4) + 4 * sizeof(uint32_t);
    const uint64_t perFace = 3 * sizeof(glm::vec4) + sizeof(uint32_t);
    const uint64_t geometry = reserved(vertices) * perVertex + reserved(triangles) * perTriangle + reserved(faces) * perFace;
    const uint64_t pixels = (uint64_t(list.frame.width) + 15) / 16 * 16 * ((uint64_t(list.frame.height) + 7) / 8 * 8);
    const uint64_t held = reserved(pixels) * sizeof(uint32_t) * (1 + planeCount(withSum(planes)));
    const uint64_t budget = device_.memoryBudgetBytes() / 16 * 15;
    return geometry <= budget && std::min(held, device_.memoryBudgetBytes() / 2) <= budget - geometry;
}

bool GpuFrame::lightsInWindows() const {
    return prepared_.choices.shading == gpu::kShadingPhong && prepared_.list.lights.size() > lightsPerWindow(prepared_.choices);
}

uint32_t GpuFrame::withSum(uint32_t planes) const {
    return planes | (lightsInWindows() ? gpu::kFillPlaneSum : 0u);
}

uint32_t GpuFrame::bandRows(uint32_t planes) const {
    planes = withSum(planes);
    const DeviceLimits& l = device_.limits();
    const uint64_t pitch = (uint64_t(prepared_.list.frame.width) + 15) / 16 * 16;
    // reserve() takes a quarter more and 16 elements of four words.
    const uint64_t words = (std::min({l.storageRangeBytes / 4, l.texelElements, device_.memoryBudgetBytes() / 4 / 4}) - 64) / 5 * 4;
    const uint64_t rows = words / (pitch * std::max(1u, planeCount(planes))) / 8 * 8;
    return uint32_t(std::clamp<uint64_t>(rows, 8, uint64_t(1) << 19));
}

uint32_t GpuFrame::bandRowsInPlace() const {
    const DeviceLimits& l = device_.limits();
    const uint64_t pitch = (uint64_t(prepared_.list.frame.width) + 15) / 16 * 16, rows = (uint64_t(prepared_.list.frame.height) + 7) / 8 * 8;
    const uint64_t bytes = pitch * rows * sizeof(uint32_t);
    if (bytes + bytes / 4 > std::min(l.allocationBytes, device_.memoryBudgetBytes() / 2)) return 0;
    return uint32_t(std::min(rows, l.storageRangeBytes / sizeof(uint32_t) / pitch / 8 * 8));
}

void GpuFrame::checkFits(const char* what, uint64_t count, uint64_t elementBytes) const {
    const DeviceLimits& l = device_.limits();
    // reserve() takes a quarter more.
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
    if (prepared_.choices.shading == gpu::kShadingGouraud) put<uint32_t>(device_, vertexMaterial_, chunk.vertexMaterial, "vertex materials");
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
    // World normals do not depend on the camera: they stay from picture to picture of one upload.
    const bool carryNormals = choices.shading == gpu::kShadingPhong || normals;
    const bool writeNormals = carryNormals && !carriedNormals_;
    for (const DrawList::Range& r : chunk_->ranges) {
        if (r.vertexCount == 0) continue;
        const gpu::TransformPush push{0, r.firstVertex, r.vertexCount, r.record, chunk_->viewport};
        const Normals carry = writeNormals ? normalsCarried(choices, normals) : Normals::none;
        if (chunk_->numbers == Numbers::fp32)
            recordTransform(recorder_, push, carry, exact_, positions_, normals_, objects_, screen_, carried_);
        else
            recordLongTransform(recorder_, device_, push, carry, exact_, positions_, normals_, objects_, screen_, carried_, {chunk_->numbers, longs_, clipSpace_});
        const uint32_t lightCount = uint32_t(chunk_->lights.size());
        if (gouraud)
            recordIlluminate(recorder_, {0, r.firstVertex, r.vertexCount, r.record, 0, lightCount, chunk_->towardViewer}, choices.parts, exact_, positions_,
                             normals_, vertexMaterial_, objects_, materials_, lights_, carried_);
        if (choices.shading == gpu::kShadingFlat && !normals && r.faceCount)
            recordIlluminate(recorder_, {0, r.firstFace, r.faceCount, r.record, 0, lightCount, chunk_->towardViewer}, choices.parts, exact_, facePositions_,
                             faceNormals_, faceMaterial_, objects_, materials_, lights_, faceColours_);
    }
    recordCull(recorder_, {0, uint32_t(chunk_->triangles.size()), chunk_->cullBackFaces, chunk_->frame}, exact_, triangles_, screen_,
               records_);
    carriedNormals_ = false;
    recorder_.run(watchdogMs_);
    carriedNormals_ = carryNormals;
}

void GpuFrame::setup() {
    const uint64_t lanes = (chunk_->triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane;
    places_ = placeDraws(records_.span().first(lanes), *chunk_, uint32_t(chunk_->positions.size()));
    const uint64_t corners = chunk_->positions.size() + places_.clippedVertices;
    checkFits("drawn triangles", places_.drawCount, sizeof(gpu::DrawTriangle));
    checkFits("vertices", corners, sizeof(glm::vec4));
    if (corners > screen_.count()) {  // more clipped triangles than usual: keep what the transform left
        const std::vector<gpu::ScreenVertex> screen(screen_.span().begin(), screen_.span().end());
        const std::vector<glm::vec4> carried(carried_.span().begin(), carried_.span().end());
        screen_.reserve(device_, corners, "screen vertices");
        carried_.reserve(device_, corners, "carried values");
        screen_.upload(screen);
        carried_.upload(carried);
    }
    draws_.reserve(device_, places_.drawCount, "draw list");
    put<uint32_t>(device_, lanePlaces_, places_.places, "places");
    const uint32_t tiles = tilesX_ * tilesY_;
    counted_ = band_.firstRow == 0 && band_.rows == chunk_->frame.height && band_.width == chunk_->frame.width && tiles <= gpu::kSlotTiles;
    tiles_.reserve(device_, std::max(1u, 2 * tiles), "tiles");
    slots_.reserve(device_, counted_ ? places_.drawCount : 1, "slots");
    if (counted_) std::fill_n(tiles_.span().begin(), tiles, 0u);
    recordSetup(recorder_, {0, uint32_t(lanes), counted_ ? tilesX_ : 0, chunk_->frame}, chunk_->cullBackFaces == 0, exact_, triangles_, screen_,
                records_, lanePlaces_, draws_, tiles_, slots_);
    wide_ = places_.wide;
    clippedDrawn_ = 0;
    if (!places_.jobs.empty()) {
        put<gpu::ClipJob>(device_, jobs_, places_.jobs, "clip jobs");
        kinds_.reserve(device_, places_.jobs.size(), "clip kinds");
        recordClip(recorder_, {0, uint32_t(places_.jobs.size()), chunk_->cullBackFaces, chunk_->frame, chunk_->viewport}, exact_,
                   triangles_, positions_, objects_, jobs_, screen_, carried_, draws_, kinds_, chunk_->numbers == Numbers::fp32 ? nullptr : &clipSpace_);
    }
    recorder_.run(watchdogMs_);
    for (size_t j = 0; j < places_.jobs.size(); ++j) {
        wide_ |= kinds_.span()[j] & 1;
        clippedDrawn_ += kinds_.span()[j] >> 1;
        for (uint32_t i = 0; i < gpu::kClipFan; ++i) {
            places_.large.push_back(places_.jobs[j].place + i);
            if (counted_) slots_.span()[places_.jobs[j].place + i] = glm::uvec4(gpu::kNoSlot);
        }
    }
    sortLarge();
}

// Large triangles are binned row by row. Where they are many, most of them are low, and need not be asked about every row of the band.
void GpuFrame::sortLarge() {
    low_ = 0;
    if (places_.large.size() < kFewLarge) return;
    const std::span<const gpu::DrawTriangle> draws = draws_.span();
    const std::span<const gpu::ScreenVertex> screen = screen_.span();
    const auto isLow = [&](uint32_t place) {
        const gpu::DrawTriangle& d = draws[place];
        const auto [low, high] = std::minmax({screen[d.vertex[0]].y, screen[d.vertex[1]].y, screen[d.vertex[2]].y});
        return (int64_t(high) - low) / (gpu::kSubpixels * gpu::kTileHeight) + 2 <= kLowRows;
    };
    low_ = uint32_t(std::stable_partition(places_.large.begin(), places_.large.end(), isLow) - places_.large.begin());
}

void GpuFrame::beginBand(const gpu::FrameBox& band, uint32_t planes) {
    band_ = band;
    planes_ = planes = withSum(planes);
    counted_ = false;
    tilesX_ = uint32_t(band.width + gpu::kTileWidth - 1) / gpu::kTileWidth;
    tilesY_ = uint32_t(band.rows + gpu::kTileHeight - 1) / gpu::kTileHeight;
    rowQuads_ = tilesX_ * gpu::kTileWidth / 4;
    planeQuads_ = rowQuads_ * tilesY_ * gpu::kTileHeight;
    // In place, the bands of a picture lie one after another in one buffer.
    const uint64_t above = inPlace_ ? uint64_t(band.firstRow) * rowQuads_ : 0;
    const uint64_t rows = inPlace_ ? (uint64_t(prepared_.list.frame.height) + gpu::kTileHeight - 1) / gpu::kTileHeight * gpu::kTileHeight : 0;
    firstColour_ = above;
    colours_.reserve(device_, std::max<uint64_t>(planeQuads_, rows * rowQuads_), "colours");
    planeBuffer_.reserve(device_, std::max<uint64_t>(1, uint64_t(planeQuads_) * planeCount(planes)), "planes");
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
    push.ends = tilesX_ * tilesY_;
    push.firstClippedVertex = uint32_t(chunk_->positions.size());
    push.frame = band_;
    return push;
}

void GpuFrame::bin() {
    const uint32_t tiles = tilesX_ * tilesY_;
    tiles_.reserve(device_, 2 * uint64_t(tiles), "tiles");
    put<uint32_t>(device_, large_, places_.large, "large triangles");
    put<uint32_t>(device_, medium_, places_.medium, "medium triangles");
    entries_.reserve(device_, 1, "tile lists");
    // Slots are good for one band of one set-up, and numbers in them for as many triangles in a tile as 16 bits count.
    const auto isCrowded = [](uint32_t count) { return count > gpu::kSlotTiles; };
    const bool counted = std::exchange(counted_, false) && std::none_of(tiles_.span().begin(), tiles_.span().begin() + tiles, isCrowded);
    if (!counted) std::fill_n(tiles_.span().begin(), tiles, 0u);
    const BinBuffers buffers{draws_, screen_, large_, medium_, tiles_, entries_, slots_};
    const BinCounts counts{places_.drawCount, uint32_t(places_.medium.size()), uint32_t(places_.large.size()), low_, counted};
    recordBin(recorder_, BinStep::count, binPush(), counts, exact_, buffers);
    recorder_.run(watchdogMs_);
    tileCounts_.assign(tiles_.span().begin(), tiles_.span().begin() + tiles);
    tileRecords_.clear();
    uint64_t total = 0;
    for (uint32_t t = 0; t < tiles; ++t) {
        const uint32_t count = tileCounts_[t];
        if (count) tileRecords_.push_back({(t % tilesX_) | (t / tilesX_) << 16, uint32_t(total), count, 0});
        tiles_.span()[t] = uint32_t(total);
        total += count;
        tiles_.span()[tiles + t] = uint32_t(total);
    }
    binEntries_ = total;
    checkFits("tile-list entries", total, 4);
    if (total == 0) return;
    entries_.reserve(device_, total, "tile lists");
    recordBin(recorder_, BinStep::list, binPush(), counts, exact_, buffers);
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
    prepareFill(recorder_, onDevice(choices), prepared_.list.towardViewer != glm::vec3(0), exact_);
}

void GpuFrame::fill(FillChoices choices) {
    choices = onDevice(choices);
    const bool lit = choices.shading == gpu::kShadingPhong && (choices.parts.diffuse || choices.parts.specular);
    const uint32_t lightCount = lit ? uint32_t(chunk_->lights.size()) : 0;
    // A list too long for one invocation is drawn in slices over the planes, as chunks are.
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
    // The pixel that is shaded must be known when it is.
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
        // All windows but the last leave the sum only: z still is what the last one, too, shall find there.
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

// In dispatches that are neither long nor too many.
void GpuFrame::recordTiles(std::span<const glm::uvec4> tiles, const Buffer<glm::uvec4>& buffer, gpu::FillPush push, const FillChoices& choices) {
    const FillBuffers buffers{draws_,     screen_,  choices.shading == gpu::kShadingFlat ? faceColours_ : carried_, buffer, entries_,
                              triangleMaterial_, materials_, lights_, encodeTable_, colours_, planeBuffer_, trianglePlaces_, firstColour_, planeQuads_};
    const uint64_t perTile = kWorkPerTile * (1 + push.lightCount);
    uint32_t first = 0;
    uint64_t work = 0;
    for (uint32_t t = 0; t < tiles.size(); ++t) {
        work += tiles[t].z + perTile;
        // Tile offsets of a dispatch must meet minTexelBufferOffsetAlignment: 16 records are 256 bytes.
        if (t + 1 < tiles.size() && (work < kWorkPerDispatch || (t + 1) % 16)) continue;
        push.tileCount = t + 1 - first;
        recordFill(recorder_, push, choices, exact_, buffers, first);
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
    recordResolve(recorder_, push, encoding, linearOut, exact_, planeBuffer_, encodeTable_, resolved_, resolvedLinear_);
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
std::span<const float> GpuFrame::resolvedLinear(uint32_t channel) const {
    const size_t quads = size_t(resolvedQuads_) * size_t(band_.rows) / prepared_.side;
    return {static_cast<const float*>(resolvedLinear_.data()) + channel * quads * 4, quads * 4};
}

}  // namespace plumb
