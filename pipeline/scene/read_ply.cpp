// SPDX-License-Identifier: MIT
// PLY (Turk, "The PLY Polygon File Format", 1994): ascii, binary of both orders, any properties in any order, faces and strips of triangles.
// What is not drawn is passed over by the rule of tolerance.h.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/ply_header.h"
#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using namespace ply;

constexpr char kNoComment = '\0';  // after the header PLY has no comments

constexpr std::string_view kBadNormal = "a normal is not finite; it counts as not stated";
constexpr std::string_view kBadColour = "a vertex colour is not finite; it counts as not stated";
constexpr std::string_view kBadSkipped = "a value that is not drawn is none of its type; it is passed over";
constexpr std::string_view kMoreValues = "a row has more values than the header says; they are not used";
constexpr std::string_view kComment = "a comment stands behind the header; it is passed over";

class PlyReader {
public:
    PlyReader(const std::filesystem::path& path, const LoadOptions& options)
        : path_(path), options_(options), text_(readTextInput(path, options)), in_(text_, path), tolerance_(options) {}

    PolygonMesh read() {
        mesh_.name = path_.stem().string();
        mesh_.faceFirst.push_back(0);
        header_ = readHeader(in_, text_, tolerance_, [&](const std::string& what) { ignore(what); });
        at_ = header_.bodyOffset;
        normals_ = header_.has3(kNormalX);
        colours_ = header_.has3(kRed);
        for (const Element& element : header_.elements)
            if (!element.properties.empty()) itemsLeft_ += element.count;
        for (const Element& element : header_.elements) readElement(element);
        const size_t rest = text_.size() - at_;
        if (!header_.ascii && rest > 0)
            tolerance_.pass(fmt::format("{} bytes after the last element are ignored", rest), [&] { return locationOfByte(path_, at_); });
        if (header_.ascii && !bodyWord().empty()) pass("data after the last element is ignored");
        checkIndices();
        checkBadVertices();
        if (anyBadNormal_) dropBadNormals(mesh_);
        tolerance_.addTo(mesh_.warnings);
        return std::move(mesh_);
    }

private:
    void ignore(const std::string& what) {
        if (std::find(mesh_.ignored.begin(), mesh_.ignored.end(), what) != mesh_.ignored.end()) return;
        if (options_.strict) in_.refuse(what + " would be ignored (--strict)");
        mesh_.ignored.push_back(what);
    }

    void pass(std::string_view kind) {
        tolerance_.pass(kind, [&] { return locationOfValue(); });
    }

    void readElement(const Element& element) {
        if (element.properties.empty()) return;  // such an element takes no bytes, however many the header says
        const uint64_t rest = reserve(element);
        LoadMeter meter(options_, "parse", kReadEnds + (kParseEnds - kReadEnds) * double(offset()) / double(text_.size()), kParseEnds,
                        rest);
        const bool vertex = element.name == "vertex", face = element.name == "face";
        std::array<double, kScalarRoles> scalar{};
        for (uint64_t item = 0; item < element.count; ++item) {
            meter.at(rest - (text_.size() - offset()));
            for (const Property& property : element.properties) {
                if (property.list) {
                    list(element, property, item);
                } else if (property.role < kScalarRoles) {
                    scalar[property.role] = real(element, property, item);
                } else {
                    skipValue(element, property, property.type, item);
                }
            }
            if (vertex) addVertex(scalar);
            if (face) addFace();
            --itemsLeft_;
            if (header_.ascii) endRow();
        }
    }

    size_t offset() const { return header_.ascii ? in_.offset() : at_; }

    // Refuses a count that the rest of the file cannot hold, before anything is allocated; returns the bytes of the rest.
    uint64_t reserve(const Element& element) {
        size_t least = 0;
        for (const Property& property : element.properties)
            least += header_.ascii ? 2 : kTypeBytes[size_t(property.list ? property.countType : property.type)];
        const uint64_t rest = header_.ascii ? text_.size() - in_.offset() + 1 : text_.size() - at_;
        if (element.count > rest / least)
            throw inputError(in_.locationAt(element.countAt),
                             fmt::format("element {} has a count of {}; the rest of the file holds at most {}", printable(element.name, 40),
                                         element.count, rest / least));
        if (element.name == "vertex") {
            mesh_.positions.reserve(element.count);
            if (normals_) mesh_.normals.reserve(element.count);
            if (colours_) mesh_.colours.reserve(element.count);
        }
        if (element.name == "face") mesh_.faceFirst.reserve(element.count + 1);
        return rest;
    }

