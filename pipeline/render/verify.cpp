// SPDX-License-Identifier: MIT
// Compares device and twin twice: each pass on the twin's input, and the whole chain on each side's own output.
#include "host/error.h"
#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/bounds/bound.h"
#include "pipeline/render/raster/gpu_frame.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/sha256.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Planes of the chain, asked for here too so that both take the same kernels. passes() compares the first three.
constexpr uint32_t kPlanes = gpu::kFillPlaneZ | gpu::kFillPlaneTriangle | gpu::kFillPlaneLinear | gpu::kFillPlaneNormal;
constexpr size_t kSmallPlane = 1 << 18;  // values; the hash of so few takes as long as a thread's start

// Distance in representable floats; the sign bit is folded so that -0 and +0 are 0 apart.
uint64_t ulpDistance(float a, float b) {
    const auto ordered = [](float f) {
        const int64_t i = std::bit_cast<int32_t>(f);
        return i < 0 ? int64_t(INT32_MIN) - i : i;
    };
    return uint64_t(std::abs(ordered(a) - ordered(b)));
}

template <class T>
std::string hashOf(const std::vector<T>& v) {
    return sha256Hex(std::as_bytes(std::span<const T>(v)));
}

// Every bit counts: -0 is not +0, and a NaN equals itself only bit for bit.
template <class T>
bool sameBits(const T& a, const T& b) {
    const auto x = std::as_bytes(std::span<const T>(&a, 1)), y = std::as_bytes(std::span<const T>(&b, 1));
    return std::equal(x.begin(), x.end(), y.begin());
}

// First differing element of two arrays of plain structs, or -1.
template <class T>
int64_t firstDifference(std::span<const T> want, std::span<const T> got) {
    if (want.size() != got.size()) return int64_t(std::min(want.size(), got.size()));
    for (size_t i = 0; i < want.size(); ++i)
        if (!sameBits(want[i], got[i])) return int64_t(i);
    return -1;
}

template <class T>
std::string wordsOf(const T& value) {
    std::string text;
    const auto* words = reinterpret_cast<const uint32_t*>(&value);
    for (size_t i = 0; i < sizeof(T) / 4; ++i) text += fmt::format("{}{:08x}", i ? " " : "", words[i]);
    return text;
}

class Verifier {
public:
    Verifier(Device& device, const Scene& scene, const RenderRequest& request) : device_(device), scene_(scene), request_(request) {}

    VerifyReport run() {
        if (request_.trade.native()) {
            const ColourBound bound = boundOfNative(scene_, request_);
            if (!bound.proved) throw usageError("verify: the device's own functions have no bound here: " + bound.why);
            report_.bounded = true;
            report_.boundLinear = bound.linear;
            report_.boundSteps = bound.steps;
        }
        if (request_.shading != Shading::wire && request_.shading != Shading::ray && request_.fill != Fill::notes) passes();
        chain();
        report_.equal = report_.mismatches.empty();
        return std::move(report_);
    }

private:
    template <class T>
    void compare(const char* pass, const char* element, std::span<const T> want, std::span<const T> got) {
        const int64_t at = firstDifference(want, got);
        auto entry = std::find_if(report_.passes.begin(), report_.passes.end(), [&](const auto& p) { return p.first == pass; });
        if (entry == report_.passes.end()) entry = report_.passes.insert(report_.passes.end(), {pass, true});
        if (at < 0) return;
        entry->second = false;
        std::string what = fmt::format("{} {}: ", element, at);
        if (size_t(at) < want.size() && size_t(at) < got.size())
            what += fmt::format("twin has words {}, device has {}", wordsOf(want[size_t(at)]), wordsOf(got[size_t(at)]));
        else
            what += fmt::format("twin has {} of them, device has {}", want.size(), got.size());
        report_.mismatches.push_back({pass, false, what});
    }

