// SPDX-License-Identifier: MIT
// Loader, instance, physical devices, the open device, its limits.
#include "host/vulkan.h"

#include "host/selftest.h"

#include <fmt/core.h>
#include <cstdint>
#include <cstdio>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace plumb {

const char* resultName(VkResult result) {
    switch (result) {
#define PLUMB_NAME(name) \
    case name:           \
        return #name
        PLUMB_NAME(VK_SUCCESS);
        PLUMB_NAME(VK_NOT_READY);
        PLUMB_NAME(VK_TIMEOUT);
        PLUMB_NAME(VK_INCOMPLETE);
        PLUMB_NAME(VK_ERROR_OUT_OF_HOST_MEMORY);
        PLUMB_NAME(VK_ERROR_OUT_OF_DEVICE_MEMORY);
        PLUMB_NAME(VK_ERROR_INITIALIZATION_FAILED);
        PLUMB_NAME(VK_ERROR_DEVICE_LOST);
        PLUMB_NAME(VK_ERROR_MEMORY_MAP_FAILED);
        PLUMB_NAME(VK_ERROR_LAYER_NOT_PRESENT);
        PLUMB_NAME(VK_ERROR_EXTENSION_NOT_PRESENT);
        PLUMB_NAME(VK_ERROR_FEATURE_NOT_PRESENT);
        PLUMB_NAME(VK_ERROR_INCOMPATIBLE_DRIVER);
        PLUMB_NAME(VK_ERROR_TOO_MANY_OBJECTS);
        PLUMB_NAME(VK_ERROR_FORMAT_NOT_SUPPORTED);
        PLUMB_NAME(VK_ERROR_FRAGMENTED_POOL);
        PLUMB_NAME(VK_ERROR_OUT_OF_POOL_MEMORY);
        PLUMB_NAME(VK_ERROR_UNKNOWN);
#undef PLUMB_NAME
        default:
            return "an unnamed VkResult";
    }
}

void checkResult(VkResult result, Exit exit, const char* call, const char* file, int line) {
    if (result == VK_SUCCESS) return;
    throw Error(exit, fmt::format("{} ({}) from {} at {}:{}", resultName(result), int(result), call, file, line));
}

// ---- instance ----

namespace {

std::mutex instanceMutex;                    // volk's instance functions are globals
std::weak_ptr<Instance> sharedInstances[2];  // by validation

VKAPI_ATTR VkBool32 VKAPI_CALL collectMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT,
                                              const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    auto& log = *static_cast<ValidationLog*>(user);
    std::string line = fmt::format("{}: {}", severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? "error" : "warning",
                                   data->pMessage ? data->pMessage : "");
    std::replace(line.begin(), line.end(), '\n', ' ');
    const std::lock_guard lock(log.mutex);
    if (log.toStderr) std::fprintf(stderr, "plumb: validation %s\n", line.c_str());
    log.lines.push_back(std::move(line));
    return VK_FALSE;
}

const char* const kValidationLayer = "VK_LAYER_KHRONOS_validation";

void requireValidationLayer() {
    uint32_t count = 0;
    VK_CHECK_START(vkEnumerateInstanceLayerProperties(&count, nullptr));
    std::vector<VkLayerProperties> layers(count);
    VK_CHECK_START(vkEnumerateInstanceLayerProperties(&count, layers.data()));
    for (const VkLayerProperties& layer : layers)
        if (std::strcmp(layer.layerName, kValidationLayer) == 0) return;
    throw deviceError(fmt::format("validation was asked for, but {} is not installed (Debian: vulkan-validationlayers)", kValidationLayer));
}

std::string driverFilesHint() {
    for (const char* variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"})
        if (const char* value = std::getenv(variable)) return fmt::format(" ({}='{}')", variable, value);
    return "";
}

}  // namespace

bool validationWanted(const DeviceRequest& request) {
    const char* value = std::getenv("PLUMB_VALIDATION");
    return request.validation || (value && std::strcmp(value, "1") == 0);
}

