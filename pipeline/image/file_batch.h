// SPDX-License-Identifier: MIT
// Files that are there together or not at all. Each is written to a temporary file in its own folder; place() syncs all of them and gives them
// their names, keep() ends the matter. Until then whatever fails takes the new files away and puts those that they replaced back.
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
    ~FileBatch();  // undoes what was not kept

    // Standard output ("-"), devices and FIFOs are written at once. Errors are those of writeFileAtomically.
    void add(const std::filesystem::path&, std::span<const std::byte>, bool noClobber);
    void addFrame(const std::filesystem::path&, const Frame&, uint32_t planes, const WriteOptions&, const Metadata&);  // as writeFrame

    bool empty() const { return staged_.empty(); }
    // Enough wait to be placed now: files, bytes, or seconds since the first. A long list is so never lost as a whole.
    bool due() const;

    void place();          // all of them, or none and an Error
    void keep() noexcept;  // what place() replaced is gone for good; the batch is empty again
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
