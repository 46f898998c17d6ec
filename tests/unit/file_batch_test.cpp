// SPDX-License-Identifier: MIT
// Files that are there together or not at all, while the calls of the system fail: this program has its own open, fsync, linkat and renameat2.
#include "pipeline/image/file_batch.h"
#include "host/error.h"
#include "pipeline/image/image.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

struct Faults {
    bool noNameless = false;                     // O_TMPFILE is not supported
    bool noExchange = false;                     // RENAME_EXCHANGE is not supported
    bool noNoReplace = false;                    // nor RENAME_NOREPLACE
    bool interrupts = false;                     // each call is interrupted once before it is made
    int fileSync = 0, folderSync = 0, name = 0;  // errno of the n-th such call from now on
    int after = 0;                               // calls that still succeed
};
Faults faults;
struct Counts {
    std::atomic<int> fileSyncs{0}, folderSyncs{0};
};
Counts counts;

int refuse(int error) {
    errno = error;
    return -1;
}

// True once for each call when interruptions are asked for.
bool interrupted() {
    static thread_local bool before = false;
    if (!faults.interrupts) return false;
    before = !before;
    return before;
}

bool fails(int error) { return error != 0 && faults.after-- <= 0; }

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, int) : 0;
    va_end(rest);
    if (interrupted()) return refuse(EINTR);
    if (faults.noNameless && (flags & O_TMPFILE) == O_TMPFILE) return refuse(EOPNOTSUPP);
    return int(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

int fsync(int fd) {
    if (interrupted()) return refuse(EINTR);
    struct stat st {};
    ::fstat(fd, &st);
    const bool folder = S_ISDIR(st.st_mode);
    ++(folder ? counts.folderSyncs : counts.fileSyncs);
    if (fails(folder ? faults.folderSync : faults.fileSync)) return refuse(folder ? faults.folderSync : faults.fileSync);
    return int(::syscall(SYS_fsync, fd));
}

int linkat(int fromFolder, const char* from, int toFolder, const char* to, int flags) noexcept {
    if (interrupted()) return refuse(EINTR);
    if (fails(faults.name)) return refuse(faults.name);
    return int(::syscall(SYS_linkat, fromFolder, from, toFolder, to, flags));
}

int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) noexcept {
    if (interrupted()) return refuse(EINTR);
    if (faults.noExchange && (flags & RENAME_EXCHANGE) != 0) return refuse(EINVAL);
    if (faults.noNoReplace && (flags & RENAME_NOREPLACE) != 0) return refuse(EINVAL);
    if (fails(faults.name)) return refuse(faults.name);
    return int(::syscall(SYS_renameat2, fromFolder, from, toFolder, to, flags));
}

}  // extern "C"

