// SPDX-License-Identifier: MIT
// Extension of a file's name, by which its format is known.
#pragma once

#include <filesystem>
#include <string>

namespace plumb {

// Extension in lower case: ".PNG" is ".png". ASCII letters only, without a locale.
inline std::string lowerExtension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return extension;
}

}  // namespace plumb
