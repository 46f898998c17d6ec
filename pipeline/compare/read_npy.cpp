// SPDX-License-Identifier: MIT
// NumPy's .npy, format versions 1.0 to 3.0 (numpy.lib.format): magic, version, length of the header, a Python literal, the array.
#include "pipeline/compare/picture.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <half.h>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr size_t kMostHeaderBytes = 65536;
constexpr double kMostExact = 0x1p53;  // larger integers are not exact in binary64

// Literal of the header's dictionary: three keys with a string, a boolean and a tuple of whole numbers. Nothing is evaluated.
class Literal {
public:
    Literal(std::string_view text, const std::filesystem::path& path, size_t offset) : text_(text), path_(path), offset_(offset) {}

    std::string descr;
    std::optional<bool> fortran;
    std::vector<uint64_t> shape;
    bool hasShape = false;

    void read() {
        expect('{');
        while (!accept('}')) {
            const std::string key = string();
            expect(':');
            if (key == "descr")
                descr = string();
            else if (key == "fortran_order")
                fortran = boolean();
            else if (key == "shape")
                tuple();
            else
                refuse(fmt::format("unknown key '{}'", printable(key, 40)));
            if (!accept(',')) {
                expect('}');
                break;
            }
        }
        blanks();
        if (at_ != text_.size()) refuse("text after the dictionary");
        if (descr.empty() || !fortran || !hasShape) refuse("'descr', 'fortran_order' or 'shape' is missing");
    }
    [[noreturn]] void refuse(const std::string& why) const { throw inputError(locationOfByte(path_, offset_ + at_), "NPY header: " + why); }

private:
    void blanks() {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\t' || text_[at_] == '\r')) ++at_;
    }
    bool accept(char c) {
        blanks();
        if (at_ == text_.size() || text_[at_] != c) return false;
        ++at_;
        return true;
    }
    void expect(char c) {
        if (!accept(c)) refuse(fmt::format("'{}' is expected", c));
    }
    std::string string() {
        blanks();
        const char quote = at_ < text_.size() ? text_[at_] : '\0';
        if (quote != '\'' && quote != '"') refuse("a string is expected; structured types are not read");
        const size_t end = text_.find(quote, ++at_);
        if (end == text_.npos) refuse("a string without its end");
        std::string value(text_.substr(at_, end - at_));
        at_ = end + 1;
        return value;
    }
    bool boolean() {
        blanks();
        for (const bool value : {true, false}) {
            const std::string_view word = value ? "True" : "False";
            if (!text_.substr(at_).starts_with(word)) continue;
            at_ += word.size();
            return value;
        }
        refuse("True or False is expected");
    }
    void tuple() {
        hasShape = true;
        shape.clear();
        expect('(');
        while (!accept(')')) {
            blanks();
            uint64_t value = 0;
            const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
            if (error != std::errc()) refuse("a whole number is expected in 'shape'");
            at_ = size_t(end - text_.data());
            shape.push_back(value);
            if (shape.size() > 8) refuse("more than 8 dimensions");
            if (!accept(',')) {
                expect(')');
                break;
            }
        }
    }

    std::string_view text_;
    const std::filesystem::path& path_;
    size_t offset_, at_ = 0;
};

template <class T>
T load(const char* from, bool swap) {
    std::array<char, sizeof(T)> raw{};
    for (size_t i = 0; i < sizeof(T); ++i) raw[i] = from[swap ? sizeof(T) - 1 - i : i];
    return std::bit_cast<T>(raw);
}

double sample(const char* from, char kind, size_t bytes, bool swap) {
    if (kind == 'f' && bytes == 2) return double(float(Imath::half(Imath::half::FromBits, load<uint16_t>(from, swap))));
    if (kind == 'f') return bytes == 4 ? double(load<float>(from, swap)) : load<double>(from, swap);
    if (kind == 'i' && bytes == 1) return double(load<int8_t>(from, swap));
    if (kind == 'i' && bytes == 2) return double(load<int16_t>(from, swap));
    if (kind == 'i') return bytes == 4 ? double(load<int32_t>(from, swap)) : double(load<int64_t>(from, swap));
    if (bytes == 1) return double(load<uint8_t>(from, swap));
    if (bytes == 2) return double(load<uint16_t>(from, swap));
    return bytes == 4 ? double(load<uint32_t>(from, swap)) : double(load<uint64_t>(from, swap));
}

}  // namespace

