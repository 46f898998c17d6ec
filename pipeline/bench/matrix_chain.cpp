// SPDX-License-Identifier: MIT
// Products of chains of matrices.
#include "pipeline/bench/matrix_ways.h"
#include "pipeline/bench/peers.h"
#include "pipeline/bench/products.h"
#include "pipeline/passes/parallel.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
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
constexpr uint32_t kPerLane = 1024;  // matrices an invocation of the tree; a shallow tree, since each level is a dispatch

glm::mat4 matrixOf(const gpu::Rows& r) { return glm::transpose(glm::mat4(r.r0, r.r1, r.r2, r.r3)); }

double errorOfMatrix(const glm::mat4& got, const glm::dmat4& exact) { return errorOf(&got[0].x, &exact[0].x, 16); }

class ChainBench {
public:
    ChainBench(Device& device, uint64_t count, const MatrixOptions& options)
        : device_(device),
          count_(count),
          options_(options),
          threads_(threadsOf(options)),
          chain_(count),
          in_(device, count, "chain"),
          left_(device, count / 2 + 1, "products"),
          right_(device, count / 4 + 1, "products of products"),
          recorder_(device),
          rows_(std::as_const(in_).span()),
          sums_(threads_) {}
    ChainBench(const ChainBench&) = delete;
    ChainBench& operator=(const ChainBench&) = delete;

    MatrixTable run() {
        table_.work = "chain";
        table_.count = count_;
        table_.bytesEach = sizeof(gpu::Rows);
        table_.ceiling = "device, load alone";
        makeInput();
        addDeviceWays();
        addHostWays();
        measureWays(
            table_, ways_, [this] { readAll(); }, double(count_) * table_.bytesEach, options_);
        return std::move(table_);
    }

private:
    void makeInput() {
        std::mt19937_64 random(2);
        LongMatrix all(1);
        for (glm::mat4& m : chain_) {
            m = rounded(randomMotion(random));
            all = all * LongMatrix(m);
        }
        wanted_ = glm::dmat4(all);
        std::transform(chain_.begin(), chain_.end(), in_.span().begin(), rowsOf);
    }

    void addDeviceWays() {
        addTree(table_.ceiling, Kind::partial, Level::sums, kPerLane);
        addTree("device, pairwise tree", Kind::device, Level::products, 2);
        addTree(fmt::format("device, tree of {}", kPerLane), Kind::device, Level::products, kPerLane);
        if (count_ <= gpu::kMostPerLane)
            addTree("device, sequential", Kind::device, Level::products, uint32_t(std::max<uint64_t>(2, count_)));
        else
            table_.absent.push_back(fmt::format(
                "device, sequential: an invocation multiplies at most {} (a loop of lavapipe ends after 65,535 steps), the chain has {}",
                gpu::kMostPerLane, count_));
    }

    void addHostWays() {
        const auto sequential = std::max<uint64_t>(2, count_);
        ways_.push_back({fmt::format("twin, tree of {}", kPerLane), [this] { product_ = matrixOf(treeOnTwin(Level::products, kPerLane)); },
                         [this] { return errorOfMatrix(matrixOf(treeOnTwin(Level::products, kPerLane)), wanted_); }});
        countTree(kPerLane);
        addHost("GLM, sequential", Kind::glm, [this] { product_ = peers::glmChain(chain_); });
        countTree(sequential);
        addHost(fmt::format("GLM, {} parts, {} threads", threads_, threads_), Kind::host, [this] { multiplyParts(); });
        ways_.back().products = count_ - 1;
        ways_.back().steps = (count_ + threads_ - 1) / threads_ - 1 + std::min<uint64_t>(threads_, count_) - 1;
        addHost("binary64, sequential, rounded once", Kind::host, [this] {
            glm::dmat4 sum(1);
            for (const glm::mat4& m : chain_) sum = sum * glm::dmat4(m);
            product_ = rounded(sum);
        });
        countTree(sequential);
    }

    void addHost(const std::string& name, Kind kind, const std::function<void()>& run) {
        ways_.push_back({name, run, [this, run] { return run(), errorOfMatrix(product_, wanted_); }, kind});
    }

