// SPDX-License-Identifier: MIT
// Fields, stereo and separations: what is taken apart is what was there.
#include "pipeline/image/arrange.h"
#include "pipeline/image/image.h"
#include "pipeline/scene/colour.h"
#include "tests/support/compare.h"
#include "tests/support/temporary_folder.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

// Every plane, every value another one; every fifth pixel is empty.
Frame frameOf(uint32_t width, uint32_t height, uint32_t salt = 0) {
    Frame f;
    f.width = width;
    f.height = height;
    for (uint32_t i = 0; i < width * height; ++i) {
        const uint32_t v = (i + salt) * 2654435761u;
        const float x = float(v >> 8) * 0x1p-24f;
        f.rgba.push_back(v | 0xff000000u);
        for (int c = 0; c < 3; ++c) f.linear.push_back(x + float(c)), f.normal.push_back(x - float(c));
        f.depth.push_back(x * 2);
        f.distance.push_back(x * 3);
        f.z.push_back(x * 4);
        f.object.push_back(i % 5 == 0 ? 0xffffffffu : i);
        f.primitive.push_back(v ^ 1u);
        f.triangle.push_back(v ^ 2u);
        f.coveredPixels += i % 5 != 0;
    }
    return f;
}

TEST(Fields, TwoFieldsAreTheProgressivePicture) {
    for (const auto& [width, height] : {std::pair(19u, 7u), std::pair(16u, 8u), std::pair(1u, 2u), std::pair(5u, 3u)}) {
        const Frame whole = frameOf(width, height);
        const Frame odd = fieldOf(whole, Field::odd), even = fieldOf(whole, Field::even);
        EXPECT_EQ(odd.height, (height + 1) / 2);
        EXPECT_EQ(even.height, height / 2);
        EXPECT_EQ(odd.rgba[0], whole.rgba[0]) << "line 1 is the topmost, and odd";
        EXPECT_EQ(even.rgba[0], whole.rgba[width]) << "line 2";
        expectSameFrame(whole, interlaced(odd, even));
    }
}

TEST(Columns, AreThoseOfEveryPlane) {
    const Frame whole = frameOf(19, 7), part = columnsOf(whole, 4, 11);
    ASSERT_EQ(part.width, 11u);
    uint64_t covered = 0;
    for (uint32_t y = 0; y < 7; ++y)
        for (uint32_t x = 0; x < 11; ++x) {
            const size_t at = y * 11 + x, from = y * 19 + x + 4;
            EXPECT_EQ(part.rgba[at], whole.rgba[from]);
            EXPECT_EQ(part.linear[3 * at + 2], whole.linear[3 * from + 2]);
            EXPECT_EQ(part.object[at], whole.object[from]);
            EXPECT_EQ(part.triangle[at], whole.triangle[from]);
            covered += whole.object[from] != 0xffffffffu;
        }
    EXPECT_EQ(part.coveredPixels, covered);
    expectSameFrame(whole, columnsOf(whole, 0, 19));
}

TEST(Anaglyph, TakesRedFromTheLeftAndTheRestFromTheRight) {
    const Frame left = frameOf(9, 4), right = frameOf(9, 4, 77), both = anaglyphOf(left, right);
    for (size_t i = 0; i < both.rgba.size(); ++i) {
        EXPECT_EQ(both.rgba[i] & 0xffu, left.rgba[i] & 0xffu);
        EXPECT_EQ(both.rgba[i] >> 8, right.rgba[i] >> 8);
        EXPECT_EQ(both.linear[3 * i], left.linear[3 * i]);
        EXPECT_EQ(both.linear[3 * i + 1], right.linear[3 * i + 1]);
        EXPECT_EQ(both.linear[3 * i + 2], right.linear[3 * i + 2]);
    }
    expectSamePlane("an eye with itself", 9, 1, left.rgba, anaglyphOf(left, left).rgba);
}

TEST(Separations, AreThePictureTakenApart) {
    const Frame whole = frameOf(64, 33);
    std::vector<Frame> cmy, cmyk;
    for (size_t ink = 0; ink < namesOf(Inks::cmy).size(); ++ink) cmy.push_back(separationOf(whole, Inks::cmy, ink));
    for (size_t ink = 0; ink < namesOf(Inks::cmyk).size(); ++ink) cmyk.push_back(separationOf(whole, Inks::cmyk, ink));
    ASSERT_EQ(cmyk.size(), 4u);
    for (size_t i = 0; i < whole.rgba.size(); ++i) {
        const auto amount = [i](const Frame& f) { return uint8_t(f.rgba[i]); };
        const Rgb8 rgb = {uint8_t(whole.rgba[i]), uint8_t(whole.rgba[i] >> 8), uint8_t(whole.rgba[i] >> 16)};
        EXPECT_EQ(rgbFromCmyk(Cmyk8{amount(cmyk[0]), amount(cmyk[1]), amount(cmyk[2]), amount(cmyk[3])}), rgb);
        EXPECT_EQ(rgbFromCmyk(Cmyk8{amount(cmy[0]), amount(cmy[1]), amount(cmy[2]), 0}), rgb);
        EXPECT_EQ(cmyk[0].rgba[i] >> 24, 255u);
        EXPECT_EQ(cmyk[0].rgba[i] & 0xffu, (cmyk[0].rgba[i] >> 16) & 0xffu) << "grey";
    }
}

TEST(Separations, AGreyPngHoldsTheAmounts) {
    const TemporaryFolder folder;
    const Frame ink = separationOf(frameOf(21, 5), Inks::cmyk, 3);
    WriteOptions options;
    options.grey = true;
    writeFrame(folder.path() / "black.png", ink, kPlaneColour, options, {});
    const Frame back = readPng(folder.path() / "black.png");
    expectSamePlane("amounts", 21, 1, ink.rgba, back.rgba);
    const std::vector<std::byte> bytes = encodePng(ink, options, {});
    EXPECT_EQ(int(bytes[25]), 0) << "colour type grey";
    EXPECT_EQ(int(bytes[24]), 8) << "bits";
}

}  // namespace
}  // namespace plumb::test
