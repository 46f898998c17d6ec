# SPDX-License-Identifier: MIT
# Rounding of the exponent n log2(1 - delta), where 1 - delta lies between sqrt(1/2) and 1 (e = 0), against the real polynomial. Its own error is that of encode_test.
# contract shade.h: Real y = x * -0.145807055f + 0.234040521f; y = y * x - 0.248877417f; y = y * x + 0.287098915f; y = y * x - 0.36023962f; y = y * x + 0.480923236f; y = y * x - 0.721352788f; y = y * x + 1.44269496f; Real p = n * (toReal(e) + y * x);
# bound LOG2 bounds.h: kLog2RoundingUnits = ([\d.]+)f
@rnd = float<ieee_32,ne>;
c0 = rnd(-0.145807055); c1 = rnd(0.234040521); c2 = rnd(-0.248877417); c3 = rnd(0.287098915);
c4 = rnd(-0.36023962); c5 = rnd(0.480923236); c6 = rnd(-0.721352788); c7 = rnd(1.44269496);
x = rnd(x_); n = rnd(n_);
y1 rnd= x * c0 + c1; y2 rnd= y1 * x + c2; y3 rnd= y2 * x + c3; y4 rnd= y3 * x + c4;
y5 rnd= y4 * x + c5; y6 rnd= y5 * x + c6; y rnd= y6 * x + c7;
Y1 = x * c0 + c1; Y2 = Y1 * x + c2; Y3 = Y2 * x + c3; Y4 = Y3 * x + c4; Y5 = Y4 * x + c5; Y6 = Y5 * x + c6; Y = Y6 * x + c7;
p rnd= n * (y * x);
P = n * (Y * x);
{ |x| in [1b-40,0.41422] /\ n in [1b-20,1000000] -> p -/ P in [-@LOG2:u@,@LOG2:u@] }
$ x in 4;
