// SPDX-License-Identifier: MIT
// What the readers read: files, and what comes once through a pipe; which format that is; and how far a reader is.
#pragma once

#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace plumb {

enum class FileFormat { unknown, obj, ply, stl, off, gltf, toml };

// By the extension in any case; unknown when it names none.
FileFormat formatOfExtension(const std::filesystem::path&);
// By the bytes: `head` is the beginning of `size` bytes. Binary formats by their magic or their size, texts by the first statement.
FileFormat formatOfContent(std::string_view head, uint64_t size);
// Of an input: what LoadOptions::format says, else by extension, else by content. Refused: a folder, and what is none of them.
FileFormat formatOfInput(const std::filesystem::path&, const LoadOptions&);
// Of a file that a scene names: by extension, else by content.
FileFormat formatOfReference(const std::filesystem::path&, const LoadOptions&);

// True for "-", a FIFO and what else can be read only once.
bool isReadOnce(const std::filesystem::path&);
// Reads such an input to its end and remembers it in options.once. At most kMaxFileBytes, and options.onProgress may end the wait.
void rememberOnce(const std::filesystem::path&, const LoadOptions&);
// The bytes of a file, or what was remembered of an input that can be read only once.
std::string readInput(const std::filesystem::path&, const LoadOptions&, uint64_t maxBytes = kMaxFileBytes);

// The file whose folder holds what an input names; for what came through a pipe or a descriptor (/dev/stdin, <(...)) one in the current folder.
std::filesystem::path referenceBase(const std::filesystem::path&, const LoadOptions&);

// readWholeFile that says how far it is, tell(done, size), every few MiB. What `tell` throws comes through.
std::string readWholeFileTelling(const std::filesystem::path&, uint64_t maxBytes, const std::function<void(uint64_t, uint64_t)>& tell);

// A part of the work on one file, told every kStep units and at its end. LoadOptions::onProgress may throw, so an interrupt is heard here.
class LoadMeter {
public:
    // From `from` to `to` of the file's share, in `total` units.
    LoadMeter(const LoadOptions& options, const char* stage, double from, double to, uint64_t total)
        : options_(options), stage_(stage), from_(from), to_(to), total_(total) {
        tell(0);
    }
    void at(uint64_t done) {
        if (done >= next_) tell(done);
    }

private:
    static constexpr uint64_t kStep = uint64_t(1) << 16;  // units that take a few nanoseconds to a microsecond each
    void tell(uint64_t done);

    const LoadOptions& options_;
    const char* stage_;
    double from_, to_;
    uint64_t total_, next_ = 0;
};

// Shares of a file's time: its bytes are read, then parsed, then finished (10^7 triangles of a binary PLY).
inline constexpr double kReadEnds = 0.02, kParseEnds = 0.25;

}  // namespace plumb
