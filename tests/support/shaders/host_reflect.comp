// SPDX-License-Identifier: MIT
// Every kind of declaration that the reflection reads; never dispatched.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(local_size_x_id = 3, local_size_y = 2) in;
#include "shared/status.h"

layout(constant_id = 9) const float kScale = 1.0;
struct Particle {
    vec3 position;
    uint kind;
    mat3 frame;
    float weights[5];
};
struct ReflectPush {
    uint statusSlot;
    vec3 offset;
    mat4 clipFromWorld;
    uvec2 sizes[2];
};
layout(push_constant, scalar) uniform Push { ReflectPush push; };
layout(binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(binding = 2, scalar) writeonly buffer Counters {
    uint drawn;
    uint skipped;
    uint most;
}
counters;
layout(binding = 3) uniform utextureBuffer words;
layout(binding = 4) uniform textureBuffer reals;
layout(binding = 5) uniform itextureBuffer integers;
layout(binding = 6, scalar) uniform Block { vec4 colour; }
block;
layout(binding = 7, scalar) buffer WithHeader {
    uint count;
    vec2 list[];
}
withHeader;

void main() {
    int item = int(gl_GlobalInvocationID.x);
    counters.drawn = particles[item].kind + texelFetch(words, item).x + uint(texelFetch(integers, item).x) + push.sizes[1].y;
    withHeader.list[item] = texelFetch(reals, item).xy * kScale + block.colour.xy + push.offset.xy;
    finish(push.statusSlot, 0u);
}
