// SPDX-License-Identifier: MIT
// Reads glTF 2.0 (.gltf, .glb): whole scenes, right-handed, +Y up. The specification is cited as "glTF n.n".
// Nothing is allocated on a number of the file: accessors are checked against the bytes that are there, and the
// corners of all meshes together against the bytes that were read (kMaxCornersPerByte).
// What a file asks for and is not drawn goes into Scene::ignored, once a kind; with `strict` it is refused.
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/affine.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;
using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "binary glTF is read as it lies in memory");

// A JSON value takes up to 32 bytes of memory for two of text.
constexpr uint64_t kMaxJsonBytes = uint64_t(256) << 20;
constexpr int kMaxDepth = 64;  // of JSON and of the node hierarchy
// One byte of indices makes at most three corners (a strip), and one accessor may serve a few primitives; a file that
// asks for more repeats its data to fill our memory.
constexpr uint64_t kMaxCornersPerByte = 16;
constexpr double kMaxShininess = 1e6;
// Lights of glTF are in lux and candela and its diffuse BRDF is colour / pi; ours is the colour.
constexpr double kIntensityPerLux = 1 / 3.14159265358979323846;

// A value of the file and the pointer (RFC 6901) that leads to it.
class Value {
public:
    Value(const std::filesystem::path& file, const json& node, std::string pointer)
        : file_(&file), node_(&node), pointer_(std::move(pointer)) {}

    [[noreturn]] void refuse(std::string_view text) const { throw inputError(place(), std::string(text)); }
    std::string place() const { return placeOfPointer(*file_, pointer_.empty() ? "/" : pointer_); }

    std::optional<Value> find(const char* key) const {
        wanted(node_->is_object(), "an object");
        const auto found = node_->find(key);
        if (found == node_->end()) return std::nullopt;
        return Value(*file_, *found, pointer_ + "/" + key);
    }
    Value required(const char* key) const {
        if (auto value = find(key)) return *value;
        refuse(fmt::format("has no '{}'", key));
    }
    // The array `key` of this object; an absent one is empty.
    std::vector<Value> list(const char* key) const {
        std::vector<Value> values;
        if (const auto array = find(key)) {
            values.reserve(array->size());
            for (size_t i = 0; i < array->size(); ++i) values.push_back(array->element(i));
        }
        return values;
    }
    size_t size() const {
        wanted(node_->is_array(), "an array");
        return node_->size();
    }
    Value element(size_t i) const { return Value(*file_, (*node_)[i], fmt::format("{}/{}", pointer_, i)); }
    std::vector<std::string> keys() const {
        wanted(node_->is_object(), "an object");
        std::vector<std::string> names;
        for (const auto& [key, value] : node_->items()) {
            (void)value;
            names.push_back(key);
        }
        return names;
    }

    double number(double least, double most) const {
        wanted(node_->is_number(), "a number");
        const double value = node_->get<double>();
        if (!std::isfinite(value)) refuse("is not finite");
        if (value < least || value > most) refuse(fmt::format("is {:g}, outside {:g} to {:g}", value, least, most));
        return value;
    }
    // JSON writes whole numbers as 3 or as 3.0.
    uint64_t whole(uint64_t most) const {
        uint64_t value = 0;
        if (node_->is_number_unsigned()) {
            value = node_->get<uint64_t>();
        } else {
            const double real = node_->is_number_float() ? node_->get<double>() : -1;
            if (!(real >= 0 && real <= 0x1p53 && real == std::floor(real))) wanted(false, "a whole number");
            value = uint64_t(real);
        }
        if (value > most) refuse(fmt::format("is {}, above {}", value, most));
        return value;
    }
    // An index into something with `count` elements.
    size_t index(size_t count, const char* ofWhat) const {
        const uint64_t value = whole(UINT64_MAX);
        if (value >= count) refuse(fmt::format("is {}, but there are {} {}", value, count, ofWhat));
        return size_t(value);
    }
    const std::string& text() const {
        wanted(node_->is_string(), "a string");
        return node_->get_ref<const std::string&>();
    }
    bool boolean() const {
        wanted(node_->is_boolean(), "true or false");
        return node_->get<bool>();
    }
    template <size_t N>
    std::array<double, N> numbers(double least, double most) const {
        if (size() != N) refuse(fmt::format("has {} numbers, not {}", size(), N));
        std::array<double, N> values;
        for (size_t i = 0; i < N; ++i) values[i] = element(i).number(least, most);
        return values;
    }

private:
    void wanted(bool is, const char* kind) const {
        if (!is) refuse(fmt::format("is {}, not {}", described(), kind));
    }
    std::string described() const {
        if (node_->is_number()) return printable(node_->dump(), 40);
        return node_->is_null()      ? "null"
               : node_->is_boolean() ? "a boolean"
               : node_->is_string()  ? "a string"
               : node_->is_array()   ? "an array"
                                     : "an object";
    }

    const std::filesystem::path* file_;
    const json* node_;
    std::string pointer_;
};

// Elements of an accessor, checked: every element lies inside its buffer.
struct Accessor {
    std::string pointer;
    const char* data = nullptr;
    size_t stride = 0;
    size_t count = 0;
    int components = 1;
    int componentType = 0;
    bool normalized = false;
    std::shared_ptr<std::vector<char>> dense;  // owns `data` when the accessor is sparse

    double component(size_t element, int i) const;
    uint32_t index(size_t element) const;
};

size_t bytesOfComponent(int componentType) {
    switch (componentType) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
    }
}

