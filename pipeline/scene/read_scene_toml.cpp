// SPDX-License-Identifier: MIT
// Reads scene.toml as docs/scene-format.md describes it. World space is binary64; matrices are to-From, column vectors.
// Left-handed scenes keep their polygons as listed (clockwise seen from outside): the cross product (P1-P0)x(P2-P0)
// points outward there just as for counter-clockwise lists in a right-handed world, so finishMesh serves both.
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/affine.h"
#include "pipeline/scene/area_light.h"
#include "pipeline/scene/colour.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/text.h"
#include "pipeline/transform/steps.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <toml++/toml.h>
#include <tuple>

namespace plumb {
namespace {

using glm::dmat4;
using glm::dvec3;

// A TOML value takes about 90 bytes of memory and at least two of text; larger meshes belong in a mesh file.
constexpr uint64_t kMaxSceneFileBytes = uint64_t(16) << 20;
constexpr int kMaxDepth = 64;            // of keys and of object hierarchies: what recurses stays off the stack's end
constexpr uint64_t kMaxCopiedTriangles = uint64_t(1) << 26;  // 5 GiB: more is a file that means to fill the memory
constexpr double kMaxShininess = 1e6;
constexpr uint32_t kMaxImageSide = 65536;
constexpr int64_t kMaxRayDepth = 64;     // counters of rays are kept a depth
constexpr double kMostJitter = 0.5;      // of a unit vector: no disturbed one is near 0
// Weights that add up to 1 in decimals may exceed it by a rounding of each.
constexpr double kLargestWeightSum = 1 + 4 * 0x1p-53;

// A channel encoded as sRGB, 0 to 1, as linear light (IEC 61966-2-1): v^2.4 = v^2 (v^(1/5))^2, the root by Newton, again with
// + - * / alone. From 1 the iteration falls monotonically to the root, 0.6 or more, in fewer than 32 steps.
float linearOfSrgb(double encoded) {
    if (encoded <= 0.04045) return float(encoded / 12.92);
    const double v = (encoded + 0.055) / 1.055;
    double root = 1;
    for (int i = 0; i < 32; ++i) root = (4 * root + v / (root * root * root * root)) / 5;
    return float(v * v * root * root);
}

void paint(TriangleMesh& mesh, uint32_t material) {
    std::fill(mesh.vertexMaterial.begin(), mesh.vertexMaterial.end(), material);
    std::fill(mesh.faceMaterial.begin(), mesh.faceMaterial.end(), material);
}

// Levenshtein's, blind to the case of ASCII letters.
size_t editDistance(std::string_view a, std::string_view b) {
    const auto same = [](char x, char y) {
        const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; };
        return lower(x) == lower(y);
    };
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t above = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + !same(a[i - 1], b[j - 1])});
            diagonal = above;
        }
    }
    return row[b.size()];
}

// "; did you mean 'x'?" for a slip of the pen, else "; known: a, b, c".
template <class Names>
std::string suggestion(std::string_view word, const Names& known) {
    std::string list;
    std::string_view nearest;
    size_t least = 1 + std::min<size_t>(word.size(), 64) / 3;
    size_t listed = 0;
    for (std::string_view name : known) {
        if (++listed <= 24) list += (list.empty() ? "" : ", ") + printable(name, 40);
        if (word.size() > 64 || name.size() > 64) continue;
        const size_t distance = editDistance(word, name);
        if (distance <= least) {
            nearest = name;
            least = distance == 0 ? 0 : distance - 1;
        }
    }
    if (!nearest.empty()) return fmt::format("; did you mean '{}'?", printable(nearest, 64));
    return list.empty() ? std::string() : "; known: " + list;
}

// How a value of the file is called in a refusal: "a string", "an array", ...
const char* kindOf(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table: return "a table";
        case toml::node_type::array: return "an array";
        case toml::node_type::string: return "a string";
        case toml::node_type::integer: return "an integer";
        case toml::node_type::floating_point: return "a number";
        case toml::node_type::boolean: return "a boolean";
        default: return "a date or time";
    }
}

class SceneFile {
public:
    SceneFile(const std::filesystem::path& path, const LoadOptions& options) : path_(path), options_(options) {}
    Scene read();

private:
    using Known = std::initializer_list<std::string_view>;

    // Where, and refusals. A field is written as the way to it: "object.transform[2].scale".
    std::string place(const toml::source_region& region) const {
        return placeOfLine(path_, region.begin.line, region.begin.column);
    }
    std::string place(const toml::node& node) const { return place(node.source()); }
    [[noreturn]] void refuse(const toml::node& node, const std::string& text) const {
        throw inputError(place(node), text);
    }
    void refuseDeepKeys(std::string_view text) const;
    void allowKeys(const toml::table& table, std::string_view what, const Known& known) const;
    const toml::node& required(const toml::table& table, std::string_view key, const std::string& what) const;

    // Values. Each refuses what is not of its kind or range, with the place of the value.
    const toml::table& tableOf(const toml::node& node, const std::string& field) const;
    const toml::array& arrayOf(const toml::node& node, const std::string& field) const;
    std::string stringOf(const toml::node& node, const std::string& field) const;
    bool booleanOf(const toml::node& node, const std::string& field) const;
    int64_t integerOf(const toml::node& node, const std::string& field, int64_t least, int64_t most) const;
    double numberOf(const toml::node& node, const std::string& field) const;
    double numberOf(const toml::node& node, const std::string& field, double least, double most) const;
    dvec3 vectorOf(const toml::node& node, const std::string& field) const;
    dvec3 axisOf(const toml::node& node, const std::string& field) const;
    glm::vec3 colourOf(const toml::node& node, const std::string& field, double most) const;
    glm::vec3 inkOf(const toml::table& table, const std::string& field) const;
    template <class T>
    T choiceOf(const toml::node& node, const std::string& field,
               std::initializer_list<std::pair<std::string_view, T>> choices) const;
    template <class Read>
    void eachTable(const toml::table& parent, std::string_view key, const std::string& field, Read read);

    // Parts of the file.
    void readSettings(const toml::table& root);
    void readRays(const toml::table& root);
    void readCamera(const toml::table& table);
    void readMaterial(const toml::table& table);
    void readWeights(const toml::table& table, Material& material) const;
    void readSphere(const toml::table& table);
    void readPlane(const toml::table& table);
    void readLight(const toml::table& table);
    void readArea(const toml::table& table, const Light& light);
    void readMesh(const toml::table& table);
    uint32_t readInlineMesh(const toml::table& table, const std::string& name, const LoadOptions& options);
    void readObject(const toml::table& table, int parent, int depth);
    struct Placement {
        dmat4 matrix{1.0};
        std::vector<Step3> steps;    // elementary, in order of application
    };
    Placement readTransforms(const toml::node& node, const std::string& field, uint32_t mesh) const;
    Placement readTransform(const toml::table& table, const std::string& field, uint32_t mesh, const dmat4& before) const;
    Placement readRotate(const toml::node& node, const std::string& field) const;
    dvec3 centreOf(const toml::node& about, const std::string& field, uint32_t mesh, const dmat4& before) const;
    uint32_t materialNamed(const toml::node& node, const std::string& field) const;
    static std::string tooDeep() { return fmt::format("objects are nested deeper than {}", kMaxDepth); }
    void linkParents();
    void placeObjects();

