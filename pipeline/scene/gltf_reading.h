// SPDX-License-Identifier: MIT
// What the parts of the glTF reader share: the scene that they fill, and what they leave out of it.
#pragma once

#include "pipeline/scene/gltf_value.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/scene.h"
#include "pipeline/scene/tolerance.h"

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>

namespace plumb::gltf {

struct Reading {
    const LoadOptions& options;
    Scene& scene;
    Tolerance& tolerance;
    mutable size_t cameras = 0;  // perspective ones so far

    // Names a kind of what the file asks for and no pass draws, once. With `strict` it is refused at `at`.
    void ignore(const Value& at, const std::string& what) const;
    // Passes over one more of `kind`, by the rule of tolerance.h.
    void pass(const Value& at, std::string_view kind) const {
        tolerance.pass(kind, [&] { return at.location(); });
    }
    // Ignores each extension of `owner` that is not `known`.
    void ignoreExtensions(const Value& owner, std::initializer_list<std::string_view> known) const;
};

}  // namespace plumb::gltf
