// SPDX-License-Identifier: MIT
#include "pipeline/passes/fill.h"

#include "host/error.h"
#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/parallel.h"

#include <algorithm>
#include <array>
#include <utility>

namespace plumb {

namespace {

int64_t floorDivide(int64_t a, int64_t b) {  // b > 0
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}
int64_t ceilDivide(int64_t a, int64_t b) { return -floorDivide(-a, b); }

// A drawn triangle in 64-bit integers. Edges: 0 = (v0, v1), 1 = (v1, v2), 2 = (v2, v0).
struct Geometry {
    int64_t x[3], y[3], a[3], b[3];
    int bias[3];

    Geometry(const gpu::DrawTriangle& d, std::span<const gpu::ScreenVertex> screen) {
        for (int i = 0; i < 3; ++i) x[i] = screen[d.vertex[i]].x, y[i] = screen[d.vertex[i]].y;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3;
            a[i] = y[j] - y[i];
            b[i] = x[i] - x[j];
            bias[i] = gpu::edgeBias(int(a[i]), int(b[i]));
        }
    }
    // E_i - bias_i at a pixel centre.
    int64_t edge(int i, int64_t pixelX, int64_t pixelY) const {
        return a[i] * (pixelX * gpu::kSubpixels + gpu::kHalfPixel - x[i]) + b[i] * (pixelY * gpu::kSubpixels + gpu::kHalfPixel - y[i]) -
               bias[i];
    }
    float whole(int i, int64_t px, int64_t py) const { return float(edge(i, px, py) >> gpu::kSubpixelBits); }
    float rho(int i) const { return float((edge(i, 0, 0) & 255) + bias[i]) * 0.00390625f; }
    gpu::DepthPlane depth(const gpu::DrawTriangle& d, std::span<const gpu::ScreenVertex> screen) const {
        int64_t sum = 0;
        for (int i = 0; i < 3; ++i) sum += edge(i, 0, 0) >> gpu::kSubpixelBits;
        return gpu::depthPlane(screen[d.vertex[0]].z, screen[d.vertex[1]].z, screen[d.vertex[2]].z, float(sum), rho(0), rho(1), rho(2));
    }
    // Columns of a row that the triangle covers: [first, last].
    std::pair<int64_t, int64_t> span(int64_t row, int64_t width) const {
        int64_t first = 0, last = width - 1;
        for (int i = 0; i < 3; ++i) {
            // a 256 x >= rest  <=>  edge(i, x, row) >= 0
            const int64_t rest = -edge(i, 0, row);
            const int64_t step = a[i] * gpu::kSubpixels;
            if (step > 0)
                first = std::max(first, ceilDivide(rest, step));
            else if (step < 0)
                last = std::min(last, floorDivide(-rest, -step));
            else if (rest > 0)
                return {1, 0};
        }
        return {first, last};
    }
};

}  // namespace

void fillCpu(const gpu::FrameBox& frame, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen,
             std::span<int> z, std::span<uint32_t> draw, uint32_t threads, uint32_t depthBits) {
    parallelBands(uint64_t(frame.rows), 8, threads, [&](uint64_t begin, uint64_t end) {
        const int64_t bandFirst = frame.firstRow + int64_t(begin), bandLast = frame.firstRow + int64_t(end) - 1;
        std::fill(z.begin() + ptrdiff_t(begin * frame.width), z.begin() + ptrdiff_t(end * frame.width), 0);
        std::fill(draw.begin() + ptrdiff_t(begin * frame.width), draw.begin() + ptrdiff_t(end * frame.width), 0u);
        for (uint32_t t = 0; t < draws.size(); ++t) {
            const gpu::DrawTriangle& d = draws[t];
            if (d.vertex[0] == d.vertex[1]) continue;  // unused place of a clip fan
            const int lowY = std::min({screen[d.vertex[0]].y, screen[d.vertex[1]].y, screen[d.vertex[2]].y});
            const int highY = std::max({screen[d.vertex[0]].y, screen[d.vertex[1]].y, screen[d.vertex[2]].y});
            const int64_t firstRow = std::max<int64_t>(gpu::firstPixel(lowY), bandFirst);
            const int64_t lastRow = std::min<int64_t>(gpu::lastPixel(highY), bandLast);
            if (firstRow > lastRow) continue;
            const Geometry g(d, screen);
            const gpu::DepthPlane plane = g.depth(d, screen);
            for (int64_t row = firstRow; row <= lastRow; ++row) {
                const auto [first, last] = g.span(row, frame.width);
                for (int64_t x = first; x <= last; ++x) {
                    const size_t at = size_t(row - frame.firstRow) * size_t(frame.width) + size_t(x);
                    int here = gpu::depthBits(g.whole(2, x, row), g.whole(0, x, row), plane.k1, plane.k2, plane.zc, plane.low, plane.high);
                    if (depthBits < 32) here = gpu::coarseDepth(here, depthBits);
                    if (depthBits == gpu::kDepthStandard) here = gpu::standardDepth(here);
                    if (!gpu::wins(here, int(t + 1), z[at], int(draw[at]))) continue;
                    z[at] = here;
                    draw[at] = t + 1;
                }
            }
        }
    });
}

