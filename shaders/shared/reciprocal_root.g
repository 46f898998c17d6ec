# SPDX-License-Identifier: MIT
# The last of three Newton steps of 1 / sqrt(x), and its square. The step before leaves an error e below 2^-16, which
# Vectors.ReciprocalRootIsWithinItsBound holds for every significand, with the result.
# contract shade.h: Real h = x * -0.5f;
# contract shade.h: y = y * ((h * y) * y + 1.5f);
# contract shade.h: return y * y;
# bound ROOT bounds.h: kReciprocalRootUnits = ([\d.]+)f
# bound RECIPROCAL bounds.h: kReciprocalUnits = ([\d.]+)f
@rnd = float<ieee_32,ne>;
h = x * -0.5;
a = rnd(h * y); b = rnd(a * y); t = rnd(b + 1.5); z = rnd(y * t);
B = h * y * y; T = B + 1.5; Z = y * T;
e = (y - i) / i;
w = rnd(z * z);
{ x in [1,4] /\ y in [0.49,1.01] /\ i in [0.5,1] /\ e in [-1b-16,1b-16] /\ x * i * i - 1 in [0,0]
  -> (z - i) / i in [-@ROOT:u@,@ROOT:u@] /\ (w - i * i) / (i * i) in [-@RECIPROCAL:u@,@RECIPROCAL:u@] }
# x i i = 1
B -> -0.5 * (1 + e) * (1 + e);
b - B -> B * ((b - B) / B) { B <> 0 };
(b - B) / B -> ((b - a * y) / (a * y)) * (1 + (a - h * y) / (h * y)) + (a - h * y) / (h * y) { a <> 0, h <> 0, y <> 0 };
t - T -> (t - (b + 1.5)) + (b - B);
(z - Z) / Z -> ((z - y * t) / (y * t)) * (1 + (t - T) / T) + (t - T) / T { T <> 0, y <> 0, t <> 0 };
(z - i) / i -> ((z - Z) / Z) * (Z / i) + (Z - i) / i { i <> 0, Z <> 0 };
(Z - i) / i -> e * e * (-1.5) - 0.5 * e * e * e { i <> 0 };
Z / i -> 1 + (Z - i) / i { i <> 0 };
(w - i * i) / (i * i) -> ((w - z * z) / (z * z)) * (1 + (z - i) / i) * (1 + (z - i) / i) + (z - i) / i * (2 + (z - i) / i) { i <> 0, z <> 0 };
