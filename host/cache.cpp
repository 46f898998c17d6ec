// SPDX-License-Identifier: MIT
#include "host/cache.h"

#include <fmt/core.h>
#include <unistd.h>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

namespace plumb {

std::filesystem::path cacheFolder() {
    if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg == '/') return std::filesystem::path(xdg) / "plumbline";
    if (const char* home = std::getenv("HOME"); home && *home == '/') return std::filesystem::path(home) / ".cache" / "plumbline";
    return {};
}

std::string readCache(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void writeCache(const std::filesystem::path& path, const std::string& text) {
    std::error_code ignored;
    std::filesystem::create_directories(path.parent_path(), ignored);
    std::filesystem::path temporary = path;
    temporary += fmt::format(".{}", getpid());
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file << text;
    file.close();
    if (file)
        std::filesystem::rename(temporary, path, ignored);
    else
        std::filesystem::remove(temporary, ignored);
}

}  // namespace plumb
