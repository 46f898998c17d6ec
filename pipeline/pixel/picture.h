// SPDX-License-Identifier: MIT
// What the openers of every technique share: the picture by both sides, its planes at a pixel, and the truth of its triangles.
#pragma once

#include "pipeline/pixel/open.h"
#include "pipeline/render/technique.h"
#include "pipeline/truth/geometry.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

namespace plumb {

// Frames of both sides with every plane that the technique has.
class BothFrames : public PixelOpener {
public:
    BothFrames(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request);
    const Frame& twin() const override { return twin_.frame; }
    const Frame* device() const override { return device_ == nullptr ? nullptr : &drawn_.frame; }

protected:
    size_t at(const glm::uvec2& pixel) const { return size_t(pixel.y) * request_.width + pixel.x; }
    Shown shownOf(const Frame& frame, const glm::uvec2& pixel) const;
    Shown deviceShown(const glm::uvec2& pixel) const;
    // Lines of the picture's last steps: linear colour of the pixel and its bytes, and what the device and the truth have there.
    void writePixel(Chain& chain, const glm::uvec2& pixel, const std::vector<std::vector<double>>& samples,
                    const std::vector<std::string>& names, const Shown& truth) const;
    // Sentences on where the sides part, from the chains and from what is shown.
    void explain(OpenedPixel& opened) const;
    // Codes of a linear colour of the truth, with their bounds.
    void encode(Shown& truth) const;

    Device* device_;
    const std::string whyNoDevice_;
    const Scene& scene_;
    RenderRequest request_;
    const Technique& technique_;
    RenderResult twin_, drawn_;
    bool srgb_ = true;
};

// Truth of the visible triangle at a point of a picture of triangles.
class TriangleTruth {
public:
    // `shift`: as truth::Pinhole has it.
    TriangleTruth(const Scene& scene, const RenderRequest& request, double shift);
    struct Hit {
        uint32_t index = 0;  // of geometry().triangles()
        uint32_t object = 0, triangle = 0;
        double z = 0, bound = 0;  // near / w
    };
    // Triangles that cover sample (column, row), the nearest first.
    std::vector<Hit> hitsAt(int column, int row);
    const truth::Geometry& geometry() const { return geometry_; }

private:
    truth::Geometry geometry_;
    truth::Judge judge_;
};

std::unique_ptr<PixelOpener> rayOpener(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request);
std::unique_ptr<PixelOpener> rasterOpener(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request);

}  // namespace plumb
