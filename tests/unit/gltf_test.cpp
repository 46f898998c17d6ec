// SPDX-License-Identifier: MIT
// glTF 2.0: what it becomes, and how it is refused. The files are written by the tests: a quadrilateral of four
// vertices, in pieces that each case replaces.
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;
using glm::dvec4;
using nlohmann::json;
using test::TemporaryFolder;

constexpr double kDouble = 1e-12;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

template <class T>
void append(std::string& bytes, std::initializer_list<T> values) {
    for (const T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Bytes 0 to 47: positions; 48 to 95: normals; 96 to 107: indices (u16) of two triangles.
std::string quadBytes() {
    std::string bytes;
    append<float>(bytes, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    append<float>(bytes, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    append<uint16_t>(bytes, {0, 1, 2, 0, 2, 3});
    return bytes;
}

json quad() {
    return json::parse(R"({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "quad", "mesh": 0}],
        "meshes": [{"name": "quad", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 48},
            {"buffer": 0, "byteOffset": 96, "byteLength": 12}],
        "buffers": [{"byteLength": 108, "uri": "quad.bin"}]
    })");
}

Scene load(const json& document, const std::string& bytes = quadBytes(), const LoadOptions& options = {}) {
    TemporaryFolder folder;
    folder.write("quad.bin", bytes);
    return readGltf(folder.write("quad.gltf", document.dump()), options);
}

json with(const std::string& pointer, const json& value, json document = quad()) {
    document[json::json_pointer(pointer)] = value;
    return document;
}

std::string glb(const std::string& text, const std::string& binary, uint32_t version = 2) {
    std::string json = text, data = binary;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    data.resize((data.size() + 3) / 4 * 4, '\0');
    std::string bytes = "glTF";
    append<uint32_t>(bytes, {version, uint32_t(12 + 8 + json.size() + 8 + data.size()), uint32_t(json.size()), 0x4e4f534a});
    bytes += json;
    append<uint32_t>(bytes, {uint32_t(data.size()), 0x004e4942});
    return bytes + data;
}

std::string quadGlb() {
    json document = quad();
    document["buffers"][0].erase("uri");
    return glb(document.dump(), quadBytes());
}

// The refusal of a file, without the folder's name; "" when it was loaded.
std::string refusal(const TemporaryFolder& folder, const std::filesystem::path& file, const LoadOptions& options = {}) {
    try {
        readGltf(file, options);
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input) << error.what();
        std::string message = error.what();
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        const std::string prefix = folder.path().string() + "/";
        return message.starts_with(prefix) ? message.substr(prefix.size()) : message;
    }
}

std::string refusal(const json& document, const std::string& bytes = quadBytes(), const LoadOptions& options = {}) {
    TemporaryFolder folder;
    folder.write("quad.bin", bytes);
    return refusal(folder, folder.write("quad.gltf", document.dump()), options);
}

void expectQuad(const Scene& scene) {
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].name, "quad");
    const TriangleMesh& mesh = scene.meshes.at(scene.objects[0].mesh);
    EXPECT_EQ(mesh.positions.size(), 4u);
    ASSERT_EQ(mesh.triangles.size(), 2u);
    for (const glm::vec3& normal : mesh.faceNormal) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    for (const glm::vec3& normal : mesh.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(mesh.boundsMax, glm::vec3(1, 1, 0));
    EXPECT_TRUE(scene.ignored.empty());
}

TEST(Gltf, ReadsAFileBesideIt) { expectQuad(load(quad())); }

TEST(Gltf, ReadsBase64) {
    static const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::string bytes = quadBytes();
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const uint32_t bits = uint32_t(uint8_t(bytes[i])) << 16 | uint32_t(uint8_t(bytes[i + 1])) << 8 | uint8_t(bytes[i + 2]);
        for (int shift = 18; shift >= 0; shift -= 6) text.push_back(kDigits[bits >> shift & 63]);
    }
    for (const char* start : {"data:application/octet-stream;base64,", "data:application/gltf-buffer;base64,", "data:;base64,"})
        expectQuad(load(with("/buffers/0/uri", start + text)));
    // Padding: one and two bytes left over, which the byteLength must not count.
    EXPECT_EQ(refusal(with("/buffers/0/uri", "data:;base64," + text + "AA==")), "");
    EXPECT_EQ(refusal(with("/buffers/0/uri", "data:;base64," + text + "AAA=")), "");
}

TEST(Gltf, ReadsGlb) {
    TemporaryFolder folder;
    expectQuad(readGltf(folder.write("quad.glb", quadGlb()), {}));
    expectQuad(readGltf(folder.write("quad.gltf", quadGlb()), {}));  // by its first bytes, not by its name
}

TEST(Gltf, DecodesPercentSignsOfFileNames) {
    TemporaryFolder folder;
    folder.write("my quad.bin", quadBytes());
    expectQuad(readGltf(folder.write("quad.gltf", with("/buffers/0/uri", "my%20quad.bin").dump()), {}));
}

TEST(Gltf, ReadsEveryIndexType) {
    std::string bytes = quadBytes().substr(0, 96);
    append<uint8_t>(bytes, {0, 1, 2, 0, 2, 3});
    append<uint8_t>(bytes, {0, 0});
    append<uint32_t>(bytes, {0, 1, 2, 0, 2, 3});
    json document = quad();
    document["buffers"][0]["byteLength"] = bytes.size();
    document["bufferViews"][2] = {{"buffer", 0}, {"byteOffset", 96}, {"byteLength", 6}};
    document["accessors"][2]["componentType"] = 5121;
    expectQuad(load(document, bytes));
    document["bufferViews"][2] = {{"buffer", 0}, {"byteOffset", 104}, {"byteLength", 24}};
    document["accessors"][2]["componentType"] = 5125;
    expectQuad(load(document, bytes));
}

TEST(Gltf, StripsAndFansKeepTheirWinding) {
    std::string strip = quadBytes().substr(0, 96), fan = strip;
    append<uint16_t>(strip, {0, 1, 3, 2, 2, 2});
    append<uint16_t>(fan, {0, 1, 2, 3, 3, 3});
    json document = with("/accessors/2/count", 4);
    document["meshes"][0]["primitives"][0]["mode"] = 5;
    expectQuad(load(document, strip));
    document["meshes"][0]["primitives"][0]["mode"] = 6;
    expectQuad(load(document, fan));
}

