# SPDX-License-Identifier: MIT
# A row of the transform times a point, the row's numbers rounded once from what they should be.
# Terms of one sign: each then carries the factor that it has with any signs, so the bound holds of sum |m_i p_i| in general.
# contract transform.h: return ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w;
# bound ROW bounds.h: kRowUnits = ([\d.]+)f
@rnd = float<ieee_32,ne>;
m0 = rnd(M0); m1 = rnd(M1); m2 = rnd(M2); m3 = rnd(M3);
x = rnd(x_); y = rnd(y_); z = rnd(z_);
r rnd= ((m0 * x + m1 * y) + m2 * z) + m3;
R = ((M0 * x + M1 * y) + M2 * z) + M3;
{ M0 in [1b-40,1b40] /\ M1 in [1b-40,1b40] /\ M2 in [1b-40,1b40] /\ M3 in [1b-40,1b40]
  /\ x in [1b-40,1b40] /\ y in [1b-40,1b40] /\ z in [1b-40,1b40]
  -> r -/ R in [-@ROW:u@,@ROW:u@] }
