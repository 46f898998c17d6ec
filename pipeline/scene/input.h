// SPDX-License-Identifier: MIT
// Input of the readers: files, and bytes that come once through a pipe; their format; and the progress of a reader.
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

// Format by the extension in any case; unknown when it names none.
FileFormat formatOfExtension(const std::filesystem::path&);
// Format by the bytes: `head` is the beginning of `size` bytes. Binary formats by their magic or their size, texts by the first statement.
FileFormat formatOfContent(std::string_view head, uint64_t size);
// Format of an input: LoadOptions::format, else by extension, else by content. Refused: a folder, and an unknown format.
FileFormat formatOfInput(const std::filesystem::path&, const LoadOptions&);
// Format of a file that a scene names: by extension, else by content.
FileFormat formatOfReference(const std::filesystem::path&, const LoadOptions&);

// True for "-", a FIFO and any other input that can be read only once.
bool isReadOnce(const std::filesystem::path&);
// Reads an input that can be read only once to its end and remembers it in options.once. At most kMaxFileBytes; options.onProgress may end
// the wait.
void rememberOnce(const std::filesystem::path&, const LoadOptions&);
// Bytes of a file, or the remembered bytes of an input that can be read only once.
std::string readInput(const std::filesystem::path&, const LoadOptions&, uint64_t maxBytes = kMaxFileBytes);
// Text of an input, without a byte order mark. A text of another encoding than UTF-8 is refused.
std::string readTextInput(const std::filesystem::path&, const LoadOptions&);

// File whose folder holds the files that an input names. For bytes from a pipe or a descriptor (/dev/stdin, <(...)): a file in the current
// folder.
std::filesystem::path referenceBase(const std::filesystem::path&, const LoadOptions&);

// Reads a file as readWholeFile() does, and calls tell(done, size) every few MiB. An exception of `tell` comes through.
std::string readWholeFileTelling(const std::filesystem::path&, uint64_t maxBytes, const std::function<void(uint64_t, uint64_t)>& tell);

// Meter of a part of the work on one file: reports every kStep units and at the end. LoadOptions::onProgress may throw, so an interrupt is
// noticed here.
class LoadMeter {
public:
    // Starts at `from` and ends at `to` of the file's share, in `total` units.
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

// Ends of the parts of a file's time: its bytes are read, then parsed, then finished (10^7 triangles of a binary PLY).
inline constexpr double kReadEnds = 0.02, kParseEnds = 0.25;

}  // namespace plumb
