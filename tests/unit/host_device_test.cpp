// SPDX-License-Identifier: MIT
// The device side of host/ on the pinned lavapipe, with core and synchronization validation and no message.
#include "host/binary64.h"
#include "host/buffer.h"
#include "host/device.h"
#include "host/recorder.h"
#include "host/selftest.h"
#include "shared/exact.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <spirv/canary.h>
#include <spirv/host_add.h>
#include <spirv/host_exact.h>
#include <spirv/host_loop.h>
#include <spirv/host_reflect.h>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <ios>
#include <memory>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace plumb {
namespace {

struct AddPush {
    uint32_t statusSlot, count, factor, skippedGroups;
};
struct LoopPush {
    uint32_t statusSlot, iterations, items, wanted;
};
constexpr uint32_t kLongestLoop = 60000;  // what the shaders' loops stay below (CONTRIBUTING.md)
struct ExactPush {
    uint32_t statusSlot, count;
    int32_t seedErrorUlp;
};
struct ExactAnswer {
    float quotient, root, emulatedQuotient, emulatedRoot, snapped;
};

Device openDevice(const char* limits = nullptr, const DeviceRequest& request = {}) {
    if (limits) setenv("PLUMB_LIMITS", limits, 1);
    struct Unset {
        ~Unset() { unsetenv("PLUMB_LIMITS"); }
    } unset;
    const DeviceChoice choice = Device::choose(request);
    if (choice.twin) throw deviceError("these tests need lavapipe: " + choice.reason);
    return Device::open(choice, request);
}

std::string messageOf(const std::function<void()>& action, Exit exit = Exit::failed) {
    try {
        action();
    } catch (const Error& error) {
        EXPECT_EQ(int(error.exit()), int(exit)) << error.what();
        return error.what();
    }
    return "nothing was thrown";
}

const Specialization kAddsNothing = {{"kAddend", 0}};

class HostDevice : public testing::Test {
protected:
    static void SetUpTestSuite() { shared() = std::make_unique<Device>(openDevice()); }
    static void TearDownTestSuite() { shared().reset(); }
    static std::unique_ptr<Device>& shared() {
        static std::unique_ptr<Device> device;
        return device;
    }
    static Device& device() { return *shared(); }
    void TearDown() override { expectSilence(device()); }

public:
    static void expectSilence(const Device& d) {
        EXPECT_TRUE(d.validationActive());
        for (const std::string& line : d.validationMessages()) ADD_FAILURE() << line;
    }
};

struct Addition {
    Buffer<glm::uvec2> pairs;
    Buffer<uint32_t> texel, sums;
    uint32_t count;

