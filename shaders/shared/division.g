# SPDX-License-Identifier: MIT
# The emulated division's quotient starts below the true one, and five comparisons reach it: the remainder is at least 0 and below 32 b.
# q: a 2^s / b, b the significand, seed: native quotient as a whole number, of which 1 ULP is 2 units.
# contract exact.h: uint remainder = (aSignificand << scaleBits) - quotient * bSignificand;
# contract exact.h: bool take = remainder >= bSignificand << 4;
# given ULP exact.h: the seed may be off by (\d+) ULP of the true result
# bound BELOW exact.h: uint quotient = uint\(seed \* pick\(below, 33554432\.0f, 16777216\.0f\)\) - (\d+)u;
quotient = seed - @BELOW@;
{ q in [1b24,1b25] /\ (seed - q) / 2 in [-@ULP@,@ULP@] /\ b in [1b23,1b24]
  -> q - quotient in [1,31] /\ (q - quotient) * b in [0,1b29] }
q - quotient -> @BELOW@ - 2 * ((seed - q) / 2);