TEST(Gltf, ReadsInterleavedAndUnindexed) {
    std::string bytes;
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {1.f, 0.f}, {1.f, 1.f}, {0.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}})
        append<float>(bytes, {x, y, 0, 0, 0, 1});
    json document = quad();
    document["buffers"][0]["byteLength"] = bytes.size();
    document["bufferViews"] = json::parse(R"([{"buffer": 0, "byteLength": 144, "byteStride": 24}])");
    document["accessors"] = json::parse(R"([
        {"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"},
        {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 6, "type": "VEC3"}])");
    document["meshes"][0]["primitives"][0].erase("indices");
    expectQuad(load(document, bytes));  // and the six corners are welded into four
}

TEST(Gltf, ReadsSparseAccessors) {
    std::string bytes = quadBytes();
    append<uint16_t>(bytes, {2, 0});
    append<float>(bytes, {1, 5, 0});
    json document = quad();
    document["buffers"][0]["byteLength"] = bytes.size();
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 108}, {"byteLength", 2}});
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 112}, {"byteLength", 12}});
    document["accessors"][0]["sparse"] =
        json::parse(R"({"count": 1, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 4}})");
    const Scene scene = load(document, bytes);
    EXPECT_EQ(scene.meshes.at(0).boundsMax, glm::vec3(1, 5, 0));
    document["accessors"][0]["sparse"]["count"] = 2;
    EXPECT_NE(refusal(document, bytes).find("/accessors/0/sparse/count"), std::string::npos);
    document["accessors"][0]["sparse"]["count"] = 1;
    bytes[108] = 4;
    EXPECT_NE(refusal(document, bytes).find("/accessors/0/sparse/indices: element 0 is 4"), std::string::npos);
}

TEST(Gltf, ReadsQuantizedPositions) {
    std::string bytes;
    append<int16_t>(bytes, {0, 0, 0, 0, 32767, 0, 0, 0, 32767, 32767, 0, 0, 0, 32767, 0, 0});
    append<int8_t>(bytes, {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0});
    append<uint16_t>(bytes, {0, 1, 2, 0, 2, 3});
    json document = quad();
    document["extensionsRequired"] = {"KHR_mesh_quantization"};
    document["buffers"][0]["byteLength"] = bytes.size();
    document["bufferViews"] = json::parse(R"([{"buffer": 0, "byteLength": 32, "byteStride": 8},
        {"buffer": 0, "byteOffset": 32, "byteLength": 16, "byteStride": 4}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}])");
    document["accessors"][0]["componentType"] = 5122;
    document["accessors"][0]["normalized"] = true;
    document["accessors"][1]["componentType"] = 5120;
    document["accessors"][1]["normalized"] = true;
    expectQuad(load(document, bytes));
}

TEST(Gltf, WithoutNormalsFacesAreFlat) {
    std::string bytes;
    append<float>(bytes, {0, 0, 0, 1, 0, 0, 1, 1, 0.1f, 0, 1, 0});
    append<float>(bytes, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    append<uint16_t>(bytes, {0, 1, 2, 0, 2, 3});
    json document = quad();
    document["meshes"][0]["primitives"][0]["attributes"].erase("NORMAL");
    const TriangleMesh mesh = load(document, bytes).meshes.at(0);
    ASSERT_EQ(mesh.triangles.size(), 2u);
    for (const auto& triangle : mesh.triangles)
        for (uint32_t vertex : triangle.vertex) EXPECT_EQ(mesh.normals[vertex], mesh.faceNormal[triangle.face]);
    EXPECT_EQ(mesh.edges.size(), 5u);
}

TEST(Gltf, ComposesNodesInDouble) {
    json document = quad();
    const double h = std::sqrt(0.5);
    document["nodes"] = {{{"children", {1, 2}}, {"translation", {1, 0, 0}}, {"rotation", {0, 0, h, h}}, {"scale", {2, 2, 2}}},
                         {{"name", "matrix"}, {"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1}}},
                         {{"name", "plain"}, {"mesh", 0}}};
    const Scene scene = load(document);
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.objects[0].mesh, scene.objects[1].mesh) << "instances share a mesh";
    EXPECT_EQ(scene.meshes.size(), 1u);
    const auto at = [](const Object& object, const dvec3& p) { return dvec3(object.worldFromObject * dvec4(p, 1)); };
    // (0,0,0) -> (3,4,5) -> doubled (6,8,10) -> a quarter turn about Z (-8,6,10) -> (-7,6,10)
    const dvec3 got = at(scene.objects[0], dvec3(0)), want(-7, 6, 10);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], want[i], 10 * kDouble);
    const dvec3 turned = at(scene.objects[1], dvec3(1, 0, 0));
    EXPECT_NEAR(turned.x, 1, kDouble);
    EXPECT_NEAR(turned.y, 2, kDouble);
}

TEST(Gltf, WithoutScenesEveryRootIsDrawn) {
    json document = quad();
    document.erase("scene");
    document.erase("scenes");
    document["nodes"] = json::parse(R"([{"mesh": 0}, {"children": [0]}, {"mesh": 0}])");
    EXPECT_EQ(load(document).objects.size(), 2u);
}

TEST(Gltf, MaterialsBecomePhong) {
    json document = with("/materials", json::parse(R"([
        {"name": "half", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.5}},
        {"name": "mirror", "pbrMetallicRoughness": {"roughnessFactor": 0}, "emissiveFactor": [0.5, 0, 0],
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_ior": {"ior": 1.4}}},
        {"name": "unlit", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1]}, "extensions": {"KHR_materials_unlit": {}}}])"));
    document["meshes"][0]["primitives"][0]["material"] = 2;
    const Scene scene = load(document);
    ASSERT_EQ(scene.materials.size(), 4u) << "the default one and three";
    const Material& half = scene.materials[1];
    EXPECT_EQ(half.diffuse, glm::vec3(0.5f, 0.25f, 1));
    EXPECT_EQ(half.ambient, glm::vec3(0.05f, 0.025f, 0.1f));
    EXPECT_FLOAT_EQ(half.shininess, 30);      // a = 1/4: 2 * 16 - 2
    EXPECT_FLOAT_EQ(half.specular.r, 0.16f);  // 0.04 / (4 / 16)
    const Material& mirror = scene.materials[2];
    EXPECT_EQ(mirror.shininess, 1e6f);
    EXPECT_EQ(mirror.specular, glm::vec3(1));
    EXPECT_EQ(mirror.emission, glm::vec3(1, 0, 0));
    EXPECT_FLOAT_EQ(mirror.refractiveIndex, 1.4f);
    const Material& unlit = scene.materials[3];
    EXPECT_EQ(unlit.emission, glm::vec3(0.5f, 0.25f, 1));
    EXPECT_EQ(unlit.diffuse, glm::vec3(0));
    EXPECT_EQ(scene.meshes.at(0).faceMaterial.at(0), 3u);
    EXPECT_TRUE(scene.ignored.empty());
}

