// SPDX-License-Identifier: MIT
// Bounds of the contracts' roundings, in units of u = 2^-24. Gappa proves each of them from the text of its contract, in the .g file that the
// row names (toolchain/prove.py); docs/derivations.md has what is made of them. No kernel reads them.
#ifndef PLUMB_BOUNDS_H
#define PLUMB_BOUNDS_H
#include "bridge.h"
SHARED_BEGIN

SHARED_CONST float kRowUnits = 5.01f;            // transform_row.g: rowTimesPoint() of a row that is rounded once, of sum |m_i p_i|
SHARED_CONST float kDepthSpanUnits = 10.1f;      // depth.g: depthBits(), of f1 |z1 - z0| + f2 |z2 - z0|
SHARED_CONST float kDepthSumUnits = 1.01f;       // depth.g: depthBits(), of z0 + z
SHARED_CONST float kAttributeUnits = 10.02f;     // interpolation.g: weigh() of rows of normals, of the sum of magnitudes
SHARED_CONST float kReciprocalRootUnits = 4.0f;  // reciprocal_root.g: reciprocalRoot(), relative
SHARED_CONST float kReciprocalUnits = 9.01f;     // reciprocal_root.g: reciprocal(), relative
SHARED_CONST float kLog2RoundingUnits = 4.5f;    // power_log2.g: the exponent n log2(1 - delta) of specularPower(), relative
SHARED_CONST float kExp2RoundingUnits = 3.0f;    // power_exp2.g: the power of two of specularPower(), relative

SHARED_END
#endif
