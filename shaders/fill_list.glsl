// SPDX-License-Identifier: MIT
// Visibility in the fill kernel: the triangles of a tile's list, and which of them each pixel shows (fill.comp).

// Alone in its tile, with nothing drawn before, a triangle wins wherever it covers: z > 0 is asked for only where a plane or a light's position needs it.
const bool kAsksDepth = !kOne || kPrior || kPointLights || kPlanes != 0u;

// One triangle at the 16 pixels of this invocation: q, a, b of its edges at the block's first pixel.
void cover(ivec3 q, ivec3 a, ivec3 b, ivec3 hi, ivec3 lo, DepthPlane depth, int name) {
    const ivec4 along = ivec4(0, 1, 2, 3);
    ivec4 f0 = along * a.x + q.x;
    ivec4 f1 = along * a.y + q.y;
    ivec4 f2 = along * a.z + q.z;
    [[unroll]] for (int r = 0; r < 4; ++r) {
        if (kAsksDepth) {
            vec4 e2 = kWide ? edgeReal(hi.z, lo.z, a.z, b.z, r) : vec4(f2);
            vec4 e0 = kWide ? edgeReal(hi.x, lo.x, a.x, b.x, r) : vec4(f0);
            ivec4 here = depthBits(e2, e0, depth.k1, depth.k2, depth.zc, depth.low, depth.high);
            if (kDepthBits < 32u) here = coarseDepth(here, kDepthBits);
            if (kDepthBits == kDepthStandard) here = standardDepth(here);
            // wins(): here > z, or equal and the lower triangle; both operands are bits of floats in [0, 1].
            ivec4 key = here + ivec4(lessThan(ivec4(name), id[r]));
            bvec4 win = lessThan((z[r] - key) & ~(f0 | f1 | f2), ivec4(0));
            z[r] = mix(z[r], here, win);
            id[r] = mix(id[r], ivec4(name), win);
        } else {
            id[r] = mix(ivec4(name), ivec4(0), lessThan(f0 | f1 | f2, ivec4(0)));
        }
        f0 += b.x;
        f1 += b.y;
        f2 += b.z;
    }
}

DepthPlane depthOf(uvec4 v0, uvec4 v1, uvec4 v2, Edges e) {
    return depthPlane(uintBitsToFloat(v0.z), uintBitsToFloat(v1.z), uintBitsToFloat(v2.z), e.sumE, float(e.rho.x) * 0.00390625,
                      float(e.rho.y) * 0.00390625, float(e.rho.z) * 0.00390625);
}

// Sets up one triangle for the pixels of this invocation and draws it.
void drawAlone(int draw) {
    uvec4 d = texelFetch(draws, draw);
    uvec4 v0 = texelFetch(screen, int(d.x));
    uvec4 v1 = texelFetch(screen, int(d.y));
    uvec4 v2 = texelFetch(screen, int(d.z));
    Edges e;
    edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
    cover(e.q, e.a, e.b, e.hi, e.lo, depthOf(v0, v1, v2, e), draw + 1);
}

// Tile of this invocation and its list of triangles.
struct Tile {
    ivec2 corner;  // first pixel
    int first;     // first of `entries`
    int count;
};

#ifdef PLUMB_SHUFFLE
// State of the walk along a tile's list.
uint walked;      // entries of it
uint longest;     // entries of the longest list of the subgroup
int hiddenBelow;  // no pixel of the tile shows a lower z

// Triangle that this invocation has set up for all invocations of its tile.
struct Candidate {
    int draw;
    bool seen;  // false: beyond the end of the list, or hidden
    Edges e;    // at the tile's first pixel
    DepthPlane depth;
};
Candidate candidate;