TEST(Gltf, LightsAndCamerasFollowTheirNodes) {
    json document = quad();
    document["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(R"([
        {"type": "directional", "intensity": 3.141592653589793, "color": [1, 0.5, 0]},
        {"type": "point", "intensity": 6.283185307179586},
        {"type": "spot", "spot": {}}])");
    document["cameras"] = json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.25}}])");
    // A quarter turn about X takes +Z to -Y and -Z to +Y.
    const double h = std::sqrt(0.5);
    document["nodes"] = {{{"mesh", 0}},
                         {{"rotation", {h, 0, 0, h}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                         {{"translation", {1, 2, 3}}, {"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}},
                         {{"extensions", {{"KHR_lights_punctual", {{"light", 2}}}}}},
                         {{"translation", {0.5, 0.5, 7}}, {"camera", 0}, {"scale", {3, 3, 3}}}};
    document["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
    const Scene scene = load(document);
    ASSERT_EQ(scene.lights.size(), 3u);
    EXPECT_TRUE(scene.lights[0].directional);
    EXPECT_NEAR(scene.lights[0].direction.y, -1, kDouble);
    EXPECT_EQ(scene.lights[0].intensity, glm::vec3(1, 0.5f, 0)) << "pi lux are 1";
    EXPECT_EQ(scene.lights[1].position, dvec3(1, 2, 3));
    EXPECT_EQ(scene.lights[1].intensity, glm::vec3(2));
    EXPECT_EQ(scene.lights[1].attenuation, Attenuation::inverseSquare);
    EXPECT_EQ(scene.ignored, std::vector<std::string>{"cones of spot lights"});
    const Camera& camera = scene.camera.value();
    EXPECT_EQ(camera.eye, dvec3(0.5, 0.5, 7));
    EXPECT_EQ(camera.forward, dvec3(0, 0, -1));
    EXPECT_EQ(camera.right, dvec3(1, 0, 0));
    EXPECT_EQ(camera.up, dvec3(0, 1, 0));
    EXPECT_NEAR(camera.fovYDegrees, 0.5 * 180 / 3.14159265358979323846, kDouble * 100);
    EXPECT_EQ(camera.near, 0.25);
    EXPECT_NEAR(camera.focusDistance, 7, kDouble * 10);
}

// What is asked for and not drawn: the change, and the word for it.
TEST(Gltf, IgnoredFeaturesAreNamedOnceAndRefusedWhenStrict) {
    json lines = quad(), noPosition = quad(), flattened = quad();
    lines["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
    lines["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 3}});
    noPosition["meshes"][0]["primitives"].push_back({{"attributes", json::object()}});
    flattened["nodes"].push_back({{"mesh", 0}, {"scale", {1, 0, 1}}});
    flattened["scenes"][0]["nodes"] = {0, 1};
    json orthographic = with("/cameras", json::parse(R"([{"type": "orthographic", "orthographic": {}}])"));
    orthographic["nodes"][0]["camera"] = 0;
    const json textured = json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}}])");
    const std::pair<json, std::string> cases[] = {
        {with("/animations", json::parse(R"([{}, {}])")), "animations"},
        {with("/meshes/0/primitives/0/attributes/COLOR_0", 0), "vertex colours"},
        {with("/materials", textured), "textures"},
        {with("/materials", json::parse(R"([{"alphaMode": "BLEND"}])")), "alphaMode BLEND"},
        {with("/materials", json::parse(R"([{"extensions": {"KHR_materials_clearcoat": {}}}])")), "extension KHR_materials_clearcoat"},
        {with("/nodes/0/extensions", json::parse(R"({"EXT_mesh_lod": {}})")), "extension EXT_mesh_lod"},
        {with("/scenes/1", json::parse(R"({"nodes": []})")), "scenes but the default one"},
        {lines, "lines"},
        {noPosition, "primitives without POSITION"},
        {flattened, "meshes flattened by a scale of 0"},
        {orthographic, "orthographic cameras"},
    };
    LoadOptions strict;
    strict.strict = true;
    for (const auto& [document, what] : cases) {
        EXPECT_EQ(load(document).ignored, std::vector<std::string>{what});
        const std::string message = refusal(document, quadBytes(), strict);
        EXPECT_NE(message.find(what), std::string::npos) << message;
        EXPECT_TRUE(message.starts_with("quad.gltf: /")) << message;
    }
    EXPECT_EQ(refusal(quad(), quadBytes(), strict), "");
}

struct BadDocument {
    json document;
    std::string pointer, words;
};

std::vector<BadDocument> badDocuments() {
    std::vector<BadDocument> rows;
    // A value put at a pointer, refused there unless told otherwise.
    const auto put = [&](const std::string& pointer, const json& value, const std::string& words, const std::string& place = "") {
        rows.push_back({with(pointer, value), place.empty() ? pointer : place, words});
    };
    const auto drop = [&](const std::string& parent, const std::string& key, const std::string& words, const std::string& place = "") {
        json document = quad();
        document[json::json_pointer(parent)].erase(key);
        rows.push_back({document, place.empty() ? (parent.empty() ? "/" : parent) : place, words});
    };
    rows.push_back({json::array(), "/", "not an object"});
    rows.push_back({json(3), "/", "not an object"});
    drop("", "asset", "has no 'asset'");
    put("/asset", 3, "is 3, not an object");
    put("/asset/version", 2.0, "not a string");
    put("/asset/version", "1.0", "only 2.0 is read");
    put("/extensionsRequired", json::array({"KHR_draco_mesh_compression"}), "KHR_draco_mesh_compression", "/extensionsRequired/0");
    put("/scene", 1, "there are 1 scenes");
    put("/scene", "0", "is a string");
    put("/scene", -1, "is -1, not a whole number");
    put("/scenes", 3, "not an array");
    put("/scenes/0/nodes/0", 1, "there are 1 nodes");
    put("/scenes/0/nodes", json::array(), "nothing to draw", "/");
    put("/nodes", json::object(), "not an array");
    put("/nodes/0", 7, "not an object");
    put("/nodes/0/mesh", 1, "there are 1 meshes");
    put("/nodes/0/mesh", 0.5, "not a whole number");
    put("/nodes/0/mesh", nullptr, "is null");
    put("/nodes/0/children", json::array({0}), "is reached twice", "/nodes/0");
    put("/nodes/0/children", json::array({9}), "there are 1 nodes", "/nodes/0/children/0");
    put("/nodes/0/translation", json::array({1, 2}), "has 2 numbers, not 3");
    put("/nodes/0/translation", json::array({1, 2, "3"}), "not a number", "/nodes/0/translation/2");
    put("/nodes/0/translation", json::array({1, 2, 1e31}), "outside", "/nodes/0/translation/2");
    put("/nodes/0/rotation", json::array({0, 0, 0, 0}), "length 0");
    put("/nodes/0/rotation", json::array({0, 0, 1, 1}), "length 1.41421");
    put("/nodes/0/scale", json::array({0, 0, 0}), "nothing to draw", "/");
    put("/nodes/0/matrix", json::array({1, 2, 3}), "has 3 numbers, not 16");
    put("/nodes/0/matrix", json::array({1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), "last row");
    put("/nodes/0/camera", 0, "there are 0 cameras");
    put("/nodes/0/extensions", json::parse(R"({"KHR_lights_punctual": {"light": 0}})"), "there are 0 lights",
        "/nodes/0/extensions/KHR_lights_punctual/light");
    put("/nodes/0/skin", 0, "there are 0 skins");
    put("/nodes/0/weights", json::array({"1"}), "not a number", "/nodes/0/weights/0");
    put("/nodes/0/extensions", json::parse(R"({"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": 0}}})"),
        "ROTATION has the wrong type", "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/ROTATION");
    const auto skinned = [&](const char* skin, const std::string& words, const std::string& place) {
        json document = with("/skins", json::array({json::parse(skin)}));
        document["nodes"][0]["skin"] = 0;
        rows.push_back({document, place, words});
    };
    skinned(R"({})", "has no 'joints'", "/skins/0");
    skinned(R"({"joints": []})", "has no joints", "/skins/0");
    skinned(R"({"joints": [1]})", "there are 1 nodes", "/skins/0/joints/0");
    skinned(R"({"joints": [0], "inverseBindMatrices": 0})", "not an accessor of MAT4", "/skins/0/inverseBindMatrices");
    drop("/meshes/0", "primitives", "has no 'primitives'");
    put("/meshes/0/name", 3, "not a string");
    put("/meshes/0/primitives/0/mode", 7, "above 6");
    put("/meshes/0/primitives/0/mode", 0, "nothing to draw", "/");
    put("/meshes/0/primitives/0/material", 0, "there are 0 materials");
    put("/meshes/0/primitives/0/indices", 3, "there are 3 accessors");
    put("/meshes/0/primitives/0/indices", 0, "not an accessor of SCALAR");
    put("/meshes/0/primitives/0/attributes/POSITION", 3, "there are 3 accessors");
    put("/meshes/0/primitives/0/attributes/POSITION", 2, "not an accessor of VEC3");
    put("/meshes/0/primitives/0/attributes", 2, "not an object");
    drop("/meshes/0/primitives/0", "attributes", "has no 'attributes'");
    drop("/accessors/0", "bufferView", "has no data", "/");
    drop("/accessors/0", "count", "has no 'count'");
    drop("/accessors/0", "type", "has no 'type'");
    drop("/accessors/0", "componentType", "has no 'componentType'");
    put("/accessors/0/bufferView", 3, "there are 3 bufferViews");
    put("/accessors/0/count", 0, "NORMAL has 4 elements, POSITION has 0", "/meshes/0/primitives/0/attributes/NORMAL");
    put("/accessors/0/count", 5, "48 bytes");
    put("/accessors/0/count", 1000000000, "48 bytes");
    put("/accessors/0/count", 18446744073709551615u, "48 bytes");
    put("/accessors/0/count", "4", "is a string");
    put("/accessors/0/byteOffset", 1, "48 bytes", "/accessors/0/count");
    put("/accessors/0/byteOffset", 4294967295u, "48 bytes", "/accessors/0/count");
    put("/accessors/0/byteOffset", -4, "not a whole number");
    put("/accessors/0/type", "VEC5", "no type of accessor");
    put("/accessors/0/componentType", 5127, "no component type");
    put("/accessors/0/normalized", 1, "not true or false");
    put("/accessors/1/count", 3, "NORMAL has 3 elements, POSITION has 4", "/meshes/0/primitives/0/attributes/NORMAL");
    put("/accessors/2/count", 2, "fewer than 3 vertices", "/");
    put("/bufferViews/0/buffer", 1, "there are 1 buffers");
    put("/bufferViews/0/byteLength", 109, "109 bytes at 0 of a buffer of 108");
    put("/bufferViews/0/byteOffset", 100, "48 bytes at 100", "/bufferViews/0/byteLength");
    put("/bufferViews/0/byteStride", 3, "elements of 12 bytes lie 3 apart", "/accessors/0");
    put("/bufferViews/0/byteStride", 8, "elements of 12 bytes lie 8 apart", "/accessors/0");
    put("/bufferViews/0/byteStride", 256, "above 252");
    drop("/bufferViews/0", "byteLength", "has no 'byteLength'");
    put("/buffers/0/byteLength", 109, "the data has 108 bytes");
    put("/buffers/0/byteLength", 1e15, "above");
    drop("/buffers/0", "uri", "no binary chunk");
    drop("/buffers/0", "byteLength", "has no 'byteLength'");
    put("/buffers/0/uri", "missing.bin", "does not exist");
    put("/buffers/0/uri", "../quad.bin", "buffer");
    put("/buffers/0/uri", "%2e%2e/quad.bin", "buffer");
    put("/buffers/0/uri", "/dev/zero", "buffer");
    put("/buffers/0/uri", "https://example.org/quad.bin", "network");
    put("/buffers/0/uri", "data:text/plain,hello", "not base64");
    put("/buffers/0/uri", "data:;base64,AAAA*AAA", "'*' is not a base64 digit");
    put("/buffers/0/uri", "data:;base64,AAAAA", "cut short");
    put("/buffers/0/uri", "data:;base64,AAAA", "the data has 3 bytes", "/buffers/0/byteLength");
    // Materials are refused where a primitive has them.
    const auto painted = [&](const char* material, const std::string& words, const std::string& place) {
        json document = with("/materials", json::array({json::parse(material)}));
        document["meshes"][0]["primitives"][0]["material"] = 0;
        rows.push_back({document, "/materials/0" + place, words});
    };
    painted(R"({"pbrMetallicRoughness": {"roughnessFactor": "2"}})", "not a number", "/pbrMetallicRoughness/roughnessFactor");
    painted(R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}})", "has 3 numbers", "/pbrMetallicRoughness/baseColorFactor");
    painted(R"({"emissiveFactor": [0, null, 0]})", "is null, not a number", "/emissiveFactor/1");
    painted(R"({"doubleSided": "yes"})", "not true or false", "/doubleSided");
    painted(R"("red")", "not an object", "");
    put("/extensions", json::parse(R"({"KHR_lights_punctual": {"lights": 3}})"), "not an array", "/extensions/KHR_lights_punctual/lights");
    // Lights and cameras are looked at where a node uses them.
    const auto lit = [&](const char* light, const std::string& words, const std::string& place) {
        json document = quad();
        document["extensions"]["KHR_lights_punctual"]["lights"] = {json::parse(light)};
        document["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
        rows.push_back({document, "/extensions/KHR_lights_punctual/lights/0" + place, words});
    };
    lit(R"({})", "has no 'type'", "");
    lit(R"({"type": "sun"})", "'sun' is no type of light", "/type");
    lit(R"({"type": "point", "intensity": -1})", "outside", "/intensity");
    lit(R"({"type": "point", "color": [1, 1]})", "has 2 numbers", "/color");
    lit(R"({"type": "point", "color": [1e30, 1, 1], "intensity": 1e30})", "above 2^100", "");
    const auto seen = [&](const char* camera, const std::string& words, const std::string& place) {
        json document = with("/nodes/0/camera", 0);
        document["cameras"] = {json::parse(camera)};
        rows.push_back({document, "/cameras/0" + place, words});
    };
    seen(R"({})", "has no 'type'", "");
    seen(R"({"type": "fisheye"})", "no type of camera", "/type");
    seen(R"({"type": "perspective"})", "has no 'perspective'", "");
    seen(R"({"type": "perspective", "perspective": {"znear": 1}})", "has no 'yfov'", "/perspective");
    seen(R"({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}})", "yfov is 0 degrees", "/perspective");
    seen(R"({"type": "perspective", "perspective": {"yfov": 4, "znear": 1}})", "outside", "/perspective/yfov");
    seen(R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 0}})", "znear is 0", "/perspective");
    json twoParents = quad();
    twoParents["nodes"] = json::parse(R"([{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}])");
    rows.push_back({twoParents, "/nodes/2", "is reached twice"});
    return rows;
}

