// SPDX-License-Identifier: MIT
// One pixel of the twin's fill: the edges and the depth of a drawn triangle there, its attributes, its surface, its colour. The twin shades
// pixels by it, and `plumb pixel` opens them by it.
#pragma once

#include "host/error.h"
#include "pipeline/passes/fill.h"
#include "pipeline/passes/illuminate.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>

namespace plumb {

inline int64_t floorDivide(int64_t a, int64_t b) {  // b > 0
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}
inline int64_t ceilDivide(int64_t a, int64_t b) { return -floorDivide(-a, b); }

// A drawn triangle in 64-bit integers. Edges: 0 = (v0, v1), 1 = (v1, v2), 2 = (v2, v0).
struct DrawnTriangle {
    int64_t x[3], y[3], a[3], b[3];
    int bias[3];

    DrawnTriangle(const gpu::DrawTriangle& d, std::span<const gpu::ScreenVertex> screen) {
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

// Shades pixels of a frame, each by itself, from what is visible there.
class PixelShader {
public:
    PixelShader(const gpu::FrameBox& frame, const DrawList& list, const FillChoices& choices, std::span<const gpu::DrawTriangle> draws,
                std::span<const gpu::ScreenVertex> screen, std::span<const glm::vec4> attributes, std::span<const int> z,
                std::span<const uint32_t> draw)
        : frame_(frame), list_(list), choices_(choices), draws_(draws), screen_(screen), attributes_(attributes), z_(z), draw_(draw) {}

    // Writes the colour of a covered pixel, and its unit normal where Phong shading asks for one.
    void shade(size_t at, float* colour, float* unitNormal) const {
        const gpu::DrawTriangle& d = draws_[draw_[at] - 1];
        const gpu::MaterialRecord& m = list_.materials[list_.triangles[d.source].w];
        Attributes v = attributesAt(at, d);
        gpu::Colour c{};
        if (choices_.shading == gpu::kShadingUnlit) {
            c = {m.diffuse.x, m.diffuse.y, m.diffuse.z};
        } else if (choices_.shading == gpu::kShadingFlat) {
            c = {v.value[0], v.value[1], v.value[2]};
        } else if (choices_.shading == gpu::kShadingGouraud) {
            const float inverse = gpu::reciprocal(v.weight);
            c = {v.value[0] * inverse, v.value[1] * inverse, v.value[2] * inverse};
        } else {
            if (choices_.unitNormals) {
                gpu::unitVector(v.value[0], v.value[1], v.value[2]);
            } else {
                const float inverse = gpu::reciprocal(v.weight);
                for (float& normal : v.value) normal *= inverse;
            }
            c = {m.base.x, m.base.y, m.base.z};
            addLights(d, m, v, surfaceAt(at, d, v), c);
            if (unitNormal) {
                if (!choices_.unitNormals) gpu::unitVector(v.value[0], v.value[1], v.value[2]);
                std::copy_n(v.value.begin(), 3, unitNormal);
            }
        }
        colour[0] = c.r;
        colour[1] = c.g;
        colour[2] = c.b;
    }

    // Index of the pixel whose colour a pixel takes, where one pixel in 2 x 2 is shaded.
    size_t coarsePixel(size_t at) const {
        const size_t width = size_t(frame_.width), row = at / width;
        PLUMB_ASSERT(frame_.firstRow % 2 == 0);
        const size_t corner = (row & ~size_t(1)) * width + (at % width & ~size_t(1));
        const bool inX = corner % width + 1 < width, inY = (row & ~size_t(1)) + 1 < size_t(frame_.rows);
        const int which = gpu::firstDrawn(draw_[corner] != 0, inX && draw_[corner + 1] != 0, inY && draw_[corner + width] != 0,
                                          inX && inY && draw_[corner + width + 1] != 0);
        return corner + size_t(which & 1) + (which > 1 ? width : 0);
    }

    // Attributes of a triangle at a pixel: a colour or a normal, times the sum of the weights.
    struct Attributes {
        std::array<float, 3> value{};
        float weight = 0;
        gpu::Shares shares{};  // of the corners
    };

    // Attributes of draw `d` at a pixel, not yet divided by their weight.
    Attributes attributesAt(size_t at, const gpu::DrawTriangle& d) const {
        Attributes v;
        if (choices_.shading == gpu::kShadingFlat) {
            const glm::vec4& c = attributes_[list_.triangleFace[d.source]];
            v.value = {c.x, c.y, c.z};
            v.weight = 1;
        } else if (choices_.shading >= gpu::kShadingGouraud) {
            const DrawnTriangle g(d, screen_);
            float e[3], w[3];
            for (int i = 0; i < 3; ++i) e[i] = g.whole(i, columnOf(at), rowOf(at)) + g.rho(i);
            int highest = 0;
            for (uint32_t vertex : d.vertex) highest = std::max(highest, gpu::bitsOf(screen_[vertex].z));
            for (int i = 0; i < 3; ++i) w[i] = choices_.affine ? 1.0f : screen_[d.vertex[i]].z * gpu::weightScale(highest);
            const glm::vec4 &a0 = attributes_[d.vertex[0]], &a1 = attributes_[d.vertex[1]], &a2 = attributes_[d.vertex[2]];
            for (int i = 0; i < 3; ++i) v.value[size_t(i)] = gpu::weigh(a0[i] * w[0], a1[i] * w[1], a2[i] * w[2], e[0], e[1], e[2]);
            v.weight = gpu::weigh(w[0], w[1], w[2], e[0], e[1], e[2]);
            v.shares = gpu::sharesOf(w[0], w[1], w[2], e[0], e[1], e[2]);
        }
        return v;
    }

    // Returns normal, position and direction to the eye of a pixel.
    gpu::Surface surfaceAt(size_t at, const gpu::DrawTriangle& d, const Attributes& v) const {
        gpu::Surface s{};
        s.nx = v.value[0];
        s.ny = v.value[1];
        s.nz = v.value[2];
        const float px = float(columnOf(at)) + 0.5f, py = float(rowOf(at)) + 0.5f;
        const float rx = gpu::rayAt(list_.rayOrigin.x, list_.rayX.x, list_.rayY.x, px, py);
        const float ry = gpu::rayAt(list_.rayOrigin.y, list_.rayX.y, list_.rayY.y, px, py);
        const float rz = gpu::rayAt(list_.rayOrigin.z, list_.rayX.z, list_.rayY.z, px, py);
        s.vx = -rx;
        s.vy = -ry;
        s.vz = -rz;
        gpu::seeFrom(list_.towardViewer != glm::vec3(0), list_.towardViewer, s);
        const float w = gpu::reciprocal(gpu::realOf(z_[at])) * list_.viewport.near;
        s.px = rx * w;
        s.py = ry * w;
        s.pz = rz * w;
        if (choices_.vectors != gpu::kVectorsPixel && choices_.parts.specular && list_.towardViewer == glm::vec3(0)) {
            const gpu::Toward eye = directionOf(d, v.shares, [](const gpu::Position& p) { return gpu::eyeFrom(p); });
            s.vx = eye.x;
            s.vy = eye.y;
            s.vz = eye.z;
        }
        return s;
    }

private:
    int64_t columnOf(size_t at) const { return int64_t(at % size_t(frame_.width)); }
    int64_t rowOf(size_t at) const { return int64_t(at / size_t(frame_.width)) + frame_.firstRow; }

    // Returns a direction as `toward` makes it at a point: of the triangle's face, or interpolated between its corners.
    template <class Toward>
    gpu::Toward directionOf(const gpu::DrawTriangle& d, const gpu::Shares& shares, const Toward& toward) const {
        if (choices_.vectors == gpu::kVectorsFace) {
            const glm::vec4& p = list_.faceCentres[list_.triangleFace[d.source]];
            return toward(gpu::Position{p.x, p.y, p.z});
        }
        gpu::Toward t[3];
        for (int i = 0; i < 3; ++i) {
            const gpu::ScreenVertex& v = screen_[d.vertex[i]];
            t[i] = toward(gpu::positionOfCorner(v.x, v.y, v.z, list_.viewport.near, list_.rayOrigin, list_.rayX, list_.rayY));
        }
        return gpu::Toward{gpu::shared3(shares, t[0].x, t[1].x, t[2].x), gpu::shared3(shares, t[0].y, t[1].y, t[2].y),
                           gpu::shared3(shares, t[0].z, t[1].z, t[2].z), gpu::shared3(shares, t[0].fade, t[1].fade, t[2].fade)};
    }

    void addLights(const gpu::DrawTriangle& d, const gpu::MaterialRecord& m, const Attributes& v, const gpu::Surface& s,
                   gpu::Colour& c) const {
        for (const gpu::LightRecord& light : list_.lights) {
            const glm::vec4 position(light.position, light.kind), intensity(light.intensity, light.attenuation);
            if (choices_.vectors == gpu::kVectorsPixel || light.kind == 0) {
                gpu::addLight(position, intensity, s, reflectanceOf(m), choices_.parts, c);
            } else {
                const auto lamp = [&](const gpu::Position& p) { return gpu::lampFrom(position, light.attenuation, p); };
                gpu::addLightFrom(directionOf(d, v.shares, lamp), intensity, s, reflectanceOf(m), choices_.parts, c);
            }
        }
    }

    const gpu::FrameBox& frame_;
    const DrawList& list_;
    const FillChoices& choices_;
    std::span<const gpu::DrawTriangle> draws_;
    std::span<const gpu::ScreenVertex> screen_;
    std::span<const glm::vec4> attributes_;
    std::span<const int> z_;
    std::span<const uint32_t> draw_;
};

}  // namespace plumb
