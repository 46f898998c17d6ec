// SPDX-License-Identifier: MIT
// Pictures as others write them, and files that want to do harm.
#include "host/error.h"
#include "pipeline/compare/picture.h"
#include "pipeline/image/image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <half.h>
#include <png.h>
#include <zlib.h>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <new>
#include <string>
#include <utility>
#include <vector>

// The largest piece of memory that was asked for, so that a header's word is seen when it is believed.
static std::atomic<size_t> largestAllocation{0};
__attribute__((noinline)) void* operator new(size_t size, const std::nothrow_t&) noexcept {
    size_t seen = largestAllocation;
    while (size > seen && !largestAllocation.compare_exchange_weak(seen, size)) {
    }
    return std::malloc(size);
}
__attribute__((noinline)) void* operator new(size_t size) {
    if (void* p = operator new(size, std::nothrow)) return p;
    throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void* p) noexcept { std::free(p); }
__attribute__((noinline)) void operator delete(void* p, size_t) noexcept { std::free(p); }

namespace plumb {
namespace {

namespace fs = std::filesystem;

class CompareRead : public testing::Test {
protected:
    CompareRead() {
        std::string name = (fs::temp_directory_path() / "plumb-compare-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
    }
    ~CompareRead() override { fs::remove_all(folder_); }
    fs::path at(const std::string& name) const { return folder_ / name; }
    fs::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(at(name), std::ios::binary) << bytes;
        return at(name);
    }
    fs::path write(const std::string& name, const std::vector<std::byte>& bytes) const {
        return write(name, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    }
    static std::string bytesOf(const fs::path& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    // The one line of a refusal; empty when it is read.
    static std::string refusal(const fs::path& path) {
        try {
            readPicture(path);
        } catch (const Error& e) {
            EXPECT_EQ(e.exit(), Exit::input) << e.what();
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
            return e.what();
        }
        return "";
    }

private:
    fs::path folder_;
};

Frame small() {
    Frame f;
    f.width = 5, f.height = 3;
    for (uint32_t i = 0; i < 15; ++i) {
        f.rgba.push_back(i * 0x01050301u);
        for (uint32_t c = 0; c < 3; ++c) f.linear.push_back(float(i) / 7 - float(c)), f.normal.push_back(float(c) / 3);
        f.depth.push_back(i == 4 ? std::numeric_limits<float>::infinity() : float(i) + 0.1f);
        f.object.push_back(i == 2 ? 0xffffffffu : i);
    }
    return f;
}

std::string npy(const std::string& header, const std::string& data, char version = 1) {
    std::string text = header + std::string((64 - (10 + header.size() + 1) % 64) % 64, ' ') + "\n";
    std::string prefix = std::string("\x93NUMPY") + version + std::string(1, '\0') + char(text.size() & 0xff) + char(text.size() >> 8);
    if (version > 1) prefix += std::string(2, '\0');
    return prefix + text + data;
}

struct PngKind {
    int bits, type, interlace;
    std::string row;
    uint32_t channels;
    std::vector<double> first;  // samples of the first pixel
};

std::string pngOf(uint32_t width, uint32_t height, const PngKind& kind) {
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &bytes,
        [](png_structp p, png_bytep d, size_t n) { static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(d), n); },
        nullptr);
    png_set_IHDR(png, info, width, height, kind.bits, kind.type, kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    const png_color palette[2] = {{10, 20, 30}, {200, 100, 50}};
    if (kind.type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 2);
    png_write_info(png, info);
    const int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; ++pass)
        for (uint32_t y = 0; y < height; ++y) png_write_row(png, reinterpret_cast<png_const_bytep>(kind.row.data()));
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

TEST_F(CompareRead, ReadsWhatTheCommandWrites) {
    const Frame f = small();
    WriteOptions options;
    options.alpha = true;
    const Picture png = readPicture(write("a.png", encodePng(f, options, {})));
    EXPECT_EQ(png.format, "png");
    ASSERT_EQ(png.layers.size(), 1u);
    EXPECT_EQ(png.layers[0].channels, 4u);
    EXPECT_FALSE(png.layers[0].linear);
    for (size_t i = 0; i < 15; ++i)
        for (size_t c = 0; c < 4; ++c) EXPECT_EQ(png.layers[0].samples[i * 4 + c], f.rgba[i] >> (8 * c) & 0xff);
    options.bits = 16;
    options.linear = true;
    const Picture wide = readPicture(write("b.png", encodePng(f, options, {})));
    EXPECT_EQ(wide.layers[0].fullScale, 65535);
    EXPECT_TRUE(wide.layers[0].linear) << "gAMA 1.0 without sRGB";

    const Picture exr = readPicture(write("a.exr", encodeExr(f, kPlaneLinear | kPlaneDepth | kPlaneNormal | kPlaneObject, {})));
    ASSERT_EQ(exr.layers.size(), 4u);
    EXPECT_EQ(exr.layers[0].name, "color");
    for (const Layer& layer : exr.layers) {
        if (layer.name == "color")
            EXPECT_EQ(layer.samples, std::vector<double>(f.linear.begin(), f.linear.end()));
        else if (layer.name == "depth")
            EXPECT_EQ(layer.samples, std::vector<double>(f.depth.begin(), f.depth.end()));
        else if (layer.name == "normal")
            EXPECT_EQ(layer.samples, std::vector<double>(f.normal.begin(), f.normal.end()));
        else {
            EXPECT_EQ(layer.name, "object_id");
            EXPECT_EQ(layer.kind, LayerKind::id);
            EXPECT_EQ(layer.samples, std::vector<double>(f.object.begin(), f.object.end()));
        }
    }
    const Picture depth = readPicture(write("d.npy", encodeNpy(f, kPlaneDepth)));
    EXPECT_EQ(depth.layers[0].samples, std::vector<double>(f.depth.begin(), f.depth.end()));
    EXPECT_EQ(readPicture(write("c.npy", encodeNpy(f, kPlaneColour))).layers[0].samples, png.layers[0].samples);
    EXPECT_EQ(readPicture(write("o.npy", encodeNpy(f, kPlaneObject))).layers[0].kind, LayerKind::id);
}

TEST_F(CompareRead, ReadsEveryKindOfPng) {
    using S = std::string;
    const PngKind kinds[] = {
        {1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, S("\xa0", 1), 1, {255}},
        {4, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, S("\x3f\x00", 2), 1, {51}},
        {8, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_INTERLACE_ADAM7, S("\x07\x80\x01\x02\x03\x04", 6), 2, {7, 128}},
        {8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_ADAM7, S("\x07\x08\x09\x01\x02\x03\x04\x05\x06", 9), 3, {7, 8, 9}},
        {16, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_ADAM7, S("\x01\x02\x03\x04\x05\x06\0\0\0\0\0\0\0\0\0\0\0\0", 18), 3, {258, 772, 1286}},
        {16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, S("\xff\xfe\0\0\0\0", 6), 1, {65534}},
        {1, PNG_COLOR_TYPE_PALETTE, PNG_INTERLACE_NONE, S("\x80", 1), 3, {200, 100, 50}},
    };
    for (const PngKind& kind : kinds) {
        const Picture p = readPicture(write("k.png", pngOf(3, 2, kind)));
        SCOPED_TRACE(fmt::format("{} bits, type {}", kind.bits, kind.type));
        EXPECT_EQ(p.layers[0].channels, kind.channels);
        EXPECT_EQ(p.layers[0].samples.size(), 6 * kind.channels);
        EXPECT_EQ(std::vector<double>(p.layers[0].samples.begin(), p.layers[0].samples.begin() + kind.channels), kind.first);
        EXPECT_EQ(p.layers[0].samples[3 * size_t(kind.channels)], kind.first[0]) << "the second row is as the first";
    }
}

TEST_F(CompareRead, ReadsHalfTilesAndNegativeWindows) {
    constexpr int kW = 37, kH = 21;
    std::vector<half> values;
    for (int i = 0; i < kW * kH; ++i) values.emplace_back(float(i) / 8);
    const Imath::Box2i window({-4, 7}, {-4 + kW - 1, 7 + kH - 1});
    for (const bool tiled : {false, true})
        for (const Imf::Compression compression :
             {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::PIZ_COMPRESSION}) {
            Imf::Header header(window, window);
            header.compression() = compression;
            header.channels().insert("Y", Imf::Channel(Imf::HALF));
            Imf::FrameBuffer buffer;
            const ptrdiff_t origin = -4 + ptrdiff_t(7) * kW;
            buffer.insert("Y", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(values.data()) - origin * 2, 2, 2 * kW));
            const std::string path = at("t.exr").string();
            if (tiled) {
                header.setTileDescription(Imf::TileDescription(16, 8));
                Imf::TiledOutputFile file(path.c_str(), header, 0);
                file.setFrameBuffer(buffer);
                file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
            } else {
                Imf::OutputFile file(path.c_str(), header, 0);
                file.setFrameBuffer(buffer);
                file.writePixels(kH);
            }
            const Picture p = readPicture(path);
            EXPECT_EQ(p.left, -4);
            EXPECT_EQ(p.top, 7);
            EXPECT_EQ(p.layers.at(0).name, "color");
            EXPECT_EQ(p.layers[0].precision, 16);
            EXPECT_EQ(p.layers[0].samples, std::vector<double>(values.begin(), values.end()));
        }
}

TEST_F(CompareRead, ReadsArraysAsNumpyWritesThem) {
    const auto samples = [&](const std::string& bytes) { return readPicture(write("n.npy", bytes)).layers[0].samples; };
    const std::string tail = ", 'fortran_order': False, 'shape': (1, 2), }";
    EXPECT_EQ(samples(npy("{'descr': '>f4'" + tail, std::string("\x3f\x80\0\0\xc0\0\0\0", 8))), (std::vector<double>{1, -2}));
    EXPECT_EQ(samples(npy("{'descr': '<f2'" + tail, std::string("\0\x3c\0\xc0", 4))), (std::vector<double>{1, -2}));
    EXPECT_EQ(samples(npy("{'descr': '|b1'" + tail, std::string("\1\0", 2))), (std::vector<double>{1, 0}));
    EXPECT_EQ(samples(npy("{'descr': '<i2'" + tail, std::string("\xff\xff\2\0", 4))), (std::vector<double>{-1, 2}));
    EXPECT_EQ(samples(npy("{'descr': '<i8'" + tail, std::string("\xff\xff\xff\xff\xff\xff\xff\xff\2\0\0\0\0\0\0\0", 16), 2)),
              (std::vector<double>{-1, 2}))
        << "version 2";
    EXPECT_EQ(samples(npy("{'descr': '|u1', 'fortran_order': True, 'shape': (2, 3), }", std::string("\1\4\2\5\3\6", 6))),
              (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST_F(CompareRead, RefusesArraysWithoutMeaning) {
    const auto why = [&](const std::string& header, size_t bytes = 8) {
        return refusal(write("n.npy", npy(header, std::string(bytes, '\0'))));
    };
    EXPECT_NE(why("{'descr': '|O', 'fortran_order': False, 'shape': (2, 4), }").find("'|O'"), std::string::npos);
    EXPECT_NE(why("{'descr': '<c8', 'fortran_order': False, 'shape': (1, 1), }").find("'<c8'"), std::string::npos);
    EXPECT_NE(why("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2,), }").find("structured"), std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }").find("shape"), std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (0, 2), }").find("empty"), std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2), }").find("8 bytes of data; the header says 16"),
              std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1), }").find("8 bytes of data; the header says 4"),
              std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (65536, 65536, 64), }").find("2^27"), std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551615, 2), }").find("65536"), std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999, 2), }").find("whole number"),
              std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'fortran_order': __import__('os'), 'shape': (1, 2), }").find("True or False"), std::string::npos);
    EXPECT_NE(why("{'descr': '<f4', 'shape': (1, 2), }").find("missing"), std::string::npos);
    EXPECT_NE(
        refusal(write("n.npy", npy("{'descr': '<u8', 'fortran_order': False, 'shape': (1, 1), }", std::string(8, '\xff')))).find("2^53"),
        std::string::npos);
}

