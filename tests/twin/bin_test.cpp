// SPDX-License-Identifier: MIT
#include "tests/twin/pass_frame.h"

#include <algorithm>

namespace plumb::test {
namespace {

// Returns how many entries there are.
size_t expectSameLists(PassFrame& f) {
    const TileLists want = binCpu(f.frame.binPush(), f.twin.draws, f.twin.screen);
    const uint32_t tilesX = f.frame.binPush().tilesX;
    expectSame<uint32_t>("bin: entries", want.counts, f.frame.tileCounts(), [&](size_t i) { return fmt::format("tile ({}, {})", i % tilesX, i / tilesX); });
    std::vector<uint32_t> got(f.frame.entries().begin(), f.frame.entries().begin() + ptrdiff_t(f.frame.binEntries()));
    EXPECT_EQ(got.size(), want.entries.size());
    if (got.size() != want.entries.size()) return 0;
    for (size_t first = 0, t = 0; t < want.counts.size(); first += want.counts[t++])
        std::sort(got.begin() + ptrdiff_t(first), got.begin() + ptrdiff_t(first + want.counts[t]));
    expectSame<uint32_t>("bin: list", want.entries, got);
    return got.size();
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

// The whole frame as one band, begun before the set-up, which then counts the small triangles.
TEST_P(BinTwin, ListsWhatTheSetUpHasCounted) {
    for (bool cullBackFaces : {false, true}) {
        SCOPED_TRACE(cullBackFaces ? "back faces culled" : "back faces drawn");
        Scene scene = GetParam().scene();
        scene.cullBackFaces = cullBackFaces;
        PassFrame f(device(), scene, requestOf(GetParam()));
        f.frame.beginBand(f.band(0, int(GetParam().height)), kPassPlanes);
        f.setup();
        ASSERT_TRUE(f.frame.counted()) << "nothing was counted: this shows nothing";
        f.frame.bin();
        f.frame.recorder().run(kWatchdogMs);
        EXPECT_GT(expectSameLists(f), 0u) << "no list has an entry: this row shows nothing";
        // What was counted is good for one list: the next band counts again.
        EXPECT_FALSE(f.frame.counted());
        f.frame.bin();
        f.frame.recorder().run(kWatchdogMs);
        EXPECT_GT(expectSameLists(f), 0u);
    }
}

class BinLarge : public OnDevice<::testing::Test> {};

// So many large triangles that the low ones among them are binned apart from the tall ones.
TEST_F(BinLarge, LowAndTallAreListedAlike) {
    const SceneCase one{"large", [](View v) { return soup(v, 17, 900, 150); }, 640, 480};
    PassFrame f(device(), one.scene(), requestOf(one));
    for (int rows : {480, 200}) {
        f.frame.beginBand(f.band(0, rows), kPassPlanes);
        f.setup();
        EXPECT_GT(f.frame.lowTriangles(), 100u) << "hardly any is low: this shows nothing";
        EXPECT_GT(f.frame.places().large.size() - f.frame.lowTriangles(), 100u) << "hardly any is tall: this shows nothing";
        for (int firstRow = 0; firstRow < 480; firstRow += rows) {
            if (firstRow != 0) f.frame.beginBand(f.band(firstRow, rows), kPassPlanes);
            f.frame.bin();
            f.frame.recorder().run(kWatchdogMs);
            EXPECT_GT(expectSameLists(f), 0u);
        }
    }
}

class BinCrowd : public OnDevice<::testing::Test> {};

// More triangles in a tile than a slot can number: the bin pass counts them anew.
TEST_F(BinCrowd, IsCountedAnew) {
    const SceneCase one{"crowd", [](View v) { return soup(v, 9, 400000, 4); }, 16, 8};
    PassFrame f(device(), one.scene(), requestOf(one));
    f.frame.beginBand(f.band(0, 8), kPassPlanes);
    f.setup();
    ASSERT_TRUE(f.frame.counted());
    f.frame.bin();
    f.frame.recorder().run(kWatchdogMs);
    EXPECT_GT(expectSameLists(f), gpu::kSlotTiles) << "the tile is not crowded: this shows nothing";
}

// Whoever owns a pixel is in its tile's list: the exact coverage of the fill against the bin's own rule.
TEST_P(BinTwin, MissesNoOwner) {
    const Prepared p = prepare(GetParam().scene(), requestOf(GetParam()));
    const TwinGeometry g = twinGeometry(p.list, p.choices, false, 1, nullptr);
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