    // Colours: the same bits, or as near as the device's own functions must be.
    bool asNear(float twin, float device, size_t channel) const {
        if (!std::isfinite(twin) || !std::isfinite(device)) return false;
        return sameBits(twin, device) || std::abs(double(twin) - double(device)) <= report_.boundLinear[glm::length_t(channel)];
    }
    void compareColours(const char* element, std::span<const glm::vec4> want, std::span<const glm::vec4> got) {
        std::vector<glm::vec4> near(got.begin(), got.end());
        for (size_t i = 0; i < std::min(want.size(), near.size()); ++i)
            if (asNear(want[i].x, near[i].x, 0) && asNear(want[i].y, near[i].y, 1) && asNear(want[i].z, near[i].z, 2)) near[i] = want[i];
        compare<glm::vec4>("illuminate", element, want, near);
    }
    // A code between those of the ends of what the colour may be, and as many steps beyond as the device's own curve may be off.
    bool codeAsNear(uint32_t code, float linear, size_t channel) const {
        const double off = report_.boundLinear[glm::length_t(channel)];
        const float ends[] = {float(double(linear) - off), float(double(linear) + off)};
        const uint32_t encoding = request_.encoding == Encoding::linear ? gpu::kEncodeLinear : gpu::kEncodeSrgb;
        const auto codeOf = [&](float x) {
            const float grey[3] = {x, x, x};
            return double(encodePixelCpu(encoding, grey, 0) & 0xff);
        };
        return code >= codeOf(ends[0]) - report_.boundSteps && code <= codeOf(ends[1]) + report_.boundSteps;
    }
    bool colourAsNear(uint32_t twin, uint32_t device, const float* linear) const {
        bool near = twin >> 24 == device >> 24;
        for (size_t c = 0; near && c < 3; ++c) near = codeAsNear(device >> (8 * c) & 0xff, linear[c], c);
        return near;
    }

    // One chunk (the whole list where it fits), one band at a time is enough: chunks and bands are compared by the chain.
    void passes() {
        const Prepared p = prepare(scene_, request_);
        if (p.list.triangles.empty()) return;
        GpuFrame frame(device_, p, request_.watchdogMs);
        const uint32_t count = uint32_t(std::min<uint64_t>(frame.chunkTriangles(), p.list.triangles.size()));
        const DrawList list = chunkOf(p.list, 0, count);
        const TwinGeometry twin = twinGeometry(list, p.choices, false, threadCount(request_.threads), nullptr);
        const size_t vertices = list.positions.size();
        frame.upload(list);
        frame.transformAndCull(false);
        compare<gpu::ScreenVertex>("transform", "vertex", std::span(twin.screen).first(vertices), frame.screen().first(vertices));
        if (p.choices.shading == gpu::kShadingPhong)
            compare<glm::vec4>("transform", "normal of vertex", std::span(twin.carried).first(vertices), frame.carried().first(vertices));
        if (p.choices.shading == gpu::kShadingGouraud)
            compareColours("colour of vertex", std::span(twin.carried).first(vertices), frame.carried().first(vertices));
        if (p.choices.shading == gpu::kShadingFlat)
            compareColours("colour of face", twin.faceColours, frame.faceColours().first(twin.faceColours.size()));
        compare<gpu::CullRecord>("cull", "32 triangles", twin.records, frame.records().first(twin.records.size()));
        // From here on the device reads the twin's vertices and records.
        std::copy_n(twin.screen.begin(), vertices, frame.screen().begin());
        std::copy_n(twin.carried.begin(), vertices, frame.carried().begin());
        std::copy(twin.records.begin(), twin.records.end(), frame.records().begin());
        gpu::FrameBox band = list.frame;
        const uint32_t bandRows = std::min(frame.bandRows(kPlanes), uint32_t(list.frame.height));
        band.rows = int(bandRows);
        frame.beginBand(band, kPlanes);
        frame.setup();
        compare<gpu::DrawTriangle>("setup", "drawn triangle", twin.draws, frame.draws().first(twin.draws.size()));
        // A clip job owns 8 corners and uses those that its fan names.
        std::vector<gpu::ScreenVertex> wantCorners, gotCorners;
        std::vector<glm::vec4> wantCarried, gotCarried;
        for (const gpu::DrawTriangle& d : twin.draws)
            for (uint32_t v : d.vertex)
                if (v >= vertices && d.vertex[0] != d.vertex[1]) {
                    wantCorners.push_back(twin.screen[v]);
                    gotCorners.push_back(frame.screen()[v]);
                    wantCarried.push_back(twin.carried[v]);
                    gotCarried.push_back(frame.carried()[v]);
                }
        compare<gpu::ScreenVertex>("clip", "clipped corner", wantCorners, gotCorners);
        if (p.choices.shading >= gpu::kShadingGouraud) compare<glm::vec4>("clip", "carried by clipped corner", wantCarried, gotCarried);
        for (uint32_t firstRow = 0; firstRow < uint32_t(list.frame.height); firstRow += bandRows) {
            band.firstRow = int(firstRow);
            band.rows = int(std::min(bandRows, uint32_t(list.frame.height) - firstRow));
            if (firstRow) frame.beginBand(band, kPlanes);
            verifyBand(frame, p, list, twin, band);
        }
    }

