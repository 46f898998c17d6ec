// SPDX-License-Identifier: MIT
#include "pipeline/scene/ply_header.h"

#include <fmt/core.h>
#include <bit>
#include <utility>

namespace plumb::ply {
namespace {

constexpr size_t kMaxElements = 64, kMaxProperties = 256;  // a file with more is not a mesh

constexpr std::pair<std::string_view, Type> kTypes[] = {
    {"char", Type::int8},     {"uchar", Type::uint8},     {"short", Type::int16},    {"ushort", Type::uint16}, {"int", Type::int32},
    {"uint", Type::uint32},   {"float", Type::float32},   {"double", Type::float64}, {"int8", Type::int8},     {"uint8", Type::uint8},
    {"int16", Type::int16},   {"uint16", Type::uint16},   {"int32", Type::int32},    {"uint32", Type::uint32}, {"int64", Type::int64},
    {"uint64", Type::uint64}, {"float32", Type::float32}, {"float64", Type::float64}};

constexpr std::string_view kRoleNames[] = {"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"};

class HeaderReader {
public:
    HeaderReader(Scanner& in, std::string_view text, Tolerance& tolerance, const std::function<void(const std::string&)>& ignore)
        : in_(in), text_(text), tolerance_(tolerance), ignore_(ignore) {}

    Header read() {
        if (in_.word() != "ply") in_.refuse("the file does not begin with 'ply'");
        const size_t firstLineEnd = in_.offset();
        if (!in_.lineEnds()) in_.refuse("the first line has more than 'ply'");
        in_.skipLine();
        statements();
        if (!formatKnown_) in_.refuse("the header has no format");
        if (!in_.lineEnds()) in_.refuse("the line of end_header has more words");
        for (const Element& element : header_.elements) nameSkipped(element);
        need("element vertex with x, y and z", header_.has3(kX));
        need("element face with a list vertex_indices", header_.has[kIndices] || header_.has[kStrips]);
        if (header_.has3(kRed)) ignore_("vertex colours");
        findBody(firstLineEnd);
        return std::move(header_);
    }

private:
    void need(const char* name, bool there) {
        if (!there) in_.refuse(fmt::format("the header has no {}", name));
    }

    void statements() {
        while (true) {
            const std::string_view key = in_.word();
            if (in_.atEnd() && key.empty()) in_.refuse("the file ends inside the header");
            if (key == "end_header") return;
            if (key == "format") {
                format();
            } else if (key == "element") {
                element();
            } else if (key == "property") {
                property();
            } else if (key == "comment") {
                if (in_.word() == "TextureFile") ignore_("texture (comment TextureFile)");
            } else if (key != "obj_info" && !key.empty()) {
                tolerance_.pass("a header line is no statement of PLY; it is passed over", [&] { return in_.location(); });
            }
            in_.skipLine();
        }
    }

    void format() {
        const std::string_view format = in_.word();
        header_.ascii = format == "ascii";
        header_.swap = format == (std::endian::native == std::endian::little ? "binary_big_endian" : "binary_little_endian");
        if (!header_.ascii && format != "binary_little_endian" && format != "binary_big_endian")
            in_.refuse(fmt::format("format '{}' is not ascii, binary_little_endian or binary_big_endian", printable(format, 40)));
        if (in_.word() != "1.0") in_.refuse("format version is not 1.0");
        formatKnown_ = true;
    }

    // A single carriage return ends lines only when it ends the first one; otherwise the byte after it is data.
    void findBody(size_t firstLineEnd) {
        const bool carriageReturns = text_[firstLineEnd] == '\r' && text_.compare(firstLineEnd, 2, "\r\n") != 0;
        if (in_.atEnd()) in_.refuse("the file ends after the header");
        size_t at = in_.offset();
        if (text_[at] == '\r')
            at += !carriageReturns && at + 1 < text_.size() && text_[at + 1] == '\n' ? 2 : 1;
        else
            ++at;
        header_.bodyOffset = at;
        if (header_.ascii) in_.skipLine();
    }

    void element() {
        const std::string_view name = in_.word();
        if (name.empty()) in_.refuse("element has no name");
        if (header_.elements.size() == kMaxElements) in_.refuse(fmt::format("more than {} elements", kMaxElements));
        for (const Element& other : header_.elements)
            if (other.name == name) in_.refuse(fmt::format("element '{}' is stated twice", printable(name, 40)));
        Element element{std::string(name)};
        const std::string_view word = in_.word();
        const int64_t count = in_.integer(word, "element count");
        if (count < 0) in_.refuse("element count is negative");
        element.count = uint64_t(count);
        element.countAt = word.data();
        header_.elements.push_back(element);
    }

    Type type(std::string_view word) {
        for (const auto& [name, type] : kTypes)
            if (name == word) return type;
        in_.refuse(fmt::format("property type '{}' is not a type of PLY", printable(word, 40)));
    }

    void property() {
        if (header_.elements.empty()) in_.refuse("property comes before the first element");
        Element& element = header_.elements.back();
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
        giveRole(element, property);
        element.properties.push_back(property);
    }

    void giveRole(const Element& element, Property& property) {
        const bool faces = element.name == "face", strips = element.name == "tristrips";
        if ((faces || strips) && (property.name == "vertex_indices" || property.name == "vertex_index")) {
            if (!property.list || isReal(property.type)) in_.refuse(fmt::format("property {} is not a list of integers", property.name));
            property.role = faces ? kIndices : kStrips;
            if (header_.has[property.role]) in_.refuse("a second list of vertex indices");
        }
        if (element.name == "vertex" && !property.list)
            for (int role = 0; role < kScalarRoles; ++role)
                if (property.name == kRoleNames[role] || (role >= kRed && property.name == fmt::format("diffuse_{}", kRoleNames[role])))
                    property.role = Role(role);
        if (property.role != kSkipped) header_.has[property.role] = true;
    }

    // Names the parts of the file that no pass draws.
    void nameSkipped(const Element& element) {
        if (element.name != "vertex" && element.name != "face" && element.name != "tristrips")
            return ignore_(fmt::format("PLY element {}", printable(element.name, 40)));
        for (const Property& property : element.properties)
            if (property.role == kSkipped) ignore_(fmt::format("PLY property {} of {}", printable(property.name, 40), element.name));
    }

    Scanner& in_;
    std::string_view text_;
    Tolerance& tolerance_;
    const std::function<void(const std::string&)>& ignore_;
    Header header_;
    bool formatKnown_ = false;
};

}  // namespace

Header readHeader(Scanner& in, std::string_view text, Tolerance& tolerance, const std::function<void(const std::string&)>& ignore) {
    return HeaderReader(in, text, tolerance, ignore).read();
}

}  // namespace plumb::ply
