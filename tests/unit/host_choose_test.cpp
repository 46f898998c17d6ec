// SPDX-License-Identifier: MIT
// The words of --device and --require-device, over lists that no machine needs to have; and machines without Vulkan.
#include "host/device.h"
#include "host/error.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>
#include <cstdint>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace plumb {
namespace {

using test::TemporaryFolder;

DeviceInfo device(uint32_t index, const std::string& name, const std::string& type, bool lavapipe = false) {
    DeviceInfo info;
    info.index = index;
    info.name = name;
    info.type = type;
    info.lavapipe = lavapipe;
    info.uuid = std::string(31, '0') + char('a' + index);
    return info;
}

std::vector<DeviceInfo> mixedMachine() {
    std::vector<DeviceInfo> devices = {device(0, "llvmpipe (LLVM 15.0.6, 256 bits)", "cpu", true), device(1, "Intel UHD 630", "integrated"),
                                       device(2, "NVIDIA RTX 4090", "discrete"), device(3, "SwiftShader Device", "cpu")};
    devices[2].unusableBecause = "has Vulkan 1.1, 1.2 is needed";
    return devices;
}

DeviceChoice choose(const std::string& prefer, const std::string& require = "", const std::vector<DeviceInfo>& devices = mixedMachine()) {
    DeviceRequest request;
    request.prefer = prefer;
    request.require = require;
    return chooseDevice(devices, "there is no Vulkan loader (libvulkan.so.1)", request);
}

std::string refusal(const std::string& prefer, const std::string& require = "", const std::vector<DeviceInfo>& devices = mixedMachine()) {
    try {
        const DeviceChoice choice = choose(prefer, require, devices);
        ADD_FAILURE() << "--device " << prefer << " --require-device " << require << " chose " << choice.info.name;
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::device);
        return error.what();
    }
    return "";
}

TEST(DeviceChoice, AutoTakesTheFirstUsableGpuAndSaysWhyNotTheOthers) {
    const DeviceChoice choice = choose("auto");
    EXPECT_FALSE(choice.twin);
    EXPECT_EQ(choice.info.name, "Intel UHD 630");
    EXPECT_EQ(choice.reason, "device 1 'Intel UHD 630': the first usable integrated GPU");
    ASSERT_EQ(choice.notChosen.size(), 3u);
    EXPECT_EQ(choice.notChosen[0], "NVIDIA RTX 4090: has Vulkan 1.1, 1.2 is needed");
    EXPECT_EQ(choice.notChosen[1], "llvmpipe (LLVM 15.0.6, 256 bits): 'Intel UHD 630' comes before it");
}

TEST(DeviceChoice, AutoPrefersLavapipeToOtherCpuDevices) {
    const DeviceChoice choice = choose("auto", "", {device(0, "SwiftShader Device", "cpu"), device(1, "llvmpipe", "cpu", true)});
    EXPECT_EQ(choice.info.name, "llvmpipe");
    EXPECT_EQ(choice.reason, "device 1 'llvmpipe': the first usable lavapipe; no usable GPU was found");
}

TEST(DeviceChoice, AutoDrawsOnTheTwinWithReasonAndAdviceWhenNothingIsThere) {
    const DeviceChoice choice = choose("auto", "", {});
    EXPECT_TRUE(choice.twin);
    EXPECT_EQ(choice.reason, "the CPU twin draws: there is no Vulkan loader (libvulkan.so.1)");
    EXPECT_NE(choice.advice.find("apt install mesa-vulkan-drivers"), std::string::npos);
}

TEST(DeviceChoice, EveryWordNamesADevice) {
    EXPECT_TRUE(choose("twin").twin);
    EXPECT_EQ(choose("lavapipe").info.index, 0u);
    EXPECT_EQ(choose("gpu").info.index, 1u);
    EXPECT_EQ(choose("software").info.index, 0u);
    EXPECT_EQ(choose("3").info.index, 3u);
    EXPECT_EQ(choose("swiftSHADER").info.index, 3u);
    EXPECT_EQ(choose(mixedMachine()[3].uuid).info.index, 3u);
    EXPECT_EQ(choose("00000000-0000-0000-0000-00000000000d").info.index, 3u);
}

