// SPDX-License-Identifier: MIT
#include "host/buffer.h"

#include "host/vulkan.h"

#include <fmt/core.h>
#include <cstdint>

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <utility>

namespace plumb {

std::string bytesText(uint64_t bytes) {
    if (bytes < 10240) return fmt::format("{} bytes", bytes);
    if (bytes < 10ull << 20) return fmt::format("{:.1f} KiB", double(bytes) / 1024);
    if (bytes < 10ull << 30) return fmt::format("{:.1f} MiB", double(bytes) / (1 << 20));
    return fmt::format("{:.1f} GiB", double(bytes) / (1 << 30));
}

namespace {

uint64_t memAvailableBytes() {
    std::ifstream file("/proc/meminfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("MemAvailable:")) return std::stoull(line.substr(13)) * 1024;
    return UINT64_MAX;
}

// Memory limit of this process: the smallest memory.max from its cgroup to the root (cgroup v2), or the v1 limit.
uint64_t cgroupBytes() {
    uint64_t least = UINT64_MAX;
    const auto take = [&](const std::string& path) {
        std::ifstream file(path);
        uint64_t value;
        if (file >> value) least = std::min(least, value);  // "max" is no number: no limit
    };
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const bool v2 = controllers.empty();
        if (!v2 && controllers != "memory") continue;
        const std::string root = v2 ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        const std::string leaf = v2 ? "/memory.max" : "/memory.limit_in_bytes";
        for (std::string path = line.substr(second + 1);; path.resize(path.rfind('/'))) {
            take(root + (path == "/" ? "" : path) + leaf);
            if (path.find_last_of('/') == std::string::npos || path.empty()) break;
        }
        take(root + leaf);
    }
    return least;
}

}  // namespace

uint64_t memoryBudget(uint64_t heapBytes, uint64_t askedBytes) {
    uint64_t budget = std::min({heapBytes, memAvailableBytes() / 2, cgroupBytes()});
    if (askedBytes != 0) budget = std::min(budget, askedBytes);
    return budget;
}

MemoryPool::MemoryPool(VkDevice device, const VolkDeviceTable& vk, const VkPhysicalDeviceMemoryProperties& types, uint64_t allocationBytes,
                       uint64_t budgetBytes)
    : device_(device), vk_(vk), types_(types), allocationBytes_(allocationBytes), budgetBytes_(budgetBytes) {}

MemoryPool::~MemoryPool() { close(false); }

void MemoryPool::destroy(Block& block) {
    for (const auto& [key, view] : block.views) vk_.vkDestroyBufferView(device_, view, nullptr);
    vk_.vkDestroyBuffer(device_, block.buffer, nullptr);
    vk_.vkFreeMemory(device_, block.memory, nullptr);  // unmaps
}

void MemoryPool::close(bool leak) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    closed_ = true;
    if (leak) return;
    for (Block& block : live_) destroy(block);
    for (Block& block : kept_) destroy(block);
    live_.clear();
    kept_.clear();
}

// Memory type: coherent always; cached first, because the host reads results (uncached reads are some 50 times slower).
uint32_t MemoryPool::memoryType(uint32_t allowed, const char* name) const {
    const VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    for (const VkMemoryPropertyFlags extra : {VkMemoryPropertyFlags(VK_MEMORY_PROPERTY_HOST_CACHED_BIT), VkMemoryPropertyFlags(0)})
        for (uint32_t i = 0; i < types_.memoryTypeCount; ++i)
            if ((allowed >> i & 1u) && (types_.memoryTypes[i].propertyFlags & (wanted | extra)) == (wanted | extra)) return i;
    throw renderError(fmt::format("{}: the device has no host-visible memory for buffers", name));
}

