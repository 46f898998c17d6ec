// SPDX-License-Identifier: MIT
// Contract of the shade pass: Phong's illumination in linear RGB (docs/illumination.md, A point).
//   colour = base + sum over lights of I * attenuation * (Kd max(N.L, 0) + Ks (R.V)^n [N.L > 0]),  base = Ka Ia + Ke.
// Only float32 + - *, integer operations on bits and selections: the same bytes on every device that rounds correctly.
// Attenuation weighs diffuse and specular alike. Lights are added in the order of their list.
#ifndef PLUMB_SHADE_H
#define PLUMB_SHADE_H
#include "bridge.h"
SHARED_BEGIN

SHARED_CONST uint kShadingUnlit = 0u;
SHARED_CONST uint kShadingFlat = 1u;
SHARED_CONST uint kShadingGouraud = 2u;
SHARED_CONST uint kShadingPhong = 3u;

// Light in two texels: (x, y, z, kind), (r, g, b, attenuation). kind 0: unit vector toward the light; 1: position relative to the eye.
struct LightRecord {
    vec3 position;
    float kind;
    vec3 intensity;
    float attenuation;  // exponent of 1 / d by which the light fades: 0, 1 or 2
};
SHARED_CONST int kLightTexels = 2;

// Material in three texels.
struct MaterialRecord {
    vec3 base;  // Ka Ia + Ke
    float shininess;
    vec3 diffuse;
    float zeroPower;  // 1 when shininess is 0, else 0: (R.V)^0 = 1 for every R.V
    vec3 specular;
    float reserved;
};
SHARED_CONST int kMaterialTexels = 3;

// Function that computes the power of the highlight, x^n with x = R.V.
SHARED_CONST uint kPowerExact = 0u;
SHARED_CONST uint kPowerSchlick = 1u;
SHARED_CONST uint kPowerNative = 2u;

// Terms of the illumination that the kernel computes (the plan turns off those that are zero in this scene), and the function used for the
// highlight's power.
struct ShadeParts {
    bool diffuse, specular, point;
    uint power;
};

// Value of 1 / sqrt(x) for normal x > 0: integer seed (Lomont's constant) and three Newton steps; relative error below 4 u. Keep the order
// (h y) y: at x = 0, y y overflows to infinity and 0 times infinity is NaN. The result at 0 is large and finite.
SHARED_FN Real reciprocalRoot(Real x) {
    Real y = realOf(0x5f375a86 - (bitsOf(x) >> 1));
    Real h = x * -0.5f;
    y = y * ((h * y) * y + 1.5f);
    y = y * ((h * y) * y + 1.5f);
    y = y * ((h * y) * y + 1.5f);
    return y;
}

// Value of 1 / x for normal x > 0, relative error below 9 u.
SHARED_FN Real reciprocal(Real x) {
    Real y = reciprocalRoot(x);
    return y * y;
}

// Power (1 - delta)^n = exp2(n log2(1 - delta)) without cancellation: while 1 - delta >= sqrt(1/2) the polynomial takes -delta itself.
// Minimax polynomials of degree 7 for log2(1 + x) / x (1.7e-7) and 5 for exp2 (7.5e-8); n in [0, 1e6].
SHARED_FN Real specularPower(Real delta, Real n, Real zeroPower) {
    Real u = real(1.0f) - delta;
    u = pick(gt(u, real(9.5367431640625e-7f)), u, real(9.5367431640625e-7f));
    Int bits = bitsOf(u);
    Int e = (bits - 0x3f3504f3) >> 23;
    Real m = realOf(bits - shiftLeft(e, 23));
    Real x = pick(same(e, e - e), -delta, m - 1.0f);
    Real y = x * -0.145807055f + 0.234040521f;
    y = y * x - 0.248877417f;
    y = y * x + 0.287098915f;
    y = y * x - 0.36023962f;
    y = y * x + 0.480923236f;
    y = y * x - 0.721352788f;
    y = y * x + 1.44269496f;
    Real p = n * (toReal(e) + y * x);
    p = pick(gt(p, real(-120.0f)), p, real(-120.0f));
    Real k = floorReal(p + 0.5f);
    Real r = p - k;
    Real q = r * 0.00132764727f + 0.00967554133f;
    q = q * r + 0.0555071327f;
    q = q * r + 0.240221197f;
    q = q * r + 0.693146967f;
    q = q * r + 1.0f;
    Real power = realOf(bitsOf(q) + shiftLeft(toInt(k), 23));
    return pick(gt(real(1.0f), delta), power, zeroPower);  // delta >= 1: R.V <= 0
}

// Greatest excess of Schlick's x / (n - n x + x) over x^n (C. Schlick, A Fast Alternative to Phong's Specular Model, Graphics Gems IV,
// 1994). Both are 1 with slope n at x = 1. For n >= 1 Schlick's is nowhere below x^n and nowhere more than kSchlickExcess above it. With t
// = n (1 - x), Schlick's is at most 1 / (1 + t), and x^n at least e^-t (1 - t^2 / n). The supremum is approached for large n, where the
// excess is 1 / (1 + t) - e^-t, largest 0.20363 at t = 2.5129 (tests/unit/contracts_test.cpp sweeps n from 1 to 10^6). For n < 1 there is
// no such bound. Rounding adds less than 16 u.
SHARED_CONST float kSchlickExcess = 0.2037f;
SHARED_FN Real schlickPower(Real delta, Real n, Real zeroPower) {
    Real x = real(1.0f) - delta;
    Real quotient = x * reciprocal(n * delta + x);
    return pick(gt(real(1.0f), delta), quotient, zeroPower);
}

