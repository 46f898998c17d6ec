// SPDX-License-Identifier: MIT
// Frames as files. Every file is written to a temporary file in the same folder, synced, then renamed.
#pragma once

#include "pipeline/render/frame.h"
#include "pipeline/scene/sha256.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace plumb {

using Metadata = std::map<std::string, std::string>;  // provenance and conventions; PNG text chunks, EXR attributes

struct WriteOptions {
    bool noClobber = false;  // an existing file is refused (exit 2)
    bool alpha = false;      // PNG: RGBA instead of RGB
    int bits = 8;            // PNG: 8, or 16 (needs kPlaneLinear; sRGB or linear as metadata "encoding" says)
    bool linear = false;     // PNG 16: no sRGB curve
    // PNG: one channel of 8 bits, the red bytes as they are. They are a quantity rather than a colour, so there is neither curve nor gamma.
    bool grey = false;
};

// Writes a file. "-" writes to stdout. Throws Error(failed) on disk faults: the old file is intact, the temporary one removed. Throws
// Error(usage) for noClobber.
// A symbolic link stays and its target is replaced; a device or FIFO is written in place.
void writeFileAtomically(const std::filesystem::path&, std::span<const std::byte>, bool noClobber);
// Throws the refusals of writeFileAtomically() that can be known before anything is rendered.
void checkWritable(const std::filesystem::path&, bool noClobber);
// Unlinks the temporary files that have names. Async-signal-safe; the process must end right after.
void removeTemporaryFile() noexcept;
std::vector<std::byte> encodePng(const Frame&, const WriteOptions&, const Metadata&);
// EXR of linear colour and the chosen planes, float32/uint32: R G B [A], Z, distance, normal.X/Y/Z, object_id, primitive_id. kPlaneColour
// and kPlaneLinear both mean the linear colour. With `alpha`, colour is multiplied by A, as EXR readers expect.
std::vector<std::byte> encodeExr(const Frame&, uint32_t planes, const Metadata&, bool alpha = false);
// NPY 1.0 of one plane: colour (H, W, 4) |u1, linear and normal (H, W, 3) <f4, ids (H, W) <u4, the others (H, W) <f4.
std::vector<std::byte> encodeNpy(const Frame&, Plane plane);
// Writes a frame in the format of the extension (.png, .exr, .npy). `planes`: the planes of an EXR; NPY takes exactly one.
void writeFrame(const std::filesystem::path&, const Frame&, uint32_t planes, const WriteOptions&, const Metadata&);
// Contact sheet: frames of equal size in rows of `columns` (0: as square as can be), in order. Left-over cells are `background`: a packed
// pixel, and its linear colour for sheets with a linear plane. Other planes are dropped.
Frame contactSheet(std::span<const Frame> frames, uint32_t columns, uint32_t background, std::array<float, 3> backgroundLinear = {});
// Frame read back from a PNG (tests, verify's pictures): RGBA8. Regular files of at most 2^28 pixels; Error(input) otherwise.
Frame readPng(const std::filesystem::path&);

}  // namespace plumb
