// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/stages.h"

#include "pipeline/passes/parallel.h"
#include "pipeline/render/raster/hand_over.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

namespace {

// Planes of the whole chain, so that stages and chain take the same kernels. The first three are compared.
constexpr uint32_t kPlanes = gpu::kFillPlaneZ | gpu::kFillPlaneTriangle | gpu::kFillPlaneLinear | gpu::kFillPlaneNormal;

class RasterStages {
public:
    RasterStages(Device& device, const Prepared& p, const RenderRequest& request, StageCheck& check)
        : p_(p),
          threads_(threadCount(request.threads)),
          check_(check),
          frame_(device, p, request.watchdogMs),
          list_(chunkOf(p.list, 0, uint32_t(std::min<uint64_t>(frame_.chunkTriangles(), p.list.triangles.size())))),
          twin_(twinGeometry(list_, p.choices, false, threads_)) {}

    void run() {
        frame_.upload(list_);
        transformAndCull();
        gpu::FrameBox band = list_.frame;
        const uint32_t height = uint32_t(list_.frame.height), rows = std::min(frame_.bandRows(kPlanes), height);
        band.rows = int(rows);
        frame_.beginBand(band, kPlanes);
        setUpAndClip();
        for (uint32_t firstRow = 0; firstRow < height; firstRow += rows) {
            band.firstRow = int(firstRow);
            band.rows = int(std::min(rows, height - firstRow));
            if (firstRow) frame_.beginBand(band, kPlanes);
            fillBand(band);
        }
    }

private:
    void transformAndCull() {
        frame_.transformAndCull(false);
        const size_t vertices = list_.positions.size();
        const uint32_t shading = p_.choices.shading;
        const std::span<const glm::vec4> attributes = std::span(twin_.attributes).first(vertices),
                                         gotAttributes = frame_.attributes().first(vertices);
        check_.compare<gpu::ScreenVertex>("transform", "vertex", std::span(twin_.screen).first(vertices), frame_.screen().first(vertices));
        if (shading == gpu::kShadingPhong) check_.compare("transform", "normal of vertex", attributes, gotAttributes);
        if (shading == gpu::kShadingGouraud) check_.compareColours("colour of vertex", attributes, gotAttributes);
        if (shading == gpu::kShadingFlat)
            check_.compareColours("colour of face", twin_.faceColours, frame_.faceColours().first(twin_.faceColours.size()));
        check_.compare<gpu::CullRecord>("cull", "32 triangles", twin_.records, frame_.records().first(twin_.records.size()));
        handOverCulled(twin_, list_, frame_);
    }

    void setUpAndClip() {
        frame_.setup();
        check_.compare<gpu::DrawTriangle>("setup", "drawn triangle", twin_.draws, frame_.draws().first(twin_.draws.size()));
        // A clip job owns 8 corners and uses those that its fan names: the others are not compared.
        const std::vector<gpu::ScreenVertex> gotCorners(frame_.screen().begin(), frame_.screen().end());
        const std::vector<glm::vec4> gotAttributes(frame_.attributes().begin(), frame_.attributes().end());
        std::vector<gpu::ScreenVertex> wantCorners = gotCorners;
        std::vector<glm::vec4> wantAttributes = gotAttributes;
        for (const gpu::DrawTriangle& d : twin_.draws)
            for (uint32_t v : d.vertex)
                if (v >= list_.positions.size() && d.vertex[0] != d.vertex[1]) {
                    wantCorners[v] = twin_.screen[v];
                    wantAttributes[v] = twin_.attributes[v];
                }
        check_.compare<gpu::ScreenVertex>("clip", "clipped corner", wantCorners, gotCorners);
        if (p_.choices.shading >= gpu::kShadingGouraud)
            check_.compare<glm::vec4>("clip", "attributes of clipped corner", wantAttributes, gotAttributes);
        handOverSetUp(twin_, frame_);
    }