    void addVertex(const std::array<double, kScalarRoles>& scalar) {
        mesh_.positions.push_back({scalar[kX], scalar[kY], scalar[kZ]});
        if (normals_) mesh_.normals.emplace_back(scalar[kNormalX], scalar[kNormalY], scalar[kNormalZ]);
        if (normals_ && badNormal_) mesh_.normals.back() = glm::vec3(std::numeric_limits<float>::quiet_NaN());
        if (colours_) mesh_.colours.emplace_back(scalar[kRed], scalar[kGreen], scalar[kBlue]);
        if (colours_ && badColour_) mesh_.colours.back() = glm::vec3(1);
        badNormal_ = badColour_ = false;
    }

    void addFace() {
        if (mesh_.corners.size() == mesh_.faceFirst.back()) return;  // passed over
        mesh_.faceFirst.push_back(uint32_t(mesh_.corners.size()));
        mesh_.faceMaterial.push_back(kNone);
    }

    // Passes over what a row of the text has beyond the header's values, when each row has a line of its own.
    void endRow() {
        if (in_.lineEnds()) return;
        if (!rowsAreLines_) {
            Scanner ahead = in_;
            ahead.skipLine();
            uint64_t lines = 0;
            for (; lines < itemsLeft_ && !ahead.atEnd(); ahead.skipLine()) lines += !ahead.lineEnds();
            rowsAreLines_ = lines >= itemsLeft_;
        }
        if (!*rowsAreLines_) return;
        in_.word();
        pass(kMoreValues);
        in_.skipLine();
    }

    // Next word of the text behind the header.
    std::string_view bodyWord() {
        while (true) {
            const std::string_view word = in_.wordAnywhere(kNoComment);
            if (word != "comment" && word != "obj_info" && !word.starts_with('#')) return word;
            pass(kComment);
            in_.skipLine();
        }
    }

    std::string fieldOf(const Element& element, const Property& property, uint64_t item) const {
        return fmt::format("{} {} property {}", printable(element.name, 40), item, printable(property.name, 40));
    }
    std::string locationOfValue() const { return header_.ascii ? in_.location() : locationOfByte(path_, valueAt_); }

    double value(const Element& element, const Property& property, Type type, uint64_t item) {
        if (!header_.ascii) return binary(element, property, type, item);
        const std::string_view word = bodyWord();
        valueAt_ = size_t(word.data() - text_.data());
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

    // Takes a value that nothing uses; in text any word will do.
    void skipValue(const Element& element, const Property& property, Type type, uint64_t item) {
        if (!header_.ascii) {
            binary(element, property, type, item);
            return;
        }
        const std::string_view word = bodyWord();
        if (word.empty()) in_.refuse(fmt::format("{} is missing", fieldOf(element, property, item)));
        double real;
        int64_t whole = 0;
        const bool good = isReal(type)
                              ? parseDouble(word, real)
                              : parseInteger(word, whole) && double(whole) >= kLeast[size_t(type)] && double(whole) <= kMost[size_t(type)];
        if (!good) pass(kBadSkipped);
    }

    double binary(const Element& element, const Property& property, Type type, uint64_t item) {
        const size_t size = kTypeBytes[size_t(type)];
        valueAt_ = at_;
        if (text_.size() - at_ < size)
            throw inputError(locationOfByte(path_, text_.size()), fmt::format("the file ends inside {}", fieldOf(element, property, item)));
        std::array<char, 8> raw{};
        std::memcpy(raw.data(), text_.data() + at_, size);
        if (header_.swap) std::reverse(raw.begin(), raw.begin() + std::ptrdiff_t(size));
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
            case Type::int64:
                return as(int64_t{});
            case Type::uint64:
                return as(uint64_t{});
            case Type::float32:
                return as(float{});
            case Type::float64:
                return as(double{});
        }
        PLUMB_ASSERT(false);
    }

    // Number in binary64, whatever type the header states, because exporters write more digits of a `float` than it holds. Only positions
    // are kept so; the rest is float32. A number that is not finite or too large is 0 here and remembered.
    double real(const Element& element, const Property& property, uint64_t item) {
        const double read = value(element, property, property.type, item);
        if (!(std::abs(read) <= double(kMaxCoordinate))) {
            if (property.role <= kZ) {
                if (badVertices_.empty() || badVertices_.back().index != item) badVertices_.push_back({item, valueAt_, read, &property});
            } else if (property.role <= kNormalZ) {
                if (normals_) pass(kBadNormal);
                badNormal_ = anyBadNormal_ = true;
            } else {
                pass(kBadColour);
                badColour_ = true;
            }
            return 0;
        }
        if (property.role <= kZ) return read;
        if (property.role >= kRed && !isReal(property.type)) return float(read / kMost[size_t(property.type)]);
        const float rounded = float(read);
        return rounded == 0 && read != 0 ? std::copysign(std::numeric_limits<float>::denorm_min(), rounded) : rounded;
    }

