// SPDX-License-Identifier: MIT
// Contract of the illuminate pass: colours of points (Gouraud: vertices; flat: one point a face), four an invocation.
#ifndef PLUMB_ILLUMINATE_H
#define PLUMB_ILLUMINATE_H
#include "shade.h"
#include "transform.h"
SHARED_BEGIN

struct IlluminatePush {
    uint statusSlot;
    uint firstPoint, pointCount;  // points of one object
    uint object;
    uint firstLight, lightCount;  // a window; the colours continue those of the window before, unless it begins at 0
    vec3 toward;                  // unit vector toward a distant viewer, world axes; 0: the viewer is at the origin
};

SHARED_FN Real rowTimesPoint4(vec4 row, Real x, Real y, Real z) { return ((x * row.x + y * row.y) + z * row.z) + row.w; }
SHARED_FN Real rowTimesVector4(vec4 row, Real x, Real y, Real z) { return (x * row.x + y * row.y) + z * row.z; }

// Surface of a point given in object space; `distant` and `toward` as in seeFrom().
SHARED_FN Surface surfaceOfPoint(ObjectRecord o, bool distant, vec3 toward, Real px, Real py, Real pz, Real nx, Real ny, Real nz) {
    Surface s;
    s.px = rowTimesPoint4(o.world0, px, py, pz);
    s.py = rowTimesPoint4(o.world1, px, py, pz);
    s.pz = rowTimesPoint4(o.world2, px, py, pz);
    s.nx = rowTimesVector4(o.normal0, nx, ny, nz);
    s.ny = rowTimesVector4(o.normal1, nx, ny, nz);
    s.nz = rowTimesVector4(o.normal2, nx, ny, nz);
    unitVector(s.nx, s.ny, s.nz);
    s.vx = -s.px;
    s.vy = -s.py;
    s.vz = -s.pz;
    seeFrom(distant, toward, s);
    return s;
}

SHARED_END
#endif