    struct Node {
        std::string name;
        const toml::table* table;    // for places; lives as long as read()
        const toml::node* parentNamed = nullptr;
        int parent = -1;
        uint32_t mesh = kNone;       // into scene_.meshes; kNone: a group
        uint32_t material = kNone;
        Placement parentFromNode;
        dmat4 worldFromNode{1.0};
        int depth = 0;
        bool placed = false;
    };
    uint32_t meshWithMaterial(uint32_t mesh, uint32_t material, const toml::table& place);

    std::filesystem::path path_;
    LoadOptions options_;
    Scene scene_;
    std::map<std::string, uint32_t, std::less<>> materials_;  // "default" is material 0; a file may restate it once
    bool defaultStated_ = false;
    std::map<std::string, uint32_t, std::less<>> meshes_;  // into scene_.meshes
    std::vector<std::string> meshNames_;   // in file order
    std::map<std::tuple<std::string, double, uint32_t>, uint32_t> meshFiles_;  // (file, crease, material): read once
    std::vector<Node> nodes_;
    std::map<std::string, int, std::less<>> nodeNames_;
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> recoloured_;  // (mesh, material): the copy
    uint64_t copiedTriangles_ = 0;
};

// toml++ limits nested values itself, but not the parts of a dotted key, and frees its tables recursively.
void SceneFile::refuseDeepKeys(std::string_view text) const {
    enum { bare, comment, basic, literal, basicBlock, literalBlock } state = bare;
    size_t line = 1, lineStart = 0;
    int dots = 0;
    const auto startsBlock = [&](size_t i, char quote) {
        return i + 2 < text.size() && text[i + 1] == quote && text[i + 2] == quote;
    };
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        switch (state) {
            case bare:
                if (c == '#') state = comment;
                else if (c == '"' || c == '\'') {
                    const bool block = startsBlock(i, c);
                    state = c == '"' ? (block ? basicBlock : basic) : (block ? literalBlock : literal);
                    if (block) i += 2;
                } else if (c == '.') {
                    if (++dots > kMaxDepth)
                        throw inputError(placeOfLine(path_, line, i - lineStart + 1),
                                         fmt::format("a key of more than {} parts", kMaxDepth));
                } else if (c == '=' || c == ',' || c == '[' || c == ']' || c == '{' || c == '}') {
                    dots = 0;
                }
                break;
            case comment: break;
            case basic:
            case literal:
                if (c == '\\' && state == basic) ++i;
                else if (c == (state == basic ? '"' : '\'')) state = bare;
                break;
            case basicBlock:
            case literalBlock:
                if (c == '\\' && state == basicBlock) ++i;
                else if (c == (state == basicBlock ? '"' : '\'') && startsBlock(i, c)) {
                    i += 2;
                    state = bare;
                }
                break;
        }
        if (i < text.size() && text[i] == '\n') {
            ++line;
            lineStart = i + 1;
            dots = 0;
            if (state == comment || state == basic || state == literal) state = bare;
        }
    }
}

void SceneFile::allowKeys(const toml::table& table, std::string_view what, const Known& known) const {
    for (const auto& [key, node] : table) {
        (void)node;
        if (std::find(known.begin(), known.end(), key.str()) == known.end())
            throw inputError(place(key.source()), fmt::format("unknown key '{}' in {}{}", printable(key.str(), 64), what,
                                                              suggestion(key.str(), known)));
    }
}

const toml::node& SceneFile::required(const toml::table& table, std::string_view key, const std::string& what) const {
    const toml::node* node = table.get(key);
    if (!node) refuse(table, fmt::format("{} has no '{}'", what, key));
    return *node;
}

const toml::table& SceneFile::tableOf(const toml::node& node, const std::string& field) const {
    if (const toml::table* table = node.as_table()) return *table;
    refuse(node, fmt::format("{} is {}, not a table", field, kindOf(node)));
}

const toml::array& SceneFile::arrayOf(const toml::node& node, const std::string& field) const {
    if (const toml::array* array = node.as_array()) return *array;
    refuse(node, fmt::format("{} is {}, not an array", field, kindOf(node)));
}

std::string SceneFile::stringOf(const toml::node& node, const std::string& field) const {
    if (const auto* text = node.as_string()) return text->get();
    refuse(node, fmt::format("{} is {}, not a string", field, kindOf(node)));
}

bool SceneFile::booleanOf(const toml::node& node, const std::string& field) const {
    if (const auto* value = node.as_boolean()) return value->get();
    refuse(node, fmt::format("{} is {}, not true or false", field, kindOf(node)));
}

int64_t SceneFile::integerOf(const toml::node& node, const std::string& field, int64_t least, int64_t most) const {
    const auto* value = node.as_integer();
    if (!value) refuse(node, fmt::format("{} is {}, not an integer", field, kindOf(node)));
    if (value->get() < least || value->get() > most)
        refuse(node, fmt::format("{} is {}, outside {} to {}", field, value->get(), least, most));
    return value->get();
}

double SceneFile::numberOf(const toml::node& node, const std::string& field) const {
    if (const auto* integer = node.as_integer()) return double(integer->get());
    const auto* value = node.as_floating_point();
    if (!value) refuse(node, fmt::format("{} is {}, not a number", field, kindOf(node)));
    if (std::isnan(value->get())) refuse(node, field + " is NaN");
    if (std::isinf(value->get())) refuse(node, field + " is infinite");
    return value->get();
}

double SceneFile::numberOf(const toml::node& node, const std::string& field, double least, double most) const {
    const double value = numberOf(node, field);
    if (value < least || value > most)
        refuse(node, fmt::format("{} is {:g}, outside {:g} to {:g}", field, value, least, most));
    return value;
}

dvec3 SceneFile::vectorOf(const toml::node& node, const std::string& field) const {
    const toml::array& array = arrayOf(node, field);
    if (array.size() != 3) refuse(node, fmt::format("{} has {} numbers, not 3", field, array.size()));
    dvec3 v;
    for (int i = 0; i < 3; ++i)
        v[i] = numberOf(array[size_t(i)], fmt::format("{}[{}]", field, i), -kMaxCoordinate, kMaxCoordinate);
    return v;
}

