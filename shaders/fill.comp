// SPDX-License-Identifier: MIT
// Fill, shade and encode in one kernel. Eight invocations a tile of 16 x 8 pixels, one invocation 4 x 4 pixels: z and triangle of
// each pixel stay in registers while the tile's list is walked, then each pixel is shaded once and written once.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef PLUMB_SHUFFLE
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/fill.h"
#include "shared/shade.h"
#include "shared/encode.h"
#include "edges.glsl"

layout(constant_id = 2) const uint kShading = 3u;         // kShadingUnlit ... kShadingPhong
layout(constant_id = 3) const bool kDiffuse = true;
layout(constant_id = 4) const bool kSpecular = true;
layout(constant_id = 5) const bool kPointLights = true;
layout(constant_id = 6) const bool kOneMaterial = false;
layout(constant_id = 7) const bool kOneLight = false;
layout(constant_id = 8) const uint kEncoding = 0u;
layout(constant_id = 9) const uint kPlanes = 0u;          // kFillPlane bits that the plane buffer holds
layout(constant_id = 10) const bool kPrior = false;       // planes hold what earlier chunks and slices drew
layout(constant_id = 11) const bool kWide = false;        // some triangle of the chunk needs the 64-bit set-up
layout(constant_id = 12) const bool kColour = true;       // write the encoded pixel
layout(constant_id = 13) const uint kWrite = 0u;          // of kPlanes: to write

layout(push_constant, scalar) uniform Push { FillPush push; };
layout(binding = 1) uniform usamplerBuffer draws;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3) uniform samplerBuffer carried;        // normals, or colours of vertices or faces
layout(binding = 4) uniform usamplerBuffer tileRecords;   // tile x | y << 16, first entry, entries
layout(binding = 5) uniform usamplerBuffer entries;
layout(binding = 6) uniform usamplerBuffer triangleMaterials;  // per triangle of the chunk: material, or face when flat
layout(binding = 7) uniform samplerBuffer materials;
layout(binding = 8) uniform samplerBuffer lights;
layout(binding = 9) uniform usamplerBuffer encodeTable;
layout(binding = 10, scalar) buffer Colours { uvec4 colours[]; };
layout(binding = 11, scalar) buffer Planes { uvec4 planes[]; };

const uint kSlotTriangle = (kPlanes & kFillPlaneZ) != 0u ? 1u : 0u;
const uint kSlotLinear = kSlotTriangle + ((kPlanes & kFillPlaneTriangle) != 0u ? 1u : 0u);
const uint kSlotNormal = kSlotLinear + ((kPlanes & kFillPlaneLinear) != 0u ? 3u : 0u);

void edgesAt(ivec2 centre, ivec2 p0, ivec2 p1, ivec2 p2, out Edges e) {
    if (kWide) wideEdges(p0 - centre, p1 - centre, p2 - centre, e);
    else narrowEdges(p0 - centre, p1 - centre, p2 - centre, e);
}

// e rounded once, at 4 pixels (x .. x + 3, y) from the block's corner.
vec4 edgeReal(int hi, int lo, int a, int b, int y) {
    ivec4 low = ivec4(lo + b * y) + ivec4(0, a, 2 * a, 3 * a);
    if (!kWide) return vec4(low);
    ivec4 high = ivec4(hi) + (low >> 16);
    return vec4(high) * 65536.0 + vec4(low & 0xffff);
}

float edgeScalar(int hi, int lo) { return kWide ? float(hi) * 65536.0 + float(lo) : float(lo); }

// Corners of a drawn triangle interpolated at one pixel centre: xyz times w, and the weights' sum in w.
vec4 interpolate(uvec4 d, ivec2 centre) {
    uvec4 v0 = texelFetch(screen, int(d.x));
    uvec4 v1 = texelFetch(screen, int(d.y));
    uvec4 v2 = texelFetch(screen, int(d.z));
    Edges e;
    edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
    float g0 = edgeScalar(e.hi.x, e.lo.x) + float(e.rho.x) * 0.00390625;
    float g1 = edgeScalar(e.hi.y, e.lo.y) + float(e.rho.y) * 0.00390625;
    float g2 = edgeScalar(e.hi.z, e.lo.z) + float(e.rho.z) * 0.00390625;
    int highest = max(max(int(v0.z), int(v1.z)), int(v2.z));
    float scale = weightScale(highest);
    float w0 = uintBitsToFloat(v0.z) * scale, w1 = uintBitsToFloat(v1.z) * scale, w2 = uintBitsToFloat(v2.z) * scale;
    vec3 a0 = texelFetch(carried, int(d.x)).xyz;
    vec3 a1 = texelFetch(carried, int(d.y)).xyz;
    vec3 a2 = texelFetch(carried, int(d.z)).xyz;
    return vec4(weigh(a0.x, a1.x, a2.x, w0, w1, w2, g0, g1, g2), weigh(a0.y, a1.y, a2.y, w0, w1, w2, g0, g1, g2),
                weigh(a0.z, a1.z, a2.z, w0, w1, w2, g0, g1, g2), weightSum(w0, w1, w2, g0, g1, g2));
}