template <class T>
T loadAs(const char* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

// glTF 3.6.2.2 and, for normalized integers, KHR_mesh_quantization.
double Accessor::component(size_t element, int i) const {
    const char* at = data + element * stride + size_t(i) * bytesOfComponent(componentType);
    switch (componentType) {
        case 5120:
            return normalized ? std::max(loadAs<int8_t>(at) / 127.0, -1.0) : loadAs<int8_t>(at);
        case 5121:
            return normalized ? loadAs<uint8_t>(at) / 255.0 : loadAs<uint8_t>(at);
        case 5122:
            return normalized ? std::max(loadAs<int16_t>(at) / 32767.0, -1.0) : loadAs<int16_t>(at);
        case 5123:
            return normalized ? loadAs<uint16_t>(at) / 65535.0 : loadAs<uint16_t>(at);
        case 5125:
            return loadAs<uint32_t>(at);
        default:
            return loadAs<float>(at);
    }
}

uint32_t Accessor::index(size_t element) const {
    const char* at = data + element * stride;
    return componentType == 5121 ? loadAs<uint8_t>(at) : componentType == 5123 ? loadAs<uint16_t>(at) : loadAs<uint32_t>(at);
}

// Vertices with the same bits of position (or normal) become one: glTF repeats a position at every seam, and edges
// and creases are found by position. -0 counts as +0.
template <class List>
class Welder {
public:
    explicit Welder(List& into) : into_(into) {}
    uint32_t add(glm::dvec3 v) {
        v += 0.0;  // -0 becomes +0
        // No two numbers of a vertex type have the same float32.
        const Key key{std::bit_cast<uint32_t>(float(v.x)), std::bit_cast<uint32_t>(float(v.y)), std::bit_cast<uint32_t>(float(v.z))};
        const auto [found, isNew] = known_.try_emplace(key, uint32_t(into_.size()));
        if (isNew) into_.push_back(typename List::value_type(v));
        return found->second;
    }

private:
    using Key = std::array<uint32_t, 3>;
    struct Hash {
        size_t operator()(const Key& key) const {
            uint64_t h = 0x9e3779b97f4a7c15u;
            for (uint32_t word : key) h = std::rotl((h ^ word) * 0xff51afd7ed558ccdu, 31);
            return size_t(h);
        }
    };
    List& into_;
    std::unordered_map<Key, uint32_t, Hash> known_;
};

class GltfFile {
public:
    GltfFile(const std::filesystem::path& path, const LoadOptions& options) : path_(path), options_(options) {}
    Scene read();

private:
    std::string_view unpackGlb();
    void parse(std::string_view text);
    void refuseDeepJson(std::string_view text) const;
    std::string placeInJson(size_t byte) const;
    void ignore(const Value& at, const std::string& what);
    void ignoreExtensions(const Value& owner, std::initializer_list<std::string_view> known);

    std::string_view buffer(size_t i);
    std::string decodeDataUri(const Value& uri) const;
    std::string_view bufferView(size_t i, size_t* strideBytes);
    Accessor accessor(const Value& index);
    void overlaySparse(const Value& from, const Value& sparse, Accessor& accessor);

    void readMaterials();
    void readPrimitive(const Value& primitive, PolygonMesh& mesh, Welder<Positions>& positions, Welder<std::vector<glm::vec3>>& normals);
    uint32_t mesh(const Value& index);
    dmat4 parentFromNode(const Value& node) const;
    void readNode(size_t i, const dmat4& worldFromParent, int depth);
    void readCamera(const Value& index, const dmat4& worldFromNode);
    void readLight(const Value& index, const dmat4& worldFromNode);
    void readNodes();
    Value root() const { return Value(path_, json_, ""); }

    std::filesystem::path path_;
    LoadOptions options_;
    size_t meshesRead_ = 0;
    std::string bytes_;
    bool isGlb_ = false;
    size_t jsonStart_ = 0;  // of the JSON text in bytes_
    std::string_view binaryChunk_;
    bool hasBinaryChunk_ = false;
    json json_;
    std::vector<Value> buffers_, bufferViews_, accessors_, nodes_, meshes_, lights_, cameras_;
    std::vector<std::optional<std::string_view>> bufferData_;
    std::vector<std::unique_ptr<std::string>> loaded_;  // owns what bufferData_ shows
    std::map<std::string, std::string_view> files_;     // external buffers, each read once
    std::vector<std::optional<uint32_t>> meshInScene_;  // kNone: nothing to draw in it
    std::vector<bool> visited_;
    uint64_t bytesRead_ = 0, corners_ = 0;
    Scene scene_;
};

void GltfFile::ignore(const Value& at, const std::string& what) {
    if (options_.strict) at.refuse(what + ": not drawn, and --strict refuses that");
    if (std::find(scene_.ignored.begin(), scene_.ignored.end(), what) == scene_.ignored.end()) scene_.ignored.push_back(what);
}

void GltfFile::ignoreExtensions(const Value& owner, std::initializer_list<std::string_view> known) {
    const auto extensions = owner.find("extensions");
    if (!extensions) return;
    for (const std::string& name : extensions->keys())
        if (std::find(known.begin(), known.end(), name) == known.end()) ignore(*extensions, "extension " + printable(name, 64));
}

// glTF 4.4: a 12-byte header, a JSON chunk, perhaps a BIN chunk; unknown chunks are skipped.
std::string_view GltfFile::unpackGlb() {
    const std::string_view all = bytes_;
    const auto word = [&](size_t at) { return loadAs<uint32_t>(all.data() + at); };
    const auto refuse = [&](size_t at, const std::string& text) -> Error { return inputError(placeOfByte(path_, at), text); };
    if (all.size() < 12) throw refuse(all.size(), "the file ends in the GLB header");
    if (word(4) != 2) throw refuse(4, fmt::format("GLB version {}; only 2 is read", word(4)));
    if (word(8) > all.size()) throw refuse(8, fmt::format("GLB length is {}, but the file has {} bytes", word(8), all.size()));
    const size_t end = word(8);
    std::string_view text;
    bool first = true;
    for (size_t at = 12; at < end;) {
        if (end - at < 8) throw refuse(at, "the file ends in a chunk header");
        const size_t length = word(at);
        const uint32_t type = word(at + 4);
        if (length > end - at - 8) throw refuse(at, fmt::format("chunk length is {}, but {} bytes follow", length, end - at - 8));
        const std::string_view chunk = all.substr(at + 8, length);
        constexpr uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
        if (first != (type == kJson)) throw refuse(at + 4, "the JSON chunk must come first and once");
        if (type == kJson) {
            text = chunk;
            jsonStart_ = at + 8;
        } else if (type == kBinary && !hasBinaryChunk_) {
            binaryChunk_ = chunk;
            hasBinaryChunk_ = true;
        }
        first = false;
        at += 8 + length;
    }
    if (first) throw refuse(12, "the GLB has no chunks");
    return text;
}

// Byte of the JSON text to a place: a line of a .gltf, a byte of a .glb.
std::string GltfFile::placeInJson(size_t byte) const {
    if (isGlb_) return placeOfByte(path_, jsonStart_ + byte);
    const std::string_view before = std::string_view(bytes_).substr(0, byte);
    const size_t lastLine = before.rfind('\n');
    return placeOfLine(path_, size_t(std::count(before.begin(), before.end(), '\n')) + 1,
                       byte - (lastLine == before.npos ? 0 : lastLine + 1) + 1);
}

// Before parsing, because each level costs far more memory than its one byte.
void GltfFile::refuseDeepJson(std::string_view text) const {
    int depth = 0;
    bool inString = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (inString) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                inString = false;
        } else if (c == '"') {
            inString = true;
        } else if (c == '[' || c == '{') {
            if (++depth > kMaxDepth) throw inputError(placeInJson(i), fmt::format("JSON is nested deeper than {}", kMaxDepth));
        } else if (c == ']' || c == '}') {
            --depth;
        }
    }
}