// Lights that one dispatch adds up; more are added window by window. Loop iterations of an invocation are limited, and a dispatch should
// take at most 100 ms.
SHARED_CONST uint kLightsPerWindow = 1280u;

// Power by the device's own pow(x, n). Vulkan allows exp2(n log2 x) with log2 off by 2^-21 in [1/2, 2] and by 3 ULP elsewhere, exp2 by 3 +
// 2 |p| ULP.
SHARED_FN Real nativePower(Real delta, Real n, Real zeroPower) {
    Real x = real(1.0f) - delta;
    x = pick(gt(x, real(9.5367431640625e-7f)), x, real(9.5367431640625e-7f));
    return pick(gt(real(1.0f), delta), nativePow(x, n), zeroPower);
}
// Bound of |nativePower - specularPower|, n in [0, 1e6]. p = n log2 x <= 0 is off by E = 1.25 n 2^-21 where x >= 1/2 (2^-21 from log2,
// 2^-22.5 from rounding x = 1 - delta) and by 3.5 |p| 2^-23 elsewhere. Then 2^p has a relative error of (3 + 2 |p| + 2 E) 2^-23. With |p|
// 2^p <= 0.531 that is at most 2^E - 1 + 2^E (3 + 2 E + 1.3 + 1.3) 2^-23, and 2^E <= 1 + E for E <= 1. 3 2^-23 more is specularPower's own
// error.
SHARED_FN float nativePowerBound(float n) {
    float e = n * 5.9604644775390625e-7f;
    return e + (1.0f + e) * (10.0f + 2.0f * e) * 1.1920928955078125e-7f;
}

struct Surface {
    Real nx, ny, nz;  // unit normal, world axes
    Real vx, vy, vz;  // unit vector toward the eye
    Real px, py, pz;  // position relative to the eye (read by point lights only)
};

struct Reflectance {
    Real dr, dg, db;  // Kd
    Real sr, sg, sb;  // Ks
    Real n, zeroPower;
};

struct Colour {
    Real r, g, b;
};

SHARED_FN void unitVector(INOUT(Real) x, INOUT(Real) y, INOUT(Real) z) {
    Real inverse = reciprocalRoot((x * x + y * y) + z * z);
    x = x * inverse;
    y = y * inverse;
    z = z * inverse;
}

// Normalises the view vector of s. A distant viewer (section 3 of the notes) has the same unit vector everywhere.
SHARED_FN void seeFrom(bool distant, vec3 toward, INOUT(Surface) s) {
    if (distant) {
        s.vx = real(toward.x);
        s.vy = real(toward.y);
        s.vz = real(toward.z);
    } else {
        unitVector(s.vx, s.vy, s.vz);
    }
}

// Unit vector toward a light, and the share of its light that reaches the point (`fade`).
struct Toward {
    Real x, y, z, fade;
};
SHARED_FN Toward towardLight(vec4 position, float attenuation, bool point, Real px, Real py, Real pz) {
    Toward t;
    t.x = real(position.x);
    t.y = real(position.y);
    t.z = real(position.z);
    t.fade = real(1.0f);
    if (point && position.w != 0.0f) {
        t.x = t.x - px;
        t.y = t.y - py;
        t.z = t.z - pz;
        Real inverse = reciprocalRoot((t.x * t.x + t.y * t.y) + t.z * t.z);
        t.x = t.x * inverse;
        t.y = t.y * inverse;
        t.z = t.z * inverse;
        if (attenuation == 1.0f) t.fade = inverse;
        if (attenuation == 2.0f) t.fade = inverse * inverse;
    }
    return t;
}

// Adds one light. R = 2 (N.L) N - L; delta = |R - V|^2 / 2 = 1 - R.V for unit vectors, without cancellation near the highlight.
SHARED_FN void addLightFrom(Toward t, vec4 intensity, Surface s, Reflectance k, ShadeParts parts, INOUT(Colour) c) {
    Real fade = t.fade;
    Real nl = (s.nx * t.x + s.ny * t.y) + s.nz * t.z;
    Bool lit = gt(nl, real(0.0f));
    if (parts.point) fade = pick(lit, fade, real(0.0f));  // a light exactly at the point: 1 / d^2 is infinite, and 0 times it not a number
    Real r = real(0.0f);
    Real g = real(0.0f);
    Real b = real(0.0f);
    if (parts.diffuse) {
        Real d = pick(lit, nl, real(0.0f));
        r = k.dr * d;
        g = k.dg * d;
        b = k.db * d;
    }
    if (parts.specular) {
        Real twice = nl + nl;
        Real qx = (twice * s.nx - t.x) - s.vx;
        Real qy = (twice * s.ny - t.y) - s.vy;
        Real qz = (twice * s.nz - t.z) - s.vz;
        Real delta = ((qx * qx + qy * qy) + qz * qz) * 0.5f;
        Real power = real(0.0f);
        if (parts.power == kPowerSchlick)
            power = schlickPower(delta, k.n, k.zeroPower);
        else if (parts.power == kPowerNative)
            power = nativePower(delta, k.n, k.zeroPower);
        else
            power = specularPower(delta, k.n, k.zeroPower);
        power = pick(lit, power, real(0.0f));
        r = r + k.sr * power;
        g = g + k.sg * power;
        b = b + k.sb * power;
    }
    c.r = c.r + (r * fade) * intensity.x;
    c.g = c.g + (g * fade) * intensity.y;
    c.b = c.b + (b * fade) * intensity.z;
}

SHARED_FN void addLight(vec4 position, vec4 intensity, Surface s, Reflectance k, ShadeParts parts, INOUT(Colour) c) {
    addLightFrom(towardLight(position, intensity.w, parts.point, s.px, s.py, s.pz), intensity, s, k, parts, c);
}

SHARED_END
#endif
