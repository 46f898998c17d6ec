// SPDX-License-Identifier: MIT
// One reader (fuzzedExtension; of a libFuzzer program PLUMB_FUZZ_EXTENSION) on hostile bytes, from the file to a small picture by the twin. Anything but a picture
// without NaN or a refusal with one clear line is a finding; memory faults are the sanitizers' to find.
// Bytes after a line "%%second file%%" are the file that the first may refer to (a material library, a mesh).
#include "host/error.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"

#include <fcntl.h>
#include <unistd.h>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#ifndef PLUMB_FUZZ_EXTENSION
#define PLUMB_FUZZ_EXTENSION ""
#endif
std::string_view fuzzedExtension = PLUMB_FUZZ_EXTENSION;  // of the file that is read: "obj"

namespace {

constexpr std::string_view kSplit = "\n%%second file%%\n";
constexpr uint64_t kMostTriangles = 20000;  // more take the twin long and find nothing new in a reader

[[noreturn]] void finding(const char* what, const std::string& text) {
    std::fprintf(stderr, "finding: %s: %s\n", what, text.c_str());
    std::abort();
}

// A folder in memory, so that nothing waits for a disk.
const std::string& folder() {
    // Not destroyed: the handler that removes the folder runs after the destructors.
    static const std::string& path = *new std::string([] {
        std::string name = access("/dev/shm", W_OK) == 0 ? "/dev/shm/plumb-fuzz-XXXXXX" : "/tmp/plumb-fuzz-XXXXXX";
        if (!mkdtemp(name.data())) finding("no temporary folder", name);
        std::atexit([] {
            std::error_code ignored;
            std::filesystem::remove_all(folder(), ignored);
        });
        return name;
    }());
    return path;
}

std::string write(const char* name, std::string_view bytes) {
    std::string path = folder() + "/" + name;
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0 || ::write(file, bytes.data(), bytes.size()) != ssize_t(bytes.size()) || close(file) != 0) finding("cannot write", path);
    return path;
}

void draw(plumb::Scene scene, bool bareMesh) {
    plumb::completeScene(scene, {16, 16}, "", bareMesh);
    uint64_t triangles = 0;
    for (const plumb::Object& object : scene.objects) triangles += scene.meshes[object.mesh].triangles.size();
    if (triangles > kMostTriangles) return;
    plumb::RenderRequest request;
    request.width = request.height = 16;
    request.threads = 1;
    request.planes |= plumb::kPlaneLinear | plumb::kPlaneZ;
    const plumb::RenderResult result = plumb::renderCpu(scene, request);
    for (const float value : result.frame.linear)
        if (!std::isfinite(value)) finding("not finite", "linear colour");
    for (const float value : result.frame.z)
        if (!std::isfinite(value)) finding("not finite", "z");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    const size_t split = bytes.find(kSplit);
    const std::string path = write((std::string("fuzz.") + std::string(fuzzedExtension)).c_str(), bytes.substr(0, split));
    if (split != std::string_view::npos) write("second.obj", bytes.substr(split + kSplit.size()));
    bool loaded = false;
    try {
        plumb::Scene scene = plumb::loadScene({path}, {});
        loaded = true;
        draw(std::move(scene), plumb::isBareMesh(path));
    } catch (const plumb::Error& error) {
        const std::string_view text = error.what();
        if (error.exit() != plumb::Exit::input) finding("not a refusal of input", std::string(text));
        if (text.empty() || text.find('\n') != std::string_view::npos) finding("not one line", std::string(text));
        // Every message begins with the file. What only shows when it is drawn names the place of its part of the scene as well.
        const std::string_view rest = text.starts_with(folder()) ? text.substr(folder().size()) : std::string_view();
        if (!rest.starts_with("/fuzz.") && !rest.starts_with("/second.")) finding("names no file", std::string(text));
        const size_t colon = rest.find(':');
        if (loaded && rest.starts_with("/fuzz.toml") && (colon + 1 >= rest.size() || rest[colon + 1] < '1' || rest[colon + 1] > '9'))
            finding("names no place", std::string(text));
    }
    return 0;
}