Int encode(Real x) {
    if (kEncoding == kEncodeLinear) return encodeLinear(x);
    Real clamped = clampUnit(x);
    Int bucket = encodeBucket(clamped);
    Int word = Int(texelFetch(encodeTable, bucket.x).x, texelFetch(encodeTable, bucket.y).x,
                   texelFetch(encodeTable, bucket.z).x, texelFetch(encodeTable, bucket.w).x);
    return encodeInBucket(clamped, word);
}

void main() {
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    // lavapipe gives each thread a contiguous half of the workgroups: interleave them so that both halves weigh the same.
    uint half_ = groups >> 1u;
    group = group < half_ ? group * 2u : group < half_ * 2u ? (group - half_) * 2u + 1u : group;
    uint item = group * 8u + (gl_LocalInvocationIndex >> 3u);
    bool mine = item < push.tileCount;
    uvec4 tile = texelFetch(tileRecords, int(min(item, push.tileCount - 1u)));
    int lane = int(gl_LocalInvocationIndex & 7u);
    ivec2 block = ivec2(tile.x & 0xffffu, tile.x >> 16u) * ivec2(kTileWidth, kTileHeight) + ivec2((lane & 3) * 4, (lane >> 2) * 4);
    ivec2 pixel = block + ivec2(0, push.firstRow);
    ivec2 centre = pixel * kSubpixels + kHalfPixel;
    uint at = uint(block.y) * push.rowQuads + uint(block.x >> 2);

    ivec4 z[4];
    ivec4 id[4];
    for (int r = 0; r < 4; ++r) {
        z[r] = kPrior ? ivec4(planes[at + uint(r) * push.rowQuads]) : ivec4(0);
        id[r] = ivec4(0);
    }

    int first = int(tile.y);
    int count = int(tile.z);
    int k = 0;
    do {
        int draw = int(texelFetch(entries, first + min(k, count - 1)).x);
        uvec4 d = texelFetch(draws, draw);
        uvec4 v0 = texelFetch(screen, int(d.x));
        uvec4 v1 = texelFetch(screen, int(d.y));
        uvec4 v2 = texelFetch(screen, int(d.z));
        Edges e;
        edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
        DepthPlane depth = depthPlane(uintBitsToFloat(v0.z), uintBitsToFloat(v1.z), uintBitsToFloat(v2.z), e.sumE,
                                      float(e.rho.x) * 0.00390625, float(e.rho.y) * 0.00390625, float(e.rho.z) * 0.00390625);
        int name = draw + 1;
        for (int r = 0; r < 4; ++r) {
            ivec4 along = ivec4(0, 1, 2, 3);
            ivec4 inside = (along * e.a.x + (e.q.x + r * e.b.x)) | (along * e.a.y + (e.q.y + r * e.b.y)) |
                           (along * e.a.z + (e.q.z + r * e.b.z));
            ivec4 here = depthBits(edgeReal(e.hi.z, e.lo.z, e.a.z, e.b.z, r), edgeReal(e.hi.x, e.lo.x, e.a.x, e.b.x, r),
                                   depth.k1, depth.k2, depth.zc, depth.low, depth.high);
            // wins(): here > z, or equal and the lower triangle; both operands are bits of floats in [0, 1].
            ivec4 key = here + ivec4(lessThan(ivec4(name), id[r]));
            bvec4 win = lessThan((z[r] - key) & ~inside, ivec4(0));
            z[r] = mix(z[r], here, win);
            id[r] = mix(id[r], ivec4(name), win);
        }
        k++;
    } while (k < count);

    ShadeParts parts = ShadeParts(kDiffuse, kSpecular, kPointLights);
    int lightCount = kOneLight ? 1 : int(push.lightCount);
    uint fault = k < count ? kFaultLoop : 0u;
    for (int r = 0; r < 4; ++r) {
        ivec4 source, material, face;
        mat4 value;   // a column a pixel
        for (int c = 0; c < 4; ++c) {
            uvec4 d = texelFetch(draws, max(id[r][c] - 1, 0));
            source[c] = int(d.w);
            material[c] = kOneMaterial && kShading != kShadingFlat ? 0 : int(texelFetch(triangleMaterials, int(d.w)).x);
            if (kShading == kShadingFlat) value[c] = texelFetch(carried, int(push.flatColours) + material[c]);
            if (kShading >= kShadingGouraud) value[c] = interpolate(d, centre + ivec2(c, r) * kSubpixels);
        }
        value = transpose(value);
        Real x = vec4(float(pixel.x) + 0.5) + vec4(0.0, 1.0, 2.0, 3.0);
        float y = float(pixel.y + r) + 0.5;
        Colour c;
        vec4 nx = value[0];
        vec4 ny = value[1];
        vec4 nz = value[2];
        if (kShading == kShadingGouraud) {
            vec4 inverse = reciprocal(value[3]);
            c = Colour(value[0] * inverse, value[1] * inverse, value[2] * inverse);
        } else if (kShading == kShadingFlat) {
            c = Colour(value[0], value[1], value[2]);
        } else {
            mat4 a, d, s;
            if (kOneMaterial) {
                vec4 m = texelFetch(materials, 0);
                a = mat4(m, m, m, m);
                m = texelFetch(materials, 1);
                d = mat4(m, m, m, m);
                m = texelFetch(materials, 2);
                s = mat4(m, m, m, m);
            } else {
                for (int i = 0; i < 4; ++i) {
                    a[i] = texelFetch(materials, material[i] * kMaterialTexels);
                    d[i] = texelFetch(materials, material[i] * kMaterialTexels + 1);
                    s[i] = texelFetch(materials, material[i] * kMaterialTexels + 2);
                }
            }
            a = transpose(a);
            d = transpose(d);
            s = transpose(s);
            if (kShading == kShadingUnlit) {
                c = Colour(d[0], d[1], d[2]);
            } else {
                c = Colour(a[0], a[1], a[2]);
                Surface surface;
                Real rx = rayAt(push.rayOrigin.x, push.rayX.x, push.rayY.x, x, y);
                Real ry = rayAt(push.rayOrigin.y, push.rayX.y, push.rayY.y, x, y);
                Real rz = rayAt(push.rayOrigin.z, push.rayX.z, push.rayY.z, x, y);
                unitVector(nx, ny, nz);
                surface.nx = nx;
                surface.ny = ny;
                surface.nz = nz;
                surface.px = rx;
                surface.py = ry;
                surface.pz = rz;
                surface.vx = -rx;
                surface.vy = -ry;
                surface.vz = -rz;
                if (kSpecular) unitVector(surface.vx, surface.vy, surface.vz);
                if (kPointLights) {
                    Real w = reciprocal(realOf(max(z[r], ivec4(1)))) * push.near;
                    surface.px = rx * w;
                    surface.py = ry * w;
                    surface.pz = rz * w;
                }
                Reflectance k = Reflectance(d[0], d[1], d[2], s[0], s[1], s[2], a[3], d[3]);
                int light = 0;
                if (kOneLight) {
                    addLight(texelFetch(lights, 0), texelFetch(lights, 1), surface, k, parts, c);
                    light = 1;
                } else {
                    do {
                        if (light < lightCount)
                            addLight(texelFetch(lights, light * kLightTexels), texelFetch(lights, light * kLightTexels + 1),
                                     surface, k, parts, c);
                        light++;
                    } while (light < lightCount);
                }
                fault |= light < lightCount ? kFaultLoop : 0u;
            }
        }
        bvec4 drawn = notEqual(id[r], ivec4(0));
        uint rowAt = at + uint(r) * push.rowQuads;
        if (kColour) {
            uvec4 word = uvec4(encode(c.r) | (encode(c.g) << 8) | (encode(c.b) << 16)) | 0xff000000u;
            uvec4 behind = kPrior ? colours[rowAt] : uvec4(push.background);
            if (mine) colours[rowAt] = mix(behind, word, drawn);
        }
        if ((kWrite & kFillPlaneZ) != 0u && mine) planes[rowAt] = uvec4(z[r]);
        if ((kWrite & kFillPlaneTriangle) != 0u) {
            uint slot = rowAt + kSlotTriangle * push.planeQuads;
            uvec4 behind = kPrior ? planes[slot] : uvec4(kNoTriangle);
            if (mine) planes[slot] = mix(behind, uvec4(source) + push.firstTriangle, drawn);
        }
        if ((kWrite & kFillPlaneLinear) != 0u) {
            uint slot = rowAt + kSlotLinear * push.planeQuads;
            for (uint i = 0u; i < 3u; ++i) {
                vec4 behind = kPrior ? uintBitsToFloat(planes[slot]) : vec4(push.backgroundLinear[i]);
                vec4 value = i == 0u ? c.r : i == 1u ? c.g : c.b;
                if (mine) planes[slot] = floatBitsToUint(mix(behind, value, drawn));
                slot += push.planeQuads;
            }
        }
        if ((kWrite & kFillPlaneNormal) != 0u) {
            uint slot = rowAt + kSlotNormal * push.planeQuads;
            for (uint i = 0u; i < 3u; ++i) {
                vec4 behind = kPrior ? uintBitsToFloat(planes[slot]) : vec4(0.0);
                vec4 value = i == 0u ? nx : i == 1u ? ny : nz;
                if (mine) planes[slot] = floatBitsToUint(mix(behind, value, drawn));
                slot += push.planeQuads;
            }
        }
    }
    finish(push.statusSlot, fault);
}
