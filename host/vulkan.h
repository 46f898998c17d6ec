// SPDX-License-Identifier: MIT
// Inside host/ only: the Vulkan objects behind device.h, buffer.h, program.h and recorder.h.
// Ownership: Device -> DeviceImpl -> Instance (shared), MemoryPool (shared with the buffers), programs.
// A buffer that outlives its device is harmless: the pool has already freed its block.
#pragma once

#include "host/device.h"
#include "host/driver.h"
#include "host/error.h"
#include "host/program.h"
#include "host/recorder.h"
#include "host/replay.h"

#include <volk.h>
#include <cstdint>

#include <functional>
#include <future>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

const char* resultName(VkResult result);
// Throws unless VK_SUCCESS: "VK_ERROR_DEVICE_LOST from vkQueueSubmit(...) at host/recorder.cpp:12".
void checkResult(VkResult result, Exit exit, const char* call, const char* file, int line);
#define VK_CHECK(call) ::plumb::checkResult((call), ::plumb::Exit::failed, #call, __FILE__, __LINE__)
#define VK_CHECK_START(call) ::plumb::checkResult((call), ::plumb::Exit::device, #call, __FILE__, __LINE__)

// Bytes as text for messages: "1536 bytes", "12.3 MiB".
std::string bytesText(uint64_t bytes);

struct ValidationLog {
    std::mutex mutex;
    std::vector<std::string> lines;
    bool toStderr = false;  // while the device is torn down, nobody can read `lines` any more
};

struct Instance {
    VkInstance handle = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
    bool validation = false;
    ValidationLog log;

    Instance() = default;
    Instance(const Instance&) = delete;
    ~Instance();

    // Null when there is no loader or no driver; then `why` says which. Throws Error(device) when validation is asked
    // for and the layer is missing. An instance of the same kind that is still alive is shared.
    static std::shared_ptr<Instance> acquire(bool validation, std::string& why);
    std::vector<VkPhysicalDevice> physicalDevices() const;
};

bool validationWanted(const DeviceRequest& request);
DeviceInfo describe(VkPhysicalDevice physical, uint32_t index);

// One VkBuffer with its own allocation, mapped; recycled as a whole.
struct Block {
    struct ViewKey {
        VkFormat format;
        uint64_t offset, range;
        auto operator<=>(const ViewKey&) const = default;
    };
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    void* mapped = nullptr;
    uint64_t bytes = 0;           // usable bytes
    uint64_t allocatedBytes = 0;  // bytes that count against the budget
    std::map<ViewKey, VkBufferView> views;
};

// Device memory of one device. Keeps freed blocks for reuse as long as the budget allows, because fresh pages of lavapipe cost a page fault
// each.
class MemoryPool {
public:
    MemoryPool(VkDevice device, const VolkDeviceTable& vk, const VkPhysicalDeviceMemoryProperties& types, uint64_t allocationBytes,
               uint64_t budgetBytes);
    ~MemoryPool();
    Block* take(uint64_t bytes, const char* name);
    void give(Block* block);
    VkBufferView view(Block& block, VkFormat format, uint64_t offset, uint64_t range);
    void close(bool leak);  // frees all memory; give() does nothing afterwards

    uint64_t budgetBytes() const { return budgetBytes_; }
    uint64_t usedBytes() const { return usedBytes_; }
    uint64_t peakBytes() const { return peakBytes_; }

private:
    void destroy(Block& block);
    uint32_t memoryType(uint32_t allowed, const char* name) const;

    mutable std::mutex mutex_;
    VkDevice device_;
    const VolkDeviceTable& vk_;
    VkPhysicalDeviceMemoryProperties types_;
    uint64_t allocationBytes_, budgetBytes_;
    uint64_t usedBytes_ = 0, peakBytes_ = 0, keptBytes_ = 0;
    std::list<Block> live_, kept_;
    bool closed_ = false;
};

struct BufferImpl {
    std::shared_ptr<MemoryPool> pool;
    uint64_t bytes;
    std::string name;
    Block* block;

