// SPDX-License-Identifier: MIT
// A machine without Vulkan loader: ctest runs this with a libvulkan.so.1 that is no library (LD_LIBRARY_PATH).
#include "host/device.h"
#include "host/error.h"

#include <gtest/gtest.h>
#include <string>

namespace plumb {
namespace {

TEST(WithoutLoader, TheListIsEmptyAndSaysWhy) {
    std::string why;
    EXPECT_TRUE(Device::list(&why).empty());
    EXPECT_EQ(why, "there is no Vulkan loader (libvulkan.so.1)");
}

TEST(WithoutLoader, AutoDrawsOnTheTwin) {
    const DeviceChoice choice = Device::choose({});
    EXPECT_TRUE(choice.twin);
    EXPECT_EQ(choice.reason, "the CPU twin draws: there is no Vulkan loader (libvulkan.so.1)");
    EXPECT_NE(choice.advice.find("libvulkan1"), std::string::npos);
}

TEST(WithoutLoader, ValidationCannotBeHad) {
    DeviceRequest request;
    request.validation = true;
    EXPECT_THROW(Device::choose(request), Error);
}

TEST(WithoutLoader, ARequiredDeviceIsRefused) {
    DeviceRequest request;
    request.require = "lavapipe";
    EXPECT_THROW(Device::choose(request), Error);
}

}  // namespace
}  // namespace plumb