    Addition(Device& device, uint32_t items)
        : pairs(device, items, "pairs"), texel(device, items, "texel"), sums(device, items, "sums"), count(items) {
        for (uint32_t i = 0; i < items; ++i) pairs.span()[i] = {i, 2 * i + 1}, texel.span()[i] = i * i;
        sums.fill(0xdeadbeefu);
    }
    void record(Recorder& recorder, const Specialization& constants = kAddsNothing, const char* label = "add", uint32_t skippedGroups = 0) {
        recorder.dispatch(label, spirv::host_add, count, AddPush{77, count, 3, skippedGroups},
                          {storage("Pairs", pairs), texels("texel", texel, View::texelU32), storage("Sums", sums)}, constants);
    }
    void expectSums(uint32_t addend = 0) const {
        for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(sums.span()[i], i + (2 * i + 1) * 3 + i * i + addend) << i;
    }
};

TEST_F(HostDevice, IsThePinnedLavapipeAndPassedItsSelfTest) {
    EXPECT_TRUE(device().info().lavapipe);
    const SelfTest& test = device().selfTest();
    EXPECT_EQ(test.failure, "");
    EXPECT_TRUE(test.exactAddMul && test.exactConversions && test.emulatedDivideIsExact && test.emulatedRootIsExact);
    // Mesa 22.3.6 ends a loop after 65,535 steps, 25.0.7 ends none of 80,000 (0).
    EXPECT_TRUE(test.loopLimit == 0 || test.loopLimit > kLongestLoop) << test.loopLimit << " steps are news for every loop budget";
    EXPECT_GE(device().limits().subgroupSize, 4u);
    EXPECT_GT(device().limits().timestampPeriodNs, 0);
}

TEST_F(HostDevice, RunsADispatchThatFits) {
    Addition work(device(), 1000);
    Recorder recorder(device());
    work.record(recorder);
    recorder.run();
    work.expectSums();
    const std::vector<PassTime> times = recorder.takeTimes();
    ASSERT_EQ(times.size(), 1u);
    EXPECT_EQ(times[0].pass, "add");
    EXPECT_EQ(times[0].dispatches, 1u);
    EXPECT_GT(times[0].ms, 0);
    EXPECT_LT(times[0].ms, 10000);
    EXPECT_TRUE(recorder.takeTimes().empty());
}

TEST_F(HostDevice, RunsAgainAfterARunAndWithOtherConstants) {
    Addition work(device(), 65);
    Recorder recorder(device());
    for (const uint32_t addend : {0u, 5u, 0xfffffff0u, 5u}) {
        work.record(recorder, {{"kAddend", addend}});
        recorder.run();
        work.expectSums(addend);
    }
    recorder.run();  // nothing recorded: nothing to do
    EXPECT_EQ(recorder.takeTimes()[0].dispatches, 4u);
}

TEST_F(HostDevice, MakesPipelinesAheadOfTheirDispatch) {
    Addition work(device(), 65);
    Recorder recorder(device());
    for (const uint32_t addend : {21u, 22u, 23u}) recorder.prepare(spirv::host_add, {{"kAddend", addend}});
    recorder.prepare(spirv::host_add, {{"kAddend", 21}});
    for (const uint32_t addend : {22u, 21u, 21u}) {
        work.record(recorder, {{"kAddend", addend}});
        recorder.run();
        work.expectSums(addend);
    }
    // What cannot be made is refused by the dispatch that needs it, and again by the next; nobody else hears of it.
    const Specialization unknown = {{"kMissing", 1}};
    recorder.prepare(spirv::host_add, unknown);
    for (int i = 0; i < 2; ++i) EXPECT_THROW(work.record(recorder, unknown), Error);
    recorder.prepare(spirv::host_add, {{"kMissing", 2}});  // 23 and this one are never asked for: the device frees what there is
}

TEST_F(HostDevice, OrdersDependentDispatchesAndFills) {
    Buffer<glm::uvec2> pairs(device(), 512, "pairs");
    Buffer<uint32_t> a(device(), 512, "a"), b(device(), 512, "b");
    for (glm::uvec2& pair : pairs.span()) pair = {1, 0};
    Recorder recorder(device());
    recorder.fill("clear", a, 40);
    for (int round = 0; round < 700; ++round) {  // more than one buffer of status slots and pool of queries
        const bool even = round % 2 == 0;
        recorder.dispatch("step", spirv::host_add, 512, AddPush{0, 512, 0, 0},
                          {storage("Pairs", pairs), texels("texel", even ? a : b, View::texelU32), storage("Sums", even ? b : a)},
                          kAddsNothing);
    }
    recorder.fill("mark", b, 7, 4, 8);
    recorder.run();
    for (const uint32_t value : a.span()) ASSERT_EQ(value, 740u);
    EXPECT_EQ(b.span()[0], 739u);
    EXPECT_EQ(b.span()[1], 7u);
    EXPECT_EQ(b.span()[2], 7u);
    EXPECT_EQ(b.span()[3], 739u);
    const std::vector<PassTime> times = recorder.takeTimes();
    ASSERT_EQ(times.size(), 3u);
    EXPECT_EQ(times[1].pass, "step");
    EXPECT_EQ(times[1].dispatches, 700u);
}

TEST_F(HostDevice, RecordsMoreDispatchesThanOneBufferOfSlots) {
    Addition work(device(), 64);
    Recorder recorder(device());
    for (int i = 0; i < 2100; ++i) work.record(recorder);
    recorder.run();
    work.expectSums();
}

TEST_F(HostDevice, BindsPartsOfBuffers) {
    Addition work(device(), 256);
    Recorder recorder(device());
    recorder.dispatch("add", spirv::host_add, 64, AddPush{0, 64, 3, 0},
                      {storage("Pairs", work.pairs, 128, 64), texels("texel", work.texel, View::texelU32, 128 * 4, 64 * 4),
                       storage("Sums", work.sums, 64, 64)},
                      kAddsNothing);
    recorder.run();
    EXPECT_EQ(work.sums.span()[64], 128u + 257u * 3u + 128u * 128u);
    EXPECT_EQ(work.sums.span()[63], 0xdeadbeefu);
    EXPECT_EQ(work.sums.span()[128], 0xdeadbeefu);
}

TEST_F(HostDevice, DoesNothingForNoItems) {
    Addition work(device(), 64);
    Recorder recorder(device());
    recorder.dispatch("add", spirv::host_add, 0, AddPush{0, 64, 3, 0},
                      {storage("Pairs", work.pairs), texels("texel", work.texel, View::texelU32), storage("Sums", work.sums)},
                      kAddsNothing);
    recorder.run();
    EXPECT_EQ(work.sums.span()[0], 0xdeadbeefu);
}

// ---- refusals: each names the module and what does not fit ----

class Refusal : public HostDevice {
protected:
    template <class Push>
    std::string refusal(const Module& module, Push push, const std::vector<Binding>& bindings,
                        const Specialization& constants = kAddsNothing, uint64_t items = 64) {
        return messageOf([&] {
            Recorder recorder(device());
            recorder.dispatch("label", module, items, push, bindings, constants);
        });
    }
    Addition work_{device(), 64};
    const AddPush push_{0, 64, 1, 0};
};

TEST_F(Refusal, OfAnotherStride) {
    const Buffer<glm::uvec3> triples(device(), 64, "triples");
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {storage("Pairs", triples), texels("texel", work_.texel, View::texelU32), storage("Sums", work_.sums)}),
              "host_add: binding Pairs has elements of 8 bytes in GLSL and 12 in C++");
}