// Sets up the triangles of the next eight entries, one an invocation. Goes on while they are all hidden, in all tiles of the subgroup: those
// cost no pixels.
// A triangle that covers the whole tile is nowhere further than its own lowest z, and none is nearer than its own highest: both are bounds of
// the depth itself, so what lies behind is left out without changing a bit.
void nextCandidate(Tile tile) {
    ivec2 tileCentre = (tile.corner + ivec2(0, push.firstRow)) * kSubpixels + kHalfPixel;
    uvec4 v0, v1, v2;
    bool anySeen;
    do {
        candidate.draw = int(texelFetch(entries, tile.first + min(int(walked) + lane, tile.count - 1)).x);
        uvec4 d = texelFetch(draws, candidate.draw);
        v0 = texelFetch(screen, int(d.x));
        v1 = texelFetch(screen, int(d.y));
        v2 = texelFetch(screen, int(d.z));
        edgesAt(tileCentre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), candidate.e);
        ivec3 least = candidate.e.q + min(candidate.e.a, 0) * (kTileWidth - 1) + min(candidate.e.b, 0) * (kTileHeight - 1);
        hiddenBelow = max(hiddenBelow, tileMax((least.x | least.y | least.z) >= 0 ? min(min(int(v0.z), int(v1.z)), int(v2.z)) : 0));
        // Not with a coarser depth, in which what lies behind may tie and be the lower triangle.
        candidate.seen = int(walked) + lane < tile.count && (kDepthBits != 32u || max(max(int(v0.z), int(v1.z)), int(v2.z)) >= hiddenBelow);
        anySeen = clusterMax(candidate.seen ? 1u : 0u) != 0u;
        walked += 8u;
    } while (!anySeen && walked < longest);
    candidate.depth = depthOf(v0, v1, v2, candidate.e);
}

// Returns a mask of the invocations of the tile whose candidates may touch a pixel of this invocation.
uint touching() {
    ivec3 most = candidate.e.q + max(candidate.e.a, 0) * 3 + max(candidate.e.b, 0) * 3;
    uint blocks = 0u;
    [[unroll]] for (int i = 0; i < 8; ++i) {
        ivec3 there = most + candidate.e.a * ((i & 3) * 4) + candidate.e.b * ((i >> 2) * 4);
        blocks |= (there.x | there.y | there.z) >= 0 ? 1u << i : 0u;
    }
    if (!candidate.seen) blocks = 0u;
    uint todo = 0u;
    [[unroll]] for (uint i = 0u; i < 8u; ++i) todo |= ((subgroupShuffle(blocks, base | i) >> lane) & 1u) << i;
    return todo;
}

// Draws the candidates of a mask. An invocation that has none left repeats one: harmless, because a triangle drawn twice changes nothing.
void drawCandidates(uint todo) {
    uint steps = clusterMax(uint(bitCount(todo)));
    uint step = 0u;
    do {
        uint from = base | (lowestBit(todo | 128u) & 7u);
        todo &= todo - 1u;
        ivec3 a, b, q;
        a.x = subgroupShuffle(candidate.e.a.x, from);
        a.y = subgroupShuffle(candidate.e.a.y, from);
        a.z = -a.x - a.y;
        b.x = subgroupShuffle(candidate.e.b.x, from);
        b.y = subgroupShuffle(candidate.e.b.y, from);
        b.z = -b.x - b.y;
        q.x = subgroupShuffle(candidate.e.q.x, from);
        q.y = subgroupShuffle(candidate.e.q.y, from);
        q.z = subgroupShuffle(candidate.e.q.z, from);
        DepthPlane p;
        p.k1 = subgroupShuffle(candidate.depth.k1, from);
        p.k2 = subgroupShuffle(candidate.depth.k2, from);
        p.zc = subgroupShuffle(candidate.depth.zc, from);
        p.low = subgroupShuffle(candidate.depth.low, from);
        p.high = subgroupShuffle(candidate.depth.high, from);
        cover(q + a * inTile.x + b * inTile.y, a, b, ivec3(0), ivec3(0), p, subgroupShuffle(candidate.draw, from) + 1);
        step++;
    } while (step < steps);
}

// Draws the tile's list, eight triangles at a time; returns a fault.
uint drawList(Tile tile) {
    longest = clusterMax(uint(tile.count));
    hiddenBelow = 0;
    walked = 0u;
    do {
        nextCandidate(tile);
        drawCandidates(touching());
    } while (walked < longest);
    return walked < longest ? kFaultLoop : 0u;
}
#else
// Draws the tile's list; returns a fault.
uint drawList(Tile tile) {
    int k = 0;
    do {
        drawAlone(int(texelFetch(entries, tile.first + min(k, tile.count - 1)).x));
        k++;
    } while (k < tile.count);
    return k < tile.count ? kFaultLoop : 0u;
}
#endif
