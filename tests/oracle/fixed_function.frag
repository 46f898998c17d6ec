// SPDX-License-Identifier: MIT
#version 450
layout(location = 0) flat in uint id;
layout(location = 0) out uint written;
void main() { written = id; }
