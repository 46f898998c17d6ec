// SPDX-License-Identifier: MIT
// Fill, shade and encode in one kernel. Eight invocations a tile of 16 x 8 pixels, one invocation 4 x 4 pixels: z and triangle of
// each pixel stay in registers while the tile's list is walked, then each pixel is shaded once and written once.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifdef PLUMB_SHUFFLE
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/fill.h"
#include "shared/shade.h"
#include "shared/encode.h"
#ifdef PLUMB_VECTORS
#include "shared/vectors.h"
#endif
#include "edges.glsl"

layout(constant_id = 2) const uint kShading = 3u;  // kShadingUnlit ... kShadingPhong
layout(constant_id = 3) const bool kDiffuse = true;
layout(constant_id = 4) const bool kSpecular = true;
layout(constant_id = 5) const bool kPointLights = true;
layout(constant_id = 6) const bool kOneMaterial = false;
layout(constant_id = 7) const uint kLightCount = 0u;  // 1 to kUnrolledLights: known, and unrolled; 0: as push.lightCount says
layout(constant_id = 8) const uint kEncoding = 0u;
layout(constant_id = 9) const uint kPlanes = 0u;     // kFillPlane bits that the plane buffer holds
layout(constant_id = 10) const bool kPrior = false;  // planes hold what earlier chunks and slices drew
layout(constant_id = 11) const bool kWide = false;   // some triangle of the chunk needs the 64-bit set-up
layout(constant_id = 12) const bool kColour = true;  // write the encoded pixel
layout(constant_id = 13) const uint kWrite = 0u;     // of kPlanes: to write
#ifdef PLUMB_SHUFFLE
layout(constant_id = 14) const uint kSubgroupSize = 8u;  // 8, 16, 32 or 64: clusters of 8 share a tile
#endif

layout(constant_id = 15) const uint kPower = 0u;       // kPowerExact or kPowerSchlick
layout(constant_id = 16) const bool kAffine = false;   // attributes without perspective
layout(constant_id = 17) const uint kDepthBits = 32u;  // 32: float; 33: float of 1 - n/w; else fixed point
layout(constant_id = 18) const bool kDistantViewer = false;
layout(constant_id = 20) const bool kUnitNormals = true;  // false: as interpolated
layout(constant_id = 21) const bool kCoarse = false;      // one shaded pixel in 2 x 2
layout(constant_id = 25) const bool kOne = false;         // every list of the dispatch has one entry: no loops
layout(constant_id = 24) const uint kLightKinds = 0u;     // with kLightCount: as lightKinds() of fill.h

layout(push_constant, scalar) uniform Push { FillPush push; };
layout(binding = 1) uniform usamplerBuffer draws;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3) uniform samplerBuffer attributes;    // normals, or colours of vertices or faces
layout(binding = 4) uniform usamplerBuffer tileRecords;  // tile x | y << 16, first entry, entries
layout(binding = 5) uniform usamplerBuffer entries;
layout(binding = 6) uniform usamplerBuffer triangleMaterials;  // per triangle of the chunk: material, or face when flat
layout(binding = 7) uniform samplerBuffer materials;
layout(binding = 8) uniform samplerBuffer lights;
layout(binding = 9) uniform usamplerBuffer encodeTable;
layout(binding = 10, scalar) buffer Colours { uvec4 colours[]; };
layout(binding = 11, scalar) buffer Planes { uvec4 planes[]; };

#ifdef PLUMB_VECTORS                                         // directions of faces or vertices; by choice only
layout(constant_id = 30) const uint kVectors = 1u;           // kVectorsFace or kVectorsVertex
layout(binding = 12) uniform samplerBuffer triangleCentres;  // of each triangle of the chunk: its face's centre, relative to the eye
Toward towardEye[4];                                         // of each row of pixels
Toward towardLamp[kUnrolledLights * 4u];                     // 4 light + row

// Takes the direction of one triangle to the pixels that show it (`here`). `from`: directions at the corners in components 0 to 2, or one
// direction in all.
void interpolateVector(inout Toward to, Toward from, Shares s, bvec4 here) {
    if (kVectors == kVectorsVertex) {
        from = Toward(shared3(s, from.x.x, from.x.y, from.x.z), shared3(s, from.y.x, from.y.y, from.y.z),
                      shared3(s, from.z.x, from.z.y, from.z.z), shared3(s, from.fade.x, from.fade.y, from.fade.z));
    }
    to = Toward(mix(to.x, from.x, here), mix(to.y, from.y, here), mix(to.z, from.z, here), mix(to.fade, from.fade, here));
}
#endif

const uint kSlotTriangle = (kPlanes & kFillPlaneZ) != 0u ? 1u : 0u;
const uint kSlotLinear = kSlotTriangle + ((kPlanes & kFillPlaneTriangle) != 0u ? 1u : 0u);
const uint kSlotNormal = kSlotLinear + ((kPlanes & kFillPlaneLinear) != 0u ? 3u : 0u);
const uint kSlotSum = kSlotNormal + ((kPlanes & kFillPlaneNormal) != 0u ? 3u : 0u);