std::shared_ptr<Instance> Instance::acquire(bool validation, std::string& why) {
    const std::lock_guard lock(instanceMutex);
    std::weak_ptr<Instance>& shared = sharedInstances[validation ? 1 : 0];
    if (auto alive = shared.lock()) return alive;
    if (volkInitialize() != VK_SUCCESS) {
        if (validation) throw deviceError("validation was asked for, but there is no Vulkan loader (libvulkan.so.1)");
        why = "there is no Vulkan loader (libvulkan.so.1)";
        return nullptr;
    }
    if (volkGetInstanceVersion() < VK_API_VERSION_1_2) {
        why = "the Vulkan loader is older than 1.2";
        return nullptr;
    }
    if (validation) requireValidationLayer();

    auto instance = std::make_shared<Instance>();
    instance->validation = validation;
    const VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "plumbline", 1, "plumbline", 1, VK_API_VERSION_1_2};
    const VkDebugUtilsMessengerCreateInfoEXT messenger{
        VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        nullptr,
        0,
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        collectMessage,
        &instance->log};
    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger, 1, &synchronization, 0, nullptr};
    const char* const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    if (validation) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &kValidationLayer;
        info.enabledExtensionCount = 2;
        info.ppEnabledExtensionNames = extensions;
    }
    const VkResult result = vkCreateInstance(&info, nullptr, &instance->handle);
    if (result != VK_SUCCESS) {
        instance->handle = VK_NULL_HANDLE;
        why = result == VK_ERROR_INCOMPATIBLE_DRIVER ? fmt::format("the Vulkan loader found no working driver (ICD){}", driverFilesHint())
                                                     : fmt::format("vkCreateInstance returned {}{}", resultName(result), driverFilesHint());
        if (validation && result != VK_ERROR_INCOMPATIBLE_DRIVER) throw deviceError("validation was asked for, but " + why);
        return nullptr;
    }
    volkLoadInstanceOnly(instance->handle);
    if (validation) VK_CHECK_START(vkCreateDebugUtilsMessengerEXT(instance->handle, &messenger, nullptr, &instance->messenger));
    shared = instance;
    if (instance->physicalDevices().empty()) why = "the Vulkan driver lists no device" + driverFilesHint();
    return instance;
}

Instance::~Instance() {
    if (!handle) return;
    log.toStderr = true;
    if (messenger) vkDestroyDebugUtilsMessengerEXT(handle, messenger, nullptr);
    vkDestroyInstance(handle, nullptr);
}

std::vector<VkPhysicalDevice> Instance::physicalDevices() const {
    uint32_t count = 0;
    // A driver whose hardware is absent answers VK_ERROR_INITIALIZATION_FAILED: there is no device, and no fault of ours.
    if (vkEnumeratePhysicalDevices(handle, &count, nullptr) != VK_SUCCESS) return {};
    std::vector<VkPhysicalDevice> devices(count);
    const VkResult result = vkEnumeratePhysicalDevices(handle, &count, devices.data());
    if (result != VK_SUCCESS && result != VK_INCOMPLETE) return {};
    devices.resize(count);
    return devices;
}

// ---- physical devices ----

namespace {

constexpr uint32_t kNoFamily = ~0u;

// Index of the compute queue family: the first one with time stamps, else the first one.
uint32_t computeFamily(const std::vector<VkQueueFamilyProperties>& families) {
    uint32_t best = kNoFamily;
    for (uint32_t i = 0; i < families.size(); ++i)
        if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) && families[i].queueCount > 0 &&
            (best == kNoFamily || (families[best].timestampValidBits == 0 && families[i].timestampValidBits != 0)))
            best = i;
    return best;
}

std::vector<VkQueueFamilyProperties> queueFamilies(VkPhysicalDevice physical) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    return families;
}

// Queried properties and features of a device of Vulkan 1.2 or later. Do not copy or move: pNext points into the struct.
struct Queried {
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceMaintenance3Properties maintenance3{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, &subgroup};
    VkPhysicalDeviceIDProperties ids{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES, &maintenance3};
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, &ids};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
    VkPhysicalDeviceScalarBlockLayoutFeatures scalar{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &scalar};

    explicit Queried(VkPhysicalDevice physical) {
        vkGetPhysicalDeviceProperties2(physical, &properties);
        vkGetPhysicalDeviceFeatures2(physical, &features);
    }
    Queried(const Queried&) = delete;
};

