// SPDX-License-Identifier: MIT
#include "pipeline/command/capsules.h"

#include "host/error.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/scene/text.h"
#include "pipeline/suite/capsule.h"
#include "pipeline/suite/reduce.h"

#include <fmt/core.h>
#include <unistd.h>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <system_error>

namespace plumb {

namespace fs = std::filesystem;

namespace {

// A folder beside the wanted one, which takes its name when all files are in it; removed otherwise.
class NewFolder {
public:
    explicit NewFolder(const fs::path& wanted) : wanted_(wanted), made_(wanted) {
        made_ += fmt::format(".part{}", getpid());
        std::error_code error;
        fs::create_directories(made_, error);
        if (error) throw renderError(fmt::format("'{}' cannot be made: {}", printablePath(made_), error.message()));
    }
    ~NewFolder() {
        std::error_code ignored;
        if (!placed_) fs::remove_all(made_, ignored);
    }
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;

    const fs::path& path() const { return made_; }
    void place() {
        std::error_code error;
        fs::rename(made_, wanted_, error);
        if (error) throw renderError(fmt::format("'{}' cannot be made: {}", printablePath(wanted_), error.message()));
        placed_ = true;
    }

private:
    const fs::path wanted_;
    fs::path made_;
    bool placed_ = false;
};

}  // namespace

void refuseCapsuleFolder(const Options& options) {
    if (options.capsule.empty()) return;
    const fs::path folder = options.capsule;
    std::error_code ignored;
    if (fs::exists(folder, ignored) && !(fs::is_directory(folder, ignored) && fs::is_empty(folder, ignored)))
        throw usageError(fmt::format("--capsule: '{}' is there already; accepted: a folder that is new or empty", printablePath(folder)));
}

std::string writeCapsule(const Options& options, Device& device, const Scene& scene, const RenderRequest& request, const std::string& pass,
                         const fs::path& folder, Progress& progress) {
    const suite::Reduced reduced =
        suite::reduce(device, scene, request, pass, std::chrono::milliseconds(int64_t(options.reduceMs)), [&](double share) {
            progress.update(share);
            stopIfInterrupted();
        });
    const std::optional<suite::Capsule> capsule = suite::capsuleOf(device, reduced, toolJson());
    if (!capsule)
        return fmt::format("no capsule: the sides of the reduced picture agree now, so the device does not do the same each time");
    const std::map<std::string, std::string> files = suite::filesOf(*capsule);
    uint64_t bytes = 0;
    NewFolder made(folder);
    FileBatch batch;
    for (const auto& [name, text] : files) {
        batch.add(made.path() / name, std::as_bytes(std::span(text)), false);
        bytes += text.size();
    }
    batch.commit();
    made.place();
    return fmt::format("capsule {}: {} in {}, {} of {} triangles, {} files, {} bytes; `plumb replay {}` runs it again",
                       printablePath(folder), capsule->pass, capsule->dispatch.module, reduced.triangles, reduced.trianglesBefore,
                       files.size(), bytes, printablePath(folder));
}

}  // namespace plumb
