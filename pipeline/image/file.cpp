// SPDX-License-Identifier: MIT
// Files that are whole or absent: temporary files in the same folder, synced together, then named (docs/outputs.md).
#include "host/error.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/scene/extension.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;

// Limits of a batch, which holds a descriptor a file. Syncing 256 files costs little more than syncing one, and at most so many are lost.
constexpr size_t kMostFiles = 256;
constexpr uint64_t kMostBytes = uint64_t(256) << 20;
constexpr std::chrono::seconds kMostWait{5};
constexpr uint32_t kSyncThreads = 8;  // the file system commits files that are synced at once together in its journal
constexpr int kMostNames = 100;       // random names to try; when that many exist already it is no chance

[[noreturn]] void fail(const fs::path& path, const char* doing) {
    throw renderError(fmt::format("cannot write '{}': {}: {}", path.string(), doing, std::strerror(errno)));
}

// Repeats a call that a signal interrupted.
template <class Call>
auto retried(const Call& call) {
    for (;;) {
        const auto result = call();
        if (result != -1 || errno != EINTR) return result;
    }
}

int closeFile(int fd) {  // never retried: Linux has closed it even when it was interrupted
    const int rc = ::close(fd);
    return rc != 0 && errno == EINTR ? 0 : rc;
}

// Writes all bytes, since write(2) may be short or interrupted; an error is left in errno.
bool writeAll(int fd, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = retried([&] { return ::write(fd, bytes.data(), std::min<size_t>(bytes.size(), size_t(1) << 24)); });
        if (n < 0) return false;
        bytes = bytes.subspan(size_t(n));
    }
    return true;
}

// Temporary file with a name, as a path that a signal handler may unlink. A slot is taken, filled, and then shown.
struct NameSlot {
    std::atomic<bool> taken{false}, shown{false};
    char path[4096] = {};
};
constinit std::array<NameSlot, kMostFiles + 1> temporaryNames{};  // all zero: no page of it is touched before it is used

NameSlot* showName(const fs::path& path) {
    for (NameSlot& slot : temporaryNames) {
        if (slot.taken.exchange(true)) continue;
        if (path.native().size() >= sizeof slot.path) {
            slot.taken = false;
            return nullptr;
        }
        std::memcpy(slot.path, path.c_str(), path.native().size() + 1);
        slot.shown = true;
        return &slot;
    }
    return nullptr;
}

void hideName(NameSlot*& slot) {
    if (slot == nullptr) return;
    slot->shown = false;
    slot->taken = false;
    slot = nullptr;
}

// Random name, short because the target's name may already be as long as the file system allows. A killed process leaves a name that is
// never met again.
fs::path randomName(const fs::path& folder) {
    uint64_t number = 0;
    if (retried([&] { return ::getrandom(&number, sizeof number, 0); }) != sizeof number) fail(folder, "asking for random bytes");
    return folder / fmt::format(".plumb-{:016x}.part", number);
}

