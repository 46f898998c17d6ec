// SPDX-License-Identifier: MIT
#include "pipeline/scene/input.h"

#include "host/error.h"
#include "pipeline/scene/extension.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {
namespace {

namespace fs = std::filesystem;

constexpr size_t kHeadBytes = size_t(1) << 16;
constexpr int kWaitMs = 100;  // wait for a writer, and between two checks for an interrupt

constexpr std::pair<std::string_view, FileFormat> kFormats[] = {
    {"obj", FileFormat::obj},   {"ply", FileFormat::ply},  {"stl", FileFormat::stl},  {"off", FileFormat::off},
    {"gltf", FileFormat::gltf}, {"glb", FileFormat::gltf}, {"toml", FileFormat::toml}};

FileFormat formatNamed(std::string_view name) {
    for (const auto& [word, format] : kFormats)
        if (word == name) return format;
    return FileFormat::unknown;
}

bool isStandardInput(const fs::path& path) { return path == "-"; }

std::string headOf(const fs::path& path) {
    std::string head(kHeadBytes, '\0');
    std::ifstream in(path, std::ios::binary);
    in.read(head.data(), std::streamsize(head.size()));
    head.resize(size_t(std::max<std::streamsize>(in.gcount(), 0)));
    return head;
}

bool isWordCharacter(char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '-'; }

std::string_view withoutBlanks(std::string_view line) {
    const size_t first = line.find_first_not_of(" \t\v\f");
    return first == line.npos ? std::string_view() : line.substr(first);
}

// Format by the first line of a text that is neither blank nor a comment; comments begin with '#' in every format that has them.
FileFormat formatOfText(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    for (;;) {
        const size_t end = std::min(text.find_first_of("\r\n"), text.size());
        const std::string_view line = withoutBlanks(text.substr(0, end));
        if (line.empty() || line[0] == '#') {
            if (end == text.size()) return FileFormat::unknown;
            text.remove_prefix(end + 1);
            continue;
        }
        if (line[0] == '{') return FileFormat::gltf;
        if (line[0] == '[') return FileFormat::toml;
        const size_t length = size_t(std::find_if_not(line.begin(), line.end(), isWordCharacter) - line.begin());
        const std::string_view word = line.substr(0, length), rest = withoutBlanks(line.substr(length));
        if (length != 0 && !rest.empty() && (rest[0] == '=' || rest[0] == '.')) return FileFormat::toml;
        if (length != line.size() && line[length] != ' ' && line[length] != '\t') return FileFormat::unknown;
        std::string lower(word);
        for (char& c : lower)
            if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
        if (lower == "solid" || lower == "facet") return FileFormat::stl;
        std::string_view off = word;  // [ST][C][N]OFF, and its counts where some writers glue them to it
        for (const std::string_view prefix : {"ST", "C", "N"})
            if (off.starts_with(prefix)) off.remove_prefix(prefix.size());
        if (off.starts_with("OFF") && off.find_first_not_of("0123456789", 3) == off.npos) return FileFormat::off;
        for (const std::string_view statement : {"v", "vn", "vt", "vp", "f", "fo", "l", "p", "o", "g", "s", "usemtl", "mtllib"})
            if (word == statement) return FileFormat::obj;
        return FileFormat::unknown;
    }
}

FileFormat unknownFormat(const fs::path& path, std::string_view formats) {
    const std::string extension = path.extension().string();
    throw inputError(printablePath(path), fmt::format("{} and the first bytes tell no format; --format names it: {}",
                                                      isStandardInput(path) ? "it has no name"
                                                      : extension.empty()   ? "the name has no extension"
                                                                          : fmt::format("unknown extension '{}'", printable(extension, 40)),
                                                      formats));
}

void refuseFolder(const fs::path& path) {
    std::error_code ignored;
    if (!isStandardInput(path) && fs::is_directory(path, ignored))
        throw inputError(printablePath(path), "is a folder, not a model: name the files in it");
}

}  // namespace

FileFormat formatOfExtension(const fs::path& path) {
    const std::string extension = lowerExtension(path);
    return extension.empty() ? FileFormat::unknown : formatNamed(std::string_view(extension).substr(1));
}

FileFormat formatOfContent(std::string_view head, uint64_t size) {
    if (head.starts_with("glTF")) return FileFormat::gltf;
    if (head.starts_with("\xef\xbb\xbfply")) head.remove_prefix(3);
    if (head.starts_with("ply") && head.size() > 3 && (head[3] == '\n' || head[3] == '\r')) return FileFormat::ply;
    constexpr uint64_t kStlHeader = 84, kFacet = 50;
    if (head.size() >= kStlHeader) {
        uint32_t facets = 0;
        std::memcpy(&facets, head.data() + 80, sizeof facets);
        if (facets != 0 && size == kStlHeader + kFacet * facets) return FileFormat::stl;
    }
    if (head.find('\0') != head.npos) return FileFormat::unknown;
    return formatOfText(head);
}

