// SPDX-License-Identifier: MIT
// PNG through libpng: any colour type and depth, as codes of 8 or 16 bits. Grey stays grey, a palette becomes RGB.
#include "pipeline/compare/picture.h"
#include "pipeline/scene/text.h"

#include <png.h>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// State of a reading. Everything that changes after setjmp stands here, behind the pointer that libpng has, so that no register holds a
// copy.
struct Reading {
    std::string_view bytes;
    size_t at = 0;
    std::string failure;
    uint32_t width = 0, height = 0;
    Layer layer;
    std::vector<unsigned char> row, whole;
};

// Error callback. libpng leaves its callbacks by longjmp: nothing with a destructor may live between setjmp and here.
[[noreturn]] void onError(png_structp png, png_const_charp message) {
    static_cast<Reading*>(png_get_error_ptr(png))->failure = message;
    png_longjmp(png, 1);
}
void onWarning(png_structp, png_const_charp) {}
void take(png_structp png, png_bytep to, size_t count) {
    auto* reading = static_cast<Reading*>(png_get_io_ptr(png));
    if (count > reading->bytes.size() - reading->at) png_error(png, "the file ends within a chunk");
    std::memcpy(to, reading->bytes.data() + reading->at, count);
    reading->at += count;
}

// Most memory for one ancillary chunk, decompressed; only gAMA and sRGB are used.
constexpr png_alloc_size_t kMostChunkBytes = 8u << 20;

void appendRow(const std::vector<unsigned char>& row, bool wide, std::vector<double>& samples) {
    if (wide)
        for (size_t i = 0; i + 1 < row.size(); i += 2) samples.push_back(row[i] * 256 + row[i + 1]);
    else
        samples.insert(samples.end(), row.begin(), row.end());
}

void decode(png_structp png, png_infop info, Reading& reading) {
    Layer& layer = reading.layer;
    png_set_read_fn(png, &reading, take);
    png_set_user_limits(png, kLargestPictureSide, kLargestPictureSide);
    png_set_chunk_malloc_max(png, kMostChunkBytes);
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(png, info);
    reading.width = png_get_image_width(png, info);
    reading.height = png_get_image_height(png, info);
    png_set_expand(png);  // palette to RGB, 1 to 4 bits to 8, a transparent colour to alpha
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    const bool wide = png_get_bit_depth(png, info) == 16;
    layer.alpha = (png_get_color_type(png, info) & PNG_COLOR_MASK_ALPHA) != 0;
    layer.channels = png_get_channels(png, info);
    layer.fullScale = wide ? 65535 : 255;
    png_fixed_point gamma = 0;
    int intent = 0;
    layer.linear = png_get_sRGB(png, info, &intent) == 0 && png_get_gAMA_fixed(png, info, &gamma) != 0 && gamma == PNG_FP_1;
    if (uint64_t(reading.width) * reading.height * layer.channels > kMostSamples) png_error(png, "more than 2^27 samples");
    const size_t rowBytes = png_get_rowbytes(png, info);
    if (rowBytes != size_t(reading.width) * layer.channels * (wide ? 2 : 1)) png_error(png, "a row of unexpected size");
    if (passes == 1) {  // row by row, so that a short file takes no more memory than the rows it has
        reading.row.resize(rowBytes);
        for (uint32_t y = 0; y < reading.height; ++y) {
            png_read_row(png, reading.row.data(), nullptr);
            appendRow(reading.row, wide, layer.samples);
        }
    } else {
        // Seven passes fill a whole picture. Deflate expands 1032 times at most, so a file that is too short is known before.
        if (uint64_t(rowBytes) * reading.height / 1032 > reading.bytes.size()) png_error(png, "the file is too short for its picture");
        reading.whole.resize(rowBytes * reading.height);
        for (int pass = 0; pass < passes; ++pass)
            for (uint32_t y = 0; y < reading.height; ++y) png_read_row(png, reading.whole.data() + y * rowBytes, nullptr);
        appendRow(reading.whole, wide, layer.samples);
    }
    png_read_end(png, nullptr);
}

}  // namespace

Picture readPngPicture(const std::filesystem::path& path, const std::string& bytes) {
    Reading reading{bytes};
    Layer& layer = reading.layer;
    layer.name = "color";
    layer.kind = LayerKind::code;
    layer.colour = true;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, onError, onWarning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) {
        png_destroy_read_struct(&png, nullptr, nullptr);
        throw renderError("PNG: out of memory");
    }
    if (setjmp(png_jmpbuf(png))) {
        png_destroy_read_struct(&png, &info, nullptr);
        throw inputError(locationOfByte(path, reading.at), "PNG: " + printable(reading.failure));
    }
    try {  // an exception of a vector must not leave libpng's structures behind
        decode(png, info, reading);
    } catch (...) {
        png_destroy_read_struct(&png, &info, nullptr);
        throw;
    }
    png_destroy_read_struct(&png, &info, nullptr);
    Picture picture;
    picture.format = "png";
    picture.width = reading.width;
    picture.height = reading.height;
    picture.layers.push_back(std::move(layer));
    return picture;
}

}  // namespace plumb