    BufferImpl(std::shared_ptr<MemoryPool> from, uint64_t size, const char* called)
        : pool(std::move(from)), bytes(size), name(called), block(pool->take(size, called)) {}
    BufferImpl(BufferImpl&& other) noexcept
        : pool(std::move(other.pool)), bytes(other.bytes), name(std::move(other.name)), block(std::exchange(other.block, nullptr)) {}
    BufferImpl& operator=(BufferImpl&&) = delete;
    ~BufferImpl() {
        if (block) pool->give(block);
    }
};

// Names by which a recorder is given the bindings and constants of a module without names.
std::string unnamedBinding(uint32_t number);
std::string unnamedConstant(uint32_t id);

struct Program {
    Reflection reflection;
    VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    // Module that it was made of, its constants, and the hash of the words that the driver got: for plantDriver().
    Module module;
    ConstantsById constants;
    uint64_t wordsHash = 0;
};

// Applies PLUMB_LIMITS. Throws Error(device) on an unknown name or a value above the device's own.
// "memory=" lowers the budget; "nativeDivide=0" and "nativeRoot=0" make the modules run the emulated forms.
struct ShrunkNative {
    bool divide = true, root = true;
};
ShrunkNative shrinkLimits(const char* text, DeviceLimits& limits, uint64_t& memoryBudgetBytes);

// Time that a destructor waits for work whose end was not seen.
inline constexpr double kGraceMs = 5000;

struct DeviceImpl {
    std::shared_ptr<Instance> instance;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice handle = VK_NULL_HANDLE;
    VolkDeviceTable vk{};
    uint32_t queueFamily = 0;
    bool queueDraws = false;  // the queue supports graphics too
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t timestampBits = 0;
    uint32_t driverVersion = 0;
    uint32_t stageBindings[3] = {};  // limits of a stage: storage buffers, texel buffers, all bindings
    DeviceInfo info;
    DeviceLimits limits;
    SelfTest selfTest;
    std::optional<bool> exactBinary64;  // host/binary64.h; empty: not tested yet
    ShrunkNative native;
    std::shared_ptr<MemoryPool> memory;
    VkPipelineCache pipelineCache = VK_NULL_HANDLE;
    std::map<std::string, Program> programs;
    std::map<std::string, std::future<Program>> making;                 // pipelines that prepare() began and nobody has used yet
    ModuleRewriter rewriter;                                            // of tests; empty: modules are loaded as they are
    std::map<std::string, std::vector<uint32_t>, std::less<>> planted;  // of tests: words in place of a module's own, by its name
    std::set<std::string, std::less<>> modulesRun;                      // names of what was dispatched
    DispatchWitness witness;                                            // empty: nobody wants the bytes of dispatches
    // True from a wait for a fence that failed, for whatever reason, to one that succeeds: work may still run, so nothing that it uses may be
    // destroyed.
    bool hung = false;

    DeviceImpl() = default;
    DeviceImpl(const DeviceImpl&) = delete;
    ~DeviceImpl();

    // Pipeline of (module, constants), made on first use. Constants of exact.h that are not given follow the
    // self-test. Throws Error(failed) naming the module.
    Program& program(const Module& module, const Specialization& constants);
    // Begins to make a pipeline on a thread of its own. Its errors are thrown by program().
    void prepare(const Module& module, const Specialization& constants);
    Program make(const Module& module, const Specialization& constants) const;
    // Values of all constants of the module, and its words as the driver reads them.
    ConstantsById constantsOf(const Module& module, const Specialization& constants) const;
    std::vector<uint32_t> wordsOf(const Module& module, const ConstantsById& constants) const;
    void destroy(const Program& program) const;
};

// Memory budget: min(heap, half of MemAvailable, cgroup limits, asked). 0 asked: no limit by the caller.
uint64_t memoryBudget(uint64_t heapBytes, uint64_t askedBytes);

}  // namespace plumb
