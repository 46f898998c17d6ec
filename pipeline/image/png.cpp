// SPDX-License-Identifier: MIT
// PNG through libpng; zlib_strips.h compresses its rows. Equal frame, options and metadata give equal bytes: no time stamp, fixed filters
// and level.
#include "host/error.h"
#include "pipeline/image/image.h"
#include "pipeline/image/zlib_strips.h"

#include <fmt/core.h>
#include <png.h>
#include <sys/stat.h>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace plumb {
namespace {

// Compression: Sub filter, zlib level 4. Suzanne at 1920x1080: 115 kB in 57 ms; libpng's defaults (all filters, level 6) 99 kB in 178 ms,
// Sub and level 1 160 kB in 38 ms.
constexpr int kZlibLevel = 4;
constexpr unsigned char kFilterSub = 1;
constexpr uint64_t kMostPixelsRead = uint64_t(1) << 28;

// Text of an error. libpng leaves an error callback by longjmp or by a C++ exception. Debian's libpng is built with unwind tables, but C
// frames without them would end the program, so errors go through longjmp.
struct Failure {
    std::string text;
};
[[noreturn]] void onError(png_structp png, png_const_charp message) {
    static_cast<Failure*>(png_get_error_ptr(png))->text = message;
    png_longjmp(png, 1);
}
void onWarning(png_structp, png_const_charp) {}

void append(png_structp png, png_bytep data, size_t count) {
    auto* bytes = static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
    const auto* from = reinterpret_cast<const std::byte*>(data);
    bytes->insert(bytes->end(), from, from + count);
}
void flushNothing(png_structp) {}

// Encoded value by the curve of IEC 61966-2-1, as in the 8-bit picture; binary64, so that rounding to 16 bits is its only error.
double srgbFromLinear(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }

uint16_t sixteenBits(float linear, bool keepLinear) {
    const double x = std::isnan(linear) ? 0.0 : std::clamp(double(linear), 0.0, 1.0);
    return uint16_t(std::lround((keepLinear ? x : srgbFromLinear(x)) * 65535.0));
}

void packRow8(const Frame& frame, uint32_t y, bool alpha, unsigned char* to) {
    const uint32_t* from = frame.rgba.data() + size_t(y) * frame.width;
    for (uint32_t x = 0; x < frame.width; ++x) {
        *to++ = static_cast<unsigned char>(from[x]);
        *to++ = static_cast<unsigned char>(from[x] >> 8);
        *to++ = static_cast<unsigned char>(from[x] >> 16);
        if (alpha) *to++ = static_cast<unsigned char>(from[x] >> 24);
    }
}

void packRowGrey(const Frame& frame, uint32_t y, unsigned char* to) {
    const uint32_t* from = frame.rgba.data() + size_t(y) * frame.width;
    for (uint32_t x = 0; x < frame.width; ++x) *to++ = static_cast<unsigned char>(from[x]);
}

void packRow16(const Frame& frame, uint32_t y, bool alpha, bool keepLinear, unsigned char* to) {
    const auto put = [&to](uint32_t value) {  // PNG is big endian
        *to++ = static_cast<unsigned char>(value >> 8);
        *to++ = static_cast<unsigned char>(value);
    };
    for (uint32_t x = 0; x < frame.width; ++x) {
        const size_t at = size_t(y) * frame.width + x;
        for (size_t c = 0; c < 3; ++c) put(sixteenBits(frame.linear[at * 3 + c], keepLinear));
        if (alpha) put((frame.rgba[at] >> 24) * 257u);
    }
}

// Key of a text chunk: 1 to 79 printable Latin-1 characters (PNG, 11.3.4.2); longer ones are cut.
std::string textKey(const std::string& key) {
    std::string k = key.substr(0, 79);
    for (char& c : k)
        if (c < 32 || c > 126) c = '_';
    return k.empty() ? "_" : k;
}

}  // namespace

