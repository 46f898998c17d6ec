// SPDX-License-Identifier: MIT
// Devices: those found, the one picked and why, and its limits. No Vulkan type leaves host/: pipeline/ sees a device through this header
// only. Knows no triangle and no pixel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

// Entry of `plumb devices`. The twin (the CPU reference) is not a Vulkan device and is not listed here.
struct DeviceInfo {
    uint32_t index = 0;           // order in which the loader lists it
    std::string name;             // e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string type;             // "cpu", "integrated", "discrete", "virtual", "other"
    std::string driver;           // VkPhysicalDeviceDriverProperties::driverName
    std::string driverInfo;       // VkPhysicalDeviceDriverProperties::driverInfo
    std::string apiVersion;       // "1.3.230"
    std::string uuid;             // 32 hex digits
    bool lavapipe = false;        // driver id is MESA_LLVMPIPE
    std::string unusableBecause;  // empty when it can run every base module
};

// Limits read from the device, never constants. Tests shrink them through PLUMB_LIMITS (see Device::open).
struct DeviceLimits {
    uint64_t storageRangeBytes = 0;  // maxStorageBufferRange
    uint64_t texelElements = 0;      // maxTexelBufferElements
    uint64_t groupCount[3] = {};     // maxComputeWorkGroupCount
    uint64_t allocationBytes = 0;    // maxMemoryAllocationSize
    uint32_t groupInvocations = 0;   // maxComputeWorkGroupInvocations
    uint32_t pushConstantBytes = 0;
    uint32_t subgroupSize = 0;
    uint32_t texelOffsetAlignment = 0;  // minTexelBufferOffsetAlignment
    uint32_t storageOffsetAlignment = 0;
    double timestampPeriodNs = 0;  // 0: no timestamps on the compute queue
    bool subgroupShuffle = false;  // ballot, vote and shuffle usable in compute, subgroup size a power of two >= 8
    bool int64 = false;
    bool float64 = false;
    bool hasGraphicsQueue = false;
    uint32_t subPixelBits = 0;  // VkPhysicalDeviceLimits::subPixelPrecisionBits, of the device's own rasteriser (host/graphics.h)
};

// Findings of the start-up self-test and of the canaries (docs/accuracy.md, Start-up self-test).
struct SelfTest {
    bool exactAddMul = false;          // + - * correctly rounded; otherwise the twin draws, and says so
    bool exactConversions = false;     // int <-> float, imulExtended
    bool nativeDivideIsExact = false;  // x/y is IEEE here: the shaders may use it
    bool nativeRootIsExact = false;
    bool emulatedDivideIsExact = false;  // emulatedDivide() of shaders/shared/exact.h, the fallback
    bool emulatedRootIsExact = false;
    uint32_t loopLimit = 0;  // iterations after which a loop silently stops; 0 = none seen up to 80,000
    bool fromCache = false;
    double timeMs = 0;
    std::string failure;  // empty: the device may draw; otherwise one sentence
};

// Words of --device and --require-device: auto, twin, lavapipe, gpu, software, INDEX, UUID, SUBSTRING.
struct DeviceRequest {
    std::string prefer = "auto";
    std::string require;             // empty: any device; otherwise exit 4 rather than use another
    bool validation = false;         // core + synchronization validation; messages are collected
    uint64_t memoryBudgetBytes = 0;  // 0: min(heap, half of MemAvailable, cgroup limit)
};

// Answer of chooseDevice(). `twin` true: no device is used, the CPU twin draws.
struct DeviceChoice {
    bool twin = false;
    DeviceInfo info;                     // valid when !twin
    std::string reason;                  // one sentence, printed with -v and in JSON
    std::string advice;                  // when nothing was found: what to install, in one or two lines; for stderr
    std::vector<std::string> notChosen;  // "name: why", one each
    std::shared_ptr<void> keepAlive;     // instance that the choice has already loaded, for open(); opaque
};

// Rule of Device::choose(), over any list. `whyNone` explains an empty list.
DeviceChoice chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& whyNone, const DeviceRequest& request);

struct DeviceImpl;

// Open device with one compute queue. Move-only; ready after construction; frees everything it owns.
class Device {
public:
    // Lists what the loader finds; empty without loader or ICD. Never throws for "nothing there".
    // Sets `why` (when given) to the reason of an empty list: no loader, no ICD, broken ICD.
    static std::vector<DeviceInfo> list(std::string* why = nullptr);
    // Applies the words of DeviceRequest. Throws Error(device) when `require` cannot be met
    // or `prefer` names a device that does not exist.
    static DeviceChoice choose(const DeviceRequest& request);
    // Opens a chosen device and runs the self-test (cached per device, driver and module hash under
    // $XDG_CACHE_HOME/plumbline; canaries run at every start). Throws Error(device).
    // The environment variable PLUMB_LIMITS="storageRange=1048576,groupCount=64,subgroup=0,..." shrinks
    // limits for tests; a value above the device's own is refused.
    static Device open(const DeviceChoice& choice, const DeviceRequest& request);

    Device(Device&&) noexcept;
    Device& operator=(Device&&) noexcept;
    ~Device();

    const DeviceInfo& info() const;
    const DeviceLimits& limits() const;
    const SelfTest& selfTest() const;
    uint64_t memoryBudgetBytes() const;
    uint64_t memoryUsedBytes() const;
    uint64_t memoryPeakBytes() const;
    // Validation messages (warnings and errors) so far, each one line. Empty unless DeviceRequest::validation.
    std::vector<std::string> validationMessages() const;
    bool validationActive() const;

    DeviceImpl& impl() const { return *impl_; }

private:
    explicit Device(std::unique_ptr<DeviceImpl> impl);
    std::unique_ptr<DeviceImpl> impl_;
};

}  // namespace plumb
