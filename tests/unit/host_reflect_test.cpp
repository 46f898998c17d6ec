// SPDX-License-Identifier: MIT
// What the reflection reads out of SPIR-V words.
#include "host/error.h"
#include "host/program.h"

#include <gtest/gtest.h>
#include <spirv/host_reflect.h>
#include <cstdint>
#include <span>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace plumb {
namespace {

TEST(Reflection, ReadsEveryKindOfDeclaration) {
    const Reflection r = reflect(spirv::host_reflect, {{3, 32}});
    ASSERT_EQ(r.bindings.size(), 8u);
    for (uint32_t i = 0; i < 8; ++i) EXPECT_EQ(r.bindings[i].binding, i);
    EXPECT_EQ(r.bindings[0].strideBytes, 8u);
    EXPECT_EQ(r.bindings[1].strideBytes, 12u + 4u + 36u + 20u);
    EXPECT_TRUE(r.bindings[1].readonly);
    EXPECT_FALSE(r.bindings[1].writeonly);
    EXPECT_EQ(r.bindings[2].strideBytes, 12u) << "a block without run-time array is one element";
    EXPECT_TRUE(r.bindings[2].writeonly);
    EXPECT_EQ(r.bindings[2].name, "counters");
    EXPECT_EQ(r.bindings[3].kind, BindingKind::uniformTexel);
    EXPECT_EQ(r.bindings[3].texel, TexelType::unsignedInt);
    EXPECT_EQ(r.bindings[4].texel, TexelType::floating);
    EXPECT_EQ(r.bindings[5].texel, TexelType::signedInt);
    EXPECT_EQ(r.bindings[6].kind, BindingKind::uniformBuffer);
    EXPECT_EQ(r.bindings[7].strideBytes, 8u) << "the element, not the header";
    EXPECT_EQ(r.pushConstantBytes, 4u + 12u + 64u + 16u);
    EXPECT_EQ(r.localSize[0], 32u);
    EXPECT_EQ(r.localSize[1], 2u);
    EXPECT_EQ(reflect(spirv::host_reflect).localSize[0], 1u);
    EXPECT_EQ(r.specializationIds, (std::vector<uint32_t>{3, 9}));
    EXPECT_EQ(r.specializationNames[1], "kScale");
}

std::vector<uint32_t> wordsOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    std::vector<uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), words.size() * 4);
    return words;
}

TEST(Reflection, UnderstandsEveryEmbeddedModule) {
    int modules = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(PLUMB_BINARY_DIR) / "generated/spirv")) {
        const std::string name = entry.path().filename();
        if (!name.ends_with(".spv") || name.ends_with(".raw.spv")) continue;
        const std::vector<uint32_t> words = wordsOf(entry.path());
        const Reflection r = reflect({name, words, ""});
        ++modules;
        ASSERT_FALSE(r.bindings.empty()) << name;
        EXPECT_EQ(r.bindings[0].strideBytes, 8u) << name << ": binding 0 is not the status";
        EXPECT_GE(r.pushConstantBytes, 4u) << name;
        EXPECT_LE(r.pushConstantBytes, 128u) << name << ": Vulkan promises no more push constants than 128 bytes";
        EXPECT_LE(r.localSize[0] * r.localSize[1] * r.localSize[2], 256u) << name;
        for (const ReflectedBinding& b : r.bindings)
            EXPECT_TRUE(b.kind == BindingKind::uniformTexel || b.strideBytes > 0) << name << ": " << b.name;
    }
    EXPECT_GE(modules, 5);
}

// Words that are damaged anywhere are refused or read, never followed out of bounds (run under the sanitizers).
TEST(Reflection, SurvivesDamagedWords) {
    const std::span<const uint32_t> good = spirv::host_reflect.words;
    std::vector<uint32_t> words;
    const auto attempt = [&] {
        try {
            reflect({"damaged", words, ""});
        } catch (const Error& error) {
            EXPECT_EQ(error.exit(), Exit::device);
            EXPECT_EQ(std::string(error.what()).rfind("damaged: ", 0), 0u);
        }
    };
    for (size_t i = 0; i < good.size(); ++i) {
        words.assign(good.begin(), good.begin() + long(i));
        attempt();
        for (const uint32_t wrong : {0u, 1u, 0xffffffffu, 0x00010000u, good[i] + 1, good[i] ^ 0x00010000u, std::rotl(good[i], 16)}) {
            words.assign(good.begin(), good.end());
            words[i] = wrong;
            attempt();
        }
    }
}

TEST(Embedding, DecoratesEveryFloatOperationOnce) {
    const std::span<const uint32_t> words = spirv::host_reflect.words;
    int operations = 0, decorations = 0;
    for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
        const uint32_t op = words[at] & 0xffffu;
        operations += op == 129 || op == 131 || op == 133 || op == 142 || op == 127 || op == 136;
        decorations += op == 71 && words[at + 2] == 42;
    }
    EXPECT_GT(operations, 0);
    EXPECT_EQ(operations, decorations);
}

TEST(Embedding, NamesTheModuleAndItsHash) {
    EXPECT_EQ(spirv::host_reflect.name, "host_reflect");
    EXPECT_EQ(spirv::host_reflect.sha256.size(), 64u);
}

}  // namespace
}  // namespace plumb
