// SPDX-License-Identifier: MIT
#include "pipeline/truth/truth.h"

#include "host/error.h"
#include "pipeline/scene/shape.h"
#include "pipeline/truth/illumination.h"
#include "pipeline/truth/rays.h"
#include "pipeline/truth/solids.h"
#include "pipeline/truth/spheres.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <glm/glm.hpp>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using truth::Geometry;
using truth::Illumination;
using truth::Judge;
using truth::Pinhole;
using truth::SolidHit;
using truth::Solids;
using truth::Triangle;

constexpr uint32_t kBandRows = 8;          // pixels
constexpr double kCurveJoint = 0.0031308;  // of the curve of IEC 61966-2-1

// Mean of `count` samples and its bound: a rounding for each sum, and one for the quotient. The samples' values are not negative.
void setChannel(Truth& out, size_t at, double sum, double error, double count) {
    out.linear[at] = sum / count;
    const double bound = (error + (count + 1) * truth::kDoubleUnit * sum) / count * truth::kOwnRounding;
    out.bound[at] = bound <= std::numeric_limits<double>::max() ? bound : INFINITY;  // a NaN says no more
}

// Pixels whose truth is asked for.
struct Wanted {
    std::span<const uint8_t> pixels;  // empty: every one
    uint32_t width = 0;
    bool operator()(uint32_t x, uint32_t y) const { return pixels.empty() || pixels[size_t(y) * width + x] != 0; }
};

// Band of pixel rows: the visible triangle of each sample, then its colour.
class Band {
public:
    Band(const Scene& scene, const RenderRequest& request, const Geometry& geometry, const Solids& solids, const Illumination& illumination,
         uint32_t side, Wanted wanted, Truth& out)
        : scene_(scene),
          request_(request),
          geometry_(geometry),
          solids_(solids),
          illumination_(illumination),
          judge_(geometry),
          side_(side),
          wanted_(wanted),
          out_(out) {}

    void draw(uint32_t firstRow, uint32_t rows) {
        const int width = int(request_.width * side_), first = int(firstRow * side_), last = int((firstRow + rows) * side_) - 1;
        seen_.assign(size_t(width) * size_t(last - first + 1), kNone);
        const std::vector<Triangle>& triangles = geometry_.triangles();
        for (uint32_t t = 0; t < triangles.size(); ++t)
            for (int j = std::max(first, triangles[t].firstRow); j <= std::min(last, triangles[t].lastRow); ++j)
                for (int i = triangles[t].firstColumn; i <= std::min(triangles[t].lastColumn, width - 1); ++i) {
                    uint32_t& best = seen_[size_t(j - first) * size_t(width) + size_t(i)];
                    if (!wanted_(uint32_t(i) / side_, uint32_t(j) / side_)) continue;
                    if (!judge_.hits(t, x(i), y(j))) continue;
                    if (best == kNone || judge_.nearer(t, best, x(i), y(j))) best = t;
                }
        for (uint32_t row = 0; row < rows; ++row)
            for (uint32_t column = 0; column < request_.width; ++column)
                if (wanted_(column, firstRow + row)) resolve(column, firstRow + row, first);
    }
    void addTo(Truth& out) const {
        out.redone += judge_.redone() + counts_.redone;
        out.undecided += counts_.undecided;
    }

private:
    struct Sample {
        truth::BoundedColour colour;
        truth::Bounded w;
        uint32_t object = kNone, primitive = kNone;
        bool open = false;  // what is seen is open: the bounds say nothing
    };

    double x(int i) const { return geometry_.pinhole().x(i); }
    double y(int j) const { return geometry_.pinhole().y(j); }

    void resolve(uint32_t column, uint32_t row, int first) {
        const size_t at = size_t(row) * request_.width + column;
        glm::dvec3 sum(0), error(0);
        uint32_t covered = 0;
        for (uint32_t k = 0; k < side_ * side_; ++k) {
            const int i = int(column * side_ + k % side_), j = int(row * side_ + k / side_);
            const Sample seen = sampleAt(seen_[size_t(j - first) * request_.width * side_ + size_t(i)], x(i), y(j));
            if (seen.open) {
                out_.decided[at] = 0;
                error = glm::dvec3(INFINITY);
            }
            if (seen.object == kNone) {
                if (!request_.transparent) sum += glm::dvec3(request_.background);
                continue;
            }
            ++covered;
            sum += seen.colour.value;
            error += seen.colour.error;
            if (k % side_ != side_ / 2 || k / side_ != side_ / 2) continue;
            out_.depth[at] = seen.w.value;
            out_.depthBound[at] = seen.w.error;
            out_.object[at] = seen.object;
            out_.primitive[at] = seen.primitive;
        }
        const double count = request_.transparent ? std::max(covered, 1u) : side_ * side_;
        for (int c = 0; c < 3; ++c) setChannel(out_, 3 * at + size_t(c), sum[c], error[c], count);
        out_.alpha[at] = double(covered) / (side_ * side_);
    }

