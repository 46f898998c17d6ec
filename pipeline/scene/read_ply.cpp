// SPDX-License-Identifier: MIT
// PLY (Turk, "The PLY Polygon File Format", 1994): ascii, binary of both orders, any properties in any order.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
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
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr size_t kMaxElements = 64, kMaxProperties = 256;  // a file with more is not a mesh
constexpr char kNoComment = '\0';                          // after the header PLY has no comments

enum class Type : uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct TypeName {
    std::string_view name;
    Type type;
};
constexpr TypeName kTypes[] = {{"char", Type::int8},   {"uchar", Type::uint8},   {"short", Type::int16},     {"ushort", Type::uint16},
                               {"int", Type::int32},   {"uint", Type::uint32},   {"float", Type::float32},   {"double", Type::float64},
                               {"int8", Type::int8},   {"uint8", Type::uint8},   {"int16", Type::int16},     {"uint16", Type::uint16},
                               {"int32", Type::int32}, {"uint32", Type::uint32}, {"float32", Type::float32}, {"float64", Type::float64}};
constexpr size_t kTypeBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
constexpr double kLeast[] = {-128, 0, -32768, 0, -2147483648.0, 0};
constexpr double kMost[] = {127, 255, 32767, 65535, 2147483647.0, 4294967295.0};

bool isReal(Type type) { return type == Type::float32 || type == Type::float64; }

// Role of a property for us.
enum Role { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kRed, kGreen, kBlue, kScalarRoles, kIndices = kScalarRoles, kSkipped };
constexpr std::string_view kRoleNames[] = {"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"};

struct Property {
    std::string name;
    Type type = Type::float32;  // type of the scalar, or of the list's items
    Type countType = Type::uint8;
    bool list = false;
    Role role = kSkipped;
};

struct Element {
    std::string name;
    uint64_t count = 0;
    const char* countAt = nullptr;  // position in the header, for a refusal
    std::vector<Property> properties;
};

class PlyReader {
public:
    PlyReader(const std::filesystem::path& path, const LoadOptions& options)
        : path_(path), options_(options), text_(readInput(path, options)), in_(text_, path) {}

    PolygonMesh read() {
        mesh_.name = path_.stem().string();
        mesh_.faceFirst.push_back(0);
        header();
        for (const Element& element : elements_) readElement(element);
        const size_t rest = text_.size() - at_;
        if (!ascii_ && rest > 0)
            mesh_.warnings.push_back(fmt::format("{}: {} bytes after the last element are ignored", placeOfByte(path_, at_), rest));
        if (ascii_ && !in_.wordAnywhere(kNoComment).empty()) in_.refuse("more data than the header says");
        checkIndices();
        return std::move(mesh_);
    }

private:
    void header() {
        if (in_.word() != "ply") in_.refuse("the file does not begin with 'ply'");
        const size_t firstLineEnd = in_.offset();
        if (!in_.lineEnds()) in_.refuse("the first line has more than 'ply'");
        in_.skipLine();
        bool formatKnown = false;
        while (true) {
            const std::string_view key = in_.word();
            if (in_.atEnd() && key.empty()) in_.refuse("the file ends inside the header");
            if (key == "end_header") break;
            if (key == "format") {
                const std::string_view format = in_.word();
                ascii_ = format == "ascii";
                swap_ = format == (std::endian::native == std::endian::little ? "binary_big_endian" : "binary_little_endian");
                if (!ascii_ && format != "binary_little_endian" && format != "binary_big_endian")
                    in_.refuse(fmt::format("format '{}' is not ascii, binary_little_endian or binary_big_endian", printable(format, 40)));
                if (in_.word() != "1.0") in_.refuse("format version is not 1.0");
                formatKnown = true;
            } else if (key == "element") {
                element();
            } else if (key == "property") {
                property();
            } else if (key == "comment") {
                if (in_.word() == "TextureFile") ignore("texture (comment TextureFile)");
            } else if (key != "obj_info" && !key.empty()) {
                in_.refuse(fmt::format("'{}' is not a header keyword of PLY", printable(key, 40)));
            }
            in_.skipLine();
        }
        if (!formatKnown) in_.refuse("the header has no format");
        if (!in_.lineEnds()) in_.refuse("the line of end_header has more words");
        for (const Element& element : elements_) nameSkipped(element);
        const auto need = [&](const char* name, bool there) {
            if (!there) in_.refuse(fmt::format("the header has no {}", name));
        };
        need("element vertex with x, y and z", roleSeen_[kX] && roleSeen_[kY] && roleSeen_[kZ]);
        need("element face with a list vertex_indices", roleSeen_[kIndices]);
        normals_ = roleSeen_[kNormalX] && roleSeen_[kNormalY] && roleSeen_[kNormalZ];
        colours_ = roleSeen_[kRed] && roleSeen_[kGreen] && roleSeen_[kBlue];
        if (colours_) ignore("vertex colours");
        // A single carriage return ends lines only when it ends the first one; otherwise the byte after it is data.
        const bool carriageReturns = text_[firstLineEnd] == '\r' && text_.compare(firstLineEnd, 2, "\r\n") != 0;
        if (in_.atEnd()) in_.refuse("the file ends after the header");
        at_ = in_.offset();
        if (text_[at_] == '\r')
            at_ += !carriageReturns && at_ + 1 < text_.size() && text_[at_ + 1] == '\n' ? 2 : 1;
        else
            ++at_;
        if (ascii_) in_.skipLine();
    }