// A direction: any length but zero.
dvec3 SceneFile::axisOf(const toml::node& node, const std::string& field) const {
    const dvec3 v = vectorOf(node, field);
    if (largestMagnitude(v) == 0) refuse(node, field + " is the zero vector");
    return v;
}

// Inks, { cmy = [c, m, y] } or { cmyk = [c, m, y, k] }: they leave (1 - C) (1 - K) of the encoded red, and so on.
glm::vec3 SceneFile::inkOf(const toml::table& table, const std::string& field) const {
    allowKeys(table, field, {"cmy", "cmyk"});
    const bool black = table.contains("cmyk");
    if (table.size() != 1) refuse(table, fmt::format("{} holds {} inks; write {{ cmy = [c, m, y] }} or {{ cmyk = [c, m, y, k] }}", field, table.size()));
    const std::string name = field + (black ? ".cmyk" : ".cmy");
    const toml::node& node = *table.get(black ? "cmyk" : "cmy");
    const toml::array& array = arrayOf(node, name);
    const size_t count = black ? 4 : 3;
    if (array.size() != count) refuse(node, fmt::format("{} has {} numbers, not {}", name, array.size(), count));
    double ink[4] = {};
    for (size_t i = 0; i < count; ++i) ink[i] = numberOf(array[i], fmt::format("{}[{}]", name, i), 0, 1);
    const dvec3 rgb = rgbFromCmyk(Cmyk{ink[0], ink[1], ink[2], ink[3]});
    return {linearOfSrgb(rgb.r), linearOfSrgb(rgb.g), linearOfSrgb(rgb.b)};
}

// One number for grey, three for linear RGB, "#rrggbb", which is sRGB as in every colour picker, or inks.
glm::vec3 SceneFile::colourOf(const toml::node& node, const std::string& field, double most) const {
    if (const auto* text = node.as_string()) {
        const std::optional<Rgb8> rgb = rgbOfHex(text->get());
        if (!rgb)
            refuse(node, fmt::format("{} is '{}', not a number, [r, g, b] or \"#rrggbb\"", field, printable(text->get(), 40)));
        return {linearOfSrgb((*rgb)[0] / 255.0), linearOfSrgb((*rgb)[1] / 255.0), linearOfSrgb((*rgb)[2] / 255.0)};
    }
    if (const auto* table = node.as_table()) return inkOf(*table, field);
    if (!node.is_array()) return glm::vec3(float(numberOf(node, field, 0, most)));
    const toml::array& array = *node.as_array();
    if (array.size() != 3) refuse(node, fmt::format("{} has {} numbers, not 3", field, array.size()));
    glm::vec3 colour;
    for (int i = 0; i < 3; ++i)
        colour[i] = float(numberOf(array[size_t(i)], fmt::format("{}[{}]", field, i), 0, most));
    return colour;
}

template <class T>
T SceneFile::choiceOf(const toml::node& node, const std::string& field,
                      std::initializer_list<std::pair<std::string_view, T>> choices) const {
    const std::string word = stringOf(node, field);
    std::vector<std::string_view> known;
    for (const auto& [name, value] : choices) {
        if (word == name) return value;
        known.push_back(name);
    }
    refuse(node, fmt::format("{} is '{}'{}", field, printable(word, 40), suggestion(word, known)));
}

template <class Read>
void SceneFile::eachTable(const toml::table& parent, std::string_view key, const std::string& field, Read read) {
    const toml::node* node = parent.get(key);
    if (!node) return;
    if (!node->is_array()) refuse(*node, fmt::format("{0} is {1}; write [[{0}]]", field, kindOf(*node)));
    for (const toml::node& element : *node->as_array()) read(tableOf(element, field));
}

void SceneFile::readSettings(const toml::table& root) {
    if (const auto* node = root.get("handedness"))
        scene_.leftHanded = choiceOf<bool>(*node, "handedness", {{"right", false}, {"left", true}});
    if (const auto* node = root.get("up")) scene_.up = unitVector(axisOf(*node, "up"));
    if (const auto* node = root.get("ambient")) scene_.ambient = colourOf(*node, "ambient", kMaxCoordinate);
    if (const auto* node = root.get("background")) scene_.background = colourOf(*node, "background", 1);
    if (const auto* node = root.get("encoding"))
        scene_.encoding = choiceOf<Encoding>(*node, "encoding", {{"srgb", Encoding::srgb}, {"linear", Encoding::linear}});
    if (const auto* node = root.get("shading"))
        scene_.shading = choiceOf<Shading>(*node, "shading",
                                           {{"wire", Shading::wire}, {"unlit", Shading::unlit}, {"flat", Shading::flat},
                                            {"gouraud", Shading::gouraud}, {"phong", Shading::phong}, {"ray", Shading::ray}});
    if (const auto* node = root.get("max_depth")) scene_.maxDepth = uint32_t(integerOf(*node, "max_depth", 1, kMaxRayDepth));
    if (const auto* node = root.get("min_weight")) scene_.minWeight = numberOf(*node, "min_weight", 0, 1);
    readRays(root);
    if (const auto* node = root.get("shadows")) scene_.shadows = booleanOf(*node, "shadows");
    if (const auto* node = root.get("fill")) scene_.fill = choiceOf<Fill>(*node, "fill", {{"exact", Fill::exact}, {"notes", Fill::notes}});
    if (const auto* node = root.get("wire"))
        scene_.wire = choiceOf<WireView>(*node, "wire", {{"see-through", WireView::seeThrough}, {"culled", WireView::culled}, {"solid", WireView::solid}});
    if (const auto* node = root.get("edges")) scene_.wirePerPolygon = choiceOf<bool>(*node, "edges", {{"once", false}, {"polygons", true}});
    if (const auto* node = root.get("viewer")) scene_.distantViewer = choiceOf<bool>(*node, "viewer", {{"local", false}, {"distant", true}});
    if (const auto* node = root.get("z_buffer")) scene_.zBuffer = booleanOf(*node, "z_buffer");
    if (const auto* node = root.get("sphere_heights"))
        scene_.wholeSphereHeights = choiceOf<bool>(*node, "sphere_heights", {{"exact", false}, {"whole", true}});
    if (const auto* node = root.get("cull")) scene_.cullBackFaces = booleanOf(*node, "cull");
    if (const auto* node = root.get("size")) {
        const toml::array& size = arrayOf(*node, "size");
        if (size.size() != 2) refuse(*node, fmt::format("size has {} numbers, not 2", size.size()));
        scene_.size = {uint32_t(integerOf(size[0], "size[0]", 1, kMaxImageSide)),
                       uint32_t(integerOf(size[1], "size[1]", 1, kMaxImageSide))};
    }
}

