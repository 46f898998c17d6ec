// SPDX-License-Identifier: MIT
// Binned surface-area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), one triangle a leaf. The
// binary tree is collapsed into one of eight children a node with the least sum of areas (Ylitie, Karras, Laine, "Efficient Incoherent Ray
// Traversal on GPUs Through Compressed Wide BVHs", 2017): the least number of nodes that a ray is likely to open.
#include "pipeline/passes/tree.h"

#include "shaders/shared/trace.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

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
        if (boxes_.empty()) return;
        pairs_.reserve(boxes_.size() * 2);
        build(0, uint32_t(boxes_.size()), 0);
        weigh();
        tree_.nodes.reserve(boxes_.size() * 4);
        tree_.leaves.reserve(boxes_.size());
        const uint32_t top = addNode();
        setChild(top * gpu::kNodeChildren, pairs_[0].box, addNode());
        open(0, gpu::kTopNode, 0, 1);
        setNext(top * gpu::kNodeChildren, uint32_t(tree_.nodes.size() / 2));
        for (const uint32_t slot : last_) setNext(slot, uint32_t(tree_.nodes.size() / 2));
    }
    TriangleTree take() { return std::move(tree_); }

private:
    struct Pair {
        Box box;
        uint32_t first = 0, triangles = 0;  // range in order_
        uint32_t second = 0;                // index of the second child; the first child follows its parent
    };

    uint32_t addNode() {
        const size_t at = tree_.nodes.size();
        tree_.nodes.resize(at + 2 * gpu::kNodeChildren, glm::uvec4(0));
        for (size_t k = 0; k < gpu::kNodeChildren; ++k) tree_.nodes[at + 2 * k].w = gpu::kNoChild;
        return uint32_t(at / (2 * gpu::kNodeChildren));
    }
    void setChild(uint32_t slot, const Box& box, uint32_t link) {
        tree_.nodes[2 * size_t(slot)] = glm::uvec4(bits(box.low), link);
        tree_.nodes[2 * size_t(slot) + 1] = glm::uvec4(bits(box.high), 0u);
    }
    void setNext(uint32_t slot, uint32_t next) { tree_.nodes[2 * size_t(slot) + 1].w = next; }

    // Computes costs_[i][n - 1]: areas of the nodes below pair i when at most n boxes stand for it. Pairs go from the last to the first,
    // because children stand behind their parents. A node costs something however small it is.
    void weigh() {
        costs_.resize(pairs_.size());
        const double least = pairs_[0].box.area() * 0x1p-24 + 0x1p-100;
        for (size_t i = pairs_.size(); i-- > 0;) {
            std::array<float, gpu::kNodeChildren>& cost = costs_[i];
            if (pairs_[i].triangles == 1) continue;
            for (uint32_t n = 2; n <= gpu::kNodeChildren; ++n) cost[n - 1] = parted(uint32_t(i), n, bestPart(uint32_t(i), n));
            cost[0] = float(pairs_[i].box.area() + least) + cost.back();
            for (float& c : cost) c = std::min(c, cost[0]);
        }
    }
    // Cost with `part` boxes for the first child and n - part for the second.
    float parted(uint32_t at, uint32_t n, uint32_t part) const {
        return costs_[at + 1][part - 1] + costs_[pairs_[at].second][n - part - 1];
    }
    uint32_t bestPart(uint32_t at, uint32_t n) const {
        uint32_t best = 1;
        for (uint32_t part = 2; part < n; ++part)
            if (parted(at, n, part) < parted(at, n, best)) best = part;
        return best;
    }
    // Appends the boxes that stand for a pair where n boxes may.
    void standIn(uint32_t at, uint32_t n, std::vector<uint32_t>& child) const {
        if (pairs_[at].triangles == 1 || n == 1 || costs_[at][0] <= costs_[at][n - 1])
            child.push_back(at);
        else
            part(at, n, child);
    }
    void part(uint32_t at, uint32_t n, std::vector<uint32_t>& child) const {
        const uint32_t first = bestPart(at, n);
        standIn(at + 1, first, child);
        standIn(pairs_[at].second, n - first, child);
    }

    // Fills `node` with the boxes below pair `at`. next: the child with which a walk continues after all of them; 0: none.
    void open(uint32_t at, uint32_t node, uint32_t next, uint32_t depth) {
        tree_.depth = std::max(tree_.depth, depth);
        std::vector<uint32_t> child;
        if (pairs_[at].triangles == 1)
            child.push_back(at);
        else
            part(at, gpu::kNodeChildren, child);
        const auto distance = [&](uint32_t pair) {
            const glm::dvec3 centre = pairs_[pair].box.centre();
            return glm::dot(centre, centre);
        };
        std::stable_sort(child.begin(), child.end(), [&](uint32_t a, uint32_t b) { return distance(a) < distance(b); });
        const size_t count = child.size();
        for (size_t k = 0; k < count; ++k) {
            const Pair& p = pairs_[child[k]];
            const uint32_t slot = node * gpu::kNodeChildren + uint32_t(k), after = k + 1 < count ? slot + 1 : next;
            if (p.triangles == 1) {
                setChild(slot, p.box, gpu::kLeaf | uint32_t(tree_.leaves.size()));
                tree_.leaves.push_back(order_[p.first]);
            } else {
                const uint32_t inner = addNode();
                setChild(slot, p.box, inner);
                open(child[k], inner, after, depth + 1);
            }
            if (after == 0)
                last_.push_back(slot);
            else
                setNext(slot, after);
        }
    }

    static glm::uvec3 bits(const glm::vec3& v) { return {gpu::ubitsOf(v.x), gpu::ubitsOf(v.y), gpu::ubitsOf(v.z)}; }

    Box boxOf(uint32_t first, uint32_t end) const {
        Box b;
        for (uint32_t i = first; i < end; ++i) b.add(boxes_[order_[i]]);
        return b;
    }

    // Index at which [first, end) is cut in two; order_ is partitioned. Beyond `depth` 60 the range is halved, so recursion stays shallow.
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
        const size_t self = pairs_.size();
        pairs_.push_back({boxOf(first, end), first, end - first, 0});
        if (end - first == 1) return;
        const uint32_t middle = split(first, end, depth);
        build(first, middle, depth + 1);
        pairs_[self].second = uint32_t(pairs_.size());
        build(middle, end, depth + 1);
    }

    std::vector<Box> boxes_;
    std::vector<uint32_t> order_;
    std::vector<Pair> pairs_;
    std::vector<std::array<float, gpu::kNodeChildren>> costs_;
    std::vector<uint32_t> last_;  // children that nothing follows
    TriangleTree tree_;
};

}  // namespace

TriangleTree treeOfTriangles(std::span<const glm::vec3> corners) { return Builder(corners).take(); }

}  // namespace plumb
