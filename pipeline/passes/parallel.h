// SPDX-License-Identifier: MIT
// Bands of a loop on several threads. Which thread takes which band never changes a result: bands do not share output.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <thread>
#include <vector>

namespace plumb {

inline uint32_t threadCount(uint32_t asked) { return asked ? asked : std::max(1u, std::thread::hardware_concurrency()); }

// Calls body(begin, end) for consecutive bands of [0, count); bands hold at least `grain` items.
template <class Body>
void parallelBands(uint64_t count, uint64_t grain, uint32_t threads, const Body& body) {
    const uint64_t bandsWanted = threads <= 1 ? 1 : uint64_t(threads) * 4;
    const uint64_t band = std::max<uint64_t>(grain, (count + bandsWanted - 1) / std::max<uint64_t>(1, bandsWanted));
    if (threads <= 1 || band >= count) {
        if (count) body(uint64_t(0), count);
        return;
    }
    std::atomic<uint64_t> next{0};
    std::exception_ptr failure;
    std::atomic<bool> failed{false};
    auto work = [&] {
        try {
            for (uint64_t begin; !failed && (begin = next.fetch_add(band)) < count;) body(begin, std::min(count, begin + band));
        } catch (...) {
            if (!failed.exchange(true)) failure = std::current_exception();
        }
    };
    {
        std::vector<std::jthread> pool;
        for (uint32_t i = 1; i < threads; ++i) pool.emplace_back(work);
        work();
    }
    if (failure) std::rethrow_exception(failure);
}

}  // namespace plumb
