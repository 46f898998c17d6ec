// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/rounding.h"

#include "host/error.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/plain_floats.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

// The contract of illumination once more, with double for float. Functions that work on the bits of a float have an overload here that
// computes what they mean. Every function of the contract is a template without parameters, so that overloads are preferred.
#undef PLUMB_SHADE_H
#undef SHARED_BEGIN
#undef SHARED_FN
#define SHARED_BEGIN namespace plumb::reread {
#define SHARED_FN       \
    template <class...> \
    inline
namespace plumb::reread {
using uint = uint32_t;
using Real = double;
using Int = int;
using Bool = bool;
using dvec3 = glm::dvec3;
using dvec4 = glm::dvec4;
inline double pick(bool c, double yes, double no) { return c ? yes : no; }
inline bool gt(double a, double b) { return a > b; }
inline bool same(int a, int b) { return a == b; }
inline double real(double x) { return x; }
inline double nativePow(double x, double y) { return std::pow(x, y); }
inline double reciprocalRoot(double x) { return x > 0 ? 1 / std::sqrt(x) : 0x1p120; }
inline double reciprocal(double x) { return 1 / x; }
inline double specularPower(double delta, double n, double zeroPower) {
    return delta < 1 ? std::exp(n * std::log1p(-std::min(delta, 1 - 0x1p-20))) : zeroPower;
}
// Only so that the bodies that these replace are well formed.
inline int bitsOf(double x) { return int(x); }
inline double realOf(int i) { return i; }
inline double toReal(int i) { return i; }
inline int toInt(double x) { return int(x); }
inline int shiftLeft(int x, int n) { return x << n; }
inline double floorReal(double x) { return std::floor(x); }
}  // namespace plumb::reread
#define float double
#define vec3 dvec3
#define vec4 dvec4
#include "shaders/shared/shade.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>
#undef float
#undef vec3
#undef vec4