// Characters of a text that say how far they are read.
struct MeteredText {
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    const char* at;
    const char* begin;
    LoadMeter* meter;

    reference operator*() const { return *at; }
    MeteredText& operator++() {
        ++at;
        meter->at(uint64_t(at - begin));
        return *this;
    }
    MeteredText operator++(int) {
        const MeteredText before = *this;
        ++*this;
        return before;
    }
    bool operator==(const MeteredText& other) const { return at == other.at; }
    bool operator!=(const MeteredText& other) const { return at != other.at; }
};

void GltfFile::parse(std::string_view text) {
    if (text.size() > kMaxJsonBytes)
        throw inputError(placeInJson(0), fmt::format("{} bytes of JSON, more than {}", text.size(), kMaxJsonBytes));
    refuseDeepJson(text);
    // "[json.exception.parse_error.101] parse error at line 1, column 2: what is wrong"
    const auto reason = [](std::string_view message) {
        for (const std::string_view start : {"] ", "column "}) {
            const size_t at = message.find(start);
            if (at != message.npos) message.remove_prefix(at + start.size());
        }
        const size_t colon = message.find(": ");
        if (colon < 12) message.remove_prefix(colon + 2);
        return "JSON: " + printable(message);
    };
    try {
        LoadMeter meter(options_, "parse", kReadEnds, kParseEnds, text.size());
        json_ = json::parse(MeteredText{text.data(), text.data(), &meter}, MeteredText{text.data() + text.size(), text.data(), nullptr});
    } catch (const json::parse_error& error) {
        throw inputError(placeInJson(std::min(text.size(), error.byte == 0 ? 0 : error.byte - 1)), reason(error.what()));
    } catch (const json::out_of_range& error) {
        // "number overflow parsing '1e999'" knows no position; the word is looked up.
        const std::string_view message = error.what();
        const size_t open = message.find('\''), close = message.rfind('\'');
        size_t at = 0;
        if (open != message.npos && close > open + 1) at = text.find(message.substr(open + 1, close - open - 1));
        throw inputError(placeInJson(at == text.npos ? 0 : at), reason(message));
    }
}

// RFC 4648 base64, as every glTF writer emits; other encodings of data: are refused.
std::string GltfFile::decodeDataUri(const Value& uri) const {
    const std::string_view text = uri.text();
    const size_t comma = text.find(',');
    if (comma == text.npos || comma < 12 || text.substr(comma - 7, 7) != ";base64") uri.refuse("a data: URI that is not base64");
    std::string_view digits = text.substr(comma + 1);
    for (int padding = 0; padding < 2 && digits.ends_with('='); ++padding) digits.remove_suffix(1);
    if (digits.size() % 4 == 1) uri.refuse("base64 is cut short");
    std::string bytes;
    bytes.reserve(digits.size() / 4 * 3 + 3);
    uint32_t bits = 0;
    int count = 0;
    for (const char c : digits) {
        const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                          : c >= 'a' && c <= 'z' ? c - 'a' + 26
                          : c >= '0' && c <= '9' ? c - '0' + 52
                          : c == '+'             ? 62
                          : c == '/'             ? 63
                                                 : -1;
        if (digit < 0) uri.refuse(fmt::format("'{}' is not a base64 digit", printable(std::string_view(&c, 1))));
        bits = (bits << 6 | uint32_t(digit)) & 0xffffffu;
        count += 6;
        if (count >= 8) bytes.push_back(char(bits >> (count -= 8) & 0xffu));
    }
    return bytes;
}

