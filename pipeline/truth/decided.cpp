// SPDX-License-Identifier: MIT
#include "pipeline/truth/decided.h"

#include "host/error.h"
#include "pipeline/truth/geometry.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <thread>

namespace plumb {
namespace {

using truth::Geometry;
using truth::Pinhole;
using truth::Triangle;

constexpr int kBandRows = 16;  // samples
constexpr double kNothing = -std::numeric_limits<double>::infinity();

// What may be seen at a sample, by inverse depths: the larger, the nearer.
struct Seen {
    double surely = kNothing;                  // least inverse depth of the triangle that is surely hit and nearest so
    double mayBe = kNothing, next = kNothing;  // the two largest inverse depths that may be hit, of different triangles
    uint32_t sure = kNone, may = kNone;        // triangles of the first two

    void add(uint32_t triangle, double least, double most, bool hit) {
        if (most > mayBe) {
            next = mayBe, mayBe = most, may = triangle;
        } else {
            next = std::max(next, most);
        }
        if (hit && least > surely) surely = least, sure = triangle;
    }
    bool decided() const { return mayBe == kNothing || (sure != kNone && surely > (may == sure ? next : mayBe)); }
};

// Edges of a triangle that is moved by at most `aside` samples.
struct Margins {
    double edge[3], inverse;
    Margins(const Triangle& t, double aside) : inverse(aside * (std::abs(t.sa) + std::abs(t.sb)) + t.inverseError) {
        for (int i = 0; i < 3; ++i) edge[i] = aside * (std::abs(t.a[i]) + std::abs(t.b[i])) + t.error[i];
    }
};

class Deciding {
public:
    Deciding(const Geometry& geometry, double aside) : geometry_(geometry) {
        for (const Triangle& t : geometry.triangles()) margins_.emplace_back(t, aside);
    }

    // Takes into `seen`, one a sample of the rows, what may be seen there.
    void see(int firstRow, int rows, std::vector<Seen>& seen) const {
        const auto width = int(geometry_.pinhole().width);
        seen.assign(size_t(width) * size_t(rows), {});
        const std::vector<Triangle>& triangles = geometry_.triangles();
        for (uint32_t k = 0; k < triangles.size(); ++k) {
            const Triangle& t = triangles[k];
            for (int j = std::max(firstRow, t.firstRow); j <= std::min(firstRow + rows - 1, t.lastRow); ++j)
                for (int i = t.firstColumn; i <= std::min(t.lastColumn, width - 1); ++i)
                    look(k, geometry_.pinhole().x(i), geometry_.pinhole().y(j), seen[size_t(j - firstRow) * size_t(width) + size_t(i)]);
        }
    }

private:
    void look(uint32_t k, double x, double y, Seen& seen) const {
        const Triangle& t = geometry_.triangles()[k];
        const Margins& m = margins_[k];
        bool sure = true;
        for (int i = 0; i < 3; ++i) {
            const double e = t.a[i] * x + t.b[i] * y + t.c[i];
            if (e < -m.edge[i]) return;
            sure &= e > m.edge[i];
        }
        const double inverse = t.sa * x + t.sb * y + t.sc, limit = 1 / geometry_.pinhole().near;
        if (inverse + m.inverse <= 0 || inverse - m.inverse > limit) return;  // behind the eye, or before the near plane
        sure &= inverse - m.inverse > 0 && inverse + m.inverse < limit;
        seen.add(k, inverse - m.inverse, inverse + m.inverse, sure);
    }

    const Geometry& geometry_;
    std::vector<Margins> margins_;
};

}  // namespace

double snapOf(const RenderRequest& request) {
    const uint32_t side = request.samples == 16 ? 4 : request.samples == 4 ? 2 : 1;
    return 0x1p-9 + 8 * 0x1p-24 * side * std::max(request.width, request.height);
}

std::vector<uint8_t> decidedPixels(const Scene& scene, const RenderRequest& request, double aside) {
    PLUMB_ASSERT(scene.camera.has_value() && request.fill == Fill::exact);
    std::vector<uint8_t> decided(size_t(request.width) * request.height, 1);
    if (request.shading == Shading::ray) return decided;
    const uint32_t side = request.samples == 16 ? 4 : request.samples == 4 ? 2 : 1;
    const Geometry geometry(scene, Pinhole(*scene.camera, request.width, request.height, side));
    const Deciding deciding(geometry, aside);
    const int height = int(request.height * side), width = int(request.width * side);
    std::atomic<int> next{0};
    const auto work = [&] {
        std::vector<Seen> seen;
        for (int first; (first = next.fetch_add(kBandRows)) < height;) {
            const int rows = std::min(kBandRows, height - first);
            deciding.see(first, rows, seen);
            for (int j = 0; j < rows; ++j)
                for (int i = 0; i < width; ++i)
                    if (!seen[size_t(j) * size_t(width) + size_t(i)].decided())
                        decided[size_t((first + j) / int(side)) * request.width + size_t(i) / side] = 0;
        }
    };
    std::vector<std::jthread> pool;  // a band has whole pixels, since 16 rows are whole pixels of any number of samples
    const uint32_t threads = request.threads ? request.threads : std::max(1u, std::thread::hardware_concurrency());
    for (uint32_t i = 1; i < threads; ++i) pool.emplace_back(work);
    work();
    return decided;
}

}  // namespace plumb
