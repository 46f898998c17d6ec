// SPDX-License-Identifier: MIT
// Pixels of --fill exact: the chain of a triangle through transform, cull, setup, fill, shade and encode. Values of the twin come from its
// buffers and from the functions that its passes call; values of the device from its buffers and planes.
#include "pipeline/passes/pixel_shader.h"
#include "pipeline/pixel/chain_writer.h"
#include "pipeline/pixel/notes_chain.h"
#include "pipeline/pixel/picture.h"
#include "pipeline/render/raster/gpu_frame.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/scene/flattened.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// What lines of a vertex hold.
constexpr const char* kProjected = "Xps, Yps and Zps; pixels, and scene units from the screen";
constexpr const char* kDisplay = "Xd and Yd, pixels; then Zps";
constexpr const char* kBufferZ = "n / w, the Z-buffer's number: 1 at the near plane, larger is nearer";

// The twin's Z-buffer and draws at the two rows of samples that hold a sample (one pixel in 2 x 2 may be shaded).
struct Rows {
    gpu::FrameBox box{};
    std::vector<int> z;
    std::vector<uint32_t> draw;
};

// Buffers of the device for a chunk of the list.
struct DeviceChunk {
    DrawList list;
    std::vector<gpu::ScreenVertex> screen;
    std::vector<glm::vec4> attributes, faceColours;
    std::vector<gpu::CullRecord> records;
    std::vector<gpu::DrawTriangle> draws;
};

// A triangle of the list and where it stands in the scene.
struct Place {
    uint32_t listed = 0;  // index in the list; kNone: the list has it not, since its object is outside the view
    const DrawList::Range* range = nullptr;
    uint32_t object = 0, triangle = 0;
};

class RasterPixels : public BothFrames {
public:
    RasterPixels(Device* device, const std::string& why, const Scene& scene, const RenderRequest& request)
        : BothFrames(device, why, scene, request),
          p_(prepare(scene, request_, RunsOn::twin)),
          list_(p_.list),
          geometry_(twinGeometry(list_, p_.choices, false, request.threads)),
          truth_(scene, request_, 0) {}

    OpenedPixel open(const Asked& asked) override {
        OpenedPixel opened;
        opened.technique = technique_.name;
        opened.pixel = asked.pixel.has_value();
        std::vector<Place> places;
        if (asked.pixel) {
            opened.x = asked.pixel->x;
            opened.y = asked.pixel->y;
            look(opened, places);
        }
        if (asked.face || asked.vertex) places = askedFor(asked);
        for (const Place& place : places) opened.chains.push_back(chainOf(place, asked.pixel));
        if (asked.pixel && places.empty()) opened.chains.push_back(emptyChain(*asked.pixel));
        if (asked.pixel) explain(opened);
        return opened;
    }

private:
    uint32_t side() const { return p_.side; }
    glm::uvec2 standingSample(const glm::uvec2& pixel) const { return pixel * side() + side() / 2; }

    Place placeOf(uint32_t object, uint32_t triangle) const {
        for (const DrawList::Range& r : list_.ranges)
            if (r.sceneObject == object) return {r.firstTriangle + triangle, &r, object, triangle};
        return {kNone, nullptr, object, triangle};
    }
    Place placeOfListed(uint32_t listed) const {
        for (const DrawList::Range& r : list_.ranges)
            if (listed >= r.firstTriangle && listed < r.firstTriangle + r.triangleCount)
                return {listed, &r, r.sceneObject, listed - r.firstTriangle};
        PLUMB_ASSERT(!"a listed triangle has a range");
        return {};
    }
    const TriangleMesh& meshOf(uint32_t object) const { return scene_.meshes[scene_.objects[object].mesh]; }

    Rows rowsAt(uint32_t row) const {
        Rows rows;
        rows.box = list_.frame;
        rows.box.firstRow = int(row & ~1u);
        rows.box.rows = std::min(2, list_.frame.height - rows.box.firstRow);
        const size_t samples = size_t(rows.box.width) * size_t(rows.box.rows);
        rows.z.resize(samples);
        rows.draw.resize(samples);
        fillCpu(rows.box, geometry_.draws, geometry_.screen, rows.z, rows.draw, 1, p_.choices.depthBits);
        return rows;
    }
    size_t atSample(const Rows& rows, const glm::uvec2& sample) const {
        return size_t(sample.y - uint32_t(rows.box.firstRow)) * size_t(rows.box.width) + sample.x;
    }