std::string percentDecoded(std::string_view uri) {
    std::string text;
    const auto digit = [](char c) {
        return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    for (size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
            text.push_back(char(digit(uri[i + 1]) * 16 + digit(uri[i + 2])));
            i += 2;
        } else {
            text.push_back(uri[i]);
        }
    }
    return text;
}

// The bytes of a buffer, at least the byteLength that it states.
std::string_view GltfFile::buffer(size_t i) {
    if (bufferData_[i]) return *bufferData_[i];
    const Value& value = buffers_[i];
    const Value lengthValue = value.required("byteLength");
    const uint64_t length = lengthValue.whole(kMaxFileBytes);
    std::string_view data;
    if (const auto uri = value.find("uri")) {
        const std::string& text = uri->text();
        if (text.starts_with("data:")) {
            loaded_.push_back(std::make_unique<std::string>(decodeDataUri(*uri)));
            data = *loaded_.back();
        } else {
            if (text.find("://") != text.npos) uri->refuse("names a network address; only files are read");
            const auto file =
                resolveReference(referenceBase(path_, options_), percentDecoded(text), options_.allowOutside, uri->place(), "buffer");
            std::error_code code;
            if (!std::filesystem::exists(file, code)) uri->refuse(fmt::format("'{}' does not exist", printable(text)));
            const auto [known, isNew] = files_.try_emplace(file.lexically_normal().string());
            if (isNew) {
                loaded_.push_back(std::make_unique<std::string>(readWholeFile(file)));
                known->second = *loaded_.back();
                bytesRead_ += known->second.size();
            }
            data = known->second;
        }
    } else {
        if (i != 0 || !hasBinaryChunk_) value.refuse("has no uri, and there is no binary chunk for it");
        data = binaryChunk_;
    }
    if (length > data.size()) lengthValue.refuse(fmt::format("is {}, but the data has {} bytes", length, data.size()));
    bufferData_[i] = data.substr(0, size_t(length));
    return *bufferData_[i];
}

std::string_view GltfFile::bufferView(size_t i, size_t* strideBytes) {
    const Value& value = bufferViews_[i];
    const std::string_view data = buffer(value.required("buffer").index(buffers_.size(), "buffers"));
    const auto offsetValue = value.find("byteOffset");
    const uint64_t offset = offsetValue ? offsetValue->whole(kMaxFileBytes) : 0;
    const Value lengthValue = value.required("byteLength");
    const uint64_t length = lengthValue.whole(kMaxFileBytes);
    if (offset + length > data.size()) lengthValue.refuse(fmt::format("{} bytes at {} of a buffer of {}", length, offset, data.size()));
    const auto stride = value.find("byteStride");
    if (stride && stride->whole(252) < 4) stride->refuse("is below 4");
    if (strideBytes) *strideBytes = stride ? size_t(stride->whole(252)) : 0;
    return data.substr(size_t(offset), size_t(length));
}

