// SPDX-License-Identifier: MIT
#include "pipeline/bench/products.h"

#include "pipeline/passes/long_rows.h"
#include "tests/support/device_fixture.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <memory>
#include <random>
#include <span>
#include <vector>

namespace plumb::test {
namespace {

constexpr uint32_t kUntouched = 0x7fc0beefu;  // NaN: a place that nobody wrote

std::vector<gpu::Rows> someMatrices(size_t count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> entry(-1, 1);
    std::vector<gpu::Rows> matrices(count);
    for (gpu::Rows& m : matrices)
        for (glm::vec4* row : {&m.r0, &m.r1, &m.r2, &m.r3})
            *row = glm::vec4(entry(random), entry(random), entry(random), entry(random)) * 0.9f;
    return matrices;
}

std::vector<glm::vec4> someVertices(size_t count) {
    std::mt19937 random(8);
    std::uniform_real_distribution<float> within(-1, 1);
    std::vector<glm::vec4> vertices(count);
    for (glm::vec4& v : vertices) v = {within(random), within(random), within(random), 1.0f};
    return vertices;
}

gpu::LongRecord someLongRecord() {
    const int exponent = blockExponent(1);
    return {longRow({0.1, -0.7, 1.0 / 3, 5.0 / 7}, exponent), longRow({-1.0 / 9, 1e-9, 0.4, -3}, exponent),
            longRow({0.6, 0.2, -0.1, 1e-3}, exponent), float(std::ldexp(1.0, -exponent))};
}

// Alone, the ends of a pair, an invocation's share, a workgroup and beyond, and more than one dispatch under small limits.
constexpr uint64_t kCounts[] = {1, 2, 15, 16, 17, 1023, 1024, 1025, 70001};

class ProductsTwin : public OnDevice<::testing::TestWithParam<const char*>> {
protected:
    void SetUp() override {
        OnDevice::SetUp();
        if (*GetParam()) limited_ = DeviceEnvironment::open(GetParam());
    }
    void TearDown() override {
        if (limited_) expectNoValidationMessages(*limited_);
        OnDevice::TearDown();
    }
    Device& device() { return limited_ ? *limited_ : OnDevice::device(); }

    // What `record` leaves: `count` results that are `want`, the odd one's neighbour, and nothing behind.
    template <class Record>
    void expectVertices(const char* what, std::span<const glm::vec4> vertices, std::span<const glm::vec4> want, const Record& record) {
        const uint64_t count = vertices.size();
        Buffer<glm::vec4> in(device(), count, "vertices");
        Buffer<gpu::VertexPair> out(device(), pairsOf(count) + 1, "results");
        in.upload(vertices);
        out.fill(kUntouched);
        Recorder recorder(device());
        record(recorder, in, out);
        recorder.run();
        ASSERT_EQ(want.size(), count);
        EXPECT_EQ(std::memcmp(out.data(), want.data(), want.size_bytes()), 0) << what << " of " << count;
        const auto* behind = reinterpret_cast<const uint32_t*>(out.span().data() + pairsOf(count));
        for (size_t i = 0; i < sizeof(gpu::VertexPair) / 4; ++i)
            EXPECT_EQ(behind[i], kUntouched) << what << " of " << count << " wrote behind its results";
    }

private:
    std::unique_ptr<Device> limited_;
};

TEST_P(ProductsTwin, VerticesLeaveTheSameBytes) {
    const std::vector<gpu::Rows> seven = someMatrices(gpu::kMostMatrices);
    Buffer<gpu::Rows> matrices(device(), seven.size(), "matrices");
    matrices.upload(seven);
    for (const uint64_t count : kCounts) {
        const std::vector<glm::vec4> vertices = someVertices(count);
        std::vector<glm::vec4> want(count);
        for (uint32_t n = 0; n <= gpu::kMostMatrices; ++n) {
            verticesCpu(std::span(seven).first(n), vertices, want, 2);
            expectVertices("products", vertices, want, [&](Recorder& r, const auto& in, const auto& out) {
                recordVertices(r, device().limits(), n, count, in, matrices, out);
            });
        }
        for (uint64_t i = 0; i < count; ++i) want[i] = gpu::markOf(seven[0], uint32_t(i % verticesPerDispatch(device().limits())));
        expectVertices("marks", vertices, want,
                       [&](Recorder& r, const auto& in, const auto& out) { recordMarks(r, device().limits(), count, in, matrices, out); });
    }
}

TEST_P(ProductsTwin, MoreAccurateVerticesLeaveTheSameBytes) {
    const gpu::LongRecord record = someLongRecord();
    Buffer<gpu::LongRecord> composite(device(), 1, "long rows");
    composite.upload(std::span(&record, 1));
    for (const uint64_t count : kCounts)
        for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
            const std::vector<glm::vec4> vertices = someVertices(count);
            std::vector<glm::vec4> want(count);
            longVerticesCpu(precision, record, vertices, want, 2);
            expectVertices(precision == Precision::fp64 ? "binary64" : "integers", vertices, want,
                           [&](Recorder& r, const auto& in, const auto& out) {
                               recordLongVertices(r, device().limits(), precision, count, in, composite, out);
                           });
        }
}

TEST_P(ProductsTwin, LevelsOfAChainLeaveTheSameBytes) {
    for (const uint32_t perLane : {2u, 3u, 4u, 5u, 6u, 7u, 1024u})
        for (const uint64_t count : {1, 2, 3, 4, 5, 6, 7, 8, 9, 1023, 1024, 1025, 1026, 1027, 1028, 20003})
            for (const Level level : {Level::products, Level::sums}) {
                const std::vector<gpu::Rows> chain = someMatrices(count);
                const uint64_t lanes = (count + perLane - 1) / perLane;
                Buffer<gpu::Rows> in(device(), count, "chain"), out(device(), lanes + 1, "products");
                in.upload(chain);
                out.fill(kUntouched);
                std::vector<gpu::Rows> want(lanes);
                chainLevelCpu(level, perLane, chain, want, 2);
                Recorder recorder(device());
                recordChainLevel(recorder, device().limits(), level, perLane, count, in, out);
                recorder.run();
                EXPECT_EQ(std::memcmp(out.data(), want.data(), lanes * sizeof(gpu::Rows)), 0) << count << " by " << perLane;
                EXPECT_EQ(*reinterpret_cast<const uint32_t*>(&out.span()[lanes]), kUntouched)
                    << count << " by " << perLane << " wrote behind its products";
            }
}

// Without words of 64 bits other modules run; a small binding cuts the work into dispatches.
INSTANTIATE_TEST_SUITE_P(Devices, ProductsTwin, ::testing::Values("", "int64=0", "storageRange=262144"));

}  // namespace
}  // namespace plumb::test
