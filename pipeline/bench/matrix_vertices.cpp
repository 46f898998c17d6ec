// SPDX-License-Identifier: MIT
// Vertices by one composite and by seven matrices.
#include "pipeline/bench/matrix_ways.h"
#include "pipeline/bench/peers.h"
#include "pipeline/bench/products.h"
#include "pipeline/passes/long_rows.h"
#include "pipeline/passes/parallel.h"

#include "host/binary64.h"

#include <fmt/core.h>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/glm.hpp>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using Kind = Way::Kind;
constexpr uint32_t kMatrices = gpu::kMostMatrices;

// Rows x, y and w for the more accurate transforms, for vertices within [-1, 1]; the third coordinate of a motion stands for w.
gpu::LongRecord longRecordOf(const glm::dmat4& m) {
    const int exponent = blockExponent(1);
    const glm::dmat4 rows = glm::transpose(m);
    return {longRow(rows[0], exponent), longRow(rows[1], exponent), longRow(rows[2], exponent), float(std::ldexp(1.0, -exponent))};
}

double errorOfVertices(std::span<const glm::vec4> got, std::span<const glm::dvec4> exact) {
    double most = 0;
    for (size_t i = 0; i < got.size(); ++i) {
        const double error = errorOf(&got[i].x, &exact[i].x, 4);
        if (!(error <= most)) most = error;
    }
    return most;
}

class VertexBench {
public:
    VertexBench(Device& device, uint64_t count, const MatrixOptions& options)
        : device_(device),
          count_(count),
          options_(options),
          threads_(threadsOf(options)),
          in_(device, count, "vertices"),
          out_(device, pairsOf(count), "results"),
          one_(device, 1, "matrix"),
          seven_(device, kMatrices, "matrices"),
          long_(device, 1, "long rows"),
          recorder_(device),
          vertices_(std::as_const(in_).span()),
          results_(verticesOf(out_, count)),
          twin_(count),
          wanted_(count) {}
    VertexBench(const VertexBench&) = delete;
    VertexBench& operator=(const VertexBench&) = delete;

    MatrixTable run() {
        table_.work = "vertices";
        table_.count = count_;
        table_.bytesEach = 2 * sizeof(glm::vec4);
        table_.ceiling = "device, load and store alone";
        makeInput();
        addPartialWays();
        addDeviceWays();
        addHostWays();
        addPeers();
        measureWays(
            table_, ways_, [this] { copyAll(); }, double(count_) * table_.bytesEach, options_);
        return std::move(table_);
    }

private:
    void makeInput() {
        std::mt19937_64 random(1);
        glm::dmat4 all(1);
        LongMatrix longest(1);
        for (uint32_t i = 0; i < kMatrices; ++i) {
            single_[i] = rounded(randomMotion(random));
            exact_[i] = glm::dmat4(single_[i]);
            sevenRows_.push_back(rowsOf(single_[i]));
            all = exact_[i] * all;
            longest = LongMatrix(exact_[i]) * longest;
        }
        composite_ = rounded(all);
        oneRows_ = {rowsOf(composite_)};
        longRecord_ = longRecordOf(all);
        one_.upload(oneRows_);
        seven_.upload(sevenRows_);
        long_.upload(std::span(&longRecord_, 1));
        std::uniform_real_distribution<float> within(-1, 1);
        for (uint64_t i = 0; i < count_; ++i) {
            in_.span()[i] = {within(random), within(random), within(random), 1.0f};
            wanted_[i] = glm::dvec4(longest * glm::vec<4, long double>(in_.span()[i]));
        }
    }

    // Stores alone, and loads and stores alone: kernels of the same shape without a product.
    void addPartialWays() {
        onDevice(
            "device, store alone", Kind::partial, [this] { recordMarks(recorder_, device_.limits(), count_, in_, one_, out_); }, 0,
            [this] {
                for (uint64_t i = 0; i < count_; ++i)
                    twin_[i] = gpu::markOf(oneRows_[0], uint32_t(i % verticesPerDispatch(device_.limits())));
            });
        onDevice(
            table_.ceiling, Kind::partial, [this] { recordVertices(recorder_, device_.limits(), 0, count_, in_, one_, out_); }, 0,
            [this] { verticesCpu({}, vertices_, twin_, threads_); });
    }

    void addDeviceWays() {
        onDevice(
            "device, one composite", Kind::device, [this] { recordVertices(recorder_, device_.limits(), 1, count_, in_, one_, out_); }, 1,
            [this] { verticesCpu(oneRows_, vertices_, twin_, threads_); });
        onDeviceLong("device, one composite, block-scaled integers", Precision::blockInteger);
        if (const std::string lacks = lacksBinary64(device_); lacks.empty())
            onDeviceLong("device, one composite, binary64", Precision::fp64);
        else
            table_.absent.push_back("device, one composite, binary64: " + lacks);
        onDevice(
            "device, 7 one after another", Kind::device,
            [this] { recordVertices(recorder_, device_.limits(), kMatrices, count_, in_, seven_, out_); }, kMatrices,
            [this] { verticesCpu(sevenRows_, vertices_, twin_, threads_); });
    }

