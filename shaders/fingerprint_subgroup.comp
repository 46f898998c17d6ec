// SPDX-License-Identifier: MIT
// What the operations of a subgroup give, for `plumb devices --fingerprint`: one word an invocation, with a bit for each thing that does not
// hold. A loop over the lanes says what should. Subgroups are full: 64 invocations, or one subgroup that is wider.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/fingerprint.h"

layout(constant_id = 2) const uint kOperation = 0u;

layout(push_constant, scalar) uniform Push { FingerprintPush push; };
layout(binding = 1, scalar) writeonly buffer Answers { uint answers[]; };

uint answerOf(uint lane, uint lanes) {
    uint mine = laneValue(lane);
    if (kOperation == kSubgroupSize) return subgroupBallotBitCount(subgroupBallot(true));
    if (kOperation == kSubgroupShuffle) {
        uint other = (lane * 5u + 3u) % lanes;
        uint wrong = subgroupShuffle(mine, other) == laneValue(other) ? 0u : 1u;
        wrong |= subgroupBroadcastFirst(mine) == laneValue(0u) ? 0u : 2u;
        return wrong | (subgroupShuffleXor(mine, 1u) == laneValue(lane ^ 1u) ? 0u : 4u);
    }
    if (kOperation == kSubgroupVote) {
        bool odd = (mine & 1u) != 0u, any = false, all = true;
        for (uint i = 0u; i < lanes; ++i) {
            bool set = (laneValue(i) & 1u) != 0u;
            any = any || set;
            all = all && set;
        }
        uint wrong = subgroupAny(odd) == any ? 0u : 1u;
        wrong |= subgroupAll(odd) == all ? 0u : 2u;
        wrong |= subgroupBallotBitExtract(subgroupBallot(odd), lane) == odd ? 0u : 4u;
        return wrong | (subgroupAll(true) ? 0u : 8u);
    }
    if (kOperation == kSubgroupSum) {
        uint sum = 0u, least = mine, before = 0u;
        for (uint i = 0u; i < lanes; ++i) {
            uint value = laneValue(i);
            before = i == lane ? sum : before;
            sum += value;
            least = min(least, value);
        }
        uint wrong = subgroupAdd(mine) == sum ? 0u : 1u;
        wrong |= subgroupMin(mine) == least ? 0u : 2u;
        return wrong | (subgroupExclusiveAdd(mine) == before ? 0u : 4u);
    }
    // The sum of floats rounds at each step, so its bits tell the order of the lanes.
    if (kOperation == kSubgroupFloatSum) return floatBitsToUint(subgroupAdd(uintBitsToFloat(laneFloatBits(lane))));
    return 0u;
}

void main() {
    uint item = itemIndex();
    uint answer = answerOf(gl_SubgroupInvocationID, min(gl_SubgroupSize, 64u));
    if (item < push.items) answers[item] = answer;
    finish(push.statusSlot, 0u);
}
