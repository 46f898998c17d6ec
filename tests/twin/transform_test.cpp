// SPDX-License-Identifier: MIT
#include "pipeline/passes/transform.h"

#include "host/binary64.h"
#include "pipeline/passes/long_rows.h"

#include "tests/twin/pass_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <ostream>
#include <span>
#include <vector>

namespace plumb::test {
namespace {

struct Row {
    const char* name;
    uint32_t first, count;  // vertices of the dispatch, within as many more before it
    bool normals;
};
std::ostream& operator<<(std::ostream& out, const Row& r) { return out << r.name; }

class TransformTwin : public OnDevice<::testing::TestWithParam<Row>> {};

// Beside random points: in the eye's plane, behind it, exactly on the near plane and on every guard plane, on ties of the snap
// (an odd number of half sub-pixels) and one ULP beside them, and as far as an object matrix allows.
std::vector<glm::vec4> pointsFor(View v, uint32_t count) {
    Random r(29);
    const double guardX = v.width / 2.0 + 8192, guardY = v.height / 2.0 + 8192;
    std::vector<glm::vec4> points;
    const auto add = [&](glm::vec3 p) { points.emplace_back(p, 1.0f); };
    for (double w : {-1.0, 0.0, 0.125, 0.25, 1.0, 4.0}) add({0.5f, -0.25f, float(-w)});
    add({0.5f, 0.5f, std::nextafter(-float(kNear), 0.0f)});
    add({0.5f, 0.5f, std::nextafter(-float(kNear), -1.0f)});
    for (double side : {-1.0, 1.0}) {
        add(v.pointAt(v.width / 2.0 + side * guardX, 3, 2));
        add(v.pointAt(3, v.height / 2.0 + side * guardY, 2));
        add({float(side * 0x1p60), 1, -1});
    }
    for (int half = -9; half <= 9; half += 2) {
        const glm::vec3 p = v.pointAt(40 + half * kSubpixel / 2, 20 - half * kSubpixel / 2, 1);
        add(p);
        add({std::nextafter(p.x, 10.0f), std::nextafter(p.y, 10.0f), p.z});
        add({std::nextafter(p.x, -10.0f), std::nextafter(p.y, -10.0f), p.z});
    }
    while (points.size() < count) add({float(r(-20, 20)), float(r(-20, 20)), float(r(-30, 3))});
    return points;
}

TEST_P(TransformTwin, LeavesTheSameBytes) {
    const Row& row = GetParam();
    const SceneCase c{"soupSmall", soupSmall, 131, 67};
    const DrawList list = prepare(c.scene(), requestOf(c)).list;
    const uint32_t total = row.first + row.count;
    const std::vector<glm::vec4> positions = pointsFor(c.view(), total);
    Random r(31);
    std::vector<glm::vec4> normals;
    for (size_t i = 0; i < positions.size(); ++i) normals.emplace_back(r.direction(), 0.0f);
    gpu::ObjectRecord turned = list.objects[0];
    turned.rowX = {200, 3.7f, -30, 1};
    turned.normal0 = {0.3f, -0.4f, 0.9f, 0};
    const std::vector<gpu::ObjectRecord> objects = {list.objects[0], turned};
    size_t visible = 0, cut = 0;
    for (uint32_t object = 0; object < objects.size(); ++object) {
        const gpu::TransformPush push{0, row.first, row.count, object, list.viewport};
        // Rows with normals write them both ways, in turn.
        const Normals writtenNormals = !row.normals ? Normals::none : object == 0 ? Normals::direction : Normals::unit;
        std::vector<gpu::ScreenVertex> screen(total);
        std::vector<glm::vec4> attributes(total);
        transformCpu(push, writtenNormals, positions, normals, objects, screen, attributes, 1);
        for (const gpu::ScreenVertex& s : std::span(screen).subspan(row.first)) ++(s.outcode == 0 ? visible : cut);
        for (const Specialization& exact : exactForms(device())) {
            Recorder recorder(device());
            auto p = bufferOf(device(), positions), n = bufferOf(device(), normals);
            auto o = bufferOf(device(), objects);
            Buffer<gpu::ScreenVertex> gotScreen(device(), total + kSentinels, "screen");
            Buffer<glm::vec4> gotAttributes(device(), total + kSentinels, "attributes");
            gotScreen.fill(kSentinel);
            gotAttributes.fill(kSentinel);
            recordTransform(recorder, push, writtenNormals, exact, p, n, o, gotScreen, gotAttributes);
            recorder.run(kWatchdogMs);
            expectSame<gpu::ScreenVertex>("transform: vertex", std::span(screen).subspan(row.first),
                                          gotScreen.span().subspan(row.first, row.count));
            if (row.normals)
                expectSame<glm::vec4>("transform: normal", std::span(attributes).subspan(row.first),
                                      gotAttributes.span().subspan(row.first, row.count));
            expectSentinels("transform: vertices", gotScreen, total);
            expectSentinels("transform: normals", gotAttributes, row.normals ? total : 0);
        }
    }
    EXPECT_GT(visible, 0u);
    EXPECT_TRUE(cut > 0 || row.count == 1);
}

// The more accurate transforms, of the same points: a composite that is turned, and one that is not.
TEST_P(TransformTwin, LeavesTheSameBytesInLongNumbers) {
    const Row& row = GetParam();
    const SceneCase c{"soupSmall", soupSmall, 131, 67};
    const DrawList list = prepare(c.scene(), requestOf(c)).list;
    const uint32_t total = row.first + row.count;
    std::vector<glm::vec4> positions = pointsFor(c.view(), total);
    double reach = 0;
    for (glm::vec4& p : positions) {
        if (std::abs(p.x) > 1e6f) p.x = 1e6f;  // coordinates are within the object's reach
        reach = std::max({reach, std::abs(double(p.x)), std::abs(double(p.y)), std::abs(double(p.z))});
    }
    const std::vector<glm::vec4> normals(positions.size(), glm::vec4(0.6f, 0, 0.8f, 0));
    const int exponent = blockExponent(reach);
    std::vector<gpu::LongRecord> longs;
    for (const glm::dvec4& x : {glm::dvec4(list.objects[0].rowX), glm::dvec4(200.123456789, 3.7, -30.03, 1.00000001)})
        longs.push_back({longRow(x, exponent), longRow(glm::dvec4(list.objects[0].rowY), exponent), longRow({0, 0, -1, 1e-12}, exponent),
                         float(std::ldexp(1.0, -exponent))});
    const std::vector<gpu::ObjectRecord> objects(2, list.objects[0]);
    EXPECT_EQ(lacksBinary64(device()), "") << "lavapipe has it";
    for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
        size_t visible = 0;
        for (uint32_t object = 0; object < objects.size(); ++object) {
            const gpu::TransformPush push{0, row.first, row.count, object, list.viewport};
            const Normals writtenNormals = row.normals ? Normals::direction : Normals::none;
            std::vector<gpu::ScreenVertex> screen(total);
            std::vector<glm::vec4> attributes(total), clip(total);
            transformCpu(push, writtenNormals, positions, normals, objects, screen, attributes, 1, {precision, longs, clip});
            for (const gpu::ScreenVertex& s : std::span(screen).subspan(row.first)) visible += s.outcode == 0;
            for (const Specialization& exact : exactForms(device())) {
                Recorder recorder(device());
                auto p = bufferOf(device(), positions), n = bufferOf(device(), normals);
                auto o = bufferOf(device(), objects);
                auto l = bufferOf(device(), longs);
                Buffer<gpu::ScreenVertex> gotScreen(device(), total + kSentinels, "screen");
                Buffer<glm::vec4> gotAttributes(device(), total + kSentinels, "attributes"), gotClip(device(), total + kSentinels, "clip");
                gotScreen.fill(kSentinel);
                gotAttributes.fill(kSentinel);
                gotClip.fill(kSentinel);
                recordLongTransform(recorder, device(), push, writtenNormals, exact, p, n, o, gotScreen, gotAttributes,
                                    {precision, l, gotClip});
                recorder.run(kWatchdogMs);
                expectSame<gpu::ScreenVertex>("transform: vertex", std::span(screen).subspan(row.first),
                                              gotScreen.span().subspan(row.first, row.count));
                expectSame<glm::vec4>("transform: clip space", std::span(clip).subspan(row.first),
                                      gotClip.span().subspan(row.first, row.count));
                if (row.normals)
                    expectSame<glm::vec4>("transform: normal", std::span(attributes).subspan(row.first),
                                          gotAttributes.span().subspan(row.first, row.count));
                expectSentinels("transform: vertices", gotScreen, total);
                expectSentinels("transform: clip space", gotClip, total);
                expectSentinels("transform: normals", gotAttributes, row.normals ? total : 0);
            }
        }
        EXPECT_TRUE(visible > 0 || row.count == 1);
    }
}

INSTANTIATE_TEST_SUITE_P(Counts, TransformTwin,
                         ::testing::Values(Row{"one", 5, 1, true}, Row{"nineteen", 0, 19, true}, Row{"nineteen_from_7", 7, 19, false},
                                           Row{"sixty_three", 0, 63, true}, Row{"sixty_four", 0, 64, true}, Row{"sixty_five", 0, 65, false},
                                           Row{"many", 1, 70001, true}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace plumb::test