TEST_F(CompareRead, RefusesWhatIsNoPicture) {
    EXPECT_NE(refusal(write("empty", std::string())), "");
    EXPECT_NE(refusal(write("text.png", std::string("hello"))).find("neither a PNG"), std::string::npos);
    EXPECT_NE(refusal(at("missing.png")), "");
    EXPECT_NE(refusal(at("")), "") << "a folder";
    EXPECT_NE(refusal("/dev/zero"), "");
    EXPECT_NE(refusal(write("evil\x1b[2J.png", std::string("x"))).find("\\x1b"), std::string::npos) << "no escape reaches the terminal";
}

TEST_F(CompareRead, RefusesPartsDepthAndSubsampling) {
    const std::vector<float> values(64);
    {
        std::vector<Imf::Header> headers(2, Imf::Header(8, 8));
        for (size_t i = 0; i < 2; ++i) {
            headers[i].setName(i == 0 ? "left" : "right");
            headers[i].setType(Imf::SCANLINEIMAGE);
            headers[i].channels().insert("Y", Imf::Channel(Imf::FLOAT));
        }
        Imf::MultiPartOutputFile file(at("parts.exr").c_str(), headers.data(), 2, false, 0);
    }
    EXPECT_NE(refusal(at("parts.exr")).find("several parts"), std::string::npos);
    {
        Imf::Header header(8, 8);
        header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
        header.channels().insert("RY", Imf::Channel(Imf::FLOAT, 2, 2));
        Imf::OutputFile file(at("sub.exr").c_str(), header, 0);
        Imf::FrameBuffer buffer;
        buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values.data())), 4, 32));
        buffer.insert("RY", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values.data())), 4, 16, 2, 2));
        file.setFrameBuffer(buffer);
        file.writePixels(8);
    }
    EXPECT_NE(refusal(at("sub.exr")).find("subsampled"), std::string::npos);
    std::string deep = bytesOf(at("sub.exr"));
    deep[5] = char(deep[5] | 0x08);
    EXPECT_NE(refusal(write("deep.exr", deep)).find("deep"), std::string::npos);
}

