// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/device_render.h"

#include "pipeline/render/raster/triangle_seen.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>

namespace plumb {

namespace {

void addCounts(const GpuFrame& frame, RenderCounters& c) {
    c.culledBackFace += frame.slots().backFacing;
    c.culledZeroArea += frame.slots().zeroArea;
    c.culledOutside += frame.slots().outside;
    c.clipped += frame.slots().jobs.size();
    c.drawnTriangles += frame.slots().drawn + frame.clippedDrawn();
}

// What the kernel must leave for the planes that were asked for, and for resolving.
uint32_t fillPlanes(const Prepared& p, const RenderRequest& request) {
    uint32_t planes = 0;
    if (request.planes & kPlanesSeen) planes |= gpu::kFillPlaneZ | gpu::kFillPlaneTriangle;
    if (request.planes & kPlaneLinear) planes |= gpu::kFillPlaneLinear | gpu::kFillPlaneZ;
    if (request.planes & kPlaneNormal) planes |= gpu::kFillPlaneNormal;
    if (p.side > 1) planes |= gpu::kFillPlaneZ | gpu::kFillPlaneLinear;
    return planes;
}

}  // namespace

DeviceRender::DeviceRender(Device& device, const Prepared& prepared, const RenderRequest& request)
    : request_(request), p_(prepared), frame_(device, prepared, request.watchdogMs), counters_(prepared.counters) {
    listen();
}

// An interrupt is heard and the watchdog wound up again after some seconds at most, however many lights or layers there are.
void DeviceRender::listen() {
    constexpr uint32_t kCommands = 64;
    frame_.recorder().runEvery(kCommands, request_.watchdogMs, [this] {
        if (request_.onProgress && !request_.onProgress(done_)) throw Error(Exit::interrupted, "interrupted");
    });
}

bool DeviceRender::draw() {
    const DrawList& list = p_.list;
    const int height = list.frame.height;
    int bandRows = int(frame_.bandRowsInPlace());
    if (request_.knobs.bandRows) bandRows = std::min(bandRows, int((request_.knobs.bandRows + 7) / 8 * 8));
    if (bandRows == 0 || list.triangles.size() > chunkTriangles(0)) return false;
    counters_ = p_.counters;
    counters_.chunks = 1;
    frame_.keepBands();
    try {
        gpu::FrameBox band = list.frame;
        for (band.firstRow = 0; band.firstRow < height; band.firstRow += bandRows) {
            band.rows = std::min(bandRows, height - band.firstRow);
            frame_.beginBand(band, 0);
            if (!uploaded_) frame_.upload(list);
            uploaded_ = true;
            if (band.firstRow == 0) {
                frame_.transformAndCull(false);
                frame_.setupForBin();
                addCounts(frame_, counters_);
            }
            drawColours(0, false);
            counters_.binEntries += frame_.binEntries();
            ++counters_.bands;
        }
    } catch (const TooLarge&) {
        return false;
    }
    return true;
}

bool DeviceRender::drawPlanes(Frame& out) {
    const uint32_t planes = fillPlanes(p_, request_);
    const size_t triangles = p_.list.triangles.size();
    if (triangles > chunkTriangles(planes)) return false;
    counters_ = p_.counters;
    PlaneWriter writer(p_, request_, out);
    try {
        drawBands(writer, out, planes, uint32_t(triangles));
    } catch (const TooLarge&) {
        return false;
    }
    return true;
}

uint64_t DeviceRender::chunkTriangles(uint32_t planes) const {
    const uint64_t most = frame_.fitsWhole(planes) ? std::max<uint64_t>(1, p_.list.triangles.size()) : frame_.chunkTriangles();
    return request_.knobs.chunkTriangles ? std::min<uint64_t>(most, request_.knobs.chunkTriangles) : most;
}

ResidentScene::Picture DeviceRender::pixels() const { return {frame_.colourWords().data(), p_.width, p_.height, frame_.rowPixels()}; }

void DeviceRender::draw(PlaneWriter& writer, RenderResult& result) {
    const DrawList& list = p_.list;
    uint32_t planes = fillPlanes(p_, request_);
    uint64_t chunk = std::max<uint64_t>(1, std::min<uint64_t>(chunkTriangles(planes), list.triangles.size()));
    if (!list.triangles.empty()) {
        const uint32_t held = chunk < list.triangles.size() ? planes | gpu::kFillPlaneZ : planes;
        frame_.prepare(colourChoices(held, false), held);
    }
    while (!list.triangles.empty()) {
        try {
            drawBands(writer, result.frame, planes, uint32_t(chunk));
            break;
        } catch (const TooLarge& reason) {
            // Several chunks need z between them; halving always ends: one triangle's lists fit any device.
            if (planes & gpu::kFillPlaneZ) {
                if (chunk == 1) throw renderError(reason.what);
                chunk = (chunk + 1) / 2;
            }
            planes |= gpu::kFillPlaneZ;
            counters_ = p_.counters;
            writer.restart();
        }
    }
    result.counters = counters_;
    result.times = frame_.recorder().takeTimes();
    for (const auto& [step, why] : frame_.recorder().takeSkipped()) result.plan.skip(step, why);
}

void DeviceRender::drawBands(PlaneWriter& writer, Frame& out, uint32_t planes, uint32_t chunkSize) {
    const DrawList& list = p_.list;
    const uint32_t height = uint32_t(list.frame.height);
    const uint32_t chunks = uint32_t((list.triangles.size() + chunkSize - 1) / chunkSize);
    if (chunks > 1) planes |= gpu::kFillPlaneZ;
    uint32_t bandRows = frame_.bandRows(planes);
    if (request_.knobs.bandRows) bandRows = std::min(bandRows, (request_.knobs.bandRows * p_.side + 7) / 8 * 8);
    DrawList part;
    for (uint32_t firstRow = 0; firstRow < height; firstRow += bandRows) {
        gpu::FrameBox band = list.frame;
        band.firstRow = int(firstRow);
        band.rows = int(std::min(bandRows, height - firstRow));
        frame_.beginBand(band, planes);
        for (uint32_t c = 0; c < chunks; ++c) {
            done_ = (double(firstRow) + double(band.rows) * c / chunks) / height;
            if (request_.onProgress && !request_.onProgress(done_)) throw Error(Exit::interrupted, "interrupted");
            if (chunks > 1)
                part = chunkOf(list, c * chunkSize, std::min<uint32_t>(chunkSize, uint32_t(list.triangles.size()) - c * chunkSize));
            if (chunks > 1 || !uploaded_) frame_.upload(chunks > 1 ? part : list);
            uploaded_ = chunks == 1;
            if (normalsApart(planes)) drawNormals(planes, c > 0);
            if (chunks > 1 || firstRow == 0 || normalsApart(planes)) {
                frame_.transformAndCull(false);
                frame_.setupForBin();
                if (firstRow == 0) addCounts(frame_, counters_);
            }
            drawColours(planes, c > 0);
            counters_.binEntries += frame_.binEntries();
        }
        if (p_.side > 1) frame_.resolve(p_.choices.encoding, request_.transparent, request_.planes & kPlaneLinear);
        readBand(writer, out, band, planes);
        ++counters_.bands;
    }
    counters_.chunks = chunks;
    if (p_.choices.shading == gpu::kShadingFlat) counters_.illuminations = list.facePositions.size();
    if (p_.choices.shading == gpu::kShadingGouraud) counters_.illuminations = list.positions.size();
}

bool DeviceRender::normalsApart(uint32_t planes) const {
    return (planes & gpu::kFillPlaneNormal) && p_.choices.shading != gpu::kShadingPhong;
}

FillChoices DeviceRender::colourChoices(uint32_t planes, bool prior) const {
    FillChoices choices = p_.choices;
    choices.write = normalsApart(planes) ? planes & ~gpu::kFillPlaneNormal : planes;
    choices.prior = prior;
    choices.colour = p_.side == 1;
    return choices;
}

void DeviceRender::drawColours(uint32_t planes, bool prior) {
    frame_.bin();
    frame_.fill(colourChoices(planes, prior));
}

void DeviceRender::drawNormals(uint32_t planes, bool prior) {
    frame_.transformAndCull(true);
    frame_.setupForBin();
    frame_.bin();
    FillChoices choices = forNormals(p_.choices);
    choices.write = planes & gpu::kFillPlaneNormal;
    choices.prior = prior;
    choices.colour = false;
    frame_.fill(choices);
}

void DeviceRender::readBand(PlaneWriter& writer, Frame& out, const gpu::FrameBox& band, uint32_t planes) {
    const uint32_t side = p_.side, rows = uint32_t(band.rows) / side, firstRow = uint32_t(band.firstRow) / side;
    const SampleLayout layout{frame_.rowPixels(), side, side, side / 2};
    const uint32_t linearSlot = planes & gpu::kFillPlaneTriangle ? 2 : 1;
    const uint32_t normalSlot = linearSlot + (planes & gpu::kFillPlaneLinear ? 3 : 0);
    PlaneWriter::DeviceRows colours{frame_.colourWords(), frame_.rowPixels(), {}, frame_.rowPixels()};
    if (side > 1) colours = {frame_.resolvedColours(), frame_.resolvedRowPixels(), {}, frame_.resolvedRowPixels()};
    for (uint32_t i = 0; i < 3 && writer.wants(kPlaneLinear); ++i)
        colours.linear[i] = side > 1 ? frame_.resolvedLinear(i).data() : frame_.plane(linearSlot + i).data();
    const uint64_t covered = writer.takeColours(firstRow, rows, colours);
    if (side == 1) out.coveredPixels += covered;
    const std::span<const uint32_t> z = planes & gpu::kFillPlaneZ ? frame_.plane(0) : std::span<const uint32_t>();
    const uint64_t samples = side > 1 ? writer.takeCoverage(rows, layout, z) : covered;
    if (p_.choices.shading == gpu::kShadingPhong) counters_.illuminations += samples;
    if (!(planes & gpu::kFillPlaneTriangle)) return;
    const std::span<const uint32_t> triangle = frame_.plane(1);
    const uint32_t* normals[3] = {};
    for (uint32_t i = 0; i < 3 && writer.wants(kPlaneNormal); ++i) normals[i] = frame_.plane(normalSlot + i).data();
    TriangleSeen seen(p_);
    writer.takeSeen(firstRow, rows, layout, z, [&](uint32_t x, uint32_t y, size_t at) {
        glm::vec3 normal(0);
        for (int i = 0; i < 3 && normals[i]; ++i) normal[i] = gpu::realOf(int(normals[i][at]));
        return seen.at(x, y, int(z[at]), triangle[at], normal);
    });
}

}  // namespace plumb