TEST_F(Refusal, OfAnotherKind) {
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {texels("Pairs", work_.pairs, View::texelU32x2), texels("texel", work_.texel, View::texelU32),
                       storage("Sums", work_.sums)}),
              "host_add: binding Pairs is a storage buffer in GLSL and a texel buffer in C++");
    EXPECT_EQ(refusal(spirv::host_add, push_, {storage("Pairs", work_.pairs), storage("texel", work_.texel), storage("Sums", work_.sums)}),
              "host_add: binding texel is a texel buffer in GLSL and a storage buffer in C++");
}

TEST_F(Refusal, OfAnotherTexelType) {
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {storage("Pairs", work_.pairs), texels("texel", work_.texel, View::texelF32), storage("Sums", work_.sums)}),
              "host_add: binding texel reads unsigned integers in GLSL and floats in C++");
}

TEST_F(Refusal, OfBindingsThatAreMissingDoubledOrUnknown) {
    const Binding pairs = storage("Pairs", work_.pairs), texel = texels("texel", work_.texel, View::texelU32),
                  sums = storage("Sums", work_.sums);
    EXPECT_EQ(refusal(spirv::host_add, push_, {pairs, sums}), "host_add: binding texel is not given");
    EXPECT_EQ(refusal(spirv::host_add, push_, {pairs, texel, sums, sums}), "host_add: binding Sums is given twice");
    EXPECT_EQ(refusal(spirv::host_add, push_, {pairs, texel, sums, storage("Total", work_.sums)}), "host_add: no binding is called Total");
    EXPECT_EQ(refusal(spirv::host_add, push_, {sums, texel, pairs}), "nothing was thrown") << "their order is free";
}

TEST_F(Refusal, OfAnotherPushBlock) {
    EXPECT_EQ(refusal(spirv::host_add, ExactPush{},
                      {storage("Pairs", work_.pairs), texels("texel", work_.texel, View::texelU32), storage("Sums", work_.sums)}),
              "host_add: the push block has 16 bytes in GLSL and 12 in C++");
}

TEST_F(Refusal, OfAnUnknownConstant) {
    const std::vector<Binding> bindings = {storage("Pairs", work_.pairs), texels("texel", work_.texel, View::texelU32),
                                           storage("Sums", work_.sums)};
    EXPECT_EQ(refusal(spirv::host_add, push_, bindings, {{"kAddend", 1}, {"kMissing", 1}}),
              "host_add: no constant is called kMissing (the module has kAddend)");
}

TEST_F(Refusal, OfAForgottenConstant) {
    const std::vector<Binding> bindings = {storage("Pairs", work_.pairs), texels("texel", work_.texel, View::texelU32),
                                           storage("Sums", work_.sums)};
    EXPECT_EQ(refusal(spirv::host_add, push_, bindings, {}), "host_add: the constant kAddend is not given");
}