Accessor GltfFile::accessor(const Value& index) {
    const Value& value = accessors_[index.index(accessors_.size(), "accessors")];
    Accessor result;
    result.pointer = value.place();
    const Value typeValue = value.required("type");
    const std::string& type = typeValue.text();
    static const std::map<std::string, int> kComponents{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                        {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    const auto known = kComponents.find(type);
    if (known == kComponents.end()) typeValue.refuse(fmt::format("'{}' is no type of accessor", printable(type, 40)));
    result.components = known->second;
    const Value componentValue = value.required("componentType");
    result.componentType = int(componentValue.whole(65535));
    const size_t componentBytes = bytesOfComponent(result.componentType);
    if (componentBytes == 0) componentValue.refuse(fmt::format("is {}, no component type", result.componentType));
    if (const auto normalized = value.find("normalized")) result.normalized = normalized->boolean();
    const Value countValue = value.required("count");
    const uint64_t count = countValue.whole(UINT64_MAX);
    if (count == 0) countValue.refuse("is 0");

    const auto view = value.find("bufferView");
    if (!view) value.refuse("has no bufferView; accessors of zeros are not read");
    const size_t elementBytes = componentBytes * size_t(result.components);
    const std::string_view data = bufferView(view->index(bufferViews_.size(), "bufferViews"), &result.stride);
    if (result.stride == 0) result.stride = elementBytes;
    if (result.stride < elementBytes) value.refuse(fmt::format("elements of {} bytes lie {} apart", elementBytes, result.stride));
    const auto offsetValue = value.find("byteOffset");
    const uint64_t offset = offsetValue ? offsetValue->whole(kMaxFileBytes) : 0;
    // offset + stride * (count - 1) + elementBytes <= data.size(), without overflow
    if (offset > data.size() || elementBytes > data.size() - offset || count - 1 > (data.size() - offset - elementBytes) / result.stride)
        countValue.refuse(fmt::format("is {}: {} bytes an element at {} of a view of {} bytes", count, result.stride, offset, data.size()));
    result.data = data.data() + offset;
    result.count = size_t(count);
    if (const auto sparse = value.find("sparse")) overlaySparse(value, *sparse, result);
    return result;
}

// glTF 3.6.2.3.
void GltfFile::overlaySparse(const Value& from, const Value& sparse, Accessor& accessor) {
    const size_t elementBytes = bytesOfComponent(accessor.componentType) * size_t(accessor.components);
    const Value countValue = sparse.required("count"), indices = sparse.required("indices"), values = sparse.required("values");
    const uint64_t count = countValue.whole(accessor.count);
    const auto slice = [&](const Value& part, size_t bytes) {
        const std::string_view data = bufferView(part.required("bufferView").index(bufferViews_.size(), "bufferViews"), nullptr);
        const auto offsetValue = part.find("byteOffset");
        const uint64_t offset = offsetValue ? offsetValue->whole(kMaxFileBytes) : 0;
        if (offset > data.size() || count > (data.size() - offset) / bytes)
            countValue.refuse(fmt::format("is {}, more than {} bytes hold", count, data.size()));
        return data.data() + offset;
    };
    const Value typeValue = indices.required("componentType");
    const uint64_t type = typeValue.whole(65535);
    if (type != 5121 && type != 5123 && type != 5125) typeValue.refuse(fmt::format("is {}, no type of index", type));
    Accessor where;
    where.componentType = int(type);
    where.stride = bytesOfComponent(where.componentType);
    where.data = slice(indices, where.stride);
    const char* what = slice(values, elementBytes);

    corners_ += accessor.count;
    auto dense = std::make_shared<std::vector<char>>(accessor.count * elementBytes);
    for (size_t i = 0; i < accessor.count; ++i)
        std::memcpy(dense->data() + i * elementBytes, accessor.data + i * accessor.stride, elementBytes);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t element = where.index(i);
        if (element >= accessor.count) indices.refuse(fmt::format("element {} is {}, but the accessor has {}", i, element, accessor.count));
        std::memcpy(dense->data() + element * elementBytes, what + i * elementBytes, elementBytes);
    }
    (void)from;
    accessor.dense = dense;
    accessor.data = dense->data();
    accessor.stride = elementBytes;
}

// Metallic-roughness to Phong (docs/scene-format.md): the base colour is the diffuse colour whatever the metalness,
// because nothing is reflected here; n = 2 / a^2 - 2 with a = roughness^2; Ks is the height of that lobe,
// F0 (n + 2) / 8 = F0 / (4 a^2), at most 1.
void GltfFile::readMaterials() {
    scene_.materials.push_back(Material{});
    size_t i = 0;
    for (const Value& value : root().list("materials")) {
        Material material;
        material.name = fmt::format("material {}", i++);
        if (const auto name = value.find("name")) material.name = name->text();
        std::array<double, 4> base{1, 1, 1, 1};
        double metallic = 1, roughness = 1;
        if (const auto pbr = value.find("pbrMetallicRoughness")) {
            if (const auto factor = pbr->find("baseColorFactor")) base = factor->numbers<4>(0, 1);
            if (const auto factor = pbr->find("metallicFactor")) metallic = factor->number(0, 1);
            if (const auto factor = pbr->find("roughnessFactor")) roughness = factor->number(0, 1);
            for (const char* texture : {"baseColorTexture", "metallicRoughnessTexture"})
                if (const auto used = pbr->find(texture)) ignore(*used, "textures");
        }
        for (const char* texture : {"normalTexture", "occlusionTexture", "emissiveTexture"})
            if (const auto used = value.find(texture)) ignore(*used, "textures");
        std::array<double, 3> emissive{0, 0, 0};
        if (const auto factor = value.find("emissiveFactor")) emissive = factor->numbers<3>(0, 1);
        double emissiveStrength = 1;
        bool unlit = false;
        if (const auto extensions = value.find("extensions")) {
            unlit = extensions->find("KHR_materials_unlit").has_value();
            if (const auto ior = extensions->find("KHR_materials_ior")) {
                material.refractiveIndex = 1.5f;
                // 0 stands for infinity in the extension; no ray of ours is refracted by it.
                if (const auto index = ior->find("ior")) material.refractiveIndex = float(std::max(1.0, index->number(0, 100)));
            }
            if (const auto strength = extensions->find("KHR_materials_emissive_strength"))
                if (const auto factor = strength->find("emissiveStrength")) emissiveStrength = factor->number(0, kMaxCoordinate);
        }
        ignoreExtensions(value, {"KHR_materials_unlit", "KHR_materials_ior", "KHR_materials_emissive_strength"});
        if (const auto mode = value.find("alphaMode"))
            if (mode->text() != "OPAQUE") {
                ignore(*mode, "alphaMode " + printable(mode->text(), 16));
                if (mode->text() == "BLEND") material.opacity = float(base[3]);
            }
        if (const auto both = value.find("doubleSided"))
            if (both->boolean()) scene_.cullBackFaces = false;

        const double a = roughness * roughness;
        material.shininess = float(std::min(a > 0 ? 2 / (a * a) - 2 : kMaxShininess, kMaxShininess));
        for (int channel = 0; channel < 3; ++channel) {
            const double colour = base[size_t(channel)];
            const double normalReflectance = 0.04 * (1 - metallic) + colour * metallic;  // F0; 0.04 is glTF B.2's
            const double peak = normalReflectance == 0 ? 0 : std::min(1.0, normalReflectance / (4 * a * a));
            material.diffuse[channel] = float(unlit ? 0 : colour);
            material.ambient[channel] = float(unlit ? 0 : 0.1 * colour);
            material.specular[channel] = float(unlit ? 0 : peak);
            material.emission[channel] = float(std::min(1.0, (unlit ? colour : 0) + emissive[size_t(channel)] * emissiveStrength));
        }
        scene_.materials.push_back(material);
    }
}

void GltfFile::readPrimitive(const Value& primitive, PolygonMesh& mesh, Welder<Positions>& positions,
                             Welder<std::vector<glm::vec3>>& normals) {
    ignoreExtensions(primitive, {});
    const auto modeValue = primitive.find("mode");
    const uint64_t mode = modeValue ? modeValue->whole(6) : 4;
    if (mode < 4) {
        ignore(primitive, mode == 0 ? "points" : "lines");
        return;
    }
    const Value attributes = primitive.required("attributes");
    if (const auto targets = primitive.find("targets")) ignore(*targets, "morph targets");
    if (const auto colours = attributes.find("COLOR_0")) ignore(*colours, "vertex colours");

    // Quantized positions and normals (KHR_mesh_quantization) are accepted whether or not the file says so.
    const auto vectors = [&](const Value& index, const char* name) {
        Accessor vector = accessor(index);
        if (vector.components != 3 || vector.componentType == 5125)
            index.refuse(fmt::format("{} is not an accessor of VEC3 of a vertex type", name));
        return vector;
    };
    const auto positionValue = attributes.find("POSITION");
    if (!positionValue) {
        ignore(attributes, "primitives without POSITION");
        return;
    }
    const Accessor position = vectors(*positionValue, "POSITION");
    std::optional<Accessor> normal, indices;
    if (const auto value = attributes.find("NORMAL")) {
        normal = vectors(*value, "NORMAL");
        if (normal->count != position.count)
            value->refuse(fmt::format("NORMAL has {} elements, POSITION has {}", normal->count, position.count));
    }
    const auto indicesValue = primitive.find("indices");
    if (indicesValue) {
        indices = accessor(*indicesValue);
        const int type = indices->componentType;
        if (indices->components != 1 || (type != 5121 && type != 5123 && type != 5125))
            indicesValue->refuse("is not an accessor of SCALAR of an index type");
    }
    const size_t count = indices ? indices->count : position.count;
    if (mode == 4 && count % 3 != 0) primitive.refuse(fmt::format("{} vertices make no whole triangles", count));
    if (mode != 4 && count < 3) primitive.refuse(fmt::format("{} vertices make no triangle", count));
    const size_t triangles = mode == 4 ? count / 3 : count - 2;
    corners_ += 3 * triangles;
    if (corners_ > kMaxCornersPerByte * bytesRead_)
        primitive.refuse(
            fmt::format("the meshes ask for {} corners of {} bytes, more than {} a byte", corners_, bytesRead_, kMaxCornersPerByte));
    if (mesh.corners.size() + 3 * triangles >= kNone) primitive.refuse("the mesh has 2^32 corners or more");

    const auto load = [&](const Accessor& from, size_t element, const char* name) {
        dvec3 v;
        for (int i = 0; i < 3; ++i) {
            const double value = from.component(element, i);
            if (!(std::abs(value) <= kMaxCoordinate))
                throw inputError(from.pointer, fmt::format("element {}: {} {} is {}", element, name, "xyz"[i],
                                                           std::isnan(value)   ? "NaN"
                                                           : std::isinf(value) ? "infinite"
                                                                               : "above 2^100"));
            v[i] = value;
        }
        return v;
    };
    // Remembered only where the memory is in proportion to what is drawn.
    std::vector<PolygonMesh::Corner> known(position.count <= 4 * count ? position.count : 0, PolygonMesh::Corner{kNone});
    const auto corner = [&](size_t i) {
        const uint32_t vertex = indices ? indices->index(i) : uint32_t(i);
        if (vertex >= position.count)
            throw inputError(indices->pointer, fmt::format("element {} is vertex {}, but POSITION has {}", i, vertex, position.count));
        if (!known.empty() && known[vertex].position != kNone) return known[vertex];
        PolygonMesh::Corner made{positions.add(load(position, vertex, "POSITION"))};
        if (normal) made.normal = normals.add(load(*normal, vertex, "NORMAL"));
        if (!known.empty()) known[vertex] = made;
        return made;
    };
    const auto materialValue = primitive.find("material");
    const uint32_t material = materialValue ? uint32_t(materialValue->index(scene_.materials.size() - 1, "materials")) + 1 : 0;
    LoadMeter meter(options_, "parse", kParseEnds, kParseEnds, triangles);
    for (size_t t = 0; t < triangles; ++t) {
        meter.at(t);
        // glTF 3.7.2.1: odd triangles of a strip swap their last two vertices; a fan starts each with v1, v2.
        const std::array<size_t, 3> at = mode == 4   ? std::array<size_t, 3>{3 * t, 3 * t + 1, 3 * t + 2}
                                         : mode == 5 ? std::array<size_t, 3>{t, t + 1 + t % 2, t + 2 - t % 2}
                                                     : std::array<size_t, 3>{t + 1, t + 2, 0};
        for (size_t i : at) mesh.corners.push_back(corner(i));
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(material);
        mesh.faceSmoothing.push_back(normal ? kNone : 0);  // glTF 3.7.2.1: without normals, flat
    }
}

uint32_t GltfFile::mesh(const Value& index) {
    const size_t i = index.index(meshes_.size(), "meshes");
    if (meshInScene_[i]) return *meshInScene_[i];
    // Each mesh has its part of what follows the JSON.
    LoadOptions own = options_;
    const double share = (options_.to - options_.from) / double(meshes_.size());
    own.from = options_.from + share * double(meshesRead_++);
    own.to = own.from + share;
    PolygonMesh mesh;
    mesh.name = fmt::format("mesh {}", i);
    if (const auto name = meshes_[i].find("name")) mesh.name = name->text();
    mesh.faceFirst.push_back(0);
    Welder<Positions> positions(mesh.positions);
    Welder<std::vector<glm::vec3>> normals(mesh.normals);
    meshes_[i].required("primitives");
    for (const Value& primitive : meshes_[i].list("primitives")) readPrimitive(primitive, mesh, positions, normals);
    meshInScene_[i] = mesh.faceMaterial.empty() ? kNone : addMesh(scene_, std::move(mesh), meshes_[i].place(), own);
    return *meshInScene_[i];
}

dmat4 GltfFile::parentFromNode(const Value& node) const {
    if (const auto matrix = node.find("matrix")) {
        for (const char* key : {"translation", "rotation", "scale"})
            if (const auto other = node.find(key)) other->refuse("beside a matrix");
        const auto entries = matrix->numbers<16>(-kMaxCoordinate, kMaxCoordinate);
        dmat4 m;
        for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = entries[size_t(i)];
        if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) matrix->refuse("the last row is not 0, 0, 0, 1");
        return m;
    }
    std::array<double, 3> t{0, 0, 0}, s{1, 1, 1};
    std::array<double, 4> q{0, 0, 0, 1};
    if (const auto value = node.find("translation")) t = value->numbers<3>(-kMaxCoordinate, kMaxCoordinate);
    if (const auto value = node.find("scale")) s = value->numbers<3>(-kMaxCoordinate, kMaxCoordinate);
    if (const auto value = node.find("rotation")) {
        q = value->numbers<4>(-2, 2);
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        // Writers round quaternions to float or to a few decimals; anything further is not a rotation.
        if (!(std::abs(length - 1) < 0.1)) value->refuse(fmt::format("is a quaternion of length {:g}, not 1", length));
        for (double& component : q) component /= length;
    }
    const auto [x, y, z, w] = q;
    dmat4 m(1.0);
    m[0] = dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0) * s[0];
    m[1] = dvec4(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0) * s[1];
    m[2] = dvec4(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0) * s[2];
    m[3] = dvec4(t[0], t[1], t[2], 1);
    return m;
}

