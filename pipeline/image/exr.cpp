// SPDX-License-Identifier: MIT
// EXR through OpenEXR, single part, ZIP compression. Linear colour and measurements with their conventions as attributes.
#include "host/error.h"
#include "pipeline/image/image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <fmt/core.h>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <type_traits>
#include <vector>

namespace plumb {
namespace {

class MemoryStream : public Imf::OStream {
public:
    explicit MemoryStream(std::vector<std::byte>& bytes) : Imf::OStream("memory"), bytes_(bytes) {}
    void write(const char c[], int n) override {
        const size_t end = size_t(at_) + size_t(n);
        if (bytes_.size() < end) bytes_.resize(end);
        std::memcpy(bytes_.data() + at_, c, size_t(n));
        at_ = end;
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t at) override { at_ = at; }

private:
    std::vector<std::byte>& bytes_;
    uint64_t at_ = 0;
};

}  // namespace

std::vector<std::byte> encodeExr(const Frame& frame, uint32_t planes, const Metadata& metadata, bool alpha) {
    const size_t width = frame.width, height = frame.height, pixels = width * height;
    PLUMB_ASSERT(pixels != 0 && planes != 0);
    Imf::Header header(int(frame.width), int(frame.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    const auto channel = [&](const std::string& name, Imf::PixelType type, const void* first, size_t strideBytes) {
        header.channels().insert(name, Imf::Channel(type));
        buffer.insert(name, Imf::Slice(type, const_cast<char*>(static_cast<const char*>(first)), strideBytes, strideBytes * width));
    };
    const auto note = [&](const std::string& name, const std::string& text) { header.insert(name, Imf::StringAttribute(text)); };

    std::vector<float> associated;  // R G B A, colour multiplied by A
    if ((planes & (kPlaneColour | kPlaneLinear)) != 0) {
        PLUMB_ASSERT(frame.linear.size() == pixels * 3);
        const float* colour = frame.linear.data();
        size_t stride = 3 * sizeof(float);
        if (alpha) {
            PLUMB_ASSERT(frame.rgba.size() == pixels);
            associated.resize(pixels * 4);
            for (size_t i = 0; i < pixels; ++i) {
                const float a = float(frame.rgba[i] >> 24) / 255.0f;
                for (size_t c = 0; c < 3; ++c) associated[i * 4 + c] = frame.linear[i * 3 + c] * a;
                associated[i * 4 + 3] = a;
            }
            colour = associated.data();
            stride = 4 * sizeof(float);
            channel("A", Imf::FLOAT, colour + 3, stride);
        }
        channel("R", Imf::FLOAT, colour, stride);
        channel("G", Imf::FLOAT, colour + 1, stride);
        channel("B", Imf::FLOAT, colour + 2, stride);
        note("plumb:colour", alpha ? "linear RGB, Rec. 709 primaries, multiplied by A (coverage)" : "linear RGB, Rec. 709 primaries");
    }
    // Planes of measurements: one channel of the plane's name, or three of its name and an axis. Z is the name that readers expect for depth.
    forEachPlane([&](const auto& row, auto values) {
        if ((planes & row.plane) == 0 || row.convention[0] == '\0') return;
        const auto& plane = frame.*values;
        PLUMB_ASSERT(plane.size() == pixels * row.channels);
        const std::string name = row.plane == kPlaneDepth ? "Z" : row.name;
        const Imf::PixelType type = std::is_same_v<decltype(row.undrawn), float> ? Imf::FLOAT : Imf::UINT;
        for (uint32_t c = 0; c < row.channels; ++c)
            channel(row.channels == 1 ? name : name + "." + "XYZ"[c], type, plane.data() + c, row.channels * sizeof plane[0]);
        note(fmt::format("plumb:{}", row.name), row.convention);
    });
    note("plumb:sample", "pixel (x, y) is sampled at (x + 0.5, y + 0.5), row 0 on top");
    for (const auto& [key, value] : metadata) note("plumb:" + key, value);

    std::vector<std::byte> bytes;
    try {
        MemoryStream stream(bytes);
        Imf::OutputFile file(stream, header, 0);  // 0: compress in this thread
        file.setFrameBuffer(buffer);
        file.writePixels(int(frame.height));
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        throw renderError(std::string("EXR: ") + e.what());
    }
    return bytes;
}

}  // namespace plumb
