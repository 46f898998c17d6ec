// SPDX-License-Identifier: MIT
// Contract of the fill pass: which triangle owns each pixel, and at what depth (docs/illumination.md, Polygons without rays).
// With edge values E_i exact integers (fixed_point.h), e_i = floor((E_i - bias_i) / 256) is an integer plane over the pixels
// and rho_i = ((E_i - bias_i) & 255) + bias_i a constant of the triangle: E_i / 256 = e_i + rho_i / 256 exactly.
// A pixel is covered when all e_i >= 0. Depth and attributes use e_i rounded once to float32.
#ifndef PLUMB_FILL_H
#define PLUMB_FILL_H
#include "setup.h"
SHARED_BEGIN

// z(p) = (e_2 k1 + e_0 k2) + zc, clamped to the triangle's own range. Edges: 0 = (v0, v1), 1 = (v1, v2), 2 = (v2, v0).
struct DepthPlane {
    float k1, k2, zc;
    int low, high;  // bits of the least and greatest z of the corners; z > 0, so bits order as values do
};

// sumE = e_0 + e_1 + e_2 rounded once; rhoI = rho_i / 256 (exact).
SHARED_FN DepthPlane depthPlane(float z0, float z1, float z2, float sumE, float rho0, float rho1, float rho2) {
    DepthPlane d;
    float inverse = exactDivide(1.0f, sumE + ((rho0 + rho1) + rho2));
    d.k1 = (z1 - z0) * inverse;
    d.k2 = (z2 - z0) * inverse;
    d.zc = z0 + (rho2 * d.k1 + rho0 * d.k2);
    float least = pick(z1 < z0, z1, z0);
    least = pick(z2 < least, z2, least);
    float most = pick(z1 > z0, z1, z0);
    most = pick(z2 > most, z2, most);
    d.low = bitsOf(least);
    d.high = bitsOf(most);
    return d;
}

SHARED_FN Int depthBits(Real e2, Real e0, float k1, float k2, float zc, int low, int high) {
    Int z = bitsOf((e2 * k1 + e0 * k2) + zc);
    return min(max(z, low), high);  // a negative float is a negative integer: below `low`
}

// Depth in fixed point of `bits` < 32 bits in place of float32: the least multiple of 2^-bits that is not below z, so what is drawn stays
// above 0. The error is below 2^-bits. Triangles whose depths become equal tie.
SHARED_FN Int coarseDepth(Int z, uint bits) {
    float steps = realOf(int((127u + bits) << 23));
    float step = realOf(int((127u - bits) << 23));
    return bitsOf(-floorReal(realOf(z) * -steps) * step);
}

// Depth as a Z-buffer of 1 - n/w in float32 keeps it: n/w itself from 1/2 up, below that the nearest multiple of 2^-24, at least 2^-24 so
// that what is drawn stays above 0. The error is below 2^-24. Only the first subtraction rounds.
SHARED_CONST uint kDepthStandard = 33u;
SHARED_FN Int standardDepth(Int z) {
    Real far = real(1.0f) - realOf(z);
    far = pick(gt(real(0.999999940395355224609375f), far), far, real(0.999999940395355224609375f));
    return bitsOf(real(1.0f) - far);
}

// True when a candidate replaces what a pixel holds: the nearest wins, at equal depth the triangle with the smaller index. So the result
// does not depend on the order of visits.
// Triangles count from 1 here. 0 stands for what an earlier dispatch left, which wins ties.
SHARED_FN bool wins(int z, int triangle, int bestZ, int bestTriangle) { return z > bestZ || (z == bestZ && triangle < bestTriangle); }

// Scale of the corners' perspective weights: it puts the nearest corner's weight in [1, 2), so that squares of weighed values stay normal.
SHARED_FN float weightScale(int highestZ) { return realOf(0x7f000000 - (highestZ & 0x7f800000)); }

// Attribute times sum(w g): the corners' values times their perspective weights (v w, rounded once) times the edge values g_i = e_i + rho_i
// / 256, added up. Normals are normalised afterwards. Colours are divided by the same sum of the weights alone.
SHARED_FN Real weigh(float vw0, float vw1, float vw2, Real g0, Real g1, Real g2) { return (g1 * vw0 + g2 * vw1) + g0 * vw2; }

// Planes that a draw can leave beside the encoded colour, in this order, only those asked for.
SHARED_CONST uint kFillPlaneZ = 1u;         // bits of z; 0 where nothing is drawn
SHARED_CONST uint kFillPlaneTriangle = 2u;  // triangle of the scene, kNoTriangle where nothing is drawn
SHARED_CONST uint kFillPlaneLinear = 4u;    // three planes
SHARED_CONST uint kFillPlaneNormal = 8u;    // three planes: world, unit
SHARED_CONST uint kFillPlaneSum = 16u;      // three planes: light added up so far, between the windows of kLightsPerWindow

// Most entries of a tile's list that one dispatch may read. An invocation may loop 65,535 times in all (lavapipe); an entry costs at most
// 10/8 rounds, a light four (one a row of the block).
// Longer lists are drawn in slices. More lights are drawn in windows: each window finds the same triangles again and continues the sum of
// the window before, in the order of the lights, so the bytes are those of one window.
SHARED_CONST uint kTileListLimit = 40000u;

// Most lights that may be specialization constants, by number and kind. lightKind() packs three bits a light: bit 0 set for a point light,
// bits 1 and 2 its attenuation.
SHARED_CONST uint kUnrolledLights = 4u;
SHARED_FN uint lightKind(uint light, bool point, uint attenuation) { return (pick(point, 1u, 0u) | attenuation << 1u) << (3u * light); }
SHARED_FN float lightIsAPoint(uint kinds, uint light) { return float((kinds >> (3u * light)) & 1u); }
SHARED_FN float lightAttenuation(uint kinds, uint light) { return float((kinds >> (3u * light + 1u)) & 3u); }

struct FillPush {
    uint statusSlot;
    uint tileCount;
    uint firstRow;                // first row of the band
    uint rowQuads;                // row pitch of the band's buffers in units of 4 pixels
    uint planeQuads;              // plane pitch
    uint firstLight, lightCount;  // lights of this window
    uint background;              // encoded colour
    uint firstTriangle;           // index in the scene of the chunk's first triangle
    float near;
    vec3 rayOrigin, rayX, rayY;  // direction to pixel (x, y), forward component 1: rayOrigin + rayX x + rayY y
    vec3 backgroundLinear;
    vec3 toward;     // unit vector toward a distant viewer, world axes; 0: the viewer is at the origin of the rays
    ivec2 frameEnd;  // first column and row (of the frame) past the band: read when shading once in 2 x 2 pixels
};

SHARED_FN Real rayAt(float origin, float perX, float perY, Real x, float y) { return (real(origin) + x * perX) + real(y * perY); }
// Direction component at pixels of several rows, as rayAt() for one row.
SHARED_FN Real rayAtEach(float origin, float perX, float perY, Real x, Real y) { return (real(origin) + x * perX) + y * perY; }

// Index of the pixel to shade in a 2 x 2 square when it is shaded once: the first covered one of (0, 0), (1, 0), (0, 1), (1, 1), whose
// colour all covered ones take. 4: none is covered.
SHARED_FN int firstDrawn(bool d00, bool d10, bool d01, bool d11) {
    int last = pick(d01, 2, pick(d11, 3, 4));
    return pick(d00, 0, pick(d10, 1, last));
}

SHARED_END
#endif
