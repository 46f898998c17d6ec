// SPDX-License-Identifier: MIT
// One device for the whole program: lavapipe, pinned by the environment that CTest sets. A missing device fails every test, and so
// does any other device. After each test the validation messages must still be none.
#pragma once

#include "host/device.h"
#include "host/error.h"

#include <gtest/gtest.h>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace plumb::test {

class DeviceEnvironment : public ::testing::Environment {
public:
    static std::unique_ptr<Device>& device() {
        static std::unique_ptr<Device> one;
        return one;
    }
    static DeviceRequest request() {
        DeviceRequest r;
        r.prefer = r.require = "lavapipe";
        const char* validation = std::getenv("PLUMB_VALIDATION");
        r.validation = validation && *validation == '1';
        return r;
    }
    // Another device of the same kind, with limits as in PLUMB_LIMITS.
    static std::unique_ptr<Device> open(const char* limits) {
        if (limits) setenv("PLUMB_LIMITS", limits, 1);
        auto opened = std::make_unique<Device>(Device::open(Device::choose(request()), request()));
        if (limits) unsetenv("PLUMB_LIMITS");
        return opened;
    }
    void SetUp() override {
        try {
            device() = open(nullptr);
        } catch (const Error& e) {
            FAIL() << "no device: " << e.what();
        }
        std::printf("device: %s, validation %s\n", device()->info().name.c_str(), device()->validationActive() ? "on" : "off");
        ASSERT_TRUE(device()->info().lavapipe) << device()->info().name << " is not lavapipe";
        ASSERT_EQ(device()->validationActive(), request().validation);
        ASSERT_EQ(device()->selfTest().failure, "");
    }
    void TearDown() override { device().reset(); }  // before the loader's own destructors
};

inline ::testing::Environment* const kDeviceEnvironment = ::testing::AddGlobalTestEnvironment(new DeviceEnvironment);

inline void expectNoValidationMessages(Device& device) {
    for (const std::string& message : device.validationMessages()) ADD_FAILURE() << "validation: " << message;
}

template <class Base>
class OnDevice : public Base {
protected:
    void SetUp() override { ASSERT_TRUE(DeviceEnvironment::device()) << "no device"; }
    void TearDown() override {
        if (DeviceEnvironment::device()) expectNoValidationMessages(device());
    }
    static Device& device() { return *DeviceEnvironment::device(); }
};
using DeviceTest = OnDevice<::testing::Test>;

}  // namespace plumb::test