    void verifyBand(GpuFrame& frame, const Prepared& p, const DrawList& list, const TwinGeometry& twin, const gpu::FrameBox& band) {
        try {
            frame.bin();
        } catch (const TooLarge&) {
            return;  // the chain draws this one in chunks
        }
        FillChoices choices = p.choices;
        choices.write = p.choices.shading == gpu::kShadingPhong ? kPlanes : kPlanes & ~gpu::kFillPlaneNormal;
        choices.colour = p.side == 1;
        frame.fill(choices);
        const TileLists want = binCpu(frame.binPush(), twin.draws, twin.screen);
        const TileLists got = frame.lists();
        compare<uint32_t>("bin", "entries of tile", want.counts, got.counts);
        if (want.entries.size() == got.entries.size()) compare<uint32_t>("bin", "list entry", want.entries, got.entries);
        const size_t samples = size_t(band.width) * size_t(band.rows);
        std::vector<int> z(samples);
        std::vector<uint32_t> draw(samples);
        std::vector<float> linear(3 * samples);
        fillCpu(band, twin.draws, twin.screen, z, draw, threadCount(request_.threads), p.choices.depthBits);
        for (size_t i = 0; i < samples; ++i)
            if (!draw[i]) std::copy_n(&p.backgroundLinear[0], 3, linear.begin() + ptrdiff_t(3 * i));
        shadeCpu(band, list, p.choices, twin.draws, twin.screen, p.choices.shading == gpu::kShadingFlat ? twin.faceColours : twin.carried,
                 z, draw, linear, {}, threadCount(request_.threads));
        for (size_t at = 0; at < samples; ++at) {
            const size_t x = at % size_t(band.width), y = at / size_t(band.width);
            const size_t word = y * frame.rowPixels() + x;
            const int gotZ = int(frame.plane(0)[word]);
            const uint32_t gotTriangle = frame.plane(1)[word];
            const uint32_t wantTriangle = draw[at] ? twin.draws[draw[at] - 1].source + list.firstTriangle : gpu::kNoTriangle;
            if (gotZ != z[at] || gotTriangle != wantTriangle) {
                failPixel("fill", band, x, y,
                          fmt::format("twin has triangle {} at z {} ({:08x}), device has {} at z {} ({:08x}), {} ULP", int(wantTriangle),
                                      gpu::realOf(z[at]), uint32_t(z[at]), int(gotTriangle), gpu::realOf(gotZ), uint32_t(gotZ),
                                      ulpDistance(gpu::realOf(z[at]), gpu::realOf(gotZ))));
                return;
            }
            for (uint32_t i = 0; i < 3; ++i) {
                const float got = gpu::realOf(int(frame.plane(2 + i)[word])), wanted = linear[3 * at + i];
                if (!asNear(wanted, got, i)) {
                    failPixel(
                        "shade", band, x, y,
                        fmt::format("{} of triangle {}: twin has {} ({:08x}), device has {} ({:08x}), {} ULP", "RGB"[i], int(wantTriangle),
                                    wanted, std::bit_cast<uint32_t>(wanted), got, std::bit_cast<uint32_t>(got), ulpDistance(wanted, got)));
                    return;
                }
            }
        }
        for (const char* pass : {"fill", "shade"})
            if (std::none_of(report_.passes.begin(), report_.passes.end(), [&](const auto& e) { return e.first == pass; }))
                report_.passes.push_back({pass, true});
    }