// Where rays pass through a pixel, their noise, and whole levels.
void SceneFile::readRays(const toml::table& root) {
    if (const auto* node = root.get("sampling"))
        scene_.sampling = choiceOf<Sampling>(*node, "sampling",
                                             {{"grid", Sampling::grid}, {"centre", Sampling::centre}, {"random", Sampling::random},
                                              {"corners", Sampling::corners}, {"adaptive", Sampling::adaptive}, {"notes", Sampling::notes}});
    if (const auto* node = root.get("jitter")) {
        const toml::table& jitter = tableOf(*node, "jitter");
        allowKeys(jitter, "jitter", {"reflect", "refract", "shadow"});
        if (jitter.empty()) refuse(*node, "jitter holds nothing; write { reflect = X, refract = X, shadow = X }, each optional");
        for (const auto& [key, amount] : {std::pair("reflect", &scene_.jitterReflect), std::pair("refract", &scene_.jitterRefract),
                                          std::pair("shadow", &scene_.jitterShadow)})
            if (const auto* value = jitter.get(key)) *amount = numberOf(*value, std::string("jitter.") + key, 0, kMostJitter);
    }
    if (const auto* node = root.get("seed")) scene_.seed = uint32_t(integerOf(*node, "seed", 0, 0xffffffff));
    if (const auto* node = root.get("levels")) {
        scene_.cutLevels = choiceOf<bool>(*node, "levels", {{"exact", false}, {"cut", true}});
        if (*scene_.cutLevels && scene_.encoding != Encoding::linear)
            refuse(*node, "levels = \"cut\" counts bytes as light: it goes with encoding = \"linear\"");
    }
}

void SceneFile::readCamera(const toml::table& table) {
    allowKeys(table, "[camera]", {"distance", "eye", "at", "up", "fov", "near"});
    Camera camera;
    if (const auto* distance = table.get("distance")) {
        for (const char* key : {"eye", "at", "up", "fov"})
            if (const auto* other = table.get(key))
                refuse(*other, fmt::format("camera.{} beside camera.distance: the notes' viewer is fixed", key));
        if (!scene_.leftHanded) refuse(*distance, "camera.distance is the notes' viewer; it needs handedness = \"left\"");
        const double d = numberOf(*distance, "camera.distance", 0, kMaxCoordinate);
        if (d == 0) refuse(*distance, "camera.distance is 0");
        camera.eye = {0, 0, -d};
        camera.right = {1, 0, 0};
        camera.up = {0, 1, 0};
        camera.forward = {0, 0, 1};
        camera.focalPixels = d;
        camera.focusDistance = d;
    } else {
        camera.eye = vectorOf(required(table, "eye", "camera"), "camera.eye");
        const toml::node& at = required(table, "at", "camera");
        const dvec3 toward = vectorOf(at, "camera.at") - camera.eye;
        if (largestMagnitude(toward) == 0) refuse(at, "camera.at is the same point as camera.eye");
        const auto* upNode = table.get("up");
        const dvec3 up = upNode ? unitVector(axisOf(*upNode, "camera.up")) : scene_.up;
        camera.forward = unitVector(toward);
        const dvec3 right = scene_.leftHanded ? glm::cross(up, camera.forward) : glm::cross(camera.forward, up);
        if (largestMagnitude(right) < kMinCross)
            refuse(upNode ? *upNode : at, fmt::format("camera.up is parallel to the view direction{}",
                                                      upNode ? "" : "; state another camera.up"));
        camera.right = unitVector(right);
        camera.up = scene_.leftHanded ? glm::cross(camera.forward, camera.right) : glm::cross(camera.right, camera.forward);
        if (const auto* node = table.get("fov")) {
            camera.fovYDegrees = numberOf(*node, "camera.fov", 0, 180);
            if (camera.fovYDegrees < 1e-3 || camera.fovYDegrees > 179)
                refuse(*node, fmt::format("camera.fov is {:g}, outside 0.001 to 179 degrees", camera.fovYDegrees));
        }
        const double scale = largestMagnitude(toward);
        camera.focusDistance = glm::length(toward / scale) * scale;
    }
    if (const auto* node = table.get("near")) {
        camera.near = numberOf(*node, "camera.near", 0, kMaxCoordinate);
        if (camera.near == 0) refuse(*node, "camera.near is 0");
    }
    scene_.camera = camera;
}

void SceneFile::readMaterial(const toml::table& table) {
    allowKeys(table, "[[material]]", {"name", "ambient", "diffuse", "specular", "emission", "shininess", "opacity", "ior", "density",
                                    "reflect", "transmit", "local"});
    const toml::node& nameNode = required(table, "name", "material");
    Material material;
    material.name = stringOf(nameNode, "material.name");
    const bool restatesDefault = material.name == "default" && !defaultStated_;
    if (materials_.contains(material.name) && !restatesDefault)
        refuse(nameNode, fmt::format("material.name '{}' is taken", printable(material.name, 64)));
    const auto colour = [&](const char* key, glm::vec3& into) {
        if (const auto* node = table.get(key)) into = colourOf(*node, std::string("material.") + key, 1);
    };
    colour("ambient", material.ambient);
    colour("diffuse", material.diffuse);
    colour("specular", material.specular);
    colour("emission", material.emission);
    if (const auto* node = table.get("shininess"))
        material.shininess = float(numberOf(*node, "material.shininess", 0, kMaxShininess));
    if (const auto* node = table.get("opacity")) material.opacity = float(numberOf(*node, "material.opacity", 0, 1));
    if (const auto* node = table.get("ior"))
        material.refractiveIndex = float(numberOf(*node, "material.ior", 0.01, 100));
    if (const auto* node = table.get("density")) {
        if (table.contains("ior")) refuse(*node, "material.density beside material.ior: they are two names of one number");
        material.refractiveIndex = float(numberOf(*node, "material.density", 0.01, 100));
    }
    readWeights(table, material);
    if (restatesDefault) {
        scene_.materials[0] = material;
        defaultStated_ = true;
        return;
    }
    materials_[material.name] = uint32_t(scene_.materials.size());
    scene_.materials.push_back(material);
}

// Shares of the mirrored, the refracted and the local colour. Opacity below 1 lets its rest pass unless `transmit` says otherwise.
void SceneFile::readWeights(const toml::table& table, Material& material) const {
    const auto weight = [&](const char* key, double fallback) {
        const auto* node = table.get(key);
        return node ? numberOf(*node, std::string("material.") + key, 0, 1) : fallback;
    };
    const double reflect = weight("reflect", 0), transmit = weight("transmit", 1.0 - double(material.opacity));
    const double local = weight("local", std::max(0.0, 1 - reflect - transmit));
    if (!(reflect + transmit + local <= kLargestWeightSum))
        refuse(table, fmt::format("material '{}': reflect {:g}, transmit {:g} and local {:g} add up to more than 1",
                                  printable(material.name, 64), reflect, transmit, local));
    material.reflect = float(reflect);
    material.transmit = float(transmit);
    material.local = float(local);
    material.statesRays = reflect > 0 || (table.get("transmit") && transmit > 0);
}

