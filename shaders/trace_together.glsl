// SPDX-License-Identifier: MIT
// Invocations of a subgroup together: sums over them, and eye rays that walk the tree as one (trace.comp).

// Over all invocations of a subgroup, which all run along.
float leastOf(float x) {
    x = lesser(x, subgroupShuffleXor(x, 1u));
    x = lesser(x, subgroupShuffleXor(x, 2u));
    x = lesser(x, subgroupShuffleXor(x, 4u));
    if (kLanes > 8u) x = lesser(x, subgroupShuffleXor(x, 8u));
    if (kLanes > 16u) x = lesser(x, subgroupShuffleXor(x, 16u));
    if (kLanes > 32u) x = lesser(x, subgroupShuffleXor(x, 32u));
    if (kLanes > 64u) x = lesser(x, subgroupShuffleXor(x, 64u));
    return x;
}
float mostOf(float x) { return -leastOf(-x); }
uint sumOf(uint x) {
    x += subgroupShuffleXor(x, 1u);
    x += subgroupShuffleXor(x, 2u);
    x += subgroupShuffleXor(x, 4u);
    if (kLanes > 8u) x += subgroupShuffleXor(x, 8u);
    if (kLanes > 16u) x += subgroupShuffleXor(x, 16u);
    if (kLanes > 32u) x += subgroupShuffleXor(x, 32u);
    if (kLanes > 64u) x += subgroupShuffleXor(x, 64u);
    return x;
}
uint allBitsOf(uint x) {
    x |= subgroupShuffleXor(x, 1u);
    x |= subgroupShuffleXor(x, 2u);
    x |= subgroupShuffleXor(x, 4u);
    if (kLanes > 8u) x |= subgroupShuffleXor(x, 8u);
    if (kLanes > 16u) x |= subgroupShuffleXor(x, 16u);
    if (kLanes > 32u) x |= subgroupShuffleXor(x, 32u);
    if (kLanes > 64u) x |= subgroupShuffleXor(x, 64u);
    return x;
}
// Octant that a ray points into: a bit for each component of its direction that is negative.
uint octantOf(RayFrame f) { return (f.inverse.x < 0.0 ? 1u : 0u) | (f.inverse.y < 0.0 ? 2u : 0u) | (f.inverse.z < 0.0 ? 4u : 0u); }
EyeHit nearerOf(EyeHit best, float t, uint triangle, bool met) {
    bool nearer = met && isNearer(t, triangle, best.t, best.triangle);
    best.t = nearer ? t : best.t;
    best.triangle = nearer ? triangle : best.triangle;
    return best;
}
// Eye rays of neighbouring pixels, all invocations together: each looks at one child of the same node and asks whether any of the rays may meet
// it. The way back stands in the invocations too, a level in each: node << 8 | children that still wait. Every trip is the same for all, so the
// loops are do..while.
// One walk serves the rays of one octant. The inverse directions of rays on both sides of an axis enclose 0, and a box then excludes nothing along
// that axis: a tile with rays on both sides of two axes would open the whole tree.
void nearestOfEyeRays(vec3 d, vec3 d2, bool any, out EyeHit best, out EyeHit best2) {
    best = EyeHit(kFarthestHit, kNoObject);
    best2 = best;
    vec3 o = vec3(0.0);
    RayFrame frame = frameOfRay(o, d, push.reach);
    RayFrame frame2 = frameOfRay(o, d2, push.reach);
    uint octant = octantOf(frame);
    uint octant2 = kTurns == 2u ? octantOf(frame2) : octant;
    uint octants = allBitsOf(1u << octant | 1u << octant2);  // not walked yet
    uint lane = gl_SubgroupInvocationID;
    int child = int(lane & (kNodeChildren - 1u));
    uint steps = 0u;
    do {
        uint walked = uint(findLSB(octants));
        octants &= octants - 1u;
        bool mine = octant == walked;
        bool mine2 = kTurns == 2u && octant2 == walked;
        vec3 least = mine ? frame.inverse : vec3(kNoInverse);
        vec3 most = mine ? frame.inverse : vec3(-kNoInverse);
        if (kTurns == 2u) {
            least = mine2 ? lesser3(least, frame2.inverse) : least;
            most = mine2 ? greater3(most, frame2.inverse) : most;
        }
        RayBundle bundle = RayBundle(o, vec3(leastOf(least.x), leastOf(least.y), leastOf(least.z)),
                                     vec3(mostOf(most.x), mostOf(most.y), mostOf(most.z)), frame.pad);
        float longest = kFarthestHit;
        uint node = kTopNode;
        uint asked = 0xffu;
        uint back = 0u;
        uint further = 0u;  // levels from kLanes on
        uint level = 0u;
        bool done = !any;
        do {
            uint met = 0u;
            uint link = 0u;
            do {
                int at = (int(node * kNodeChildren) + child) * 2;
                uvec4 low = texelFetch(nodes, at);
                uvec4 high = texelFetch(nodes, at + 1);
                link = low.w;
                vec3 from = uintBitsToFloat(low.xyz);
                vec3 to = uintBitsToFloat(high.xyz);
                bool open = !done && link != kNoChild && lane < kNodeChildren &&
                            opens(earliestEntry(bundle, from, to), latestExit(bundle, from, to), longest);
                uint opened = sumOf((asked >> uint(child) & (open ? 1u : 0u)) << (link >= kLeaf ? uint(child) + 16u : uint(child)));
                met = opened >> 16;
                uint inner = opened & 0xffffu;
                uint rest = inner & (inner - 1u);
                back = rest != 0u && lane == level ? node << 8 | rest : back;
                if (kDeep) further = rest != 0u && lane + kLanes == level ? node << 8 | rest : further;
                level += rest != 0u ? 1u : 0u;
                bool up = inner == 0u;
                done = done || (up && level == 0u);
                level -= up && level > 0u ? 1u : 0u;
                uint next = subgroupShuffle(back, level & (kLanes - 1u));
                if (kDeep) next = level < kLanes ? next : subgroupShuffle(further, level & (kLanes - 1u));
                uint first = subgroupShuffle(link, uint(findLSB(inner | kNodeChildren << 8)) & (kNodeChildren - 1u));
                node = up ? next >> 8 : first;
                asked = up ? next & 0xffu : 0xffu;
                steps++;
            } while (met == 0u && !done && steps < kMostSteps);
            do {
                uint leaf = subgroupShuffle(link, uint(findLSB(met | kNodeChildren << 8)) & (kNodeChildren - 1u)) & ~kLeaf;
                leaf = met != 0u ? leaf : 0u;
                uvec4 a = texelFetch(leaves, int(leaf) * 3);
                vec3 p0 = uintBitsToFloat(a.xyz);
                vec3 p1 = uintBitsToFloat(texelFetch(leaves, int(leaf) * 3 + 1).xyz);
                vec3 p2 = uintBitsToFloat(texelFetch(leaves, int(leaf) * 3 + 2).xyz);
                best = nearerOf(best, hitTriangle(frame, p0, p1, p2, false).t, a.w, met != 0u);
                if (kTurns == 2u) best2 = nearerOf(best2, hitTriangle(frame2, p0, p1, p2, false).t, a.w, met != 0u);
                met &= met - 1u;
                steps++;
            } while (met != 0u);
            float farther = mine ? best.t : 0.0;
            if (kTurns == 2u) farther = mine2 ? greater(farther, best2.t) : farther;
            longest = mostOf(farther);
        } while (!done && steps < kMostSteps);
        fault |= !done ? kFaultLoop : 0u;
    } while (octants != 0u);
}