    void failPixel(const char* pass, const gpu::FrameBox& band, size_t x, size_t y, const std::string& what) {
        y += size_t(band.firstRow);
        report_.passes.push_back({pass, false});
        report_.mismatches.push_back(
            {pass, false, fmt::format("tile ({}, {}), sample ({}, {}): {}", x / gpu::kTileWidth, y / gpu::kTileHeight, x, y, what)});
    }

    template <class T>
    void comparePlane(const char* name, const std::vector<T>& twin, const std::vector<T>& device, uint32_t channels) {
        comparePlane(name, twin, device, channels, [](size_t) { return false; });
    }
    // within(i): the values differ, and may.
    template <class T, class Within>
    void comparePlane(const char* name, const std::vector<T>& twin, const std::vector<T>& device, uint32_t channels, const Within& within) {
        if (twin.empty() && device.empty()) return;  // pictures of this kind have no such plane
        VerifyPlane plane{name, "", "", 0};
        const bool small = twin.size() < kSmallPlane;
        parallelBands(2, 1, small ? 1 : threadCount(request_.threads), [&](uint64_t first, uint64_t end) {
            for (; first < end; ++first) (first == 0 ? plane.twinSha256 : plane.deviceSha256) = first == 0 ? hashOf(twin) : hashOf(device);
        });
        if (twin.size() != device.size()) {
            plane.differing = plane.beyond = std::max(twin.size(), device.size());
            report_.planes.push_back(plane);
            report_.mismatches.push_back({name, true, fmt::format("twin has {} values, device has {}", twin.size(), device.size())});
            return;
        }
        int64_t first = -1;
        bool finite = true;
        for (size_t i = 0; i < twin.size(); ++i) {
            bool bad = !sameBits(twin[i], device[i]);
            if constexpr (std::is_same_v<T, float>) {
                if (std::isnan(twin[i]) || std::isnan(device[i])) bad = true, finite = false;
            }
            if (!bad) continue;
            ++plane.differing;
            if (within(i)) continue;
            ++plane.beyond;
            if (first < 0) first = int64_t(i);
        }
        report_.planes.push_back(plane);
        if (first < 0) return;
        const size_t pixel = size_t(first) / channels, width = report_.twin.frame.width;
        const size_t x = pixel % width, y = pixel / width;
        std::string values = fmt::format("twin has {}, device has {}", twin[size_t(first)], device[size_t(first)]);
        if constexpr (std::is_same_v<T, float>)
            values += fmt::format(", {} ULP{}", ulpDistance(twin[size_t(first)], device[size_t(first)]), finite ? "" : "; not a number");
        report_.mismatches.push_back(
            {name, true,
             fmt::format("tile ({}, {}), pixel ({}, {}): {}; object {}, primitive {}; {} values differ{}", x / gpu::kTileWidth,
                         y / gpu::kTileHeight, x, y, values, int(report_.twin.frame.object[pixel]),
                         int(report_.twin.frame.primitive[pixel]), plane.differing,
                         report_.bounded ? fmt::format(", {} beyond the bound", plane.beyond) : "")});
    }

