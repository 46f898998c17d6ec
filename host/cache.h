// SPDX-License-Identifier: MIT
// Files of what was measured once on this machine. A cache that cannot be read or written is none, and no failure.
#pragma once

#include <filesystem>
#include <string>

namespace plumb {

// $XDG_CACHE_HOME/plumbline, or .cache/plumbline in the home folder; empty where neither is known.
std::filesystem::path cacheFolder();
// Bytes of a file; empty where it cannot be read.
std::string readCache(const std::filesystem::path& path);
// Writes the file whole or not at all: a temporary file in the same folder, renamed.
void writeCache(const std::filesystem::path& path, const std::string& text);

}  // namespace plumb