Picture readNpyPicture(const std::filesystem::path& path, const std::string& bytes) {
    const auto byte = [&](size_t i) { return size_t(static_cast<unsigned char>(bytes[i])); };
    if (bytes.size() < 12) throw inputError(locationOfByte(path, bytes.size()), "NPY: the file ends within its header");
    const size_t version = byte(6);
    if (version < 1 || version > 3 || byte(7) != 0)
        throw inputError(locationOfByte(path, 6), fmt::format("NPY: version {}.{}; 1.0, 2.0 and 3.0 are read", version, byte(7)));
    const size_t prefix = version == 1 ? 10 : 12;
    const size_t headerBytes = version == 1 ? byte(8) | byte(9) << 8 : byte(8) | byte(9) << 8 | byte(10) << 16 | byte(11) << 24;
    if (headerBytes > kMostHeaderBytes)
        throw inputError(locationOfByte(path, 8),
                         fmt::format("NPY: a header of {} bytes; at most {} are read", headerBytes, kMostHeaderBytes));
    if (headerBytes > bytes.size() - prefix) throw inputError(locationOfByte(path, bytes.size()), "NPY: the file ends within its header");
    Literal header(std::string_view(bytes).substr(prefix, headerBytes), path, prefix);
    header.read();

    const std::string& type = header.descr;
    const char order = type[0], kind = type.size() == 3 ? type[1] : '\0';
    const size_t size = type.size() == 3 ? size_t(type[2] - '0') : 0;
    const bool whole = kind == 'u' || kind == 'i' || (kind == 'b' && size == 1);
    const bool known =
        (order == '<' || order == '>' || (order == '|' && size == 1)) &&
        ((whole && (size == 1 || size == 2 || size == 4 || size == 8)) || (kind == 'f' && (size == 2 || size == 4 || size == 8)));
    if (!known)
        header.refuse(fmt::format("type '{}' is not read; accepted: |b1, integers and floats of 1 to 8 bytes", printable(type, 40)));
    if (header.shape.size() != 2 && header.shape.size() != 3)
        header.refuse("'shape' has neither two nor three numbers: (H, W) or (H, W, C)");
    const uint64_t height = header.shape[0], width = header.shape[1], channels = header.shape.size() == 3 ? header.shape[2] : 1;
    if (height == 0 || width == 0 || channels == 0) header.refuse("an empty array");
    if (height > kLargestPictureSide || width > kLargestPictureSide)
        header.refuse(fmt::format("a side is longer than {}", kLargestPictureSide));
    if (channels > kMostChannels) header.refuse(fmt::format("{} channels; at most {} are read", channels, kMostChannels));
    const uint64_t samples = height * width * channels;
    if (samples > kMostSamples) header.refuse("more than 2^27 samples");
    const size_t start = prefix + headerBytes;
    if (bytes.size() - start != samples * size)
        throw inputError(locationOfByte(path, bytes.size()),
                         fmt::format("NPY: {} bytes of data; the header says {}", bytes.size() - start, samples * size));

    Picture picture;
    picture.format = "npy";
    picture.width = uint32_t(width);
    picture.height = uint32_t(height);
    Layer layer;
    layer.channels = uint32_t(channels);
    // Unsigned codes of 8 and 16 bits are taken as colour where their number of channels permits; an array says no more about itself.
    if (kind == 'u' && size <= 2 && channels != 2 && channels <= 4) {
        layer.name = "color";
        layer.kind = LayerKind::code;
        layer.colour = true;
        layer.alpha = channels == 4;
        layer.fullScale = size == 1 ? 255 : 65535;
    } else {
        layer.name = "array";
        layer.kind = kind == 'f' ? LayerKind::real : LayerKind::id;
        layer.precision = int(size * 8);
    }
    layer.samples.resize(samples);
    const bool swap = order == '>';
    for (uint64_t i = 0; i < samples; ++i) {
        uint64_t from = i;
        if (*header.fortran) {
            const uint64_t c = i % channels, x = i / channels % width, y = i / channels / width;
            from = y + height * (x + width * c);
        }
        const double value = sample(bytes.data() + start + from * size, kind, size, swap);
        if (kind != 'f' && std::fabs(value) >= kMostExact)
            throw inputError(locationOfByte(path, start + from * size), "NPY: an integer of 2^53 or more");
        layer.samples[i] = value;
    }
    picture.layers.push_back(std::move(layer));
    return picture;
}

}  // namespace plumb
