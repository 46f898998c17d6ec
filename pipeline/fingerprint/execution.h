// SPDX-License-Identifier: MIT
// Numbers that the traits about execution and those who ask them share.
#pragma once

#include "pipeline/fingerprint/traits.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace plumb::fingerprint {

inline constexpr uint32_t kSubgroupItems = 64;
inline constexpr uint32_t kIndexWords = 1u << 25;  // of the buffer that large indices point into
inline constexpr uint32_t kAtomicOperands = 4096;
inline constexpr size_t kAtomicWords = 6;
inline constexpr std::array<uint32_t, kAtomicWords> kAtomicStart = {0, ~0u, 0, 0, ~0u, 0};

// Word that the host leaves at an index, and operand of an atomic.
constexpr uint32_t indexWord(uint32_t index) { return index * 0x9e3779b1u ^ 0x5bd1e995u; }
constexpr uint32_t atomicOperand(uint32_t i) { return indexWord(i) | 0x10u; }

// True for a trait whose kernel is run a second time, over the answers of the first.
inline bool isRepeated(const Trait& t) { return t.kernel == Kernel::values || t.kernel == Kernel::loose; }

}  // namespace plumb::fingerprint
