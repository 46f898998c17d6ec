// SPDX-License-Identifier: MIT
// Makes a capsule of each planted fault of a device: the pictures of the suite are drawn on a device with the faulty modules until one
// differs, its scene is reduced, and the capsule is written, read back and run again. toolchain/capsule_plants.py builds the modules.
// usage: capsule_plants MANIFEST.json FOLDER SECONDS    one JSON object a fault on standard output
#include "host/driver.h"
#include "host/error.h"
#include "host/replay.h"
#include "pipeline/suite/capsule.h"
#include "pipeline/suite/reduce.h"
#include "pipeline/suite/suite.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace {

using namespace plumb;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Planted = std::map<std::string, std::vector<uint32_t>, std::less<>>;

constexpr uint32_t kReplays = 20;

Device opened(const char* limits, const Planted& planted) {
    DeviceRequest request;
    request.prefer = request.require = "lavapipe";
    Device device = Device::open(Device::choose(request), request);
    if (*limits) shrink(device, limits);
    plantModules(device, planted);
    return device;
}

std::string textOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

Planted plantedOf(const Json& modules) {
    Planted planted;
    for (const auto& [name, path] : modules.items()) {
        const std::string bytes = textOf(path.get<std::string>());
        std::vector<uint32_t>& words = planted[name];
        words.resize(bytes.size() / 4);
        std::memcpy(words.data(), bytes.data(), words.size() * 4);
    }
    return planted;
}

// Modules that each picture runs.
std::vector<std::set<std::string, std::less<>>> modulesOfPictures() {
    std::vector<std::set<std::string, std::less<>>> modules;
    for (const suite::PictureTest& test : suite::pictureTests()) {
        const Device device = opened(test.limits, {});
        Device& used = const_cast<Device&>(device);
        const std::string pass = suite::differingPass(used, test.scene(test.width, test.height), suite::requestOf(test, 1));
        if (!pass.empty()) std::fprintf(stderr, "%s differs without a fault: %s\n", test.name, pass.c_str());
        modules.push_back(modulesRun(device));
    }
    return modules;
}

Json capsuleOf(const suite::PictureTest& test, Device& device, const std::string& pass, const fs::path& folder, double seconds) {
    Json json;
    const auto start = std::chrono::steady_clock::now();
    const suite::Reduced reduced = suite::reduce(device, test.scene(test.width, test.height), suite::requestOf(test, 1), pass,
                                                 std::chrono::milliseconds(int64_t(seconds * 1000)), {});
    json["reduce_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    json["triangles"] = reduced.triangles;
    json["triangles_before"] = reduced.trianglesBefore;
    json["tried"] = reduced.tried;
    const std::optional<suite::Capsule> capsule = suite::capsuleOf(device, reduced, Json());
    if (!capsule) return json["what"] = "the sides of the reduced picture agree", json;
    fs::create_directories(folder);
    uint64_t bytes = 0;
    for (const auto& [name, text] : suite::filesOf(*capsule)) {
        std::ofstream(folder / name, std::ios::binary) << text;
        bytes += text.size();
    }
    json["bytes"] = bytes;
    const suite::Capsule read = suite::readCapsule(folder);
    json["module"] = read.dispatch.module;
    json["located"] = read.location.has_value();
    json["failure"] = read.dispatch.failure;
    uint32_t captured = 0;
    const Device plain = opened("", {});  // the capsule has the faulty words
    for (uint32_t n = 0; n < kReplays; ++n)
        captured += suite::outcomeOf(read, replay(const_cast<Device&>(plain), read.dispatch, 60000)) == suite::Outcome::captured;
    json["captured"] = captured;
    return json;
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 4) return std::fprintf(stderr, "usage: capsule_plants MANIFEST.json FOLDER SECONDS\n"), 2;
    const Json manifest = Json::parse(textOf(arguments[1]));
    const std::vector<std::set<std::string, std::less<>>> modules = modulesOfPictures();
    const std::span<const suite::PictureTest> pictures = suite::pictureTests();
    for (const Json& row : manifest) {
        const Planted planted = plantedOf(row.at("modules"));
        Json json = {{"name", row.at("name")}, {"picture", nullptr}};
        std::map<std::string, Device> devices;
        for (size_t i = 0; i < pictures.size() && json["picture"].is_null(); ++i) {
            const suite::PictureTest& test = pictures[i];
            if (std::none_of(planted.begin(), planted.end(), [&](const auto& p) { return modules[i].contains(p.first); })) continue;
            auto device = devices.find(test.limits);
            if (device == devices.end()) device = devices.emplace(test.limits, opened(test.limits, planted)).first;
            try {
                const std::string pass =
                    suite::differingPass(device->second, test.scene(test.width, test.height), suite::requestOf(test, 1));
                if (pass.empty()) continue;
                json["picture"] = test.name;
                json["pass"] = pass;
                json.update(capsuleOf(test, device->second, pass, fs::path(arguments[2]) / row.at("name").get<std::string>(),
                                      std::atof(arguments[3])));
            } catch (const Error& error) {
                json["what"] = error.what();
            }
        }
        std::printf("%s\n", json.dump().c_str());
        std::fflush(stdout);
    }
    return 0;
}