// Every prefix of a small file is refused in one line, or, where only trailing bytes are missing, read in full.
TEST_F(CompareRead, RefusesEveryTruncation) {
    const Frame f = small();
    size_t refused = 0, all = 0;
    for (const auto& [name, bytes] : {std::pair{"t.png", encodePng(f, {}, {})},
                                      {"t.exr", encodeExr(f, kPlaneLinear | kPlaneDepth | kPlaneObject, {})},
                                      {"t.npy", encodeNpy(f, kPlaneDepth)}}) {
        const Picture whole = readPicture(write(name, bytes));
        for (size_t cut = 0; cut < bytes.size(); ++cut, ++all)
            refused += !refusal(write(name, std::vector<std::byte>(bytes.begin(), bytes.begin() + ptrdiff_t(cut)))).empty();
    }
    EXPECT_EQ(refused, all);
}

TEST_F(CompareRead, SurvivesEveryChangedByte) {
    const Frame f = small();
    uint32_t state = 7;
    for (const auto& [name, bytes] : {std::pair{"m.png", encodePng(f, {}, {})},
                                      {"m.exr", encodeExr(f, kPlaneLinear | kPlaneObject, {})},
                                      {"m.npy", encodeNpy(f, kPlaneDepth)}})
        for (size_t i = 0; i < bytes.size(); ++i)
            for (int value : {0, 255, -1}) {
                auto changed = bytes;
                state = state * 1664525u + 1013904223u;
                changed[i] = std::byte(value < 0 ? state >> 24 : unsigned(value));
                refusal(write(name, changed));  // read or refused with one line
            }
}

