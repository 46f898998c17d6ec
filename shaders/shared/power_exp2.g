# SPDX-License-Identifier: MIT
# Rounding of 2^r, the fraction of the exponent, against the real polynomial. Its own error is that of encode_test.
# contract shade.h: Real q = r * 0.00132764727f + 0.00967554133f; q = q * r + 0.0555071327f; q = q * r + 0.240221197f; q = q * r + 0.693146967f; q = q * r + 1.0f;
# bound EXP2 bounds.h: kExp2RoundingUnits = ([\d.]+)f
@rnd = float<ieee_32,ne>;
d0 = rnd(0.00132764727); d1 = rnd(0.00967554133); d2 = rnd(0.0555071327); d3 = rnd(0.240221197); d4 = rnd(0.693146967);
r = rnd(r_);
q1 rnd= r * d0 + d1; q2 rnd= q1 * r + d2; q3 rnd= q2 * r + d3; q4 rnd= q3 * r + d4; q rnd= q4 * r + 1;
Q1 = r * d0 + d1; Q2 = Q1 * r + d2; Q3 = Q2 * r + d3; Q4 = Q3 * r + d4; Q = Q4 * r + 1;
{ r in [-0.5,0.5] -> q -/ Q in [-@EXP2:u@,@EXP2:u@] }
$ r in 4;