    void addHostWays() {
        onHost("twin, one composite", Kind::host, [this] { verticesCpu(oneRows_, vertices_, results_, threads_); });
        onHost(
            "twin, 7 one after another", Kind::host, [this] { verticesCpu(sevenRows_, vertices_, results_, threads_); }, kMatrices);
        onHost("GLM, one composite, 1 thread", Kind::glm, [this] { peers::glmVertices(composite_, vertices_, results_); });
        onHost(fmt::format("GLM, one composite, {} threads", threads_), Kind::glm,
               [this] { parallel([this](auto a, auto b) { peers::glmVertices(composite_, a, b); }); });
        onHost(
            fmt::format("GLM, 7 one after another, {} threads", threads_), Kind::host,
            [this] { parallel([this](auto a, auto b) { peers::glmVertices7(single_, a, b); }); }, kMatrices);
        onHost(
            fmt::format("binary64, 7 one after another, rounded once, {} threads", threads_), Kind::host,
            [this] {
                parallel([this](std::span<const glm::vec4> from, std::span<glm::vec4> to) {
                    for (size_t i = 0; i < from.size(); ++i) {
                        glm::dvec4 v(from[i]);
                        for (const glm::dmat4& m : exact_) v = m * v;
                        to[i] = glm::vec4(v);
                    }
                });
            },
            kMatrices);
    }

    // Libraries that this machine may lack.
    void addPeers() {
        std::string why;
        if (peers::hasEigen(why))
            onHost(fmt::format("Eigen, one composite, {} threads", threads_), Kind::host,
                   [this] { parallel([this](auto a, auto b) { peers::eigenVertices(composite_, a, b); }); });
        else
            table_.absent.push_back("Eigen: " + why);
        if (peers::hasOpenBlas(why))
            onHost("OpenBLAS sgemm, one composite", Kind::host, [this] { peers::openBlasVertices(composite_, vertices_, results_); });
        else
            table_.absent.push_back("OpenBLAS: " + why);
    }

    void onHost(const std::string& name, Kind kind, const std::function<void()>& run, uint64_t matrices = 1) {
        ways_.push_back({name, run, [this, run] { return run(), errorOfVertices(results_, wanted_); }, kind});
        ways_.back().products = matrices * count_, ways_.back().steps = matrices;
    }

    // Adds a way on the device. It runs once more before its error is taken, so that its results stand in the array, and `twinRuns` leaves
    // the same bytes in `twin_`.
    void onDevice(const std::string& name, Kind kind, const std::function<void()>& record, uint64_t matrices,
                  const std::function<void()>& twinRuns) {
        const auto run = [this, record] {
            record();
            recorder_.run(options_.watchdogMs);
            recorder_.takeTimes();
        };
        const auto error = [this, run, twinRuns, name, kind] {
            run();
            twinRuns();
            if (std::memcmp(results_.data(), twin_.data(), count_ * sizeof(glm::vec4)) != 0)
                table_.failure = fmt::format("{} vertices, {}: device and twin differ", count_, name);
            return kind == Kind::partial ? 0 : errorOfVertices(results_, wanted_);
        };
        ways_.push_back({name, run, error, kind});
        ways_.back().products = matrices * count_, ways_.back().steps = matrices;
    }

    void onDeviceLong(const std::string& name, Precision precision) {
        onDevice(
            name, Kind::device, [this, precision] { recordLongVertices(recorder_, device_.limits(), precision, count_, in_, long_, out_); },
            1, [this, precision] { longVerticesCpu(precision, longRecord_, vertices_, twin_, threads_); });
    }

    void parallel(const std::function<void(std::span<const glm::vec4>, std::span<glm::vec4>)>& work) {
        parallelBands(count_, 65536, threads_, [&](uint64_t begin, uint64_t end) {
            work(vertices_.subspan(begin, end - begin), results_.subspan(begin, end - begin));
        });
    }

    // Copies as many bytes as the ways read and write.
    void copyAll() {
        parallelBands(count_, 65536, threads_,
                      [&](uint64_t begin, uint64_t end) { std::memcpy(&results_[begin], &vertices_[begin], (end - begin) * 16); });
    }

    Device& device_;
    const uint64_t count_;
    const MatrixOptions& options_;
    const uint32_t threads_;
    glm::dmat4 exact_[kMatrices];
    glm::mat4 single_[kMatrices];
    glm::mat4 composite_{1};  // as an application makes it: multiplied in binary64, rounded once
    std::vector<gpu::Rows> oneRows_, sevenRows_;
    gpu::LongRecord longRecord_{};
    Buffer<glm::vec4> in_;
    Buffer<gpu::VertexPair> out_;
    Buffer<gpu::Rows> one_, seven_;
    Buffer<gpu::LongRecord> long_;
    Recorder recorder_;
    const std::span<const glm::vec4> vertices_;
    const std::span<glm::vec4> results_;
    std::vector<glm::vec4> twin_;
    std::vector<glm::dvec4> wanted_;
    MatrixTable table_;
    std::vector<Way> ways_;
};

}  // namespace

MatrixTable benchVertices(Device& device, uint64_t count, const MatrixOptions& options) {
    return VertexBench(device, count, options).run();
}

}  // namespace plumb
