// SPDX-License-Identifier: MIT
// The committed pairs against what other programs said about them (tests/data/compare/make_witness.py).
#include "pipeline/compare/compare.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace plumb {
namespace {

using Json = nlohmann::json;

constexpr double kExact = 1e-6;      // PSNR in dB, and what is a plain sum: the measure of the project
constexpr double kPerceived = 1e-3;  // SSIM, FLIP, CIEDE2000: programs differ in constants of the white and in float32

TEST(CompareWitness, AgreesWithOtherPrograms) {
    const std::string folder = std::string(PLUMB_SOURCE_DIR) + "/tests/data/compare/";
    std::ifstream file(folder + "witness.json");
    const Json witness = Json::parse(file);
    size_t flips = 0;
    for (const auto& [name, want] : witness.at("pairs").items()) {
        SCOPED_TRACE(name);
        const LayerDifference d = compare(readPicture(folder + name + "_a.png"), readPicture(folder + name + "_b.png"), {}).layers.at(0);
        EXPECT_NEAR(*d.psnr, want.at("psnr"), kExact);
        EXPECT_NEAR(*d.mean, want.at("mean"), kExact);
        EXPECT_NEAR(*d.rmse, want.at("rmse"), kExact);
        EXPECT_NEAR(*d.max, want.at("max"), kExact);
        EXPECT_EQ(d.differing, want.at("differing"));
        EXPECT_NEAR(d.ssim->mean, want.at("ssim"), kPerceived);
        EXPECT_NEAR(d.deltaE->mean, want.at("deltae_mean"), kPerceived);
        EXPECT_NEAR(d.deltaE->worst, want.at("deltae_max"), kPerceived);
        fmt::print("{}: psnr {:.2g}, ssim {:.2g}, deltae {:.2g}", name, std::abs(*d.psnr - want.at("psnr").get<double>()),
                   std::abs(d.ssim->mean - want.at("ssim").get<double>()), std::abs(d.deltaE->mean - want.at("deltae_mean").get<double>()));
        if (want.contains("flip")) {
            ++flips;
            EXPECT_NEAR(d.flip->mean, want.at("flip").at("mean"), kPerceived);
            EXPECT_NEAR(d.flip->worst, want.at("flip").at("max"), kPerceived);
            fmt::print(", flip {:.2g}", std::abs(d.flip->mean - want.at("flip").at("mean").get<double>()));
        }
        fmt::print(" from the witness\n");
    }
    EXPECT_EQ(witness.at("pairs").size(), 5u);
    EXPECT_EQ(flips, 4u);
}

}  // namespace
}  // namespace plumb
