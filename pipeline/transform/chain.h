// SPDX-License-Identifier: MIT
// Chains of transforms in order of application (the first step acts first), and their composite, one matrix that does the same. It is
// formed one product after the other, or as a tree of products that do not depend on each other.
#pragma once

#include "pipeline/transform/matrix.h"
#include "pipeline/transform/step.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

// Operations, counted where they are done.
struct ChainCounters {
    uint64_t products = 0;      // matrix * matrix
    uint64_t applications = 0;  // matrix * point
    uint64_t equations = 0;     // coordinates computed by applications: 2 a point in the plane, 3 in space
};

template <class Matrix>
Matrix countedProduct(const Matrix& later, const Matrix& earlier, ChainCounters& counters) {
    ++counters.products;
    return later * earlier;
}

// Matrices after each step; the last is the composite. n - 1 products, each waiting for the one before.
template <class Matrix>
std::vector<Matrix> productsOf(std::span<const Step<Matrix>> chain, ChainCounters& counters) {
    std::vector<Matrix> products;
    products.reserve(chain.size());
    for (const Step<Matrix>& step : chain)
        products.push_back(products.empty() ? step.matrix : countedProduct(step.matrix, products.back(), counters));
    return products;
}

// Node of the tree of products: it stands for the steps [first, last].
template <class Matrix>
struct TreeNode {
    size_t first, last;
    Matrix matrix;
    bool product;  // false: taken over from the level below
};

// Levels of the tree. levels[0] are the pairs of the steps themselves; the last level has one node, the composite. The depth is
// levels.size() = ceil(log2 n): all products of one level can be formed at once. A chain of one step has no level.
template <class Matrix>
std::vector<std::vector<TreeNode<Matrix>>> treeOf(std::span<const Step<Matrix>> chain, ChainCounters& counters) {
    std::vector<TreeNode<Matrix>> below;
    for (size_t i = 0; i < chain.size(); ++i) below.push_back({i, i, chain[i].matrix, false});
    std::vector<std::vector<TreeNode<Matrix>>> levels;
    while (below.size() > 1) {
        std::vector<TreeNode<Matrix>> level;
        for (size_t i = 0; i + 1 < below.size(); i += 2)
            level.push_back({below[i].first, below[i + 1].last, countedProduct(below[i + 1].matrix, below[i].matrix, counters), true});
        if (below.size() % 2 == 1) {
            level.push_back(below.back());
            level.back().product = false;
        }
        levels.push_back(level);
        below = std::move(level);
    }
    return levels;
}

// Applies matrix * (point, 1) to each point.
template <class Matrix, class Point>
void apply(const Matrix& matrix, std::span<Point> points, ChainCounters& counters) {
    for (Point& point : points) {
        point = transformed(matrix, point);
        ++counters.applications;
        counters.equations += uint64_t(Point::length());
    }
}

}  // namespace plumb