    void element() {
        const std::string_view name = in_.word();
        if (name.empty()) in_.refuse("element has no name");
        if (elements_.size() == kMaxElements) in_.refuse(fmt::format("more than {} elements", kMaxElements));
        for (const Element& other : elements_)
            if (other.name == name) in_.refuse(fmt::format("element '{}' is stated twice", printable(name, 40)));
        Element element{std::string(name)};
        const std::string_view word = in_.word();
        const int64_t count = in_.integer(word, "element count");
        if (count < 0) in_.refuse("element count is negative");
        element.count = uint64_t(count);
        element.countAt = word.data();
        elements_.push_back(element);
    }

    Type type(std::string_view word) {
        for (const TypeName& known : kTypes)
            if (known.name == word) return known.type;
        in_.refuse(fmt::format("property type '{}' is not a type of PLY", printable(word, 40)));
    }

    void property() {
        if (elements_.empty()) in_.refuse("property comes before the first element");
        Element& element = elements_.back();
        if (element.properties.size() == kMaxProperties) in_.refuse(fmt::format("more than {} properties", kMaxProperties));
        Property property;
        std::string_view word = in_.word();
        property.list = word == "list";
        if (property.list) {
            property.countType = type(in_.word());
            if (isReal(property.countType)) in_.refuse("list count type is not an integer type");
            word = in_.word();
        }
        property.type = type(word);
        property.name = in_.word();
        if (property.name.empty()) in_.refuse("property has no name");
        for (const Property& other : element.properties)
            if (other.name == property.name) in_.refuse(fmt::format("property '{}' is stated twice", printable(property.name, 40)));
        const bool indices = element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
        if (indices && (!property.list || isReal(property.type)))
            in_.refuse(fmt::format("property {} is not a list of integers", property.name));
        if (indices && roleSeen_[kIndices]) in_.refuse("a second list of vertex indices");
        if (indices) {
            property.role = kIndices;
            roleSeen_[kIndices] = true;
        }
        if (element.name == "vertex" && !property.list)
            for (int role = 0; role < kScalarRoles; ++role)
                if (property.name == kRoleNames[role] || (role >= kRed && property.name == fmt::format("diffuse_{}", kRoleNames[role]))) {
                    property.role = Role(role);
                    roleSeen_[role] = true;
                }
        element.properties.push_back(property);
    }

    // Names the parts of the file that no pass draws.
    void nameSkipped(const Element& element) {
        if (element.name != "vertex" && element.name != "face") return ignore(fmt::format("PLY element {}", printable(element.name, 40)));
        for (const Property& property : element.properties)
            if (property.role == kSkipped) ignore(fmt::format("PLY property {} of {}", printable(property.name, 40), element.name));
    }