void shadeCpu(const gpu::FrameBox& frame, const DrawList& list, const FillChoices& choices, std::span<const gpu::DrawTriangle> draws,
              std::span<const gpu::ScreenVertex> screen, std::span<const glm::vec4> carried, std::span<const int> z,
              std::span<const uint32_t> draw, std::span<float> linear, std::span<float> normal, uint32_t threads) {
    const auto shade = [&](size_t at, float* colour, float* unitNormal) {
        const int64_t x = int64_t(at % size_t(frame.width)), y = int64_t(at / size_t(frame.width)) + frame.firstRow;
        const gpu::DrawTriangle& d = draws[draw[at] - 1];
        const gpu::MaterialRecord& m = list.materials[list.triangles[d.source].w];
        std::array<float, 4> value{};
        gpu::Shares shares{};
        if (choices.shading == gpu::kShadingFlat) {
            const glm::vec4& c = carried[list.triangleFace[d.source]];
            value = {c.x, c.y, c.z, 1};
        } else if (choices.shading >= gpu::kShadingGouraud) {
            const Geometry g(d, screen);
            float e[3], w[3];
            for (int i = 0; i < 3; ++i) e[i] = g.whole(i, x, y) + g.rho(i);
            int highest = 0;
            for (uint32_t v : d.vertex) highest = std::max(highest, gpu::bitsOf(screen[v].z));
            for (int i = 0; i < 3; ++i) w[i] = choices.affine ? 1.0f : screen[d.vertex[i]].z * gpu::weightScale(highest);
            const glm::vec4 &a0 = carried[d.vertex[0]], &a1 = carried[d.vertex[1]], &a2 = carried[d.vertex[2]];
            for (int i = 0; i < 3; ++i) value[size_t(i)] = gpu::weigh(a0[i] * w[0], a1[i] * w[1], a2[i] * w[2], e[0], e[1], e[2]);
            value[3] = gpu::weigh(w[0], w[1], w[2], e[0], e[1], e[2]);
            shares = gpu::sharesOf(w[0], w[1], w[2], e[0], e[1], e[2]);
        }
        gpu::Colour c{};
        if (choices.shading == gpu::kShadingUnlit) {
            c = {m.diffuse.x, m.diffuse.y, m.diffuse.z};
        } else if (choices.shading == gpu::kShadingFlat) {
            c = {value[0], value[1], value[2]};
        } else if (choices.shading == gpu::kShadingGouraud) {
            const float inverse = gpu::reciprocal(value[3]);
            c = {value[0] * inverse, value[1] * inverse, value[2] * inverse};
        } else {
            gpu::Surface s{};
            if (choices.unitNormals) {
                gpu::unitVector(value[0], value[1], value[2]);
            } else {
                const float inverse = gpu::reciprocal(value[3]);
                for (size_t i = 0; i < 3; ++i) value[i] *= inverse;
            }
            s.nx = value[0];
            s.ny = value[1];
            s.nz = value[2];
            const float px = float(x) + 0.5f, py = float(y) + 0.5f;
            const float rx = gpu::rayAt(list.rayOrigin.x, list.rayX.x, list.rayY.x, px, py);
            const float ry = gpu::rayAt(list.rayOrigin.y, list.rayX.y, list.rayY.y, px, py);
            const float rz = gpu::rayAt(list.rayOrigin.z, list.rayX.z, list.rayY.z, px, py);
            s.vx = -rx;
            s.vy = -ry;
            s.vz = -rz;
            gpu::seeFrom(list.towardViewer != glm::vec3(0), list.towardViewer, s);
            const float w = gpu::reciprocal(gpu::realOf(z[at])) * list.viewport.near;
            s.px = rx * w;
            s.py = ry * w;
            s.pz = rz * w;
            c = {m.base.x, m.base.y, m.base.z};
            // A direction as `toward` makes it at a place, of the face or of each corner.
            const auto made = [&](const auto& toward) {
                if (choices.vectors == gpu::kVectorsFace) {
                    const glm::vec4& p = list.facePlaces[list.triangleFace[d.source]];
                    return toward(gpu::Place{p.x, p.y, p.z});
                }
                gpu::Toward t[3];
                for (int i = 0; i < 3; ++i) {
                    const gpu::ScreenVertex& v = screen[d.vertex[i]];
                    t[i] = toward(gpu::placeOfCorner(v.x, v.y, v.z, list.viewport.near, list.rayOrigin, list.rayX, list.rayY));
                }
                return gpu::Toward{gpu::shared3(shares, t[0].x, t[1].x, t[2].x), gpu::shared3(shares, t[0].y, t[1].y, t[2].y),
                                   gpu::shared3(shares, t[0].z, t[1].z, t[2].z), gpu::shared3(shares, t[0].fade, t[1].fade, t[2].fade)};
            };
            const bool atPixels = choices.vectors == gpu::kVectorsPixel;
            if (!atPixels && choices.parts.specular && list.towardViewer == glm::vec3(0)) {
                const gpu::Toward eye = made([](const gpu::Place& p) { return gpu::eyeFrom(p); });
                s.vx = eye.x;
                s.vy = eye.y;
                s.vz = eye.z;
            }
            for (const gpu::LightRecord& light : list.lights) {
                const glm::vec4 place(light.place, light.kind), intensity(light.intensity, light.attenuation);
                if (atPixels || light.kind == 0)
                    gpu::addLight(place, intensity, s, reflectanceOf(m), choices.parts, c);
                else
                    gpu::addLightFrom(made([&](const gpu::Place& p) { return gpu::lampFrom(place, light.attenuation, p); }), intensity, s,
                                      reflectanceOf(m), choices.parts, c);
            }
            if (unitNormal) {
                if (!choices.unitNormals) gpu::unitVector(value[0], value[1], value[2]);
                std::copy_n(value.begin(), 3, unitNormal);
            }
        }
        colour[0] = c.r;
        colour[1] = c.g;
        colour[2] = c.b;
    };
    // The pixel whose colour a pixel takes.
    const auto shaded = [&](size_t at) {
        const size_t width = size_t(frame.width), row = at / width;
        PLUMB_ASSERT(frame.firstRow % 2 == 0);
        const size_t corner = (row & ~size_t(1)) * width + (at % width & ~size_t(1));
        const bool inX = corner % width + 1 < width, inY = (row & ~size_t(1)) + 1 < size_t(frame.rows);
        const int which = gpu::firstDrawn(draw[corner] != 0, inX && draw[corner + 1] != 0, inY && draw[corner + width] != 0,
                                          inX && inY && draw[corner + width + 1] != 0);
        return corner + size_t(which & 1) + (which > 1 ? width : 0);
    };
    parallelBands(uint64_t(frame.rows), 8, threads, [&](uint64_t begin, uint64_t end) {
        for (size_t at = begin * frame.width; at < end * frame.width; ++at) {
            if (!draw[at]) continue;
            float* colour = &linear[3 * at];
            float* unitNormal = normal.empty() ? nullptr : &normal[3 * at];
            const size_t from = choices.coarse ? shaded(at) : at;
            if (from == at || unitNormal) shade(at, colour, unitNormal);
            if (from == at) continue;
            if (from >= begin * frame.width && from < at)
                std::copy_n(&linear[3 * from], 3, colour);
            else
                shade(from, colour, nullptr);
        }
    });
}

}  // namespace plumb