uint32_t SceneFile::materialNamed(const toml::node& node, const std::string& field) const {
    const std::string name = stringOf(node, field);
    const auto found = materials_.find(name);
    if (found != materials_.end()) return found->second;
    std::vector<std::string_view> known;
    for (const auto& [key, index] : materials_) {
        (void)index;
        known.push_back(key);
    }
    refuse(node, fmt::format("{} names the unknown material '{}'{}", field, printable(name, 64), suggestion(name, known)));
}

void SceneFile::readLight(const toml::table& table) {
    allowKeys(table, "[[light]]", {"type", "direction", "position", "edge_u", "edge_v", "points", "intensity", "attenuation"});
    enum class Kind { directional, point, area };
    const Kind kind = choiceOf<Kind>(required(table, "type", "light"), "light.type",
                                     {{"directional", Kind::directional}, {"point", Kind::point}, {"area", Kind::area}});
    if (kind == Kind::directional)
        for (const char* key : {"position", "attenuation"})
            if (const auto* node = table.get(key)) refuse(*node, fmt::format("light.{} needs type = \"point\"", key));
    if (kind != Kind::directional)
        if (const auto* node = table.get("direction")) refuse(*node, "light.direction needs type = \"directional\"");
    if (kind != Kind::area)
        for (const char* key : {"edge_u", "edge_v", "points"})
            if (const auto* node = table.get(key)) refuse(*node, fmt::format("light.{} needs type = \"area\"", key));
    Light light;
    light.directional = kind == Kind::directional;
    if (const auto* node = table.get("intensity")) light.intensity = colourOf(*node, "light.intensity", kMaxCoordinate);
    if (const auto* node = table.get("attenuation"))
        light.attenuation = choiceOf<Attenuation>(*node, "light.attenuation",
                                                  {{"none", Attenuation::none}, {"1/d", Attenuation::inverse}, {"1/d^2", Attenuation::inverseSquare}});
    if (light.directional) light.direction = axisOf(required(table, "direction", "directional light"), "light.direction");
    if (kind == Kind::point) light.position = vectorOf(required(table, "position", "point light"), "light.position");
    if (kind == Kind::area)
        readArea(table, light);
    else
        scene_.lights.push_back(light);
}

// A lamp with a size becomes points: k along a line, m times n on a rectangle.
void SceneFile::readArea(const toml::table& table, const Light& light) {
    AreaLight area;
    area.intensity = light.intensity;
    area.attenuation = light.attenuation;
    area.corner = vectorOf(required(table, "position", "area light"), "light.position");
    area.u = axisOf(required(table, "edge_u", "area light"), "light.edge_u");
    const auto* second = table.get("edge_v");
    if (second) area.v = axisOf(*second, "light.edge_v");
    const toml::node& points = required(table, "points", "area light");
    if (second) {
        const toml::array& counts = arrayOf(points, "light.points");
        if (counts.size() != 2) refuse(points, fmt::format("light.points has {} numbers, not 2: along edge_u and along edge_v", counts.size()));
        area.pointsU = uint32_t(integerOf(counts[0], "light.points[0]", 1, kMaxAreaPoints));
        area.pointsV = uint32_t(integerOf(counts[1], "light.points[1]", 1, kMaxAreaPoints));
    } else {
        area.pointsU = uint32_t(integerOf(points, "light.points", 1, kMaxAreaPoints));
    }
    if (area.pointsU * area.pointsV > kMaxAreaPoints)
        refuse(points, fmt::format("light.points makes {} points; an area light has at most {}", area.pointsU * area.pointsV, kMaxAreaPoints));
    for (const Light& point : pointsOf(area)) {
        if (!(std::max({std::abs(point.position.x), std::abs(point.position.y), std::abs(point.position.z)}) <= kMaxCoordinate))
            refuse(table, "light: a point of it has a coordinate above 2^100");
        scene_.lights.push_back(point);
    }
}

void SceneFile::readSphere(const toml::table& table) {
    allowKeys(table, "[[sphere]]", {"name", "centre", "radius", "material"});
    SphereShape sphere;
    if (const auto* node = table.get("name")) sphere.name = stringOf(*node, "sphere.name");
    sphere.centre = vectorOf(required(table, "centre", "sphere"), "sphere.centre");
    const toml::node& radius = required(table, "radius", "sphere");
    sphere.radius = numberOf(radius, "sphere.radius");
    if (!(sphere.radius > 0)) refuse(radius, fmt::format("sphere.radius is {:g}, not above 0", sphere.radius));
    if (sphere.radius > kMaxCoordinate) refuse(radius, fmt::format("sphere.radius is {:g}, above 2^100", sphere.radius));
    if (const auto* node = table.get("material")) sphere.material = materialNamed(*node, "sphere.material");
    scene_.spheres.push_back(std::move(sphere));
}

void SceneFile::readPlane(const toml::table& table) {
    allowKeys(table, "[[plane]]", {"name", "point", "normal", "u", "u_range", "v_range", "two_sided", "material", "board"});
    PlaneShape plane;
    if (const auto* node = table.get("name")) plane.name = stringOf(*node, "plane.name");
    plane.point = vectorOf(required(table, "point", "plane"), "plane.point");
    plane.normal = unitVector(axisOf(required(table, "normal", "plane"), "plane.normal"));
    // The coordinate axis that is least along the normal, X first: Y = const has u = X and v = Z.
    dvec3 u(1, 0, 0);
    const dvec3 n = plane.normal;
    if (std::abs(n.x) > std::abs(n.y) || std::abs(n.x) > std::abs(n.z)) u = std::abs(n.y) <= std::abs(n.z) ? dvec3(0, 1, 0) : dvec3(0, 0, 1);
    const auto* uNode = table.get("u");
    if (uNode) u = unitVector(axisOf(*uNode, "plane.u"));
    u -= n * glm::dot(n, u);
    if (largestMagnitude(u) < kMinCross) refuse(uNode ? *uNode : *table.get("normal"), "plane.u is parallel to plane.normal");
    plane.u = unitVector(u);
    plane.v = glm::cross(plane.u, n);
    const auto range = [&](const char* key, double& least, double& most) {
        const auto* node = table.get(key);
        if (!node) return;
        const std::string field = std::string("plane.") + key;
        const toml::array& ends = arrayOf(*node, field);
        if (ends.size() != 2) refuse(*node, fmt::format("{} has {} numbers, not 2", field, ends.size()));
        least = numberOf(ends[0], field + "[0]", -kMaxCoordinate, kMaxCoordinate);
        most = numberOf(ends[1], field + "[1]", -kMaxCoordinate, kMaxCoordinate);
        if (!(least < most)) refuse(*node, fmt::format("{} is empty: {:g} is not below {:g}", field, least, most));
    };
    range("u_range", plane.uMin, plane.uMax);
    range("v_range", plane.vMin, plane.vMax);
    if (const auto* node = table.get("two_sided")) plane.twoSided = booleanOf(*node, "plane.two_sided");
    if (const auto* node = table.get("material")) plane.material = materialNamed(*node, "plane.material");
    if (const auto* node = table.get("board")) {
        const toml::table& board = tableOf(*node, "plane.board");
        allowKeys(board, "plane.board", {"square", "material", "mirrored"});
        const toml::node& square = required(board, "square", "plane.board");
        plane.square = numberOf(square, "plane.board.square");
        if (!(plane.square > 0)) refuse(square, fmt::format("plane.board.square is {:g}, not above 0", plane.square));
        if (plane.square > kMaxCoordinate) refuse(square, fmt::format("plane.board.square is {:g}, above 2^100", plane.square));
        plane.otherMaterial = materialNamed(required(board, "material", "plane.board"), "plane.board.material");
        if (const auto* mirrored = board.get("mirrored")) plane.mirrored = booleanOf(*mirrored, "plane.board.mirrored");
    }
    scene_.planes.push_back(std::move(plane));
}

