// SPDX-License-Identifier: MIT
// Records dispatches, runs them, and shows that they ran. Between two dispatches stands a full compute barrier (free on lavapipe).
// Every dispatch has a status slot. Each workgroup that reached its end adds 1 to `finished`; each invocation that stopped early (loop
// budget) sets a bit in `fault`. run() checks both, so it throws for a truncated loop, a partial dispatch, a lost device or a dropped
// submission.
//
// Every module declares   layout(binding = 0, scalar) buffer Status { StatusSlot status[]; };
// and its push block begins with   uint statusSlot;   (shaders/shared/status.h). The recorder binds and fills both.
#pragma once

#include "host/buffer.h"
#include "host/pass_time.h"
#include "host/program.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace plumb {

enum class View : uint32_t { storage, texelU32, texelU32x2, texelU32x4, texelF32, texelF32x4 };

// Buffer for one binding of a dispatch, by the name that the shader gives the texel buffer or the block.
// A storage range or a texel count above the device's limit is refused with a sentence.
struct Binding {
    const char* name = "";
    const RawBuffer* buffer = nullptr;
    View view = View::storage;
    uint32_t elementBytes = 0;  // sizeof(T) for storage: compared with the stride that the module declares
    uint64_t offset = 0;        // bytes
    uint64_t range = 0;         // bytes; 0: to the end of the buffer
};

template <class T>
Binding storage(const char* name, const Buffer<T>& buffer, uint64_t firstElement = 0, uint64_t count = 0) {
    return {name, &buffer, View::storage, uint32_t(sizeof(T)), firstElement * sizeof(T), count * sizeof(T)};
}
inline Binding texels(const char* name, const RawBuffer& buffer, View view, uint64_t offset = 0, uint64_t range = 0) {
    return {name, &buffer, view, 0, offset, range};
}

struct RecorderImpl;

class Recorder {
public:
    explicit Recorder(Device& device);
    ~Recorder();
    Recorder(Recorder&&) noexcept;

    // Records one dispatch of `items` invocations along x, rounded up to the local size. More groups than maxComputeWorkGroupCount[0] go to
    // y; modules compute their item from both (shaders/shared/status.h). `push` is a struct whose first member is `uint statusSlot`, which
    // is overwritten here. Its size must equal the module's. `bindings` are those of the module but its Status, in any order. Refuses
    // (Error(failed), a sentence naming module and binding) what does not fit: names, kinds, strides, texel types, push size, ranges,
    // constants that are unknown or not given.
    template <class Push>
    void dispatch(const char* label, const Module& module, uint64_t items, Push push, const std::vector<Binding>& bindings,
                  const Specialization& constants = {}) {
        static_assert(sizeof(Push) % 4 == 0);
        record(label, module, items, &push, sizeof(Push), bindings, constants);
    }
    // Begins to make the pipeline of a later dispatch, with exactly these constants, on a thread of its own. For a large module a driver
    // may take longer than everything before that dispatch. Errors are thrown by the dispatch. `module` lives as long as the device.
    void prepare(const Module& module, const Specialization& constants);
    // Restricts labels: every later dispatch or fill under another label is refused (Error(failed), one sentence).
    void allow(std::vector<std::string> labels);
    // States that the pass of this label had nothing to do; a dispatch of 0 items states it too.
    void skip(const char* label, const char* why);
    // Labels of passes that had nothing to do since the last call, with the reason stated last.
    std::map<std::string, std::string> takeSkipped();
    void fill(const char* label, const RawBuffer& buffer, uint32_t word, uint64_t offset = 0, uint64_t bytes = 0);

    // Submits the recorded commands, waits (time-out `watchdogMs`), checks the status slots, collects the times, and
    // is empty again. Throws Error(failed): "fill: 12 of 240 workgroups did not finish", "... loop budget", lost, timeout.
    void run(double watchdogMs = 60000);

    // Makes the recorder run by itself whenever it has `commands` commands, and call `between` then. For pictures of many dispatches: the
    // watchdog waits for a few seconds of work, and an interrupt is noticed.
    void runEvery(uint32_t commands, double watchdogMs, std::function<void()> between);

    // Makes the recorder submit every later command by itself and wait for it; its time is the host's. For comparing passes, not for speed:
    // time stamps within one submission of lavapipe do not wait for the work between them once the device is warm.
    void timeApart(double watchdogMs);

    // Times of everything run since the last takeTimes(), in order of first appearance.
    std::vector<PassTime> takeTimes();

private:
    void record(const char* label, const Module& module, uint64_t items, void* push, size_t pushBytes, std::span<const Binding> bindings,
                const Specialization& constants);
    void runWhenDue();
    std::unique_ptr<RecorderImpl> impl_;
};

}  // namespace plumb