    void addTree(const std::string& name, Kind kind, Level level, uint32_t perLane) {
        const auto error = [this, kind, level, perLane, name] {
            treeOnDevice(level, perLane);
            const gpu::Rows got = last_->span()[0], want = treeOnTwin(level, perLane);
            const auto bytesOf = [](const gpu::Rows& of) { return std::as_bytes(std::span(&of, 1)); };
            if (!std::ranges::equal(bytesOf(got), bytesOf(want)))
                table_.failure = fmt::format("a chain of {}, {}: device and twin differ", count_, name);
            return kind == Kind::partial ? 0 : errorOfMatrix(matrixOf(got), wanted_);
        };
        ways_.push_back({name, [this, level, perLane] { treeOnDevice(level, perLane); }, error, kind});
        if (kind != Kind::partial) countTree(perLane);
    }

    // Counts of the last way's tree. A level multiplies runs of perLane matrices, all at once, each from left to right.
    void countTree(uint64_t perLane) {
        ways_.back().products = count_ - 1;
        for (uint64_t n = count_; n > 1; n = (n + perLane - 1) / perLane) ways_.back().steps += std::min(perLane, n) - 1;
    }

    void treeOnDevice(Level level, uint32_t perLane) {
        const Buffer<gpu::Rows>* from = &in_;
        for (uint64_t n = count_; n > 1 || from == &in_; n = (n + perLane - 1) / perLane) {
            const Buffer<gpu::Rows>* to = from == &left_ ? &right_ : &left_;
            recordChainLevel(recorder_, device_.limits(), level, perLane, n, *from, *to);
            from = to;
        }
        recorder_.run(options_.watchdogMs);
        recorder_.takeTimes();
        last_ = from;
    }

    gpu::Rows treeOnTwin(Level level, uint32_t perLane) {
        std::span<const gpu::Rows> from = rows_;
        for (uint64_t n = count_; n > 1 || from.data() == rows_.data();) {
            n = (n + perLane - 1) / perLane;
            std::vector<gpu::Rows>& to = from.data() == a_.data() ? b_ : a_;
            if (to.size() < n) to.resize(n);
            chainLevelCpu(level, perLane, from, std::span(to).first(n), threads_);
            from = std::span<const gpu::Rows>(to).first(n);
        }
        return from[0];
    }

    // By GLM, a part of the chain on each thread.
    void multiplyParts() {
        const uint64_t part = (count_ + threads_ - 1) / threads_;
        std::vector<glm::mat4> parts((count_ + part - 1) / part);
        parallelBands(parts.size(), 1, threads_, [&](uint64_t begin, uint64_t end) {
            for (uint64_t i = begin; i < end; ++i)
                parts[i] = peers::glmChain(std::span<const glm::mat4>(chain_).subspan(i * part, std::min(part, count_ - i * part)));
        });
        product_ = peers::glmChain(parts);
    }

    // Reads as many bytes as the ways read.
    void readAll() {
        const std::span<const uint64_t> words(reinterpret_cast<const uint64_t*>(rows_.data()), count_ * sizeof(gpu::Rows) / 8);
        const uint64_t part = (words.size() + threads_ - 1) / threads_;
        parallelBands(threads_, 1, threads_, [&](uint64_t begin, uint64_t end) {
            for (uint64_t i = begin; i < end; ++i)
                if (i * part < words.size()) sums_[i] += peers::sumWords(words.subspan(i * part, std::min(part, words.size() - i * part)));
        });
    }

    Device& device_;
    const uint64_t count_;
    const MatrixOptions& options_;
    const uint32_t threads_;
    std::vector<glm::mat4> chain_;
    glm::dmat4 wanted_{1};
    Buffer<gpu::Rows> in_, left_, right_;
    Recorder recorder_;
    const std::span<const gpu::Rows> rows_;  // of in_
    const Buffer<gpu::Rows>* last_ = nullptr;
    std::vector<gpu::Rows> a_, b_;
    glm::mat4 product_{1};
    std::vector<uint64_t> sums_;
    MatrixTable table_;
    std::vector<Way> ways_;
};

}  // namespace

MatrixTable benchChain(Device& device, uint64_t count, const MatrixOptions& options) { return ChainBench(device, count, options).run(); }

}  // namespace plumb