    // What is seen: triangle `t`, or a body in front of it.
    Sample sampleAt(uint32_t t, double x, double y) {
        const uint64_t before = counts_.undecided;
        Sample out = solids_.empty() ? triangleAt(t, x, y) : nearestAt(t, x, y);
        out.open = counts_.undecided != before;
        return out;
    }
    Sample triangleAt(uint32_t t, double x, double y) {
        if (t == kNone) return {};
        if (t != patchIndex_) patch_ = illumination_.patchOf(patchIndex_ = t);
        const Illumination::Seen seen = illumination_.at(patch_, x, y);
        const Triangle& triangle = geometry_.triangles()[t];
        const TriangleMesh& mesh = scene_.meshes[scene_.objects[triangle.object].mesh];
        return {seen.colour, seen.w, triangle.object, mesh.shape ? kNone : mesh.triangles[triangle.triangle].face};
    }
    Sample nearestAt(uint32_t t, double x, double y) {
        const SolidHit hit = solids_.look(x, y, counts_);
        if (hit.object == kNone || (t != kNone && !isNearer(hit, geometry_.triangles()[t], x, y))) return triangleAt(t, x, y);
        const truth::Direction toViewer =
            scene_.distantViewer.value_or(false)
                ? truth::Direction{-scene_.camera->forward, truth::kUnitVectorError}
                : truth::Direction{-glm::normalize(hit.position),
                                   truth::turnedBy(hit.positionError, glm::length(hit.position)) + truth::kUnitVectorError};
        return {illumination_.colourOf(hit.material, hit.position, hit.positionError, hit.normal, toViewer), hit.w, hit.object, kNone};
    }

    // True when the body is nearer than the triangle; at equal depth the smaller object is.
    bool isNearer(const SolidHit& hit, const Triangle& t, double x, double y) {
        const double w = hit.w.value, inverse = t.sa * x + t.sb * y + t.sc, difference = 1 / w - inverse;
        constexpr double kOwn = 16 * truth::kDoubleUnit;  // quotient, three products and sums
        const bool open = !(std::abs(difference) > (t.inverseError + hit.w.error / (w * w) + kOwn / w) * truth::kOwnRounding);
        counts_.undecided += open;
        return open ? hit.object < t.object : difference > 0;
    }

    const Scene& scene_;
    const RenderRequest& request_;
    const Geometry& geometry_;
    const Solids& solids_;
    const Illumination& illumination_;
    Judge judge_;
    Solids::Counts counts_;
    const uint32_t side_;
    const Wanted wanted_;
    Truth& out_;
    std::vector<uint32_t> seen_;  // visible triangle of each sample: index into geometry_.triangles()
    uint32_t patchIndex_ = kNone;
    Illumination::Patch patch_;
};

}  // namespace

void forgetFaces(Truth& truth, const std::vector<bool>& objects) {
    for (size_t at = 0; at < truth.object.size(); ++at)
        if (truth.object[at] < objects.size() && objects[truth.object[at]]) truth.primitive[at] = kNone;
}

