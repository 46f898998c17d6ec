// SPDX-License-Identifier: MIT
// Phong's illumination with the API's functions: pow, normalize, native division. Lights are constants of the pipeline.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(location = 0) in vec3 normalIn;
layout(location = 0) out vec4 colour;
#include "baseline.glsl"
layout(constant_id = 0) const uint kLights = 1u;
layout(constant_id = 1) const bool kSpecular = true;
#define LIGHT(i, first)                                      \
    layout(constant_id = first) const float kKind##i = 0.0;  \
    layout(constant_id = first + 1) const float kX##i = 0.0; \
    layout(constant_id = first + 2) const float kY##i = 0.0; \
    layout(constant_id = first + 3) const float kZ##i = 1.0; \
    layout(constant_id = first + 4) const float kR##i = 0.0; \
    layout(constant_id = first + 5) const float kG##i = 0.0; \
    layout(constant_id = first + 6) const float kB##i = 0.0; \
    layout(constant_id = first + 7) const float kFade##i = 0.0;
LIGHT(0, 2)
LIGHT(1, 10)
LIGHT(2, 18)
LIGHT(3, 26)

vec3 lightOf(float kind, vec3 position, vec3 intensity, float fade, vec3 n, vec3 v, vec3 p) {
    vec3 l = position;
    float weaker = 1.0;
    if (kind != 0.0) {
        l = position - p;
        float inverse = inversesqrt(dot(l, l));
        l *= inverse;
        weaker = fade == 0.0 ? 1.0 : fade == 1.0 ? inverse : inverse * inverse;
    }
    float nl = dot(n, l);
    vec3 sum = diffuse.xyz * max(nl, 0.0);
    if (kSpecular) sum += nl > 0.0 ? specular.xyz * pow(max(dot(2.0 * nl * n - l, v), 0.0), base.w) : vec3(0.0);
    return sum * weaker * intensity;
}

void main() {
    vec3 ray = vec3(diffuse.w, specular.w, rayX.w) + rayX.xyz * gl_FragCoord.x + rayY * gl_FragCoord.y;
    vec3 n = normalize(normalIn);
    vec3 v = -normalize(ray);
    vec3 p = ray / gl_FragCoord.w;
    vec3 c = base.xyz;
    if (kLights > 0u) c += lightOf(kKind0, vec3(kX0, kY0, kZ0), vec3(kR0, kG0, kB0), kFade0, n, v, p);
    if (kLights > 1u) c += lightOf(kKind1, vec3(kX1, kY1, kZ1), vec3(kR1, kG1, kB1), kFade1, n, v, p);
    if (kLights > 2u) c += lightOf(kKind2, vec3(kX2, kY2, kZ2), vec3(kR2, kG2, kB2), kFade2, n, v, p);
    if (kLights > 3u) c += lightOf(kKind3, vec3(kX3, kY3, kZ3), vec3(kR3, kG3, kB3), kFade3, n, v, p);
    colour = vec4(c, 1.0);
}
