// SPDX-License-Identifier: MIT
// What the end of a file's name says of its format.
#pragma once

#include <filesystem>
#include <string>

namespace plumb {

// ".PNG" is ".png": ASCII letters alone, without a locale.
inline std::string lowerExtension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return extension;
}

}  // namespace plumb
