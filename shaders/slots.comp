// SPDX-License-Identifier: MIT
// One invocation one drawn triangle that the set-up pass has counted: into the lists of its tiles, at the places it got there.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/bin.h"
#include "shared/setup.h"

layout(push_constant, scalar) uniform Push { BinPush push; };
layout(binding = 1) uniform usamplerBuffer slots;
layout(binding = 2) uniform usamplerBuffer tiles;   // first entry of each tile
layout(binding = 3, scalar) writeonly buffer Entries { uint entries[]; };

uint entryOf(uint slot) { return texelFetch(tiles, int(slot & 0xffffu)).x + (slot >> 16u); }

void main() {
    uint item = itemIndex();
    uvec4 slot = texelFetch(slots, int(min(item, push.itemCount - 1u)));
    if (item >= push.itemCount) slot = uvec4(kNoSlot);
    uvec4 at = uvec4(entryOf(slot.x), entryOf(slot.y), entryOf(slot.z), entryOf(slot.w));
    if (slot.x != kNoSlot) entries[at.x] = item;
    if (slot.y != kNoSlot) entries[at.y] = item;
    if (slot.z != kNoSlot) entries[at.z] = item;
    if (slot.w != kNoSlot) entries[at.w] = item;
    finish(push.statusSlot, 0u);
}
