// SPDX-License-Identifier: MIT
// One invocation four pixels of a row.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/resolve.h"

layout(constant_id = 2) const uint kEncoding = 0u;
layout(constant_id = 3) const bool kLinearOut = false;

layout(push_constant, scalar) uniform Push { ResolvePush push; };
layout(binding = 1) uniform usamplerBuffer samplePlanes;  // single words
layout(binding = 2) uniform usamplerBuffer encodeTable;
layout(binding = 3, scalar) writeonly buffer Colours { uvec4 colours[]; };
layout(binding = 4, scalar) writeonly buffer Linear { vec4 linear[]; };  // three planes, kLinearOut

#include "encode.glsl"

void main() {
    uint item = itemIndex();
    bool mine = item < push.pixelQuads;
    uint quad = min(item, push.pixelQuads - 1u);
    uint row = quad / push.rowQuads;
    uint column = (quad - row * push.rowQuads) * 4u;
    vec4 r = vec4(0.0), g = vec4(0.0), b = vec4(0.0);
    ivec4 covered = ivec4(0);
    uint k = 0u;
    uint samples = push.side * push.side;
    do {
        uint sy = k / push.side;
        uint sx = k - sy * push.side;
        uint first = (row * push.stride + sy) * push.sampleRowQuads * 4u;
        for (uint c = 0u; c < 4u; ++c) {
            uint word = first + min((column + c) * push.stride + sx, push.sampleRowQuads * 4u - 1u);
            uint plane = push.samplePlaneQuads * 4u;
            bool here = texelFetch(samplePlanes, int(word + push.zSlot * plane)).x != 0u;
            bool counts = here || push.transparent == 0u;
            uint at = word + push.linearSlot * plane;
            r[c] += counts ? uintBitsToFloat(texelFetch(samplePlanes, int(at)).x) : 0.0;
            g[c] += counts ? uintBitsToFloat(texelFetch(samplePlanes, int(at + plane)).x) : 0.0;
            b[c] += counts ? uintBitsToFloat(texelFetch(samplePlanes, int(at + 2u * plane)).x) : 0.0;
            covered[c] += here ? 1 : 0;
        }
        k++;
    } while (k < samples);
    uvec4 alpha = uvec4(255u);
    for (uint c = 0u; c < 4u; ++c) {
        float count = push.transparent == 0u ? float(samples) : float(max(covered[c], 1));
        float inverse = exactDivide(1.0, count);
        r[c] *= inverse;
        g[c] *= inverse;
        b[c] *= inverse;
        if (push.transparent != 0u) alpha[c] = coverageCode(uint(covered[c]), samples);
    }
    uvec4 word = uvec4(encode(r) | (encode(g) << 8) | (encode(b) << 16)) | (alpha << 24);
    if (mine) colours[quad] = word;
    if (kLinearOut && mine) {
        linear[quad] = r;
        linear[quad + push.pixelQuads] = g;
        linear[quad + 2u * push.pixelQuads] = b;
    }
    finish(push.statusSlot, k < samples ? kFaultLoop : 0u);
}
