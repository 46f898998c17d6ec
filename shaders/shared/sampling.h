// SPDX-License-Identifier: MIT
// Contract of rays' sampling (notes 18.4.1, 18.4.3 and 18.5): where in a pixel rays pass, noise on secondary rays, colours cut to whole
// levels. Noise is a hash of sample, seed and the path that a ray took, so neither order of work nor side changes it.
#ifndef PLUMB_SAMPLING_H
#define PLUMB_SAMPLING_H
#include "ray.h"
SHARED_BEGIN

SHARED_CONST uint kSampleGrid = 0u;    // the middle of each sample's square
SHARED_CONST uint kSampleCentre = 1u;  // all samples of a pixel through its middle
SHARED_CONST uint kSampleRandom = 2u;  // anywhere in the sample's square
SHARED_CONST uint kSampleCorner = 3u;  // its upper left corner
SHARED_CONST uint kSampleNotes = 4u;   // its lower right corner: where the notes' C program looks

// Random word from a word: O'Neill's PCG, one step of the congruential generator, permuted.
SHARED_FN uint mixed(uint x) {
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
SHARED_FN uint keyOfSample(uint column, uint row, uint seed) { return mixed(column + mixed(row + mixed(seed))); }
// Key of the first shadow ray among the children of a hit: 1 the mirrored ray, 2 the refracted ray, 3 + i the shadow ray to light i.
SHARED_CONST uint kFirstShadowKey = 3u;
SHARED_FN uint keyOfChild(uint key, uint which) { return mixed(key ^ (which * 2654435769u)); }

// Noise of 24 bits, exact: unitNoise() in [0, 1), signedNoise() in [-1, 1).
SHARED_FN float unitNoise(uint key) { return float(int(key >> 8u)) * 5.9604644775390625e-8f; }
SHARED_FN float signedNoise(uint key) { return float(int(key >> 8u)) * 1.1920928955078125e-7f - 1.0f; }

// Position of sample `index` (a column or a row) along its axis, in samples. `side`: samples a pixel along an axis. `noise` in [0, 1).
SHARED_FN float sampleAlong(uint sampling, uint index, uint side, float noise) {
    float at = float(int(index)) + 0.5f;
    at = pick(sampling == kSampleCentre, float(int(index / side * side)) + 0.5f * float(int(side)), at);
    at = pick(sampling == kSampleRandom, float(int(index)) + noise, at);
    at = pick(sampling == kSampleCorner, float(int(index)), at);
    return pick(sampling == kSampleNotes, float(int(index)) + 1.0f, at);
}
SHARED_FN float columnOf(uint sampling, uint column, uint side, uint key) {
    return sampleAlong(sampling, column, side, unitNoise(mixed(key + 1u)));
}
SHARED_FN float rowOf(uint sampling, uint row, uint side, uint key) { return sampleAlong(sampling, row, side, unitNoise(mixed(key + 2u))); }

// Unit vector d disturbed by a vector out of the cube [-amount, amount)^3, normalised again. The result is d itself where the disturbed
// vector would pass to the other side of the surface of normal n. amount <= 1/2: no disturbed vector is shorter than 1 - sqrt(3) / 2.
SHARED_FN vec3 jittered(vec3 d, vec3 n, float amount, uint key) {
    vec3 noise = vec3(signedNoise(mixed(key)), signedNoise(mixed(key + 1u)), signedNoise(mixed(key + 2u)));
    vec3 other = unitLength(d + noise * amount);
    bool before = dot3(d, n) > 0.0f;
    bool after = dot3(other, n) > 0.0f;
    return chosen(before == after, other, d);
}

// Highest of the whole levels in which the notes' C program counts colours. It takes a surface's colour to the nearest level, and int(0.7 *
// mirrored + 0.3 * local) toward zero.
SHARED_CONST float kTopLevel = 255.0f;
SHARED_CONST float kOneLevel = 0.0039215686274509803922f;  // a level times this, encoded as linear light, gives that level
SHARED_FN float wholeLevel(float colour) { return roundEvenReal(colour * kTopLevel); }
SHARED_FN float cutLevel(float mirrored, float local) { return floorReal(mirrored + local); }
SHARED_FN vec3 wholeLevels(vec3 c) { return vec3(wholeLevel(c.x), wholeLevel(c.y), wholeLevel(c.z)); }
SHARED_FN vec3 cutLevels(vec3 mirrored, vec3 local) {
    return vec3(cutLevel(mirrored.x, local.x), cutLevel(mirrored.y, local.y), cutLevel(mirrored.z, local.z));
}

SHARED_END
#endif