void GltfFile::readCamera(const Value& index, const dmat4& worldFromNode) {
    const Value& value = cameras_[index.index(cameras_.size(), "cameras")];
    const Value typeValue = value.required("type");
    if (typeValue.text() == "orthographic") return ignore(value, "orthographic cameras");
    if (typeValue.text() != "perspective") typeValue.refuse(fmt::format("'{}' is no type of camera", printable(typeValue.text(), 40)));
    if (scene_.camera) return ignore(index, "cameras after the first");
    const Value perspective = value.required("perspective");
    Camera camera;
    camera.fovYDegrees = perspective.required("yfov").number(0, 3.14159265358979323846) * (180 / 3.14159265358979323846);
    if (camera.fovYDegrees < 1e-3 || camera.fovYDegrees > 179)
        perspective.refuse(fmt::format("yfov is {:g} degrees, outside 0.001 to 179", camera.fovYDegrees));
    camera.near = perspective.required("znear").number(0, kMaxCoordinate);
    if (camera.near == 0) perspective.refuse("znear is 0");
    // A camera looks along its -Z with +Y up (glTF 3.10.2); scales of its node do not distort it.
    const dvec3 back(worldFromNode[2]), up(worldFromNode[1]);
    camera.eye = dvec3(worldFromNode[3]);
    if (largestMagnitude(back) == 0 || largestMagnitude(up) == 0) index.refuse("the node of the camera has a scale of 0");
    camera.forward = -unitVector(back);
    const dvec3 right = glm::cross(camera.forward, unitVector(up));
    if (largestMagnitude(right) < kMinCross) index.refuse("the node of the camera has no inverse");
    camera.right = unitVector(right);
    camera.up = glm::cross(camera.right, camera.forward);
    scene_.camera = camera;
}