TEST_F(Refusal, OfNoBuffer) {
    const Buffer<uint32_t> none;
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {storage("Pairs", work_.pairs), texels("texel", work_.texel, View::texelU32), storage("Sums", none)}),
              "host_add: binding Sums is given no buffer");
}

TEST_F(Refusal, OfARangeOutsideTheBuffer) {
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {storage("Pairs", work_.pairs, 32, 64), texels("texel", work_.texel, View::texelU32), storage("Sums", work_.sums)}),
              "host_add: binding Pairs takes 512 bytes from byte 256 of buffer 'pairs', which has 512");
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {storage("Pairs", work_.pairs, 64), texels("texel", work_.texel, View::texelU32), storage("Sums", work_.sums)}),
              "host_add: binding Pairs takes 0 bytes from byte 512 of buffer 'pairs', which has 512");
}

TEST_F(Refusal, OfAnUnalignedBeginning) {
    EXPECT_EQ(refusal(spirv::host_add, push_,
                      {storage("Pairs", work_.pairs, 1), texels("texel", work_.texel, View::texelU32), storage("Sums", work_.sums)}),
              fmt::format("host_add: binding Pairs begins at byte 8 of buffer 'pairs'; the device wants a multiple of {}",
                          device().limits().storageOffsetAlignment));
}

TEST_F(Refusal, OfAUniformBlock) {
    struct {
        uint32_t words[24];
    } push96{};
    EXPECT_EQ(refusal(spirv::host_reflect, push96, {storage("Pairs", work_.pairs)}, {{"kLocalSizeX", 8}, {"kScale", 1}}),
              "host_reflect: binding 6 is a uniform buffer; the recorder binds storage and texel buffers");
}

TEST_F(Refusal, OfTooLargeAWorkgroup) {
    struct {
        uint32_t words[24];
    } push96{};
    EXPECT_EQ(refusal(spirv::host_reflect, push96, {storage("Pairs", work_.pairs)}, {{"kLocalSizeX", 1u << 20}, {"kScale", 1}}),
              fmt::format("host_reflect: 2097152 invocations a workgroup, the device allows 1 to {}", device().limits().groupInvocations));
}

TEST_F(Refusal, LeavesTheRecorderAsItWas) {
    Recorder recorder(device());
    work_.record(recorder);
    EXPECT_THROW(recorder.dispatch("label", spirv::host_add, 64, push_, {storage("Pairs", work_.pairs)}), Error);
    EXPECT_THROW(recorder.fill("label", work_.sums, 0, 2), Error);
    recorder.run();
    work_.expectSums();
}

TEST_F(Refusal, OfAFillThatIsNotWordsOfTheBuffer) {
    Recorder recorder(device());
    EXPECT_EQ(messageOf([&] { recorder.fill("clear", work_.sums, 0, 2, 4); }),
              "clear: 4 bytes from byte 2 of buffer 'sums', which has 256, cannot be filled by words");
    EXPECT_NE(messageOf([&] { recorder.fill("clear", work_.sums, 0, 252, 8); }).find("cannot be filled"), std::string::npos);
}

TEST_F(Refusal, OfAModuleWithoutStatus) {
    std::vector<uint32_t> words(spirv::host_add.words.begin(), spirv::host_add.words.end());
    for (size_t at = 5; at < words.size(); at += words[at] >> 16)  // binding 0 becomes 4
        if ((words[at] & 0xffffu) == 71 && words[at + 2] == 33 && words[at + 3] == 0) words[at + 3] = 4;
    EXPECT_NE(
        refusal(Module{"bare", words, "other"}, push_, {storage("Pairs", work_.pairs)}).find("bare: binding 0 is not the Status buffer"),
        std::string::npos);
}

TEST_F(Refusal, OfABufferAboveTheBudget) {
    const std::string message = messageOf([&] { Buffer<uint32_t>(device(), uint64_t(1) << 40, "huge"); });
    EXPECT_NE(message.find("buffer 'huge': 4096.0 GiB asked"), std::string::npos) << message;
    EXPECT_THROW((Buffer<glm::uvec4>(device(), uint64_t(1) << 62, "overflow")), Error);
}

// ---- work that does not end well ----

uint32_t stateAfter(uint32_t state, uint32_t steps) {
    for (uint32_t i = 0; i < steps; ++i) state = state * 1664525u + 1013904223u;
    return state;
}