void syncFolder(const fs::path& folder, const fs::path& target) {
    const int fd = retried([&] { return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
    if (fd < 0) return;  // a folder may be writable and not readable; the file itself is synced
    const int rc = retried([&] { return ::fsync(fd); });
    const int error = errno;
    closeFile(fd);
    if (rc != 0 && error != EINVAL && error != EROFS) {
        errno = error;
        fail(target, "syncing the folder");
    }
}

// Final target of a symbolic link: the link stays and its target is replaced.
fs::path followLinks(fs::path path) {
    for (int hops = 0; hops < 40; ++hops) {
        std::error_code ignored;
        if (!fs::is_symlink(fs::symlink_status(path, ignored))) return path;
        const fs::path to = fs::read_symlink(path, ignored);
        if (ignored) return path;
        path = to.is_absolute() ? to : path.parent_path() / to;
    }
    return path;
}

fs::path folderOf(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

size_t mostFiles() {
    constexpr rlim_t kForOthers = 64;  // drivers, meshes, standard streams
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur > kMostFiles + kForOthers)
        return kMostFiles;
    return limit.rlim_cur <= kForOthers ? 1 : size_t(limit.rlim_cur - kForOthers);
}

}  // namespace

// File on its way to `target`. Where the file system permits it has no name until it is placed, so that a killed process leaves nothing
// behind.
struct FileBatch::Staged {
    fs::path shown, target, folder;
    fs::path name;  // temporary file; after placing, the file that was replaced
    NameSlot* slot = nullptr;
    int fd = -1;
    bool noClobber = false;
    bool placed = false;    // `target` is the new file
    bool holdsOld = false;  // `name` is the file that was replaced

    Staged() = default;
    Staged(const Staged&) = delete;
    Staged& operator=(const Staged&) = delete;
    ~Staged() {
        if (fd >= 0) closeFile(fd);
        dropName();
    }

    void dropName() noexcept {
        if (!name.empty()) ::unlink(name.c_str());
        hideName(slot);
        name.clear();
    }

    template <class Make>  // make(path): -1 and EEXIST when the name is taken
    int named(const Make& make) {
        for (int attempt = 0; attempt < kMostNames; ++attempt) {
            const fs::path candidate = randomName(folder);
            const int result = retried([&] { return make(candidate); });
            if (result != -1) {
                name = candidate;
                slot = showName(name);
                return result;
            }
            if (errno != EEXIST) break;
        }
        return -1;
    }

    bool open(mode_t mode) {
        // A nameless file is linked through /proc.
        static const bool kMayBeNameless = ::access("/proc/self/fd", X_OK) == 0;
        if (kMayBeNameless) fd = retried([&] { return ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, mode); });
        if (fd >= 0 || (kMayBeNameless && (errno == EMFILE || errno == ENFILE))) return fd >= 0;
        fd = named([&](const fs::path& path) { return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode); });
        return fd >= 0;
    }

    int link(const fs::path& to) const {
        return ::linkat(AT_FDCWD, fmt::format("/proc/self/fd/{}", fd).c_str(), AT_FDCWD, to.c_str(), AT_SYMLINK_FOLLOW);
    }

    // Gives the file the target's name. The replaced file is kept under the temporary name, where the file system can exchange names.
    void place() {
        const auto exchange = [&](unsigned flags) {
            return retried([&] { return ::renameat2(AT_FDCWD, name.c_str(), AT_FDCWD, target.c_str(), flags); }) == 0;
        };
        struct stat st {};
        const bool exists = ::lstat(target.c_str(), &st) == 0;
        if (exists && noClobber) refuseToReplace();
        if (!exists) {
            if (name.empty() ? retried([&] { return link(target); }) == 0 : exchange(RENAME_NOREPLACE)) return done(false);
            // File systems without RENAME_NOREPLACE: link(2) refuses an existing name as well.
            if (!name.empty() && errno == EINVAL && retried([&] { return ::link(name.c_str(), target.c_str()); }) == 0) {
                dropName();
                return done(false);
            }
            if (errno == EEXIST && noClobber) refuseToReplace();
            if (errno != EEXIST) fail(shown, "naming the finished file");
        }
        if (name.empty() && named([&](const fs::path& path) { return link(path); }) == -1) fail(shown, "naming the finished file");
        if (exchange(RENAME_EXCHANGE)) return done(true);
        if (!exchange(0)) fail(shown, "renaming the finished file");
        hideName(slot);
        name.clear();
        replacedForGood = true;
        done(false);
    }

    void undo() noexcept {
        if (!placed || replacedForGood) return;
        if (holdsOld)
            (void)::rename(name.c_str(), target.c_str());
        else
            ::unlink(target.c_str());
        if (holdsOld) hideName(slot);
        if (holdsOld) name.clear();
        placed = holdsOld = false;
    }

    bool replacedForGood = false;  // the file system cannot exchange names

private:
    void done(bool old) {
        placed = true;
        holdsOld = old;
        if (!old && !name.empty()) {  // renamed: the name is no longer ours
            hideName(slot);
            name.clear();
        }
    }
    [[noreturn]] void refuseToReplace() const { throw usageError(fmt::format("--no-clobber: '{}' exists", shown.string())); }
};

FileBatch::FileBatch() = default;
FileBatch::~FileBatch() { undo(); }

void FileBatch::undo() noexcept {
    while (!staged_.empty()) {
        staged_.back()->undo();
        staged_.pop_back();
    }
    bytes_ = 0;
    placed_ = false;
}

bool FileBatch::due() const {
    static const size_t kMost = mostFiles();
    return staged_.size() >= kMost || bytes_ >= kMostBytes || (!staged_.empty() && std::chrono::steady_clock::now() - first_ >= kMostWait);
}

