// SPDX-License-Identifier: MIT
#include "pipeline/compare/picture.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace plumb {

Picture readPicture(const std::filesystem::path& path) {
    const std::string bytes = readWholeFile(path, kMostPictureBytes);
    Picture picture;
    if (bytes.starts_with("\x89PNG\r\n\x1a\n"))
        picture = readPngPicture(path, bytes);
    else if (bytes.starts_with("\x76\x2f\x31\x01"))
        picture = readExrPicture(path, bytes);
    else if (bytes.starts_with("\x93NUMPY"))
        picture = readNpyPicture(path, bytes);
    else
        throw inputError(locationOfByte(path, 0), "neither a PNG nor an EXR nor an NPY: its first bytes belong to none of them");
    picture.path = path.string();
    picture.sha256 = sha256Hex(std::as_bytes(std::span(bytes)));
    return picture;
}

std::string describe(const Layer& layer) {
    if (layer.kind == LayerKind::id) return layer.channels == 1 ? "ids" : fmt::format("{} channels, ids", layer.channels);
    const uint32_t shown = layer.channels - (layer.alpha ? 1 : 0);
    const std::string channels = !layer.colour ? fmt::format("{} channel{}", layer.channels, layer.channels == 1 ? "" : "s")
                                               : fmt::format("{}{}", shown == 1 ? "grey" : "RGB", layer.alpha ? " and alpha" : "");
    const std::string type =
        layer.kind == LayerKind::code ? fmt::format("{} bits", layer.fullScale > 255 ? 16 : 8) : fmt::format("float{}", layer.precision);
    return fmt::format("{}, {}{}", channels, type, layer.colour ? layer.linear ? ", linear" : ", sRGB" : "");
}

}  // namespace plumb
