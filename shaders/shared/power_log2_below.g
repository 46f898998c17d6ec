# SPDX-License-Identifier: MIT
# Rounding of the exponent n log2(1 - delta), where 1 - delta lies between 2^-20 and sqrt(1/2), against the real polynomial.
# contract shade.h: Real y = x * -0.145807055f + 0.234040521f; y = y * x - 0.248877417f; y = y * x + 0.287098915f; y = y * x - 0.36023962f; y = y * x + 0.480923236f; y = y * x - 0.721352788f; y = y * x + 1.44269496f; Real p = n * (toReal(e) + y * x);
# bound LOG2 bounds.h: kLog2RoundingUnits = ([\d.]+)f
@rnd = float<ieee_32,ne>;
c0 = rnd(-0.145807055); c1 = rnd(0.234040521); c2 = rnd(-0.248877417); c3 = rnd(0.287098915);
c4 = rnd(-0.36023962); c5 = rnd(0.480923236); c6 = rnd(-0.721352788); c7 = rnd(1.44269496);
x = rnd(x_); n = rnd(n_);
y1 rnd= x * c0 + c1; y2 rnd= y1 * x + c2; y3 rnd= y2 * x + c3; y4 rnd= y3 * x + c4;
y5 rnd= y4 * x + c5; y6 rnd= y5 * x + c6; y rnd= y6 * x + c7;
Y1 = x * c0 + c1; Y2 = Y1 * x + c2; Y3 = Y2 * x + c3; Y4 = Y3 * x + c4; Y5 = Y4 * x + c5; Y6 = Y5 * x + c6; Y = Y6 * x + c7;
f1 rnd= -1 + y * x; F1 = -1 + Y * x; p1 rnd= n * f1;
f rnd= e + y * x; F = e + Y * x; p rnd= n * f;
{ x in [-0.2929,0.41422] /\ e in [-20,-2] /\ n in [1b-20,1000000]
  -> (p1 - n * F1) / (n * F1) in [-@LOG2:u@,@LOG2:u@] /\ (p - n * F) / (n * F) in [-@LOG2:u@,@LOG2:u@] }
f1 - F1 -> (f1 - (-1 + rnd(y * x))) + (rnd(y * x) - Y * x);
(f1 - F1) / F1 -> (f1 - F1) * (1 / F1) { F1 <> 0 };
(p1 - n * F1) / (n * F1) -> ((p1 - n * f1) / (n * f1)) * (1 + (f1 - F1) / F1) + (f1 - F1) / F1 { n <> 0, F1 <> 0, f1 <> 0 };
f - F -> (f - (e + rnd(y * x))) + (rnd(y * x) - Y * x);
(f - F) / F -> (f - F) * (1 / F) { F <> 0 };
(p - n * F) / (n * F) -> ((p - n * f) / (n * f)) * (1 + (f - F) / F) + (f - F) / F { n <> 0, F <> 0, f <> 0 };
$ x in 16;