double srgbCode(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return 255 * (x <= kCurveJoint ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

double srgbCodeError(double linear, double error) {
    // The evaluation of the curve: pow is within 4 u, its exponent 1 / 2.4 within 2 u, which |ln 0.0031308| / 2.4 makes 4.8 u, and eight roundings.
    constexpr double kOwn = 255 * 24 * truth::kDoubleUnit;
    // The curve is steepest below its joint, where its two parts do not quite meet: by 2.9e-8 of full scale.
    constexpr double kSteepest = 255 * 12.92, kStep = 255 * 3e-8;
    constexpr double kSmall = 0x1p-20;  // above it the codes of both ends say more than the slope
    const double step = std::abs(linear - kCurveJoint) <= error * 2 ? kStep : 0;
    if (error <= kSmall) return (error * kSteepest + kOwn) * truth::kOwnRounding + step;
    if (!(error < 1)) return std::max(srgbCode(linear), 255 - srgbCode(linear)) + kOwn;
    const double code = srgbCode(linear);
    return std::max(code - srgbCode(linear - error * truth::kOwnRounding), srgbCode(linear + error * truth::kOwnRounding) - code) +
           2 * kOwn + step;
}

namespace {

uint32_t sideOf(uint32_t samples) { return samples == 16 ? 4 : samples == 4 ? 2 : 1; }

// Draws bands of pixel rows on all threads. make() makes a thread's worker, which has draw(first row, rows) and addTo(out).
template <class Make>
void drawBands(const RenderRequest& request, Truth& out, const Make& make) {
    const uint32_t bands = (out.height + kBandRows - 1) / kBandRows;
    std::atomic<uint32_t> next{0}, finished{0};
    std::atomic<bool> stop{false};
    std::exception_ptr failure;
    std::mutex adding;
    const auto report = [&](uint32_t done) {
        if (request.onProgress && !request.onProgress(double(done) / bands)) throw Error(Exit::interrupted, "interrupted");
    };
    const auto work = [&](bool reports) {
        try {
            if (reports) report(finished);  // other threads may take all bands before this one gets any
            auto band = make();
            for (uint32_t b; !stop && (b = next.fetch_add(1)) < bands;) {
                band.draw(b * kBandRows, std::min(kBandRows, out.height - b * kBandRows));
                const uint32_t done = finished.fetch_add(1) + 1;
                if (reports) report(done);
            }
            const std::lock_guard lock(adding);
            band.addTo(out);
        } catch (...) {
            const std::lock_guard lock(adding);
            if (!failure) failure = std::current_exception();
            stop = true;
        }
    };
    {
        const uint32_t threads = std::min(bands, request.threads ? request.threads : std::max(1u, std::thread::hardware_concurrency()));
        std::vector<std::jthread> pool;
        for (uint32_t i = 1; i < threads; ++i) pool.emplace_back(work, false);
        work(true);
    }
    if (failure) std::rethrow_exception(failure);
}

// Positions at which rays pass through a pixel, from its upper left corner, in pixels. `anchor` is the one that the planes hold.
struct SamplePositions {
    std::vector<glm::dvec2> at;
    glm::dvec2 anchor{0};
};
SamplePositions positionsOf(const RenderRequest& request) {
    using Sampling = RayChoices::Sampling;
    const uint32_t side = sideOf(request.samples);
    SamplePositions p;
    double inSquare = 0.5;
    switch (request.rays.sampling) {
        case Sampling::grid:
        case Sampling::random:
            break;
        case Sampling::adaptive:
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) p.at.emplace_back((i + 0.5) / 4, (j + 0.5) / 4);
            return p;
        case Sampling::centre:
            p.at = {{0.5, 0.5}};
            p.anchor = p.at[0];
            return p;
        case Sampling::corners:
            p.at = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
            return p;
        case Sampling::notes:
            inSquare = 1;
            break;
    }
    for (uint32_t j = 0; j < side; ++j)
        for (uint32_t i = 0; i < side; ++i) p.at.emplace_back((i + inSquare) / side, (j + inSquare) / side);
    p.anchor = p.at[size_t(side / 2) * side + side / 2];
    return p;
}

// Result along one ray or at one point.
struct Sample {
    glm::dvec3 colour{0};  // linear RGB, not clamped; the sky's where nothing is seen
    uint32_t object = kNone, primitive = kNone;
    double depth = INFINITY;  // planar, scene units
    double leftOut = 0;       // weights of rays that were not followed
    glm::dvec3 error{0};      // of the colour
    double depthError = INFINITY;
    bool decided = true;
};

// Most rays of a picture, whatever it shows: glass among glass makes trees without end.
constexpr double kMostRaysOfPicture = 0x1p29;
truth::RayLimits limitsOf(const RenderRequest& request, const SamplePositions& positions) {
    truth::RayLimits limits;
    const double trees = double(request.width) * request.height * double(positions.at.size());
    limits.mostRays = uint32_t(std::clamp(kMostRaysOfPicture / trees, 64.0, double(limits.mostRays)));
    return limits;
}

// Samples of a picture by rays, for one thread.
class RayLooker {
public:
    RayLooker(const truth::RayWorld& world, const Pinhole& pinhole, const RenderRequest& request, const SamplePositions& positions)
        : pinhole_(pinhole), rays_(world, pinhole, glm::dvec3(request.background), limitsOf(request, positions)) {}

    // Sample at (x, y) of the screen from its middle, in pixels.
    Sample look(double x, double y) {
        const truth::RaySeen seen = rays_.look(x, y);
        const double cosine = pinhole_.focal / std::sqrt(x * x + y * y + pinhole_.focal * pinhole_.focal), depth = seen.distance * cosine;
        return {seen.colour,
                seen.object,
                seen.primitive,
                depth,
                seen.leftOut,
                seen.bound,
                seen.distanceError * cosine + 8 * truth::kDoubleUnit * depth,
                seen.decided};
    }
    void addTo(Truth& out) const {
        out.redone += rays_.redone();
        out.undecided += rays_.undecided();
    }

private:
    const Pinhole& pinhole_;
    truth::RayTruth rays_;
};

class SphereLooker {
public:
    SphereLooker(const Scene& scene, const truth::Illumination& illumination, const RenderRequest& request)
        : first_(uint32_t(scene.objects.size())), sky_(request.background), spheres_(scene, illumination) {}

    Sample look(double x, double y) {
        const truth::SphereTruth::Seen seen = spheres_.look(x, y);
        if (seen.sphere == kNone) return {sky_};
        return {seen.colour.value, first_ + seen.sphere, 0, seen.depth.value, 0, seen.colour.error, seen.depth.error};
    }
    void addTo(Truth& out) const { out.redone += spheres_.redone(); }

private:
    const uint32_t first_;  // number of the first sphere among the objects
    const glm::dvec3 sky_;
    truth::SphereTruth spheres_;
};

// Band of a picture whose samples are looked up one by one.
template <class Looker>
class SampleBand {
public:
    SampleBand(Looker looker, const Pinhole& pinhole, const RenderRequest& request, const SamplePositions& positions, Wanted wanted,
               Truth& out)
        : request_(request), pinhole_(pinhole), positions_(positions), looker_(std::move(looker)), wanted_(wanted), out_(out) {}

    void draw(uint32_t firstRow, uint32_t rows) {
        for (uint32_t y = firstRow; y < firstRow + rows; ++y)
            for (uint32_t x = 0; x < request_.width; ++x)
                if (wanted_(x, y)) pixel(x, y);
    }
    void addTo(Truth& out) const {
        looker_.addTo(out);
        out.leftOut = std::max(out.leftOut, leftOut_);
    }

private:
    void pixel(uint32_t x, uint32_t y) {
        const size_t at = size_t(y) * request_.width + x;
        glm::dvec3 sum(0), error(0);
        uint32_t covered = 0;
        double leftOut = 0;
        bool anchored = false, decided = true;
        for (const glm::dvec2& d : positions_.at) {
            const Sample seen = look(x, y, d);
            leftOut += seen.leftOut;
            covered += seen.object != kNone;
            decided = decided && seen.decided;
            if (!request_.transparent || seen.object != kNone) sum += seen.colour, error += seen.error;
            if (d != positions_.anchor) continue;
            anchored = true;
            write(at, seen);
        }
        if (!anchored) write(at, look(x, y, positions_.anchor));
        const double count = request_.transparent ? std::max(covered, 1u) : double(positions_.at.size());
        for (int c = 0; c < 3; ++c) setChannel(out_, 3 * at + size_t(c), sum[c], decided ? error[c] : INFINITY, count);
        out_.decided[at] = decided;
        out_.alpha[at] = double(covered) / double(positions_.at.size());
        leftOut_ = std::max(leftOut_, leftOut / double(positions_.at.size()));
    }
    Sample look(uint32_t x, uint32_t y, const glm::dvec2& d) {
        return looker_.look(x + d.x - pinhole_.width / 2, y + d.y - pinhole_.height / 2);
    }
    void write(size_t at, const Sample& seen) {
        if (seen.object == kNone) return;
        out_.depth[at] = seen.depth;
        out_.depthBound[at] = seen.depthError;
        out_.object[at] = seen.object;
        out_.primitive[at] = seen.primitive;
    }

    const RenderRequest& request_;
    const Pinhole& pinhole_;
    const SamplePositions& positions_;
    Looker looker_;
    const Wanted wanted_;
    Truth& out_;
    double leftOut_ = 0;
};

// Positions for the polygon fill of the notes, which works at whole coordinates. Pixel (x, y) is the point (x, y) of the screen, and
// samples lie around it.
SamplePositions aroundWholeCoordinates(uint32_t samples) {
    SamplePositions p;
    const uint32_t side = sideOf(samples);
    for (uint32_t j = 0; j < side; ++j)
        for (uint32_t i = 0; i < side; ++i) p.at.emplace_back((i + 0.5) / side - 0.5, (j + 0.5) / side - 0.5);
    return p;
}

// The scene with its teapots at their most segments, which are as near to the patches as a scene can come. None: it has none.
std::optional<Scene> withFinestPatches(const Scene& scene) {
    std::optional<Scene> out;
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
        const TriangleMesh& mesh = scene.meshes[i];
        if (!mesh.shape || mesh.shape->kind != ShapeKind::teapot) continue;
        if (!out) out = scene;
        out->meshes[i] = tessellated(mesh, segmentRangeOf(mesh.shape->kind).most, true);
    }
    return out;
}

}  // namespace

