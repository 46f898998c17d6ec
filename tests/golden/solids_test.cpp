// SPDX-License-Identifier: MIT
// Sections 11 to 14: vectors, visibility, the fill table and its lines, projection. In binary64, by the product's own functions where it has the
// step: unit vectors, normals and culling of polygons, Zps and whole pixels of the notes' projection, dot products of rays in float32.
#include "pipeline/render/notes/polygons.h"
#include "pipeline/render/notes/projection.h"
#include "pipeline/transform/vector.h"
#include "shaders/shared/ray.h"
#include "tests/golden/golden.h"
#include "tests/golden/notes_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <initializer_list>
#include <numbers>
#include <string>
#include <vector>

namespace plumb::golden {
namespace {

using glm::dvec2;
using glm::dvec3;

double dot(const Json& p, const Json& q) { return glm::dot(vectorOf<dvec3>(p), vectorOf<dvec3>(q)); }
double degreesBetween(const dvec3& p, const dvec3& q) { return std::acos(glm::dot(unitVector(p), unitVector(q))) * 180 / std::numbers::pi; }

GOLDEN(s113_scalar_times_vector) { e.binary64("result", jsonOf(e.input("a").get<double>() * vectorOf<dvec2>(e.input("V")))); }
GOLDEN(s114_vector_sum) {
    const dvec2 p = vectorOf<dvec2>(e.input("P")), q = vectorOf<dvec2>(e.input("Q"));
    e.binary64("sum", jsonOf(p + q));
    e.binary64("difference", jsonOf(p - q));
}
GOLDEN(s116_magnitude_2d) { e.binary64("magnitude", magnitude(vectorOf<dvec2>(e.input("V")))); }
GOLDEN(s116_magnitude_3d) {
    const dvec3 v = vectorOf<dvec3>(e.input("V"));
    e.binary64("magnitude", magnitude(v));
    e.binary64("magnitude_with_2sqrt3", magnitude(dvec3(v.x, 2 * std::sqrt(3.0), v.z)));
    e.binary64("projection_on_YZ", magnitude(dvec2(v.y, v.z)));
}
GOLDEN(s117_unit_2d) { e.binary64("unit", jsonOf(unitVector(vectorOf<dvec2>(e.input("V"))))); }
GOLDEN(s117_unit_3d) { e.binary64("unit", jsonOf(unitVector(vectorOf<dvec3>(e.input("V"))))); }
GOLDEN(s118_magnitude_scaling) {
    const double a = e.input("a").get<double>();
    const dvec2 p = vectorOf<dvec2>(e.input("P"));
    e.binary64("lhs", magnitude(a * p));
    e.binary64("rhs", std::abs(a) * magnitude(p));
    e.binary64("negative_a", magnitude(-a * p));
}
void dotSign(Entry& e) {
    e.binary64("dot", dot(e.input("P"), e.input("Q")));
    e.float32("dot", gpu::dot3(glm::vec3(vectorOf<dvec3>(e.input("P"))), glm::vec3(vectorOf<dvec3>(e.input("Q")))));
    e.binary64("angle_deg", degreesBetween(vectorOf<dvec3>(e.input("P")), vectorOf<dvec3>(e.input("Q"))));
}
GOLDEN(s1192_dot_perpendicular) { dotSign(e); }
GOLDEN(s1192_dot_acute) { dotSign(e); }
GOLDEN(s1192_dot_obtuse) { dotSign(e); }
// Normal of the polygon 0, P, Q by the product: P x Q.
GOLDEN(s1110_cross) {
    const dvec3 n = newellOf(std::array{dvec3(0), vectorOf<dvec3>(e.input("P")), vectorOf<dvec3>(e.input("Q"))}).normal;
    e.binary64("cross", jsonOf(n));
    e.binary64("magnitude", magnitude(n));
    e.binary64("unit", jsonOf(unitVector(n)));
}

void visibility(Entry& e) {
    const dvec3 p0 = vectorOf<dvec3>(e.input("P0")), p = vectorOf<dvec3>(e.input("P1")) - p0, q = vectorOf<dvec3>(e.input("P2")) - p0,
                viewpoint = vectorOf<dvec3>(e.input("viewpoint"));
    const Newell polygon = newellOf(std::array{p0, p0 + p, p0 + q});
    const dvec3 n = polygon.normal, unit = unitVector(n);
    const double d = glm::dot(unit, p0), result = glm::dot(unit, viewpoint) - d;
    for (const char* name : {"P", "P_second_table"}) e.binary64(name, jsonOf(p));
    for (const char* name : {"Q", "Q_second_table"}) e.binary64(name, jsonOf(q));
    e.binary64("N", jsonOf(n));
    e.binary64("N_magnitude", magnitude(n));
    e.binary64("N_unit", jsonOf(unit));
    e.binary64("D", d);
    e.binary64("result", result);
    EXPECT_EQ(result > 0, e.data("visible").get<bool>());
    EXPECT_EQ(polygon.faces(viewpoint - p0, false), e.data("visible").get<bool>()) << "by the product's cull";
    EXPECT_EQ(polygon.faces(viewpoint - p0, true), !e.data("visible").get<bool>()) << "a mirror turns the polygon around";
}
GOLDEN(s12_pyramid_front) { visibility(e); }
GOLDEN(s12_pyramid_back) { visibility(e); }
GOLDEN(s12_pyramid_left) { visibility(e); }
GOLDEN(s12_pyramid_right) { visibility(e); }
GOLDEN(s12_pyramid_base) { visibility(e); }
GOLDEN(s123_edge_on) {
    const dvec3 n = vectorOf<dvec3>(e.input("N_unnormalised"));
    const double value = glm::dot(n, vectorOf<dvec3>(e.input("viewpoint"))) - glm::dot(n, vectorOf<dvec3>(e.input("P0")));
    e.exactly("N.V-D_integer", value);
    const Newell polygon{n, glm::abs(n)};
    e.exactly("visible", polygon.faces(vectorOf<dvec3>(e.input("viewpoint")) - vectorOf<dvec3>(e.input("P0")), false) ? 1 : 0);
}

std::vector<NotesCorner> cornersOf(const Entry& e, std::initializer_list<const char*> names) {
    std::vector<NotesCorner> polygon;
    for (const char* name : names) {
        const Json& v = e.input(name);
        polygon.push_back({v[0].get<double>(), v[1].get<double>(), {}});
        if (v.size() > 2) polygon.back().values.push_back(v[2].get<double>());
    }
    return polygon;
}
// B before A: the order of the edges in the file is B-A, B-C, A-C.
std::vector<NotesCorner> theTriangle() { return cornersOf(Entry("s131_fill_table"), {"A", "B", "C"}); }

GOLDEN(s131_edge_slopes) {
    const dvec2 a = vectorOf<dvec2>(e.input("A")), b = vectorOf<dvec2>(e.input("B")), c = vectorOf<dvec2>(e.input("C"));
    e.binary64("slope_B-A", (b.y - a.y) / (b.x - a.x));
    e.binary64("slope_A-C", (a.y - c.y) / (a.x - c.x));
    EXPECT_EQ(b.x, c.x) << e.data("slope_B-C");
}
GOLDEN(s131_fill_table) {
    Json x = Json::array(), start = Json::array(), end = Json::array(), dx = Json::array();
    for (const NotesEdge& edge : notesFillTable(theTriangle()))
        x.push_back(edge.x), start.push_back(edge.yStart), end.push_back(edge.yEnd), dx.push_back(edge.dx);
    e.binary64("Xstart", x);
    e.binary64("Ystart", start);
    e.binary64("Yend", end);
    e.binary64("dX", dx);
}
GOLDEN(s131_first_fill_lines) {
    const std::vector<NotesLine> lines = notesLines(notesFillTable(theTriangle()), true);
    for (size_t y = 0; y < 3; ++y) {
        Json row = Json::array();
        for (double x = lines[y].leftX; x <= lines[y].rightX; ++x) row.push_back({x, lines[y].y});
        e.binary64("row" + std::to_string(y), row);
    }
    const Json& five = e.data("left_right_first_five_rows");
    for (size_t y = 0; y < five.size(); ++y) EXPECT_EQ(Json({lines[y].leftX, lines[y].rightX}), five[y]) << y;
}
void wholeTriangle(Entry& e, bool corrected) {
    const std::vector<NotesLine> lines = notesLines(notesFillTable(theTriangle()), corrected);
    int pixels = 0;
    Json spans = Json::array();
    for (const NotesLine& line : lines) {
        pixels += notesPixels(line);
        spans.push_back({int(line.y), int(line.leftX), int(line.leftX) + notesPixels(line) - 1});
    }
    e.exactly("pixel_count", pixels);
    e.exactly("rows", lines.size());
    EXPECT_EQ(spans, e.data("spans_y_x0_x1"));
}
GOLDEN(s132_fill_triangle_literal) { wholeTriangle(e, false); }
GOLDEN(s132_fill_triangle_corrected) {
    wholeTriangle(e, true);
    const std::vector<NotesCorner> t = theTriangle();
    e.binary64("area", std::abs((t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[2].x - t[0].x) * (t[1].y - t[0].y)) / 2);
    Json differ = Json::array();
    const auto table = notesFillTable(t);
    const auto literal = notesLines(table, false), corrected = notesLines(table, true);
    for (size_t i = 0; i < literal.size(); ++i)
        if (literal[i].leftX != corrected[i].leftX || literal[i].rightX != corrected[i].rightX) differ.push_back(int(literal[i].y));
    EXPECT_EQ(differ, e.data("rows_that_differ_from_literal"));
}

double projected(double value, double z, double d) { return d * value / (d + z); }
// A corner by the product's projection: the notes' viewer at (0, 0, -d) before a window of w x h. Empty behind the near plane.
struct Display {
    std::vector<gpu::ScanCorner> corners;
    double zps = 0;
    Display(const dvec3& vertex, double d, double w, double h) {
        Pinhole view;
        view.focal = d;
        view.near = d / 1024;
        view.right = {1, 0, 0};
        view.down = {0, -1, 0};
        view.forward = {0, 0, 1};
        view.eye = {0, 0, -d};
        view.width = w;
        view.height = h;
        corners = NotesProjection(view, d).display({{view.viewOf(vertex), glm::vec3(0)}});
        if (!corners.empty()) zps = std::ldexp(double(corners[0].z), std::ilogb(d));  // the fill's unit is a power of two
    }
};
GOLDEN(s142_zps_values) {
    Json all = Json::array();
    Json byProduct = Json::array();
    const double d = e.input("d").get<double>();
    for (const Json& z : e.input("z")) {
        all.push_back(projected(z.get<double>(), z.get<double>(), d));
        byProduct.push_back(Display({0, 0, z.get<double>()}, d, 400, 400).zps);
    }
    e.binary64("Zps", all);
    e.float32("Zps", byProduct);
}
GOLDEN(s142_max_distance) {
    const double d = e.input("d").get<double>();
    e.binary64("MaxDistance", d);
    e.binary64("Zps(1e6)", projected(1e6, 1e6, d));
    e.float32("Zps(1e6)", Display({0, 0, 1e6}, d, 400, 400).zps);
    EXPECT_LT(Display({0, 0, 1e6}, d, 400, 400).zps, d) << "MaxDistance is beyond every Zps";
    EXPECT_TRUE(Display({0, 0, -1000}, d, 400, 400).corners.empty()) << "behind the viewer: cut, not divided (A11)";
    e.binary64("Zps(-1000)_behind_viewer", projected(-1000, -1000, d));
}
void project(Entry& e) {
    const dvec3 v = vectorOf<dvec3>(e.input("vertex"));
    const double d = e.input("d").get<double>();
    const dvec3 p(projected(v.x, v.z, d), projected(v.y, v.z, d), projected(v.z, v.z, d));
    const dvec3 display(e.input("W").get<double>() / 2 + p.x, e.input("H").get<double>() / 2 - p.y, p.z);
    e.binary64("projected", jsonOf(p));
    e.binary64("display_unrounded", jsonOf(display));
    const Display drawn(v, d, e.input("W").get<double>(), e.input("H").get<double>());
    ASSERT_EQ(drawn.corners.size(), 1u);
    EXPECT_EQ(dvec2(drawn.corners[0].x, drawn.corners[0].y), dvec2(std::nearbyint(display.x), std::nearbyint(display.y)));
    e.float32("display_rounded", {drawn.corners[0].x, drawn.corners[0].y, drawn.zps});
    e.binary64("display_rounded", {std::nearbyint(display.x), std::nearbyint(display.y), display.z});
}
GOLDEN(s142_project_a) { project(e); }
GOLDEN(s142_project_b1) { project(e); }
GOLDEN(s142_project_b2) { project(e); }
GOLDEN(s142_project_b3) { project(e); }
GOLDEN(s142_project_b4) { project(e); }

std::vector<NotesEdge> frontTable() { return notesFillTable(cornersOf(Entry("s142_front_fill_table"), {"A", "B1", "B4"})); }
GOLDEN(s142_front_fill_table) {
    Json x = Json::array(), start = Json::array(), end = Json::array(), dx = Json::array(), z = Json::array(), dz = Json::array(),
         rounded = Json::array();
    const auto toCents = [](double v) { return std::round(v * 100) / 100; };
    const std::vector<NotesCorner> corners = cornersOf(e, {"A", "B1", "B4"});
    for (const NotesEdge& edge : frontTable()) {
        x.push_back(edge.x), start.push_back(edge.yStart), end.push_back(edge.yEnd), dx.push_back(edge.dx), z.push_back(edge.values[0]),
            dz.push_back(edge.steps[0]);
        rounded.push_back((toCents(corners[edge.to].values[0]) - toCents(corners[edge.from].values[0])) / (edge.yEnd - edge.yStart));
    }
    e.binary64("Xstart", x);
    e.binary64("Ystart", start);
    e.binary64("Yend", end);
    e.binary64("dX", dx);
    e.binary64("Zstart", z);
    e.binary64("dZ", dz);
    e.binary64("dZ_from_rounded_Z", rounded);
}
GOLDEN(s143_front_fill_rows) {
    const std::vector<NotesEdge> table = frontTable();
    const std::vector<NotesLine> lines = notesLines(table, true);
    int pixels = 0;
    for (size_t i = 0; i < lines.size(); ++i) {
        const NotesLine& line = lines[i];
        const Json& row = e.data("rows")[i];
        const Json got = {line.y,           line.leftX,
                          line.rightX,      line.left[0],
                          line.right[0],    line.rightX > line.leftX ? (line.right[0] - line.left[0]) / (line.rightX - line.leftX) : 0,
                          notesPixels(line)};
        for (size_t k = 0; k < got.size(); ++k)
            EXPECT_LE(std::abs(got[k].get<double>() - row[k].get<double>()),
                      tolerance().binary64 * std::max(1.0, std::abs(row[k].get<double>())))
                << "line " << i << ", column " << k;
        pixels += notesPixels(line);
    }
    e.exactly("rows", lines.size());
    e.exactly("literal_pixel_count", pixels);
    const double height = table[0].yEnd - table[0].yStart;
    const double left = table[1].x + height * table[1].dx, right = table[0].x + height * table[0].dx,
                 z = table[0].values[0] + height * table[0].steps[0];
    e.binary64("last_row_exact", {left, right, z, z});
    e.binary64("last_row_accumulated", {lines.back().leftX, lines.back().rightX, lines.back().left[0], lines.back().right[0]});
}

}  // namespace
}  // namespace plumb::golden
