// SPDX-License-Identifier: MIT
// Checks of the modules that draw no picture: the start-up self-test, the products of `plumb bench matrix`, and the questions of
// `plumb devices --fingerprint`.
#include "host/binary64.h"
#include "host/recorder.h"
#include "host/selftest.h"
#include "pipeline/bench/products.h"
#include "pipeline/fingerprint/fingerprint.h"
#include "pipeline/passes/long_rows.h"
#include "pipeline/suite/scenes.h"
#include "pipeline/suite/suite.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb::suite {

namespace {

constexpr uint64_t kVertices = 1025;
constexpr uint32_t kQuestions = 1024;
constexpr uint32_t kLastField = 255;  // exponent field of infinities and NaN, whose results are known at once

std::string selfTest(Device& device) {
    const SelfTest verdict = runSelfTest(device, false);
    if (!verdict.failure.empty()) return verdict.failure;
    return device.limits().float64 ? lacksBinary64(device) : std::string();
}

gpu::Rows rowsOf(Random& r) {
    gpu::Rows m;
    for (glm::vec4* row : {&m.r0, &m.r1, &m.r2, &m.r3}) *row = {float(r(-1, 1)), float(r(-1, 1)), float(r(-1, 1)), float(r(-1, 1))};
    return m;
}

// Compares bits, so that a NaN is equal to itself and 0 differs from -0.
template <class T>
bool sameBytes(const T& a, const T& b) {
    return std::ranges::equal(std::as_bytes(std::span(&a, 1)), std::as_bytes(std::span(&b, 1)));
}

// Runs `record`, and compares what it leaves with the twin's vertices.
template <class Record>
std::string verticesDiffer(Device& device, const char* what, std::span<const glm::vec4> want, const Record& record) {
    Buffer<gpu::VertexPair> out(device, pairsOf(want.size()), "results");
    out.fill(0);
    Recorder recorder(device);
    record(recorder, out);
    recorder.run();
    const std::span<const glm::vec4> got = verticesOf(out, want.size());
    for (size_t i = 0; i < want.size(); ++i)
        if (!sameBytes(want[i], got[i]))
            return fmt::format("{}: vertex {}: twin has ({}, {}, {}, {}), device has ({}, {}, {}, {})", what, i, want[i].x, want[i].y,
                               want[i].z, want[i].w, got[i].x, got[i].y, got[i].z, got[i].w);
    return "";
}

std::string products(Device& device) {
    Random r(37);
    std::vector<gpu::Rows> some;
    for (uint32_t i = 0; i < gpu::kMostMatrices; ++i) some.push_back(rowsOf(r));
    std::vector<glm::vec4> vertices(kVertices), want(kVertices);
    for (glm::vec4& v : vertices) v = {float(r(-1, 1)), float(r(-1, 1)), float(r(-1, 1)), 1.0f};
    Buffer<glm::vec4> in(device, kVertices, "vertices");
    Buffer<gpu::Rows> matrices(device, some.size(), "matrices");
    in.upload(vertices);
    matrices.upload(some);
    verticesCpu(some, vertices, want, 1);
    std::string wrong = verticesDiffer(device, "seven matrices", want, [&](Recorder& recorder, const auto& out) {
        recordVertices(recorder, device.limits(), uint32_t(some.size()), kVertices, in, matrices, out);
    });
    if (!wrong.empty()) return wrong;
    const int exponent = blockExponent(1);
    const gpu::LongRecord record{longRow({0.1, -0.7, 1.0 / 3, 5.0 / 7}, exponent), longRow({-1.0 / 9, 1e-9, 0.4, -3}, exponent),
                                 longRow({0.6, 0.2, -0.1, 1e-3}, exponent), float(std::ldexp(1.0, -exponent))};
    Buffer<gpu::LongRecord> composite(device, 1, "long rows");
    composite.upload(std::span(&record, 1));
    for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
        if (precision == Precision::fp64 && !lacksBinary64(device).empty()) continue;
        longVerticesCpu(precision, record, vertices, want, 1);
        wrong =
            verticesDiffer(device, precision == Precision::fp64 ? "binary64" : "integers", want, [&](Recorder& recorder, const auto& out) {
                recordLongVertices(recorder, device.limits(), precision, kVertices, in, composite, out);
            });
        if (!wrong.empty()) return wrong;
    }
    return "";
}

std::string chain(Device& device) {
    constexpr uint32_t kPerLane = 4;
    Random r(41);
    std::vector<gpu::Rows> factors(kVertices), want((kVertices + kPerLane - 1) / kPerLane);
    for (gpu::Rows& m : factors) m = rowsOf(r);
    chainLevelCpu(Level::products, kPerLane, factors, want, 1);
    Buffer<gpu::Rows> in(device, factors.size(), "factors"), out(device, want.size(), "products");
    in.upload(factors);
    Recorder recorder(device);
    recordChainLevel(recorder, device.limits(), Level::products, kPerLane, factors.size(), in, out);
    recorder.run();
    for (size_t i = 0; i < want.size(); ++i)
        if (!sameBytes(want[i], out.span()[i])) return fmt::format("product {} differs from the twin's", i);
    return "";
}

// A fingerprint judges nothing here: a device may answer as it likes, but it answers all questions, and twice alike.
std::string fingerprint(Device& device) {
    namespace fp = plumb::fingerprint;
    const fp::Fingerprint first = fp::ask(device, kQuestions), second = fp::ask(device, kQuestions);
    for (size_t i = 0; i < first.answers.size(); ++i) {
        if (!first.answers[i].failure.empty()) return fmt::format("{}: {}", fp::traits()[i].name, first.answers[i].failure);
        if (first.answers[i].words != second.answers[i].words)
            return fmt::format("{}: the device answers the same questions in two ways", fp::traits()[i].name);
    }
    for (const fp::Sweep& sweep : fp::sweep(device, 1, {}, {kLastField}))
        if (!sweep.failure.empty()) return fmt::format("{}: {}", sweep.trait, sweep.failure);
    return "";
}

constexpr ModuleTest kModules[] = {
    {"self-test", selfTest},
    {"products", products},
    {"chain", chain},
    {"fingerprint", fingerprint},
    {"plain-products", products, kPlainLimits},
};

}  // namespace

std::span<const ModuleTest> moduleTests() { return kModules; }

}  // namespace plumb::suite
