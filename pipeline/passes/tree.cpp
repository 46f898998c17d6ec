// SPDX-License-Identifier: MIT
// Binned surface-area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), one triangle a leaf.
#include "pipeline/passes/tree.h"

#include "shaders/shared/trace.h"

#include <algorithm>
#include <array>
#include <limits>

namespace plumb {

namespace {

constexpr int kBins = 16;

struct Box {
    glm::vec3 low{std::numeric_limits<float>::max()}, high{-std::numeric_limits<float>::max()};
    void add(const Box& b) {
        low = glm::min(low, b.low);
        high = glm::max(high, b.high);
    }
    double area() const {
        const glm::dvec3 e = glm::dvec3(high) - glm::dvec3(low);
        return e.x < 0 ? 0 : e.x * e.y + e.y * e.z + e.z * e.x;
    }
    glm::dvec3 centre() const { return (glm::dvec3(low) + glm::dvec3(high)) * 0.5; }
};

class Builder {
public:
    explicit Builder(std::span<const glm::vec3> corners) : boxes_(corners.size() / 3), order_(boxes_.size()) {
        for (size_t i = 0; i < boxes_.size(); ++i) {
            order_[i] = uint32_t(i);
            for (size_t k = 0; k < 3; ++k) boxes_[i].add({corners[3 * i + k], corners[3 * i + k]});
        }
        nodes_.reserve(boxes_.size() * 4);
        if (!boxes_.empty()) build(0, uint32_t(boxes_.size()), 0);
    }
    std::vector<glm::uvec4> take() { return std::move(nodes_); }

private:
    static glm::uvec3 bits(const glm::vec3& v) { return {gpu::ubitsOf(v.x), gpu::ubitsOf(v.y), gpu::ubitsOf(v.z)}; }

    Box boxOf(uint32_t first, uint32_t end) const {
        Box b;
        for (uint32_t i = first; i < end; ++i) b.add(boxes_[order_[i]]);
        return b;
    }

    // Where [first, end) is cut in two; order_ is partitioned. Beyond `depth` 60 halves are taken, so recursion stays shallow.
    uint32_t split(uint32_t first, uint32_t end, int depth) {
        Box centres;
        for (uint32_t i = first; i < end; ++i) {
            const glm::vec3 c(boxes_[order_[i]].centre());
            centres.add({c, c});
        }
        double best = std::numeric_limits<double>::infinity();
        int bestAxis = -1, bestBin = 0;
        const auto binOf = [&](uint32_t triangle, int axis) {
            const double extent = double(centres.high[axis]) - double(centres.low[axis]);
            return std::clamp(int((boxes_[triangle].centre()[axis] - double(centres.low[axis])) / extent * kBins), 0, kBins - 1);
        };
        for (int axis = 0; axis < 3 && depth < 60; ++axis) {
            if (!(centres.high[axis] > centres.low[axis])) continue;
            std::array<Box, kBins> box;
            std::array<uint32_t, kBins> count{};
            for (uint32_t i = first; i < end; ++i) {
                const int bin = binOf(order_[i], axis);
                box[size_t(bin)].add(boxes_[order_[i]]);
                ++count[size_t(bin)];
            }
            std::array<double, kBins> below{};
            Box sum;
            uint32_t number = 0;
            for (int bin = 0; bin + 1 < kBins; ++bin) {
                sum.add(box[size_t(bin)]);
                number += count[size_t(bin)];
                below[size_t(bin)] = number ? sum.area() * number : std::numeric_limits<double>::infinity();
            }
            sum = {};
            number = 0;
            for (int bin = kBins - 1; bin > 0; --bin) {
                sum.add(box[size_t(bin)]);
                number += count[size_t(bin)];
                if (number == 0) continue;
                const double cost = below[size_t(bin - 1)] + sum.area() * number;
                if (cost < best) best = cost, bestAxis = axis, bestBin = bin;
            }
        }
        if (bestAxis < 0) return first + (end - first) / 2;
        const auto middle = std::stable_partition(order_.begin() + first, order_.begin() + end,
                                                  [&](uint32_t triangle) { return binOf(triangle, bestAxis) < bestBin; });
        const auto at = uint32_t(middle - order_.begin());
        return at == first || at == end ? first + (end - first) / 2 : at;
    }

    void build(uint32_t first, uint32_t end, int depth) {
        const size_t self = nodes_.size();
        const Box box = boxOf(first, end);
        nodes_.emplace_back(bits(box.low), 0u);
        nodes_.emplace_back(bits(box.high), gpu::kInnerNode);
        if (end - first == 1) {
            nodes_[self + 1].w = order_[first];
        } else {
            const uint32_t middle = split(first, end, depth);
            const glm::dvec3 left = boxOf(first, middle).centre(), right = boxOf(middle, end).centre();
            const bool leftFirst = glm::dot(left, left) <= glm::dot(right, right);
            build(leftFirst ? first : middle, leftFirst ? middle : end, depth + 1);
            build(leftFirst ? middle : first, leftFirst ? end : middle, depth + 1);
        }
        nodes_[self].w = uint32_t(nodes_.size() / 2);
    }

    std::vector<Box> boxes_;
    std::vector<uint32_t> order_;
    std::vector<glm::uvec4> nodes_;
};

}  // namespace

std::vector<glm::uvec4> treeOfTriangles(std::span<const glm::vec3> corners) { return Builder(corners).take(); }

}  // namespace plumb