void SceneFile::readMesh(const toml::table& table) {
    allowKeys(table, "[[mesh]]", {"name", "file", "vertices", "faces", "material", "face_materials", "crease"});
    const toml::node& nameNode = required(table, "name", "mesh");
    const std::string name = stringOf(nameNode, "mesh.name");
    if (meshes_.contains(name)) refuse(nameNode, fmt::format("mesh.name '{}' is taken", printable(name, 64)));
    LoadOptions options = options_;
    if (const auto* node = table.get("crease")) options.creaseDegrees = numberOf(*node, "mesh.crease", 0, 180);

    uint32_t index;
    if (const auto* fileNode = table.get("file")) {
        for (const char* key : {"vertices", "faces", "face_materials"})
            if (const auto* other = table.get(key)) refuse(*other, fmt::format("mesh.{} beside mesh.file", key));
        const std::string reference = stringOf(*fileNode, "mesh.file");
        const auto file = resolveReference(path_, reference, options.allowOutside, place(*fileNode), "mesh.file");
        std::error_code code;
        if (!std::filesystem::exists(file, code))
            refuse(*fileNode, fmt::format("mesh.file '{}' does not exist", printable(reference)));
        const auto* materialNode = table.get("material");
        const uint32_t material = materialNode ? materialNamed(*materialNode, "mesh.material") : kNone;
        const std::tuple key(file.lexically_normal().string(), options.creaseDegrees, material);
        const auto [read, isNew] = meshFiles_.try_emplace(key);
        if (isNew) {
            options.keepMaterials = material == kNone;
            read->second = addMeshFile(scene_, file, options);
            if (material != kNone) paint(scene_.meshes[read->second], material);
        }
        index = read->second;
    } else {
        index = readInlineMesh(table, name, options);
    }
    meshes_[name] = index;
    meshNames_.push_back(name);
}

uint32_t SceneFile::readInlineMesh(const toml::table& table, const std::string& name, const LoadOptions& options) {
    PolygonMesh mesh;
    mesh.name = name;
    if (!table.get("vertices")) refuse(table, fmt::format("mesh '{}' has neither 'file' nor 'vertices'", printable(name, 64)));
    const toml::array& vertices = arrayOf(*table.get("vertices"), "mesh.vertices");
    mesh.positions.reserve(vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
        const std::string field = fmt::format("mesh.vertices[{}]", i);
        const toml::array* point = vertices[i].as_array();
        if (point != nullptr && point->size() == 2)  // a point of the plane
            mesh.positions.emplace_back(float(numberOf((*point)[0], field + "[0]", -kMaxCoordinate, kMaxCoordinate)), float(numberOf((*point)[1], field + "[1]", -kMaxCoordinate, kMaxCoordinate)), 0.0f);
        else
            mesh.positions.push_back(glm::vec3(vectorOf(vertices[i], field)));
    }

    const toml::node& facesNode = required(table, "faces", "mesh");
    const toml::array& faces = arrayOf(facesNode, "mesh.faces");
    if (faces.empty()) refuse(facesNode, "mesh.faces is empty");
    mesh.faceFirst.push_back(0);
    for (size_t f = 0; f < faces.size(); ++f) {
        const std::string field = fmt::format("mesh.faces[{}]", f);
        const toml::array& face = arrayOf(faces[f], field);
        if (face.size() < 3) refuse(faces[f], fmt::format("{} has {} vertices; a polygon has at least 3", field, face.size()));
        std::set<int64_t> seen;
        for (size_t corner = 0; corner < face.size(); ++corner) {
            const std::string cornerField = fmt::format("{}[{}]", field, corner);
            if (vertices.empty()) refuse(face[corner], cornerField + " names a vertex of none");
            const int64_t vertex = integerOf(face[corner], cornerField, 0, int64_t(vertices.size()) - 1);
            if (!seen.insert(vertex).second)
                refuse(face[corner], fmt::format("{} names vertex {} twice", field, vertex));
            mesh.corners.push_back({uint32_t(vertex)});
        }
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
    }

    const auto* materialNode = table.get("material");
    const auto* listNode = table.get("face_materials");
    if (materialNode && listNode) refuse(*listNode, "mesh.face_materials beside mesh.material");
    if (listNode) {
        const toml::array& list = arrayOf(*listNode, "mesh.face_materials");
        if (list.size() != faces.size())
            refuse(*listNode, fmt::format("mesh.face_materials has {} names for {} faces", list.size(), faces.size()));
        for (size_t f = 0; f < list.size(); ++f)
            mesh.faceMaterial.push_back(materialNamed(list[f], fmt::format("mesh.face_materials[{}]", f)));
    } else {
        mesh.faceMaterial.assign(faces.size(), materialNode ? materialNamed(*materialNode, "mesh.material") : 0);
    }
    const uint32_t index = addMesh(scene_, std::move(mesh), place(table), options);
    scene_.meshes[index].place = place(facesNode);
    warnOfRepairs(scene_, index, place(table));
    return index;
}

