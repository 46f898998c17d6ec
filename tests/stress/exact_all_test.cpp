// SPDX-License-Identifier: MIT
// shaders/shared/exact.h for every root and for the quotients that are hardest to round, from every seed of its promise. PLUMB_LONG=1: all
// roots and 2^34 quotients; else a part of them.
#include "shared/exact.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <thread>
#include <vector>

namespace plumb::gpu {
namespace {

constexpr int kPromise = 7;                // ULP that a seed may be off
constexpr int kPastPowerOfTwo = 4;         // bit patterns beyond a power of two, where each is two ULP of the result below it
constexpr uint32_t kOne = 1u << 23;        // least significand
constexpr uint32_t kQuotientsEach = 1024;  // near-midpoint quotients of a divisor, and as many others

bool isLong() { return std::getenv("PLUMB_LONG") != nullptr; }

// Runs body(first, end) over parts of [0, count) on every processor.
void inParallel(uint64_t count, const std::function<void(uint64_t, uint64_t)>& body) {
    std::atomic<uint64_t> next = 0;
    std::vector<std::thread> threads;
    const uint64_t step = std::max<uint64_t>(1, count / 256);
    for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t)
        threads.emplace_back([&] {
            for (uint64_t first; (first = next.fetch_add(step)) < count;) body(first, std::min(count, first + step));
        });
    for (std::thread& thread : threads) thread.join();
}

float floatOf(uint32_t field, uint32_t significand) { return realOf(int(field << 23 | (significand & 0x7fffffu))); }

// True for a seed that is within the promise: moved by so many bit patterns from the correctly rounded `right`.
bool promised(float right, int moved) {
    if (std::abs(moved) > kPromise) return false;
    return moved <= kPastPowerOfTwo || (ubitsOf(right) & 0x7fffffu) + uint32_t(moved) < kOne;
}

TEST(Exact, EveryRoot) {
    std::atomic<uint64_t> tried = 0, wrong = 0;
    const std::vector<uint32_t> fields = [] {
        std::vector<uint32_t> some = {127, 128};
        for (uint32_t field = 1; field < 255 && isLong(); ++field)
            if (field != 127 && field != 128) some.push_back(field);
        return some;
    }();
    for (const uint32_t field : fields)
        inParallel(kOne, [&, all = field == 127 || field == 128](uint64_t first, uint64_t end) {
            uint64_t count = 0, bad = 0;
            // Every seed for an even and an odd exponent; for the others the result is the same but for its exponent, with a seed each.
            const int from = all ? -kPromise : int(field % 15) - kPromise, to = all ? kPromise : from;
            for (uint64_t significand = first; significand < end; ++significand) {
                const float a = floatOf(field, uint32_t(significand)), right = std::sqrt(a);
                // The seed is the root of a significand below 2^50, whose bits but the exponent are those of the result.
                for (int moved = from; moved <= to; ++moved) {
                    if (!promised(right, moved)) continue;
                    ++count;
                    bad += ubitsOf(emulatedRoot(a, moved)) != ubitsOf(right);
                }
            }
            tried += count;
            wrong += bad;
        });
    std::printf("roots: %llu of %zu exponents, %llu wrong\n", static_cast<unsigned long long>(tried), fields.size(),
                static_cast<unsigned long long>(wrong));
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(tried, uint64_t(fields.size()) * kOne * 9 / 10);
}

// Inverse of an odd number modulo 2^32, by Newton's iteration.
uint32_t inverseOf(uint32_t odd) {
    uint32_t inverse = odd;
    for (int i = 0; i < 5; ++i) inverse *= 2u - odd * inverse;
    return inverse;
}

// Calls body(a) for the dividends whose quotient by b is nearest to the middle between two floats: a 2^k = q b + d with q odd, the
// smallest |d| first.
template <class Body>
uint32_t nearMidpoints(uint32_t b, const Body& body) {
    uint32_t twos = 0;
    while ((b >> twos & 1u) == 0) ++twos;
    const uint32_t inverse = inverseOf(b >> twos);
    uint32_t found = 0;
    for (uint32_t n = 1; found < kQuotientsEach && n < 4 * kQuotientsEach; n += 2)
        for (const int sign : {1, -1})
            for (const uint32_t k : {24u, 25u}) {
                // q = -(d / 2^twos) / (b / 2^twos) modulo 2^(k - twos)
                const uint64_t modulus = uint64_t(1) << (k - twos);
                const uint64_t residue = (0u - uint32_t(sign * int(n))) * inverse & (modulus - 1);
                for (uint64_t q = residue + ((uint64_t(1) << 24) - residue + modulus - 1) / modulus * modulus; q < uint64_t(1) << 25;
                     q += modulus) {
                    if (residue > (uint64_t(1) << 24) && q == 0) continue;
                    const int64_t scaled = int64_t(q * b) + int64_t(sign) * int64_t(uint64_t(n) << twos);
                    const int64_t a = scaled >> k;
                    if ((scaled & ((int64_t(1) << k) - 1)) != 0 || a < int64_t(kOne) || a >= int64_t(2 * kOne)) continue;
                    if ((a < int64_t(b)) != (k == 25)) continue;
                    body(uint32_t(a));
                    if (++found == kQuotientsEach) return found;
                }
            }
    return found;
}

TEST(Exact, QuotientsNextToTheMiddle) {
    const uint64_t divisors = isLong() ? kOne : 2048;
    std::atomic<uint64_t> tried = 0, wrong = 0, nearest = 0;
    inParallel(divisors, [&](uint64_t first, uint64_t end) {
        uint64_t count = 0, bad = 0, near = 0;
        for (uint64_t i = first; i < end; ++i) {
            const uint32_t b = kOne + uint32_t(i * (kOne / divisors)) + (isLong() ? 0u : uint32_t(i * 2654435761u) % (kOne / 2048u));
            uint32_t state = b * 2654435761u;
            const auto judge = [&](uint32_t significand) {
                state = state * 1664525u + 1013904223u;
                const uint32_t fieldB = 100 + (state >> 8) % 50, fieldA = 100 + (state >> 16) % 50;
                const float a = floatOf(fieldA, significand) * (state >> 31 ? -1.0f : 1.0f), divisor = floatOf(fieldB, b);
                const float right = a / divisor;
                const int moved = int((state >> 24) % 15u) - kPromise;
                if (!promised(right, moved)) return;
                ++count;
                bad += ubitsOf(emulatedDivide(a, divisor, moved)) != ubitsOf(right);
            };
            near += nearMidpoints(b, judge);
            for (uint32_t n = 0; n < kQuotientsEach; ++n) judge(kOne + (state >> 9));
        }
        tried += count;
        wrong += bad;
        nearest += near;
    });
    std::printf("quotients: %llu by %llu divisors, %llu of them next to a middle, %llu wrong\n", static_cast<unsigned long long>(tried),
                static_cast<unsigned long long>(divisors), static_cast<unsigned long long>(nearest),
                static_cast<unsigned long long>(wrong));
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(nearest, divisors * kQuotientsEach / 2);
}

// How far a seed may be off: the table of docs/exact-division.md.
TEST(Exact, SeedsByTheirDistance) {
    std::printf("moved  wrong quotients  past a power of two  wrong roots\n");
    for (int moved = -10; moved <= 10; ++moved) {
        uint64_t quotients = 0, past = 0, roots = 0;
        for (uint32_t i = 0; i < 200000; ++i) {
            const uint32_t hash = i * 2654435761u;
            const float a = floatOf(127, i % 3 == 0 ? kOne - 1 - (hash >> 20) : hash >> 9),
                        b = floatOf(127, i % 2 ? hash * 31 >> 9 : hash >> 28);
            const float quotient = a / b, root = std::sqrt(a);
            const bool crosses = moved > 0 && (ubitsOf(quotient) & 0x7fffffu) + uint32_t(moved) >= kOne;
            const bool bad = ubitsOf(emulatedDivide(a, b, moved)) != ubitsOf(quotient);
            (crosses ? past : quotients) += bad;
            if (!(moved > 0 && (ubitsOf(root) & 0x7fffffu) + uint32_t(moved) >= kOne))
                roots += ubitsOf(emulatedRoot(a, moved)) != ubitsOf(root);
        }
        std::printf("%5d  %15llu  %19llu  %11llu\n", moved, static_cast<unsigned long long>(quotients),
                    static_cast<unsigned long long>(past), static_cast<unsigned long long>(roots));
        if (std::abs(moved) <= kPromise) {
            EXPECT_EQ(quotients + roots, 0u) << moved;
        }
        if (moved <= kPastPowerOfTwo) {
            EXPECT_EQ(moved < -kPromise ? 0 : past, 0u) << moved;
        }
        if (std::abs(moved) > kPromise + 1) {
            EXPECT_GT(quotients, 0u) << moved << ": the table must be able to show a fault";
        }
    }
}

}  // namespace
}  // namespace plumb::gpu