    void ignore(const std::string& what) {
        if (std::find(mesh_.ignored.begin(), mesh_.ignored.end(), what) != mesh_.ignored.end()) return;
        if (options_.strict) in_.refuse(what + " would be ignored (--strict)");
        mesh_.ignored.push_back(what);
    }

    void readElement(const Element& element) {
        if (element.properties.empty()) return;  // such an element takes no bytes, however many the header says
        size_t least = 0;
        for (const Property& property : element.properties)
            least += ascii_ ? 2 : kTypeBytes[size_t(property.list ? property.countType : property.type)];
        const uint64_t rest = ascii_ ? text_.size() - in_.offset() + 1 : text_.size() - at_;
        if (element.count > rest / least)
            throw inputError(in_.placeAt(element.countAt),
                             fmt::format("element {} has a count of {}; the rest of the file holds at most {}", printable(element.name, 40),
                                         element.count, rest / least));
        const bool vertex = element.name == "vertex", face = element.name == "face";
        if (vertex) {
            mesh_.positions.reserve(element.count);
            if (normals_) mesh_.normals.reserve(element.count);
            if (colours_) mesh_.colours.reserve(element.count);
        }
        if (face) mesh_.faceFirst.reserve(element.count + 1);
        LoadMeter meter(options_, "parse",
                        kReadEnds + (kParseEnds - kReadEnds) * double(ascii_ ? in_.offset() : at_) / double(text_.size()), kParseEnds,
                        rest);
        double scalar[kScalarRoles] = {};
        for (uint64_t item = 0; item < element.count; ++item) {
            meter.at(rest - (ascii_ ? text_.size() - in_.offset() : text_.size() - at_));
            for (const Property& property : element.properties) {
                if (property.list) {
                    list(element, property, item);
                } else if (property.role < kScalarRoles) {
                    scalar[property.role] = real(element, property, item);
                } else {
                    value(element, property, property.type, item);
                }
            }
            if (vertex) {
                mesh_.positions.push_back({scalar[kX], scalar[kY], scalar[kZ]});
                if (normals_) mesh_.normals.emplace_back(scalar[kNormalX], scalar[kNormalY], scalar[kNormalZ]);
                if (colours_) mesh_.colours.emplace_back(scalar[kRed], scalar[kGreen], scalar[kBlue]);
            } else if (face) {
                mesh_.faceFirst.push_back(uint32_t(mesh_.corners.size()));
                mesh_.faceMaterial.push_back(kNone);
            }
        }
    }

    std::string fieldOf(const Element& element, const Property& property, uint64_t item) const {
        return fmt::format("{} {} property {}", printable(element.name, 40), item, printable(property.name, 40));
    }
    std::string placeOfValue() const { return ascii_ ? in_.place() : placeOfByte(path_, valueAt_); }

    double value(const Element& element, const Property& property, Type type, uint64_t item) {
        if (!ascii_) return binary(element, property, type, item);
        const std::string_view word = in_.wordAnywhere(kNoComment);
        if (isReal(type)) {
            double parsed;
            if (!word.empty() && parseDouble(word, parsed)) return parsed;
            return in_.number(word, fieldOf(element, property, item));  // refuses
        }
        int64_t whole = 0;
        if (!parseInteger(word, whole)) in_.integer(word, fieldOf(element, property, item));
        if (double(whole) < kLeast[size_t(type)] || double(whole) > kMost[size_t(type)])
            in_.refuse(fmt::format("{} is {}, which its type cannot hold", fieldOf(element, property, item), whole));
        return double(whole);
    }

