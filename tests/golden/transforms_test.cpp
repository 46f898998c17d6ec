// SPDX-License-Identifier: MIT
// Sections 1 to 10: frames, display coordinates, transforms and their chains.
#include "pipeline/transform/steps.h"
#include "pipeline/transform/vector.h"
#include "tests/golden/golden.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb::golden {
namespace {

using glm::dmat3;
using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;

template <class Matrix, class Point>
Json moved(const Matrix& m, std::vector<Point> points) {
    ChainCounters counters;
    apply(m, std::span<Point>(points), counters);
    return jsonOf(points);
}

// X, Y of section 4: the origin in the middle of the window, +Y up.
dvec2 displayOf(const Entry& e, double x, double y) { return {e.input("W").get<double>() / 2 + x, e.input("H").get<double>() / 2 - y}; }

GOLDEN(s01_frame_memory) {
    Json bytes = Json::array(), mixed = Json::array(), decimal = Json::array(), binary = Json::array();
    for (const Json& row : e.input("rows")) {
        const double n = row["W"].get<double>() * row["H"].get<double>() * row["bytes_per_pixel"].get<double>();
        bytes.push_back(n), mixed.push_back(n / 1024 / 1000), decimal.push_back(n / 1e6), binary.push_back(n / 1024 / 1024);
    }
    e.exactly("bytes", bytes);
    e.binary64("KiB_divided_by_1000", mixed);
    e.binary64("MB_decimal", decimal);
    e.binary64("MiB", binary);
}
GOLDEN(s01_bits_per_frame) {
    const uint64_t bits = e.input("W").get<uint64_t>() * e.input("H").get<uint64_t>() * e.input("bits_per_pixel").get<uint64_t>();
    e.exactly("bits_per_frame", bits);
    e.exactly("bits_per_second", bits * e.input("fps").get<uint64_t>());
    e.exactly("erratum_factor", bits);
}
GOLDEN(s01_colour_count) {
    uint64_t colours = 1;
    for (int i = 0; i < e.input("channels").get<int>(); ++i) colours *= e.input("levels_per_channel").get<uint64_t>();
    e.exactly("colours", colours);
    e.binary64("colours_in_millions", double(colours) / 1e6);
}
GOLDEN(s02_pyramid_hierarchy) {
    std::map<std::pair<std::string, std::string>, int> edges;
    int draws = 0;
    for (const Json& polygon : e.input("polygons"))
        for (size_t i = 0; i < polygon.size(); ++i, ++draws) {
            const std::string a = polygon[i].get<std::string>(), b = polygon[(i + 1) % polygon.size()].get<std::string>();
            ++edges[std::minmax(a, b)];
        }
    int least = draws, most = 0;
    for (const auto& [edge, count] : edges) least = std::min(least, count), most = std::max(most, count);
    e.exactly("vertices", e.input("vertices").size());
    e.exactly("polygons", e.input("polygons").size());
    e.exactly("edge_draws", draws);
    e.exactly("distinct_edges", edges.size());
    e.exactly("draws_per_edge_min_max", {least, most});
}
GOLDEN(s04_display_centre) { e.binary64("display", jsonOf(displayOf(e, e.input("Xps").get<double>(), e.input("Yps").get<double>()))); }
GOLDEN(s04_display_point) { e.binary64("display", jsonOf(displayOf(e, e.input("Xps").get<double>(), e.input("Yps").get<double>()))); }

GOLDEN(s051_translate_triangle) {
    e.binary64("points", moved(translation(vectorOf<dvec2>(e.input("T"))), vectorsOf<dvec2>(e.input("points"))));
}
GOLDEN(s052_scale_off_origin) { e.binary64("points", moved(scaling(vectorOf<dvec2>(e.input("S"))), vectorsOf<dvec2>(e.input("points")))); }
GOLDEN(s052_scale_centred) { e.binary64("points", moved(scaling(vectorOf<dvec2>(e.input("S"))), vectorsOf<dvec2>(e.input("points")))); }
GOLDEN(s052_scale_identity_and_collapse) {
    for (const Json& s : e.input("S_list"))
        e.binary64("S=" + s.dump(), moved(scaling(dvec2(s.get<double>())), vectorsOf<dvec2>(e.input("points"))));
}
GOLDEN(s053_rotate_90) { e.binary64("points", moved(rotation(e.input("phi_deg").get<double>()), vectorsOf<dvec2>(e.input("points")))); }
GOLDEN(s053_rotate_45) {
    const SineCosine angle = sineCosineOfDegrees(e.input("phi_deg").get<double>());
    e.binary64("sin_cos", {angle.sine, angle.cosine});
    e.binary64("points", moved(rotation(e.input("phi_deg").get<double>()), vectorsOf<dvec2>(e.input("points"))));
}

GOLDEN(s071_inplace_rotate_2d) {
    const std::vector<dvec2> points = vectorsOf<dvec2>(e.input("points"));
    const std::vector<Step2> chain = aboutSteps(vectorOf<dvec2>(e.input("ref")), rotateStep(e.input("phi_deg").get<double>()));
    ChainCounters counters;
    const std::vector<dmat3> products = productsOf(std::span<const Step2>(chain), counters);
    e.binary64("after_translate", moved(products[0], points));
    e.binary64("after_rotate", moved(products[1], points));
    e.binary64("final", moved(products[2], points));
    e.binary64("bounding_box_centre", jsonOf(visualCentre(std::span<const dvec2>(points))));
}
GOLDEN(s072_inplace_scale_2d) {
    const std::vector<dvec2> points = vectorsOf<dvec2>(e.input("points"));
    const dvec2 centre = visualCentre(std::span<const dvec2>(points));
    EXPECT_EQ(centre, vectorOf<dvec2>(e.input("ref")));
    const std::vector<Step2> chain = aboutSteps(centre, scaleStep(dvec2(e.input("S").get<double>())));
    ChainCounters counters;
    const std::vector<dmat3> products = productsOf(std::span<const Step2>(chain), counters);
    e.binary64("bounding_box_centre", jsonOf(centre));
    e.binary64("after_translate", moved(products[0], points));
    e.binary64("after_scale", moved(products[1], points));
    e.binary64("final", moved(products[2], points));
}
GOLDEN(s073_inplace_rotate_3d) {
    const dvec3 p = vectorOf<dvec3>(e.input("point"));
    EXPECT_EQ(e.input("axis"), "Z");
    const std::vector<Step3> chain = aboutSteps(vectorOf<dvec3>(e.input("ref")), rotateZStep(e.input("phi_deg").get<double>()));
    ChainCounters counters;
    const std::vector<dmat4> products = productsOf(std::span<const Step3>(chain), counters);
    e.binary64("after_translate", jsonOf(transformed(products[0], p)));
    e.binary64("after_rotate", jsonOf(transformed(products[1], p)));
    e.binary64("final", jsonOf(transformed(products[2], p)));
}
GOLDEN(s073_inplace_scale_3d) {
    e.binary64("final", jsonOf(transformed(about(vectorOf<dvec3>(e.input("ref")), scaling(vectorOf<dvec3>(e.input("S")))),
                                           vectorOf<dvec3>(e.input("point")))));
}
GOLDEN(s074_bounding_box_centre) {
    std::vector<dvec3> points;
    for (const Json& v : e.input("vertices")) points.push_back(vectorOf<dvec3>(v));
    dvec3 least = points[0], most = points[0];
    for (const dvec3& p : points) least = glm::min(least, p), most = glm::max(most, p);
    e.binary64("min", jsonOf(least));
    e.binary64("max", jsonOf(most));
    e.binary64("centre", jsonOf(visualCentre(std::span<const dvec3>(points))));
}

GOLDEN(s082_matrix_forms_2d) {
    const dvec3 p = vectorOf<dvec3>(e.input("point"));
    const auto check = [&](const char* name, const dmat3& m) {
        e.binary64(std::string(name) + "_matrix", jsonOf(rowForm(m)));
        EXPECT_EQ(m * p, p * rowForm(m));  // both notations, the same point
        e.binary64(std::string(name) + "_point", jsonOf(p * rowForm(m)));
    };
    check("T", translation(vectorOf<dvec2>(e.input("T"))));
    check("S", scaling(vectorOf<dvec2>(e.input("S"))));
    check("R", rotation(e.input("phi_deg").get<double>()));
}

void bothNotations(Entry& e, const dmat4& m) {
    const dvec4 p = vectorOf<dvec4>(e.input("point"));
    e.binary64("row_vector_matrix", jsonOf(rowForm(m)));
    e.binary64("column_vector_matrix", jsonOf(m));
    e.binary64("point_times_matrix", jsonOf(p * rowForm(m)));
    e.binary64("matrix_times_point", jsonOf(m * p));
}
// "T=(4,5,6)", "phi=30"
std::vector<double> parameterOf(const Entry& e) {
    const std::string text = e.input("parameter").get<std::string>();
    std::vector<double> list;
    for (size_t i = text.find('=') + 1; i < text.size(); ++i)
        if (std::isdigit(static_cast<unsigned char>(text[i])) != 0) {
            char* end = nullptr;
            list.push_back(std::strtod(text.c_str() + i, &end));
            i = size_t(end - text.c_str());
        }
    return list;
}
dvec3 vectorParameter(const Entry& e) {
    const std::vector<double> p = parameterOf(e);
    return {p.at(0), p.at(1), p.at(2)};
}
GOLDEN(s083_matrix_translate) { bothNotations(e, translation(vectorParameter(e))); }
GOLDEN(s083_matrix_scale) { bothNotations(e, scaling(vectorParameter(e))); }
GOLDEN(s083_matrix_rotate_z) { bothNotations(e, rotationZ(parameterOf(e).at(0))); }
GOLDEN(s083_matrix_rotate_y) { bothNotations(e, rotationY(parameterOf(e).at(0))); }
GOLDEN(s083_matrix_rotate_x) { bothNotations(e, rotationX(parameterOf(e).at(0))); }
GOLDEN(s0834_rotate_y_90) { e.binary64("point", jsonOf(rotationY(e.input("phi_deg").get<double>()) * vectorOf<dvec4>(e.input("point")))); }
GOLDEN(s0835_rotate_x_90) { e.binary64("point", jsonOf(rotationX(e.input("phi_deg").get<double>()) * vectorOf<dvec4>(e.input("point")))); }
GOLDEN(s0833_rotate_z_90) { e.binary64("point", jsonOf(rotationZ(e.input("phi_deg").get<double>()) * vectorOf<dvec4>(e.input("point")))); }
GOLDEN(s091_opposite_direction) {
    const dmat4 m1 = rotationZ(e.input("phi_deg").get<double>()), m2 = rotationZ(-e.input("phi_deg").get<double>());
    e.binary64("M1_takes_X_to", jsonOf(m1 * dvec4(1, 0, 0, 1)));
    e.binary64("M2_takes_Y_to", jsonOf(m2 * vectorOf<dvec4>(e.input("point"))));
    e.binary64("M1*M2", jsonOf(m1 * m2));
}

GOLDEN(s101_sequential_equations) {
    std::vector<dvec3> points(e.input("vertices").get<size_t>(), dvec3(1, 2, 3));
    ChainCounters counters;
    apply(rotationZ(30), std::span<dvec3>(points), counters);
    e.exactly("sequential", counters.equations);
    // None waits for another: any band of the points alone gives the same bytes, so one step is enough with as many units.
    std::vector<dvec3> alone(points.size(), dvec3(1, 2, 3));
    for (dvec3& p : alone) apply(rotationZ(30), std::span<dvec3>(&p, 1), counters);
    EXPECT_EQ(alone, points);
    e.exactly("parallel_steps", 1);
}
GOLDEN(s102_composite_counts_2d) {
    const std::vector<Step2> chain = aboutSteps(dvec2(3, 2), rotateStep(90));
    std::vector<dvec2> points(e.input("vertices").get<size_t>(), dvec2(1, 2)), together = points;
    ChainCounters translations, rotations, composite;
    apply(chain[0].matrix, std::span<dvec2>(points), translations);
    apply(chain[1].matrix, std::span<dvec2>(points), rotations);
    apply(chain[2].matrix, std::span<dvec2>(points), translations);
    apply(productsOf(std::span<const Step2>(chain), composite).back(), std::span<dvec2>(together), composite);
    e.exactly("translations_without", translations.applications);
    e.exactly("rotations_without", rotations.applications);
    e.exactly("point_matrix_products_with", composite.applications);
    e.exactly("matrix_products", composite.products);
    e.binary64("ratio", double(composite.applications) / double(translations.applications + rotations.applications));
}
GOLDEN(s1021_composite_2d) {
    const std::vector<Step2> chain = aboutSteps(vectorOf<dvec2>(e.input("centre")), rotateStep(e.input("phi_deg").get<double>()));
    ChainCounters counters;
    const std::vector<dmat3> products = productsOf(std::span<const Step2>(chain), counters);
    e.binary64("T_minus", jsonOf(rowForm(chain[0].matrix)));
    e.binary64("R", jsonOf(rowForm(chain[1].matrix)));
    e.binary64("T_plus", jsonOf(rowForm(chain[2].matrix)));
    e.binary64("T_minus*R", jsonOf(rowForm(products[1])));
    e.binary64("composite", jsonOf(rowForm(products[2])));
    Json points = Json::array();
    for (const Json& p : e.input("points")) points.push_back(jsonOf(vectorOf<dvec3>(p) * rowForm(products[2])));
    e.binary64("points", points);
}

// The line of section 10.2.2, which the steps of the same section share.
std::array<dvec3, 2> line() {
    const Entry e("s1022_line_parameters");
    return {vectorOf<dvec3>(e.input("P1")), vectorOf<dvec3>(e.input("P2"))};
}
GOLDEN(s1022_line_parameters) {
    const auto angles = lineAngles(line()[0], line()[1]);
    ASSERT_TRUE(angles);
    e.binary64("a_b_c", {angles->a, angles->b, angles->c});
    e.binary64("s", angles->s);
    e.binary64("L", angles->length);
    e.binary64("sin_alpha", angles->alpha.sine);
    e.binary64("cos_alpha", angles->alpha.cosine);
    e.binary64("sin_beta", angles->beta.sine);
    e.binary64("cos_beta", angles->beta.cosine);
}
void lineStep(Entry& e, size_t step) {
    const dmat4 m = (*lineRotation(line()[0], line()[1], 90))[step];
    e.binary64("matrix", jsonOf(rowForm(m)));
    e.binary64("points", moved(m, vectorsOf<dvec3>(e.input("points"))));
}
GOLDEN(s1022_step1) { lineStep(e, 0); }
GOLDEN(s1022_step2) { lineStep(e, 1); }
GOLDEN(s1022_step3) {
    lineStep(e, 2);
    // What the misprint does: sine and cosine exchanged (errata A1).
    const SineCosine beta = lineAngles(line()[0], line()[1])->beta;
    e.binary64("point_through_the_printed_matrix",
               jsonOf(transformed(rotationY({-beta.cosine, beta.sine}), vectorOf<dvec3>(e.input("points")[1]))));
}
GOLDEN(s1022_step5) { lineStep(e, 4); }
GOLDEN(s1022_step6) { lineStep(e, 5); }
GOLDEN(s1022_step7) { lineStep(e, 6); }
GOLDEN(s1022_composite_phi90) {
    const dvec3 p1 = vectorOf<dvec3>(e.input("P1")), p2 = vectorOf<dvec3>(e.input("P2")), p = vectorOf<dvec3>(e.input("test_point"));
    const double phi = e.input("phi_deg").get<double>();
    const std::vector<Step3> chain = lineSteps(p1, p2, phi);
    ChainCounters counters;
    const std::vector<dmat4> products = productsOf(std::span<const Step3>(chain), counters);
    e.binary64("composite", jsonOf(rowForm(products.back())));
    Json after = Json::array();
    dvec3 q = p;
    for (const Step3& step : chain) after.push_back(jsonOf(q = transformed(step.matrix, q)));
    e.binary64("test_point_after_each_step", after);
    e.binary64("P1_image", jsonOf(transformed(products.back(), p1)));
    e.binary64("P2_image", jsonOf(transformed(products.back(), p2)));
    e.binary64("rodrigues_image_of_test_point", jsonOf(transformed(about(p1, rotation(unitVector(p2 - p1), phi)), p)));
}
GOLDEN(s1022_step_counts) {
    const std::vector<Step3> chain = lineSteps(line()[0], line()[1], 90);
    EXPECT_EQ(chain.size(), e.input("matrices").get<size_t>());
    std::vector<dvec3> points(e.input("vertices").get<size_t>(), dvec3(4, 3, 5)), together = points;
    ChainCounters separate, composite, tree;
    for (const Step3& step : chain) apply(step.matrix, std::span<dvec3>(points), separate);
    apply(productsOf(std::span<const Step3>(chain), composite).back(), std::span<dvec3>(together), composite);
    const auto levels = treeOf(std::span<const Step3>(chain), tree);
    Json perLevel = Json::array();
    for (const auto& level : levels)
        perLevel.push_back(std::count_if(level.begin(), level.end(), [](const auto& node) { return node.product; }));
    e.exactly("point_matrix_products_without", separate.applications);
    e.exactly("point_matrix_products_with", composite.applications);
    e.exactly("improvement", separate.applications / composite.applications);
    e.exactly("sequential_matrix_products", composite.products);
    e.exactly("tree_levels", levels.size());
    e.exactly("products_per_level", perLevel);
    e.exactly("time_steps_with_enough_hardware", levels.size() + 1);
}

}  // namespace
}  // namespace plumb::golden