std::vector<std::byte> encodePng(const Frame& frame, const WriteOptions& options, const Metadata& metadata) {
    const size_t pixels = size_t(frame.width) * frame.height;
    PLUMB_ASSERT(pixels != 0 && frame.rgba.size() == pixels);
    PLUMB_ASSERT(options.bits == 8 || (options.bits == 16 && frame.linear.size() == pixels * 3));
    PLUMB_ASSERT(!options.grey || (options.bits == 8 && !options.alpha));
    const size_t channels = options.grey ? 1 : options.alpha ? 4 : 3;
    const int colourType = options.grey ? PNG_COLOR_TYPE_GRAY : options.alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB;
    const size_t pixelBytes = channels * size_t(options.bits / 8), rowBytes = frame.width * pixelBytes;

    // Everything with a destructor lives outside the frames that longjmp leaves.
    std::vector<std::byte> bytes;
    bytes.reserve(rowBytes * frame.height / 4 + 4096);
    const std::vector<std::vector<std::byte>> strips =
        zlibStrips(frame.height, rowBytes + 1, kZlibLevel, [&](uint32_t y, unsigned char* to) {
            *to++ = kFilterSub;
            if (options.grey)
                packRowGrey(frame, y, to);
            else if (options.bits == 8)
                packRow8(frame, y, options.alpha, to);
            else
                packRow16(frame, y, options.alpha, options.linear, to);
            // Sub filter: each byte minus that of the pixel before (PNG, 9.2).
            for (size_t i = rowBytes - 1; i >= pixelBytes; --i) to[i] = static_cast<unsigned char>(to[i] - to[i - pixelBytes]);
        });
    Failure failure;
    std::vector<std::string> keys;
    for (const auto& [key, value] : metadata) keys.push_back(textKey(key));
    std::vector<png_text> texts;
    for (const auto& [key, value] : metadata) {
        const bool ascii = std::all_of(value.begin(), value.end(), [](char c) { return c == '\n' || (c >= 32 && c < 127); });
        png_text text{};
        text.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;  // tEXt is Latin-1, iTXt is UTF-8
        text.key = keys[texts.size()].data();
        text.text = const_cast<char*>(value.c_str());
        text.text_length = ascii ? value.size() : 0;
        text.itxt_length = ascii ? 0 : value.size();
        texts.push_back(text);
    }

    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, onError, onWarning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) {
        png_destroy_write_struct(&png, nullptr);
        throw renderError("PNG: out of memory");
    }
    if (setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        throw renderError("PNG: " + failure.text);
    }
    png_set_write_fn(png, &bytes, append, flushNothing);
    png_set_user_limits(png, 0x7fffffff, 0x7fffffff);
    png_set_IHDR(png, info, frame.width, frame.height, options.bits, colourType, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (options.linear && !options.grey) png_set_gAMA_fixed(png, info, PNG_FP_1);
    if (!options.linear && !options.grey) png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
    if (!texts.empty()) png_set_text(png, info, texts.data(), int(texts.size()));
    png_write_info(png, info);
    for (const std::vector<std::byte>& strip : strips)
        png_write_chunk(png, reinterpret_cast<png_const_bytep>("IDAT"), reinterpret_cast<png_const_bytep>(strip.data()), strip.size());
    png_write_chunk(png, reinterpret_cast<png_const_bytep>("IEND"), nullptr, 0);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

Frame readPng(const std::filesystem::path& path) {
    const std::string name = path.string();
    struct stat st {};
    if (::stat(name.c_str(), &st) != 0) throw inputError(name, std::strerror(errno));
    if (!S_ISREG(st.st_mode)) throw inputError(name, "not a regular file");
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "rb"), std::fclose);
    if (!file) throw inputError(name, std::strerror(errno));

    Frame frame;
    std::vector<png_bytep> rows;
    Failure failure;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, onError, onWarning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) {
        png_destroy_read_struct(&png, nullptr, nullptr);
        throw renderError("PNG: out of memory");
    }
    if (setjmp(png_jmpbuf(png))) {
        png_destroy_read_struct(&png, &info, nullptr);
        throw inputError(name, "PNG: " + failure.text);
    }
    png_init_io(png, file.get());
    png_set_user_limits(png, 0x7fffffff, 0x7fffffff);
    png_read_info(png, info);
    frame.width = png_get_image_width(png, info);
    frame.height = png_get_image_height(png, info);
    const uint64_t pixels = uint64_t(frame.width) * frame.height;
    if (pixels > kMostPixelsRead) png_error(png, "more than 2^28 pixels");
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    if (png_get_rowbytes(png, info) != size_t(frame.width) * 4) png_error(png, "unexpected row size");
    frame.rgba.resize(size_t(pixels));
    for (uint32_t y = 0; y < frame.height; ++y) rows.push_back(reinterpret_cast<png_bytep>(frame.rgba.data() + size_t(y) * frame.width));
    png_read_image(png, rows.data());
    png_read_end(png, nullptr);
    png_destroy_read_struct(&png, &info, nullptr);
    return frame;
}

}  // namespace plumb