// About an axis through a point (Rodrigues), or about the line through two points (the notes' seven matrices).
SceneFile::Placement SceneFile::readRotate(const toml::node& node, const std::string& field) const {
    const toml::table& rotate = tableOf(node, field);
    allowKeys(rotate, field, {"axis", "degrees", "through", "from", "to"});
    const double degrees = numberOf(required(rotate, "degrees", field), field + ".degrees");
    if (const auto* fromNode = rotate.get("from")) {
        for (const char* key : {"axis", "through"})
            if (const auto* other = rotate.get(key)) refuse(*other, fmt::format("{0}.{1} beside {0}.from", field, key));
        const dvec3 from = vectorOf(*fromNode, field + ".from");
        const toml::node& toNode = required(rotate, "to", field);
        Placement placement{dmat4(1.0), lineSteps(from, vectorOf(toNode, field + ".to"), degrees)};
        if (placement.steps.empty()) refuse(toNode, field + ".to is the same point as from: two equal points have no line");
        for (const Step3& step : placement.steps) placement.matrix = step.matrix * placement.matrix;
        return placement;
    }
    if (const auto* to = rotate.get("to")) refuse(*to, fmt::format("{0}.to without {0}.from", field));
    const dvec3 axis = unitVector(axisOf(required(rotate, "axis", field), field + ".axis"));
    const Step3 step = rotateStep(axis, degrees);
    const auto* through = rotate.get("through");
    if (!through) return {step.matrix, {step}};
    const dvec3 point = vectorOf(*through, field + ".through");
    return {about(point, step.matrix), aboutSteps(point, step)};
}

// Where `about` is: a point, or "centre", the visual centre of the object's mesh as the transforms before this one leave it.
dvec3 SceneFile::centreOf(const toml::node& about, const std::string& field, uint32_t mesh, const dmat4& before) const {
    if (!about.is_string()) return vectorOf(about, field);
    const std::string word = stringOf(about, field);
    if (word != "centre" && word != "center") refuse(about, fmt::format("{} is '{}', not a point or \"centre\"", field, printable(word, 40)));
    if (mesh == kNone) refuse(about, field + " is the centre of an object without a mesh");
    const std::vector<glm::vec3>& positions = scene_.meshes[mesh].positions;
    if (positions.empty()) refuse(about, field + " is the centre of a mesh without vertices");
    std::vector<dvec3> points(positions.begin(), positions.end());
    for (dvec3& p : points) p = transformed(before, p);
    return visualCentre(std::span<const dvec3>(points));
}

SceneFile::Placement SceneFile::readTransform(const toml::table& table, const std::string& field, uint32_t mesh, const dmat4& before) const {
    allowKeys(table, field, {"translate", "rotate_x", "rotate_y", "rotate_z", "rotate", "scale", "matrix", "about"});
    const toml::node* aboutNode = table.get("about");
    if (table.size() != (aboutNode ? 2u : 1u))
        refuse(table, fmt::format("{} holds {} transforms; write one a table, in order of application", field,
                                  table.size() - (aboutNode ? 1 : 0)));
    Step3 step;
    bool canBeAbout = true;
    if (const auto* node = table.get("translate")) {
        step = translateStep(vectorOf(*node, field + ".translate"));
        canBeAbout = false;
    } else if (const auto* node = table.get("rotate_x")) {
        step = rotateXStep(numberOf(*node, field + ".rotate_x"));
    } else if (const auto* node = table.get("rotate_y")) {
        step = rotateYStep(numberOf(*node, field + ".rotate_y"));
    } else if (const auto* node = table.get("rotate_z")) {
        step = rotateZStep(numberOf(*node, field + ".rotate_z"));
    } else if (const auto* node = table.get("rotate")) {
        if (aboutNode) refuse(*aboutNode, field + ".about goes with rotate_x, rotate_y, rotate_z and scale");
        return readRotate(*node, field + ".rotate");
    } else if (const auto* node = table.get("scale")) {
        const dvec3 factors = node->is_array()
                                  ? vectorOf(*node, field + ".scale")
                                  : dvec3(numberOf(*node, field + ".scale", -kMaxCoordinate, kMaxCoordinate));
        if (factors.x == 0 || factors.y == 0 || factors.z == 0)
            refuse(*node, field + ".scale is 0: normals need its inverse");
        step = scaleStep(factors);
    } else {
        const toml::node& matrix = *table.get("matrix");
        const std::string name = field + ".matrix";
        const toml::array& entries = arrayOf(matrix, name);
        if (entries.size() != 16) refuse(matrix, fmt::format("{} has {} numbers, not 16", name, entries.size()));
        double rows[16];
        for (size_t i = 0; i < 16; ++i)
            rows[i] = numberOf(entries[i], fmt::format("{}[{}]", name, i), -kMaxCoordinate, kMaxCoordinate);
        if (rows[12] != 0 || rows[13] != 0 || rows[14] != 0 || rows[15] != 1)
            refuse(matrix, name + ": the last row is not 0, 0, 0, 1 (rows of a matrix for column vectors)");
        step = matrixStep(fromRows(rows));
        if (!hasInverse(step.matrix)) refuse(matrix, name + " has no inverse");
        canBeAbout = false;
    }
    if (!aboutNode) return {step.matrix, {step}};
    if (!canBeAbout) refuse(*aboutNode, field + ".about goes with rotate_x, rotate_y, rotate_z and scale");
    const dvec3 point = centreOf(*aboutNode, field + ".about", mesh, before);
    return {about(point, step.matrix), aboutSteps(point, step)};
}

// In order of application: the first of the list acts on the object first.
SceneFile::Placement SceneFile::readTransforms(const toml::node& node, const std::string& field, uint32_t mesh) const {
    Placement all;
    size_t i = 0;
    for (const toml::node& element : arrayOf(node, field)) {
        const std::string name = fmt::format("{}[{}]", field, i++);
        const toml::table& table = tableOf(element, name);
        if (table.empty() || (table.size() == 1 && table.contains("about"))) refuse(element, name + " holds no transform");
        const Placement next = readTransform(table, name, mesh, all.matrix);
        all.matrix = next.matrix * all.matrix;
        all.steps.insert(all.steps.end(), next.steps.begin(), next.steps.end());
        if (!entriesUsable(all.matrix)) refuse(element, name + ": the matrix so far has entries above 2^100");
    }
    return all;
}

void SceneFile::readObject(const toml::table& table, int parent, int depth) {
    allowKeys(table, parent < 0 ? "[[object]]" : "[[object.child]]", {"name", "mesh", "material", "transform", "parent", "child"});
    if (depth > kMaxDepth) refuse(table, tooDeep());
    Node node;
    node.table = &table;
    node.parent = parent;
    if (const auto* meshNode = table.get("mesh")) {
        const std::string mesh = stringOf(*meshNode, "object.mesh");
        const auto found = meshes_.find(mesh);
        if (found == meshes_.end())
            refuse(*meshNode, fmt::format("object.mesh names the unknown mesh '{}'{}", printable(mesh, 64),
                                          suggestion(mesh, meshNames_)));
        node.mesh = found->second;
        node.name = mesh;
    }
    if (const auto* nameNode = table.get("name")) {
        node.name = stringOf(*nameNode, "object.name");
        if (!nodeNames_.emplace(node.name, int(nodes_.size())).second)
            refuse(*nameNode, fmt::format("object.name '{}' is taken", printable(node.name, 64)));
    }
    if (const auto* materialNode = table.get("material")) {
        if (node.mesh == kNone) refuse(*materialNode, "object.material without object.mesh");
        node.material = materialNamed(*materialNode, "object.material");
    }
    if (const auto* transform = table.get("transform")) node.parentFromNode = readTransforms(*transform, "object.transform", node.mesh);
    if (const auto* parentNode = table.get("parent")) {
        if (parent >= 0) refuse(*parentNode, "object.parent of a nested child: it has a parent already");
        node.parentNamed = parentNode;
    }
    const int self = int(nodes_.size());
    nodes_.push_back(std::move(node));
    eachTable(table, "child", "object.child", [&](const toml::table& child) { readObject(child, self, depth + 1); });
}