    // What each side sees at the sample that stands for the pixel, and every triangle that covers it.
    void look(OpenedPixel& opened, std::vector<Place>& places) {
        const glm::uvec2 pixel(opened.x, opened.y), sample = standingSample(pixel);
        opened.twin = shownOf(twin_.frame, pixel);
        opened.device = deviceShown(pixel);
        const uint32_t twinSees = twin_.frame.triangle[at(pixel)],
                       deviceSees = device_ != nullptr ? drawn_.frame.triangle[at(pixel)] : kNone;
        std::map<std::pair<uint32_t, uint32_t>, Candidate> found;
        for (uint32_t k = 0; k < geometry_.draws.size(); ++k) {
            const gpu::DrawTriangle& d = geometry_.draws[k];
            if (d.vertex[0] == d.vertex[1] || !covers(d, sample)) continue;
            const Place place = placeOfListed(d.source);
            Candidate& c = found[{place.object, place.triangle}];
            c.twinZ.values = {double(depthAt(d, sample))};
            c.twinSees = d.source == twinSees;
            c.deviceSees = d.source == deviceSees;
        }
        std::vector<TriangleTruth::Hit> hits = truth_.hitsAt(int(sample.x), int(sample.y));
        for (size_t i = 0; i < hits.size(); ++i) {
            Candidate& c = found[{hits[i].object, hits[i].triangle}];
            c.truthZ.values = {hits[i].z};
            c.truthBound = hits[i].bound;
            c.truthSees = i == 0;
        }
        if (deviceSees != kNone) {
            const Place place = placeOfListed(deviceSees);
            found[{place.object, place.triangle}].deviceSees = true;
        }
        truthAt(opened, hits, sample);
        for (auto& [key, c] : found) {
            c.object = key.first;
            c.triangle = key.second;
            c.face = meshOf(c.object).triangles[c.triangle].face;
            if (!c.twinZ.has()) c.twinZ.why = "it does not cover the sample after rounding to sub-pixels, or it is culled";
            if (!c.truthZ.has()) c.truthZ.why = "it does not cover the sample in real arithmetic, or it is culled";
            if (!c.twinSees)
                c.lost = c.twinZ.has() ? "another is nearer, or as near and earlier in the list" : "it does not cover the sample";
            opened.candidates.push_back(c);
            if (c.twinSees || c.deviceSees || c.truthSees) places.push_back(placeOf(c.object, c.triangle));
        }
        std::stable_sort(opened.candidates.begin(), opened.candidates.end(), [](const Candidate& a, const Candidate& b) {
            return (a.twinZ.has() ? a.twinZ.values[0] : 0) > (b.twinZ.has() ? b.twinZ.values[0] : 0);
        });
        // The twin's first: what is printed is about it.
        std::stable_sort(places.begin(), places.end(),
                         [&](const Place& a, const Place& b) { return (a.listed == twinSees) > (b.listed == twinSees); });
    }

    void truthAt(OpenedPixel& opened, const std::vector<TriangleTruth::Hit>& hits, const glm::uvec2& sample) const {
        Shown& truth = opened.truth;
        truth.there = true;
        if (hits.empty()) {
            for (int k = 0; k < 3; ++k) truth.linear[k] = request_.transparent ? 0 : double(request_.background[k]);
        } else {
            truth.object = hits[0].object;
            truth.face = meshOf(truth.object).triangles[hits[0].triangle].face;
            const auto values = textbook::TriangleChain<Interval>(inputOf(hits[0].object, hits[0].triangle, sample, true)).make();
            for (size_t k = 0; k < 3; ++k) {
                truth.linear[k] = values.at("linear")[k].middle();
                truth.linearBound[k] = values.at("linear")[k].bound();
            }
            truth.depth = values.at("depth")[0].middle();
        }
        encode(truth);
    }

    textbook::TriangleInput inputOf(uint32_t object, uint32_t triangle, const std::optional<glm::uvec2>& sample, bool lit) const {
        const Object& o = scene_.objects[object];
        const TriangleMesh& mesh = meshOf(object);
        const truth::Pinhole& pinhole = truth_.geometry().pinhole();
        textbook::TriangleInput in{scene_, o, mesh};
        for (size_t i = 0; i < 3; ++i) in.vertex[i] = mesh.triangles[triangle].vertex[i];
        in.width = pinhole.width;
        in.height = pinhole.height;
        in.side = side();
        in.focal = pinhole.focal;
        in.near = pinhole.near;
        in.distance = scene_.camera->focusDistance;
        in.mirrored = mirrors(o.worldFromObject);
        in.sampled = sample.has_value();
        if (sample) {
            in.x = double(sample->x) + 0.5;
            in.y = double(sample->y) + 0.5;
        }
        in.distantViewer = request_.distantViewer;
        in.srgb = srgb_;
        in.lit = lit;
        in.material = &scene_.materials[mesh.faceMaterial[mesh.triangles[triangle].face]];
        return in;
    }

    bool covers(const gpu::DrawTriangle& d, const glm::uvec2& sample) const {
        const DrawnTriangle t(d, geometry_.screen);
        for (int i = 0; i < 3; ++i)
            if (t.edge(i, sample.x, sample.y) < 0) return false;
        return true;
    }
    float depthAt(const gpu::DrawTriangle& d, const glm::uvec2& sample) const {
        const DrawnTriangle t(d, geometry_.screen);
        const gpu::DepthPlane plane = t.depth(d, geometry_.screen);
        int z = gpu::depthBits(t.whole(2, sample.x, sample.y), t.whole(0, sample.x, sample.y), plane.k1, plane.k2, plane.zc, plane.low,
                               plane.high);
        if (p_.choices.depthBits < 32) z = gpu::coarseDepth(z, p_.choices.depthBits);
        if (p_.choices.depthBits == gpu::kDepthStandard) z = gpu::standardDepth(z);
        return gpu::realOf(z);
    }

