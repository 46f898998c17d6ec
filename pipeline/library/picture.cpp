// SPDX-License-Identifier: MIT
#include "pipeline/library/picture.h"

#include "host/error.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/scene/extension.h"

#include <fmt/core.h>
#include <cstdint>
#include <filesystem>
#include <string>

namespace plumb {

void Picture::save(const std::filesystem::path& path, uint32_t asked) const {
    const std::string extension = lowerExtension(path);
    if (frame.rgba.empty()) throw usageError(fmt::format("'{}': the picture is empty: nothing was drawn into it", path.string()));
    const bool exr = extension == ".exr";
    // An EXR holds linear colour, never the encoded one, and no plane of verify's.
    constexpr uint32_t kInExr = ~uint32_t(kPlaneColour | kPlaneZ | kPlaneTriangle);
    uint32_t chosen = asked;
    if (chosen == 0) chosen = exr ? planes & kInExr : uint32_t(kPlaneColour);
    if (exr && chosen == 0)
        throw usageError(
            fmt::format("'{}': an .exr file holds linear colour and measures: ask for such planes when drawing", path.string()));
    uint32_t needed = chosen;
    if (exr && (needed & kPlaneColour)) needed = (needed & ~uint32_t(kPlaneColour)) | kPlaneLinear;
    forEachPlane([&](const auto& row, auto) {
        if (needed & row.plane & ~planes)
            throw usageError(fmt::format("'{}': the picture has no plane '{}': ask for it when drawing", path.string(), row.name));
    });
    WriteOptions options;
    options.alpha = transparent;
    options.linear = encoding == Encoding::linear;
    FileBatch file;
    file.addFrame(path, frame, chosen, options, {{"Software", "plumbline " PLUMB_VERSION}, {"encoding", nameOf(encoding)}});
    file.commit();
}

}  // namespace plumb
