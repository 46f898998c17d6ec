// SPDX-License-Identifier: MIT
// The report stays one small file whatever goes in. What a reader sees of it is tested in a browser (tests/browser).
#include "pipeline/report/report.h"

#include <gtest/gtest.h>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb {
namespace {

using Json = nlohmann::ordered_json;

ReportPicture noise(const std::string& choice, uint32_t width, uint32_t height, uint32_t seed) {
    ReportPicture p{"axis", choice, width, height, {}};
    for (uint32_t i = 0; i < width * height; ++i) {
        seed = seed * 1664525u + 1013904223u;
        p.rgba.push_back(seed >> 8 | 0xff000000u);
    }
    return p;
}

Json rowsOf(size_t count) {
    Json m = {{"schema", "plumb-measure-1"}, {"rows", Json::array()}};
    for (size_t i = 0; i < count; ++i) m["rows"].push_back({{"axis", "axis"}, {"choice", std::to_string(i)}, {"onFront", i == 7}});
    return m;
}

Json shownBy(const std::string& html) {
    const std::string mark = "<script type=\"application/json\" id=\"pictures\">";
    const size_t at = html.find(mark) + mark.size();
    return Json::parse(html.substr(at, html.find("</script>", at) - at));
}

TEST(Report, StaysSmallAndSaysWhatIsLeftOut) {
    std::vector<ReportPicture> pictures;
    for (uint32_t i = 0; i < 10; ++i) pictures.push_back(noise(std::to_string(i), 400, 300, i + 1));  // noise does not compress
    const std::string html = reportHtml(rowsOf(10), noise("", 400, 300, 99), pictures);
    EXPECT_LT(html.size(), kMostReportBytes);
    const Json shown = shownBy(html);
    EXPECT_TRUE(shown["of"].contains("axis/7")) << "the front comes first";
    EXPECT_GT(shown["leftOut"].size(), 0u);
    EXPECT_EQ(shown["of"].size() + shown["leftOut"].size(), 10u);
}

TEST(Report, KeepsOnePictureForRowsThatShareIt) {
    const std::vector<ReportPicture> pictures = {noise("0", 40, 30, 1), noise("1", 40, 30, 1), noise("2", 40, 30, 2)};
    const Json shown = shownBy(reportHtml(rowsOf(3), noise("", 40, 30, 9), pictures));
    EXPECT_EQ(shown["apart"].size(), 2u);
    EXPECT_EQ(shown["of"]["axis/0"], shown["of"]["axis/1"]);
    EXPECT_EQ(shown["every"], 1);
}

TEST(Report, ThinsLargePictures) {
    const Json shown =
        shownBy(reportHtml(rowsOf(0), ReportPicture{"", "", 1920, 1081, std::vector<uint32_t>(1920 * 1081, 0xff102030u)}, {}));
    EXPECT_EQ(shown["every"], 3);
    EXPECT_EQ(shown["size"], Json({640, 361}));
}

TEST(Report, HoldsNoMarkThatWouldEndItsScript) {
    Json m = rowsOf(1);
    m["context"] = {{"cpu", "</script><!-- \xff"}};  // and bytes that are not UTF-8
    const std::string html = reportHtml(m, noise("", 8, 8, 1), {});
    EXPECT_EQ(html.find("</script><!--"), html.npos);
    EXPECT_NE(html.find("\\u003c/script>\\u003c!--"), html.npos);
    EXPECT_EQ(html.find("{{"), html.npos);
}

}  // namespace
}  // namespace plumb
