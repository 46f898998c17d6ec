// SPDX-License-Identifier: MIT
#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <vector>

namespace plumb::test {
namespace {

// Returns how many entries there are.
size_t expectSameLists(PassFrame& f) {
    const TileLists want = binCpu(f.frame.binPush(), f.twin.draws, f.twin.screen);
    const uint32_t tilesX = f.frame.binPush().tilesX;
    const TileLists got = f.frame.lists();
    expectSame<uint32_t>("bin: entries", want.counts, got.counts,
                         [&](size_t i) { return fmt::format("tile ({}, {})", i % tilesX, i / tilesX); });
    EXPECT_EQ(got.entries.size(), want.entries.size());
    EXPECT_EQ(got.entries.size(), f.frame.binEntries());
    if (got.entries.size() != want.entries.size()) return 0;
    expectSame<uint32_t>("bin: list", want.entries, got.entries);
    return got.entries.size();
}

class BinTwin : public SceneRows {};

TEST_P(BinTwin, ListsTheSameSets) {
    PassFrame f(device(), GetParam().scene(), requestOf(GetParam()));
    f.takeTwin();
    size_t listed = 0;
    for (int bandRows : {8, 24, int(GetParam().height)}) {
        for (int firstRow = 0; firstRow < int(GetParam().height); firstRow += bandRows) {
            SCOPED_TRACE(fmt::format("rows {} to {}", firstRow, firstRow + bandRows));
            f.frame.beginBand(f.band(firstRow, bandRows), kPassPlanes);
            f.frame.bin();
            f.frame.recorder().run(kWatchdogMs);
            listed += expectSameLists(f);
        }
    }
    EXPECT_GT(listed, 0u) << "no list has an entry: this row shows nothing";
}

// The whole frame as one band, begun before the set-up, which then bins the small triangles.
TEST_P(BinTwin, ListsWhatTheSetUpHasBinned) {
    for (bool cullBackFaces : {false, true}) {
        SCOPED_TRACE(cullBackFaces ? "back faces culled" : "back faces drawn");
        Scene scene = GetParam().scene();
        scene.cullBackFaces = cullBackFaces;
        PassFrame f(device(), scene, requestOf(GetParam()));
        f.frame.beginBand(f.band(0, int(GetParam().height)), kPassPlanes);
        f.setup();
        ASSERT_TRUE(f.frame.binned()) << "nothing was binned: this shows nothing";
        f.frame.bin();
        f.frame.recorder().run(kWatchdogMs);
        EXPECT_GT(expectSameLists(f), 0u) << "no list has an entry: this row shows nothing";
        // What was binned is good for one list: the next band bins again.
        EXPECT_FALSE(f.frame.binned());
        f.frame.bin();
        f.frame.recorder().run(kWatchdogMs);
        EXPECT_GT(expectSameLists(f), 0u);
    }
}

struct BinCase {
    const char* name;
    SceneCase scene;
    bool strips, walked, wide;  // what the row is there to show
};

class BinOverflow : public OnDevice<::testing::TestWithParam<BinCase>> {};

// Tiles that have room for a few of their entries, of each kernel: the host completes the lists. Bands, and the frame as one.
TEST_P(BinOverflow, AreListedWhole) {
    const BinCase& c = GetParam();
    for (uint32_t room : {1u, 5u})
        for (int rows : {int(c.scene.height), int(c.scene.height) / 16 * 8}) {
            SCOPED_TRACE(fmt::format("bands of {} rows, room for {}", rows, room));
            PassFrame f(device(), c.scene.scene(), requestOf(c.scene));
            f.frame.limitRoom(room);
            size_t strips = 0, overflowed = 0;
            for (int firstRow = 0; firstRow < int(c.scene.height); firstRow += rows) {
                f.frame.beginBand(f.band(firstRow, rows), kPassPlanes);
                if (firstRow == 0) f.setup();
                EXPECT_EQ(f.frame.binned(), rows == int(c.scene.height));
                f.frame.bin();
                EXPECT_GT(expectSameLists(f), 0u);
                strips += f.frame.stripCount();
                overflowed += f.frame.overflowedTiles();
            }
            EXPECT_GE(overflowed, 4u) << "hardly any tile is overflowed: this shows nothing";
            if (c.strips) {
                EXPECT_GE(strips, 100u) << "hardly any strip: this shows nothing";
            }
            if (c.walked) {
                EXPECT_GE(f.frame.slots().medium.size(), 2048u) << "none is walked: this shows nothing";
            }
            EXPECT_EQ(f.frame.slots().wide, c.wide);
        }
}

// soup(): triangles of about so many pixels all over the frame.
INSTANTIATE_TEST_SUITE_P(
    Scenes, BinOverflow,
    ::testing::Values(BinCase{"Strips", {"large", [](View v) { return soup(v, 17, 900, 150); }, 640, 480}, true, false, false},
                      BinCase{"LongStrips", {"long", [](View v) { return soup(v, 21, 60, 900); }, 4096, 64}, true, false, false},
                      BinCase{"WideStrips", {"wide", [](View v) { return soup(v, 8, 60, 6000); }, 4096, 96}, true, false, true},
                      BinCase{"Medium", {"medium", [](View v) { return soup(v, 5, 12000, 40); }, 320, 240}, false, true, false},
                      BinCase{"Small", {"small", [](View v) { return soup(v, 3, 12000, 6); }, 512, 96}, false, false, false}),
    [](const auto& info) { return info.param.name; });

// Whoever owns a pixel is in its tile's list: the exact coverage of the fill against the bin's own rule.
TEST_P(BinTwin, MissesNoOwner) {
    const Prepared p = prepare(GetParam().scene(), requestOf(GetParam()));
    const TwinGeometry g = twinGeometry(p.list, p.choices, false, 1);
    gpu::BinPush push{};
    push.tilesX = (GetParam().width + 15) / 16;
    push.tilesY = (GetParam().height + 7) / 8;
    push.firstClippedVertex = uint32_t(p.list.positions.size());
    push.frame = p.list.frame;
    const TileLists lists = binCpu(push, g.draws, g.screen);
    const size_t pixels = size_t(GetParam().width) * GetParam().height;
    std::vector<int> z(pixels);
    std::vector<uint32_t> draw(pixels), first(lists.counts.size() + 1);
    fillCpu(p.list.frame, g.draws, g.screen, z, draw, 1);
    for (size_t t = 0; t < lists.counts.size(); ++t) first[t + 1] = first[t] + lists.counts[t];
    size_t owned = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (!draw[i]) continue;
        ++owned;
        const size_t x = i % GetParam().width, y = i / GetParam().width, tile = y / 8 * push.tilesX + x / 16;
        ASSERT_TRUE(std::binary_search(lists.entries.begin() + first[tile], lists.entries.begin() + first[tile + 1], draw[i] - 1))
            << "pixel (" << x << ", " << y << ") belongs to draw " << draw[i] - 1 << ", which the list of its tile lacks";
    }
    EXPECT_GT(owned, 0u);
}

INSTANTIATE_TEST_SUITE_P(Scenes, BinTwin, ::testing::ValuesIn(sceneCases()), [](const auto& info) { return nameOf(info.param); });

}  // namespace
}  // namespace plumb::test
