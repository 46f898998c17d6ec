// SPDX-License-Identifier: MIT
// A capsule as files: capsule.json names them all, each with its length and its SHA-256. Zeros at the end of a buffer are left out.
#include "host/error.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/text.h"
#include "pipeline/suite/capsule.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb::suite {

namespace {

namespace fs = std::filesystem;

constexpr const char* kIndex = "capsule.json";
constexpr std::array<const char*, 6> kViews = {"storage", "texelU32", "texelU32x2", "texelU32x4", "texelF32", "texelF32x4"};

std::string textOf(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// Adds a file and returns what the index says of it.
Json addFile(std::map<std::string, std::string>& files, const std::string& name, std::span<const std::byte> bytes) {
    size_t kept = bytes.size();
    while (kept > 0 && bytes[kept - 1] == std::byte(0)) --kept;
    files[name] = textOf(bytes.first(kept));
    return {{"file", name}, {"bytes", bytes.size()}, {"sha256", sha256Hex(bytes.first(kept))}};
}

// What the index says, read back; every refusal names the file.
class Reader {
public:
    explicit Reader(fs::path folder) : folder_(std::move(folder)) {}

    Capsule read() {
        const fs::path index = folder_ / kIndex;
        const std::string path = printablePath(index);
        if (!fs::is_directory(folder_)) throw inputError(printablePath(folder_), "is no folder, and a capsule is one");
        if (!fs::is_regular_file(index)) throw inputError(printablePath(folder_), fmt::format("is no capsule: it has no {}", kIndex));
        try {
            const Json json = Json::parse(readInput(index, {}, kMostCapsuleBytes));
            const std::string schema = json.is_object() ? json.value("schema", "") : "";
            if (schema != kCapsuleSchema)
                throw inputError(path, fmt::format("is no capsule of this program: its schema is '{}', and '{}' is wanted",
                                                   printable(schema), kCapsuleSchema));
            return capsuleOf(json, path);
        } catch (const Json::parse_error& e) {
            throw inputError(fmt::format("{}: byte {}", path, e.byte), "the JSON ends or breaks here: the file is truncated or no capsule");
        } catch (const Json::exception& e) {
            throw inputError(path, fmt::format("is no whole capsule: {}", e.what()));
        }
    }

private:
    std::vector<std::byte> fileOf(const Json& json) const {
        const auto name = json.at("file").get<std::string>();
        const auto bytes = json.at("bytes").get<uint64_t>();
        const fs::path path = folder_ / name;
        if (name.find('/') != std::string::npos || name.starts_with("."))
            throw inputError(printablePath(folder_ / kIndex), fmt::format("names '{}', which is outside its folder", printable(name)));
        if (bytes > kMostCapsuleBytes)
            throw inputError(printablePath(folder_ / kIndex),
                             fmt::format("gives '{}' {} bytes, at most {} are read", printable(name), bytes, kMostCapsuleBytes));
        if (!fs::is_regular_file(path)) throw inputError(printablePath(path), "is missing; the capsule is torn");
        const std::string text = readInput(path, {}, kMostCapsuleBytes);
        const auto read = std::as_bytes(std::span(text));
        if (text.size() > bytes || sha256Hex(read) != json.at("sha256").get<std::string>())
            throw inputError(printablePath(path), "has other bytes than capsule.json says; the capsule is torn");
        std::vector<std::byte> whole(read.begin(), read.end());
        whole.resize(bytes);
        return whole;
    }

    DispatchRecord::Bound boundOf(const Json& json, const std::string& path) const {
        DispatchRecord::Bound bound;
        bound.name = json.at("name").get<std::string>();
        const auto view = std::find(kViews.begin(), kViews.end(), json.at("view").get<std::string>());
        if (view == kViews.end())
            throw inputError(path, fmt::format("has a binding of the unknown view '{}'", printable(json.at("view").get<std::string>())));
        bound.view = View(view - kViews.begin());
        bound.elementBytes = json.at("elementBytes").get<uint32_t>();
        bound.before = fileOf(json.at("before"));
        bound.after = json.at("after").is_null() ? bound.before : fileOf(json.at("after"));
        if (bound.before.empty() || bound.after.size() != bound.before.size())
            throw inputError(path, fmt::format("binding '{}' has {} bytes before the dispatch and {} after it", printable(bound.name),
                                               bound.before.size(), bound.after.size()));
        return bound;
    }

    Capsule capsuleOf(const Json& json, const std::string& path) const {
        Capsule capsule;
        DispatchRecord& d = capsule.dispatch;
        const Json& difference = json.at("difference");
        capsule.pass = difference.at("pass").get<std::string>();
        capsule.what = difference.at("what").get<std::string>();
        d.failure = difference.at("failure").get<std::string>();
        const Json& dispatch = json.at("dispatch");
        d.label = dispatch.at("label").get<std::string>();
        d.module = dispatch.at("module").get<std::string>();
        const std::vector<std::byte> words = fileOf(dispatch.at("words"));
        if (words.size() < 20 || words.size() % 4 != 0) throw inputError(path, "its module is no SPIR-V");
        d.words.resize(words.size() / 4);
        std::memcpy(d.words.data(), words.data(), words.size());
        d.items = dispatch.at("items").get<uint64_t>();
        d.push = dispatch.at("push").get<std::vector<uint32_t>>();
        if (d.push.empty()) throw inputError(path, "its push block is empty");
        for (const auto& [id, value] : dispatch.at("constants").items()) d.constants[uint32_t(std::stoul(id))] = value.get<uint32_t>();
        for (const Json& bound : json.at("bindings")) d.bindings.push_back(boundOf(bound, path));
        if (const Json& compared = json.at("compared"); !compared.is_null()) {
            capsule.element = compared.at("element").get<std::string>();
            capsule.elementBytes = compared.at("elementBytes").get<uint32_t>();
            capsule.expected = fileOf(compared.at("expected"));
            capsule.got = fileOf(compared.at("got"));
            if (!compared.at("binding").is_null())
                capsule.location = Location{compared.at("binding").get<uint32_t>() - 1, compared.at("offset").get<uint64_t>()};
            if (capsule.elementBytes == 0 || capsule.expected.size() != capsule.got.size() || !fits(capsule))
                throw inputError(path, "its compared values do not lie in its bindings");
        }
        capsule.about = json.at("about");
        return capsule;
    }
    static bool fits(const Capsule& capsule) {
        if (!capsule.location) return true;
        if (capsule.location->binding >= capsule.dispatch.bindings.size()) return false;
        const uint64_t bytes = capsule.dispatch.bindings[capsule.location->binding].after.size();
        return capsule.location->offset <= bytes && capsule.expected.size() <= bytes - capsule.location->offset;
    }

    const fs::path folder_;
};

Json comparedOf(std::map<std::string, std::string>& files, const Capsule& capsule) {
    if (capsule.elementBytes == 0) return {};
    const ValueDifference found = differenceOf(capsule.expected, capsule.got, capsule.elementBytes);
    Json json = {{"element", capsule.element},
                 {"elementBytes", capsule.elementBytes},
                 {"count", found.count},
                 {"differing", found.differing},
                 {"first",
                  {{"index", found.first},
                   {"expected", wordsOf(capsule.expected, found.first, capsule.elementBytes)},
                   {"got", wordsOf(capsule.got, found.first, capsule.elementBytes)}}},
                 {"binding", capsule.location ? Json(capsule.location->binding + 1) : Json()},
                 {"offset", capsule.location ? Json(capsule.location->offset) : Json()}};
    json["expected"] = addFile(files, "expected.bin", capsule.expected);
    json["got"] = addFile(files, "got.bin", capsule.got);
    return json;
}

}  // namespace

std::map<std::string, std::string> filesOf(const Capsule& capsule) {
    std::map<std::string, std::string> files;
    const DispatchRecord& d = capsule.dispatch;
    Json json;
    json["schema"] = kCapsuleSchema;
    json["about"] = capsule.about;
    json["difference"] = {{"pass", capsule.pass}, {"what", capsule.what}, {"failure", d.failure}};
    Json constants = Json::object();
    for (const auto& [id, value] : d.constants) constants[std::to_string(id)] = value;
    json["dispatch"] = {
        {"label", d.label}, {"module", d.module}, {"words", addFile(files, "module.spv", std::as_bytes(std::span(d.words)))},
        {"items", d.items}, {"push", d.push},     {"constants", constants}};
    json["bindings"] = Json::array();
    for (size_t b = 0; b < d.bindings.size(); ++b) {
        const DispatchRecord::Bound& bound = d.bindings[b];
        json["bindings"].push_back(
            {{"binding", b + 1},
             {"name", bound.name},
             {"view", kViews[size_t(bound.view)]},
             {"elementBytes", bound.elementBytes},
             {"before", addFile(files, fmt::format("binding{}.before.bin", b + 1), bound.before)},
             {"after", bound.after == bound.before ? Json() : addFile(files, fmt::format("binding{}.after.bin", b + 1), bound.after)}});
    }
    json["compared"] = comparedOf(files, capsule);
    files["triangles.obj"] = capsule.triangles;
    files[kIndex] = json.dump(1) + "\n";
    return files;
}

Capsule readCapsule(const fs::path& folder) { return Reader(folder).read(); }

}  // namespace plumb::suite