void GltfFile::readLight(const Value& index, const dmat4& worldFromNode) {
    const Value& value = lights_[index.index(lights_.size(), "lights")];
    const Value typeValue = value.required("type");
    const std::string& type = typeValue.text();
    Light light;
    light.place = value.place();
    if (type == "directional") {
        light.direction = dvec3(worldFromNode[2]);  // it shines along -Z, so +Z is toward it
        if (largestMagnitude(light.direction) == 0) index.refuse("the node of the light has a scale of 0");
    } else if (type == "point" || type == "spot") {
        light.directional = false;
        light.position = dvec3(worldFromNode[3]);
        light.attenuation = Attenuation::inverseSquare;
        if (type == "spot") ignore(value, "cones of spot lights");
        if (const auto range = value.find("range")) ignore(*range, "ranges of lights");
    } else {
        typeValue.refuse(fmt::format("'{}' is no type of light", printable(type, 40)));
    }
    std::array<double, 3> colour{1, 1, 1};
    if (const auto factor = value.find("color")) colour = factor->numbers<3>(0, kMaxCoordinate);
    double intensity = 1;
    if (const auto factor = value.find("intensity")) intensity = factor->number(0, kMaxCoordinate);
    for (int channel = 0; channel < 3; ++channel) {
        const double product = colour[size_t(channel)] * intensity * kIntensityPerLux;
        if (product > kMaxCoordinate) value.refuse("color times intensity is above 2^100");
        light.intensity[channel] = float(product);
    }
    scene_.lights.push_back(light);
}