    void compareRays(const RenderCounters& a, const RenderCounters& b) {
        const auto differ = [&](const std::string& name, uint64_t twin, uint64_t device) {
            if (twin != device)
                report_.mismatches.push_back({"counters", true, fmt::format("{}: twin counts {}, device {}", name, twin, device)});
        };
        differ("depths of rays", a.rays.size(), b.rays.size());
        for (size_t i = 0; i < std::min(a.rays.size(), b.rays.size()); ++i) {
            differ(fmt::format("primary rays of depth {}", i + 1), a.rays[i].primary, b.rays[i].primary);
            differ(fmt::format("reflected rays of depth {}", i + 1), a.rays[i].reflected, b.rays[i].reflected);
            differ(fmt::format("refracted rays of depth {}", i + 1), a.rays[i].refracted, b.rays[i].refracted);
            differ(fmt::format("feelers of depth {}", i + 1), a.rays[i].feelers, b.rays[i].feelers);
        }
        differ("refined pixels", a.refinedPixels, b.refinedPixels);
        differ("undecided rays", a.undecidedRays, b.undecidedRays);
    }

    // Every plane that a picture of this shading has.
    static uint32_t planesOf(Shading shading) {
        const uint32_t lines = kPlaneColour | kPlaneLinear | kPlaneObject | kPlanePrimitive;
        if (shading == Shading::wire) return lines;
        const uint32_t surfaces = lines | kPlaneZ | kPlaneDepth | kPlaneDistance | kPlaneNormal;
        return shading == Shading::ray ? surfaces : surfaces | kPlaneTriangle;  // rays meet more than triangles
    }

    void chain() {
        RenderRequest request = request_;
        request.planes = planesOf(request.shading);
        const bool rays = request.shading == Shading::ray;
        // The twin takes the first half of the progress.
        if (request_.onProgress) request.onProgress = [this](double done) { return request_.onProgress(done / 2); };
        report_.twin = renderCpu(scene_, request);
        if (request_.onProgress) request.onProgress = [this](double done) { return request_.onProgress((1 + done) / 2); };
        report_.device = renderGpu(device_, scene_, request);
        const Frame &t = report_.twin.frame, &d = report_.device.frame;
        const auto coverage = [](const Frame& f) {
            std::vector<uint32_t> c(f.object.size());
            for (size_t i = 0; i < c.size(); ++i) c[i] = f.object[i] != kNone;
            return c;
        };
        comparePlane("coverage", coverage(t), coverage(d), 1);
        forEachPlane([&](const auto& row, auto plane) {
            comparePlane(row.name, t.*plane, d.*plane, row.channels, [&](size_t i) {
                if (row.plane == kPlaneLinear) return asNear(t.linear[i], d.linear[i], i % 3);
                return row.plane == kPlaneColour && report_.bounded && colourAsNear(t.rgba[i], d.rgba[i], &t.linear[3 * i]);
            });
        });
        const RenderCounters &a = report_.twin.counters, &b = report_.device.counters;
        const std::pair<const char*, std::pair<uint64_t, uint64_t>> counts[] = {{"drawn triangles", {a.drawnTriangles, b.drawnTriangles}},
                                                                                {"back-facing", {a.culledBackFace, b.culledBackFace}},
                                                                                {"zero area", {a.culledZeroArea, b.culledZeroArea}},
                                                                                {"outside", {a.culledOutside, b.culledOutside}},
                                                                                {"clipped", {a.clipped, b.clipped}},
                                                                                {"illuminations", {a.illuminations, b.illuminations}},
                                                                                {"covered pixels", {t.coveredPixels, d.coveredPixels}}};
        for (const auto& [name, values] : counts)
            if (values.first != values.second)
                report_.mismatches.push_back(
                    {"counters", true, fmt::format("{}: twin counts {}, device {}", name, values.first, values.second)});
        compareRays(a, b);
        // One pass, on the scene itself: what it leaves is what the chain has compared.
        if (rays) report_.passes.push_back({"trace", report_.mismatches.empty()});
    }

    Device& device_;
    const Scene& scene_;
    RenderRequest request_;
    VerifyReport report_;
};

}  // namespace

VerifyReport verifyRender(Device& device, const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    return Verifier(device, scene, request).run();
}

}  // namespace plumb
