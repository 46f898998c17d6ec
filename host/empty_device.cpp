// SPDX-License-Identifier: MIT
// Floor of every program on this device: creates the first Vulkan device with one queue, and ends. Measured by toolchain/bench_start.py;
// built on demand only.
#include <volk.h>
#include <cstdint>

int main() {
    if (volkInitialize() != VK_SUCCESS) return 4;
    const VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "empty", 1, "empty", 1, VK_API_VERSION_1_2};
    const VkInstanceCreateInfo instanceInfo{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, &application, 0, nullptr, 0, nullptr};
    VkInstance instance = nullptr;
    if (vkCreateInstance(&instanceInfo, nullptr, &instance) != VK_SUCCESS) return 4;
    volkLoadInstance(instance);
    uint32_t count = 1;
    VkPhysicalDevice physical = nullptr;
    if (vkEnumeratePhysicalDevices(instance, &count, &physical) < 0 || count == 0) return 4;
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
    const VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, nullptr, 0, 1, &queue, 0, nullptr, 0, nullptr, nullptr};
    VkDevice device = nullptr;
    if (vkCreateDevice(physical, &info, nullptr, &device) != VK_SUCCESS) return 4;
    volkLoadDevice(device);
    vkDestroyDevice(device, nullptr);
    vkDestroyInstance(instance, nullptr);
    return 0;
}
