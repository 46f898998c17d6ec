// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_buffers.h"

#include "pipeline/scene/input.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <filesystem>
#include <system_error>

namespace plumb::gltf {

// RFC 4648 base64, as every glTF writer emits; other encodings of data: are refused.
static std::string decodeDataUri(const Value& uri) {
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

static std::string percentDecoded(std::string_view uri) {
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

Buffers::Buffers(const Container& container, const Reading& reading)
    : container_(container),
      reading_(reading),
      buffers_(container.root().list("buffers")),
      views_(container.root().list("bufferViews")),
      data_(buffers_.size()),
      bytesRead_(container.bytes().size()) {}

std::string_view Buffers::file(const Value& uri) {
    const std::string& text = uri.text();
    if (text.find("://") != text.npos) uri.refuse("names a network address; only files are read");
    const std::filesystem::path path = resolveReference(referenceBase(container_.path(), reading_.options), percentDecoded(text),
                                                        reading_.options.allowOutside, uri.location(), "buffer");
    std::error_code code;
    if (!std::filesystem::exists(path, code)) uri.refuse(fmt::format("'{}' does not exist", printable(text)));
    const auto [known, isNew] = files_.try_emplace(path.lexically_normal().string());
    if (isNew) {
        loaded_.push_back(std::make_unique<std::string>(readWholeFile(path)));
        known->second = *loaded_.back();
        bytesRead_ += known->second.size();
    }
    return known->second;
}

// Bytes of a buffer, at least the byteLength that it states.
std::string_view Buffers::buffer(size_t i) {
    if (data_[i]) return *data_[i];
    const Value& value = buffers_[i];
    const Value lengthValue = value.required("byteLength");
    const uint64_t length = lengthValue.whole(kMaxFileBytes);
    std::string_view data;
    if (const auto uri = value.find("uri")) {
        if (uri->text().starts_with("data:")) {
            loaded_.push_back(std::make_unique<std::string>(decodeDataUri(*uri)));
            data = *loaded_.back();
        } else {
            data = file(*uri);
        }
    } else {
        if (i != 0 || !container_.binaryChunk()) value.refuse("has no uri, and there is no binary chunk for it");
        data = *container_.binaryChunk();
    }
    if (length > data.size()) lengthValue.refuse(fmt::format("is {}, but the data has {} bytes", length, data.size()));
    data_[i] = data.substr(0, size_t(length));
    return *data_[i];
}

Buffers::View Buffers::view(const Value& index) {
    const Value& value = views_[index.index(views_.size(), "bufferViews")];
    const std::string_view data = buffer(value.required("buffer").index(buffers_.size(), "buffers"));
    const auto offsetValue = value.find("byteOffset");
    const uint64_t offset = offsetValue ? offsetValue->whole(kMaxFileBytes) : 0;
    const Value lengthValue = value.required("byteLength");
    const uint64_t length = lengthValue.whole(kMaxFileBytes);
    if (offset + length > data.size()) lengthValue.refuse(fmt::format("{} bytes at {} of a buffer of {}", length, offset, data.size()));
    const auto strideValue = value.find("byteStride");
    const size_t stride = strideValue ? size_t(strideValue->whole(252)) : 0;
    if (strideValue && stride < 4)
        reading_.pass(*strideValue, stride == 0 ? "is 0; it counts as not stated" : "is below the least byteStride of glTF, 4");
    return {data.substr(size_t(offset), size_t(length)), stride};
}

}  // namespace plumb::gltf