void edgesAt(ivec2 centre, ivec2 p0, ivec2 p1, ivec2 p2, out Edges e) {
    if (kWide)
        wideEdges(p0 - centre, p1 - centre, p2 - centre, e);
    else
        narrowEdges(p0 - centre, p1 - centre, p2 - centre, e);
}

// e rounded once, at 4 pixels (x .. x + 3, y) from the block's corner.
vec4 edgeReal(int hi, int lo, int a, int b, int y) {
    ivec4 low = ivec4(lo + b * y) + ivec4(0, a, 2 * a, 3 * a);
    vec4 real = vec4(low);
    if (kWide) {
        ivec4 high = ivec4(hi) + (low >> 16);
        real = vec4(high) * 65536.0 + vec4(low & 0xffff);
    }
    return real;
}

#include "encode.glsl"

#ifdef PLUMB_SHUFFLE
uint clusterMax(uint v) {  // over the subgroup, so that loops over it are uniform
    v = max(v, subgroupShuffleXor(v, 1u));
    v = max(v, subgroupShuffleXor(v, 2u));
    v = max(v, subgroupShuffleXor(v, 4u));
    if (kSubgroupSize > 8u) v = max(v, subgroupShuffleXor(v, 8u));
    if (kSubgroupSize > 16u) v = max(v, subgroupShuffleXor(v, 16u));
    if (kSubgroupSize > 32u) v = max(v, subgroupShuffleXor(v, 32u));
    return v;
}
int tileMax(int v) {  // over the eight invocations of a tile
    v = max(v, subgroupShuffleXor(v, 1u));
    v = max(v, subgroupShuffleXor(v, 2u));
    return max(v, subgroupShuffleXor(v, 4u));
}
// Number of the lowest set bit of a mask of 8, by its float exponent (findLSB is slow here).
uint lowestBit(uint mask) { return uint((floatBitsToInt(float(int(mask & (0u - mask)))) >> 23) - 127); }
#endif

// Block of this invocation.
bool mine;     // false: beyond the last tile, nothing is written
int lane;      // block of the tile, row by row
ivec2 inTile;  // its first pixel, from the tile's corner
ivec2 pixel;   // its first pixel in the frame
ivec2 centre;  // the same in subpixels, at the pixel's centre
uint at;       // index of its first row in a plane
#ifdef PLUMB_SHUFFLE
uint base;  // first invocation of the tile in the subgroup
#endif

// State of the block's pixels, one element a row. Element kCopy (4) is scratch for the loop over rows.
ivec4 z[5];
ivec4 id[5];
ivec4 source[5], material[4];
vec4 attributeX[5], attributeY[5], attributeZ[5], weight[5];

#include "fill_shade.glsl"
#include "fill_list.glsl"
#include "fill_attributes.glsl"

// Returns the number of this workgroup. lavapipe gives each thread a contiguous half of the workgroups, so they are interleaved: both halves
// weigh the same.
uint interleavedGroup() {
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint halfGroups = groups >> 1u;
    return group < halfGroups ? group * 2u : group < halfGroups * 2u ? (group - halfGroups) * 2u + 1u : group;
}

// Places this invocation's block, with what earlier dispatches left of it; returns its tile.
Tile takeBlock() {
    uint group = interleavedGroup();
#ifdef PLUMB_SHUFFLE
    lane = int(gl_SubgroupInvocationID & 7u);
    base = gl_SubgroupInvocationID & ~7u;
    uint item = group * 8u + gl_SubgroupID * (kSubgroupSize >> 3u) + (gl_SubgroupInvocationID >> 3u);
#else
    lane = int(gl_LocalInvocationIndex & 7u);
    uint item = group * 8u + (gl_LocalInvocationIndex >> 3u);
#endif
    mine = item < push.tileCount;
    uvec4 record = texelFetch(tileRecords, int(min(item, push.tileCount - 1u)));
    Tile tile = Tile(ivec2(record.x & 0xffffu, record.x >> 16u) * ivec2(kTileWidth, kTileHeight), int(record.y), int(record.z));
    inTile = ivec2((lane & 3) * 4, (lane >> 2) * 4);
    ivec2 block = tile.corner + inTile;
    pixel = block + ivec2(0, push.firstRow);
    centre = pixel * kSubpixels + kHalfPixel;
    at = uint(block.y) * push.rowQuads + uint(block.x >> 2);
    [[unroll]] for (int r = 0; r < 4; ++r) {
        z[r] = kPrior ? ivec4(planes[at + uint(r) * push.rowQuads]) : ivec4(0);
        id[r] = ivec4(0);
    }
    return tile;
}

void main() {
    uint fault = 0u;
#ifdef PLUMB_SHUFFLE
    fault |= gl_SubgroupSize != kSubgroupSize ? kFaultRange : 0u;
#endif
    Tile tile = takeBlock();
    int alone = int(texelFetch(entries, tile.first).x);
    if (kOne)
        drawAlone(alone);
    else
        fault |= drawList(tile);
    interpolateVisible(alone);
    [[unroll]] for (int r = 0; r < 4; ++r) {
        unlit[r] = Colour(vec4(0.0), vec4(0.0), vec4(0.0));
        reflects[r] = Reflectance(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    }
    if (kShading == kShadingPhong || kShading == kShadingUnlit) readMaterials();
    fault |= shadeAndWrite();
    finish(push.statusSlot, fault);
}
