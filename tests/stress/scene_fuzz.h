// SPDX-License-Identifier: MIT
// Scenes for differential fuzzing, ordinary and hostile: each is made from a seed and its number, is text that `plumb verify` takes, and can be made
// smaller piece by piece.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace plumb::test {

// A scene file in pieces that may be left out one by one, and the flags beside it.
struct FuzzScene {
    struct Mesh {
        std::string name, material;
        double creaseDegrees = 60;
        std::vector<std::array<double, 3>> vertices;
        std::vector<std::vector<uint32_t>> faces;
    };
    std::vector<std::string> settings;                                     // lines before the first table
    std::string camera;                                                    // lines of [camera]
    std::vector<std::string> materials, lights, objects, spheres, planes;  // tables
    std::vector<Mesh> meshes;
    uint32_t width = 1, height = 1;
    std::vector<std::string> flags;  // each a flag with its value, "--samples 4"
    bool heldAgainstTruth = false;   // Phong with the default choices, or rays through the middle of each pixel
    bool rays = false;               // of these

    // The scene file; its first line is the comment kFlagsLine with the flags.
    std::string text() const;
    // "--size 63x17 --samples 4"
    std::string flagsText() const;
};
inline constexpr const char* kFlagsLine = "# plumb verify: ";

// One in so many scenes is of the kind that the truth is compared with, and one that the truth of rays is compared with.
inline constexpr uint64_t kTruthEvery = 5, kRayTruthAt = 3;
// Scenes one after another that share what kernels are made for (shading, samples, trade, numbers of lights and shapes): a kernel costs more to make
// than hundreds of small pictures cost to draw.
inline constexpr uint64_t kScenesOfFamily = 25;
// Scene of a seed and a number: always the same one, whatever was made before.
FuzzScene fuzzScene(uint64_t seed, uint64_t number);

// The smallest scene that is found by leaving out objects, faces, lights, shapes, settings and flags, and by shrinking the picture, as long as
// `fails(scene)` stays true; at most `most` calls of it.
FuzzScene reduced(FuzzScene scene, const std::function<bool(const FuzzScene&)>& fails, uint32_t most);

}  // namespace plumb::test