TEST(Gltf, BadInputNamesPointerAndField) {
    const std::vector<BadDocument> rows = badDocuments();
    ASSERT_GE(rows.size(), 40u);
    for (const BadDocument& row : rows) {
        const std::string message = refusal(row.document);
        EXPECT_TRUE(message.starts_with("quad.gltf: " + row.pointer + ": "))
            << row.document << "\n-> " << message << "\n   want " << row.pointer;
        EXPECT_NE(message.find(row.words), std::string::npos) << message << "\n   want " << row.words;
    }
}

TEST(Gltf, NanAndInfinityNameAccessorAndElement) {
    const struct {
        size_t at;
        float value;
        std::string place, words;
    } rows[] = {
        {12, kNan, "/accessors/0", "element 1: POSITION x is NaN"},
        {28, kInfinity, "/accessors/0", "element 2: POSITION y is infinite"},
        {44, -kInfinity, "/accessors/0", "element 3: POSITION z is infinite"},
        {36, 1e31f, "/accessors/0", "element 3: POSITION x is above 2^100"},
    };
    for (const auto& row : rows) {
        std::string bytes = quadBytes();
        std::memcpy(bytes.data() + row.at, &row.value, 4);
        EXPECT_EQ(refusal(quad(), bytes), "quad.gltf: " + row.place + ": " + row.words);
    }
    std::string bytes = quadBytes();
    bytes[102] = 4;
    EXPECT_EQ(refusal(quad(), bytes), "quad.gltf: /accessors/2: element 3 is vertex 4, but POSITION has 4");
}

