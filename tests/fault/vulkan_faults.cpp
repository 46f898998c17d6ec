// SPDX-License-Identifier: MIT
// The command on a Vulkan whose n-th call of one entry point fails: PLUMB_VULKAN_FAULT="vkQueueSubmit:3:-4:once" (or sticky: that call and
// all later ones). The call itself is not made. PLUMB_VULKAN_CALLS names a file that holds, at the end of the program, "ENTRY CALLS FAILED" of
// that entry point; "all:0:0:once" writes a line for each entry point. The linker puts what is here in the place of volk (--wrap).
#include <volk.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace {

struct Fault {
    std::string entry;
    uint32_t number = 0;  // of the first call that fails, from 1
    int result = 0;
    bool sticky = false;
};

Fault faultOfEnvironment() {
    const char* const word = std::getenv("PLUMB_VULKAN_FAULT");
    std::vector<std::string> parts(1);
    for (const char c : std::string_view(word != nullptr ? word : "")) {
        if (c == ':')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    if (parts.size() != 4) return {};
    return {parts[0], uint32_t(std::stoul(parts[1])), std::stoi(parts[2]), parts[3] == "sticky"};
}

struct Entry {
    const char* name;
    std::atomic<uint32_t> calls{0}, failed{0};
};

const Fault kFault = faultOfEnvironment();
std::vector<Entry*> entries;

struct Report {
    ~Report() {
        const char* const path = std::getenv("PLUMB_VULKAN_CALLS");
        std::FILE* const file = path != nullptr ? std::fopen(path, "w") : nullptr;
        if (file == nullptr) return;
        for (const Entry* e : entries) std::fprintf(file, "%s %u %u\n", e->name, e->calls.load(), e->failed.load());
        std::fclose(file);
    }
} report;

// One entry point. Number: keeps two of one type apart.
template <size_t Number, class Result, class... A>
struct Point {
    inline static Result (*real)(A...) = nullptr;
    inline static Entry entry{};
    static Result call(A... a) {
        const uint32_t number = ++entry.calls;
        const bool due = kFault.number != 0 && (kFault.sticky ? number >= kFault.number : number == kFault.number);
        if (!due) return real(a...);
        ++entry.failed;
        return Result(kFault.result);
    }
};

template <size_t Number, class Result, class... A>
void watch(Result (*&pointer)(A...), const char* name) {
    using P = Point<Number, Result, A...>;
    if (pointer == nullptr || pointer == &P::call || (kFault.entry != name && kFault.entry != "all")) return;
    if (P::entry.name == nullptr) {
        P::entry.name = name;
        entries.push_back(&P::entry);
    }
    P::real = pointer;
    pointer = &P::call;
}

#define WATCH(table, name) watch<__LINE__>(table name, #name)

}  // namespace

extern "C" {

VkResult __real_volkInitialize();
void __real_volkLoadInstanceOnly(VkInstance instance);
void __real_volkLoadDeviceTable(VolkDeviceTable* table, VkDevice device);

VkResult __wrap_volkInitialize() {
    const VkResult result = __real_volkInitialize();
    WATCH(, vkCreateInstance);
    return result;
}

void __wrap_volkLoadInstanceOnly(VkInstance instance) {
    __real_volkLoadInstanceOnly(instance);
    WATCH(, vkEnumeratePhysicalDevices);
    WATCH(, vkCreateDevice);
}

void __wrap_volkLoadDeviceTable(VolkDeviceTable* table, VkDevice device) {
    __real_volkLoadDeviceTable(table, device);
    WATCH(table->, vkAllocateCommandBuffers);
    WATCH(table->, vkAllocateDescriptorSets);
    WATCH(table->, vkAllocateMemory);
    WATCH(table->, vkBeginCommandBuffer);
    WATCH(table->, vkBindBufferMemory);
    WATCH(table->, vkCreateBuffer);
    WATCH(table->, vkCreateBufferView);
    WATCH(table->, vkCreateCommandPool);
    WATCH(table->, vkCreateComputePipelines);
    WATCH(table->, vkCreateDescriptorPool);
    WATCH(table->, vkCreateDescriptorSetLayout);
    WATCH(table->, vkCreateFence);
    WATCH(table->, vkCreatePipelineCache);
    WATCH(table->, vkCreatePipelineLayout);
    WATCH(table->, vkCreateQueryPool);
    WATCH(table->, vkCreateShaderModule);
    WATCH(table->, vkEndCommandBuffer);
    WATCH(table->, vkGetQueryPoolResults);
    WATCH(table->, vkMapMemory);
    WATCH(table->, vkQueueSubmit);
    WATCH(table->, vkResetCommandPool);
    WATCH(table->, vkResetDescriptorPool);
    WATCH(table->, vkResetFences);
    WATCH(table->, vkWaitForFences);
}
}
