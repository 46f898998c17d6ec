// SPDX-License-Identifier: MIT
// Tests of `plumb verify --suite`: built-in scenes and checks that together run every embedded module at least once.
#pragma once

#include "host/device.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace plumb::suite {

// Limits (PLUMB_LIMITS) of further devices of the suite, so that it runs what other devices would: modules without shuffles of subgroups and
// without 64-bit integers, and the forms of division and root for devices whose own are inexact.
inline constexpr const char* kPlainLimits = "subgroup=0,int64=0";
inline constexpr const char* kEmulatedLimits = "nativeDivide=0,nativeRoot=0";

// A picture that both sides must draw alike.
struct PictureTest {
    const char* name;
    uint32_t width, height;
    Scene (*scene)(uint32_t width, uint32_t height);
    void (*choose)(RenderRequest&);  // sets what the default request does not have
    const char* limits = "";         // of the device
};
std::span<const PictureTest> pictureTests();
RenderRequest requestOf(const PictureTest& test, uint32_t threads);

// A check of modules that draw no picture. `run` returns what is wrong, one sentence, or nothing.
struct ModuleTest {
    const char* name;
    std::string (*run)(Device&);
    const char* limits = "";
};
std::span<const ModuleTest> moduleTests();

// Reason why the device cannot take a test, one sentence; empty when it can.
std::string lacks(Device& device, const PictureTest& test);

}  // namespace plumb::suite