FileFormat formatOfReference(const fs::path& path, const LoadOptions&) {
    FileFormat format = formatOfExtension(path);
    struct stat status {};
    // The reader refuses anything but a regular file and never opens it.
    if (format == FileFormat::unknown && ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode))
        format = formatOfContent(headOf(path), uint64_t(status.st_size));
    return format;
}

FileFormat formatOfInput(const fs::path& path, const LoadOptions& options) {
    refuseFolder(path);
    if (!options.format.empty()) return formatNamed(options.format);
    FileFormat format = FileFormat::unknown;
    std::string head;
    if (const auto once = options.once->find(path.native()); once != options.once->end()) {
        format = formatOfExtension(path);
        if (format == FileFormat::unknown && once->second.empty()) throw inputError(printablePath(path), "it is empty");
        head = once->second.substr(0, kHeadBytes);
        if (format == FileFormat::unknown) format = formatOfContent(head, once->second.size());
    } else {
        std::error_code failed;
        if (formatOfExtension(path) == FileFormat::unknown && !fs::exists(path, failed)) readWholeFile(path);  // refuses, and says why
        format = formatOfReference(path, options);
        if (format == FileFormat::unknown) head = headOf(path);
    }
    if (const char* encoding = format == FileFormat::unknown ? otherEncoding(head) : nullptr)
        throw inputError(printablePath(path), fmt::format("the text is {}; only UTF-8 is read", encoding));
    return format == FileFormat::unknown ? unknownFormat(path, "obj, ply, stl, off, gltf, toml") : format;
}

bool isReadOnce(const fs::path& path) {
    if (isStandardInput(path)) return true;
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 && S_ISFIFO(status.st_mode);
}

void rememberOnce(const fs::path& path, const LoadOptions& options) {
    const std::string location = printablePath(path);
    // A FIFO is opened without waiting for its writer. poll() waits instead, and checks for an interrupt.
    const bool own = !isStandardInput(path);
    const int fd = own ? ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY) : STDIN_FILENO;
    if (fd < 0) throw inputError(location, std::strerror(errno));
    const struct Closer {
        int fd;
        ~Closer() {
            if (fd >= 0) ::close(fd);
        }
    } closer{own ? fd : -1};
    std::string bytes;
    for (size_t done = 0;;) {
        if (options.onProgress) options.onProgress(options.from, "read");
        pollfd input{fd, POLLIN, 0};
        const int ready = ::poll(&input, 1, kWaitMs);
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        if (done == bytes.size()) bytes.resize(std::min<uint64_t>(std::max<size_t>(kHeadBytes, 2 * done), kMaxFileBytes + 1));
        const ssize_t got = ::read(fd, bytes.data() + done, std::min<size_t>(bytes.size() - done, size_t(1) << 20));
        if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (got < 0) throw inputError(location, std::strerror(errno));
        if (got == 0) {
            bytes.resize(done);
            break;
        }
        done += size_t(got);
        if (done > kMaxFileBytes)
            throw inputError(location, fmt::format("has more than {} bytes; at most {} are read", kMaxFileBytes, kMaxFileBytes));
    }
    bytes.shrink_to_fit();
    (*options.once)[path.native()] = std::move(bytes);
}

fs::path referenceBase(const fs::path& path, const LoadOptions& options) {
    const std::string& name = path.native();
    const bool descriptor = name == "/dev/stdin" || name.starts_with("/dev/fd/") || name.starts_with("/proc/self/fd/");
    return descriptor || options.once->contains(name) ? path.filename() : path;
}

std::string readInput(const fs::path& path, const LoadOptions& options, uint64_t maxBytes) {
    if (const auto once = options.once->find(path.native()); once != options.once->end()) {
        if (once->second.size() > maxBytes)
            throw inputError(printablePath(path), fmt::format("has {} bytes; at most {} are read", once->second.size(), maxBytes));
        return once->second;
    }
    return readWholeFileTelling(path, maxBytes, [&](uint64_t done, uint64_t size) {
        LoadMeter(options, "read", kReadEnds * double(done) / double(std::max<uint64_t>(1, size)), kReadEnds, 1);
    });
}

std::string readTextInput(const fs::path& path, const LoadOptions& options) {
    std::string text = readInput(path, options);
    takeByteOrderMark(text, path);
    return text;
}

void LoadMeter::tell(uint64_t done) {
    next_ = done + kStep;
    if (!options_.onProgress) return;
    const double share = from_ + (to_ - from_) * (total_ == 0 ? 1 : std::min(1.0, double(done) / double(total_)));
    options_.onProgress(options_.from + (options_.to - options_.from) * share, stage_);
}

}  // namespace plumb