    double binary(const Element& element, const Property& property, Type type, uint64_t item) {
        const size_t size = kTypeBytes[size_t(type)];
        valueAt_ = at_;
        if (text_.size() - at_ < size)
            throw inputError(placeOfByte(path_, text_.size()), fmt::format("the file ends inside {}", fieldOf(element, property, item)));
        std::array<char, 8> raw{};
        std::memcpy(raw.data(), text_.data() + at_, size);
        if (swap_) std::reverse(raw.begin(), raw.begin() + std::ptrdiff_t(size));
        at_ += size;
        const auto as = [&]<class T>(T result) {
            std::memcpy(&result, raw.data(), sizeof(T));
            return double(result);
        };
        switch (type) {
            case Type::int8:
                return as(int8_t{});
            case Type::uint8:
                return as(uint8_t{});
            case Type::int16:
                return as(int16_t{});
            case Type::uint16:
                return as(uint16_t{});
            case Type::int32:
                return as(int32_t{});
            case Type::uint32:
                return as(uint32_t{});
            case Type::float32:
                return as(float{});
            case Type::float64:
                return as(double{});
        }
        PLUMB_ASSERT(false);
    }

    // Number in binary64, whatever type the header states, because exporters write more digits of a `float` than it holds. Only positions
    // are kept so; the rest is float32.
    double real(const Element& element, const Property& property, uint64_t item) {
        const double read = value(element, property, property.type, item);
        if (!(std::abs(read) <= double(kMaxCoordinate))) finiteFloat(read, placeOfValue(), fieldOf(element, property, item));
        if (property.role <= kZ) return read;
        if (property.role >= kRed && !isReal(property.type)) return float(read / kMost[size_t(property.type)]);
        const float rounded = float(read);
        return rounded == 0 && read != 0 ? std::copysign(std::numeric_limits<float>::denorm_min(), rounded) : rounded;
    }

    void list(const Element& element, const Property& property, uint64_t item) {
        const double count = value(element, property, property.countType, item);
        const bool indices = property.role == kIndices;
        if (count < (indices ? 3 : 0))
            throw inputError(placeOfValue(), fmt::format("{} has {} entries{}", fieldOf(element, property, item), count,
                                                         indices ? "; a face has at least 3 corners" : ""));
        const size_t most = (text_.size() - at_) / kTypeBytes[size_t(property.type)];  // binary: at most the remaining bytes
        if (!ascii_ && count > double(most))
            throw inputError(placeOfValue(),
                             fmt::format("{} has {} entries; the file ends before", fieldOf(element, property, item), count));
        for (double i = 0; i < count; ++i) {
            const double entry = value(element, property, property.type, item);
            if (!indices) continue;
            if (entry < 0) throw inputError(placeOfValue(), fmt::format("{} is negative: {}", fieldOf(element, property, item), entry));
            if (verticesRead() && entry >= double(mesh_.positions.size()))
                throw inputError(placeOfValue(), fmt::format("{} is {}; there are {} vertices", fieldOf(element, property, item), entry,
                                                             mesh_.positions.size()));
            const uint32_t index = uint32_t(entry);
            mesh_.corners.push_back({index, normals_ ? index : kNone});
        }
    }

    bool verticesRead() const { return !mesh_.positions.empty(); }

    // Checks indices at the end, because faces may come before the vertices. There must be some faces.
    void checkIndices() const {
        if (mesh_.faceMaterial.empty())
            throw inputError(in_.placeAt(faceElement().countAt), "element face has a count of 0: the file has no face");
        for (size_t c = 0; c < mesh_.corners.size(); ++c)
            if (mesh_.corners[c].position >= mesh_.positions.size())
                throw inputError(in_.placeAt(faceElement().countAt), fmt::format("vertex index {} of corner {}: there are {} vertices",
                                                                                 mesh_.corners[c].position, c, mesh_.positions.size()));
    }
    const Element& faceElement() const {
        return *std::find_if(elements_.begin(), elements_.end(), [](const Element& e) { return e.name == "face"; });
    }

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    const std::string text_;
    Scanner in_;
    size_t at_ = 0, valueAt_ = 0;  // binary: the next byte, and the first byte of the last value
    bool ascii_ = false, swap_ = false, normals_ = false, colours_ = false;
    std::array<bool, kIndices + 1> roleSeen_{};
    std::vector<Element> elements_;
    PolygonMesh mesh_;
};

}  // namespace

PolygonMesh readPly(const std::filesystem::path& path, const LoadOptions& options) { return PlyReader(path, options).read(); }

}  // namespace plumb