Truth truthOf(const Scene& scene, const RenderRequest& request, uint32_t drawnSamples, std::span<const uint8_t> wantedPixels) {
    PLUMB_ASSERT(scene.camera.has_value());
    PLUMB_ASSERT(wantedPixels.empty() || wantedPixels.size() == size_t(request.width) * request.height);
    if (request.shading == Shading::wire)
        throw usageError("a wire frame has no truth: its lines are a drawing, not the picture of a surface");
    if (request.samples != 1 && request.samples != 4 && request.samples != 16) throw usageError("--samples takes 1, 4 or 16");
    const auto begin = std::chrono::steady_clock::now();
    Truth out;
    out.width = request.width;
    out.height = request.height;
    out.samples = request.samples;
    const size_t pixels = size_t(out.width) * out.height;
    const Wanted wanted{wantedPixels, out.width};
    out.linear.assign(3 * pixels, 0.0);
    out.alpha.assign(pixels, 0.0);
    out.depth.assign(pixels, INFINITY);
    out.bound.assign(3 * pixels, 0.0);
    out.decided.assign(pixels, 1);
    out.depthBound.assign(pixels, INFINITY);
    out.object.assign(pixels, kNone);
    out.primitive.assign(pixels, kNone);
    out.traced = request.shading == Shading::ray;
    if (out.traced) {
        const Pinhole pinhole(*scene.camera, out.width, out.height, 1);
        const SamplePositions positions = positionsOf(request);
        out.samples = uint32_t(positions.at.size());
        const truth::RayWorld world(scene);
        drawBands(request, out,
                  [&] { return SampleBand(RayLooker(world, pinhole, request, positions), pinhole, request, positions, wanted, out); });
    } else if (request.fill == Fill::notes && !scene.spheres.empty()) {
        const Pinhole pinhole(*scene.camera, out.width, out.height, 1);
        const SamplePositions positions = aroundWholeCoordinates(request.samples);
        const Geometry geometry(scene, pinhole);
        const Illumination illumination(scene, geometry);
        drawBands(request, out,
                  [&] { return SampleBand(SphereLooker(scene, illumination, request), pinhole, request, positions, wanted, out); });
    } else {
        const uint32_t side = sideOf(request.samples), drawnSide = sideOf(drawnSamples == 0 ? request.samples : drawnSamples);
        const std::optional<Scene> finest = withFinestPatches(scene);
        const Scene& shown = finest ? *finest : scene;
        const Geometry geometry(
            shown, Pinhole(*scene.camera, out.width, out.height, side, request.fill == Fill::notes ? 0.5 * side / drawnSide : 0));
        const Solids solids(shown, geometry.pinhole());
        const Illumination illumination(shown, geometry);
        out.redone = geometry.redone();
        drawBands(request, out, [&] { return Band(shown, request, geometry, solids, illumination, side, wanted, out); });
    }
    out.timeMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return out;
}

}  // namespace plumb
