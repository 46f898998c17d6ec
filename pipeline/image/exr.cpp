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
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
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
    const auto channel = [&](const char* name, Imf::PixelType type, const void* first, size_t strideBytes) {
        header.channels().insert(name, Imf::Channel(type));
        buffer.insert(name, Imf::Slice(type, const_cast<char*>(static_cast<const char*>(first)), strideBytes, strideBytes * width));
    };
    const auto note = [&](const char* name, const char* text) { header.insert(name, Imf::StringAttribute(text)); };

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
    if ((planes & kPlaneDepth) != 0) {
        PLUMB_ASSERT(frame.depth.size() == pixels);
        channel("Z", Imf::FLOAT, frame.depth.data(), sizeof(float));
        note("plumb:depth", "Z: planar depth along the view axis, scene units, +infinity where nothing is drawn");
    }
    if ((planes & kPlaneDistance) != 0) {
        PLUMB_ASSERT(frame.distance.size() == pixels);
        channel("distance", Imf::FLOAT, frame.distance.data(), sizeof(float));
        note("plumb:distance", "Euclidean distance from the eye, scene units, +infinity where nothing is drawn");
    }
    if ((planes & kPlaneNormal) != 0) {
        PLUMB_ASSERT(frame.normal.size() == pixels * 3);
        channel("normal.X", Imf::FLOAT, frame.normal.data(), 3 * sizeof(float));
        channel("normal.Y", Imf::FLOAT, frame.normal.data() + 1, 3 * sizeof(float));
        channel("normal.Z", Imf::FLOAT, frame.normal.data() + 2, 3 * sizeof(float));
        note("plumb:normal", "world space, unit length, 0 where nothing is drawn");
    }
    if ((planes & kPlaneObject) != 0) {
        PLUMB_ASSERT(frame.object.size() == pixels);
        channel("object_id", Imf::UINT, frame.object.data(), sizeof(uint32_t));
        note("plumb:object_id", "order in the scene, 4294967295 where nothing is drawn");
    }
    if ((planes & kPlanePrimitive) != 0) {
        PLUMB_ASSERT(frame.primitive.size() == pixels);
        channel("primitive_id", Imf::UINT, frame.primitive.data(), sizeof(uint32_t));
        note("plumb:primitive_id", "face in file order before triangulation, 4294967295 where nothing is drawn");
    }
    note("plumb:sample", "pixel (x, y) is sampled at (x + 0.5, y + 0.5), row 0 on top");
    for (const auto& [key, value] : metadata) note(("plumb:" + key).c_str(), value.c_str());

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
