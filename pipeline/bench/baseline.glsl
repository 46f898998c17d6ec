// SPDX-License-Identifier: MIT
layout(push_constant, std430) uniform Push {
    vec4 rowX, rowY, rowW;  // clip space from object space
    vec4 base;              // Ka Ia + Ke; specular exponent
    vec4 diffuse;           // Kd; rayOrigin.x
    vec4 specular;          // Ks; rayOrigin.y
    vec4 rayX;              // ray to pixel (x, y), forward component 1: rayOrigin + rayX x + rayY y; w: rayOrigin.z
    vec3 rayY;
    float near;
};