    void fillBand(const gpu::FrameBox& band) {
        try {
            frame_.bin();
        } catch (const TooLarge&) {
            return;  // the chain draws this one in chunks
        }
        FillChoices choices = p_.choices;
        choices.write = p_.choices.shading == gpu::kShadingPhong ? kPlanes : kPlanes & ~gpu::kFillPlaneNormal;
        choices.colour = p_.side == 1;
        frame_.fill(choices);
        const TileLists want = binCpu(frame_.binPush(), twin_.draws, twin_.screen);
        const TileLists got = frame_.lists();
        check_.compare<uint32_t>("bin", "entries of tile", want.counts, got.counts);
        if (want.entries.size() == got.entries.size()) check_.compare<uint32_t>("bin", "list entry", want.entries, got.entries);
        const size_t samples = size_t(band.width) * size_t(band.rows);
        std::vector<int> z(samples);
        std::vector<uint32_t> draw(samples);
        std::vector<float> linear(3 * samples);
        fillCpu(band, twin_.draws, twin_.screen, z, draw, threads_, p_.choices.depthBits);
        for (size_t i = 0; i < samples; ++i)
            if (!draw[i]) std::copy_n(&p_.backgroundLinear[0], 3, linear.begin() + ptrdiff_t(3 * i));
        shadeCpu(band, list_, p_.choices, twin_.draws, twin_.screen,
                 p_.choices.shading == gpu::kShadingFlat ? twin_.faceColours : twin_.attributes, z, draw, linear, {}, threads_);
        for (size_t at = 0; at < samples; ++at) {
            const int plane = differingPlane(band, at, z[at], draw[at], &linear[3 * at]);
            if (plane < 0) continue;
            keepPlane(band, plane < 2 ? "fill" : "shade", uint32_t(plane), [&](size_t i) {
                if (plane == 0) return uint32_t(z[i]);
                return plane == 1 ? triangleOf(draw[i]) : gpu::ubitsOf(linear[3 * i + size_t(plane) - 2]);
            });
            return;
        }
        for (const char* pass : {"fill", "shade"}) check_.equal(pass);
    }

    uint32_t triangleOf(uint32_t draw) const { return draw ? twin_.draws[draw - 1].source + list_.firstTriangle : gpu::kNoTriangle; }

    // Keeps a plane as the device left it, and with the twin's samples in it.
    template <class WantAt>
    void keepPlane(const gpu::FrameBox& band, const char* pass, uint32_t plane, const WantAt& wantAt) {
        const std::span<const uint32_t> got = frame_.plane(plane).first(size_t(band.rows) * frame_.rowPixels());
        std::vector<uint32_t> want(got.begin(), got.end());
        for (size_t y = 0; y < size_t(band.rows); ++y)
            for (size_t x = 0; x < size_t(band.width); ++x) want[y * frame_.rowPixels() + x] = wantAt(y * size_t(band.width) + x);
        check_.keep<uint32_t>(pass, "sample", want, got);
    }

    // First plane in which the sample differs, written down, or -1.
    int differingPlane(const gpu::FrameBox& band, size_t at, int z, uint32_t draw, const float* linear) {
        const size_t x = at % size_t(band.width), y = at / size_t(band.width), word = y * frame_.rowPixels() + x;
        const int gotZ = int(frame_.plane(0)[word]);
        const uint32_t gotTriangle = frame_.plane(1)[word];
        const uint32_t wantTriangle = triangleOf(draw);
        if (gotZ != z || gotTriangle != wantTriangle) {
            pixelDiffers("fill", band, x, y,
                         fmt::format("twin has triangle {} at z {} ({:08x}), device has {} at z {} ({:08x}), {} ULP", int(wantTriangle),
                                     gpu::realOf(z), uint32_t(z), int(gotTriangle), gpu::realOf(gotZ), uint32_t(gotZ),
                                     ulpDistance(gpu::realOf(z), gpu::realOf(gotZ))));
            return gotZ != z ? 0 : 1;
        }
        for (uint32_t i = 0; i < 3; ++i) {
            const float got = gpu::realOf(int(frame_.plane(2 + i)[word])), wanted = linear[i];
            if (check_.asNear(wanted, got, i)) continue;
            pixelDiffers("shade", band, x, y,
                         fmt::format("{} of triangle {}: twin has {} ({:08x}), device has {} ({:08x}), {} ULP", "RGB"[i], int(wantTriangle),
                                     wanted, std::bit_cast<uint32_t>(wanted), got, std::bit_cast<uint32_t>(got), ulpDistance(wanted, got)));
            return int(2 + i);
        }
        return -1;
    }

    void pixelDiffers(const char* pass, const gpu::FrameBox& band, size_t x, size_t y, const std::string& what) {
        y += size_t(band.firstRow);
        check_.differs(pass, fmt::format("tile ({}, {}), sample ({}, {}): {}", x / gpu::kTileWidth, y / gpu::kTileHeight, x, y, what));
    }

    const Prepared& p_;
    const uint32_t threads_;
    StageCheck& check_;
    GpuFrame frame_;
    const DrawList list_;
    const TwinGeometry twin_;
};

}  // namespace

void verifyRasterStages(Device& device, const Prepared& prepared, const RenderRequest& request, StageCheck& check) {
    if (!prepared.list.triangles.empty()) RasterStages(device, prepared, request, check).run();
}

}  // namespace plumb
