// SPDX-License-Identifier: MIT
// Frames as files. Everything is written to a temporary file in the same folder, synced, then renamed.
#pragma once

#include "pipeline/render/frame.h"

#include <filesystem>
#include <map>
#include <span>
#include <string>

namespace plumb {

using Metadata = std::map<std::string, std::string>;  // provenance and conventions; PNG text chunks, EXR attributes

struct WriteOptions {
    bool noClobber = false;   // an existing file is refused (exit 2)
    bool alpha = false;       // PNG: RGBA instead of RGB
    int bits = 8;             // PNG: 8, or 16 (needs kPlaneLinear; sRGB or linear as metadata "encoding" says)
    bool linear = false;      // PNG 16: no sRGB curve
};

// "-" writes to stdout. Throws Error(failed) on disk faults (old file intact, temporary removed), Error(usage) for noClobber.
void writeFileAtomically(const std::filesystem::path&, std::span<const std::byte>, bool noClobber);
std::vector<std::byte> encodePng(const Frame&, const WriteOptions&, const Metadata&);
std::vector<std::byte> encodeExr(const Frame&, uint32_t planes, const Metadata&);   // linear colour + chosen planes, float32/uint32
std::vector<std::byte> encodeNpy(const Frame&, Plane plane);                        // one plane: shape (H, W) or (H, W, C)
// By extension (.png, .exr, .npy); `planes`: what goes into an EXR; NPY takes exactly one.
void writeFrame(const std::filesystem::path&, const Frame&, uint32_t planes, const WriteOptions&, const Metadata&);
Frame contactSheet(std::span<const Frame> frames, uint32_t columns, uint32_t background);
std::string sha256Hex(std::span<const std::byte>);
// Reads a PNG back (tests, verify's pictures): RGBA8.
Frame readPng(const std::filesystem::path&);

}  // namespace plumb
