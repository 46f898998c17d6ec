// SPDX-License-Identifier: MIT
// Inputs: what tells a format, what can be read only once, and where a long load can be ended.
#include "host/error.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

std::string refusalOf(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input) << error.what();
        return error.what();
    }
    return "";
}

std::string binaryStl(uint32_t facets) {
    std::string bytes(84 + size_t(50) * facets, '\0');
    std::memcpy(bytes.data() + 80, &facets, sizeof facets);
    for (uint32_t f = 0; f < facets; ++f)
        for (int corner = 0; corner < 3; ++corner) {
            const float p[3] = {float(f) + float(corner == 1), float(corner == 2), 0};
            std::memcpy(bytes.data() + 84 + size_t(50) * f + 12 + size_t(12 * corner), p, sizeof p);
        }
    return bytes;
}

TEST(FormatOfContent, ReadsMagicSizesAndFirstStatements) {
    const std::pair<std::string, FileFormat> rows[] = {
        {"glTF\2\0\0\0", FileFormat::gltf},
        {"{\"asset\": {}}", FileFormat::gltf},
        {"\n  {", FileFormat::gltf},
        {"ply\nformat ascii 1.0\n", FileFormat::ply},
        {"ply\r\nformat", FileFormat::ply},
        {"plywood\n", FileFormat::unknown},
        {"OFF\n3 1 0\n", FileFormat::off},
        {"# made by hand\n\nOFF 3 1 0\n", FileFormat::off},
        {"STCNOFF\n", FileFormat::off},
        {"COFF\n", FileFormat::off},
        {"OFF8 12 0\n", FileFormat::off},
        {"OFFSET\n", FileFormat::unknown},
        {"solid cube\nfacet normal", FileFormat::stl},
        {"  SOLID\n", FileFormat::stl},
        {"solidify\n", FileFormat::unknown},
        {binaryStl(2), FileFormat::stl},
        {binaryStl(2) + "x", FileFormat::unknown},
        {"# Blender\nmtllib a.mtl\no Cube\n", FileFormat::obj},
        {"v 0 0 0\n", FileFormat::obj},
        {"\xef\xbb\xbfv 0 0 0\n", FileFormat::obj},
        {"usemtl x\n", FileFormat::obj},
        {"s = 3\n", FileFormat::toml},
        {"v=1\n", FileFormat::toml},
        {"# scene\n[camera]\n", FileFormat::toml},
        {"[[mesh]]\n", FileFormat::toml},
        {"camera.eye = [0, 0, 1]\n", FileFormat::toml},
        {"", FileFormat::unknown},
        {"# only a comment", FileFormat::unknown},
        {"\n\n", FileFormat::unknown},
        {"\x89PNG\r\n\x1a\n", FileFormat::unknown},
        {"<?xml version=\"1.0\"?>", FileFormat::unknown},
        {"Kaydara FBX Binary", FileFormat::unknown},
        {"vertex 1 2 3\n", FileFormat::unknown},
    };
    for (const auto& [bytes, format] : rows) EXPECT_EQ(int(formatOfContent(bytes, bytes.size())), int(format)) << bytes.substr(0, 40);
    // A binary STL may begin with the word "solid"; then its size decides.
    std::string named = binaryStl(3);
    std::memcpy(named.data(), "solid exported", 14);
    EXPECT_EQ(int(formatOfContent(named, named.size())), int(FileFormat::stl));
}

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

TEST(FormatOfInput, ByExtensionInAnyCaseElseByContentElseAsTold) {
    const TemporaryFolder folder;
    for (const char* name : {"a.obj", "A.OBJ", "noextension", "odd.xyz", "a.b/c"}) {
        fs::create_directories((folder.path() / name).parent_path());
        const fs::path path = folder.write(name, kTriangle);
        EXPECT_EQ(loadScene({path}, {}).meshes.at(0).triangles.size(), 1u) << name;
        EXPECT_TRUE(isBareMesh(path)) << name;
    }
    LoadOptions told;
    told.format = "obj";
    EXPECT_EQ(loadScene({folder.write("wrong.stl", kTriangle)}, told).meshes.at(0).triangles.size(), 1u);
    EXPECT_EQ(loadScene({folder.write("facets", binaryStl(4))}, {}).meshes.at(0).triangles.size(), 4u);
    const fs::path scene = folder.write("scene", "[[mesh]]\nname = \"m\"\nfile = \"noextension\"\n");
    EXPECT_EQ(loadScene({scene}, {}).meshes.at(0).triangles.size(), 1u) << "a mesh that a scene names is told by its content as well";
    EXPECT_FALSE(isBareMesh(scene));
    // --format is of the inputs, not of what they name.
    told.format = "toml";
    EXPECT_EQ(loadScene({scene}, told).meshes.at(0).triangles.size(), 1u);
}

TEST(FormatOfInput, WhatIsNoModelIsNamedInOneLine) {
    const TemporaryFolder folder;
    const auto refusal = [&](const fs::path& path) {
        const std::string text = refusalOf([&] { loadScene({path}, {}); });
        EXPECT_EQ(text.find('\n'), text.npos);
        EXPECT_EQ(text.find(path.string()), 0u) << text;
        return text;
    };
    EXPECT_NE(refusal(folder.path()).find("is a folder"), std::string::npos);
    fs::create_directory(folder.path() / "f.obj");
    EXPECT_NE(refusal(folder.path() / "f.obj").find("is a folder"), std::string::npos);
    for (const char* name : {"picture.png", "noextension"}) {
        const std::string text = refusal(folder.write(name, "\x89PNG\r\n\x1a\n"));
        EXPECT_NE(text.find("--format names it: obj, ply, stl, off, gltf, toml"), std::string::npos) << text;
    }
    EXPECT_NE(refusal(folder.path() / "missing").find("No such file"), std::string::npos);
    EXPECT_NE(refusal(folder.path() / "missing.obj").find("No such file"), std::string::npos);
    EXPECT_NE(refusal("/dev/zero").find("--format"), std::string::npos) << "a device is never opened";
}

