# SPDX-License-Identifier: MIT
# The emulated root starts below the true one, and five steps reach it: the remainder is at least 0 and fits into 31 bits.
# s: root of the significand times 2^k, seed: native root as a whole number, of which 1 ULP is 2 units.
# contract exact.h: uint remainder = (significand << scaleBits) - root * root;
# contract exact.h: uint cost = ((root << 1) + (1u << stepBits)) << stepBits;
# given ULP exact.h: the seed may be off by (\d+) ULP of the true result
# bound BELOW exact.h: uint root = uint\(realOf\(bitsOf\(seed\) \+ seedErrorUlp\)\) - (\d+)u;
root = seed - @BELOW@;
{ s in [1b24,1b25] /\ (seed - s) / 2 in [-@ULP@,@ULP@]
  -> s - root in [1,31] /\ (s - root) * (s + root) in [0,2147483647] }
s - root -> @BELOW@ - 2 * ((seed - s) / 2);
s + root -> 2 * s - @BELOW@ + 2 * ((seed - s) / 2);
