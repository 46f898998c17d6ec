// SPDX-License-Identifier: MIT
#include "pipeline/pixel/picture.h"

#include "pipeline/pixel/chain_writer.h"
#include "pipeline/render/raster/raster.h"
#include "pipeline/render/rays/rays.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <utility>

namespace plumb {

BothFrames::BothFrames(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request)
    : device_(device), whyNoDevice_(whyNoDevice), scene_(scene), request_(request), technique_(techniqueOf(scene, request)) {
    request_.planes = technique_.planes;
    srgb_ = request.encoding == Encoding::srgb;
    RenderRequest half = request_;
    const auto share = [&](double from, double to) {
        if (request_.onProgress) half.onProgress = [this, from, to](double done) { return request_.onProgress(from + (to - from) * done); };
    };
    share(0, 0.5);
    twin_ = renderCpu(scene_, half);
    share(0.5, 1);
    if (device_ != nullptr) drawn_ = renderGpu(*device_, scene_, half);
}

Shown BothFrames::shownOf(const Frame& frame, const glm::uvec2& pixel) const {
    const size_t i = at(pixel);
    Shown shown;
    shown.there = true;
    shown.object = frame.object[i];
    shown.face = frame.primitive[i];
    shown.depth = frame.depth.empty() ? 0 : double(frame.depth[i]);
    for (size_t k = 0; k < 3; ++k) {
        shown.linear[k] = double(frame.linear[3 * i + k]);
        shown.code[k] = double(frame.rgba[i] >> (8 * k) & 255u);
    }
    return shown;
}

Shown BothFrames::deviceShown(const glm::uvec2& pixel) const {
    if (device_ != nullptr) return shownOf(drawn_.frame, pixel);
    Shown none;
    none.why = whyNoDevice_;
    return none;
}

void BothFrames::encode(Shown& truth) const {
    for (size_t k = 0; k < 3; ++k) {
        const Interval code = codeOf(Interval(truth.linear[k] - truth.linearBound[k], truth.linear[k] + truth.linearBound[k]), srgb_);
        truth.code[k] = code.middle();
        truth.codeBound[k] = code.bound();
    }
}

void BothFrames::writePixel(Chain& chain, const glm::uvec2& pixel, const std::vector<std::vector<double>>& samples,
                            const std::vector<std::string>& names, const Shown& truth) const {
    ChainWriter lines(chain);
    const Shown twin = shownOf(twin_.frame, pixel), device = deviceShown(pixel);
    const auto of = [](const double(&v)[3]) { return std::vector<double>(v, v + 3); };
    const auto column = [&](Line& line, const double(Shown::*values)[3], const double(Shown::*bounds)[3]) {
        if (device.there)
            line.device.values = of(device.*values);
        else
            line.device.why = device.why;
        if (truth.there) {
            line.truth.values = of(truth.*values);
            line.bound = of(truth.*bounds);
        } else {
            line.truth.why = truth.why;
        }
    };
    for (size_t s = 0; samples.size() > 1 && s < samples.size(); ++s)
        lines.twin("18.4.1", "sample" + std::to_string(s), "linear colour of one sample", samples[s]);
    std::vector<std::string> how;
    for (size_t k = 0; k < 3; ++k) {
        std::string text = samples.size() > 1 ? "mean(" : "";
        for (size_t s = 0; s < names.size(); ++s) text += fmt::format("{}{}[{}]", s != 0 ? "," : "", names[s], k);
        if (!names.empty()) how.push_back(text + (samples.size() > 1 ? ")" : ""));
    }
    Line& linear = lines.twin("16.5", "linear", "linear colour of the pixel", of(twin.linear), how);
    column(linear, &Shown::linear, &Shown::linearBound);
    Line& bytes =
        lines.twin("16.2", "bytes", srgb_ ? "codes of the sRGB curve, rounded" : "255 times the intensity, rounded", of(twin.code),
                   {srgb_ ? "srgb(linear[0])" : "round255(linear[0])", srgb_ ? "srgb(linear[1])" : "round255(linear[1])",
                    srgb_ ? "srgb(linear[2])" : "round255(linear[2])"});
    column(bytes, &Shown::code, &Shown::codeBound);
}

// One sentence for each pair of sides: where they part, or that they do not.
void BothFrames::explain(OpenedPixel& opened) const {
    if (device_ != nullptr) {
        const bool same = opened.device.object == opened.twin.object && opened.device.face == opened.twin.face &&
                          std::equal(opened.device.linear, opened.device.linear + 3, opened.twin.linear) &&
                          std::equal(opened.device.code, opened.device.code + 3, opened.twin.code);
        std::string where;
        for (const Chain& chain : opened.chains)
            if (where.empty() && !chain.deviceParts.empty()) where = fmt::format("{}: {}", chain.title, chain.deviceParts);
        opened.explains.push_back(same && where.empty()
                                      ? "device and twin: the same bits on every line that both have"
                                      : fmt::format("device and twin part first at {}", where.empty() ? "the pixel's planes" : where));
    }
    if (opened.truth.object == opened.twin.object && opened.truth.face == opened.twin.face) {
        opened.explains.push_back("twin and truth see the same face");
        return;
    }
    std::string where;
    for (const Chain& chain : opened.chains)
        if (where.empty() && !chain.truthParts.empty()) where = fmt::format("{}: {}", chain.title, chain.truthParts);
    opened.explains.push_back(
        fmt::format("twin and truth see different faces; they part first at {}", where.empty() ? "the pixel's planes" : where));
}

TriangleTruth::TriangleTruth(const Scene& scene, const RenderRequest& request, double shift)
    : geometry_(scene, truth::Pinhole(*scene.camera, request.width, request.height,
                                      request.samples == 16  ? 4
                                      : request.samples == 4 ? 2
                                                             : 1,
                                      shift)),
      judge_(geometry_) {}

std::vector<TriangleTruth::Hit> TriangleTruth::hitsAt(int column, int row) {
    std::vector<Hit> hits;
    const double x = geometry_.pinhole().x(column), y = geometry_.pinhole().y(row), near = geometry_.pinhole().near;
    const std::vector<truth::Triangle>& all = geometry_.triangles();
    for (uint32_t i = 0; i < all.size(); ++i) {
        const truth::Triangle& t = all[i];
        if (column < t.firstColumn || column > t.lastColumn || row < t.firstRow || row > t.lastRow || !judge_.hits(i, x, y)) continue;
        hits.push_back({i, t.object, t.triangle, near * (t.sa * x + t.sb * y + t.sc), near * t.inverseError});
    }
    std::sort(hits.begin(), hits.end(),
              [&](const Hit& a, const Hit& b) { return a.index != b.index && judge_.nearer(a.index, b.index, x, y); });
    return hits;
}

void checkAsked(const Scene& scene, const RenderRequest& request, const Asked& asked) {
    if (asked.pixel && (asked.pixel->x >= request.width || asked.pixel->y >= request.height))
        throw usageError(fmt::format("pixel {},{} is outside the picture of {}x{}: columns are 0 to {}, rows 0 to {}", asked.pixel->x,
                                     asked.pixel->y, request.width, request.height, request.width - 1, request.height - 1));
    if (!asked.face && !asked.vertex) return;
    if (asked.object >= scene.objects.size())
        throw usageError(
            fmt::format("--object: the scene has {} objects, numbered from 0; {} is not one of them", scene.objects.size(), asked.object));
    const TriangleMesh& mesh = scene.meshes[scene.objects[asked.object].mesh];
    const auto drawn = [&](uint32_t face) {
        return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) { return t.face == face; });
    };
    if (asked.face && *asked.face >= mesh.faceCentre.size())
        throw usageError(
            fmt::format("--polygon {}: object {} has {} polygons, numbered from 0", *asked.face, asked.object, mesh.faceCentre.size()));
    if (asked.face && !drawn(*asked.face)) throw usageError(fmt::format("--polygon {}: it has no area and no triangle", *asked.face));
    if (asked.vertex && *asked.vertex >= mesh.positions.size())
        throw usageError(
            fmt::format("--vertex {}: object {} has {} vertices, numbered from 0", *asked.vertex, asked.object, mesh.positions.size()));
}

std::unique_ptr<PixelOpener> openerOf(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request) {
    refuse(scene, request);
    const Technique& technique = techniqueOf(scene, request);
    if (&technique == &kRays) {
        if (request.rays.cutLevels)
            throw usageError("--levels cut: colours are cut to whole levels ray by ray, which is not opened; leave it out");
        return rayOpener(device, whyNoDevice, scene, request);
    }
    if (&technique != &kRaster)
        throw usageError(
            "pixels of --fill exact can be opened, by --shading unlit, flat, gouraud or phong, and of --shading ray; not those of wire "
            "frames "
            "or of --fill notes");
    return rasterOpener(device, whyNoDevice, scene, request);
}

}  // namespace plumb