void GltfFile::readNode(size_t i, const dmat4& worldFromParent, int depth) {
    const Value& node = nodes_[i];
    if (depth > kMaxDepth) node.refuse(fmt::format("nodes are nested deeper than {}", kMaxDepth));
    if (visited_[i]) node.refuse("is reached twice: a cycle, or a node with two parents");
    visited_[i] = true;
    const dmat4 worldFromNode = worldFromParent * parentFromNode(node);
    if (!entriesUsable(worldFromNode)) node.refuse("the world matrix has entries above 2^100");
    if (const auto skin = node.find("skin")) ignore(*skin, "skins");
    if (const auto index = node.find("mesh")) {
        const uint32_t inScene = mesh(*index);
        if (inScene != kNone && !hasInverse(worldFromNode) && leavesNoArea(scene_.meshes[inScene], worldFromNode)) {
            ignore(node, "meshes flattened by a scale of 0");
        } else if (inScene != kNone) {
            Object object;
            object.name = scene_.meshes[inScene].name;
            if (const auto name = node.find("name")) object.name = name->text();
            object.mesh = inScene;
            object.place = node.place();
            object.worldFromObject = worldFromNode;
            scene_.objects.push_back(std::move(object));
        }
    }
    if (const auto index = node.find("camera")) readCamera(*index, worldFromNode);
    ignoreExtensions(node, {"KHR_lights_punctual"});
    if (const auto extensions = node.find("extensions"))
        if (const auto punctual = extensions->find("KHR_lights_punctual")) readLight(punctual->required("light"), worldFromNode);
    for (const Value& child : node.list("children")) readNode(child.index(nodes_.size(), "nodes"), worldFromNode, depth + 1);
}

void GltfFile::readNodes() {
    const std::vector<Value> scenes = root().list("scenes");
    const auto sceneValue = root().find("scene");
    const size_t chosen = sceneValue ? sceneValue->index(scenes.size(), "scenes") : 0;
    if (!scenes.empty()) {
        if (scenes.size() > 1) ignore(scenes[chosen == 0 ? 1 : 0], "scenes but the default one");
        for (const Value& node : scenes[chosen].list("nodes")) readNode(node.index(nodes_.size(), "nodes"), dmat4(1.0), 1);
        return;
    }
    // Without scenes, what no node has as a child is a root.
    std::vector<bool> isChild(nodes_.size());
    for (const Value& node : nodes_)
        for (const Value& child : node.list("children")) isChild[child.index(nodes_.size(), "nodes")] = true;
    for (size_t i = 0; i < nodes_.size(); ++i)
        if (!isChild[i]) readNode(i, dmat4(1.0), 1);
}

Scene GltfFile::read() {
    bytes_ = readInput(path_, options_);
    bytesRead_ = bytes_.size();
    isGlb_ = bytes_.starts_with("glTF");
    parse(isGlb_ ? unpackGlb() : std::string_view(bytes_));
    scene_.path = path_.string();
    scene_.sha256 = sha256Hex(std::as_bytes(std::span(bytes_)));

    const Value file = root();
    const Value version = file.required("asset").required("version");
    if (!version.text().starts_with("2.")) version.refuse(fmt::format("glTF {}; only 2.0 is read", printable(version.text(), 20)));
    for (const Value& name : file.list("extensionsRequired")) {
        static constexpr std::string_view kRead[] = {"KHR_lights_punctual",   "KHR_materials_unlit",
                                                     "KHR_materials_ior",     "KHR_materials_emissive_strength",
                                                     "KHR_mesh_quantization", "KHR_texture_transform"};
        if (std::find(std::begin(kRead), std::end(kRead), name.text()) == std::end(kRead))
            name.refuse(fmt::format("the file requires the extension '{}', which is not read", printable(name.text(), 64)));
    }
    buffers_ = file.list("buffers");
    bufferViews_ = file.list("bufferViews");
    accessors_ = file.list("accessors");
    nodes_ = file.list("nodes");
    meshes_ = file.list("meshes");
    cameras_ = file.list("cameras");
    bufferData_.resize(buffers_.size());
    meshInScene_.resize(meshes_.size());
    visited_.resize(nodes_.size());
    ignoreExtensions(file, {"KHR_lights_punctual"});
    if (const auto extensions = file.find("extensions"))
        if (const auto punctual = extensions->find("KHR_lights_punctual")) lights_ = punctual->list("lights");
    if (const auto animations = file.find("animations"))
        if (animations->size() > 0) ignore(*animations, "animations");
    readMaterials();
    readNodes();
    if (scene_.objects.empty()) {
        std::string ignored;
        for (const std::string& what : scene_.ignored) ignored += (ignored.empty() ? " (not drawn: " : ", ") + what;
        file.refuse("nothing to draw: no node of the scene has a mesh of triangles" + ignored + (ignored.empty() ? "" : ")"));
    }
    warnOfRepairs(scene_, 0, printablePath(path_));

    if (scene_.camera) {  // the distance to the middle of what is drawn, measured along the view
        dvec3 least(kMaxCoordinate), most(-kMaxCoordinate);
        for (const Object& object : scene_.objects) {
            const TriangleMesh& mesh = scene_.meshes[object.mesh];
            for (int corner = 0; corner < 8; ++corner) {
                const dvec4 at(corner & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, corner & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                               corner & 4 ? mesh.boundsMax.z : mesh.boundsMin.z, 1);
                const dvec3 world(worldFromMesh(scene_, object) * at);
                least = glm::min(least, world);
                most = glm::max(most, world);
            }
        }
        const double distance = glm::length((least + most) * 0.5 - scene_.camera->eye);
        if (distance > 0 && std::isfinite(distance)) scene_.camera->focusDistance = distance;
    }
    return std::move(scene_);
}

}  // namespace

Scene readGltf(const std::filesystem::path& path, const LoadOptions& options) { return GltfFile(path, options).read(); }

}  // namespace plumb