TEST_F(HostDevice, NoticesALoopThatWasCut) {
    Buffer<uint32_t> states(device(), 64, "states");
    Recorder recorder(device());
    const auto loop = [&](const char* label, uint32_t iterations, uint32_t wanted) {
        recorder.dispatch(label, spirv::host_loop, 64, LoopPush{0, iterations, 64, wanted}, {storage("States", states)});
        return messageOf([&] { recorder.run(); });
    };
    const auto expectStates = [&](uint32_t steps) {
        for (uint32_t lane = 0; lane < 64; ++lane) ASSERT_EQ(states.span()[lane], stateAfter(lane, steps)) << lane;
    };
    const std::string whole = "nothing was thrown";
    EXPECT_EQ(loop("short", kLongestLoop, kLongestLoop), whole);
    expectStates(kLongestLoop);
    EXPECT_EQ(loop("cut", 10, 11), "cut: a loop stopped before its end (loop budget of the device)");
    // The self-test's answer is what another kernel sees: a loop an eighth longer is cut there, or none is. Where in its last step a loop is cut
    // depends on the kernel.
    const uint32_t limit = device().selfTest().loopLimit, more = limit ? limit + limit / 8 : 70000;
    EXPECT_EQ(loop("long", more, more), limit ? "long: a loop stopped before its end (loop budget of the device)" : whole);
    if (!limit) expectStates(more);
    EXPECT_EQ(loop("short", 10, 10), whole);
    expectStates(10);
}

TEST_F(HostDevice, NoticesWorkgroupsThatDoNotFinish) {
    Addition work(device(), 64 * 240);
    Recorder recorder(device());
    work.record(recorder, kAddsNothing, "add", 12);
    EXPECT_EQ(messageOf([&] { recorder.run(); }), "add: 12 of 240 workgroups did not finish");
}

TEST_F(HostDevice, StopsWaitingAtTheWatchdog) {
    Device own = openDevice();
    Buffer<uint32_t> states(own, 64, "states");
    {
        Recorder recorder(own);
        recorder.dispatch("slow", spirv::host_loop, 64 * 256, LoopPush{0, kLongestLoop, 64, kLongestLoop}, {storage("States", states)});
        EXPECT_EQ(messageOf([&] { recorder.run(1); }), "slow: the device did not finish within 1 ms (watchdog)");
        EXPECT_EQ(messageOf([&] { recorder.fill("more", states, 0); }),
                  "the device may still be busy: the end of its last work was not seen");
    }
    expectSilence(own);  // the recorder waited for the work to end before it freed what the work uses
}

// ---- memory ----

TEST_F(HostDevice, CountsAndRecyclesMemory) {
    Device own = openDevice();
    const uint64_t before = own.memoryUsedBytes();
    void* first = nullptr;
    {
        Buffer<uint32_t> buffer(own, 1 << 20, "a");
        first = buffer.data();
        EXPECT_GE(own.memoryUsedBytes(), before + (4 << 20));
    }
    EXPECT_EQ(own.memoryUsedBytes(), before);
    EXPECT_GE(own.memoryPeakBytes(), before + (4 << 20));
    Buffer<uint32_t> again(own, (1 << 20) - 5000, "b");
    EXPECT_EQ(again.data(), first) << "a freed block of about the size is used again";
    EXPECT_EQ(again.bytes(), ((1 << 20) - 5000) * 4u);
    expectSilence(own);
}

TEST_F(HostDevice, GivesKeptBlocksBackToTheBudget) {
    Device own = openDevice("memory=8388608");
    EXPECT_EQ(own.memoryBudgetBytes(), 8388608u);
    { Buffer<uint32_t> most(own, 1536 * 1024, "most"); }
    { Buffer<uint32_t> other(own, 512 * 1024, "other"); }
    Buffer<uint32_t> all(own, 1900 * 1024, "all");
    EXPECT_EQ(messageOf([&] { Buffer<uint32_t>(own, 1 << 20, "more"); }),
              "buffer 'more': 4096.0 KiB asked, 7600.0 KiB of the memory budget of 8192.0 KiB are in use");
    expectSilence(own);
}

TEST_F(HostDevice, ReservesWithRoomToGrow) {
    Buffer<uint32_t> buffer;
    buffer.reserve(device(), 100, "list");
    EXPECT_EQ(buffer.count(), 141u);
    const void* const data = buffer.data();
    buffer.reserve(device(), 141, "list");
    EXPECT_EQ(buffer.data(), data);
}

