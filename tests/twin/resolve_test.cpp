// SPDX-License-Identifier: MIT
#include "pipeline/passes/resolve.h"

#include "pipeline/passes/encode.h"
#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <ostream>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

struct Row {
    uint32_t width, height, side;
    bool transparent;
    uint32_t encoding;
    uint32_t stride = 0;  // 0: side
};
std::ostream& operator<<(std::ostream& out, const Row& r) { return out << r.width << 'x' << r.height << " side " << r.side; }

class ResolveTwin : public OnDevice<::testing::TestWithParam<Row>> {};

TEST_P(ResolveTwin, LeavesTheSameBytes) {
    const Row& row = GetParam();
    const uint32_t stride = row.stride ? row.stride : row.side;
    const size_t width = size_t(row.width - 1) * stride + row.side, height = size_t(row.height - 1) * stride + row.side;
    Random r(47);
    std::vector<float> samples(3 * width * height);
    std::vector<int> z(width * height);
    const auto& thresholds = srgbThresholds();
    for (size_t i = 0; i < z.size(); ++i) {
        // Whole rows of pixels bare, whole rows covered, the rest mixed.
        const size_t y = i / width / row.side;
        z[i] = y % 5 == 0 ? 0 : y % 5 == 1 || r.below(2) ? 0x3f000000 + int(r.below(1000)) : 0;
        for (size_t k = 0; k < 3; ++k)
            samples[3 * i + k] = !z[i] ? 0.25f : r.below(4) == 0 ? thresholds[1 + r.below(255)] : float(r(-0.1, 1.3));
    }
    std::vector<float> pixels(3 * size_t(row.width) * row.height);
    std::vector<uint32_t> rgba(size_t(row.width) * row.height);
    resolveCpu(row.width, row.height, row.side, row.transparent, row.encoding, samples, z, pixels, rgba, 1, row.stride);

    const uint32_t sampleRowQuads = uint32_t((width + 15) / 16 * 4), planeQuads = sampleRowQuads * uint32_t((height + 7) / 8 * 8);
    std::vector<glm::uvec4> planes(size_t(planeQuads) * 5, glm::uvec4(0x7fc00000u));  // NaN where no sample is
    auto* words = &planes[0].x;
    const size_t plane = size_t(planeQuads) * 4;
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const size_t at = y * sampleRowQuads * 4 + x, i = y * width + x;
            words[at + plane] = uint32_t(z[i]);
            for (size_t k = 0; k < 3; ++k) words[at + (2 + k) * plane] = gpu::ubitsOf(samples[3 * i + k]);
        }
    for (const Specialization& exact : exactForms(device())) {
        gpu::ResolvePush push{};
        push.rowQuads = (row.width + 3) / 4;
        push.pixelQuads = push.rowQuads * row.height;
        push.sampleRowQuads = sampleRowQuads;
        push.samplePlaneQuads = planeQuads;
        push.zSlot = 1;
        push.linearSlot = 2;
        push.side = row.side;
        push.stride = stride;
        push.transparent = row.transparent;
        Recorder recorder(device());
        auto p = bufferOf(device(), planes);
        auto table = bufferOf(device(), srgbBucketTable());
        Buffer<glm::uvec4> colours(device(), push.pixelQuads + kSentinels, "pixels");
        Buffer<glm::vec4> linear(device(), 3 * push.pixelQuads + kSentinels, "linear");
        colours.fill(kSentinel);
        linear.fill(kSentinel);
        recordResolve(recorder, push, row.encoding, true, exact, p, table, colours, linear);
        recorder.run(kWatchdogMs);
        std::vector<uint32_t> got(rgba.size());
        std::vector<float> gotLinear(pixels.size());
        const auto* colourWords = static_cast<const uint32_t*>(colours.data());
        const auto* linearWords = static_cast<const float*>(linear.data());
        for (size_t i = 0; i < got.size(); ++i) {
            const size_t at = i / row.width * push.rowQuads * 4 + i % row.width;
            got[i] = colourWords[at];
            for (size_t k = 0; k < 3; ++k) gotLinear[3 * i + k] = linearWords[at + k * push.pixelQuads * 4];
        }
        expectSamePlane("resolve: colour", row.width, 1, rgba, got);
        expectSamePlane("resolve: linear", row.width, 3, pixels, gotLinear);
        expectSentinels("resolve: colour", colours, push.pixelQuads);
        expectSentinels("resolve: linear", linear, 3 * size_t(push.pixelQuads));
    }
}

std::vector<Row> rows() {
    std::vector<Row> all;
    for (auto [w, h] : {std::pair{1u, 1u}, {19u, 1u}, {1u, 19u}, {131u, 67u}})
        for (uint32_t side : {1u, 2u, 4u})
            for (bool transparent : {false, true})
                for (uint32_t encoding : {gpu::kEncodeSrgb, gpu::kEncodeLinear}) all.push_back({w, h, side, transparent, encoding});
    for (auto [w, h] : {std::pair{1u, 1u}, {19u, 1u}, {131u, 67u}})
        for (bool transparent : {false, true}) all.push_back({w, h, 2, transparent, gpu::kEncodeSrgb, 1});
    return all;
}
INSTANTIATE_TEST_SUITE_P(Rows, ResolveTwin, ::testing::ValuesIn(rows()), [](const auto& info) {
    const Row& r = info.param;
    return fmt::format("{}x{}_side{}{}_{}_{}", r.width, r.height, r.side, r.stride ? "_shared" : "",
                       r.transparent ? "transparent" : "opaque", r.encoding ? "linear" : "srgb");
});

}  // namespace
}  // namespace plumb::test
