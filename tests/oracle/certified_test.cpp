// SPDX-License-Identifier: MIT
// Certificates of pictures against real arithmetic: colours of single pixels are computed anew in 64 bits, and in binary128 where those do not settle
// it, by code that shares nothing with the truth (real_picture.h, real_rays.h). No colour may be further from the truth than the truth's own bound says,
// and no drawn byte further from the real picture than its certificate.
// The seed is printed; PLUMB_SEED states another, PLUMB_CASE runs that case alone. PLUMB_LONG=1 judges 10^8 pixels and searches longer.
#include "pipeline/truth/certificate.h"
#include "tests/oracle/certified_scenes.h"
#include "tests/oracle/real_rays.h"
#include "tests/support/ray_scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <glm/glm.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using oracle::Long;
using oracle::RealSample;
using oracle::Wide;
using test::Random;

uint64_t numberOf(const char* name, uint64_t otherwise) {
    const char* stated = std::getenv(name);
    return stated ? std::strtoull(stated, nullptr, 10) : otherwise;
}
bool isLong() { return std::getenv("PLUMB_LONG") != nullptr; }

// The 64 bits of x87 are near enough where less than this share of a bound is used: they round 2^11 times as finely as the truth does.
constexpr double kSettled = 0.5;

struct Tally {
    uint64_t pixels = 0;        // judged
    uint64_t shown = 0;         // that show more than the background
    uint64_t beside = 0;        // so close to a decision that binary128 leaves it open here
    uint64_t open = 0;          // of which the truth says nothing
    uint64_t wide = 0;          // computed in binary128
    uint64_t halfStep = 0;      // certified to half a step
    double worst = 0;           // largest error of the truth in shares of its bound, linear light
    double worstCode = 0;       // the same in steps of the code
    double worstOfPicture = 0;  // largest error of a byte in shares of its certificate
    void add(const Tally& other) {
        pixels += other.pixels, shown += other.shown, beside += other.beside, open += other.open, wide += other.wide,
            halfStep += other.halfStep;
        worst = std::max(worst, other.worst);
        worstCode = std::max(worstCode, other.worstCode);
        worstOfPicture = std::max(worstOfPicture, other.worstOfPicture);
    }
    void print(const std::string& what) const {
        fmt::print(
            "{}: {} pixels, {} of them background, {} in binary128, {} beside a decision, {} open; {:.2f} % certified to half a step; "
            "error of "
            "the truth at most {:.3g} of its bound, {:.3g} in steps; error of a byte at most {:.9f} of its certificate\n",
            what, pixels, pixels - shown, wide, beside, open, pixels == 0 ? 0 : 100 * double(halfStep) / double(pixels), worst, worstCode,
            worstOfPicture);
    }
};

// Mean of a raster pixel's samples in real arithmetic; what is seen is that of sample `anchor`.
template <class N>
RealSample<N> meanOf(const std::vector<RealSample<N>>& samples, uint32_t anchor, const glm::vec3& background) {
    RealSample<N> mean = samples[anchor];
    mean.colour = {};
    for (const RealSample<N>& s : samples) {
        mean.sure = mean.sure && s.sure;
        mean.colour = mean.colour + (s.object == kNone ? oracle::Triple<N>(background) : s.colour);
    }
    mean.colour = (N(1) / N(double(samples.size()))) * mean.colour;
    return mean;
}

// Holds pixels of one picture against real arithmetic.
class Judge {
public:
    Judge(const Scene& scene, const RenderRequest& request, std::vector<uint8_t> wanted, Tally& tally)
        : scene_(scene),
          request_(request),
          wanted_(std::move(wanted)),
          side_(request.shading == Shading::ray ? 1 : uint32_t(std::lround(std::sqrt(request.samples)))),
          frame_(renderCpu(scene, request).frame),
          truth_(truthOf(scene, request, 0, wanted_)),
          certificate_(certificateOf(frame_, truth_, request.encoding, false)),
          tally_(tally) {}

    void run() {
        for (size_t at = 0; at < truth_.object.size() && !testing::Test::HasFailure(); ++at)
            if (wanted_.empty() || wanted_[at] != 0) judge(at);
    }

private:
    template <class N>
    struct Real {
        std::unique_ptr<oracle::RealRaster<N>> raster;
        std::unique_ptr<oracle::RealRays<N>> rays;
    };

