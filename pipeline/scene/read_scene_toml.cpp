// SPDX-License-Identifier: MIT
#include "pipeline/scene/input.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/toml_scene.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <ios>
#include <istream>
#include <span>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {
namespace scene_file {
namespace {

// Largest scene file. A TOML value takes about 90 bytes of memory and at least two of text; larger meshes belong in a mesh file.
constexpr uint64_t kMaxSceneFileBytes = uint64_t(16) << 20;

// Text in pieces, so that the parser's progress can be reported between them.
class MeteredBuffer : public std::streambuf {
public:
    MeteredBuffer(std::string_view text, const LoadOptions& options)
        : text_(text), meter_(options, "parse", kReadEnds, kParseEnds, text.size()) {}

protected:
    int_type underflow() override {
        meter_.at(done_);
        if (done_ == text_.size()) return traits_type::eof();
        const size_t size = std::min(kPiece, text_.size() - done_);
        char* first = const_cast<char*>(text_.data()) + done_;  // a streambuf that is only read writes nothing
        setg(first, first, first + size);
        done_ += size;
        return traits_type::to_int_type(*gptr());
    }

    // Seeks, because the parser looks for a byte order mark and goes back.
    pos_type seekoff(off_type by, std::ios::seekdir from, std::ios::openmode which) override {
        const off_type here = off_type(done_) - (egptr() - gptr());
        return seekpos(pos_type(by + (from == std::ios::beg ? 0 : from == std::ios::cur ? here : off_type(text_.size()))), which);
    }
    pos_type seekpos(pos_type to, std::ios::openmode) override {
        if (off_type(to) < 0 || off_type(to) > off_type(text_.size())) return pos_type(off_type(-1));
        done_ = size_t(off_type(to));
        setg(nullptr, nullptr, nullptr);
        return to;
    }

private:
    static constexpr size_t kPiece = size_t(1) << 14;
    std::string_view text_;
    LoadMeter meter_;
    size_t done_ = 0;
};

toml::table parsed(const std::string& text, const LoadOptions& options) {
    constexpr size_t kSmall = size_t(1) << 18;  // a stream is slower, and so few bytes are parsed at once
    if (text.size() <= kSmall) return toml::parse(std::string_view(text));
    MeteredBuffer buffer(text, options);
    std::istream stream(&buffer);
    stream.exceptions(std::ios::badbit);  // exceptions of the meter come through
    return toml::parse(stream);
}

}  // namespace

Scene SceneFile::read() {
    const std::string text = readInput(path_, options_, kMaxSceneFileBytes);
    if (const char* encoding = otherEncoding(text))
        throw inputError(locationOfLine(path_, 1, 1), fmt::format("the text is {}; only UTF-8 is read", encoding));
    refuseDeepKeys(text);
    toml::table root;
    try {
        root = parsed(text, options_);
    } catch (const toml::parse_error& error) {
        throw inputError(location(error.source()), "TOML: " + printable(error.description()));
    }
    allowKeys(root, "the scene",
              {"handedness", "up",     "ambient",   "background", "encoding", "shading", "fill",   "wire",   "edges",   "viewer",
               "size",       "cull",   "max_depth", "min_weight", "sampling", "jitter",  "seed",   "levels", "shadows", "sphere_heights",
               "z_buffer",   "camera", "material",  "light",      "mesh",     "object",  "sphere", "plane"});
    scene_.path = path_.string();
    scene_.sha256 = sha256Hex(std::as_bytes(std::span(text)));
    scene_.materials.push_back(Material{});
    materials_["default"] = 0;
    readSettings(root);
    if (const auto* node = root.get("camera")) readCamera(tableOf(*node, "camera"));
    eachTable(root, "material", "material", [&](const toml::table& table) { readMaterial(table); });
    eachTable(root, "light", "light", [&](const toml::table& table) { readLight(table); });
    const auto* meshTables = root.get_as<toml::array>("mesh");
    const double file = options_.from,
                 share = (options_.to - options_.from) / double(meshTables != nullptr ? std::max<size_t>(1, meshTables->size()) : 1);
    eachTable(root, "mesh", "mesh", [&, i = size_t(0)](const toml::table& table) mutable {
        options_.from = file + share * double(i++);  // each mesh has its part of the file
        options_.to = options_.from + share;
        readMesh(table);
    });
    options_.from = options_.to;
    LoadMeter meter(options_, "finish", 1, 1, 1);  // an interrupt is noticed here
    uint64_t work = 0;
    constexpr uint64_t kWork = 1000;  // units of the meter for a table
    eachTable(root, "sphere", "sphere", [&](const toml::table& table) { readSphere(table), meter.at(work += kWork); });
    eachTable(root, "plane", "plane", [&](const toml::table& table) { readPlane(table); });
    eachTable(root, "object", "object", [&](const toml::table& table) { readObject(table, -1, 1), meter.at(work += kWork); });
    if (!root.contains("object")) {
        for (const std::string& name : meshNames_) {
            Node node;
            node.name = name;
            node.table = &root;
            node.implied = true;
            node.mesh = meshes_.find(name)->second;
            nodes_.push_back(std::move(node));
        }
    }
    linkParents();
    placeObjects();
    if (scene_.objects.empty() && scene_.spheres.empty() && scene_.planes.empty())
        throw inputError(locationOfLine(path_, 1, 1),
                         "nothing to draw: no [[object]] has a mesh and there is no [[mesh]], [[sphere]] or [[plane]]");
    return std::move(scene_);
}

}  // namespace scene_file

Scene readSceneToml(const std::filesystem::path& path, const LoadOptions& options) { return scene_file::SceneFile(path, options).read(); }

}  // namespace plumb