void FileBatch::add(const fs::path& path, std::span<const std::byte> bytes, bool noClobber) {
    PLUMB_ASSERT(!placed_);
    if (path == "-") {
        if (!writeAll(STDOUT_FILENO, bytes)) fail("standard output", "writing");
        return;
    }
    checkWritable(path, noClobber);
    const fs::path target = followLinks(path);
    struct stat st {};
    const bool exists = ::stat(target.c_str(), &st) == 0;
    if (exists && !S_ISREG(st.st_mode)) {  // a device or FIFO cannot be replaced by a rename without destroying it
        const int fd = retried([&] { return ::open(target.c_str(), O_WRONLY | O_CLOEXEC); });
        if (fd < 0) fail(path, "opening");
        const bool written = writeAll(fd, bytes);
        const int error = errno;
        const bool closed = closeFile(fd) == 0;
        if (!written) errno = error;
        if (!written || !closed) fail(path, "writing");
        return;
    }
    auto staged = std::make_unique<Staged>();
    staged->shown = path;
    staged->target = target;
    staged->folder = folderOf(target);
    staged->noClobber = noClobber;
    if (!staged->open(0666)) {
        // Out of descriptors: the files that wait are finished first.
        if ((errno != EMFILE && errno != ENFILE) || staged_.empty()) fail(path, "creating a temporary file");
        commit();
        if (!staged->open(0666)) fail(path, "creating a temporary file");
    }
    if (exists) (void)::fchmod(staged->fd, st.st_mode & 07777);
    if (!writeAll(staged->fd, bytes)) fail(path, "writing");
    if (staged_.empty()) first_ = std::chrono::steady_clock::now();
    bytes_ += bytes.size();
    staged_.push_back(std::move(staged));
}

void FileBatch::place() {
    if (placed_ || staged_.empty()) return;
    try {
        parallelBands(staged_.size(), 1, uint32_t(std::min<size_t>(staged_.size(), kSyncThreads)), [&](uint64_t first, uint64_t end) {
            for (; first < end; ++first)
                if (retried([&] { return ::fsync(staged_[first]->fd); }) != 0 && errno != EINVAL) fail(staged_[first]->shown, "syncing");
        });
        std::set<fs::path> folders;
        for (const auto& staged : staged_) staged->place();
        for (const auto& staged : staged_) {
            if (closeFile(std::exchange(staged->fd, -1)) != 0) fail(staged->shown, "closing");
            if (folders.insert(staged->folder).second) syncFolder(staged->folder, staged->shown);
        }
    } catch (...) {
        undo();
        throw;
    }
    placed_ = true;
}

void FileBatch::keep() noexcept {
    PLUMB_ASSERT(placed_ || staged_.empty());
    staged_.clear();  // each file removes the one that it replaced
    bytes_ = 0;
    placed_ = false;
}

void removeTemporaryFile() noexcept {
    for (NameSlot& slot : temporaryNames)
        if (slot.shown) ::unlink(slot.path);
}

void checkWritable(const fs::path& path, bool noClobber) {
    if (path == "-") return;
    const fs::path target = followLinks(path);
    struct stat st {};
    if (::stat(target.c_str(), &st) == 0) {
        if (S_ISDIR(st.st_mode)) throw usageError(fmt::format("'{}' is a folder, not a file to write", path.string()));
        if (noClobber) throw usageError(fmt::format("--no-clobber: '{}' exists", path.string()));
        if (!S_ISREG(st.st_mode)) return;
    }
    if (::access(folderOf(target).c_str(), W_OK | X_OK) != 0) fail(path, "opening its folder");
}

void writeFileAtomically(const fs::path& path, std::span<const std::byte> bytes, bool noClobber) {
    FileBatch alone;
    alone.add(path, bytes, noClobber);
    alone.commit();
}

void writeFrame(const fs::path& path, const Frame& frame, uint32_t planes, const WriteOptions& options, const Metadata& metadata) {
    FileBatch alone;
    alone.addFrame(path, frame, planes, options, metadata);
    alone.commit();
}

void FileBatch::addFrame(const fs::path& path, const Frame& frame, uint32_t planes, const WriteOptions& options, const Metadata& metadata) {
    const std::string extension = path == "-" ? ".png" : lowerExtension(path);
    std::vector<std::byte> bytes;
    if (extension == ".png") {
        bytes = encodePng(frame, options, metadata);
    } else if (extension == ".exr") {
        bytes = encodeExr(frame, planes, metadata, options.alpha);
    } else if (extension == ".npy") {
        if (planes == 0 || (planes & (planes - 1)) != 0)
            throw usageError(fmt::format("'{}': an .npy file holds exactly one plane", path.string()));
        bytes = encodeNpy(frame, Plane(planes));
    } else {
        throw usageError(fmt::format("'{}': pictures are written as .png, .exr or .npy", path.string()));
    }
    add(path, bytes, options.noClobber);
}

}  // namespace plumb