    template <class N>
    RealSample<N> real(size_t at) {
        const uint32_t x = uint32_t(at % request_.width), y = uint32_t(at / request_.width);
        std::vector<RealSample<N>> samples;
        Real<N>& own = std::get<Real<N>>(real_);
        if (request_.shading == Shading::ray) {
            if (!own.rays)
                own.rays = std::make_unique<oracle::RealRays<N>>(scene_, request_.width, request_.height, glm::dvec3(request_.background));
            return own.rays->look(x, y);
        }
        if (!own.raster) own.raster = std::make_unique<oracle::RealRaster<N>>(scene_, request_.width, request_.height, side_);
        for (uint32_t k = 0; k < side_ * side_; ++k)
            samples.push_back(own.raster->look(int(x * side_ + k % side_), int(y * side_ + k / side_)));
        return meanOf(samples, side_ / 2 * side_ + side_ / 2, request_.background);
    }

    // Shares of the bounds that one pixel uses; above 1 is a violation.
    struct Used {
        double linear = 0, code = 0, picture = 0, depth = 0;
        bool sameFace = true;
        double most() const { return sameFace ? std::max({linear, code, depth}) : INFINITY; }
    };
    // Distance to an interval.
    template <class N>
    static N beyond(const N& x, const N& low, const N& high) {
        return x < low ? low - x : x > high ? x - high : N(0);
    }
    template <class N>
    Used usedBy(size_t at, const RealSample<N>& real) const {
        Used used;
        const uint32_t face = real.object == kNone ? kNone : real.face;
        used.sameFace = truth_.object[at] == real.object && truth_.primitive[at] == face;
        const auto share = [](N error, double bound) { return error == 0 ? 0.0 : double(error / N(bound)); };
        for (int c = 0; c < 3; ++c) {
            const size_t i = 3 * at + size_t(c);
            // Rays that were left out brighten, so the picture lies anywhere between.
            const N low = real.colour.at(c), high = low + real.allowance, lowCode = oracle::codeOf(low), highCode = oracle::codeOf(high);
            used.linear = std::max(used.linear, share(beyond(N(truth_.linear[i]), low, high), truth_.bound[i]));
            used.code = std::max(used.code, share(beyond(N(srgbCode(truth_.linear[i])), lowCode, highCode),
                                                  srgbCodeError(truth_.linear[i], truth_.bound[i])));
            const N byte = N(int(frame_.rgba[at] >> (8 * c) & 0xff));
            const N drawn = request_.encoding == Encoding::srgb ? byte : oracle::codeOf(byte / 255);
            used.picture = std::max(used.picture, share(beyond(drawn, lowCode, highCode), double(certificate_.steps[at])));
        }
        if (real.object != kNone && request_.shading != Shading::ray)
            used.depth = share(oracle::magnitude(real.depth - N(truth_.depth[at])), truth_.depthBound[at]);
        return used;
    }

    void judge(size_t at) {
        if (truth_.decided[at] == 0 || !std::isfinite(truth_.bound[3 * at])) {
            ++tally_.open;
            EXPECT_EQ(certificate_.grades[at], uint32_t(Grade::open));
            EXPECT_TRUE(std::isinf(certificate_.steps[at]));
            return;
        }
        const RealSample<Long> quick = real<Long>(at);
        Used used = quick.sure ? usedBy(at, quick) : Used{};
        if (!quick.sure || !(used.most() < kSettled) || !(used.picture < 1)) {
            ++tally_.wide;
            const RealSample<Wide> slow = real<Wide>(at);
            if (!slow.sure) {
                ++tally_.beside;
                return;
            }
            used = usedBy(at, slow);
        }
        ++tally_.pixels;
        tally_.shown += truth_.object[at] != kNone;
        tally_.halfStep += certificate_.grades[at] == uint32_t(Grade::halfStep);
        tally_.worst = std::max(tally_.worst, used.linear);
        tally_.worstCode = std::max(tally_.worstCode, used.code);
        tally_.worstOfPicture = std::max(tally_.worstOfPicture, used.picture);
        const std::string where = fmt::format("{}, pixel ({}, {})", scene_.path, at % request_.width, at / request_.width);
        EXPECT_TRUE(used.sameFace) << where;
        EXPECT_LE(used.linear, 1) << where;
        EXPECT_LE(used.code, 1) << where;
        EXPECT_LE(used.depth, 1) << where;
        EXPECT_LE(used.picture, 1) << where;
    }

