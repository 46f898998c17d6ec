// SPDX-License-Identifier: MIT
// Ways to a product of matrices, measured side by side: what both tables of matrix.h share.
#pragma once

#include "pipeline/bench/matrix.h"
#include "shaders/shared/product.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <random>
#include <string>
#include <vector>

namespace plumb {

// Way to the result: `run` is timed, `error` is called once after the last round.
struct Way {
    std::string name;
    std::function<void()> run;
    std::function<double()> error;
    enum class Kind { host, glm, device, partial } kind = Kind::host;
    std::vector<double> ms = {};
    uint64_t products = 0, steps = 0;
};

// Measures: every round runs every way and the bandwidth once.
void measureWays(MatrixTable& table, std::vector<Way>& ways, const std::function<void()>& memory, double memoryBytes,
                 const MatrixOptions& options);

uint32_t threadsOf(const MatrixOptions& options);

// Random rotation, so that no chain grows or fades, with a small shift.
glm::dmat4 randomMotion(std::mt19937_64& random);

inline glm::mat4 rounded(const glm::dmat4& m) { return glm::mat4(m); }
gpu::Rows rowsOf(const glm::mat4& m);

// Reference of the results: 64 bits of significand, so that binary64 rounded once has an error of its own.
using LongMatrix = glm::mat<4, 4, long double>;

// Largest entry of the difference over the largest entry of the exact result, in units of 2^-24. NaN stays NaN.
template <class Got, class Exact>
double errorOf(const Got& got, const Exact& exact, int entries) {
    double most = 0, largest = 0;
    for (int i = 0; i < entries; ++i) {
        largest = std::max(largest, std::abs(double(exact[i])));
        const double error = std::abs(double(got[i]) - double(exact[i]));
        if (!(error <= most)) most = error;
    }
    return most / largest / 0x1p-24;
}

}  // namespace plumb