    std::vector<Place> askedFor(const Asked& asked) const {
        const TriangleMesh& mesh = meshOf(asked.object);
        std::vector<Place> places;
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleMesh::Triangle& own = mesh.triangles[t];
            const bool hasVertex = !asked.vertex || std::find(own.vertex, own.vertex + 3, *asked.vertex) != own.vertex + 3;
            if (asked.face && own.face != *asked.face) continue;
            if (!asked.face && !hasVertex) continue;
            const Place place = placeOf(asked.object, t);
            // One triangle of a face: the one that covers the sample, or else the first.
            const bool covered =
                asked.pixel && place.listed != kNone && !drawsOf(place.listed, standingSample(*asked.pixel)).second.empty();
            if (covered) return {place};
            if (places.empty()) places.push_back(place);
        }
        if (places.empty()) throw usageError("no triangle has that vertex");
        return places;
    }

    // Draws of a listed triangle, and of these the ones that cover the sample.
    std::pair<std::vector<uint32_t>, std::vector<uint32_t>> drawsOf(uint32_t listed, const std::optional<glm::uvec2>& sample) const {
        std::pair<std::vector<uint32_t>, std::vector<uint32_t>> found;
        for (uint32_t k = 0; k < geometry_.draws.size(); ++k) {
            const gpu::DrawTriangle& d = geometry_.draws[k];
            if (d.source != listed || d.vertex[0] == d.vertex[1]) continue;
            found.first.push_back(k);
            if (sample && covers(d, *sample)) found.second.push_back(k);
        }
        return found;
    }

    // Device's buffers that hold a listed triangle. Null: no device, or its buffers do not fit.
    const DeviceChunk* chunkWith(uint32_t listed) {
        if (device_ == nullptr) return nullptr;
        if (!frame_) {
            forDevice_ = prepare(scene_, request_, RunsOn::device);
            frame_.emplace(*device_, *forDevice_, request_.watchdogMs);
        }
        const uint64_t most = std::max<uint64_t>(1, std::min<uint64_t>(frame_->chunkTriangles(), list_.triangles.size()));
        const uint32_t first = uint32_t(listed / most * most);
        const auto known = chunks_.find(first);
        if (known != chunks_.end()) return &known->second;
        DeviceChunk& c = chunks_[first];
        c.list = chunkOf(list_, first, uint32_t(std::min<uint64_t>(most, list_.triangles.size() - first)));
        frame_->upload(c.list);
        frame_->transformAndCull(false);
        gpu::FrameBox band = c.list.frame;
        band.rows = int(std::min(frame_->bandRows(0), uint32_t(band.height)));
        frame_->beginBand(band, 0);
        frame_->setup();
        const auto copy = [](auto& to, const auto& from) { to.assign(from.begin(), from.end()); };
        copy(c.screen, frame_->screen());
        copy(c.attributes, frame_->attributes());
        copy(c.faceColours, frame_->faceColours());
        copy(c.records, frame_->records());
        copy(c.draws, frame_->draws().first(frame_->slots().drawCount));
        return &c;
    }

    Chain chainOf(const Place& place, const std::optional<glm::uvec2>& pixel) {
        Chain chain;
        const TriangleMesh& mesh = meshOf(place.object);
        chain.object = place.object;
        chain.triangle = place.triangle;
        chain.face = mesh.triangles[place.triangle].face;
        chain.title = fmt::format("object {} '{}', face {}", place.object, scene_.objects[place.object].name, chain.face);
        ChainWriter lines(chain);
        const std::optional<glm::uvec2> sample = pixel ? std::optional(standingSample(*pixel)) : std::nullopt;
        writeVertices(lines, place, mesh);
        writeCull(lines, place);
        if (pixel && place.listed != kNone) writeFill(lines, chain, place, *pixel, *sample);
        const bool phong = p_.choices.shading == gpu::kShadingPhong;
        lines.take(textbook::TriangleChain<float>(inputOf(place.object, place.triangle, sample, phong)).make());
        textbook::TriangleInput exact = inputOf(place.object, place.triangle, sample, true);
        exact.origin = mesh.origin;
        lines.take(textbook::TriangleChain<Interval>(exact).make());
        lines.close("the notes have no such number", device_ == nullptr ? whyNoDevice_ : "the device's passes store no such number",
                    "the passes compute no such number", "real arithmetic has no such number");
        lines.compare(request_.trade.native());
        return chain;
    }

    // Vertices of the face in the order of its file: 2 to 4, 10.2 and 13.1.
    void writeVertices(ChainWriter& lines, const Place& place, const TriangleMesh& mesh) {
        const uint32_t* vertex = mesh.triangles[place.triangle].vertex;
        const DeviceChunk* chunk = place.listed == kNone ? nullptr : chunkWith(place.listed);
        const char* corners[] = {"first", "second", "third"};
        lines.twin("2", "O", "origin of the mesh in the object's space; vertices count from it", listOf(mesh.origin));
        for (size_t i = 0; i < 3; ++i)
            lines.twin("2", "P" + std::to_string(i), fmt::format("{} vertex, object space from O (vertex {})", corners[i], vertex[i]),
                       listOf(mesh.positions[vertex[i]]));
        Line& composite = lines.add("10.2", "M", "composite matrix: rows of X w, Y w (pixels times length) and w");
        if (place.listed == kNone) {
            composite.twin.why = "the object is outside the view, so the list leaves it out";
            for (const char* n : {"0", "1", "2"})
                for (const auto& [section, name, what] :
                     {std::tuple("10.1", "c", "vertex times the matrix: X w, Y w, w"), std::tuple("3", "projected", kProjected),
                      std::tuple("4", "display", kDisplay), std::tuple("14.2", "z", kBufferZ)})
                    lines.add(section, std::string(name) + n, what).twin.why = "the object is outside the view, so the list leaves it out";
            return;
        }
        const gpu::ObjectRecord& o = list_.objects[place.range->record];
        const double unit = p_.unit;
        for (const glm::vec4& row : {o.rowX, o.rowY, o.rowW})
            for (int k = 0; k < 4; ++k) composite.twin.values.push_back(double(row[k]) / unit);
        lines.twin("4", "centre", "middle of the canvas, pixels", {list_.viewport.centreX, list_.viewport.centreY});
        lines.twin("14.2", "near", "near plane, scene units", {double(list_.viewport.near) / unit});
        for (size_t i = 0; i < 3; ++i) {
            const std::string n = std::to_string(i);
            const uint32_t v = place.range->firstVertex + vertex[i];
            const glm::vec3 p(list_.positions[v]);
            const bool fp32 = place.range->precision == Precision::fp32;
            const glm::vec3 clip =
                fp32 ? glm::vec3(gpu::rowTimesPoint(o.rowX, p), gpu::rowTimesPoint(o.rowY, p), gpu::rowTimesPoint(o.rowW, p))
                     : glm::vec3(geometry_.clipSpace[v]);
            std::vector<std::string> how;
            for (const int row : {0, 4, 8})
                how.push_back(fmt::format("((M[{}]*P{}[0]+M[{}]*P{}[1])+M[{}]*P{}[2])+M[{}]", row, n, row + 1, n, row + 2, n, row + 3));
            lines.twin("10.1", "c" + n, "vertex times the matrix: X w, Y w, w", {clip.x / unit, clip.y / unit, clip.z / unit},
                       fp32 ? how : std::vector<std::string>());
            const gpu::ScreenVertex& s = geometry_.screen[v];
            lines.add("3", "projected" + n, kProjected).twin.why = "the pass goes from X w to display coordinates at once";
            lines.add("4", "display" + n, kDisplay);
            lines.add("13.1", "r" + n, "display coordinates rounded to 1/256 pixel");
            Line& out = lines.add("14.2", "z" + n, kBufferZ);
            Line *lineDisplay = lines.find("display" + n), *lineRounded = lines.find("r" + n);
            const char* beyond = "the vertex is outside a clip plane and has no place on the screen; corners after clipping follow";
            lineDisplay->twin.why = "the pass rounds it at once";
            if (s.outcode == 0) {
                const double step = list_.viewport.droppedBits == 0 ? 256 : 16;
                lineRounded->twin.values = {double(s.x) / 256, double(s.y) / 256};
                lineRounded->how = {fmt::format("snap(c{0}[0]/c{0}[2]+centre[0],{1})", n, step),
                                    fmt::format("snap(c{0}[1]/c{0}[2]+centre[1],{1})", n, step)};
                out.twin.values = {double(s.z)};
                out.how = {fmt::format("near[0]/c{}[2]", n)};
            } else {
                lineRounded->twin.why = out.twin.why = beyond;
            }
            lineRounded->truth.why = lineRounded->textbook.why = "only --fill notes rounds by the notes; this is the passes' finer grid";
            if (chunk == nullptr) continue;
            const gpu::ScreenVertex& d = chunk->screen[chunk->list.triangles[place.listed - chunk->list.firstTriangle][cornerOf(place, i)]];
            if (d.outcode == 0) {
                lineRounded->device.values = {double(d.x) / 256, double(d.y) / 256};
                out.device.values = {double(d.z)};
            } else {
                lineRounded->device.why = out.device.why = beyond;
            }
        }
    }
    // Corner of the listed triangle that is corner i of the face: left-handed scenes list the second and third in the other order.
    static int cornerOf(const Place& place, size_t i) { return place.range->turned && i != 0 ? int(3 - i) : int(i); }

    // 12.1 to 12.4.
    void writeCull(ChainWriter& lines, const Place& place) {
        const char* signOnly = "the pass decides by the sign of the rounded area";
        for (const auto& [section, name, what] :
             {std::tuple("12.1", "P", "P1 - P0, world space"), std::tuple("12.1", "Q", "P2 - P0, world space"),
              std::tuple("12.1", "N", "P x Q"), std::tuple("12.1", "N_length", "|N|"), std::tuple("12.1", "N_unit", "N / |N|"),
              std::tuple("12.2", "D", "plane offset, N_unit . P0"), std::tuple("12.4", "NV", "N_unit . V, V is the viewpoint"),
              std::tuple("12.4", "NV_minus_D", "N.V - D: above 0 the polygon faces the viewer")})
            lines.add(section, name, what).twin.why = signOnly;
        Line& visible = lines.add("12.4", "visible", "the polygon faces the viewer");
        visible.decision = true;
        if (place.listed == kNone) return;
        const auto verdict = [&](const std::vector<gpu::CullRecord>& records, uint32_t listed, Column& column) {
            const gpu::CullRecord& r = records[listed / gpu::kTrianglesPerLane];
            const uint32_t bit = 1u << (listed % gpu::kTrianglesPerLane);
            if ((r.drawn | r.backFacing) & bit)
                column.values = {(r.drawn & bit) != 0 ? 1.0 : 0.0};
            else
                column.why = (r.clip & bit) != 0       ? "it crosses a clip plane: its parts are culled after clipping"
                             : (r.zeroArea & bit) != 0 ? "its area is 0 after rounding: nothing is left to draw"
                                                       : "it is outside the view, or holds no sample";
        };
        if (!scene_.cullBackFaces) visible.twin.why = "cull is off: both sides are drawn";
        if (scene_.cullBackFaces) verdict(geometry_.records, place.listed, visible.twin);
        const DeviceChunk* chunk = chunkWith(place.listed);
        Line& line = *lines.find("visible");
        if (chunk != nullptr && scene_.cullBackFaces) verdict(chunk->records, place.listed - chunk->list.firstTriangle, line.device);
        if (chunk != nullptr && !scene_.cullBackFaces) line.device.why = line.twin.why;
    }

    // 13 to 16 at one sample.
    void writeFill(ChainWriter& lines, Chain& chain, const Place& place, const glm::uvec2& pixel, const glm::uvec2& sample) {
        const auto [draws, covering] = drawsOf(place.listed, sample);
        lines.twin("13", "sample", "point of the sample, pixels", {sample.x + 0.5, sample.y + 0.5});
        if (draws.empty()) return writeInside(lines, place, sample, false);
        const gpu::DrawTriangle& d = geometry_.draws[covering.empty() ? draws[0] : covering[0]];
        const DrawnTriangle t(d, geometry_.screen);
        writeCorners(lines, place, d);
        std::vector<double> edges, biases, wholes, rests;
        std::vector<std::string> edgeHow, wholeHow, restHow;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3;
            const int64_t e = t.edge(i, sample.x, sample.y);
            edges.push_back(double(e + t.bias[i]) / 65536);
            biases.push_back(t.bias[i]);
            wholes.push_back(double(t.whole(i, sample.x, sample.y)));
            rests.push_back(double(t.rho(i)));
            edgeHow.push_back(fmt::format("exact((q{1}[1]-q{0}[1])*(sample[0]-q{0}[0])+(q{0}[0]-q{1}[0])*(sample[1]-q{0}[1]))", i, j));
            wholeHow.push_back(fmt::format("exact(floor((E[{0}]*65536-bias[{0}])/256))", i));
            restHow.push_back(fmt::format("exact(((E[{0}]*65536-bias[{0}])%256+bias[{0}])/256)", i));
        }
        lines.twin("13.1", "E", "edge values at the sample, square pixels: all positive inside; exact integers in the passes", edges,
                   edgeHow);
        lines.twin("13.1", "bias", "1 for an edge whose own points belong to the neighbour (neither left nor top)", biases);
        Line& shares = lines.add("13.1", "shares", "shares of the corners on the screen, in the order of the file");
        shares.twin.why = "the pass weighs by E";
        writeInside(lines, place, sample, !covering.empty());
        lines.twin("", "e", "whole part of (E - bias) 256, float32", wholes, wholeHow);
        lines.twin("", "rho", "the rest of it, in 1/256", rests, restHow);
        writeDepth(lines, d, t, pixel, sample);
        if (!covering.empty() && twin_.frame.triangle[at(pixel)] == place.listed) writeShade(lines, chain, place, pixel, sample);
    }

    // Coverage: the twin's by exact integers, the truth's without rounding.
    void writeInside(ChainWriter& lines, const Place& place, const glm::uvec2& sample, bool covered) {
        Line& inside = lines.add("13.1", "inside", "the sample is inside the polygon, and it is drawn");
        inside.decision = true;
        inside.twin.values = {covered ? 1.0 : 0.0};
        const std::vector<TriangleTruth::Hit> hits = truth_.hitsAt(int(sample.x), int(sample.y));
        const auto own = [&](const auto& h) { return h.object == place.object && h.triangle == place.triangle; };
        inside.truth.values = {std::any_of(hits.begin(), hits.end(), own) ? 1.0 : 0.0};
        inside.bound = {0};
    }

    void writeCorners(ChainWriter& lines, const Place& place, const gpu::DrawTriangle& d) {
        const uint32_t first = place.range->firstVertex, count = uint32_t(list_.positions.size());
        const uint32_t* vertex = meshOf(place.object).triangles[place.triangle].vertex;
        for (size_t i = 0; i < 3; ++i) {
            const gpu::ScreenVertex& s = geometry_.screen[d.vertex[i]];
            std::vector<std::string> how;
            std::string what = "a corner after clipping: x and y in pixels, n / w";
            for (size_t k = 0; k < 3 && d.vertex[i] < count; ++k)
                if (first + vertex[k] == d.vertex[i]) {
                    how = {fmt::format("r{}[0]", k), fmt::format("r{}[1]", k), fmt::format("z{}[0]", k)};
                    what = fmt::format("corner {} in the order of filling: x and y in pixels, n / w", i);
                    break;
                }
            lines.twin("13.1", "q" + std::to_string(i), what, {double(s.x) / 256, double(s.y) / 256, double(s.z)}, how);
        }
    }

    // 14: the depth plane and its value, and what the Z-buffer keeps.
    void writeDepth(ChainWriter& lines, const gpu::DrawTriangle& d, const DrawnTriangle& t, const glm::uvec2& pixel,
                    const glm::uvec2& sample) {
        const gpu::DepthPlane plane = t.depth(d, geometry_.screen);
        int64_t sum = 0;
        for (int i = 0; i < 3; ++i) sum += t.edge(i, 0, 0) >> gpu::kSubpixelBits;
        lines.twin("", "esum", "sum of the whole parts, the same everywhere in the triangle", {double(float(sum))},
                   {"exact((e[0]+e[1])+e[2])"});
        lines.twin("14.2", "kz", "dZ for each unit of e2 and of e0", {plane.k1, plane.k2},
                   {"(q1[2]-q0[2])*(1/(esum[0]+((rho[0]+rho[1])+rho[2])))", "(q2[2]-q0[2])*(1/(esum[0]+((rho[0]+rho[1])+rho[2])))"});
        lines.twin("14.2", "zc", "Z where e is 0", {plane.zc}, {"q0[2]+(rho[2]*kz[0]+rho[0]*kz[1])"});
        const uint32_t listed = d.source;
        Line& z = lines.twin("14.2", "z", "n / w at the sample, within the corners' range", {double(depthAt(d, sample))});
        if (p_.choices.depthBits == 32) z.how = {"clamp((e[2]*kz[0]+e[0]*kz[1])+zc[0],min(q0[2],q1[2],q2[2]),max(q0[2],q1[2],q2[2]))"};
        if (device_ != nullptr && side() == 1 && drawn_.frame.triangle[at(pixel)] == listed)
            z.device.values = {double(drawn_.frame.z[at(pixel)])};
        else if (device_ != nullptr)
            z.device.why = side() == 1 ? "the device shows another polygon here" : "the plane holds one sample of several";
        lines.add("14.2", "Zps", "Zps at the sample, scene units").twin.why =
            "the Z-buffer holds n / w, from which Zps = d - d^2 / w follows";
        lines.add("3", "depth", "distance along the view axis, scene units").twin.values = {double(p_.near) / double(depthAt(d, sample))};
        Line& nearest = lines.add("14.1", "nearest", "the polygon is the one that the Z-buffer keeps");
        nearest.decision = true;
        nearest.twin.values = {twin_.frame.triangle[at(pixel)] == listed ? 1.0 : 0.0};
        if (device_ != nullptr) nearest.device.values = {drawn_.frame.triangle[at(pixel)] == listed ? 1.0 : 0.0};
        const std::vector<TriangleTruth::Hit> hits = truth_.hitsAt(int(sample.x), int(sample.y));
        const Place place = placeOfListed(listed);
        nearest.truth.values = {!hits.empty() && hits[0].object == place.object && hits[0].triangle == place.triangle ? 1.0 : 0.0};
        nearest.bound = {0};
    }

    // 16 and 17 at the sample, by the functions that the twin's shade pass calls.
    void writeShade(ChainWriter& lines, Chain& chain, const Place& place, const glm::uvec2& pixel, const glm::uvec2& sample) {
        const Rows rows = rowsAt(sample.y);
        const uint32_t shading = p_.choices.shading;
        const std::vector<glm::vec4>& attributes = shading == gpu::kShadingFlat ? geometry_.faceColours : geometry_.attributes;
        const PixelShader shader(rows.box, list_, p_.choices, geometry_.draws, geometry_.screen, attributes, rows.z, rows.draw);
        const size_t own = atSample(rows, sample), from = p_.choices.coarse ? shader.coarsePixel(own) : own;
        if (from != own) chain.title += "; --trade rate=1/2 takes the colour of another pixel of its 2 x 2";
        const gpu::DrawTriangle& d = geometry_.draws[rows.draw[own] - 1];
        PLUMB_ASSERT(d.source == place.listed);
        const gpu::MaterialRecord& m = list_.materials[list_.triangles[d.source].w];
        const PixelShader::Attributes v = shader.attributesAt(own, d);
        std::string last;
        if (shading == gpu::kShadingUnlit) {
            lines.twin("16.2", "colour", "colour of the material, without light", listOf(m.diffuse));
            last = "colour";
        } else if (shading == gpu::kShadingFlat) {
            last = writeFlat(lines, place);
        } else {
            last = writeInterpolated(lines, place, d, v, shader, own, pixel);
        }
        std::vector<std::vector<double>> samples;
        std::vector<std::string> names = {last};
        if (side() > 1) {
            names.clear();
            collectSamples(pixel, samples, names);
        }
        if (from != own) names.clear();
        Shown truth;
        truth.why = "the pixel shows several samples";
        if (side() == 1) {
            OpenedPixel opened;
            truthAt(opened, truth_.hitsAt(int(sample.x), int(sample.y)), sample);
            truth = opened.truth;
        }
        writePixel(chain, pixel, samples, names, truth);
        if (side() == 1 && from == own) confirm(lines, last);
    }

    // The chain's colour must be the one that the twin drew: the chain would otherwise explain another picture.
    void confirm(ChainWriter& lines, const std::string& last) const {
        const Line *colour = lines.find(last), *linear = lines.find("linear");
        for (size_t k = 0; k < 3; ++k)
            if (colour->twin.values[k] != linear->twin.values[k])
                throw renderError(fmt::format("plumb pixel: the opened chain ends at {:.9g} in channel {}, and the twin drew {:.9g}",
                                              colour->twin.values[k], k, linear->twin.values[k]));
    }

    void collectSamples(const glm::uvec2& pixel, std::vector<std::vector<double>>& samples, std::vector<std::string>& names) const {
        for (uint32_t j = 0; j < side(); ++j) {
            Rows rows = rowsAt(pixel.y * side() + j);
            std::vector<float> linear(3 * rows.z.size());
            for (size_t i = 0; i < rows.draw.size(); ++i)
                if (rows.draw[i] == 0) std::copy_n(&p_.backgroundLinear[0], 3, linear.begin() + ptrdiff_t(3 * i));
            shadeCpu(rows.box, list_, p_.choices, geometry_.draws, geometry_.screen,
                     p_.choices.shading == gpu::kShadingFlat ? geometry_.faceColours : geometry_.attributes, rows.z, rows.draw, linear, {},
                     1);
            for (uint32_t i = 0; i < side(); ++i) {
                const size_t s = atSample(rows, {pixel.x * side() + i, pixel.y * side() + j});
                names.push_back("sample" + std::to_string(samples.size()));
                samples.push_back({linear[3 * s], linear[3 * s + 1], linear[3 * s + 2]});
            }
        }
    }

    gpu::Surface surfaceOf(const gpu::ObjectRecord& o, const glm::vec4& position, const glm::vec4& normal) const {
        return gpu::surfaceOfPoint(o, list_.towardViewer != glm::vec3(0), list_.towardViewer, position.x, position.y, position.z, normal.x,
                                   normal.y, normal.z);
    }

    // 17.1: one colour a face, of its centre.
    std::string writeFlat(ChainWriter& lines, const Place& place) {
        const uint32_t face = list_.triangleFace[place.listed];
        const gpu::ObjectRecord& o = list_.objects[place.range->record];
        writeLit(lines,
                 {surfaceOf(o, list_.facePositions[face], list_.faceNormals[face]), list_.materials[list_.faceMaterial[face]], list_.lights,
                  p_.choices.parts, p_.unit},
                 "face_", "of the face, lit at its centre");
        Line& colour = lines.twin("17.1", "face_colour", "colour of the face", listOf(glm::vec3(geometry_.faceColours[face])),
                                  {"face_sum[0]", "face_sum[1]", "face_sum[2]"});
        const DeviceChunk* chunk = chunkWith(place.listed);
        if (chunk != nullptr) {
            const uint32_t own = chunk->list.triangleFace[place.listed - chunk->list.firstTriangle];
            colour.device.values = listOf(glm::vec3(chunk->faceColours[own]));
        }
        return "face_colour";
    }

    // 17.2 and 17.3: colours or normals of the corners, interpolated in perspective.
    std::string writeInterpolated(ChainWriter& lines, const Place& place, const gpu::DrawTriangle& d, const PixelShader::Attributes& v,
                                  const PixelShader& shader, size_t own, const glm::uvec2& pixel) {
        const bool phong = p_.choices.shading == gpu::kShadingPhong;
        const DeviceChunk* chunk = chunkWith(place.listed);
        const uint32_t count = uint32_t(list_.positions.size());
        int highest = 0;
        for (const uint32_t vertex : d.vertex) highest = std::max(highest, gpu::bitsOf(geometry_.screen[vertex].z));
        lines.twin("17.2", "scale", "power of two that brings the nearest corner's n / w to [1, 2)",
                   {p_.choices.affine ? 0.0 : double(gpu::weightScale(highest))});
        for (int i = 0; i < 3; ++i) {
            const std::string n = std::to_string(i);
            const uint32_t vertex = d.vertex[i];
            if (!phong && vertex < count) {
                const gpu::ObjectRecord& o = list_.objects[place.range->record];
                writeLit(lines,
                         {surfaceOf(o, list_.positions[vertex], list_.normals[vertex]), list_.materials[list_.vertexMaterial[vertex]],
                          list_.lights, p_.choices.parts, p_.unit},
                         "corner" + n + "_", "of corner " + n);
            }
            Line& attribute = lines.twin(phong ? "17.3" : "17.2", (phong ? "n" : "colour") + n,
                                         phong ? "normal of the corner, world space, of any length" : "colour of the corner",
                                         listOf(glm::vec3(geometry_.attributes[vertex])));
            if (!phong && vertex < count) attribute.how = {"corner" + n + "_sum[0]", "corner" + n + "_sum[1]", "corner" + n + "_sum[2]"};
            if (chunk != nullptr && vertex < count)
                for (int k = 0; k < 3; ++k) {
                    const glm::uvec4& whole = list_.triangles[place.listed];
                    if (whole[k] == vertex)
                        attribute.device.values =
                            listOf(glm::vec3(chunk->attributes[chunk->list.triangles[place.listed - chunk->list.firstTriangle][k]]));
                }
        }
        lines.add("17.3", "shares_in_space", "shares of the corners in space, in the order of the file").twin.why =
            "the pass weighs by E and n / w";
        const char* name = phong ? "n" : "colour";
        std::vector<std::string> weighed;
        for (int k = 0; k < 3; ++k) weighed.push_back(weighedBy(fmt::format("{}#[{}]", name, k)));
        lines.twin("17.3", "weighed",
                   phong ? "sum of the corners' normals times their weights" : "sum of the corners' colours times their weights",
                   {v.value[0], v.value[1], v.value[2]}, weighed);
        if (!phong) {
            lines.twin("17.2", "weight", "sum of the weights", {v.weight}, {weighedBy("")});
            const float inverse = gpu::reciprocal(v.weight);
            lines.twin("17.2", "gouraud", "colour of the sample", {v.value[0] * inverse, v.value[1] * inverse, v.value[2] * inverse},
                       {"weighed[0]*inverse(weight[0])", "weighed[1]*inverse(weight[0])", "weighed[2]*inverse(weight[0])"});
            return "gouraud";
        }
        writePhong(lines, d, v, shader, own, pixel);
        return "pixel_sum";
    }

    // Sum over the corners of value times weight times e + rho; '#' in `value` is the corner.
    std::string weighedBy(const std::string& value) const {
        const auto term = [&](int corner, int edge) {
            std::string v = value;
            for (size_t at = v.find('#'); at != v.npos; at = v.find('#')) v.replace(at, 1, std::to_string(corner));
            const std::string weight = p_.choices.affine ? "1" : fmt::format("(q{}[2]*scale[0])", corner);
            return fmt::format("(e[{0}]+rho[{0}])*{1}", edge, v.empty() ? weight : fmt::format("({}*{})", v, weight));
        };
        return fmt::format("({}+{})+{}", term(0, 1), term(1, 2), term(2, 0));
    }

    void writePhong(ChainWriter& lines, const gpu::DrawTriangle& d, PixelShader::Attributes v, const PixelShader& shader, size_t own,
                    const glm::uvec2& pixel) {
        if (p_.choices.unitNormals) {
            gpu::unitVector(v.value[0], v.value[1], v.value[2]);
        } else {
            const float inverse = gpu::reciprocal(v.weight);
            for (float& normal : v.value) normal *= inverse;
        }
        const gpu::Surface s = shader.surfaceAt(own, d, v);
        const double unit = p_.unit;
        lines.twin("3", "ray", "rows of the ray through a point: origin, for each column, for each row",
                   {list_.rayOrigin.x, list_.rayOrigin.y, list_.rayOrigin.z, list_.rayX.x, list_.rayX.y, list_.rayX.z, list_.rayY.x,
                    list_.rayY.y, list_.rayY.z});
        std::vector<std::string> position;
        for (int k = 0; k < 3; ++k)
            position.push_back(fmt::format("((ray[{}]+sample[0]*ray[{}])+sample[1]*ray[{}])*(inverse(z[0])*near[0])", k, k + 3, k + 6));
        lines.twin("16.3", "position", "point of the surface from the eye, scene units", {s.px / unit, s.py / unit, s.pz / unit}, position);
        for (size_t i = 0; i < list_.lights.size(); ++i)
            if (list_.lights[i].kind != 0)
                lines.twin("16.3", "light" + std::to_string(i), "position of the light from the eye, scene units",
                           listOf(glm::dvec3(list_.lights[i].position) / unit));
        writeLit(lines, {s, list_.materials[list_.triangles[d.source].w], list_.lights, p_.choices.parts, unit}, "pixel_", "at the sample");
        Line& normal = *lines.find("pixel_N");
        if (p_.choices.unitNormals) {
            const std::string square = "(weighed[0]*weighed[0]+weighed[1]*weighed[1])+weighed[2]*weighed[2]";
            for (int k = 0; k < 3; ++k) normal.how.push_back(fmt::format("weighed[{}]*rsqrt({})", k, square));
            if (device_ != nullptr && drawn_.frame.triangle[at(pixel)] == d.source)
                for (size_t k = 0; k < 3; ++k) normal.device.values.push_back(double(drawn_.frame.normal[3 * at(pixel) + k]));
        }
        if (p_.choices.vectors != gpu::kVectorsPixel || list_.towardViewer != glm::vec3(0)) return;
        const auto viewed = [](int k) { return fmt::format("(0-((ray[{}]+sample[0]*ray[{}])+sample[1]*ray[{}]))", k, k + 3, k + 6); };
        const std::string length = fmt::format("rsqrt(({0}*{0}+{1}*{1})+{2}*{2})", viewed(0), viewed(1), viewed(2));
        Line& view = *lines.find("pixel_V");
        for (int k = 0; k < 3; ++k) view.how.push_back(viewed(k) + "*" + length);
        for (size_t i = 0; i < list_.lights.size(); ++i) {
            if (list_.lights[i].kind == 0) continue;
            const auto toward = [&](int k) { return fmt::format("(light{}[{}]-position[{}])", i, k, k); };
            const std::string inverse = fmt::format("rsqrt(({0}*{0}+{1}*{1})+{2}*{2})", toward(0), toward(1), toward(2));
            Line& l = *lines.find("pixel_L" + std::to_string(i));
            for (int k = 0; k < 3; ++k) l.how.push_back(toward(k) + "*" + inverse);
            Line& fade = *lines.find("pixel_fade" + std::to_string(i));
            if (list_.lights[i].attenuation == 1) fade.how = {inverse};
            if (list_.lights[i].attenuation == 2) fade.how = {inverse + "*" + inverse};
        }
    }

    Chain emptyChain(const glm::uvec2& pixel) {
        Chain chain;
        chain.title = "no polygon covers the pixel: it shows the background";
        chain.object = chain.face = chain.triangle = kNone;
        OpenedPixel opened;
        truthAt(opened, {}, standingSample(pixel));
        std::vector<std::vector<double>> samples;
        std::vector<std::string> names;
        ChainWriter lines(chain);
        if (side() > 1)
            collectSamples(pixel, samples, names);
        else {
            lines.twin("16.5", "background", "linear colour where nothing is drawn", listOf(p_.backgroundLinear));
            names = {"background"};
        }
        if (side() > 1) {
            opened.truth.there = false;
            opened.truth.why = "the pixel shows several samples";
        }
        writePixel(chain, pixel, samples, names, opened.truth);
        const std::string given = "the background is given, not computed";
        lines.close("the notes have no such number", device_ == nullptr ? whyNoDevice_ : given, given, given);
        lines.compare(request_.trade.native());
        return chain;
    }

    const Prepared p_;
    const DrawList& list_;
    const TwinGeometry geometry_;
    TriangleTruth truth_;
    std::optional<Prepared> forDevice_;  // the same list, with the plan of the device
    std::optional<GpuFrame> frame_;
    std::map<uint32_t, DeviceChunk> chunks_;
};

}  // namespace

std::unique_ptr<PixelOpener> rasterOpener(Device* device, const std::string& whyNoDevice, const Scene& scene,
                                          const RenderRequest& request) {
    return std::make_unique<RasterPixels>(device, whyNoDevice, scene, request);
}

}  // namespace plumb