    const Scene& scene_;
    const RenderRequest& request_;
    const std::vector<uint8_t> wanted_;
    const uint32_t side_;
    const Frame frame_;
    const Truth truth_;
    const Certificate certificate_;
    Tally& tally_;
    std::tuple<Real<Long>, Real<Wide>> real_;
};

RenderRequest requestOf(uint32_t width, uint32_t height, Shading shading) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.shading = shading;
    r.planes = kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
    r.threads = 1;
    return r;
}

std::vector<uint8_t> someOf(const RenderRequest& request, uint32_t count, Random& random) {
    std::vector<uint8_t> wanted(size_t(request.width) * request.height);
    for (uint32_t i = 0; i < count; ++i) wanted[random.below(uint32_t(wanted.size()))] = 1;
    return wanted;
}

// Few pixels may lie beside a decision: the rest is judged. Glass among glass spreads any error until a tree of rays has such a decision somewhere.
constexpr uint64_t kBesideOf = 100, kBesideOfGlass = 20;
void expectMostJudged(const Tally& tally, uint64_t of = kBesideOf) { EXPECT_LE(tally.beside, 1 + (tally.pixels + tally.beside) / of); }
// Bounds that nothing comes near to would hold for a truth that is wrong, too: something uses at least this much of them.
constexpr double kLeastUsed = 0x1p-7;