DeviceLimits limitsOf(const Queried& q, const std::vector<VkQueueFamilyProperties>& families, uint32_t family) {
    const VkPhysicalDeviceLimits& l = q.properties.properties.limits;
    DeviceLimits limits;
    limits.storageRangeBytes = l.maxStorageBufferRange;
    limits.texelElements = l.maxTexelBufferElements;
    for (int i = 0; i < 3; ++i) limits.groupCount[i] = l.maxComputeWorkGroupCount[i];
    limits.allocationBytes = q.maintenance3.maxMemoryAllocationSize;
    limits.groupInvocations = l.maxComputeWorkGroupInvocations;
    limits.pushConstantBytes = l.maxPushConstantsSize;
    limits.subgroupSize = q.subgroup.subgroupSize;
    limits.texelOffsetAlignment = uint32_t(l.minTexelBufferOffsetAlignment);
    limits.storageOffsetAlignment = uint32_t(l.minStorageBufferOffsetAlignment);
    limits.timestampPeriodNs = families[family].timestampValidBits != 0 ? double(l.timestampPeriod) : 0;
    const VkSubgroupFeatureFlags needed = VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT;
    limits.subgroupShuffle = (q.subgroup.supportedOperations & needed) == needed &&
                             (q.subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) && limits.subgroupSize >= 8 &&
                             std::has_single_bit(limits.subgroupSize);
    limits.subPixelBits = l.subPixelPrecisionBits;
    limits.int64 = q.features.features.shaderInt64;
    limits.float64 = q.features.features.shaderFloat64;
    for (const VkQueueFamilyProperties& f : families)
        limits.hasGraphicsQueue = limits.hasGraphicsQueue || (f.queueFlags & VK_QUEUE_GRAPHICS_BIT);
    return limits;
}

}  // namespace

DeviceInfo describe(VkPhysicalDevice physical, uint32_t index) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    DeviceInfo info;
    info.index = index;
    info.name = properties.deviceName;
    switch (properties.deviceType) {
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            info.type = "cpu";
            break;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            info.type = "integrated";
            break;
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            info.type = "discrete";
            break;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            info.type = "virtual";
            break;
        default:
            info.type = "other";
            break;
    }
    info.apiVersion = fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(properties.apiVersion), VK_API_VERSION_MINOR(properties.apiVersion),
                                  VK_API_VERSION_PATCH(properties.apiVersion));
    if (properties.apiVersion < VK_API_VERSION_1_2) {
        info.unusableBecause = fmt::format("has Vulkan {}, 1.2 is needed", info.apiVersion);
        return info;
    }
    const Queried q(physical);
    info.driver = q.driver.driverName;
    info.driverInfo = q.driver.driverInfo;
    info.lavapipe = q.driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
    for (const uint8_t byte : q.ids.deviceUUID) info.uuid += fmt::format("{:02x}", byte);
    if (!q.scalar.scalarBlockLayout)
        info.unusableBecause = "lacks scalarBlockLayout";
    else if (computeFamily(queueFamilies(physical)) == kNoFamily)
        info.unusableBecause = "has no compute queue";
    return info;
}

std::vector<DeviceInfo> Device::list(std::string* why) {
    std::string reason;
    std::vector<DeviceInfo> devices;
    if (const auto instance = Instance::acquire(false, reason))
        for (const VkPhysicalDevice physical : instance->physicalDevices()) devices.push_back(describe(physical, uint32_t(devices.size())));
    if (why) *why = devices.empty() ? reason : "";
    return devices;
}

// ---- limits for tests ----

