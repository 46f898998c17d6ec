// SPDX-License-Identifier: MIT
// Cull, set-up and clip: three kernels that answer one question.
#include "tests/twin/pass_frame.h"

#include "pipeline/passes/cull.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb::test {
namespace {

class CullTwin : public SceneRows {};

TEST_P(CullTwin, LeavesTheSameRecordsDrawsAndCorners) {
    for (bool cullBackFaces : {false, true}) {
        SCOPED_TRACE(cullBackFaces ? "back faces culled" : "back faces drawn");
        Scene scene = GetParam().scene();
        scene.cullBackFaces = cullBackFaces;
        for (Shading shading : {Shading::phong, Shading::gouraud}) {
            PassFrame f(device(), scene, requestOf(GetParam(), shading));
            const size_t vertices = f.p.list.positions.size();
            f.frame.upload(f.p.list);
            f.frame.transformAndCull(false);
            expectSame<gpu::ScreenVertex>("transform: vertex", std::span(f.twin.screen).first(vertices), f.frame.screen().first(vertices));
            expectSame<glm::vec4>("attributes of vertex", std::span(f.twin.attributes).first(vertices),
                                  f.frame.attributes().first(vertices));
            expectSame<gpu::CullRecord>("cull: 32 triangles", f.twin.records, f.frame.records().first(f.twin.records.size()));
            f.setup();
            expectSame<gpu::DrawTriangle>("setup: drawn triangle", f.twin.draws, f.frame.draws().first(f.twin.draws.size()));
            std::vector<gpu::ScreenVertex> want, got;
            std::vector<glm::vec4> wantAttributes, gotAttributes;
            size_t drawn = 0;
            for (const gpu::DrawTriangle& d : f.twin.draws) {
                if (d.vertex[0] == d.vertex[1]) continue;
                ++drawn;
                for (uint32_t v : d.vertex)
                    if (v >= vertices) {
                        want.push_back(f.twin.screen[v]);
                        got.push_back(f.frame.screen()[v]);
                        wantAttributes.push_back(f.twin.attributes[v]);
                        gotAttributes.push_back(f.frame.attributes()[v]);
                    }
            }
            expectSame<gpu::ScreenVertex>("clip: corner", want, got);
            expectSame<glm::vec4>("clip: attributes of corner", wantAttributes, gotAttributes);
            EXPECT_EQ(drawn, f.frame.slots().drawn + f.frame.clippedDrawn()) << "the counters of drawn triangles";
            EXPECT_GT(drawn, 0u) << "nothing is drawn: this row shows nothing";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, CullTwin, ::testing::ValuesIn(sceneCases()), [](const auto& info) { return nameOf(info.param); });

// The rows reach what they are meant to reach; a row that stops doing so is found here and not in a quiet loss of cover.
TEST(CullRows, ReachEveryClass) {
    gpu::CullRecord all{};
    uint32_t small = 0;
    uint32_t outcodes = 0, corners = 0;
    bool wideClip = false;
    for (const SceneCase& c : sceneCases()) {
        Scene scene = c.scene();
        scene.cullBackFaces = true;
        const Prepared p = prepare(scene, requestOf(c));
        const TwinGeometry g = twinGeometry(p.list, p.choices, false, 1);
        for (const gpu::CullRecord& r : g.records) {
            all.drawn |= r.drawn;
            all.clip |= r.clip;
            all.large |= r.large;
            all.wide |= r.wide;
            all.backFacing |= r.backFacing;
            all.zeroArea |= r.zeroArea;
            all.outside |= r.outside;
            all.medium |= r.medium;
            small |= r.drawn & ~(r.large | r.wide | r.medium);
        }
        for (const gpu::ScreenVertex& s : std::span(g.screen).first(p.list.positions.size())) outcodes |= s.outcode;
        for (uint32_t kind : g.clipKinds) {
            corners = std::max(corners, kind >> 1);
            wideClip |= (kind & 1) != 0;
        }
    }
    EXPECT_NE(all.drawn, 0u);
    EXPECT_NE(all.clip, 0u);
    EXPECT_NE(all.large, 0u);
    EXPECT_NE(all.wide, 0u);
    EXPECT_NE(all.backFacing, 0u);
    EXPECT_NE(all.zeroArea, 0u);
    EXPECT_NE(all.outside, 0u);
    EXPECT_NE(all.medium, 0u);
    EXPECT_NE(small, 0u);
    EXPECT_EQ(outcodes, (1u << gpu::kClipPlanes) - 1u) << "some plane has no vertex outside it";
    EXPECT_GE(corners, 3u) << "no triangle is clipped at three planes";
    EXPECT_TRUE(wideClip) << "no clipped triangle needs the wide set-up";
}

}  // namespace
}  // namespace plumb::test
