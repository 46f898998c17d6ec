// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_reading.h"

#include "pipeline/scene/text.h"

#include <algorithm>
#include <vector>

namespace plumb::gltf {

void Reading::ignore(const Value& at, const std::string& what) const {
    if (options.strict) at.refuse(what + ": not drawn, and --strict refuses that");
    std::vector<std::string>& ignored = scene.ignored;
    if (std::find(ignored.begin(), ignored.end(), what) == ignored.end()) ignored.push_back(what);
}

void Reading::ignoreExtensions(const Value& owner, std::initializer_list<std::string_view> known) const {
    const auto extensions = owner.find("extensions");
    if (!extensions) return;
    for (const std::string& name : extensions->keys())
        if (std::find(known.begin(), known.end(), name) == known.end()) ignore(*extensions, "extension " + printable(name, 64));
}

}  // namespace plumb::gltf
