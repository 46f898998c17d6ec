// SPDX-License-Identifier: MIT
// The one writer of a picture's planes, for every way to draw and for both sides. Colours come as a device leaves them or as samples that host code
// holds; every other plane comes pixel by pixel from what is seen there.
#pragma once

#include "pipeline/render/prepare.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

namespace plumb {

// The planes that show what is seen at a pixel: all but its colours and what is judged of them.
inline constexpr uint32_t kPlanesSeen = ~uint32_t(kPlaneColour | kPlaneLinear | kPlanesJudged);

// What the planes show of a pixel where nothing is drawn. A way to draw derives its own from it and hides the functions whose answers it knows; only
// those of planes that are asked for are called. The calls are resolved when the writer is compiled: there is no virtual call a pixel.
struct SeenNothing {
    float z() const { return 0; }
    float depth() const { return std::numeric_limits<float>::infinity(); }
    float distance() const { return std::numeric_limits<float>::infinity(); }
    glm::vec3 normal() const { return glm::vec3(0); }
    uint32_t object() const { return kNone; }
    uint32_t primitive() const { return kNone; }
    uint32_t triangle() const { return kNone; }
};

// Where samples lie: pixel (x, y) has the samples (x stride + i, y stride + j), i and j below side, in rows of `pitch` samples.
struct SampleLayout {
    uint32_t pitch = 0;
    uint32_t side = 1, stride = 1;
    uint32_t anchor = 0;  // i and j of the sample that stands for the pixel in the planes beside colour

    size_t at(uint32_t x, uint32_t y, uint32_t i, uint32_t j) const { return size_t(y * stride + j) * pitch + x * stride + i; }
    size_t standingFor(uint32_t x, uint32_t y) const { return at(x, y, anchor, anchor); }
};

class PlaneWriter {
public:
    // Writes what `request` asks for into `frame`, which first is a picture in which nothing is drawn.
    PlaneWriter(const Prepared& prepared, const RenderRequest& request, Frame& frame);
    void restart();
    bool wants(uint32_t planes) const { return (planes_ & planes) != 0; }

    // Colours of rows of pixels in the words of a device.
    struct DeviceRows {
        std::span<const uint32_t> words;  // encoded; alpha 0 where nothing is drawn
        uint32_t pitch = 0;               // words from row to row
        const uint32_t* linear[3] = {};   // float32 of each channel, where linear colour is asked for
        uint32_t linearPitch = 0;
    };
    // Returns how many pixels have an alpha of at least 128: with one sample a pixel, those that are covered.
    uint64_t takeColours(uint32_t firstRow, uint32_t rows, const DeviceRows& from);

    // Colours of rows of pixels in samples that host code holds, to be resolved (several a pixel) and encoded.
    struct HostRows {
        SampleLayout layout;
        std::span<const float> linear;  // 3 a sample; the background's where nothing is drawn
        std::span<const int> drawn;     // 0: nothing is
    };
    void takeColours(uint32_t firstRow, uint32_t rows, const HostRows& from, uint32_t threads);
    // The colour of one pixel in place of what was there. `linear`: of channel 0; the others follow `step` floats apart.
    void replaceColour(uint32_t x, uint32_t y, uint32_t word, const float* linear, size_t step);

    // Adds the pixels of `rows` rows of which a sample is drawn (a word other than 0) to the frame's. Returns the number of such samples.
    template <class Word>
    uint64_t takeCoverage(uint32_t rows, const SampleLayout& layout, std::span<const Word> drawn);

    // Every other plane. seenAt(x, y, sample) is what the sample that stands for pixel (x, y) of these rows shows, asked where it is drawn.
    template <class Word, class SeenAt>
    void takeSeen(uint32_t firstRow, uint32_t rows, const SampleLayout& layout, std::span<const Word> drawn, const SeenAt& seenAt) {
        if (!wants(kPlanesSeen)) return;
        for (uint32_t y = 0; y < rows; ++y)
            for (uint32_t x = 0; x < prepared_.width; ++x) {
                const size_t sample = layout.standingFor(x, y);
                if (drawn[sample] != 0) put(size_t(firstRow + y) * prepared_.width + x, seenAt(x, firstRow + y, sample));
            }
    }

private:
    template <class Seen>
    void put(size_t at, const Seen& seen) {
        if (planes_ & kPlaneZ) frame_.z[at] = seen.z();
        if (planes_ & kPlaneDepth) frame_.depth[at] = seen.depth();
        if (planes_ & kPlaneDistance) frame_.distance[at] = seen.distance();
        if (planes_ & kPlaneNormal) {
            const glm::vec3 normal = seen.normal();
            for (int i = 0; i < 3; ++i) frame_.normal[3 * at + size_t(i)] = normal[i];
        }
        if (planes_ & kPlaneObject) frame_.object[at] = seen.object();
        if (planes_ & kPlanePrimitive) frame_.primitive[at] = seen.primitive();
        if (planes_ & kPlaneTriangle) frame_.triangle[at] = seen.triangle();
    }

    const Prepared& prepared_;
    const uint32_t planes_;
    const bool transparent_;
    Frame& frame_;
    std::vector<float> resolved_;
};

template <class Word>
uint64_t PlaneWriter::takeCoverage(uint32_t rows, const SampleLayout& layout, std::span<const Word> drawn) {
    uint64_t samples = 0;
    for (uint32_t y = 0; y < rows; ++y)
        for (uint32_t x = 0; x < prepared_.width; ++x) {
            uint32_t own = 0;
            for (uint32_t j = 0; j < layout.side; ++j)
                for (uint32_t i = 0; i < layout.side; ++i) own += drawn[layout.at(x, y, i, j)] != 0;
            frame_.coveredPixels += own != 0;
            samples += own;
        }
    return samples;
}

}  // namespace plumb