TEST(DeviceChoice, AWordThatNamesNothingIsRefusedNotReplaced) {
    const std::string message = refusal("voodoo");
    EXPECT_NE(message.find("--device voodoo: no such device; found 0 'llvmpipe"), std::string::npos) << message;
    refusal("gpu", "", {device(0, "llvmpipe", "cpu", true)});
    refusal("lavapipe", "", {device(0, "Intel", "integrated")});
    refusal("17");
    EXPECT_NE(refusal("4090").find("unusable: has Vulkan 1.1"), std::string::npos);
    EXPECT_NE(refusal("lavapipe", "", {}).find("apt install mesa-vulkan-drivers"), std::string::npos);
}

TEST(DeviceChoice, RequireExcludesEverythingElse) {
    EXPECT_EQ(choose("auto", "lavapipe").info.index, 0u);
    EXPECT_EQ(choose("auto", "auto").info.index, 1u);
    EXPECT_EQ(choose("software", "swiftshader").info.index, 3u);
    EXPECT_TRUE(choose("auto", "twin").twin);
    EXPECT_TRUE(choose("twin", "twin").twin);
    refusal("auto", "gpu", {device(0, "llvmpipe", "cpu", true)});
    refusal("auto", "gpu", {});
    refusal("lavapipe", "gpu");
    refusal("twin", "lavapipe");
    refusal("lavapipe", "twin");
}

class Environment {
public:
    Environment(const char* name, const char* value) : name_(name) {
        if (const char* old = std::getenv(name)) old_ = old, had_ = true;
        setenv(name, value, 1);
    }
    ~Environment() { had_ ? setenv(name_, old_.c_str(), 1) : unsetenv(name_); }

private:
    const char* name_;
    std::string old_;
    bool had_ = false;
};

TEST(DeviceList, IsEmptyWithAReasonWhenThereIsNoDriver) {
    for (const char* files : {"", "/nonexistent/icd.json"}) {
        const Environment none("VK_ICD_FILENAMES", files);
        std::string why;
        EXPECT_TRUE(Device::list(&why).empty());
        EXPECT_EQ(why, "the Vulkan loader found no working driver (ICD) (VK_ICD_FILENAMES='" + std::string(files) + "')");
        const DeviceChoice choice = Device::choose({});
        EXPECT_TRUE(choice.twin);
        EXPECT_FALSE(choice.advice.empty());
    }
}

// JSON whose root is an array is left out: loader 1.3.239 itself crashes on it in vkCreateInstance.
TEST(DeviceList, SurvivesABrokenIcdFile) {
    const TemporaryFolder folder;
    for (const char* text : {"", "{", "{}", "{\"ICD\":{}}", "{\"ICD\":{\"library_path\":\"/nonexistent.so\",\"api_version\":\"1.2.0\"}}"}) {
        const std::string file = folder.path() / "icd.json";
        std::ofstream(file) << text;
        const Environment broken("VK_ICD_FILENAMES", file.c_str());
        std::string why;
        EXPECT_TRUE(Device::list(&why).empty());
        EXPECT_FALSE(why.empty());
    }
}

TEST(DeviceList, FindsThePinnedLavapipe) {
    const std::vector<DeviceInfo> devices = Device::list();
    ASSERT_EQ(devices.size(), 1u);
    EXPECT_TRUE(devices[0].lavapipe);
    EXPECT_EQ(devices[0].type, "cpu");
    EXPECT_EQ(devices[0].uuid.size(), 32u);
    EXPECT_TRUE(devices[0].unusableBecause.empty());
}

}  // namespace
}  // namespace plumb