// A FIFO as an input: it is waited for, read to its end, and remembered until its bytes are not needed any more.
TEST(Fifo, IsReadOnceAndRemembered) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "pipe";
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    const std::string bytes = binaryStl(50000);  // many times what a pipe holds
    std::jthread writer([&] { std::ofstream(path, std::ios::binary) << bytes; });
    LoadOptions options;
    const Scene scene = loadScene({path}, options);
    EXPECT_EQ(scene.meshes.at(0).triangles.size(), 50000u);
    EXPECT_EQ(readInput(path, options), bytes);
    EXPECT_THROW(loadScene({path}, options), Error) << "a second time";
}

TEST(Fifo, IsNoReferenceOfAScene) {
    const TemporaryFolder folder;
    ASSERT_EQ(::mkfifo((folder.path() / "pipe.obj").c_str(), 0600), 0);
    const fs::path scene = folder.write("scene.toml", "[[mesh]]\nname = \"m\"\nfile = \"pipe.obj\"\n");
    EXPECT_NE(refusalOf([&] { loadScene({scene}, {}); }).find("is a FIFO"), std::string::npos);
}

TEST(Fifo, AnInterruptEndsTheWaitForItsWriter) {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "pipe";
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    LoadOptions options;
    int calls = 0;
    options.onProgress = [&](double, const char*) {
        if (++calls == 3) throw Error(Exit::interrupted, "interrupted");
    };
    EXPECT_THROW(loadScene({path}, options), Error);
    EXPECT_EQ(calls, 3);
}

// A mesh of `side` x `side` squares in each format.
std::vector<std::pair<std::string, std::string>> largeFiles(uint32_t side) {
    std::string vertices, objFaces, offFaces, plyFaces, tomlVertices, tomlFaces;
    for (uint32_t y = 0; y <= side; ++y)
        for (uint32_t x = 0; x <= side; ++x) {
            vertices += fmt::format("{} {} {}\n", x, y, x * y % 7);
            tomlVertices += fmt::format("[{}, {}, {}],\n", x, y, x * y % 7);
        }
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const uint32_t a = y * (side + 1) + x, b = a + 1, c = b + side + 1, d = c - 1;
            objFaces += fmt::format("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1);
            offFaces += fmt::format("4 {} {} {} {}\n", a, b, c, d);
            tomlFaces += fmt::format("[{}, {}, {}, {}],\n", a, b, c, d);
        }
    const uint32_t n = (side + 1) * (side + 1), f = side * side;
    std::string obj;
    for (size_t at = 0; at < vertices.size();) {
        const size_t end = vertices.find('\n', at) + 1;
        obj += "v " + vertices.substr(at, end - at);
        at = end;
    }
    return {{"a.obj", obj + objFaces},
            {"a.off", fmt::format("OFF\n{} {} 0\n", n, f) + vertices + offFaces},
            {"a.ply", fmt::format("ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement "
                                  "face {}\nproperty list uchar int vertex_indices\nend_header\n",
                                  n, f) +
                          vertices + offFaces},
            {"a.stl", binaryStl(2 * f)},
            {"a.toml", "[[mesh]]\nname = \"m\"\nvertices = [\n" + tomlVertices + "]\nfaces = [\n" + tomlFaces + "]\n"}};
}

// From 0 to 1 in every format, never falling within a stage, in steps that are small beside the whole; and whatever step is met ends the load.
TEST(Progress, IsToldOfEveryFormatAndMayEndTheLoadAnywhere) {
    const TemporaryFolder folder;
    for (const auto& [name, bytes] : largeFiles(250)) {
        const fs::path path = folder.write(name, bytes);
        std::vector<std::pair<double, std::string>> told;
        LoadOptions options;
        options.onProgress = [&](double share, const char* stage) { told.emplace_back(share, stage); };
        loadScene({path}, options);
        ASSERT_GE(told.size(), 10u) << name;
        std::set<std::string> stages;
        for (size_t i = 0; i < told.size(); ++i) {
            stages.insert(told[i].second);
            EXPECT_GE(told[i].first, 0) << name;
            EXPECT_LE(told[i].first, 1) << name;
            if (i > 0 && told[i].second == told[i - 1].second) {
                EXPECT_GE(told[i].first, told[i - 1].first) << name << " step " << i;
            }
        }
        EXPECT_EQ(stages, (std::set<std::string>{"finish", "parse", "read"})) << name;
        for (size_t end = 0; end < told.size(); end += std::max<size_t>(1, told.size() / 20)) {
            size_t calls = 0;
            options.onProgress = [&](double, const char*) {
                if (calls++ == end) throw Error(Exit::interrupted, "interrupted");
            };
            EXPECT_THROW(loadScene({path}, options), Error) << name << " step " << end;
            EXPECT_EQ(calls, end + 1) << name;
        }
    }
}

TEST(Progress, FilesHaveTheirPartsOfTheWhole) {
    const TemporaryFolder folder;
    const fs::path a = folder.write("a.obj", kTriangle), b = folder.write("b.obj", kTriangle);
    double last = 0;
    LoadOptions options;
    options.onProgress = [&](double share, const char*) {
        EXPECT_GE(share, last);
        last = share;
    };
    loadScene({a, b, a, b}, options);
    EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace plumb