namespace plumb {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> bytesOf(const std::string& text) {
    const auto* p = reinterpret_cast<const std::byte*>(text.data());
    return {p, p + text.size()};
}

class FileBatches : public testing::Test {
protected:
    FileBatches() {
        std::string name = (fs::temp_directory_path() / "plumb-batch-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        fs::create_directory(folder_ / "other");
    }
    ~FileBatches() override {
        faults = {};
        fs::remove_all(folder_);
    }
    fs::path at(const std::string& name) const { return folder_ / name; }
    std::string read(const std::string& name) const {
        std::ifstream in(at(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    // Everything below the folder but the folders, temporary files as well.
    std::set<std::string> files() const {
        std::set<std::string> names;
        for (const auto& entry : fs::recursive_directory_iterator(folder_))
            if (!entry.is_directory()) names.insert(fs::relative(entry.path(), folder_).string());
        return names;
    }
    void add(FileBatch& batch, const std::string& name, const std::string& text, bool noClobber = false) {
        batch.add(at(name), bytesOf(text), noClobber);
    }
    template <class Call>
    static Exit exitOf(const Call& call) {
        try {
            call();
        } catch (const Error& error) {
            return error.exit();
        }
        return Exit::done;
    }

    fs::path folder_;
};

// The ways in which a file system may lack what is used where it is there.
constexpr Faults kWays[] = {{},
                            {.noNameless = true},
                            {.noExchange = true},
                            {.noNameless = true, .noExchange = true},
                            {.noNameless = true, .noExchange = true, .noNoReplace = true}};

TEST_F(FileBatches, AreThereTogetherOnEveryFileSystem) {
    for (const Faults& way : kWays)
        for (const bool interrupts : {false, true}) {
            faults = way;
            faults.interrupts = interrupts;
            add(*std::make_unique<FileBatch>(), "a", "never kept");
            EXPECT_EQ(files(), std::set<std::string>{});
            writeFileAtomically(at("old"), bytesOf("before"), false);
            ::chmod(at("old").c_str(), 0640);
            {
                FileBatch batch;
                add(batch, "old", "after");
                add(batch, "a", "first");
                add(batch, "other/b", "second");
                EXPECT_EQ(read("old"), "before");
                EXPECT_EQ(files().count("a"), 0u);
                batch.commit();
                EXPECT_TRUE(batch.empty());
                add(batch, "a", "third");  // the batch is as new
                batch.commit();
            }
            EXPECT_EQ(files(), (std::set<std::string>{"a", "old", "other/b"}));
            EXPECT_EQ(read("old") + read("a") + read("other/b"), "afterthirdsecond");
            struct stat st {};
            ::stat(at("old").c_str(), &st);
            EXPECT_EQ(st.st_mode & 0777, 0640u);
            for (const char* name : {"a", "old", "other/b"}) fs::remove(at(name));
        }
}

TEST_F(FileBatches, PlacedFilesAreTakenBackUnlessTheyAreKept) {
    for (const Faults& way : kWays) {
        faults = way;
        if (way.noExchange) continue;  // there is nothing to take back with
        writeFileAtomically(at("old"), bytesOf("before"), false);
        {
            FileBatch batch;
            add(batch, "old", "after");
            add(batch, "new", "x");
            batch.place();
            EXPECT_EQ(read("old"), "after");
            EXPECT_EQ(read("new"), "x");
        }
        EXPECT_EQ(read("old"), "before");
        EXPECT_EQ(files(), std::set<std::string>{"old"});
    }
}

// Whatever call fails, and whichever: the old files are there with what they held, the new ones are not, and nothing else is.
TEST_F(FileBatches, AFailureLeavesEverythingAsItWas) {
    for (const Faults& way : kWays)
        for (int Faults::*const what : {&Faults::fileSync, &Faults::folderSync, &Faults::name})
            for (const int error : {EIO, ENOSPC, EDQUOT})
                for (int after = 0; after < 4; ++after) {
                    if (way.noExchange && what != &Faults::fileSync) continue;
                    faults = {};
                    for (const char* name : {"old", "other/old"}) writeFileAtomically(at(name), bytesOf("before"), false);
                    bool failed = false;
                    {
                        FileBatch batch;
                        for (const char* name : {"old", "new", "other/old", "other/new"}) add(batch, name, "after");
                        faults = way;
                        faults.*what = error;
                        faults.after = after;
                        failed = exitOf([&] { batch.commit(); }) == Exit::failed;
                    }
                    faults = {};
                    if (!failed) {  // there were no more calls of this kind
                        EXPECT_GE(after, 2);
                        EXPECT_EQ(read("old") + read("other/new"), "afterafter");
                    } else {
                        EXPECT_EQ(read("old") + read("other/old"), "beforebefore") << error << " after " << after;
                        EXPECT_EQ(files(), (std::set<std::string>{"old", "other/old"})) << error << " after " << after;
                    }
                    for (const char* name : {"new", "other/new"}) fs::remove(at(name));
                }
}

TEST_F(FileBatches, NoClobberRefusesWhatAppearedInBetween) {
    for (const Faults& way : kWays) {
        faults = way;
        FileBatch batch;
        add(batch, "a", "ours", true);
        add(batch, "b", "ours", true);
        std::ofstream(at("b")) << "theirs";
        EXPECT_EQ(exitOf([&] { batch.commit(); }), Exit::usage);
        EXPECT_EQ(files(), std::set<std::string>{"b"});
        EXPECT_EQ(read("b"), "theirs");
        fs::remove(at("b"));
    }
}

TEST_F(FileBatches, SyncEachFileAndEachFolderOnce) {
    FileBatch batch;
    for (int i = 0; i < 40; ++i) add(batch, fmt::format("{}{}", i % 2 ? "other/" : "", i), "x");
    counts.fileSyncs = counts.folderSyncs = 0;
    batch.commit();
    EXPECT_EQ(counts.fileSyncs, 40);
    EXPECT_EQ(counts.folderSyncs, 2);
}

TEST_F(FileBatches, AreDueBeforeDescriptorsRunOut) {
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    const rlimit few{16, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
    {
        FileBatch batch;
        for (int i = 0; i < 40; ++i) add(batch, std::to_string(i), "x");  // those that wait are finished when no descriptor is left
        batch.commit();
    }
    ::setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_EQ(files().size(), 40u);
}

TEST_F(FileBatches, WhatAKilledProcessLeftIsNoObstacle) {
    faults.noNameless = true;
    for (int i = 0; i < 200; ++i) std::ofstream(at(fmt::format(".plumb-{}-{}.part", ::getpid(), i))) << "stale";
    writeFileAtomically(at("a"), bytesOf("x"), false);
    EXPECT_EQ(read("a"), "x");
    EXPECT_EQ(files().size(), 201u);
}

// A process that is ended has no file without a name left behind; the handler of a second signal takes those with one away.
TEST_F(FileBatches, NothingIsLeftOfAProcessThatIsEnded) {
    for (const bool noNameless : {false, true}) {
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            faults.noNameless = noNameless;
            FileBatch batch;
            for (int i = 0; i < 5; ++i) add(batch, std::to_string(i), "x");
            if (noNameless) removeTemporaryFile();
            ::_exit(0);
        }
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        EXPECT_EQ(files(), std::set<std::string>{}) << noNameless;
    }
}

}  // namespace
}  // namespace plumb
