// SPDX-License-Identifier: MIT
// The only file in which GLSL and C++ differ. Everything else in shaders/shared/ reads the same in both.
// Blocks use scalar layout, so a struct has the same bytes on both sides.
//
// Real, Int and Bool are one pixel in C++ (float, int, bool) and four neighbouring pixels of a row on the device
// (vec4, ivec4, bvec4): lavapipe runs four interleaved chains faster than one. Every operation on them is
// componentwise, so a lane of the device computes exactly what the twin computes. A kernel with one pixel an invocation (rays, whose pixels
// diverge) defines PLUMB_ONE_PIXEL before it includes anything.
// `precise` is not written in the sources: the build decorates every float operation of every module with
// NoContraction (toolchain/spirv/), and C++ is compiled with -ffp-contract=off.
#ifndef PLUMB_BRIDGE_H
#define PLUMB_BRIDGE_H
#ifdef __cplusplus
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#define SHARED_BEGIN namespace plumb::gpu {
#define SHARED_END }
#define SHARED_FN inline
#define SHARED_CONST inline constexpr
#define INOUT(T) T&
#define SPECIALIZED(id, T) inline constexpr T  // a specialization constant; in C++ its default
SHARED_BEGIN
using glm::abs;
using glm::ivec2;
using glm::ivec3;
using glm::ivec4;
using glm::max;
using glm::min;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using std::sqrt;
using uint = std::uint32_t;
using Real = float;
using Int = int;
using Bool = bool;
inline float pick(bool c, float yes, float no) { return c ? yes : no; }
inline int pick(bool c, int yes, int no) { return c ? yes : no; }
inline uint pick(bool c, uint yes, uint no) { return c ? yes : no; }
inline bool gt(float a, float b) { return a > b; }
inline bool same(int a, int b) { return a == b; }
inline float toReal(int i) { return float(i); }
inline int toInt(float x) { return int(x); }
inline float real(float x) { return x; }
inline int bitsOf(float x) { return std::bit_cast<int>(x); }
inline float realOf(int bits) { return std::bit_cast<float>(bits); }
inline uint ubitsOf(float x) { return std::bit_cast<uint>(x); }
inline float floorReal(float x) { return std::floor(x); }
inline float roundEvenReal(float x) { return std::nearbyint(x); }
// Power x^y. In C++ it is rounded once; on the device it is the native instruction, in modules that hold it (below).
inline float nativePow(float x, float y) { return float(std::pow(double(x), double(y))); }
inline int shiftLeft(int x, int n) { return int(uint(x) << n); }
// Product a b = high 2^32 + low.
inline void multiplyLong(int a, int b, int& high, uint& low) {
    const std::int64_t product = std::int64_t(a) * b;
    high = int(product >> 32);
    low = uint(product);
}
inline int highestBit(uint x) { return 31 - std::countl_zero(x); }  // x > 0
// Row in binary64 (the low word of each number first) times a point, rounded to float32 at the end.
inline float rowTimesDouble(const uvec4& row01, const uvec4& row23, const vec3& p) {
    const auto number = [](uint low, uint high) { return std::bit_cast<double>(std::uint64_t(high) << 32 | low); };
    const double x = number(row01.x, row01.y) * double(p.x), y = number(row01.z, row01.w) * double(p.y),
                 z = number(row23.x, row23.y) * double(p.z);
    return float(((x + y) + z) + number(row23.z, row23.w));
}
// Sign of a b - c d, exact for |a b|, |c d| < 2^50: -1, 0 or 1.
inline int signOfDifference(int a, int b, int c, int d) {
    const std::int64_t left = std::int64_t(a) * b, right = std::int64_t(c) * d;
    return left > right ? 1 : left < right ? -1 : 0;
}
SHARED_END
#else
#extension GL_EXT_scalar_block_layout : require
#define SHARED_BEGIN
#define SHARED_END
#define SHARED_FN
#define SHARED_CONST const
#define INOUT(T) inout T
#define SPECIALIZED(id, T) layout(constant_id = id) const T
#ifdef PLUMB_ONE_PIXEL
#define Real float
#define Int int
#define Bool bool
float real(float x) { return x; }
#else
#define Real vec4
#define Int ivec4
#define Bool bvec4
vec4 real(float x) { return vec4(x); }
#endif
float pick(bool c, float yes, float no) { return c ? yes : no; }
int pick(bool c, int yes, int no) { return c ? yes : no; }
uint pick(bool c, uint yes, uint no) { return c ? yes : no; }
vec4 pick(bvec4 c, vec4 yes, vec4 no) { return mix(no, yes, c); }
ivec4 pick(bvec4 c, ivec4 yes, ivec4 no) { return mix(no, yes, c); }
bool gt(float a, float b) { return a > b; }  // no plant: every use in a kernel of one pixel is a contract's own decision
bool same(int a, int b) { return a == b; }   // no plant: the same
bvec4 gt(vec4 a, vec4 b) { return greaterThan(a, b); }
bvec4 same(ivec4 a, ivec4 b) { return equal(a, b); }
vec4 toReal(ivec4 i) { return vec4(i); }
float toReal(int i) { return float(i); }
ivec4 toInt(vec4 x) { return ivec4(x); }
int toInt(float x) { return int(x); }
ivec4 bitsOf(vec4 x) { return floatBitsToInt(x); }
int bitsOf(float x) { return floatBitsToInt(x); }
vec4 realOf(ivec4 bits) { return intBitsToFloat(bits); }
float realOf(int bits) { return intBitsToFloat(bits); }
uint ubitsOf(float x) { return floatBitsToUint(x); }
vec4 floorReal(vec4 x) { return floor(x); }
float floorReal(float x) { return floor(x); }
float roundEvenReal(float x) { return roundEven(x); }
// Native power, whose last bits are the implementation's. Only a module built with PLUMB_NATIVE holds the instruction, and recorders take
// that module when a choice asks for it (toolchain/spirv_lint.py). Other modules never call it.
#ifdef PLUMB_NATIVE
vec4 nativePow(vec4 x, vec4 y) { return pow(x, y); }
float nativePow(float x, float y) { return pow(x, y); }
#else
vec4 nativePow(vec4 x, vec4 y) { return x; }
float nativePow(float x, float y) { return x; }
#endif
ivec4 shiftLeft(ivec4 x, int n) { return x << n; }
int shiftLeft(int x, int n) { return x << n; }
void multiplyLong(int a, int b, out int high, out uint low) {
    int lower;
    imulExtended(a, b, high, lower);
    low = uint(lower);
}
int highestBit(uint x) { return findMSB(x); }
// Row in binary64 times a point, in modules that draw by choice only (toolchain/spirv_lint.py): it needs shaderFloat64.
#ifdef PLUMB_DOUBLE
float rowTimesDouble(uvec4 row01, uvec4 row23, vec3 p) {
    double x = packDouble2x32(row01.xy) * double(p.x);
    double y = packDouble2x32(row01.zw) * double(p.y);
    double z = packDouble2x32(row23.xy) * double(p.z);
    return float(((x + y) + z) + packDouble2x32(row23.zw));
}
#else
float rowTimesDouble(uvec4 row01, uvec4 row23, vec3 p) { return 0.0; }
#endif
// Sign of a b - c d. Four roundings of products below 2^50 are less than 2^29 together. So where the float is 2^30 or more its sign is
// right; elsewhere the difference lies within 2^31, and the wrapping integer is the difference itself. 64 bits are slow here.
int signOfDifference(int a, int b, int c, int d) {
    float rough = float(a) * float(b) - float(c) * float(d);
    int wrapped = a * b - c * d;
    return abs(rough) < 1073741824.0 ? sign(wrapped) : rough > 0.0 ? 1 : -1;
}
#endif
#endif