// What is passed over: the change, what the scene then warns of, and the triangles that are left.
TEST(Gltf, WhatIsNotDrawnIsPassedOverAndNamed) {
    json empty = quad(), few = quad(), noData = quad(), chain = quad(), badMaterial = quad(), strided = quad();
    empty["accessors"].push_back({{"componentType", 5126}, {"count", 0}, {"type", "VEC3"}});
    empty["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 3}}}});
    few["accessors"].push_back({{"bufferView", 0}, {"componentType", 5126}, {"count", 2}, {"type", "VEC3"}});
    few["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 3}}}, {"mode", 5}});
    noData["accessors"].push_back({{"componentType", 5126}, {"count", 3999999999999}, {"type", "VEC3"}});
    noData["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 3}}}});
    noData["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 3}}}});
    chain["nodes"] = json::array();
    for (int i = 0; i < 100000; ++i) chain["nodes"].push_back({{"children", {i + 1}}});
    chain["nodes"].push_back({{"mesh", 0}});
    badMaterial["materials"] = json::parse(R"([{}, {"emissiveFactor": "white"}])");
    strided["bufferViews"][2]["byteStride"] = 2;
    const std::string place = "/meshes/0/primitives/1: ";
    const struct {
        json document;
        std::string warning;
        size_t triangles = 2;
    } rows[] = {
        {empty, place + "is empty; it is passed over"},
        {few, place + "has fewer than 3 vertices; it is passed over"},
        {noData, place + "has no data; all its vertices are one point (2 times)"},
        {chain, ""},
        {badMaterial, "/materials/1: cannot be read; nothing that is drawn has this material"},
        {with("/accessors/2/count", 5), "/meshes/0/primitives/0: has vertices left over that make no whole triangle; they are not drawn",
         1},
        {with("/bufferViews/0/byteStride", 0), "/bufferViews/0/byteStride: is 0; it counts as not stated"},
        {strided, "/bufferViews/2/byteStride: is below the least byteStride of glTF, 4"},
    };
    LoadOptions strict;
    strict.strict = true;
    for (const auto& row : rows) {
        const Scene scene = load(row.document);
        EXPECT_EQ(scene.meshes.at(0).triangles.size(), row.triangles) << row.warning;
        EXPECT_EQ(scene.warnings.size(), row.warning.empty() ? 0u : 1u);
        for (const std::string& warning : scene.warnings) EXPECT_TRUE(warning.ends_with("quad.gltf: " + row.warning)) << warning;
        EXPECT_EQ(refusal(row.document, quadBytes(), strict).empty(), row.warning.empty()) << row.warning;
    }
    std::string bytes = quadBytes();
    for (const float bad : {kNan, kInfinity, 1e31f}) {
        std::memcpy(bytes.data() + 48, &bad, 4);
        const Scene scene = load(quad(), bytes);
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_NE(scene.warnings[0].find("a NORMAL is not finite; it counts as not stated"), std::string::npos) << scene.warnings[0];
        for (const glm::vec3& normal : scene.meshes.at(0).normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    }
    json zeros = quad();
    zeros["accessors"][1].erase("bufferView");
    const Scene scene = load(zeros);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("NORMAL has no data; it counts as not stated"), std::string::npos) << scene.warnings[0];
}

TEST(Gltf, DataInAFormThatIsNotReadIsNamed) {
    json document = quad();
    document["accessors"][0].erase("bufferView");
    document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}};
    EXPECT_NE(
        refusal(document).find("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: KHR_draco_mesh_compression is not read"),
        std::string::npos)
        << refusal(document);
    document = quad();
    document["asset"] = json::object();
    document["meshes"] = {{"mesh_0", json::object()}};
    EXPECT_EQ(refusal(document), "quad.gltf: /: glTF 1.0; only 2.0 is read");
    TemporaryFolder folder;
    std::string wide;
    for (const char c : quad().dump()) wide += {c, '\0'};
    EXPECT_EQ(refusal(folder, folder.write("quad.gltf", wide)), "quad.gltf:1:1: the text is UTF-16; only UTF-8 is read");
}

TEST(Gltf, ExtensionsThatConcernSurfacesOnlyMayBeRequired) {
    LoadOptions strict;
    strict.strict = true;
    for (const char* name :
         {"KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds", "KHR_materials_transmission", "KHR_materials_variants"}) {
        const json document = with("/extensionsRequired", json::array({name}));
        const std::vector<std::string> ignored = load(document).ignored;
        EXPECT_EQ(ignored.back(), std::string("extension ") + name);
        EXPECT_EQ(ignored.size() == 2 && ignored[0] == "textures", std::string(name).find("_texture_") != std::string::npos) << name;
        EXPECT_NE(refusal(document, quadBytes(), strict), "") << name;
    }
    for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "CESIUM_RTC"})
        EXPECT_NE(refusal(with("/extensionsRequired", json::array({name}))).find(name), std::string::npos);
}