// 64 Ki x 64 Ki in a header of a few bytes.
TEST_F(CompareRead, TakesNoMemoryForWhatAHeaderSays) {
    constexpr size_t kPlenty = size_t(1) << 20;
    std::string png = pngOf(3, 2, {8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, std::string(9, 'x'), 3, {}});
    const auto resized = [&](uint32_t width, uint32_t height) {
        std::string p = png;
        for (int i = 0; i < 4; ++i) p[16 + size_t(i)] = char(width >> (24 - 8 * i)), p[20 + size_t(i)] = char(height >> (24 - 8 * i));
        const uint32_t crc = uint32_t(::crc32(0, reinterpret_cast<const unsigned char*>(p.data()) + 12, 17));
        for (int i = 0; i < 4; ++i) p[29 + size_t(i)] = char(crc >> (24 - 8 * i));
        return p;
    };
    const auto modest = [&](const fs::path& path) {
        largestAllocation = 0;
        std::string why = refusal(path);
        EXPECT_NE(why, "");
        EXPECT_LT(largestAllocation.load(), kPlenty) << why;
        return why;
    };
    EXPECT_NE(modest(write("h.png", resized(60000, 60000))).find("2^27"), std::string::npos);
    EXPECT_NE(modest(write("h.png", resized(3, 60000))), "");
    EXPECT_NE(modest(write("h.png", resized(0x7fffffff, 1))), "");
    std::string interlaced = pngOf(3, 2, {8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_ADAM7, std::string(9, 'x'), 3, {}});
    std::swap(png, interlaced);
    EXPECT_NE(modest(write("h.png", resized(6000, 6000))).find("too short"), std::string::npos);

    const std::vector<std::byte> exr = encodeExr(small(), kPlaneLinear, {});
    std::string header(reinterpret_cast<const char*>(exr.data()), exr.size());
    const size_t window = header.find("dataWindow") + sizeof "dataWindow" + sizeof "box2i" + 4;
    const auto boxed = [&](int32_t x, int32_t y) {
        std::string h = header;
        std::memcpy(h.data() + window + 8, &x, 4);
        std::memcpy(h.data() + window + 12, &y, 4);
        return h;
    };
    EXPECT_NE(modest(write("h.exr", boxed(59999, 59999))).find("2^27"), std::string::npos);
    EXPECT_NE(modest(write("h.exr", boxed(-2, 5))).find("empty"), std::string::npos);
    EXPECT_NE(modest(write("h.exr", boxed(std::numeric_limits<int32_t>::max(), 1))).find("2^24"), std::string::npos);
    EXPECT_NE(modest(write("h.exr", boxed(70000, 1))).find("65536"), std::string::npos);
    EXPECT_NE(
        modest(write("h.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (10000, 10000), }", "x"))).find("1 bytes of data"),
        std::string::npos);
}

}  // namespace
}  // namespace plumb
