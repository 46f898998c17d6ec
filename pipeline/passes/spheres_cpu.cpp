// SPDX-License-Identifier: MIT
#include "pipeline/passes/spheres.h"

#include "host/error.h"
#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/parallel.h"

#include <fmt/core.h>
#include <algorithm>
#include <utility>

namespace plumb {

bool SphereList::add(const gpu::SphereDisc& d) {
    if (d.column + d.reach < 0 || d.column - d.reach >= width || d.row + d.reach < 0 || d.row - d.reach >= height) return false;
    discs.push_back(d);
    return true;
}

void SphereList::close(const std::function<std::string(size_t)>& locationOf) {
    const auto rowsOf = [&](const gpu::SphereDisc& d) {
        return std::pair(size_t(std::max(0, d.row - d.reach)), size_t(std::min(height - 1, d.row + d.reach)));
    };
    std::vector<uint64_t> counts(size_t(height) + 1);
    uint64_t all = 0;
    for (size_t i = 0; i < discs.size(); ++i)
        for (auto [y, last] = rowsOf(discs[i]); y <= last; ++y) {
            if (++counts[y + 1] > uint64_t(gpu::kSpheresOfRow))
                throw inputError(locationOf(i),
                                 fmt::format("--fill notes tries at most {} spheres a pixel, and row {} of the picture meets more",
                                             gpu::kSpheresOfRow, y));
            if (++all > 0x7fffffffu) throw inputError(locationOf(i), "with it, the spheres of --fill notes meet more than 2^31 rows");
        }
    for (size_t y = 0; y < size_t(height); ++y) counts[y + 1] += counts[y];
    rowFirst.assign(counts.begin(), counts.end());
    rowDiscs.resize(counts.back());
    std::vector<uint32_t> next(rowFirst.begin(), rowFirst.end() - 1);
    for (uint32_t i = 0; i < discs.size(); ++i)
        for (auto [y, last] = rowsOf(discs[i]); y <= last; ++y) rowDiscs[next[y]++] = i;
}

SphereCanvas spheresCpu(const SphereList& list, const SphereLight& light, uint32_t threads) {
    SphereCanvas canvas;
    const size_t pixels = size_t(list.width) * size_t(list.height);
    canvas.depth.assign(pixels, gpu::kSphereFarthest);
    canvas.owner.assign(pixels, gpu::kNoSphere);
    canvas.colour.assign(pixels, glm::vec4(0));
    for (uint32_t number = 0; number < list.discs.size(); ++number) {
        const gpu::SphereDisc& d = list.discs[number];
        for (int row = std::max(0, d.row - d.reach); row <= std::min(list.height - 1, d.row + d.reach); ++row)
            for (int column = std::max(0, d.column - d.reach); column <= std::min(list.width - 1, d.column + d.reach); ++column) {
                const int x = column - d.column, y = d.row - row;
                if (!gpu::sphereCovers(d, x, y)) continue;
                const size_t pixel = size_t(row) * size_t(list.width) + size_t(column);
                const float depth = gpu::sphereDepth(d, gpu::sphereHeight(d, x, y, light.wholeHeights), light.unit);
                if (!gpu::sphereNearer(depth, canvas.depth[pixel])) continue;
                canvas.depth[pixel] = depth;
                canvas.owner[pixel] = number;
            }
    }
    parallelBands(pixels, 4096, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t pixel = begin; pixel < end; ++pixel) {
            if (canvas.owner[pixel] == gpu::kNoSphere) continue;
            const gpu::SphereDisc& d = list.discs[canvas.owner[pixel]];
            const int x = int(pixel % uint64_t(list.width)) - d.column, y = d.row - int(pixel / uint64_t(list.width));
            const gpu::Surface surface = gpu::sphereSurface(d, x, y, gpu::sphereHeight(d, x, y, light.wholeHeights), light.unit);
            const gpu::MaterialRecord& m = light.materials[d.material];
            gpu::Colour c{m.base.x, m.base.y, m.base.z};
            for (const gpu::LightRecord& l : light.lights)
                gpu::addLight(glm::vec4(l.position, l.kind), glm::vec4(l.intensity, l.attenuation), surface, reflectanceOf(m), light.parts,
                              c);
            canvas.colour[pixel] = {c.r, c.g, c.b, 0.0f};
        }
    });
    return canvas;
}

}  // namespace plumb
