// SPDX-License-Identifier: MIT
// Hash table of indices, for things that stand elsewhere: positions, edges, vertices.
#pragma once

#include "pipeline/scene/mesh.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {

inline uint64_t mixBits(uint64_t x) {  // the finalizer of MurmurHash3 (Appleby, public domain)
    x ^= x >> 33;
    x *= 0xff51afd7ed558ccdull;
    x ^= x >> 33;
    x *= 0xc4ceb9fe1a85ec53ull;
    return x ^ x >> 33;
}

// Table with open addressing. It grows and never forgets.
class IndexTable {
public:
    explicit IndexTable(size_t expected) : slots_(std::bit_ceil(std::max<size_t>(16, expected * 2)), kNone) {}

    // Index that `same` accepts; otherwise `fresh`, which is then in the table.
    template <class Same, class HashOf>
    uint32_t findOrAdd(uint64_t hash, uint32_t fresh, Same same, HashOf hashOf) {
        if ((used_ + 1) * 2 > slots_.size()) grow(hashOf);
        for (size_t at = hash & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
            if (slots_[at] == kNone) {
                slots_[at] = fresh;
                ++used_;
                return fresh;
            }
            if (same(slots_[at])) return slots_[at];
        }
    }

private:
    template <class HashOf>
    void grow(HashOf hashOf) {
        std::vector<uint32_t> old(slots_.size() * 2, kNone);
        old.swap(slots_);
        for (uint32_t index : old) {
            if (index == kNone) continue;
            size_t at = hashOf(index) & (slots_.size() - 1);
            while (slots_[at] != kNone) at = (at + 1) & (slots_.size() - 1);
            slots_[at] = index;
        }
    }

    std::vector<uint32_t> slots_;
    size_t used_ = 0;
};

}  // namespace plumb
