// SPDX-License-Identifier: MIT
#include "pipeline/image/zlib_strips.h"

#include "host/error.h"
#include "pipeline/passes/parallel.h"

#include <zlib.h>
#include <algorithm>

namespace plumb {
namespace {

// Bytes of a strip of rows. A strip knows nothing of the strip before it; strips of this size make a picture of 1920x1080 0.5 % larger.
constexpr size_t kStripBytes = 131072;
constexpr int kRawWindowBits = -15, kMemoryLevel = 8;
constexpr size_t kFlushBytes = 16;  // bound on the bytes of a strip's end beyond deflateBound()

// Strip as blocks of RFC 1951 that end at a byte; the stream ends with the last one.
std::vector<std::byte> deflated(std::vector<unsigned char>& raw, int level, bool last) {
    z_stream stream{};
    if (deflateInit2(&stream, level, Z_DEFLATED, kRawWindowBits, kMemoryLevel, Z_FILTERED) != Z_OK)
        throw renderError("zlib: out of memory");
    const struct End {
        z_stream& of;
        ~End() { deflateEnd(&of); }
    } end{stream};
    std::vector<std::byte> bytes(deflateBound(&stream, uLong(raw.size())) + kFlushBytes);
    stream.next_in = raw.data();
    stream.avail_in = uInt(raw.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = uInt(bytes.size());
    const int done = deflate(&stream, last ? Z_FINISH : Z_SYNC_FLUSH);
    PLUMB_ASSERT(done == (last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0 && stream.avail_out != 0);
    bytes.resize(bytes.size() - stream.avail_out);
    return bytes;
}

}  // namespace

std::vector<std::vector<std::byte>> zlibStrips(uint32_t rows, size_t rowBytes, int level,
                                               const std::function<void(uint32_t, unsigned char*)>& fillRow) {
    PLUMB_ASSERT(rows != 0 && rowBytes != 0);
    const uint32_t stripRows = uint32_t(std::clamp<size_t>(kStripBytes / rowBytes, 1, rows)), strips = (rows + stripRows - 1) / stripRows;
    std::vector<std::vector<std::byte>> pieces(strips);
    std::vector<uLong> sums(strips);
    parallelBands(strips, 1, threadCount(0), [&](uint64_t begin, uint64_t end) {
        std::vector<unsigned char> raw;
        for (uint64_t strip = begin; strip < end; ++strip) {
            const uint32_t first = uint32_t(strip) * stripRows, here = std::min(stripRows, rows - first);
            raw.resize(here * rowBytes);
            for (uint32_t y = 0; y < here; ++y) fillRow(first + y, raw.data() + y * rowBytes);
            sums[strip] = adler32(1, raw.data(), uInt(raw.size()));
            pieces[strip] = deflated(raw, level, strip + 1 == strips);
        }
    });
    // Header of the stream: a window of 32 KiB; the level is only a remark. The two bytes are a multiple of 31.
    const unsigned method = 0x78, remark = level < 2 ? 0 : level < 6 ? 1 : level == 6 ? 2 : 3;
    const unsigned flags = remark << 6, check = 31 - (method * 256 + flags) % 31;
    pieces.front().insert(pieces.front().begin(), {std::byte(method), std::byte(flags + check % 31)});
    uLong sum = sums[0];
    for (uint32_t strip = 1; strip < strips; ++strip) {
        const uint32_t here = std::min(stripRows, rows - strip * stripRows);
        sum = adler32_combine(sum, sums[strip], z_off_t(here * rowBytes));
    }
    for (int shift = 24; shift >= 0; shift -= 8) pieces.back().push_back(std::byte(sum >> shift & 255u));
    return pieces;
}

}  // namespace plumb
