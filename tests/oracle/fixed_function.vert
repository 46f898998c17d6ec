// SPDX-License-Identifier: MIT
#version 450
layout(location = 0) in vec4 positionClip;
layout(location = 1) in uint idOfTriangle;
layout(location = 0) flat out uint id;
invariant gl_Position;
void main() {
    id = idOfTriangle;
    gl_Position = positionClip;
}
