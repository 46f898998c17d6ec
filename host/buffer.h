// SPDX-License-Identifier: MIT
// Device memory, mapped for its whole life. Every buffer can be written as a storage buffer and read through
// texel views (lavapipe reads texel buffers 5 to 8 times faster than storage buffers).
#pragma once

#include "host/device.h"
#include "host/error.h"

#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

namespace plumb {

struct BufferImpl;

class RawBuffer {
public:
    RawBuffer() noexcept;  // empty: must not be bound
    // Throws Error(failed) when the budget, maxMemoryAllocationSize or the device refuses.
    // Contents are undefined (recycled allocations are possible): clear what must be clear.
    RawBuffer(Device& device, uint64_t bytes, const char* name);
    RawBuffer(RawBuffer&&) noexcept;
    RawBuffer& operator=(RawBuffer&&) noexcept;
    ~RawBuffer();

    uint64_t bytes() const;  // bytes that the caller asked for
    void* data();            // host address; coherent
    const void* data() const;
    explicit operator bool() const { return impl_ != nullptr; }
    BufferImpl& impl() const { return *impl_; }

private:
    std::unique_ptr<BufferImpl> impl_;
};

// Buffer of `count` elements of T. T has the same bytes in GLSL (scalar block layout).
template <class T>
class Buffer : public RawBuffer {
public:
    Buffer() = default;
    Buffer(Device& device, uint64_t count, const char* name) : RawBuffer(device, checkedBytes(count), name), count_(count) {}
    uint64_t count() const { return count_; }
    std::span<T> span() { return {static_cast<T*>(data()), size_t(count_)}; }
    std::span<const T> span() const { return {static_cast<const T*>(data()), size_t(count_)}; }
    void upload(std::span<const T> from, uint64_t at = 0) {
        PLUMB_ASSERT(at + from.size() <= count_);
        if (!from.empty()) std::memcpy(span().data() + at, from.data(), from.size_bytes());
    }
    void fill(uint32_t word) {  // host-side fill of whole words
        auto* words = static_cast<uint32_t*>(data());
        for (uint64_t i = 0; i < bytes() / 4; ++i) words[i] = word;
    }
    // Grows to at least `count` elements, by a quarter more than asked; contents are lost then.
    void reserve(Device& device, uint64_t count, const char* name) {
        if (count > count_ || !*this) *this = Buffer(device, count + count / 4 + 16, name);
    }

private:
    static uint64_t checkedBytes(uint64_t count) {
        const uint64_t bytes = count * sizeof(T);
        if (count != 0 && bytes / sizeof(T) != count) throw renderError("buffer size overflows 64 bits");
        return bytes == 0 ? sizeof(T) : bytes;
    }
    uint64_t count_ = 0;
};

}  // namespace plumb