// Factors that would make the picture white, or that a writer rounded the wrong way.
TEST(Gltf, FactorsOutsideTheirRangeAreClampedWithTheirDigits) {
    json document = with("/materials", json::parse(R"([
        {"pbrMetallicRoughness": {"baseColorFactor": [1.00000012, -0.5, 0.25, 1], "roughnessFactor": 2}, "emissiveFactor": [2.5, 0, 0],
         "extensions": {"KHR_materials_ior": {"ior": 1000}}},
        {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}},
        {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1], "baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}},
        {"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}, "extensions": {"KHR_materials_pbrSpecularGlossiness":
         {"diffuseFactor": [1, 0.25, 0, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.5}}}])"));
    const Scene scene = load(document);
    const Material& clamped = scene.materials.at(1);
    EXPECT_EQ(clamped.diffuse, glm::vec3(1, 0, 0.25f));
    EXPECT_EQ(clamped.emission, glm::vec3(1, 0, 0));
    EXPECT_EQ(clamped.refractiveIndex, 1000);
    EXPECT_EQ(scene.materials.at(2).emission, glm::vec3(0));
    EXPECT_EQ(scene.materials.at(2).diffuse, glm::vec3(1));
    EXPECT_EQ(scene.materials.at(3).emission, glm::vec3(0));
    EXPECT_EQ(scene.materials.at(3).diffuse, glm::vec3(0.5f, 0.25f, 1));
    const Material& paint = scene.materials.at(4);
    EXPECT_EQ(paint.diffuse, glm::vec3(1, 0.25f, 0));
    EXPECT_FLOAT_EQ(paint.specular.r, 0.16f);  // 0.04 / (4 a^2), a = 1/4
    EXPECT_FLOAT_EQ(paint.shininess, 30);
    EXPECT_EQ(scene.ignored, std::vector<std::string>{"textures"});
    ASSERT_EQ(scene.warnings.size(), 3u);
    EXPECT_TRUE(scene.warnings[0].ends_with(
        "/materials/0/pbrMetallicRoughness/baseColorFactor/0: is 1.00000012, outside 0 to 1; it is clamped (4 times)"))
        << scene.warnings[0];
    EXPECT_NE(scene.warnings[1].find("/materials/1/emissiveTexture: is not drawn"), std::string::npos) << scene.warnings[1];
    EXPECT_NE(scene.warnings[2].find("/materials/2/extensions/KHR_materials_unlit: its texture is not drawn"), std::string::npos);
    LoadOptions strict;
    strict.strict = true;
    EXPECT_NE(refusal(document, quadBytes(), strict).find("is 1.00000012, outside 0 to 1; it is clamped (--strict)"), std::string::npos);
}

// The quadrilateral with joints 0 and 1 and their weights, a skin of two joints and two morph targets.
struct Posed {
    json document = quad();
    std::string bytes = quadBytes();
};

Posed posed() {
    Posed made;
    append<uint8_t>(made.bytes, {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});      // byte 108: JOINTS_0
    append<float>(made.bytes, {1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 3, 0, 0});  // 124: WEIGHTS_0
    append<float>(made.bytes, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});                    // 188: a target
    append<float>(made.bytes, {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1});        // 236: MAT4
    append<float>(made.bytes, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    json& d = made.document;
    d["buffers"][0]["byteLength"] = made.bytes.size();
    const auto add = [&](size_t at, size_t bytes, int type, size_t count, const char* shape) {
        d["accessors"].push_back({{"bufferView", d["bufferViews"].size()}, {"componentType", type}, {"count", count}, {"type", shape}});
        d["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", bytes}});
    };
    add(108, 16, 5121, 4, "VEC4");
    add(124, 64, 5126, 4, "VEC4");
    add(188, 48, 5126, 4, "VEC3");
    add(236, 128, 5126, 2, "MAT4");
    return made;
}

