// SPDX-License-Identifier: MIT
// Folding leaves modules valid, declared as before and exact; spirv-val and the reflection judge every embedded module under many constants. That a
// folded module computes the same is what every twin test says, since all dispatches run folded modules.
#include "host/error.h"
#include "host/fold.h"

#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <spirv/host_add.h>
#include <spirv/host_reflect.h>
#include <cstdint>
#include <span>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace plumb {
namespace {

struct Loaded {
    std::string name;
    std::vector<uint32_t> words;
    Module module() const { return {name, words, ""}; }
};

std::vector<Loaded> embeddedModules() {
    std::vector<Loaded> all;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(PLUMB_BINARY_DIR) / "generated/spirv")) {
        const std::string name = entry.path().filename();
        if (!name.ends_with(".spv") || name.ends_with(".raw.spv")) continue;
        std::ifstream file(entry.path(), std::ios::binary);
        const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
        all.push_back({name, std::vector<uint32_t>(bytes.size() / 4)});
        std::memcpy(all.back().words.data(), bytes.data(), all.back().words.size() * 4);
    }
    return all;
}

// Float operations without NoContraction.
size_t contractible(std::span<const uint32_t> words) {
    std::set<uint32_t> exact;
    size_t count = 0;
    for (size_t i = 5; i < words.size(); i += words[i] >> 16) {
        const uint32_t op = words[i] & 0xffff;
        if (op == 71 && words[i + 2] == 42) exact.insert(words[i + 1]);
        const bool real = op == 127 || op == 129 || op == 131 || op == 133 || op == 136 || op == 142;
        count += real && !exact.contains(words[i + 2]);
    }
    return count;
}

ConstantsById someConstants(const Reflection& r, std::mt19937& random) {
    constexpr uint32_t kValues[] = {0, 1, 2, 3, 4, 8, 16, 31, 32, 33};
    ConstantsById constants;
    for (size_t i = 0; i < r.specializationIds.size(); ++i) {
        const std::string& name = r.specializationNames[i];
        if (name.find("Size") != std::string::npos) continue;  // workgroups and subgroups have sizes of their own
        if (random() % 3) constants[r.specializationIds[i]] = kValues[random() % std::size(kValues)];
    }
    return constants;
}

TEST(Fold, LeavesEveryModuleValidDeclaredAsBeforeAndExact) {
    const test::TemporaryFolder folder;
    size_t modules = 0, shorter = 0;
    std::string files;
    for (const Loaded& loaded : embeddedModules()) {
        const Reflection before = reflect(loaded.module());
        std::seed_seq seed(loaded.name.begin(), loaded.name.end());  // the same constants whatever other modules there are
        std::mt19937 random(seed);
        for (int round = 0; round < 12; ++round) {
            const ConstantsById constants = round == 0 ? ConstantsById() : someConstants(before, random);
            const std::vector<uint32_t> words = foldConstants(loaded.module(), constants);
            EXPECT_LT(words.size(), loaded.words.size()) << loaded.name;
            const Reflection after = reflect({loaded.name, words, ""}, constants);
            ASSERT_EQ(after.bindings.size(), before.bindings.size()) << loaded.name;
            for (size_t b = 0; b < before.bindings.size(); ++b) {
                EXPECT_EQ(after.bindings[b].kind, before.bindings[b].kind) << loaded.name;
                EXPECT_EQ(after.bindings[b].strideBytes, before.bindings[b].strideBytes) << loaded.name;
            }
            EXPECT_EQ(after.pushConstantBytes, before.pushConstantBytes) << loaded.name;
            EXPECT_EQ(after.specializationIds, before.specializationIds) << loaded.name;
            EXPECT_LE(contractible(words), contractible(loaded.words)) << loaded.name;
            EXPECT_EQ(foldConstants({loaded.name, words, ""}, constants), words) << loaded.name << ": a second time finds something";
            const std::filesystem::path path = folder.path() / fmt::format("{}-{}.spv", loaded.name, round);
            std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(words.data()), std::streamsize(words.size() * 4));
            files += fmt::format("'{}' --target-env vulkan1.2 --scalar-block-layout '{}' || exit 1\n", PLUMB_SPIRV_VAL, path.string());
            shorter += words.size() < loaded.words.size() / 2;
        }
        ++modules;
    }
    EXPECT_GT(modules, 25u);
    EXPECT_GT(shorter, 20u) << "little is folded";
    const std::filesystem::path script = folder.path() / "validate.sh";
    std::ofstream(script) << files;
    EXPECT_EQ(std::system(("sh '" + script.string() + "'").c_str()), 0) << "spirv-val refuses a folded module";
}

TEST(Fold, TakesTheSideThatTheConstantsSay) {
    size_t differ = 0;
    for (const Loaded& loaded : embeddedModules()) {
        const Reflection r = reflect(loaded.module());
        for (size_t i = 0; i < r.specializationIds.size(); ++i) {
            if (r.specializationNames[i].find("Size") != std::string::npos) continue;
            differ += foldConstants(loaded.module(), {{r.specializationIds[i], 0}}) !=
                      foldConstants(loaded.module(), {{r.specializationIds[i], 1}});
        }
    }
    EXPECT_GT(differ, 50u) << "constants that branches ask for";
}

TEST(Fold, RefusesWordsThatAreNoModule) {
    const std::span<const uint32_t> good = spirv::host_add.words;
    const auto refused = [](std::vector<uint32_t> words) {
        try {
            foldConstants({"broken", words, ""}, {});
        } catch (const Error& error) {
            return error.exit() == Exit::device && std::string(error.what()).find("broken") != std::string::npos;
        }
        return false;
    };
    EXPECT_TRUE(refused({}));
    EXPECT_TRUE(refused({good.begin() + 1, good.end()}));
    std::vector<uint32_t> words(good.begin(), good.end());
    words[3] = 1;
    EXPECT_TRUE(refused(words)) << "ids beyond the bound";
    words[3] = ~0u;
    EXPECT_TRUE(refused(words)) << "a bound beyond reason";
    size_t cut = 0;
    for (size_t length = 0; length < good.size(); ++length) {
        try {
            foldConstants({"cut", good.first(length), ""}, {});
        } catch (const Error&) {
            ++cut;
        }
    }
    EXPECT_GT(cut, good.size() / 2) << "and none read beyond its end (the sanitizers watch)";
}

}  // namespace
}  // namespace plumb
