// SPDX-License-Identifier: MIT
// The scene as an application would give it to a graphics pipeline: one composite matrix, per-pixel Phong (baseline.frag).
#version 450
#extension GL_GOOGLE_include_directive : require
layout(location = 0) in vec3 position;  // object space
layout(location = 1) in vec3 normal;    // world axes
layout(location = 0) out vec3 normalOut;
#include "baseline.glsl"
void main() {
    vec4 p = vec4(position, 1.0);
    gl_Position = vec4(dot(rowX, p), dot(rowY, p), near, dot(rowW, p));  // depth near / w: greater is nearer
    normalOut = normal;
}