json& attributesOf(Posed& posed) { return posed.document["meshes"][0]["primitives"][0]["attributes"]; }

TEST(Gltf, SkinsStandWhereTheirJointsAre) {
    Posed p = posed();
    attributesOf(p)["JOINTS_0"] = 3;
    attributesOf(p)["WEIGHTS_0"] = 4;
    p.document["skins"] = json::parse(R"([{"joints": [1, 3], "inverseBindMatrices": 6}])");
    // The node's own matrix does not count, and a joint may stand outside the scene.
    p.document["nodes"] = json::parse(R"([{"mesh": 0, "skin": 0, "translation": [100, 0, 0]}, {"translation": [10, 0, 0]},
                                          {"children": [3], "translation": [0, 0, 7]}, {"translation": [0, 20, 0]}])");
    p.document["scenes"][0]["nodes"] = {0, 1};
    const Scene scene = load(p.document, p.bytes);
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].worldFromObject, glm::dmat4(1.0));
    const TriangleMesh& mesh = scene.meshes.at(0);
    // Corner 0: joint 0, twice (0,0,0) + (10,0,0). 1: twice (1,0,0) + (10,0,0). 2: the mean of (12,2,0) and (1,21,7). 3: (0,21,7), weight 3.
    std::vector<dvec3> found;
    for (size_t v = 0; v < mesh.positions.size(); ++v) found.push_back(mesh.statedAt(v));
    for (const dvec3& want : {dvec3(10, 0, 0), dvec3(12, 0, 0), dvec3(6.5, 11.5, 3.5), dvec3(0, 21, 7)})
        EXPECT_NE(std::find(found.begin(), found.end(), want), found.end()) << want.x << ' ' << want.y << ' ' << want.z;
    EXPECT_TRUE(scene.ignored.empty());
    // Weights of 0 stand at the node; so does a primitive without any.
    Posed still = p;
    attributesOf(still).erase("WEIGHTS_0");
    const Scene unskinned = load(still.document, still.bytes);
    EXPECT_EQ(unskinned.meshes.at(0).statedMax, dvec3(101, 1, 0));
    ASSERT_EQ(unskinned.warnings.size(), 1u);
    EXPECT_NE(unskinned.warnings[0].find("has a skin but neither joints nor weights"), std::string::npos);
    // Joints that mirror turn the winding round: the face still looks where its normal does.
    Posed mirrored = p;
    const float minusTwo = -2;
    std::memcpy(mirrored.bytes.data() + 236, &minusTwo, 4);
    mirrored.document["skins"][0]["joints"] = {1};
    const std::string oneJoint(16, '\0');
    mirrored.bytes.replace(108, 16, oneJoint);
    const TriangleMesh turned = load(mirrored.document, mirrored.bytes).meshes.at(0);
    for (const glm::vec3& normal : turned.faceNormal) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    for (const glm::vec3& normal : turned.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(turned.repairedNormals, 0u);
    p.bytes[108] = 2;
    EXPECT_EQ(refusal(p.document, p.bytes), "quad.gltf: /accessors/3: element 0: the joint is 2; the skin has 2");
}

TEST(Gltf, MorphTargetsHaveTheirStatedWeights) {
    Posed p = posed();
    json& primitive = p.document["meshes"][0]["primitives"][0];
    primitive["targets"] = json::parse(R"([{"POSITION": 5}, {"POSITION": 5}])");
    EXPECT_EQ(load(p.document, p.bytes).meshes.at(0).statedMax, dvec3(1, 1, 0)) << "none stated: 0";
    p.document["meshes"][0]["weights"] = {0.5, 2};
    EXPECT_EQ(load(p.document, p.bytes).meshes.at(0).statedMax, dvec3(1, 1, 2.5));
    // A node's weights go before the mesh's; nodes that say the same share a mesh.
    p.document["nodes"] = json::parse(R"([{"mesh": 0}, {"mesh": 0, "weights": [1, 0]}, {"mesh": 0}])");
    p.document["scenes"][0]["nodes"] = {0, 2, 1};
    const Scene scene = load(p.document, p.bytes);
    ASSERT_EQ(scene.objects.size(), 3u);
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[scene.objects[1].mesh].statedMax, dvec3(1, 1, 2.5));
    EXPECT_EQ(scene.meshes[scene.objects[2].mesh].statedMax, dvec3(1, 1, 1));
    primitive["targets"][1]["POSITION"] = 2;
    EXPECT_NE(refusal(p.document, p.bytes).find("/meshes/0/primitives/0/targets/1/POSITION: POSITION has 1 numbers, not 3"),
              std::string::npos);
}

TEST(Gltf, InstancesAreObjectsBelowTheirNode) {
    Posed p = posed();
    p.document["nodes"][0]["scale"] = {2, 2, 2};
    p.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 5}, {"SCALE", 0}};
    p.document["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    const Scene scene = load(p.document, p.bytes);
    // Scales are the positions of the corners: three have a factor of 0, and leave no area or flatten the quadrilateral in its plane.
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(dvec3(scene.objects[0].worldFromObject * dvec4(1, 1, 0, 1)), dvec3(2, 2, 2));
    EXPECT_EQ(scene.ignored, std::vector<std::string>{"meshes flattened by a scale of 0"});
    p.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 5}};
    EXPECT_EQ(load(p.document, p.bytes).objects.size(), 4u);
    json& many = p.document["nodes"];
    const json node = many[0];
    for (int i = 1; i < 3000; ++i) {
        many.push_back({{"extensions", node["extensions"]}, {"mesh", 0}});
        p.document["scenes"][0]["nodes"].push_back(i);
    }
    EXPECT_EQ(load(p.document, p.bytes).objects.size(), 12000u);
}

