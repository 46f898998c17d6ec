// SPDX-License-Identifier: MIT
// Files that are there together or not at all. Each is written to a temporary file in its own folder. place() syncs all of them and gives
// them their names, keep() makes that final. Before keep() a failure removes the new files and restores the replaced ones.
#pragma once

#include "pipeline/image/image.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace plumb {

class FileBatch {
public:
    FileBatch();
    FileBatch(const FileBatch&) = delete;
    FileBatch& operator=(const FileBatch&) = delete;
    ~FileBatch();  // undoes every file that was not kept

    // Adds a file. Standard output ("-"), devices and FIFOs are written at once. Throws as writeFileAtomically() does.
    void add(const std::filesystem::path&, std::span<const std::byte>, bool noClobber);
    void addFrame(const std::filesystem::path&, const Frame&, uint32_t planes, const WriteOptions&, const Metadata&);  // as writeFrame

    bool empty() const { return staged_.empty(); }
    // True when enough is waiting to be placed now: files, bytes, or seconds since the first. So a long list is never lost as a whole.
    bool due() const;

    void place();          // all files, or none and an Error
    void keep() noexcept;  // replaced files are gone for good; the batch is empty again
    void commit() {
        place();
        keep();
    }

private:
    struct Staged;
    void undo() noexcept;

    std::vector<std::unique_ptr<Staged>> staged_;
    uint64_t bytes_ = 0;
    bool placed_ = false;
    std::chrono::steady_clock::time_point first_;
};

}  // namespace plumb
