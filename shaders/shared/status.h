// SPDX-License-Identifier: MIT
// Proof of work of a dispatch. The recorder zeroes a slot. Every workgroup that reaches its end adds 1 to `finished`. An invocation whose
// loop stopped before its end sets a bit in `fault` (lavapipe ends loops in silence after 65,535 iterations). The recorder compares
// `finished` with the number of workgroups it asked for.
#ifndef PLUMB_STATUS_H
#define PLUMB_STATUS_H
#include "bridge.h"
SHARED_BEGIN

struct StatusSlot {
    uint finished;
    uint fault;
};

SHARED_CONST uint kFaultLoop = 1u;   // a loop stopped before its end
SHARED_CONST uint kFaultRange = 2u;  // a value left the range that the contract states

SHARED_END
#ifndef __cplusplus
layout(binding = 0, scalar) buffer Status { StatusSlot status[]; };
// Item of this invocation when the recorder has spread workgroups over x and y.
uint itemIndex() { return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex; }
void finish(uint slot, uint fault) {
    if (fault != 0u) atomicOr(status[slot].fault, fault);
    if (gl_LocalInvocationIndex == 0u) atomicAdd(status[slot].finished, 1u);
}
#endif
#endif