TEST_F(HostDevice, OutlivingBuffersAreHarmless) {
    auto own = std::make_unique<Device>(openDevice());
    Buffer<uint32_t> survivor(*own, 64, "survivor");
    expectSilence(*own);
    own.reset();
    survivor = {};
}

TEST_F(HostDevice, ObeysTheUsersBudget) {
    DeviceRequest request;
    request.memoryBudgetBytes = 1 << 20;
    const Device own = openDevice(nullptr, request);
    EXPECT_EQ(own.memoryBudgetBytes(), 1u << 20);
}

// ---- PLUMB_LIMITS ----

TEST_F(HostDevice, ShrinksLimits) {
    Device own = openDevice("storageRange=65536,texelElements=300,groupCount=4,subgroup=0,allocation=1048576,int64=0");
    EXPECT_EQ(own.limits().storageRangeBytes, 65536u);
    EXPECT_FALSE(own.limits().subgroupShuffle);
    EXPECT_FALSE(own.limits().int64);
    Recorder recorder(own);
    Addition work(own, 1000);
    EXPECT_EQ(messageOf([&] { work.record(recorder); }),
              "host_add: binding texel takes 1000 texels of buffer 'texel', the device allows 300");
    Addition large(own, 9000);
    EXPECT_EQ(messageOf([&] { large.record(recorder); }),
              "host_add: binding Pairs takes 72000 bytes of buffer 'pairs', the device allows 65536");
    Buffer<uint32_t> states(own, 64, "states");
    EXPECT_EQ(messageOf([&] {
                  recorder.dispatch("loop", spirv::host_loop, 64 * 17, LoopPush{0, 1, 64, 1}, {storage("States", states)});
              }),
              "host_loop: 1088 items are 17 workgroups, the device allows 4 x 4");
    EXPECT_EQ(messageOf([&] { Buffer<uint32_t>(own, 1 << 19, "big"); }),
              "buffer 'big': 2048.0 KiB asked, the device allocates at most 1024.0 KiB at once");
    expectSilence(own);
}

TEST_F(HostDevice, SpreadsWorkgroupsOverRows) {
    Device own = openDevice("groupCountX=5");
    for (const uint32_t items : {1u, 64u, 65u, 320u, 321u, 640u, 64u * 23u, 64u * 25u}) {
        Addition work(own, items);
        Recorder recorder(own);
        work.record(recorder);
        recorder.run();
        work.expectSums();
    }
    expectSilence(own);
}

TEST_F(HostDevice, TimesByTheHostWithoutTimeStamps) {
    Device own = openDevice("timestamps=0");
    Addition work(own, 64);
    Recorder recorder(own);
    work.record(recorder, kAddsNothing, "one");
    recorder.run();
    work.record(recorder, kAddsNothing, "one");
    work.record(recorder, kAddsNothing, "two");
    recorder.run();
    const std::vector<PassTime> times = recorder.takeTimes();
    ASSERT_EQ(times.size(), 3u);
    EXPECT_GT(times[0].ms, 0);
    EXPECT_EQ(times[0].dispatches, 2u);
    EXPECT_EQ(times[2].pass, "whole submission (host time)");
    EXPECT_GT(times[2].ms, 0);
}

TEST_F(HostDevice, RefusesLimitsThatAreNone) {
    for (const char* text :
         {"storageRange=99999999999999", "speed=1", "storageRange", "storageRange=x", "groupCount=-1", "timestamps=1", "="})
        EXPECT_EQ(messageOf([&] { openDevice(text); }, Exit::device).rfind("PLUMB_LIMITS: ", 0), 0u) << text;
}

// ---- exact arithmetic on the device ----