void SceneFile::linkParents() {
    for (Node& node : nodes_) {
        if (!node.parentNamed) continue;
        const std::string name = stringOf(*node.parentNamed, "object.parent");
        const auto found = nodeNames_.find(name);
        if (found == nodeNames_.end()) {
            std::vector<std::string_view> known;
            for (const auto& [key, index] : nodeNames_) {
                (void)index;
                known.push_back(key);
            }
            refuse(*node.parentNamed, fmt::format("object.parent names the unknown object '{}'{}", printable(name, 64),
                                                  suggestion(name, known)));
        }
        node.parent = found->second;
    }
}

// World matrices from the roots down, each node once, and the objects in file order.
void SceneFile::placeObjects() {
    for (size_t start = 0; start < nodes_.size(); ++start) {
        std::vector<int> chain;  // from `start` up to the first placed ancestor
        for (int n = int(start); n >= 0 && !nodes_[size_t(n)].placed; n = nodes_[size_t(n)].parent) {
            const auto again = std::find(chain.begin(), chain.end(), n);
            if (again != chain.end()) {
                std::string cycle;
                for (auto member = again; member != chain.end(); ++member)
                    cycle += printable(nodes_[size_t(*member)].name, 40) + " -> ";
                const Node& first = nodes_[size_t(n)];
                refuse(first.parentNamed ? *first.parentNamed : *first.table,
                       fmt::format("object.parent: {}{} is a cycle", printable(cycle, 400), printable(first.name, 40)));
            }
            chain.push_back(n);
            if (int(chain.size()) > kMaxDepth) refuse(*nodes_[start].table, tooDeep());
        }
        for (auto n = chain.rbegin(); n != chain.rend(); ++n) {
            Node& node = nodes_[size_t(*n)];
            node.worldFromNode = node.parent < 0 ? node.parentFromNode.matrix
                                                 : nodes_[size_t(node.parent)].worldFromNode * node.parentFromNode.matrix;
            if (!entriesUsable(node.worldFromNode))
                refuse(*node.table, "object.transform: the world matrix has entries above 2^100");
            if (node.mesh != kNone && !hasInverse(node.worldFromNode))
                refuse(*node.table, "object.transform: the world matrix has no inverse");
            node.depth = node.parent < 0 ? 1 : nodes_[size_t(node.parent)].depth + 1;
            if (node.depth > kMaxDepth) refuse(*node.table, tooDeep());
            node.placed = true;
        }
    }
    for (const Node& node : nodes_) {
        if (node.mesh == kNone) continue;
        Object object;
        object.name = node.name;
        object.mesh = node.material == kNone ? node.mesh : meshWithMaterial(node.mesh, node.material, *node.table);
        object.worldFromObject = node.worldFromNode;
        for (const Node* n = &node;; n = &nodes_[size_t(n->parent)]) {  // its own steps act first, then its parent's
            object.chain.insert(object.chain.end(), n->parentFromNode.steps.begin(), n->parentFromNode.steps.end());
            if (n->parent < 0) break;
        }
        scene_.objects.push_back(std::move(object));
    }
}

// A TriangleMesh carries its materials, so an object that replaces them draws a copy; one for each (mesh, material).
uint32_t SceneFile::meshWithMaterial(uint32_t mesh, uint32_t material, const toml::table& place) {
    const auto [found, isNew] = recoloured_.try_emplace({mesh, material}, uint32_t(scene_.meshes.size()));
    if (isNew) {
        copiedTriangles_ += scene_.meshes[mesh].triangles.size();
        if (copiedTriangles_ > kMaxCopiedTriangles)
            refuse(place, fmt::format("object.material copies more than {} triangles in all", kMaxCopiedTriangles));
        TriangleMesh copy = scene_.meshes[mesh];
        paint(copy, material);
        scene_.meshes.push_back(std::move(copy));
    }
    return found->second;
}

Scene SceneFile::read() {
    const std::string text = readWholeFile(path_, kMaxSceneFileBytes);
    refuseDeepKeys(text);
    toml::table root;
    try {
        root = toml::parse(std::string_view(text));
    } catch (const toml::parse_error& error) {
        throw inputError(place(error.source()), "TOML: " + printable(error.description()));
    }
    allowKeys(root, "the scene", {"handedness", "up", "ambient", "background", "encoding", "shading", "fill", "wire", "edges", "viewer", "size", "cull",
                                  "max_depth", "min_weight", "sampling", "jitter", "seed", "levels", "shadows", "sphere_heights", "z_buffer", "camera", "material", "light", "mesh", "object", "sphere", "plane"});
    scene_.path = path_.string();
    scene_.sha256 = sha256Hex(std::as_bytes(std::span(text)));
    scene_.materials.push_back(Material{});
    materials_["default"] = 0;
    readSettings(root);
    if (const auto* node = root.get("camera")) readCamera(tableOf(*node, "camera"));
    eachTable(root, "material", "material", [&](const toml::table& table) { readMaterial(table); });
    eachTable(root, "light", "light", [&](const toml::table& table) { readLight(table); });
    eachTable(root, "mesh", "mesh", [&](const toml::table& table) { readMesh(table); });
    eachTable(root, "sphere", "sphere", [&](const toml::table& table) { readSphere(table); });
    eachTable(root, "plane", "plane", [&](const toml::table& table) { readPlane(table); });
    eachTable(root, "object", "object", [&](const toml::table& table) { readObject(table, -1, 1); });
    if (!root.contains("object")) {
        for (const std::string& name : meshNames_) {
            Node node;
            node.name = name;
            node.table = &root;
            node.mesh = meshes_.find(name)->second;
            nodes_.push_back(std::move(node));
        }
    }
    linkParents();
    placeObjects();
    if (scene_.objects.empty() && scene_.spheres.empty() && scene_.planes.empty())
        throw inputError(placeOfLine(path_, 1, 1), "nothing to draw: no [[object]] has a mesh and there is no [[mesh]], [[sphere]] or [[plane]]");
    return std::move(scene_);
}

}  // namespace

Scene readSceneToml(const std::filesystem::path& path, const LoadOptions& options) {
    return SceneFile(path, options).read();
}

}  // namespace plumb
