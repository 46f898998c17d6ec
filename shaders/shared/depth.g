# SPDX-License-Identifier: MIT
# Depth at a pixel. Each part carries a product of factors 1 + d, |d| <= u; edge values and their sum are exact before they are rounded once.
# t: the parts (e + rho) (z_i - z0) / area, by the way over e and that over rho. s: z0. The contract's bound of them is
# SPAN (parts) + SUM (z0 + z), and z is no less than z0 less the parts.
# contract fill.h: float inverse = exactDivide(1.0f, sumE + ((rho0 + rho1) + rho2)); d.k1 = (z1 - z0) * inverse;
# contract fill.h: d.zc = z0 + (rho2 * d.k1 + rho0 * d.k2);
# contract fill.h: Int z = bitsOf((e2 * k1 + e0 * k2) + zc);
# bound SPAN bounds.h: kDepthSpanUnits = ([\d.]+)f
# bound SUM bounds.h: kDepthSumUnits = ([\d.]+)f
# sumE a, sum b, division c; difference d, product k; edge value e, its product m, sum of the two s, last sum l
# products with rho p, their sum q, z0 added w
t1 = (1 + c) * (1 + d) * (1 + k) * (1 + e) * (1 + m) * (1 + s) * (1 + l) / ((1 + a) * (1 + b));
t2 = (1 + c) * (1 + d) * (1 + k) * (1 + p) * (1 + q) * (1 + w) * (1 + l) / ((1 + a) * (1 + b));
z0 = (1 + w) * (1 + l);
{ |a| <= 1b-24 /\ |b| <= 1b-24 /\ |c| <= 1b-24 /\ |d| <= 1b-24 /\ |k| <= 1b-24 /\ |e| <= 1b-24 /\ |m| <= 1b-24 /\ |s| <= 1b-24
  /\ |l| <= 1b-24 /\ |p| <= 1b-24 /\ |q| <= 1b-24 /\ |w| <= 1b-24
  -> |t1 - 1| <= @SPAN:u@ /\ |t2 - 1| <= @SPAN:u@ /\ t1 - 1 + @SUM:u@ in [-@SPAN:u@,@SPAN:u@] /\ t2 - 1 + @SUM:u@ in [-@SPAN:u@,@SPAN:u@]
  /\ 0.5 * (z0 - 1) in [-@SUM:u@,@SUM:u@] }
