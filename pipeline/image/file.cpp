// SPDX-License-Identifier: MIT
// Files that are whole or absent: temporary file in the same folder, synced, renamed (docs/outputs.md).
#include "host/error.h"
#include "pipeline/image/image.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/core.h>
#include <mutex>
#include <span>
#include <string>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;

// The one temporary file that exists at a time, as a path that a signal handler may unlink.
std::mutex writing;
char temporaryPath[4096];
std::atomic<bool> temporaryExists{false};

[[noreturn]] void fail(const fs::path& path, const char* doing) {
    throw renderError(fmt::format("cannot write '{}': {}: {}", path.string(), doing, std::strerror(errno)));
}

// write(2) may be short or interrupted; an error is left in errno.
bool writeAll(int fd, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), std::min<size_t>(bytes.size(), size_t(1) << 24));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return false;
        bytes = bytes.subspan(size_t(n));
    }
    return true;
}

// Owns the temporary file: unlinked unless it was renamed.
class Temporary {
public:
    Temporary(const fs::path& folder, const fs::path& target, mode_t mode) : target_(target) {
        for (int attempt = 0; attempt < 100; ++attempt) {
            // A short name of its own: the target's name may already be as long as the file system allows.
            path_ = folder / fmt::format(".plumb-{}-{}.part", ::getpid(), attempt);
            if (path_.native().size() >= sizeof temporaryPath) {
                errno = ENAMETOOLONG;
                break;
            }
            fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
            if (fd_ >= 0 || errno != EEXIST) break;
        }
        if (fd_ < 0) fail(target_, "creating a temporary file");
        std::memcpy(temporaryPath, path_.c_str(), path_.native().size() + 1);
        temporaryExists = true;
    }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    ~Temporary() {
        if (fd_ >= 0) ::close(fd_);
        if (!path_.empty()) ::unlink(path_.c_str());
        temporaryExists = false;
    }
    int fd() const { return fd_; }
    void close() {
        const int fd = std::exchange(fd_, -1);
        if (::close(fd) != 0) fail(target_, "closing");
    }
    void moveTo(const fs::path& target, bool noClobber) {
        if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target.c_str(), noClobber ? RENAME_NOREPLACE : 0) == 0) {
            path_.clear();
            return;
        }
        // File systems without RENAME_NOREPLACE: link(2) refuses an existing name as well, and the destructor takes the temporary one away.
        if (noClobber && errno != EEXIST && ::link(path_.c_str(), target.c_str()) == 0) return;
        if (noClobber && errno == EEXIST) throw usageError(fmt::format("--no-clobber: '{}' exists", target_.string()));
        fail(target_, "renaming the finished file");
    }

private:
    fs::path target_, path_;
    int fd_ = -1;
};

void syncFolder(const fs::path& folder, const fs::path& target) {
    const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;  // a folder may be writable and not readable; the file itself is synced
    const int rc = ::fsync(fd);
    const int error = errno;
    ::close(fd);
    if (rc != 0 && error != EINVAL && error != EROFS) {
        errno = error;
        fail(target, "syncing the folder");
    }
}

// Where a symbolic link finally points, so that the link stays and its target is replaced.
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

void writeStream(int fd, const fs::path& name, std::span<const std::byte> bytes) {
    if (!writeAll(fd, bytes)) fail(name, "writing");
}

}  // namespace

void removeTemporaryFile() noexcept {
    if (temporaryExists) ::unlink(temporaryPath);
}

void checkWritable(const fs::path& path, bool noClobber) {
    if (path == "-") return;
    const fs::path target = followLinks(path);
    struct stat st{};
    if (::stat(target.c_str(), &st) == 0) {
        if (S_ISDIR(st.st_mode)) throw usageError(fmt::format("'{}' is a folder, not a file to write", path.string()));
        if (noClobber) throw usageError(fmt::format("--no-clobber: '{}' exists", path.string()));
        if (!S_ISREG(st.st_mode)) return;
    }
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (::access(folder.c_str(), W_OK | X_OK) != 0) fail(path, "opening its folder");
}

void writeFileAtomically(const fs::path& path, std::span<const std::byte> bytes, bool noClobber) {
    if (path == "-") return writeStream(STDOUT_FILENO, "standard output", bytes);
    checkWritable(path, noClobber);
    const fs::path target = followLinks(path);
    struct stat st{};
    const bool exists = ::stat(target.c_str(), &st) == 0;
    if (exists && !S_ISREG(st.st_mode)) {  // a device or FIFO cannot be replaced by a rename without destroying it
        const int fd = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
        if (fd < 0) fail(path, "opening");
        const bool written = writeAll(fd, bytes);
        const int error = errno;
        const bool closed = ::close(fd) == 0;
        if (!written) errno = error;
        if (!written || !closed) fail(path, "writing");
        return;
    }
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    const std::lock_guard turn(writing);
    Temporary temporary(folder, path, 0666);
    if (exists) (void)::fchmod(temporary.fd(), st.st_mode & 07777);
    if (!writeAll(temporary.fd(), bytes)) fail(path, "writing");
    if (::fsync(temporary.fd()) != 0 && errno != EINVAL) fail(path, "syncing");
    temporary.close();
    temporary.moveTo(target, noClobber);
    syncFolder(folder, path);
}

void writeFrame(const fs::path& path, const Frame& frame, uint32_t planes, const WriteOptions& options, const Metadata& metadata) {
    const std::string extension = path == "-" ? ".png" : path.extension().string();
    std::vector<std::byte> bytes;
    if (extension == ".png") {
        bytes = encodePng(frame, options, metadata);
    } else if (extension == ".exr") {
        bytes = encodeExr(frame, planes, metadata, options.alpha);
    } else if (extension == ".npy") {
        if (planes == 0 || (planes & (planes - 1)) != 0) throw usageError(fmt::format("'{}': an .npy file holds exactly one plane", path.string()));
        bytes = encodeNpy(frame, Plane(planes));
    } else {
        throw usageError(fmt::format("'{}': pictures are written as .png, .exr or .npy", path.string()));
    }
    writeFileAtomically(path, bytes, options.noClobber);
}

}  // namespace plumb
