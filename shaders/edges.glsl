// SPDX-License-Identifier: MIT
// Exact edge values at a pixel centre, for the device. Narrow triangles: wrapping 32-bit arithmetic (E = 256 (xh1 y0 - xh0 y1) + (xl1 y0 -
// xl0 y1) is exact modulo 2^40). Wide ones: 64 bits by imulExtended. The twin uses 64-bit integers.
// q: e_i, exact when narrow, clamped to +-2^30 when wide (exact sign anywhere in a tile). hi, lo: e_i = hi 65536 + lo (wide).
struct Edges {
    ivec3 q, hi, lo, a, b;
    ivec3 rho;
    float sumE;
};

void narrowEdges(ivec2 p0, ivec2 p1, ivec2 p2, out Edges e) {  // corners relative to the pixel centre
    e.a = ivec3(p1.y - p0.y, p2.y - p1.y, p0.y - p2.y);
    e.b = ivec3(p0.x - p1.x, p1.x - p2.x, p2.x - p0.x);
    ivec3 bias = ivec3(edgeBias(e.a.x, e.b.x), edgeBias(e.a.y, e.b.y), edgeBias(e.a.z, e.b.z));
    int h0 = p0.x >> 8, h1 = p1.x >> 8, h2 = p2.x >> 8;
    int l0 = p0.x & 255, l1 = p1.x & 255, l2 = p2.x & 255;
    ivec3 s = ivec3(l1 * p0.y - l0 * p1.y, l2 * p1.y - l1 * p2.y, l0 * p2.y - l2 * p0.y) - bias;
    e.q = ivec3(h1 * p0.y - h0 * p1.y, h2 * p1.y - h1 * p2.y, h0 * p2.y - h2 * p0.y) + (s >> 8);
    e.rho = (s & 255) + bias;
    e.sumE = float(e.q.x + e.q.y + e.q.z);
    e.hi = ivec3(0);
    e.lo = e.q;
}

// Value E - bias of edge (a, b) whose first corner is p: 48 bits at most.
void wideEdge(int a, int b, ivec2 p, int bias, out int q, out int hi, out int lo, out int rho) {
    int h1, l1, h2, l2;
    imulExtended(a, -p.x, h1, l1);
    imulExtended(b, -p.y, h2, l2);
    uint carry, borrow;
    uint low = uaddCarry(uint(l1), uint(l2), carry);
    int high = h1 + h2 + int(carry);
    low = usubBorrow(low, uint(bias), borrow);
    high -= int(borrow);
    hi = (high << 8) | int(low >> 24);
    lo = int((low >> 8) & 0xffffu);
    rho = int(low & 255u) + bias;
    q = hi >= 16384 ? 1073741823 : hi < -16384 ? -1073741824 : hi * 65536 + lo;
}

void wideEdges(ivec2 p0, ivec2 p1, ivec2 p2, out Edges e) {
    e.a = ivec3(p1.y - p0.y, p2.y - p1.y, p0.y - p2.y);
    e.b = ivec3(p0.x - p1.x, p1.x - p2.x, p2.x - p0.x);
    wideEdge(e.a.x, e.b.x, p0, edgeBias(e.a.x, e.b.x), e.q.x, e.hi.x, e.lo.x, e.rho.x);
    wideEdge(e.a.y, e.b.y, p1, edgeBias(e.a.y, e.b.y), e.q.y, e.hi.y, e.lo.y, e.rho.y);
    wideEdge(e.a.z, e.b.z, p2, edgeBias(e.a.z, e.b.z), e.q.z, e.hi.z, e.lo.z, e.rho.z);
    e.sumE = float(e.hi.x + e.hi.y + e.hi.z) * 65536.0 + float(e.lo.x + e.lo.y + e.lo.z);
}