void expectExact(Device& device, int seedErrorUlp) {
    constexpr uint32_t kCount = 100000;
    Buffer<glm::vec2> operands(device, kCount, "operands");
    Buffer<ExactAnswer> answers(device, kCount, "answers");
    std::mt19937 random(3);
    for (glm::vec2& v : operands.span())
        for (int k = 0; k < 2; ++k) {
            const uint32_t bits = uint32_t(random());
            const uint32_t significand = bits >> 30 == 0 ? bits & 15u : bits >> 30 == 1 ? 0x7fffffu - (bits & 15u) : bits & 0x7fffffu;
            v[k] = gpu::realOf(int((uint32_t(random()) & 0x80000000u) | (70u + uint32_t(random()) % 115u) << 23 | significand));
        }
    Recorder recorder(device);
    recorder.dispatch("exact", spirv::host_exact, kCount, ExactPush{0, kCount, seedErrorUlp},
                      {storage("Operands", operands), storage("Answers", answers)});
    recorder.run();
    for (uint32_t i = 0; i < kCount; ++i) {
        const glm::vec2 v = operands.span()[i];
        const ExactAnswer& a = answers.span()[i];
        ASSERT_EQ(gpu::ubitsOf(a.quotient), gpu::ubitsOf(v.x / v.y)) << std::hexfloat << v.x << " / " << v.y;
        ASSERT_EQ(gpu::ubitsOf(a.root), gpu::ubitsOf(std::sqrt(std::fabs(v.x)))) << std::hexfloat << v.x;
        ASSERT_EQ(gpu::ubitsOf(a.emulatedQuotient), gpu::ubitsOf(v.x / v.y)) << std::hexfloat << v.x << " / " << v.y;
        ASSERT_EQ(gpu::ubitsOf(a.emulatedRoot), gpu::ubitsOf(std::sqrt(std::fabs(v.x)))) << std::hexfloat << v.x;
        ASSERT_EQ(gpu::ubitsOf(a.snapped), gpu::ubitsOf(gpu::snapTiny(v.x))) << std::hexfloat << v.x;
    }
}

TEST_F(HostDevice, DividesAndTakesRootsAsIeeeDoesWhateverTheSeed) {
    for (const int seedErrorUlp : {-3, -2, -1, 0, 1, 2, 3}) expectExact(device(), seedErrorUlp);
}

TEST_F(HostDevice, RunsTheEmulatedFormsWhereTheNativeOnesMayNot) {
    Device own = openDevice("nativeDivide=0,nativeRoot=0");
    EXPECT_FALSE(own.selfTest().nativeDivideIsExact);
    EXPECT_FALSE(own.selfTest().nativeRootIsExact);
    EXPECT_TRUE(own.selfTest().emulatedDivideIsExact);
    expectExact(own, 0);
    expectSilence(own);
}

// ---- the self-test ----

TEST(SelfTestVerdict, SeesEachWrongAnswer) {
    const std::vector<gpu::SelfTestVector> vectors = selfTestVectors();
    ASSERT_EQ(vectors.size(), gpu::kSelfTestVectors);
    std::vector<gpu::SelfTestAnswer> good;
    for (const gpu::SelfTestVector& v : vectors) {
        const uint64_t u = uint64_t(v.i) * v.j;
        const int64_t s = int64_t(int32_t(v.i)) * int32_t(v.j);
        const float root = std::sqrt(std::fabs(v.x));
        good.push_back({v.x + v.y, v.x - v.y, v.x * v.y, v.x * v.y + v.x, float(int32_t(v.i)), float(v.i), int32_t(v.converted),
                        uint32_t(std::fabs(v.converted)), uint32_t(u >> 32), uint32_t(u), int32_t(s >> 32), int32_t(s), v.x / v.y, root,
                        gpu::emulatedDivide(v.x, v.y, 0), gpu::emulatedRoot(std::fabs(v.x), 0)});
    }
    EXPECT_EQ(judgeSelfTest(vectors, good).failure, "");
    EXPECT_TRUE(judgeSelfTest(vectors, good).nativeDivideIsExact);
    const size_t fields = sizeof(gpu::SelfTestAnswer) / 4;
    for (size_t field = 0; field < fields; ++field) {
        std::vector<gpu::SelfTestAnswer> bad = good;
        reinterpret_cast<uint32_t*>(&bad[vectors.size() - 1])[field] ^= 1u;
        const SelfTest verdict = judgeSelfTest(vectors, bad);
        const int kept = verdict.exactAddMul + verdict.exactConversions + verdict.nativeDivideIsExact + verdict.nativeRootIsExact +
                         verdict.emulatedDivideIsExact + verdict.emulatedRootIsExact;
        EXPECT_EQ(kept, 5) << "field " << field;
        EXPECT_EQ(verdict.failure.empty(), field >= 12) << verdict.failure;
    }
}

// A contracted multiply-add and a flushed sum are what real drivers do; the vectors must tell.
TEST(SelfTestVerdict, VectorsTellContractionFromTwoRoundings) {
    int differing = 0;
    for (const gpu::SelfTestVector& v : selfTestVectors()) differing += std::fma(v.x, v.y, v.x) != v.x * v.y + v.x;
    EXPECT_GT(differing, 1000);
}

