# SPDX-License-Identifier: MIT
# A component of a normal times the sum of the weights: rows of the normal matrix that are rounded once, the corners' weights, edge values.
# Terms of one sign, as in transform_row.g.
# contract transform.h: return (row.x * v.x + row.y * v.y) + row.z * v.z;
# contract fill.h: return (g1 * vw0 + g2 * vw1) + g0 * vw2;
# bound ATTRIBUTE bounds.h: kAttributeUnits = ([\d.]+)f
@rnd = float<ieee_32,ne>;
m0 = rnd(M0); m1 = rnd(M1); m2 = rnd(M2);
n0 rnd= (m0 * x0 + m1 * y0) + m2 * z0;
n1 rnd= (m0 * x1 + m1 * y1) + m2 * z1;
n2 rnd= (m0 * x2 + m1 * y2) + m2 * z2;
N0 = (M0 * x0 + M1 * y0) + M2 * z0;
N1 = (M0 * x1 + M1 * y1) + M2 * z1;
N2 = (M0 * x2 + M1 * y2) + M2 * z2;
g0 rnd= rnd(e0) + r0; g1 rnd= rnd(e1) + r1; g2 rnd= rnd(e2) + r2;
G0 = e0 + r0; G1 = e1 + r1; G2 = e2 + r2;
v0 rnd= n0 * w0; v1 rnd= n1 * w1; v2 rnd= n2 * w2;
a rnd= (g1 * v0 + g2 * v1) + g0 * v2;
A = (G1 * (N0 * w0) + G2 * (N1 * w1)) + G0 * (N2 * w2);
{ M0 in [1b-30,1b30] /\ M1 in [1b-30,1b30] /\ M2 in [1b-30,1b30]
  /\ x0 in [1b-20,1] /\ y0 in [1b-20,1] /\ z0 in [1b-20,1] /\ x1 in [1b-20,1] /\ y1 in [1b-20,1] /\ z1 in [1b-20,1]
  /\ x2 in [1b-20,1] /\ y2 in [1b-20,1] /\ z2 in [1b-20,1] /\ w0 in [1b-20,2] /\ w1 in [1b-20,2] /\ w2 in [1b-20,2]
  /\ e0 in [1,1b44] /\ e1 in [1,1b44] /\ e2 in [1,1b44] /\ r0 in [1b-8,1] /\ r1 in [1b-8,1] /\ r2 in [1b-8,1]
  -> a -/ A in [-@ATTRIBUTE:u@,@ATTRIBUTE:u@] }