Block* MemoryPool::take(uint64_t bytes, const char* name) {
    const std::lock_guard lock(mutex_);
    PLUMB_ASSERT(!closed_);
    const uint64_t rounded = (bytes + 255) & ~uint64_t(255);
    if (rounded < bytes || rounded > allocationBytes_)
        throw renderError(fmt::format("buffer '{}': {} asked, the device allocates at most {} at once", name, bytesText(bytes),
                                      bytesText(allocationBytes_)));
    auto best = kept_.end();
    for (auto it = kept_.begin(); it != kept_.end(); ++it)
        if (it->bytes >= rounded && it->bytes <= rounded + rounded / 4 + 65536 && (best == kept_.end() || it->bytes < best->bytes))
            best = it;
    // Blocks kept for reuse count against the budget: the least recently freed go first.
    const uint64_t extra = best != kept_.end() ? best->allocatedBytes : rounded;
    if (usedBytes_ + extra > budgetBytes_)
        throw renderError(fmt::format("buffer '{}': {} asked, {} of the memory budget of {} are in use", name, bytesText(bytes),
                                      bytesText(usedBytes_), bytesText(budgetBytes_)));
    if (best != kept_.end()) {
        keptBytes_ -= best->allocatedBytes;
        live_.splice(live_.end(), kept_, best);
    } else {
        while (!kept_.empty() && usedBytes_ + keptBytes_ + rounded > budgetBytes_) {
            keptBytes_ -= kept_.front().allocatedBytes;
            destroy(kept_.front());
            kept_.pop_front();
        }
        Block block;
        block.bytes = rounded;
        const VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                      nullptr,
                                      0,
                                      rounded,
                                      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                                          VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                                          VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                                          VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
                                      VK_SHARING_MODE_EXCLUSIVE,
                                      0,
                                      nullptr};
        try {
            VK_CHECK(vk_.vkCreateBuffer(device_, &info, nullptr, &block.buffer));
            VkMemoryRequirements needs;
            vk_.vkGetBufferMemoryRequirements(device_, block.buffer, &needs);
            const VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
                                                memoryType(needs.memoryTypeBits, name)};
            VK_CHECK(vk_.vkAllocateMemory(device_, &allocate, nullptr, &block.memory));
            VK_CHECK(vk_.vkBindBufferMemory(device_, block.buffer, block.memory, 0));
            VK_CHECK(vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped));
            block.allocatedBytes = needs.size;
        } catch (const Error& error) {
            destroy(block);
            throw Error(error.exit(), fmt::format("buffer '{}' of {}: {}", name, bytesText(bytes), error.what()));
        }
        live_.push_back(std::move(block));
    }
    usedBytes_ += live_.back().allocatedBytes;
    peakBytes_ = std::max(peakBytes_, usedBytes_);
    return &live_.back();
}

void MemoryPool::give(Block* block) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    const auto it = std::find_if(live_.begin(), live_.end(), [&](const Block& b) { return &b == block; });
    PLUMB_ASSERT(it != live_.end());
    usedBytes_ -= it->allocatedBytes;
    keptBytes_ += it->allocatedBytes;
    kept_.splice(kept_.end(), live_, it);
}

VkBufferView MemoryPool::view(Block& block, VkFormat format, uint64_t offset, uint64_t range) {
    const std::lock_guard lock(mutex_);
    const auto [it, fresh] = block.views.try_emplace({format, offset, range}, VkBufferView(VK_NULL_HANDLE));
    if (fresh) {
        const VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, block.buffer, format, offset, range};
        VK_CHECK(vk_.vkCreateBufferView(device_, &info, nullptr, &it->second));
    }
    return it->second;
}

RawBuffer::RawBuffer() noexcept = default;

RawBuffer::RawBuffer(Device& device, uint64_t bytes, const char* name)
    : impl_(std::make_unique<BufferImpl>(device.impl().memory, bytes, name)) {}
RawBuffer::RawBuffer(RawBuffer&&) noexcept = default;
RawBuffer& RawBuffer::operator=(RawBuffer&&) noexcept = default;
RawBuffer::~RawBuffer() = default;

uint64_t RawBuffer::bytes() const { return impl_ ? impl_->bytes : 0; }
void* RawBuffer::data() { return impl_ ? impl_->block->mapped : nullptr; }
const void* RawBuffer::data() const { return impl_ ? impl_->block->mapped : nullptr; }

}  // namespace plumb
