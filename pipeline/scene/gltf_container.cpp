// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_container.h"

#include "host/error.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string>

namespace plumb::gltf {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "binary glTF is read as it lies in memory");

// A JSON value takes up to 32 bytes of memory for two of text.
static constexpr uint64_t kMaxJsonBytes = uint64_t(256) << 20;
static constexpr int kMaxJsonDepth = 64;

Container::Container(const std::filesystem::path& path, const LoadOptions& options) : path_(path), bytes_(readInput(path, options)) {
    isGlb_ = bytes_.starts_with("glTF");
    if (const char* encoding = isGlb_ ? nullptr : otherEncoding(bytes_))
        throw inputError(locationOfLine(path_, 1, 1), fmt::format("the text is {}; only UTF-8 is read", encoding));
    parse(isGlb_ ? unpackGlb() : std::string_view(bytes_), options);
}

// glTF 4.4: a 12-byte header, a JSON chunk, perhaps a BIN chunk; unknown chunks are skipped.
std::string_view Container::unpackGlb() {
    const std::string_view all = bytes_;
    const auto word = [&](size_t at) {
        uint32_t value;
        std::memcpy(&value, all.data() + at, sizeof value);
        return value;
    };
    const auto refuse = [&](size_t at, const std::string& text) -> Error { return inputError(locationOfByte(path_, at), text); };
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
        } else if (type == kBinary && !binaryChunk_) {
            binaryChunk_ = chunk;
        }
        first = false;
        at += 8 + length;
    }
    if (first) throw refuse(12, "the GLB has no chunks");
    return text;
}

// Byte of the JSON text to a location: a line of a .gltf, a byte of a .glb.
std::string Container::locationInJson(size_t byte) const {
    if (isGlb_) return locationOfByte(path_, jsonStart_ + byte);
    const std::string_view before = std::string_view(bytes_).substr(0, byte);
    const size_t lastLine = before.rfind('\n');
    return locationOfLine(path_, size_t(std::count(before.begin(), before.end(), '\n')) + 1,
                          byte - (lastLine == before.npos ? 0 : lastLine + 1) + 1);
}

// Before parsing, because each level costs far more memory than its one byte.
void Container::refuseDeepJson(std::string_view text) const {
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
            if (++depth > kMaxJsonDepth) throw inputError(locationInJson(i), fmt::format("JSON is nested deeper than {}", kMaxJsonDepth));
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

void Container::parse(std::string_view text, const LoadOptions& options) {
    if (text.size() > kMaxJsonBytes)
        throw inputError(locationInJson(0), fmt::format("{} bytes of JSON, more than {}", text.size(), kMaxJsonBytes));
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
        LoadMeter meter(options, "parse", kReadEnds, kParseEnds, text.size());
        json_ = json::parse(MeteredText{text.data(), text.data(), &meter}, MeteredText{text.data() + text.size(), text.data(), nullptr});
    } catch (const json::parse_error& error) {
        throw inputError(locationInJson(std::min(text.size(), error.byte == 0 ? 0 : error.byte - 1)), reason(error.what()));
    } catch (const json::out_of_range& error) {
        // "number overflow parsing '1e999'" knows no position; the word is looked up.
        const std::string_view message = error.what();
        const size_t open = message.find('\''), close = message.rfind('\'');
        size_t at = 0;
        if (open != message.npos && close > open + 1) at = text.find(message.substr(open + 1, close - open - 1));
        throw inputError(locationInJson(at == text.npos ? 0 : at), reason(message));
    }
}

}  // namespace plumb::gltf
