// SPDX-License-Identifier: MIT
// What is written is what was drawn, and a file is whole or absent.
#include "pipeline/image/image.h"
#include "host/error.h"
#include "pipeline/image/zlib_strips.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;

class Folder {
public:
    Folder() {
        std::string name = (fs::temp_directory_path() / "plumb-image-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { fs::remove_all(path_); }
    fs::path operator/(const char* name) const { return path_ / name; }
    size_t files() const { return size_t(std::distance(fs::directory_iterator(path_), fs::directory_iterator())); }

private:
    fs::path path_;
};

Frame awkwardFrame(uint32_t width, uint32_t height) {
    Frame f;
    f.width = width, f.height = height;
    const size_t n = size_t(width) * height;
    uint32_t state = 1;
    for (size_t i = 0; i < n; ++i) {
        state = state * 1664525u + 1013904223u;
        f.rgba.push_back(state);
        for (int c = 0; c < 3; ++c) {
            f.linear.push_back(float((state >> (8 * c)) & 0xff) / 255.0f);
            f.normal.push_back(float(c) - 1.0f);
        }
        const bool drawn = i % 3 != 0;
        f.depth.push_back(drawn ? float(i) * 0.25f : std::numeric_limits<float>::infinity());
        f.distance.push_back(drawn ? float(i) * 0.5f : std::numeric_limits<float>::infinity());
        f.object.push_back(drawn ? uint32_t(i) : 0xffffffffu);
        f.primitive.push_back(drawn ? uint32_t(i) * 7u : 0xffffffffu);
        f.z.push_back(float(i)), f.triangle.push_back(uint32_t(i));
    }
    return f;
}

std::vector<std::byte> bytesOf(const std::string& text) {
    const auto* p = reinterpret_cast<const std::byte*>(text.data());
    return {p, p + text.size()};
}
std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
template <class Call>
Exit exitOf(Call call) {
    try {
        call();
    } catch (const Error& e) {
        return e.exit();
    }
    return Exit::done;
}

// FIPS 180-4 by both forms: the examples of the standard, and those of NIST's SHAVS for 1, 2, 55 and 64 bytes.
TEST(Sha256, BothFormsAgreeWithFips180) {
    const std::pair<std::string, const char*> vectors[] = {
        {"", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
        {"abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
        {"\xbd", "68325720aabd7c82f30f554b313d0570c95accbb7dc4b5aae11204c08ffe732b"},
        {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq", "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
        {"abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu",
         "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1"},
        {std::string(55, '\0'), "02779466cdec163811d078815c633f21901413081449002f24aa3e80f0b88ef7"},
        {std::string(64, '\0'), "f5a5fd42d16a20302798ef6ed309979b43003d2320d9f0e8ea9831a92759fb4b"},
        {std::string(1000000, 'a'), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"},
    };
    for (const Sha256Form form : {Sha256Form::portable, Sha256Form::fastest})
        for (const auto& [text, hash] : vectors)
            EXPECT_EQ(sha256Hex(bytesOf(text), form), hash) << text.size() << " bytes, form " << int(form);
}

// Every length of the last blocks, from every alignment of the first byte.
TEST(Sha256, BothFormsAgreeOnEveryLength) {
    if (!processorHasSha256()) std::puts("this processor has no SHA instructions: one form is compared with itself");
    std::vector<std::byte> bytes(400);
    uint32_t state = 1;
    for (std::byte& b : bytes) b = std::byte((state = state * 1664525u + 1013904223u) >> 24);
    for (size_t first = 0; first < 16; ++first)
        for (size_t length = 0; length + first <= bytes.size(); ++length) {
            const std::span part = std::span(bytes).subspan(first, length);
            ASSERT_EQ(sha256Hex(part, Sha256Form::fastest), sha256Hex(part, Sha256Form::portable)) << length << " bytes from " << first;
        }
}

TEST(Png, ComesBackAsItWasWritten) {
    const Folder folder;
    for (const auto& [w, h] : {std::pair{1u, 1u}, {7u, 3u}, {333u, 211u}}) {
        const Frame frame = awkwardFrame(w, h);
        WriteOptions options;
        options.alpha = true;
        writeFrame(folder / "a.png", frame, kPlaneColour, options, {});
        const Frame back = readPng(folder / "a.png");
        EXPECT_EQ(back.width, w);
        EXPECT_EQ(back.height, h);
        EXPECT_EQ(back.rgba, frame.rgba);
        options.alpha = false;
        writeFrame(folder / "a.png", frame, kPlaneColour, options, {});
        std::vector<uint32_t> opaque = frame.rgba;
        for (uint32_t& p : opaque) p |= 0xff000000u;
        EXPECT_EQ(readPng(folder / "a.png").rgba, opaque);
    }
}

TEST(Png, KeepsSixteenBitsOfTheLinearPlane) {
    Frame frame = awkwardFrame(4, 1);
    frame.linear = {0, 0.5f, 1, -1, 2, std::numeric_limits<float>::quiet_NaN(), 0.25f, 0.0031308f, 0.18f, 1e-5f, 0.75f, 0.999f};
    WriteOptions options;
    options.bits = 16;
    options.linear = true;
    const Folder folder;
    writeFrame(folder / "a.png", frame, kPlaneColour, options, {});
    const Frame back = readPng(folder / "a.png");  // scaled to 8 bits by the reader
    EXPECT_EQ(back.rgba[0] & 0xffffffu, 0xff8000u);
    EXPECT_EQ(back.rgba[1] & 0xffffffu, 0x00ff00u) << "below 0, above 1 and NaN are clamped";
    options.linear = false;
    writeFrame(folder / "b.png", frame, kPlaneColour, options, {});
    EXPECT_EQ(readPng(folder / "b.png").rgba[0] & 0xffffffu, 0xffbc00u) << "sRGB of 0.5 is 188";
}

TEST(Png, HasTheSameBytesAndItsProvenance) {
    const Frame frame = awkwardFrame(31, 17);
    const Metadata metadata{{"Software", "plumb"}, {"plumb:scene", "caf\xc3\xa9"}};
    const auto a = encodePng(frame, {}, metadata), b = encodePng(frame, {}, metadata);
    EXPECT_EQ(a, b);
    const std::string text(reinterpret_cast<const char*>(a.data()), a.size());
    EXPECT_NE(text.find(std::string("tEXtSoftware\0plumb", 18)), std::string::npos);
    EXPECT_NE(text.find("iTXtplumb:scene"), std::string::npos);
    EXPECT_NE(text.find("caf\xc3\xa9"), std::string::npos);
    EXPECT_EQ(text.find("tIME"), std::string::npos) << "a time stamp would change the bytes";
}

// Rows of bytes that compress a little, in one strip, in several, with a short last one, and one row a strip.
TEST(ZlibStrips, AreOneStreamOfTheRows) {
    struct Case {
        uint32_t rows;
        size_t rowBytes;
    };
    for (const Case c : {Case{1, 1}, {7, 13}, {1024, 128}, {1025, 128}, {3000, 301}, {5, 131072}, {3, 200003}})
        for (const int level : {1, 4, 6, 9}) {
            std::vector<unsigned char> want(c.rows * c.rowBytes);
            std::mt19937 random(c.rows);
            for (unsigned char& byte : want) byte = random() % 3 == 0 ? static_cast<unsigned char>(random()) : 7;
            std::vector<std::byte> stream;
            for (const std::vector<std::byte>&piece : zlibStrips(c.rows, c.rowBytes, level, [&](uint32_t y, unsigned char*to) {
                     std::copy_n(want.begin() + ptrdiff_t(y * c.rowBytes), c.rowBytes, to);
                 }))
                stream.insert(stream.end(), piece.begin(), piece.end());
            std::vector<unsigned char> got(want.size());
            uLongf size = got.size();
            EXPECT_EQ(uncompress(got.data(), &size, reinterpret_cast<const Bytef*>(stream.data()), stream.size()), Z_OK)
                << c.rows << " x " << c.rowBytes;
            EXPECT_EQ(size, want.size());
            EXPECT_EQ(got, want) << c.rows << " x " << c.rowBytes;
        }
}

TEST(Png, KeepsPicturesOfManyStrips) {
    const Folder folder;
    Frame frame = awkwardFrame(701, 301);
    std::mt19937 random(3);
    for (uint32_t& p : frame.rgba) p = random();
    for (const bool alpha : {false, true}) {
        WriteOptions options;
        options.alpha = alpha;
        writeFrame(folder / "a.png", frame, kPlaneColour, options, {});
        std::vector<uint32_t> want = frame.rgba;
        for (uint32_t& p : want) p |= alpha ? 0u : 0xff000000u;
        EXPECT_EQ(readPng(folder / "a.png").rgba, want);
    }
}

TEST(Png, RefusesWhatIsNotAPicture) {
    const Folder folder;
    std::ofstream(folder / "a.png") << "not a PNG";
    EXPECT_EQ(exitOf([&] { readPng(folder / "a.png"); }), Exit::input);
    EXPECT_EQ(exitOf([&] { readPng(folder / "missing.png"); }), Exit::input);
    EXPECT_EQ(exitOf([&] { readPng("/dev/zero"); }), Exit::input);
    const auto whole = encodePng(awkwardFrame(64, 64), {}, {});
    for (const size_t cut : {size_t(20), whole.size() / 2, whole.size() - 20}) {
        std::ofstream(folder / "cut.png", std::ios::binary).write(reinterpret_cast<const char*>(whole.data()), std::streamsize(cut));
        EXPECT_EQ(exitOf([&] { readPng(folder / "cut.png"); }), Exit::input) << cut;
    }
}

TEST(Exr, HoldsEveryPlaneWithItsConvention) {
    const Folder folder;
    const Frame frame = awkwardFrame(13, 5);
    const uint32_t planes = kPlaneColour | kPlaneDepth | kPlaneDistance | kPlaneNormal | kPlaneObject | kPlanePrimitive;
    writeFrame(folder / "a.exr", frame, planes, {}, {{"scene", "x.obj"}});
    Imf::InputFile file((folder / "a.exr").c_str());
    std::vector<std::string> names;
    for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) names.emplace_back(it.name());
    EXPECT_EQ(names,
              (std::vector<std::string>{"B", "G", "R", "Z", "distance", "normal.X", "normal.Y", "normal.Z", "object_id", "primitive_id"}));
    EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("plumb:scene").value(), "x.obj");
    EXPECT_NE(file.header().typedAttribute<Imf::StringAttribute>("plumb:depth").value().find("infinity"), std::string::npos);
    const size_t n = frame.depth.size();
    std::vector<float> red(n), depth(n), distance(n), normalY(n);
    std::vector<uint32_t> object(n), primitive(n);
    Imf::FrameBuffer buffer;
    const auto slice = [&](const char* name, Imf::PixelType type, void* to) {
        buffer.insert(name, Imf::Slice(type, static_cast<char*>(to), 4, 4 * frame.width));
    };
    slice("R", Imf::FLOAT, red.data());
    slice("Z", Imf::FLOAT, depth.data());
    slice("distance", Imf::FLOAT, distance.data());
    slice("normal.Y", Imf::FLOAT, normalY.data());
    slice("object_id", Imf::UINT, object.data());
    slice("primitive_id", Imf::UINT, primitive.data());
    file.setFrameBuffer(buffer);
    file.readPixels(0, int(frame.height) - 1);
    EXPECT_EQ(depth, frame.depth);
    EXPECT_EQ(distance, frame.distance);
    EXPECT_EQ(object, frame.object);
    EXPECT_EQ(primitive, frame.primitive);
    for (size_t i = 0; i < n; ++i) {
        EXPECT_EQ(red[i], frame.linear[i * 3]);
        EXPECT_EQ(normalY[i], frame.normal[i * 3 + 1]);
    }
    EXPECT_EQ(encodeExr(frame, planes, {}), encodeExr(frame, planes, {}));
}

TEST(Exr, MultipliesColourByAlpha) {
    const Folder folder;
    Frame frame = awkwardFrame(2, 1);
    frame.rgba = {0xff000000u, 0x33000000u};
    frame.linear = {1, 1, 1, 0.5f, 1, 1};
    WriteOptions options;
    options.alpha = true;
    writeFrame(folder / "a.exr", frame, kPlaneLinear, options, {});
    Imf::InputFile file((folder / "a.exr").c_str());
    float red[2], alpha[2];
    Imf::FrameBuffer buffer;
    buffer.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(red), 4, 8));
    buffer.insert("A", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(alpha), 4, 8));
    file.setFrameBuffer(buffer);
    file.readPixels(0, 0);
    EXPECT_EQ(alpha[0], 1.0f);
    EXPECT_EQ(alpha[1], 51.0f / 255.0f);
    EXPECT_EQ(red[1], 0.5f * (51.0f / 255.0f));
}

TEST(Npy, HasTheHeaderThatNumpyReads) {
    const Frame frame = awkwardFrame(6, 4);
    const struct {
        Plane plane;
        const char* header;
        size_t bytes;
    } rows[] = {{kPlaneColour, "{'descr': '|u1', 'fortran_order': False, 'shape': (4, 6, 4), }", 96},
                {kPlaneLinear, "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 6, 3), }", 288},
                {kPlaneDepth, "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 6), }", 96},
                {kPlaneObject, "{'descr': '<u4', 'fortran_order': False, 'shape': (4, 6), }", 96}};
    for (const auto& row : rows) {
        const auto bytes = encodeNpy(frame, row.plane);
        const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        EXPECT_EQ(text.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
        const size_t header = size_t(uint8_t(text[8])) | size_t(uint8_t(text[9])) << 8;
        EXPECT_EQ((10 + header) % 64, 0u);
        EXPECT_EQ(text[10 + header - 1], '\n');
        EXPECT_EQ(text.substr(10, std::strlen(row.header)), row.header);
        EXPECT_EQ(bytes.size(), 10 + header + row.bytes);
        if (row.plane == kPlaneDepth) {
            EXPECT_EQ(std::memcmp(bytes.data() + 10 + header, frame.depth.data(), row.bytes), 0);
        }
    }
}

TEST(Sheet, KeepsOrderAndFillsTheRest) {
    std::vector<Frame> frames;
    for (uint32_t i = 0; i < 3; ++i) {
        Frame f;
        f.width = 2, f.height = 1;
        f.rgba = {10 * i, 10 * i + 1};
        f.linear.assign(6, float(i));
        f.coveredPixels = i;
        frames.push_back(f);
    }
    const Frame sheet = contactSheet(frames, 0, 99, {0.5f, 0.25f, 0.125f});
    EXPECT_EQ(sheet.width, 4u);
    EXPECT_EQ(sheet.height, 2u);
    EXPECT_EQ(sheet.rgba, (std::vector<uint32_t>{0, 1, 10, 11, 20, 21, 99, 99}));
    EXPECT_EQ(sheet.linear[12], 2.0f);
    EXPECT_EQ(sheet.linear[19], 0.25f);
    EXPECT_EQ(sheet.coveredPixels, 3u);
    EXPECT_EQ(contactSheet(frames, 3, 0).width, 6u);
}

TEST(AtomicFile, ReplacesAndKeepsTheMode) {
    const Folder folder;
    writeFileAtomically(folder / "a", bytesOf("first"), false);
    ::chmod((folder / "a").c_str(), 0600);
    writeFileAtomically(folder / "a", bytesOf("second"), false);
    EXPECT_EQ(read(folder / "a"), "second");
    struct stat st {};
    ::stat((folder / "a").c_str(), &st);
    EXPECT_EQ(st.st_mode & 0777, 0600u);
    EXPECT_EQ(folder.files(), 1u);
}

TEST(AtomicFile, RefusesToClobber) {
    const Folder folder;
    writeFileAtomically(folder / "new", bytesOf("x"), true);
    EXPECT_EQ(exitOf([&] { writeFileAtomically(folder / "new", bytesOf("y"), true); }), Exit::usage);
    EXPECT_EQ(read(folder / "new"), "x");
    EXPECT_EQ(folder.files(), 1u);
}

TEST(AtomicFile, FollowsALinkAndKeepsIt) {
    const Folder folder;
    writeFileAtomically(folder / "target", bytesOf("old"), false);
    fs::create_symlink("target", folder / "link");
    writeFileAtomically(folder / "link", bytesOf("new"), false);
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(read(folder / "target"), "new");
}

TEST(AtomicFile, AcceptsTheLongestName) {
    const Folder folder;
    const std::string name(255, 'n');
    writeFileAtomically(folder / name.c_str(), bytesOf("x"), false);
    EXPECT_EQ(read(folder / name.c_str()), "x");
}

TEST(AtomicFile, SaysThatTheDiskIsFull) {
    try {
        writeFileAtomically("/dev/full", bytesOf("x"), false);
        FAIL() << "/dev/full took a byte";
    } catch (const Error& e) {
        EXPECT_EQ(e.exit(), Exit::failed);
        EXPECT_NE(std::string(e.what()).find("No space left"), std::string::npos) << e.what();
    }
}

TEST(AtomicFile, LeavesTheOldFileWhenTheNewOneDoesNotFit) {
    const Folder folder;
    writeFileAtomically(folder / "a", bytesOf("old"), false);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{4096, before.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const Exit exit = exitOf([&] { writeFileAtomically(folder / "a", bytesOf(std::string(100000, 'x')), false); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(exit, Exit::failed);
    EXPECT_EQ(read(folder / "a"), "old");
    EXPECT_EQ(folder.files(), 1u) << "the temporary file stayed";
}

TEST(AtomicFile, NamesAFolderThatIsMissing) {
    const Folder folder;
    EXPECT_EQ(exitOf([&] { writeFileAtomically(folder / "no" / "a", bytesOf("x"), false); }), Exit::failed);
    EXPECT_EQ(exitOf([&] { checkWritable(folder / "no" / "a", false); }), Exit::failed);
    EXPECT_EQ(exitOf([&] { writeFileAtomically(folder / "", bytesOf("x"), false); }), Exit::usage) << "a folder is no file";
    EXPECT_EQ(folder.files(), 0u);
}

TEST(WriteFrame, RefusesAnUnknownExtension) {
    const Folder folder;
    const Frame frame = awkwardFrame(2, 2);
    EXPECT_EQ(exitOf([&] { writeFrame(folder / "a.jpg", frame, kPlaneColour, {}, {}); }), Exit::usage);
    EXPECT_EQ(exitOf([&] { writeFrame(folder / "a.npy", frame, kPlaneDepth | kPlaneNormal, {}, {}); }), Exit::usage);
    EXPECT_EQ(folder.files(), 0u);
}

}  // namespace
}  // namespace plumb
