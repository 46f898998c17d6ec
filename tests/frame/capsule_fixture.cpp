// SPDX-License-Identifier: MIT
// Writes capsules of planted faults for suite_command_test.py: a device whose products of floats are one unit off in the kernel of lines, and
// one whose kernel of the fill never says that it finished. usage: capsule_fixture FOLDER    FOLDER/differs and FOLDER/fails
#include "host/driver.h"
#include "host/error.h"
#include "pipeline/suite/capsule.h"
#include "pipeline/suite/reduce.h"
#include "pipeline/suite/suite.h"
#include "tests/fault/planted_driver.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace plumb;
namespace fs = std::filesystem;
using test::Editor;
using test::Words;

const suite::PictureTest& pictureOf(std::string_view name) {
    const auto all = suite::pictureTests();
    return *std::find_if(all.begin(), all.end(), [&](const suite::PictureTest& test) { return test.name == name; });
}

// Makes the capsule, and says what it found.
bool write(const fs::path& folder, const char* picture, const char* module, void (*change)(Editor&)) {
    DeviceRequest request;
    request.prefer = request.require = "lavapipe";
    Device device = Device::open(Device::choose(request), request);
    plantDriver(device, [&](std::string_view name, std::vector<uint32_t>& words) {
        if (name != module) return;
        Editor editor(words);
        change(editor);
        words = editor.words();
    });
    const suite::PictureTest& test = pictureOf(picture);
    const Scene scene = test.scene(test.width, test.height);
    const RenderRequest drawn = suite::requestOf(test, 1);
    const std::string pass = suite::differingPass(device, scene, drawn);
    const suite::Reduced reduced = suite::reduce(device, scene, drawn, pass, std::chrono::seconds(20), {});
    const std::optional<suite::Capsule> capsule = suite::capsuleOf(device, reduced, suite::Json());
    if (!capsule) return false;
    fs::create_directories(folder);
    uint64_t bytes = 0;
    for (const auto& [name, text] : suite::filesOf(*capsule)) {
        std::ofstream(folder / name, std::ios::binary) << text;
        bytes += text.size();
    }
    std::printf("{\"pass\": \"%s\", \"triangles\": %d, \"before\": %d, \"bytes\": %d, \"located\": %d}\n", pass.c_str(),
                int(reduced.triangles), int(reduced.trianglesBefore), int(bytes), int(capsule->location.has_value()));
    return true;
}

constexpr uint32_t kOpFMul = 133, kOpAtomicIAdd = 234;

void productsOneMore(Editor& editor) {
    editor.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == kOpFMul && in[1] == editor.floatType())
            editor.wordResult(in, [&](uint32_t word) { return editor.plusOne(word); });
    });
}

// Counts each group as none: the recorder misses them.
void countsNothing(Editor& editor) {
    const uint32_t none = editor.constant(0);
    editor.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == kOpAtomicIAdd) editor.put(kOpAtomicIAdd, in[1], {in[3], in[4], in[5], none}, in[2]);
    });
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) return std::fprintf(stderr, "usage: capsule_fixture FOLDER\n"), 2;
    const fs::path folder = arguments[1];
    try {
        return write(folder / "differs", "soup-flat", "fill_shuffle", productsOneMore) &&
                       write(folder / "fails", "wire-culled", "lines", countsNothing)
                   ? 0
                   : 1;
    } catch (const Error& error) {
        std::fprintf(stderr, "capsule_fixture: %s\n", error.what());
        return 1;
    }
}