    void list(const Element& element, const Property& property, uint64_t item) {
        const double count = value(element, property, property.countType, item);
        const bool indices = property.role == kIndices, strips = property.role == kStrips;
        if (count < 0) throw inputError(locationOfValue(), fmt::format("{} has {} entries", fieldOf(element, property, item), count));
        const bool drawn = strips || (indices && count >= 3);
        if (indices && !drawn) pass(kFewCorners);
        const size_t most = (text_.size() - at_) / kTypeBytes[size_t(property.type)];  // binary: at most the remaining bytes
        if (!header_.ascii && count > double(most))
            throw inputError(locationOfValue(),
                             fmt::format("{} has {} entries; the file ends before", fieldOf(element, property, item), count));
        stripLength_ = 0;
        for (double i = 0; i < count; ++i) {
            if (!drawn) {
                skipValue(element, property, property.type, item);
                continue;
            }
            const double entry = value(element, property, property.type, item);
            if (strips && entry < 0) {
                stripLength_ = 0;  // the next index starts a strip
                continue;
            }
            const uint32_t index = vertexIndex(element, property, item, entry);
            if (indices)
                addCorner(index);
            else
                addToStrip(index);
        }
    }

    uint32_t vertexIndex(const Element& element, const Property& property, uint64_t item, double entry) const {
        if (entry < 0) throw inputError(locationOfValue(), fmt::format("{} is negative: {}", fieldOf(element, property, item), entry));
        const bool known = !mesh_.positions.empty();
        if (known ? entry >= double(mesh_.positions.size()) : entry >= double(kNone))
            throw inputError(locationOfValue(), fmt::format("{} is {}; there are {} vertices", fieldOf(element, property, item), entry,
                                                            mesh_.positions.size()));
        return uint32_t(entry);
    }

    void addCorner(uint32_t index) { mesh_.corners.push_back({index, normals_ ? index : kNone}); }

    // Adds the triangle that ends with `index`. Odd triangles of a strip swap two corners; those that name a vertex twice only join parts.
    void addToStrip(uint32_t index) {
        const auto [a, b] = stripEnd_;
        stripEnd_ = {b, index};
        if (++stripLength_ < 3 || a == b || b == index || a == index) return;
        const bool odd = stripLength_ % 2 == 0;
        addCorner(odd ? b : a);
        addCorner(odd ? a : b);
        addCorner(index);
        addFace();
    }

    // Checks indices at the end, because faces may come before the vertices. There must be some faces.
    void checkIndices() const {
        if (mesh_.faceMaterial.empty()) {
            const Element& element = elementNamed(header_.has[kIndices] ? "face" : "tristrips");
            throw inputError(in_.locationAt(element.countAt),
                             element.count == 0 ? fmt::format("element {} has a count of 0: the file has no face", element.name)
                                                : fmt::format("element {} has no face of 3 corners or more", element.name));
        }
        for (size_t c = 0; c < mesh_.corners.size(); ++c)
            if (mesh_.corners[c].position >= mesh_.positions.size())
                throw inputError(in_.locationAt(elementNamed(header_.has[kIndices] ? "face" : "tristrips").countAt),
                                 fmt::format("vertex index {} of corner {}: there are {} vertices", mesh_.corners[c].position, c,
                                             mesh_.positions.size()));
    }
    const Element& elementNamed(std::string_view name) const {
        return *std::find_if(header_.elements.begin(), header_.elements.end(), [&](const Element& e) { return e.name == name; });
    }

    void checkBadVertices() {
        if (badVertices_.empty()) return;
        const std::vector<bool> drawn = drawnPositions(mesh_);
        for (const BadVertex& bad : badVertices_) {
            const auto location = [&] { return header_.ascii ? in_.locationAt(text_.data() + bad.at) : locationOfByte(path_, bad.at); };
            if (drawn[bad.index]) finiteFloat(bad.value, location(), fieldOf(elementNamed("vertex"), *bad.property, bad.index));  // refuses
            tolerance_.pass(kBadVertex, location);
        }
    }

    struct BadVertex {
        uint64_t index;
        size_t at;  // of the first such number in the file
        double value;
        const Property* property;
    };

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    const std::string text_;
    Scanner in_;
    Tolerance tolerance_;
    Header header_;
    size_t at_ = 0, valueAt_ = 0;  // binary: the next byte; and the first byte of the last value
    uint64_t itemsLeft_ = 0;       // of all elements
    std::optional<bool> rowsAreLines_;
    bool normals_ = false, colours_ = false;
    bool badNormal_ = false, badColour_ = false, anyBadNormal_ = false;  // of the current vertex, and of any
    uint64_t stripLength_ = 0;                                           // vertices of the current strip
    std::array<uint32_t, 2> stripEnd_{};                                 // its last two
    std::vector<BadVertex> badVertices_;
    PolygonMesh mesh_;
};

}  // namespace

PolygonMesh readPly(const std::filesystem::path& path, const LoadOptions& options) { return PlyReader(path, options).read(); }

}  // namespace plumb
