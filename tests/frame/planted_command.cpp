// SPDX-License-Identifier: MIT
// The command on a device with a faulty driver, so that verify and its capsules meet one: PLUMB_DRIVER=products makes every product of floats
// in the kernel of the fill one unit larger, PLUMB_DRIVER=uncounted keeps the kernel of lines from saying that it finished. The linker puts
// what is here in the place of Device::open (--wrap).
#include "host/driver.h"
#include "tests/fault/planted_driver.h"

#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

namespace plumb {

Device openedByDriver(const DeviceChoice&,
                      const DeviceRequest&) asm("__real__ZN5plumb6Device4openERKNS_12DeviceChoiceERKNS_13DeviceRequestE");
Device openedFaulty(const DeviceChoice&,
                    const DeviceRequest&) asm("__wrap__ZN5plumb6Device4openERKNS_12DeviceChoiceERKNS_13DeviceRequestE");

namespace {

using test::Editor;
using test::Words;

constexpr uint32_t kOpFMul = 133, kOpAtomicIAdd = 234;

void enlargeProducts(Editor& editor) {
    editor.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == kOpFMul && in[1] == editor.floatType())
            editor.wordResult(in, [&](uint32_t word) { return editor.plusOne(word); });
    });
}

// Counts each group as none: the recorder misses them.
void countNothing(Editor& editor) {
    const uint32_t none = editor.constant(0);
    editor.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == kOpAtomicIAdd) editor.put(kOpAtomicIAdd, in[1], {in[3], in[4], in[5], none}, in[2]);
    });
}

}  // namespace

Device openedFaulty(const DeviceChoice& choice, const DeviceRequest& request) {
    Device device = openedByDriver(choice, request);
    const char* const word = std::getenv("PLUMB_DRIVER");
    const std::string_view fault = word != nullptr ? word : "";
    if (!fault.empty())
        plantDriver(device, [fault](std::string_view name, std::vector<uint32_t>& words) {
            const bool products = fault == "products" && name.starts_with("fill"), uncounted = fault == "uncounted" && name == "lines";
            if (!products && !uncounted) return;
            Editor editor(words);
            products ? enlargeProducts(editor) : countNothing(editor);
            words = editor.words();
        });
    return device;
}

}  // namespace plumb