ShrunkNative shrinkLimits(const char* text, DeviceLimits& limits, uint64_t& memoryBudgetBytes) {
    ShrunkNative native;
    std::string_view rest = text;
    while (!rest.empty()) {
        const size_t comma = std::min(rest.find(','), rest.size());
        const std::string_view item = rest.substr(0, comma);
        rest.remove_prefix(std::min(comma + 1, rest.size()));
        const size_t equals = item.find('=');
        uint64_t value = 0;
        const char* const end = item.data() + item.size();
        if (equals == std::string_view::npos || std::from_chars(item.data() + equals + 1, end, value).ptr != end)
            throw deviceError(fmt::format("PLUMB_LIMITS: '{}' is not NAME=NUMBER", item));
        const std::string_view name = item.substr(0, equals);
        const auto lower = [&](auto& limit) {
            if (value > uint64_t(limit)) throw deviceError(fmt::format("PLUMB_LIMITS: {}={} is above the device's {}", name, value, limit));
            limit = std::remove_reference_t<decltype(limit)>(value);
        };
        if (name == "storageRange")
            lower(limits.storageRangeBytes);
        else if (name == "texelElements")
            lower(limits.texelElements);
        else if (name == "groupCount")
            for (uint64_t& count : limits.groupCount) lower(count);
        else if (name == "groupCountX")
            lower(limits.groupCount[0]);
        else if (name == "groupCountY")
            lower(limits.groupCount[1]);
        else if (name == "allocation")
            lower(limits.allocationBytes);
        else if (name == "groupInvocations")
            lower(limits.groupInvocations);
        else if (name == "pushConstants")
            lower(limits.pushConstantBytes);
        else if (name == "subgroup")
            lower(limits.subgroupShuffle);
        else if (name == "int64")
            lower(limits.int64);
        else if (name == "float64")
            lower(limits.float64);
        else if (name == "graphicsQueue")
            lower(limits.hasGraphicsQueue);
        else if (name == "memory")
            lower(memoryBudgetBytes);
        else if (name == "nativeDivide")
            lower(native.divide);
        else if (name == "nativeRoot")
            lower(native.root);
        else if (name == "timestamps" && value == 0)
            limits.timestampPeriodNs = 0;
        else
            throw deviceError(fmt::format("PLUMB_LIMITS: '{}' is not a limit that can be shrunk", item));
    }
    return native;
}

// ---- the open device ----

DeviceImpl::~DeviceImpl() {
    if (!handle) return;
    {
        const std::lock_guard lock(instance->log.mutex);
        instance->log.toStderr = true;
    }
    for (auto& [key, begun] : making) {
        try {
            destroy(begun.get());
        } catch (const Error&) {  // result of a pipeline that nobody used
        }
    }
    // Work that does not end cannot be cancelled, and its memory cannot be freed under it: both are left behind.
    if (memory) memory->close(hung);
    if (hung) {
        new std::shared_ptr<Instance>(instance);  // leaked on purpose
        return;
    }
    for (const auto& [key, program] : programs) destroy(program);
    if (pipelineCache) vk.vkDestroyPipelineCache(handle, pipelineCache, nullptr);
    vk.vkDestroyDevice(handle, nullptr);
    const std::lock_guard lock(instance->log.mutex);
    instance->log.toStderr = false;
}

