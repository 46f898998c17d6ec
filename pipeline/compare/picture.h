// SPDX-License-Identifier: MIT
// Picture read from a file, as numbers, for `plumb diff`. Row 0 on top.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// Most samples of one picture, all layers together: 7680x4320 RGBA. As binary64 they take 1 GiB.
inline constexpr uint64_t kMostSamples = uint64_t(1) << 27;
inline constexpr uint32_t kLargestPictureSide = 65536;
inline constexpr uint64_t kMostPictureBytes = uint64_t(1) << 31;  // largest file
inline constexpr uint32_t kMostChannels = 64;                     // most channels of one picture

enum class LayerKind {
    code,  // integers 0 to fullScale; a sample counts as code / fullScale
    real,  // floating point; a sample counts as it is
    id     // integers that are equal or not
};

struct Layer {
    std::string name;  // "color", "depth", "normal", "array", ... as in docs/outputs.md, else the name in the file
    LayerKind kind = LayerKind::real;
    bool colour = false;      // channels are grey or R G B, then alpha where there is one
    bool linear = false;      // colour: in proportion to light, else encoded with the sRGB curve
    bool alpha = false;       // colour: the last channel is alpha, 0 to fullScale
    bool associated = false;  // alpha: the colour is multiplied by it (EXR), else straight (PNG)
    uint32_t channels = 1;
    double fullScale = 1;         // code: 255 or 65535
    int precision = 32;           // real: bits of a sample in the file, 16, 32 or 64
    std::vector<double> samples;  // height x width x channels; every type that is read is exact in binary64
};

struct Picture {
    std::string path, format;  // format: "png", "exr" or "npy", by content
    std::string sha256;        // SHA-256 of the file
    uint32_t width = 0, height = 0;
    int32_t left = 0, top = 0;  // first column and row of an EXR's data window
    std::vector<Layer> layers;  // not empty; names differ
};

// Reads a regular file. Refuses with one line (Error(input)): unreadable or truncated files, foreign formats, more than the limits above,
// and contents without a meaning here (see the readers). No memory is taken for samples that the file does not have, but for one block of
// rows.
Picture readPicture(const std::filesystem::path&);

// Readers of the bytes of a file; `path` names it in refusals.
Picture readPngPicture(const std::filesystem::path& path,
                       const std::string& bytes);  // every PNG: 1 to 16 bits, grey, RGB, palette, alpha, interlaced
Picture readExrPicture(const std::filesystem::path& path,
                       const std::string& bytes);  // one part, flat, no subsampling; half, float, uint
Picture readNpyPicture(const std::filesystem::path& path,
                       const std::string& bytes);  // (H, W) or (H, W, C); versions 1 to 3; not objects, not complex

// Layer in words: "RGB, 8 bits", "3 channels, float32", "ids".
std::string describe(const Layer&);

}  // namespace plumb