namespace plumb {

namespace {

using glm::dvec3;
using glm::dvec4;

// IEC 61966-2-1, in steps of 1/255.
double codeOf(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

double alongRow(const glm::vec4& row, const glm::vec4& p) {
    return double(row.x) * double(p.x) + double(row.y) * double(p.y) + double(row.z) * double(p.z);
}

// A row of a more accurate transform, in binary64.
double alongLongRow(const gpu::LongRow& row, const glm::vec4& p) {
    const auto number = [](uint32_t low, uint32_t high) { return std::bit_cast<double>(uint64_t(high) << 32 | low); };
    return number(row.double01.x, row.double01.y) * double(p.x) + number(row.double01.z, row.double01.w) * double(p.y) +
           number(row.double23.x, row.double23.y) * double(p.z) + number(row.double23.z, row.double23.w);
}

class Reread {
public:
    Reread(const Scene& scene, const RenderRequest& request)
        : p_(prepare(scene, request)), g_(twinGeometry(p_.list, p_.choices, false, threadCount(request.threads))) {
        const DrawList& list = p_.list;
        const bool gouraud = p_.choices.shading == gpu::kShadingGouraud;
        z_.resize(g_.screen.size());
        attributes_.resize(g_.screen.size());
        for (size_t i = 0; i < g_.screen.size(); ++i) {  // clipped corners stay as they are: where an edge was cut is a decision
            z_[i] = double(g_.screen[i].z);
            attributes_[i] = dvec3(g_.attributes[i]);
        }
        faces_.resize(list.facePositions.size());
        for (const DrawList::Range& r : list.ranges) {
            const gpu::ObjectRecord& o = list.objects[r.record];
            for (uint32_t v = r.firstVertex; v < r.firstVertex + r.vertexCount; ++v) {
                const double w = r.precision == Precision::fp32 ? alongRow(o.rowW, list.positions[v]) + double(o.rowW.w)
                                                                : alongLongRow(list.longs[r.record].w, list.positions[v]);
                if (g_.screen[v].outcode == 0) z_[v] = double(list.viewport.near) / w;
                attributes_[v] =
                    gouraud ? lit(o, list.positions[v], list.normals[v], list.vertexMaterial[v]) : normalOf(o, list.normals[v]);
                if (!gouraud && !p_.choices.unitNormals) attributes_[v] *= reread::reciprocalRoot(glm::dot(attributes_[v], attributes_[v]));
            }
            if (p_.choices.shading == gpu::kShadingFlat)
                for (uint32_t f = r.firstFace; f < r.firstFace + r.faceCount; ++f)
                    faces_[f] = lit(o, list.facePositions[f], list.faceNormals[f], list.faceMaterial[f]);
        }
    }

    const Prepared& prepared() const { return p_; }
    const TwinGeometry& geometry() const { return g_; }

    dvec3 at(const gpu::DrawTriangle& d, int64_t column, int64_t row, int zBits) const {
        const DrawList& list = p_.list;
        const gpu::MaterialRecord& m = list.materials[list.triangles[d.source].w];
        const uint32_t shading = p_.choices.shading;
        if (shading == gpu::kShadingUnlit) return dvec3(m.diffuse);
        if (shading == gpu::kShadingFlat) return faces_[list.triangleFace[d.source]];
        // Edge values are integers: exact in binary64.
        double e[3], weights = 0, z = 0;
        for (size_t i = 0; i < 3; ++i) {
            const gpu::ScreenVertex &a = g_.screen[d.vertex[(i + 1) % 3]],
                                    &b = g_.screen[d.vertex[(i + 2) % 3]];  // of the edge across corner i
            const int64_t px = column * gpu::kSubpixels + gpu::kHalfPixel - a.x, py = row * gpu::kSubpixels + gpu::kHalfPixel - a.y;
            e[i] = double(int64_t(b.y - a.y) * px + int64_t(a.x - b.x) * py);
            weights += e[i];
        }
        for (size_t i = 0; i < 3; ++i) z += e[i] / weights * z_[d.vertex[i]];
        // A coarser depth is a choice, not a rounding.
        if (p_.choices.depthBits != 32) z = double(gpu::realOf(zBits));
        dvec3 sum(0), shares(0);
        for (int i = 0; i < 3; ++i) {
            shares[i] = e[i] * (p_.choices.affine ? 1 : z_[d.vertex[i]]);
            sum += attributes_[d.vertex[i]] * shares[i];
        }
        const double share = shares.x + shares.y + shares.z;
        sum /= share;
        shares /= share;
        if (shading == gpu::kShadingGouraud) return sum;
        if (p_.choices.unitNormals) sum *= reread::reciprocalRoot(glm::dot(sum, sum));
        const dvec3 ray = dvec3(list.rayOrigin) + dvec3(list.rayX) * (double(column) + 0.5) + dvec3(list.rayY) * (double(row) + 0.5);
        if (p_.choices.vectors != gpu::kVectorsPixel) return shadeByVectors(d, m, sum, shares);
        return shadeAt(m, sum, -ray, ray * (double(list.viewport.near) / z));
    }

private:
    dvec3 normalOf(const gpu::ObjectRecord& o, const glm::vec4& n) const {
        return {alongRow(o.normal0, n), alongRow(o.normal1, n), alongRow(o.normal2, n)};
    }

    dvec3 lit(const gpu::ObjectRecord& o, const glm::vec4& position, const glm::vec4& normal, uint32_t material) const {
        const dvec3 p(alongRow(o.world0, position) + double(o.world0.w), alongRow(o.world1, position) + double(o.world1.w),
                      alongRow(o.world2, position) + double(o.world2.w));
        dvec3 n = normalOf(o, normal);
        n *= reread::reciprocalRoot(glm::dot(n, n));
        return shadeAt(p_.list.materials[material], n, -p, p);
    }

    // Directions of the face or of the corners (shaders/shared/vectors.h).
    dvec3 shadeByVectors(const gpu::DrawTriangle& d, const gpu::MaterialRecord& m, const dvec3& n, const dvec3& shares) const {
        const DrawList& list = p_.list;
        const bool face = p_.choices.vectors == gpu::kVectorsFace;
        dvec3 points[3];
        for (int i = 0; i < 3; ++i) {
            const gpu::ScreenVertex& v = g_.screen[d.vertex[i]];
            points[i] = face ? dvec3(list.faceCentres[list.triangleFace[d.source]])
                             : (dvec3(list.rayOrigin) + dvec3(list.rayX) * (double(v.x) / gpu::kSubpixels) +
                                dvec3(list.rayY) * (double(v.y) / gpu::kSubpixels)) *
                                   (double(list.viewport.near) / z_[d.vertex[i]]);
        }
        const auto made = [&](const auto& toward) {
            reread::Toward t{};
            for (int i = 0; i < 3; ++i) {
                const reread::Toward at = toward(points[i]);
                const double share = face ? double(i == 0) : shares[i];
                t = {t.x + share * at.x, t.y + share * at.y, t.z + share * at.z, t.fade + share * at.fade};
            }
            return t;
        };
        const reread::Toward eye = made([](const dvec3& p) {
            const dvec3 unit = -p * reread::reciprocalRoot(glm::dot(p, p));
            return reread::Toward{unit.x, unit.y, unit.z, 1};
        });
        const reread::Surface s{n.x, n.y, n.z, eye.x, eye.y, eye.z, 0, 0, 0};
        reread::Colour c{double(m.base.x), double(m.base.y), double(m.base.z)};
        for (const gpu::LightRecord& light : list.lights) {
            const dvec4 position(glm::dvec3(light.position), double(light.kind)),
                intensity(glm::dvec3(light.intensity), double(light.attenuation));
            const auto lamp = [&](const dvec3& p) {
                reread::Toward t = reread::towardLight(position, intensity.w, true, p.x, p.y, p.z);
                if (!(t.fade < 0x1p100)) t.fade = 0;
                return t;
            };
            reread::addLightFrom(light.kind == 0 ? lamp(dvec3(0)) : made(lamp), intensity, s, reflects(m), partsRead(), c);
        }
        return {c.r, c.g, c.b};
    }

    reread::ShadeParts partsRead() const {
        const gpu::ShadeParts& parts = p_.choices.parts;
        return {parts.diffuse, parts.specular, parts.point, parts.power};
    }
    static reread::Reflectance reflects(const gpu::MaterialRecord& m) {
        return {double(m.diffuse.x),  double(m.diffuse.y),  double(m.diffuse.z), double(m.specular.x),
                double(m.specular.y), double(m.specular.z), double(m.shininess), double(m.zeroPower)};
    }

    dvec3 shadeAt(const gpu::MaterialRecord& m, const dvec3& n, dvec3 toEye, const dvec3& p) const {
        toEye *= reread::reciprocalRoot(glm::dot(toEye, toEye));
        const reread::Surface s{n.x, n.y, n.z, toEye.x, toEye.y, toEye.z, p.x, p.y, p.z};
        const reread::Reflectance k = reflects(m);
        reread::Colour c{double(m.base.x), double(m.base.y), double(m.base.z)};
        for (const gpu::LightRecord& light : p_.list.lights)
            reread::addLight(dvec4(glm::dvec3(light.position), double(light.kind)),
                             dvec4(glm::dvec3(light.intensity), double(light.attenuation)), s, k, partsRead(), c);
        return {c.r, c.g, c.b};
    }

    Prepared p_;
    TwinGeometry g_;
    std::vector<double> z_;          // n/w of vertices
    std::vector<dvec3> attributes_;  // normals, or colours
    std::vector<dvec3> faces_;       // colours, flat
};

}  // namespace

std::optional<Rounding> roundingOf(const Scene& scene, const RenderRequest& request, const Frame& frame) {
    const PlainFloats plain;
    if (techniqueOf(scene, request).vertices != Technique::Vertices::transformPass || request.distantViewer) return {};
    const Reread again(scene, request);
    const Prepared& p = again.prepared();
    if (p.choices.coarse) return {};
    const size_t pixels = size_t(frame.width) * frame.height;
    PLUMB_ASSERT(frame.width == p.width && frame.height == p.height && frame.linear.size() == 3 * pixels);
    const uint32_t side = p.side, threads = threadCount(request.threads);
    // -1: shows nothing.
    std::vector<float> steps(pixels, -1.0f), linear(pixels, 0.0f);
    constexpr uint32_t kBandRows = 64;  // pixels at once: what fillCpu takes memory for
    for (uint32_t firstRow = 0; firstRow < p.height; firstRow += kBandRows) {
        const uint32_t rows = std::min(kBandRows, p.height - firstRow);
        gpu::FrameBox band = p.list.frame;
        band.firstRow = int(firstRow * side);
        band.rows = int(rows * side);
        const size_t samples = size_t(band.width) * size_t(band.rows);
        std::vector<int> z(samples);
        std::vector<uint32_t> draw(samples);
        fillCpu(band, again.geometry().draws, again.geometry().screen, z, draw, threads, p.choices.depthBits);
        parallelBands(rows, 4, threads, [&](uint64_t begin, uint64_t end) {
            for (uint64_t y = begin; y < end; ++y)
                for (uint32_t x = 0; x < p.width; ++x) {
                    dvec3 sum(0);
                    uint32_t covered = 0;
                    for (uint32_t k = 0; k < side * side; ++k) {
                        const size_t column = size_t(x) * side + k % side, row = size_t(y) * side + k / side,
                                     at = row * size_t(band.width) + column;
                        if (draw[at] == 0) {
                            if (!request.transparent || side == 1) sum += dvec3(request.background);
                            continue;
                        }
                        ++covered;
                        sum += again.at(again.geometry().draws[draw[at] - 1], int64_t(column), int64_t(row) + band.firstRow, z[at]);
                    }
                    if (covered == 0) continue;
                    sum /= double(request.transparent && side > 1 ? covered : side * side);
                    const size_t pixel = size_t(firstRow + y) * p.width + x;
                    double code = 0, light = 0;
                    for (int c = 0; c < 3; ++c) {
                        const double drawn = double(frame.linear[3 * pixel + size_t(c)]);
                        code = std::max(code, std::abs(codeOf(drawn) - codeOf(sum[c])));
                        light = std::max(light, std::abs(drawn - sum[c]));
                    }
                    steps[pixel] = float(code);
                    linear[pixel] = float(light);
                }
        });
    }
    Rounding r;
    std::vector<float> known;
    double squares = 0;
    for (size_t at = 0; at < pixels; ++at) {
        if (steps[at] < 0) continue;
        const double s = double(steps[at]);
        if (known.empty() || s > r.max) r.max = s, r.x = uint32_t(at % p.width), r.y = uint32_t(at / p.width);
        known.push_back(steps[at]);
        r.mean += s;
        squares += s * s;
        r.linearMax = std::max(r.linearMax, double(linear[at]));
    }
    r.pixels = known.size();
    if (known.empty()) return r;
    r.mean /= double(known.size());
    r.rms = std::sqrt(squares / double(known.size()));
    const size_t rank = (known.size() * 99 + 99) / 100 - 1;
    std::nth_element(known.begin(), known.begin() + ptrdiff_t(rank), known.end());
    r.p99 = double(known[rank]);
    return r;
}

}  // namespace plumb
