// SPDX-License-Identifier: MIT
// Contract of the trace pass: light transport of the notes (18.1 to 18.4.3).
//   colour of a ray = local weight * Phong with shadow rays + reflect * colour of the mirrored ray + transmit * colour of the refracted
// ray.
// A ray that hits nothing has the sky's colour. The sum is taken as weight of the path * local colour, each ray before its children and the
// whole tree of the mirrored ray before that of the refracted one. This order is part of the contract, so the bytes are the same however
// rays are kept.
// The other form sums in whole levels (kCutLevels, sampling.h): along a path with one child a hit, from its end to the eye.
#ifndef PLUMB_TRACE_H
#define PLUMB_TRACE_H
#include "sampling.h"
#include "triangle.h"
SHARED_BEGIN

SHARED_CONST uint kRayDepthLimit = 64u;  // longest chain of rays; the primary ray has depth 1

// Objects that rays meet are counted in one row: spheres, planes, triangles. A mesh has, as texels:
// - two a corner: position, normal;
// - two a triangle: corners and material; bits of its geometric normal;
// - three a leaf of its BVH: a triangle's corners as bits, the first with the triangle's number;
// - two a child of a node: box low, link; box high, the child to continue with when this one is passed over or done.
// A link is a node, kLeaf + a leaf, or kNoChild; a leaf is one triangle. Child c of node n has number n kNodeChildren + c. Node 0 has one
// child, the whole tree, whose children are those of kTopNode. Leaves are numbered in the order of a walk from each node's first child to
// its last.
SHARED_CONST uint kNodeChildren = 8u;
SHARED_CONST uint kTopNode = 1u;
SHARED_CONST uint kLeaf = 0x80000000u;
SHARED_CONST uint kNoChild = 0xffffffffu;

// Material of rays in four texels.
struct TraceMaterial {
    vec3 base;  // Ka Ia + Ke
    float shininess;
    vec3 diffuse;
    float zeroPower;  // as in MaterialRecord
    vec3 specular;
    float local;                // weight of the local colour
    float reflect, transmit;    // weights; local + reflect + transmit <= 1
    float index, inverseIndex;  // refractive index of the inside, outside 1; the notes' density ratio d
};
SHARED_CONST int kTraceMaterialTexels = 4;

// Counters, exact, four words a depth: rays of each kind, and shadow rays sent from hits of rays of that depth.
SHARED_CONST uint kCountPrimary = 0u;
SHARED_CONST uint kCountReflected = 1u;
SHARED_CONST uint kCountRefracted = 2u;
SHARED_CONST uint kCountShadowRays = 3u;
SHARED_CONST uint kCountKinds = 4u;
SHARED_CONST uint kCountUndecided = 256u;   // rays parallel to a plane within rounding
SHARED_CONST uint kCountUnfinished = 257u;  // samples with waiting rays (list form)
SHARED_CONST uint kCounters = 258u;

// AOVs of a draw, in this order, only those that the request names.
SHARED_CONST uint kTracePlaneDistance = 1u;  // bits of the distance; 0 where nothing is hit
SHARED_CONST uint kTracePlaneObject = 2u;    // kNoObject where nothing is hit
SHARED_CONST uint kTracePlaneLinear = 4u;    // three planes
SHARED_CONST uint kTracePlaneNormal = 8u;    // three planes: world, unit, facing the eye

// Waiting ray in words: origin, direction, weight, object it starts on, depth << 3 | kind << 1 | inside, key of its noise.
SHARED_CONST uint kWaitingWords = 10u;
// State of a sample between two dispatches: colour so far, number of waiting rays.
SHARED_CONST uint kStateWords = 4u;

struct TracePush {
    uint statusSlot;
    uint itemCount, firstItem;  // samples of this dispatch, row by row in the frame
    uint width;                 // width of the frame
    uint firstRow;              // first row of the band: row 0 of the buffers
    uint rowWords, planeWords;  // pitch
    uint sphereCount, planeCount, lightCount;
    uint childCount;  // children of the BVH, unused ones included
    float reach;      // largest |coordinate| of a corner
    uint maxDepth;
    uint rayLimit;    // rays a sample may follow in this dispatch
    uint first;       // 1: samples begin; 0: they continue with their waiting rays (list form)
    uint background;  // encoded colour
    float minWeight;
    vec3 rayOrigin, rayX, rayY;  // direction to sample (x, y), forward component 1
    vec3 sky;
    uint seed;      // seed of the noise
    uint tileRows;  // samples come in tiles: rows of this dispatch, from row firstItem / width on
};

SHARED_FN vec3 primaryDirection(vec3 origin, vec3 perX, vec3 perY, float x, float y) { return unitLength((origin + perX * x) + perY * y); }

// Secondary rays of a hit. Total reflection hands the transmitted weight to the mirrored ray.
struct Children {
    bool mirror, pass;
    float mirrorWeight, passWeight;
    vec3 mirrorDirection, passDirection;
};

// Children of a hit; n faces the ray. A child is followed when it is no deeper than maxDepth and weighs at least minWeight.
SHARED_FN Children childrenOf(vec3 d, vec3 n, bool inside, float mirrorShare, float passShare, float index, float inverseIndex,
                              float weight, uint depth, uint maxDepth, float minWeight) {
    float cosine = -dot3(d, n);
    float ratio = pick(inside, index, inverseIndex);
    float square = refractedSquare(cosine, ratio);
    bool passes = square > 0.0f;
    Children c;
    c.mirrorWeight = weight * pick(passes, mirrorShare, mirrorShare + passShare);
    c.passWeight = pick(passes, weight * passShare, 0.0f);
    bool deeper = depth < maxDepth;
    c.mirror = deeper && c.mirrorWeight > 0.0f && c.mirrorWeight >= minWeight;
    c.pass = deeper && c.passWeight > 0.0f && c.passWeight >= minWeight;
    c.mirrorDirection = mirrored(d, n, cosine);
    // no plant: the root of a negative number is not used
    c.passDirection = refracted(d, n, cosine, ratio, pick(passes, square, 1.0f));
    return c;
}

// Shadow ray from q to a light: direction and length. Nothing at or behind the light casts a shadow. So the length is shortened by 16 u,
// the error of both lengths that are compared.
struct ShadowRay {
    vec3 direction;
    float reach;
};
SHARED_FN ShadowRay shadowRayTo(vec4 position, vec3 q) {
    vec3 toward = vec3(position.x, position.y, position.z);
    ShadowRay f;
    f.direction = toward;
    f.reach = kFarthestHit;
    if (position.w != 0.0f) {
        toward = toward - q;
        float square = dot3(toward, toward);
        float inverse = reciprocalRoot(real(square));
        f.direction = toward * inverse;
        f.reach = (square * inverse) * 0.99999904632568359375f;
    }
    return f;
}
// Share of light after a triangle of a mesh. An opaque triangle blocks on either side. A translucent one dims where the shadow ray leaves
// the body, so once a body. Blockers are multiplied in ascending order of their numbers; an opaque one leaves 0.
SHARED_FN float passesTriangle(float share, float slope) { return pick(share == 0.0f || slope > 0.0f, share, 1.0f); }
SHARED_FN bool blocks(float t, float reach) { return t > 0.0f && t < reach; }

SHARED_END
#endif