namespace {

std::unique_ptr<DeviceImpl> openImpl(const DeviceChoice& choice, const DeviceRequest& request) {
    PLUMB_ASSERT(!choice.twin);
    auto impl = std::make_unique<DeviceImpl>();
    std::string why;
    impl->instance = Instance::acquire(validationWanted(request), why);
    if (!impl->instance) throw deviceError(fmt::format("device '{}' cannot be opened: {}", choice.info.name, why));
    {
        const std::lock_guard lock(impl->instance->log.mutex);
        impl->instance->log.lines.clear();
    }
    const std::vector<VkPhysicalDevice> devices = impl->instance->physicalDevices();
    for (uint32_t i = 0; i < devices.size(); ++i) {
        const DeviceInfo info = describe(devices[i], i);
        // The order of devices may have changed since the choice. Identity decides; the index decides only between equals.
        if (info.uuid == choice.info.uuid && info.name == choice.info.name && (!impl->physical || i == choice.info.index)) {
            impl->physical = devices[i];
            impl->info = info;
        }
    }
    if (!impl->physical) throw deviceError(fmt::format("device '{}' is gone", choice.info.name));
    if (!impl->info.unusableBecause.empty()) throw deviceError(fmt::format("device '{}' {}", impl->info.name, impl->info.unusableBecause));

    const Queried q(impl->physical);
    const auto families = queueFamilies(impl->physical);
    impl->queueFamily = computeFamily(families);
    impl->queueDraws = (families[impl->queueFamily].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
    impl->timestampBits = families[impl->queueFamily].timestampValidBits;
    impl->driverVersion = q.properties.properties.driverVersion;
    const VkPhysicalDeviceLimits& l = q.properties.properties.limits;
    impl->stageBindings[0] = std::min(l.maxPerStageDescriptorStorageBuffers, l.maxDescriptorSetStorageBuffers);
    impl->stageBindings[1] = std::min(l.maxPerStageDescriptorSampledImages, l.maxDescriptorSetSampledImages);
    impl->stageBindings[2] = l.maxPerStageResources;
    impl->limits = limitsOf(q, families, impl->queueFamily);

    const float priority = 1;
    const VkDeviceQueueCreateInfo queueInfo{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, impl->queueFamily, 1, &priority};
    VkPhysicalDeviceScalarBlockLayoutFeatures scalar{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES, nullptr, VK_TRUE};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &scalar};
    features.features.shaderInt64 = impl->limits.int64;
    features.features.shaderFloat64 = impl->limits.float64;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queueInfo;
    VK_CHECK_START(vkCreateDevice(impl->physical, &info, nullptr, &impl->handle));
    volkLoadDeviceTable(&impl->vk, impl->handle);
    impl->vk.vkGetDeviceQueue(impl->handle, impl->queueFamily, 0, &impl->queue);
    const VkPipelineCacheCreateInfo cacheInfo{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    VK_CHECK_START(impl->vk.vkCreatePipelineCache(impl->handle, &cacheInfo, nullptr, &impl->pipelineCache));

    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(impl->physical, &types);
    uint64_t heapBytes = 0;
    for (uint32_t i = 0; i < types.memoryTypeCount; ++i)
        if (types.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)
            heapBytes = std::max(heapBytes, uint64_t(types.memoryHeaps[types.memoryTypes[i].heapIndex].size));
    uint64_t budget = memoryBudget(heapBytes, request.memoryBudgetBytes);
    if (const char* text = std::getenv("PLUMB_LIMITS")) impl->native = shrinkLimits(text, impl->limits, budget);
    impl->queueDraws = impl->queueDraws && impl->limits.hasGraphicsQueue;
    impl->memory = std::make_shared<MemoryPool>(impl->handle, impl->vk, types, impl->limits.allocationBytes, budget);
    return impl;
}

}  // namespace

Device::Device(std::unique_ptr<DeviceImpl> impl) : impl_(std::move(impl)) {}
Device::Device(Device&&) noexcept = default;
Device& Device::operator=(Device&&) noexcept = default;
Device::~Device() = default;

Device Device::open(const DeviceChoice& choice, const DeviceRequest& request) {
    Device device(openImpl(choice, request));
    try {
        SelfTest verdict = runSelfTest(device);
        verdict.nativeDivideIsExact = verdict.nativeDivideIsExact && device.impl_->native.divide;
        verdict.nativeRootIsExact = verdict.nativeRootIsExact && device.impl_->native.root;
        device.impl_->selfTest = verdict;
    } catch (const Error& error) {
        throw deviceError(fmt::format("device '{}' failed its self-test: {}", device.info().name, error.what()));
    }
    return device;
}

void shrink(Device& device, const char* limits) {
    DeviceImpl& impl = device.impl();
    uint64_t unusedBudget = impl.memory->budgetBytes();
    const ShrunkNative native = shrinkLimits(limits, impl.limits, unusedBudget);
    impl.selfTest.nativeDivideIsExact = impl.selfTest.nativeDivideIsExact && native.divide;
    impl.selfTest.nativeRootIsExact = impl.selfTest.nativeRootIsExact && native.root;
}

const DeviceInfo& Device::info() const { return impl_->info; }
const DeviceLimits& Device::limits() const { return impl_->limits; }
const SelfTest& Device::selfTest() const { return impl_->selfTest; }
uint64_t Device::memoryBudgetBytes() const { return impl_->memory->budgetBytes(); }
uint64_t Device::memoryUsedBytes() const { return impl_->memory->usedBytes(); }
uint64_t Device::memoryPeakBytes() const { return impl_->memory->peakBytes(); }
bool Device::validationActive() const { return impl_->instance->validation; }
std::vector<std::string> Device::validationMessages() const {
    const std::lock_guard lock(impl_->instance->log.mutex);
    return impl_->instance->log.lines;
}

}  // namespace plumb
