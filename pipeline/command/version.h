// SPDX-License-Identifier: MIT
// Version of the build: made by version.cmake and CMakeLists.txt of this folder.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace plumb {

const char* gitRevision();  // `git describe` of the source tree at build time, "unknown" outside a repository
std::span<const std::pair<std::string_view, std::string_view>> spirvModules();  // name, SHA-256 of the words

}  // namespace plumb
