// SPDX-License-Identifier: MIT
#include "pipeline/bench/matrix_ways.h"

#include "host/error.h"

#include <fmt/core.h>
#include <thread>
#include <utility>

namespace plumb {

uint32_t threadsOf(const MatrixOptions& options) {
    return options.threads != 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
}

glm::dmat4 randomMotion(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    glm::dvec4 q(normal(random), normal(random), normal(random), normal(random));
    q /= glm::length(q);
    const double x = q.x, y = q.y, z = q.z, w = q.w;
    glm::dmat4 m(1);
    m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0};
    m[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0};
    m[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0};
    m[3] = {normal(random) * 1e-3, normal(random) * 1e-3, normal(random) * 1e-3, 1};
    return m;
}

gpu::Rows rowsOf(const glm::mat4& m) {
    const glm::mat4 t = glm::transpose(m);
    return {t[0], t[1], t[2], t[3]};
}

void measureWays(MatrixTable& table, std::vector<Way>& ways, const std::function<void()>& memory, double memoryBytes,
                 const MatrixOptions& options) {
    std::vector<double> memoryMs, glmMs;
    memory();
    for (Way& way : ways) way.run(), way.run();
    for (uint32_t round = 0; round < options.rounds; ++round) {
        if (options.onProgress) options.onProgress(double(round) / options.rounds);
        memoryMs.push_back(msOf(memory));
        double glm = 0;
        for (Way& way : ways) {
            way.ms.push_back(msOf(way.run));
            if (way.kind == Way::Kind::glm && (glm == 0 || way.ms.back() < glm)) glm = way.ms.back();
        }
        glmMs.push_back(glm);
    }
    const auto ceiling = std::find_if(ways.begin(), ways.end(), [&](const Way& way) { return way.name == table.ceiling; });
    PLUMB_ASSERT(ceiling != ways.end());
    const double bytesPerMs = memoryBytes / spreadOf(memoryMs).median;
    table.bandwidthGBs = bytesPerMs * 1e-6;
    for (Way& way : ways) {
        MatrixWay row;
        row.name = way.name;
        row.ms = spreadOf(way.ms);
        row.perSecond = double(table.count) / row.ms.median * 1e3;
        row.shareOfBound = row.perSecond * table.bytesEach / (bytesPerMs * 1e3);
        row.partial = way.kind == Way::Kind::partial;
        if (way.kind == Way::Kind::device || row.partial) row.ofDevice = ratioOf(ceiling->ms, way.ms);
        row.againstGlm = ratioOf(glmMs, way.ms);
        row.products = way.products;
        row.steps = way.steps;
        row.errorU = way.error();
        if (!std::isfinite(row.errorU)) table.failure = fmt::format("{}: a result is not finite", row.name);
        table.ways.push_back(std::move(row));
    }
}

}  // namespace plumb