TEST(Gltf, CamerasAreChosenByNumberOrName) {
    json document = quad();
    document["cameras"] = json::parse(R"([{"type": "perspective", "name": "wide", "perspective": {"yfov": 1, "znear": 1}},
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}}])");
    document["nodes"] = json::parse(R"([{"mesh": 0}, {"camera": 1, "name": "tele"}, {"camera": 0}])");
    document["scenes"][0]["nodes"] = {0, 1, 2};
    const auto fovOf = [&](const char* choice) {
        LoadOptions options;
        options.camera = choice;
        return load(document, quadBytes(), options).camera.value().fovYDegrees * (3.14159265358979323846 / 180);
    };
    for (const char* tele : {"", "0", "tele"}) EXPECT_NEAR(fovOf(tele), 0.5, kDouble) << tele;
    for (const char* wide : {"1", "wide"}) EXPECT_NEAR(fovOf(wide), 1, kDouble) << wide;
    LoadOptions options;
    options.camera = "2";
    try {
        load(document, quadBytes(), options);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::usage);
        EXPECT_NE(std::string(error.what()).find("has no perspective camera '2'; it has 2"), std::string::npos) << error.what();
    }
}

TEST(Gltf, JsonErrorsNameLineAndColumn) {
    TemporaryFolder folder;
    const std::pair<std::string, std::string> rows[] = {
        {"", "quad.gltf:1:1: JSON: "},
        {"{", "quad.gltf:1:2: JSON: "},
        {"{\n  \"asset\": }", "quad.gltf:2:12: JSON: "},
        {"{\"a\": [1, 2,]}", "quad.gltf:1:13: JSON: "},
        {"{\"a\":\n 1e999}", "quad.gltf:2:2: JSON: number overflow"},
        {"{\"a\": nan}", "quad.gltf:1:8: JSON: "},
        {"{} x", "quad.gltf:1:4: JSON: "},
        {std::string("{\"\xff\": 1}"), "quad.gltf:1:3: JSON: "},
        {std::string(1000000, '['), "quad.gltf:1:65: JSON is nested deeper than 64"},
    };
    for (const auto& [text, want] : rows) {
        const std::string message = refusal(folder, folder.write("quad.gltf", text));
        EXPECT_TRUE(message.starts_with(want)) << text.substr(0, 80) << "\n-> " << message;
    }
}

TEST(Gltf, GlbErrorsNameTheByte) {
    TemporaryFolder folder;
    const std::string good = quadGlb();
    const auto changed = [&](size_t at, uint32_t value) {
        std::string bytes = good;
        std::memcpy(bytes.data() + at, &value, 4);
        return bytes;
    };
    const std::pair<std::string, std::string> rows[] = {
        {good.substr(0, 11), "quad.glb: byte 11: the file ends in the GLB header"},
        {changed(4, 1), "quad.glb: byte 4: GLB version 1"},
        {changed(8, 0xffffffff), "quad.glb: byte 8: GLB length is 4294967295"},
        {good.substr(0, good.size() - 1), "quad.glb: byte 8: GLB length"},
        {changed(8, 12), "quad.glb: byte 12: the GLB has no chunks"},
        {changed(8, 16), "quad.glb: byte 12: the file ends in a chunk header"},
        {changed(12, 0xfffffff0), "quad.glb: byte 12: chunk length"},
        {changed(16, 0x004e4942), "quad.glb: byte 16: the JSON chunk must come first"},
        {glb("{\"a\": }", ""), "quad.glb: byte 26: JSON: "},
        {glb(quad().dump(), ""), "quad.glb: /buffers/0/uri: 'quad.bin' does not exist"},
    };
    for (const auto& [bytes, want] : rows) {
        const std::string message = refusal(folder, folder.write("quad.glb", bytes));
        EXPECT_TRUE(message.starts_with(want)) << message << "\n   want " << want;
    }
}

TEST(Gltf, CutAtEveryByteItIsRefused) {
    TemporaryFolder folder;
    const std::string good = quadGlb(), text = quad().dump();
    folder.write("quad.bin", quadBytes());
    for (size_t bytes = 0; bytes < good.size(); ++bytes) EXPECT_NE(refusal(folder, folder.write("quad.glb", good.substr(0, bytes))), "");
    for (size_t bytes = 0; bytes < text.size(); ++bytes) EXPECT_NE(refusal(folder, folder.write("quad.gltf", text.substr(0, bytes))), "");
}

// Every byte of the JSON replaced in turn: it loads or it is refused in one line.
TEST(Gltf, ChangedBytesNeverCrash) {
    TemporaryFolder folder;
    const std::string text = quad().dump();
    folder.write("quad.bin", quadBytes());
    for (size_t at = 0; at < text.size(); ++at)
        for (const char c : {'9', at % 2 == 0 ? '"' : ']'}) {
            std::string bytes = text;
            bytes[at] = c;
            refusal(folder, folder.write("quad.gltf", bytes));
        }
}

TEST(Gltf, RepeatedDataDoesNotFillTheMemory) {
    json document = quad();
    const json primitive = document["meshes"][0]["primitives"][0];
    for (int i = 0; i < 20000; ++i) document["meshes"][0]["primitives"].push_back(primitive);
    // 20,001 times 6 corners of a file of a megabyte: allowed, because the JSON itself is longer.
    EXPECT_EQ(load(document).meshes.at(0).triangles.size(), 40002u);
    std::string bytes = quadBytes().substr(0, 96);
    for (int i = 0; i < 30000; ++i) append<uint16_t>(bytes, {0, 1, 2});
    document["accessors"][2]["count"] = 90000;
    document["bufferViews"][2]["byteLength"] = 180000;
    document["buffers"][0]["byteLength"] = bytes.size();
    EXPECT_NE(refusal(document, bytes).find("more than 16 a byte"), std::string::npos);
}

TEST(Gltf, RefusesWhatIsNoFile) {
    TemporaryFolder folder;
    EXPECT_THROW(readGltf(folder.path() / "missing.glb", {}), Error);
    EXPECT_THROW(readGltf(folder.path(), {}), Error);
    EXPECT_THROW(readGltf("/dev/zero", {}), Error);
    // A buffer that is a folder, and one that is a link out of the folder.
    std::filesystem::create_directory(folder.path() / "folder.bin");
    std::filesystem::create_symlink("/etc/passwd", folder.path() / "link.bin");
    for (const char* uri : {"folder.bin", "link.bin"})
        EXPECT_NE(refusal(folder, folder.write("quad.gltf", with("/buffers/0/uri", uri).dump())), "") << uri;
}

}  // namespace
}  // namespace plumb