// Each answer of binary64 counts, and what drivers do instead is told.
TEST(SelfTestVerdict, OfBinary64NoticesEachWord) {
    const std::vector<gpu::DoubleVector> vectors = doubleVectors();
    ASSERT_EQ(vectors.size(), gpu::kDoubleVectors);
    const auto doubleOf = [](uint32_t low, uint32_t high) { return std::bit_cast<double>(uint64_t(high) << 32 | low); };
    std::vector<gpu::DoubleAnswer> good;
    int contracted = 0, cutShort = 0, single = 0;
    for (const gpu::DoubleVector& v : vectors) {
        const double a = doubleOf(v.aLow, v.aHigh), b = doubleOf(v.bLow, v.bHigh), x = double(v.x);
        for (const double operand : {a, b, x}) ASSERT_TRUE(std::abs(operand) >= 0x1p-60 && std::abs(operand) <= 0x1p60) << operand;
        const auto words = [](double y) { return std::bit_cast<uint64_t>(y); };
        const uint64_t sum = words(a + b), product = words(a * x), both = words(a * x + b);
        good.push_back({uint32_t(sum), uint32_t(sum >> 32), uint32_t(product), uint32_t(product >> 32), uint32_t(both),
                        uint32_t(both >> 32), float(a)});
        contracted += std::fma(a, x, b) != a * x + b;
        cutShort += float(a) != std::bit_cast<float>(uint32_t(words(a) >> 63) << 31 | uint32_t((words(a) >> 29) - (uint64_t(896) << 23)));
        single += double(float(a) + float(b)) != a + b;
    }
    EXPECT_TRUE(judgeDoubles(vectors, good));
    EXPECT_GT(contracted, 100);
    EXPECT_GT(cutShort, 100) << "a conversion that does not round";
    EXPECT_GT(single, 100) << "float32 in its place";
    for (size_t field = 0; field < sizeof(gpu::DoubleAnswer) / 4; ++field) {
        std::vector<gpu::DoubleAnswer> bad = good;
        reinterpret_cast<uint32_t*>(&bad[vectors.size() / 2])[field] ^= 1u;
        EXPECT_FALSE(judgeDoubles(vectors, bad)) << "field " << field;
    }
}

TEST(SelfTestCache, IsReadOnlyWholeAndForItsKey) {
    SelfTest verdict;
    verdict.exactAddMul = verdict.exactConversions = verdict.emulatedDivideIsExact = verdict.emulatedRootIsExact = true;
    const std::string text = selfTestCacheText(verdict, "uuid 1 sha");
    SelfTest read;
    ASSERT_TRUE(readSelfTestCache(text, "uuid 1 sha", read));
    EXPECT_TRUE(read.exactAddMul && read.emulatedRootIsExact && !read.nativeRootIsExact);
    EXPECT_FALSE(readSelfTestCache(text, "uuid 2 sha", read));
    for (size_t i = 0; i < text.size(); ++i) {
        std::string damaged = text;
        damaged[i] ^= 1;
        EXPECT_FALSE(readSelfTestCache(damaged, "uuid 1 sha", read)) << i;
        EXPECT_FALSE(readSelfTestCache(text.substr(0, i), "uuid 1 sha", read)) << i;
    }
}

TEST_F(HostDevice, StoresItsVerdictAndSurvivesADamagedStore) {
    const test::TemporaryFolder folder;
    const char* const old = std::getenv("XDG_CACHE_HOME");
    const std::string before = old ? old : "";
    setenv("XDG_CACHE_HOME", folder.path().c_str(), 1);
    EXPECT_FALSE(openDevice().selfTest().fromCache);
    EXPECT_TRUE(openDevice().selfTest().fromCache);
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "plumbline")) {
        std::filesystem::resize_file(entry.path(), 40);
        ++files;
    }
    EXPECT_EQ(files, 1);
    EXPECT_FALSE(openDevice().selfTest().fromCache);
    EXPECT_TRUE(openDevice().selfTest().fromCache);
    setenv("XDG_CACHE_HOME", "/proc/nowhere", 1);
    EXPECT_FALSE(openDevice().selfTest().fromCache);
    old ? setenv("XDG_CACHE_HOME", before.c_str(), 1) : unsetenv("XDG_CACHE_HOME");
}

}  // namespace
}  // namespace plumb