TEST(Certified, CommittedScenesInEveryRasterShading) {
    Random random(uint32_t(numberOf("PLUMB_SEED", 1)));
    Tally tally;
    for (const char* file : {"suzanne.toml", "cornell.toml", "pyramid.toml", "still-life.toml"})
        for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
            Scene scene = loadScene({std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes" / file}, {});
            const glm::uvec2 size = scene.size.x != 0 && scene.camera && scene.camera->focalPixels > 0 ? scene.size : glm::uvec2(160, 120);
            completeScene(scene, size, "", false);
            RenderRequest request = requestOf(size.x, size.y, shading);
            request.samples = shading == Shading::phong ? 4 : 1;
            request.encoding = shading == Shading::gouraud ? Encoding::linear : Encoding::srgb;
            request.background = {0.25f, 0.5f, 0.125f};
            Judge(scene, request, someOf(request, isLong() ? 2000 : 60, random), tally).run();
            if (HasFailure()) return;
        }
    tally.print("committed scenes");
    expectMostJudged(tally);
    EXPECT_EQ(tally.open, 0u);
    EXPECT_GT(tally.worst, kLeastUsed);
}

// Random scenes, one picture each. PLUMB_LONG judges every pixel, else some of each picture.
template <class Make>
Tally judgeRandom(const char* what, uint64_t plain, uint64_t thorough, uint32_t some, const Make& make) {
    const uint64_t seed = numberOf("PLUMB_SEED", 1), only = numberOf("PLUMB_CASE", UINT64_MAX), count = isLong() ? thorough : plain;
    fmt::print("{}: seed {}, {} pictures\n", what, seed, only == UINT64_MAX ? count : 1);
    Tally all;
    std::mutex adding;
    std::atomic<uint64_t> next{0};
    const auto work = [&] {
        Tally own;
        for (uint64_t i; (i = next.fetch_add(1)) < count && !testing::Test::HasFailure();) {
            if (only != UINT64_MAX && i != only) continue;
            SCOPED_TRACE(fmt::format("PLUMB_SEED={} PLUMB_CASE={}", seed, i));
            Random random(uint32_t(seed * 1000003u + i));
            test::Genes genes(random);
            const auto& [scene, request] = make(genes);
            Judge(scene, request, isLong() ? std::vector<uint8_t>{} : someOf(request, some, random), own).run();
        }
        const std::lock_guard lock(adding);
        all.add(own);
    };
    {
        std::vector<std::jthread> pool;
        for (uint32_t i = 1; i < std::thread::hardware_concurrency(); ++i) pool.emplace_back(work);
        work();
    }
    all.print(what);
    return all;
}
std::pair<Scene, RenderRequest> trianglesOf(test::Genes& genes, uint32_t width, uint32_t height) {
    const Scene scene = test::randomTriangles(genes);
    RenderRequest request = requestOf(width, height, genes.below(2) ? Shading::phong : Shading::gouraud);
    request.encoding = genes.below(4) == 0 ? Encoding::linear : Encoding::srgb;
    request.background = glm::vec3(float(genes(0, 1)), 0.5f, 0);
    return {scene, request};
}
std::pair<Scene, RenderRequest> tracedOf(test::Genes& genes, uint32_t width, uint32_t height) {
    const Scene scene = test::randomTraced(genes);
    RenderRequest request = requestOf(width, height, Shading::ray);
    request.maxDepth = 8;
    request.background = glm::vec3(float(genes(0, 1)), 0.5f, 0);
    return {scene, request};
}

TEST(Certified, RandomTrianglesUnderEveryLight) {
    // 8.2e7 pixels in the long run: 8000 pictures of 128 x 80.
    const Tally tally = judgeRandom("random triangles", 24, 8000, 400, [](test::Genes& genes) { return trianglesOf(genes, 128, 80); });
    expectMostJudged(tally);
    EXPECT_GT(tally.worst, kLeastUsed);
}

TEST(Certified, RandomTracedScenes) {
    // 2e7 pixels in the long run.
    const Tally tally = judgeRandom("random traced scenes", 12, 20000, 100, [](test::Genes& genes) { return tracedOf(genes, 40, 25); });
    expectMostJudged(tally, kBesideOfGlass);
    EXPECT_GT(tally.worst, kLeastUsed);
}

// A mirror of a mesh whose ray leaves along the polygon, followed again in 64 bits: the normal that bends it was once as long as binary64 has it.
TEST(Certified, ARayAlongAPolygonIsAsExactAsItsBoundSays) {
    Random random(1000003u + 9042);
    test::Genes genes(random);
    const auto& [scene, request] = tracedOf(genes, 40, 25);
    std::vector<uint8_t> wanted(size_t(40) * 25);
    wanted[size_t(13) * 40 + 15] = 1;
    Tally tally;
    Judge(scene, request, wanted, tally).run();
    EXPECT_EQ(tally.pixels, 1u);
}

TEST(Certified, TracedScenes) {
    Random random(uint32_t(numberOf("PLUMB_SEED", 1)));
    const uint32_t pixels = isLong() ? 2000 : 120;
    Tally all;
    for (const auto& [name, made] : {std::pair("mirrors", test::mirrors()), std::pair("glass", test::glass()),
                                     std::pair("closeOutside", test::closeOutside()), std::pair("meshes", test::meshesAmongMirrors())}) {
        Scene scene = made;
        scene.path = name;
        RenderRequest request = requestOf(160, 120, Shading::ray);
        request.background = *scene.background;
        request.maxDepth = scene.maxDepth;
        Tally tally;
        Judge(scene, request, someOf(request, scene.objects.empty() ? pixels : pixels / 16, random), tally).run();
        if (HasFailure()) return;
        tally.print(name);
        expectMostJudged(tally, kBesideOfGlass);
        all.pixels += tally.pixels, all.open += tally.open;
    }
    EXPECT_GT(all.pixels, 8 * all.open);
}

// A search that moves the numbers of scenes to bring an error as near to its bound as it can.
template <class Make>
double searched(const char* what, uint32_t tries, uint32_t perStart, const Make& make) {
    Random random(uint32_t(numberOf("PLUMB_SEED", 1)) + 77);
    double worst = 0, best = 0;
    uint64_t pixels = 0;
    test::Genes kept(random);
    for (uint32_t i = 0; i < tries && !testing::Test::HasFailure(); ++i) {
        if (i % perStart == 0) kept = test::Genes(random), best = 0;
        test::Genes genes = kept;
        genes.mutate();
        genes.restart();
        const auto& [scene, request] = make(genes);
        Tally tally;
        Judge(scene, request, {}, tally).run();
        pixels += tally.pixels;
        const double used = std::max(tally.worst, tally.worstCode);
        worst = std::max(worst, used);
        if (used >= best) best = used, kept = genes;
    }
    fmt::print("search, {}: {} scenes, {} pixels, largest error {:.4f} of its bound\n", what, tries, pixels, worst);
    return worst;
}

TEST(Certified, ASearchFindsNoErrorAboveItsBound) {
    const uint32_t tries = isLong() ? 40000 : 120;
    const double raster = searched("triangles", tries, isLong() ? 2000 : 60, [](test::Genes& g) { return trianglesOf(g, 24, 15); });
    const double traced = searched("traced", tries / 4, isLong() ? 500 : 15, [](test::Genes& g) { return tracedOf(g, 12, 8); });
    EXPECT_LT(std::max(raster, traced), 1);
    EXPECT_GT(raster, kLeastUsed);
}

}  // namespace
}  // namespace plumb
