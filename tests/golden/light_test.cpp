// SPDX-License-Identifier: MIT
// Sections 15 to 17: colours, the illumination model, the spheres, the cylinder. Each number in binary64 by the formula, and by the
// pass (device and twin, equal bytes) where the pass computes it.
#include "pipeline/passes/encode.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/colour.h"
#include "pipeline/scene/load.h"
#include "pipeline/transform/matrix.h"
#include "pipeline/transform/vector.h"
#include "tests/golden/golden.h"
#include "tests/golden/lit.h"
#include "tests/golden/notes_fill.h"
#include "tests/support/compare.h"
#include "tests/support/device_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <glm/glm.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb::golden {
namespace {

using glm::dvec3;

// Round half to even, as the notes' round(): nearbyint in the default rounding mode.
int byteOf(double intensity) { return int(std::nearbyint(255 * intensity)); }

// The model in binary64, with the clamps of errata A12 and A13 where they are asked for.
struct Model {
    double ambient = 0, diffuse = 0, specular = 0;
    double sum() const { return ambient + diffuse + specular; }
};
struct Surface {
    double ia = 0, ip = 0, kd = 0, ks = 0, index = 0;
};
// reflect() of 16.4.2, on any lengths.
dvec3 reflectBeforeNormalising(const dvec3& normal, const dvec3& light) {
    const dvec3 n = unitVector(normal), l = unitVector(light);
    const double twice = 2 * glm::dot(n, l);
    return twice > 0 ? n - l / twice : twice == 0 ? -l : -n + l / twice;
}
dvec3 reflected(const dvec3& normal, const dvec3& light) { return unitVector(reflectBeforeNormalising(normal, light)); }
Model illuminated(const dvec3& normal, const dvec3& light, const dvec3& view, const Surface& s) {
    const double nl = glm::dot(unitVector(normal), unitVector(light));
    const double rv = std::max(0.0, glm::dot(reflected(normal, light), unitVector(view)));
    return {s.ia * s.kd, s.ip * s.kd * std::max(0.0, nl), nl > 0 ? s.ip * s.ks * std::pow(rv, s.index) : 0};
}

gpu::MaterialRecord grey(double base, double kd, double ks, double index) {
    return {glm::vec3(float(base)), float(index), glm::vec3(float(kd)), index == 0 ? 1.0f : 0.0f, glm::vec3(float(ks)), 0};
}
gpu::LightRecord directional(const dvec3& toLight, double ip) { return {glm::vec3(unitVector(toLight)), 0, glm::vec3(float(ip)), 0}; }
// A grey point by the pass.
double byPass(const dvec3& normal, const dvec3& light, const dvec3& view, const Surface& s) {
    return double(lit({{normal, view}}, {grey(s.ia * s.kd, s.kd, s.ks, s.index)}, {directional(light, s.ip)})[0].x);
}

GOLDEN(s153_hex_colours) {
    for (const auto& [name, code] : e.input("codes").items()) {
        const std::optional<Rgb8> rgb = rgbOfHex("#" + code.get<std::string>());
        ASSERT_TRUE(rgb) << code;
        e.exactly(name, {(*rgb)[0], (*rgb)[1], (*rgb)[2]});
    }
}
GOLDEN(s154_cmy_mixing) {
    // A pigment absorbs one channel; a mixture reflects what every pigment reflects.
    const dvec3 cyan = rgbFromCmy({1, 0, 0}), magenta = rgbFromCmy({0, 1, 0}), yellow = rgbFromCmy({0, 0, 1});
    e.exactly("cyan", jsonOf(cyan));
    e.exactly("magenta", jsonOf(magenta));
    e.exactly("yellow", jsonOf(yellow));
    e.exactly("cyan+magenta=blue", jsonOf(mixed(cyan, magenta)));
    e.exactly("cyan+yellow=green", jsonOf(mixed(cyan, yellow)));
    e.exactly("magenta+yellow=red", jsonOf(mixed(magenta, yellow)));
    e.exactly("all=black", jsonOf(mixed(mixed(cyan, magenta), yellow)));
    // The mixture as one colour of ink, and back: what the pigments leave is what the inks of the mixture leave.
    for (const dvec3& rgb : {mixed(cyan, magenta), mixed(cyan, yellow), mixed(magenta, yellow), mixed(mixed(cyan, magenta), yellow)})
        EXPECT_EQ(rgbFromCmyk(cmykFromRgb(rgb)), rgb);
}
GOLDEN(s162_ambient_mono) {
    const double value = e.input("Ia").get<double>() * e.input("Kd").get<double>();
    e.binary64("intensity", value);
    e.binary64("times255", 255 * value);
    e.exactly("byte", byteOf(value));
    const std::vector<glm::vec4> c = lit({{{0, 0, 1}, {0, 0, 1}}}, {grey(value, 0, 0, 1)}, {});
    e.float32("intensity", c[0].x);
    e.colour("byte", encodePixelCpu(gpu::kEncodeLinear, &c[0].x, 0) & 255u);
}
GOLDEN(s162_ambient_rgb) {
    const dvec3 value = vectorOf<dvec3>(e.input("Ia")) * vectorOf<dvec3>(e.input("Kd"));
    e.binary64("intensity", jsonOf(value));
    e.exactly("bytes", {byteOf(value.x), byteOf(value.y), byteOf(value.z)});
    gpu::MaterialRecord m = grey(0, 0, 0, 1);
    m.base = glm::vec3(value);
    const std::vector<glm::vec4> c = lit({{{0, 0, 1}, {0, 0, 1}}}, {m}, {});
    e.float32("intensity", jsonOf(glm::vec3(c[0])));
    const uint32_t word = encodePixelCpu(gpu::kEncodeLinear, &c[0].x, 0);
    e.colour("bytes", {word & 255u, word >> 8 & 255u, word >> 16});
}
GOLDEN(s163_lambert_angles) {
    Json all = Json::array(), pass = Json::array();
    for (const Json& degrees : e.input("phi_deg")) {
        const SineCosine angle = sineCosineOfDegrees(degrees.get<double>());
        all.push_back(angle.cosine);
        pass.push_back(byPass({0, 1, 0}, {angle.sine, angle.cosine, 0}, {0, 1, 0}, {0, 1, 1, 0, 1}));
    }
    e.binary64("cos", all);
    e.float32("cos", pass);
}
GOLDEN(s163_light_vector) {
    const dvec3 unit = unitVector(vectorOf<dvec3>(e.input("L")));
    e.binary64("unit", jsonOf(unit));
    e.binary64("angle_to_view_axis_deg", std::acos(-unit.z) * 180 / std::numbers::pi);
}
GOLDEN(s163_diffuse_mono) {
    const dvec3 n = vectorOf<dvec3>(e.input("N")), l = vectorOf<dvec3>(e.input("L"));
    const Surface s{0, e.input("Ip").get<double>(), e.input("Kd").get<double>(), 0, 1};
    e.binary64("|N|", magnitude(n));
    e.binary64("N_unit", jsonOf(unitVector(n)));
    e.binary64("|L|", magnitude(l));
    e.binary64("L_unit", jsonOf(unitVector(l)));
    const double value = illuminated(n, l, {0, 0, -1}, s).diffuse / e.input("d").get<double>();
    e.binary64("diffuse", value);
    e.exactly("byte", byteOf(value));
    const double pass = byPass(n, l, {0, 0, -1}, s);
    e.float32("diffuse", pass);
    e.colour("byte", byteOf(pass));
}
GOLDEN(s163_diffuse_from_below) {
    const dvec3 n = vectorOf<dvec3>(e.input("N"));
    const Surface s{0, e.input("Ip").get<double>(), e.input("Kd").get<double>(), 0, 1};
    Json nl = Json::array(), diffuse = Json::array(), pass = Json::array();
    for (const Json& list : e.input("L_list")) {
        const dvec3 l = vectorOf<dvec3>(list);
        nl.push_back(glm::dot(unitVector(n), unitVector(l)));
        diffuse.push_back(illuminated(n, l, {0, 0, -1}, s).diffuse);
        pass.push_back(byPass(n, l, {0, 0, -1}, s));
    }
    e.binary64("N.L", nl);
    e.binary64("diffuse", diffuse);
    e.float32("diffuse", pass);
}
GOLDEN(s163_attenuation_choices) {
    const double ip = e.input("Ip").get<double>(), kd = e.input("Kd").get<double>(), nl = e.input("N.L").get<double>(),
                 d = e.input("d").get<double>();
    const char* names[] = {"ignored", "one_over_d", "one_over_d2"};
    for (int power = 0; power < 3; ++power) {
        e.binary64(names[power], ip * kd * nl / std::pow(d, power));
        // A lamp at distance d along the normal (N.L = 1); the surface stands one unit before the eye.
        const std::vector<glm::vec4> c =
            lit({{{0, 0, 1}, {0, 0, 1}}}, {grey(0, kd, 0, 1)}, {{glm::vec3(0, 0, float(d) - 1), 1, glm::vec3(float(ip)), float(power)}});
        e.float32(names[power], c[0].x);
    }
}
GOLDEN(s1641_spec_index_table) {
    const SineCosine angle = sineCosineOfDegrees(e.input("theta_deg").get<double>());
    Json factor = Json::array(), percent = Json::array(), pass = Json::array();
    for (const Json& n : e.input("specIndex")) {
        factor.push_back(std::pow(angle.cosine, n.get<double>()));
        percent.push_back(100 * std::pow(angle.cosine, n.get<double>()));
        // R = L mirrored at N: the light comes head on, the viewer stands off by theta.
        pass.push_back(byPass({0, 1, 0}, {0, 1, 0}, {angle.sine, angle.cosine, 0}, {0, 1, 0, 1, n.get<double>()}));
    }
    e.binary64("factor", factor);
    e.binary64("percent", percent);
    e.float32("factor", pass);
}
GOLDEN(s1641_spec_limits) {
    const double ip = e.input("Ip").get<double>(), ks = e.input("Ks").get<double>();
    const auto check = [&](const char* name, double rv, double index, const dvec3& view) {
        e.binary64(name, ip * ks * std::pow(rv, index));
        e.float32(name, byPass({0, 1, 0}, {0, 1, 0}, view, {0, ip, 0, ks, index}));
    };
    check("R.V=1,n=50", 1, 50, {0, 1, 0});
    check("R.V=0.3,n=0", 0.3, 0, {std::sqrt(1 - 0.3 * 0.3), 0.3, 0});
    check("R.V=0(clamped),n=0", 0, 0, {1, -0.5, 0});
}

void reflection(Entry& e) {
    const dvec3 n = vectorOf<dvec3>(e.input("N")), l = vectorOf<dvec3>(e.input("L"));
    const double nl = glm::dot(unitVector(n), unitVector(l));
    e.binary64("twoCosPhi", 2 * nl);
    e.binary64("R_before_normalising", jsonOf(reflectBeforeNormalising(n, l)));
    e.binary64("R", jsonOf(reflected(n, l)));
    e.binary64("R", jsonOf(unitVector(2 * nl * unitVector(n) - unitVector(l))));  // without the division and the cases
    // The pass: seen along R, the highlight is full, and its power falls with the distance from R.
    if (nl > 0) {
        EXPECT_NEAR(byPass(n, l, reflected(n, l), {0, 1, 0, 1, 1}), 1, tolerance().float32);
    }
}
GOLDEN(s1642_reflect_positive) { reflection(e); }
GOLDEN(s1642_reflect_positive_general) { reflection(e); }
GOLDEN(s1642_reflect_head_on) { reflection(e); }
GOLDEN(s1642_reflect_zero) { reflection(e); }
GOLDEN(s1642_reflect_zero_general) { reflection(e); }
GOLDEN(s1642_reflect_negative) { reflection(e); }

// The 20 spheres of 16.5, from the entry that describes them.
struct Spheres {
    const Entry entry{"s165_20_spheres_scene"};
    int number(const char* name) const { return entry.input(name).get<int>(); }
    double real(const char* name) const { return entry.input(name).get<double>(); }
    dvec3 vector(const char* name) const { return vectorOf<dvec3>(entry.input(name)); }
    int radius = number("radius");
    int centreX(int column) const { return number("xCenter_first") + column * number("pitch"); }
    int centreY(int row) const { return number("yCenter_first") + row * number("pitch"); }
    Surface surface(int row, int column) const {
        return {real("Ia"), real("Ip"), entry.input("Kd")[size_t(column)].get<double>(), entry.input("Ks")[size_t(column)].get<double>(),
                entry.input("specIndex_per_row")[size_t(row)].get<double>()};
    }
    bool inside(int x, int y) const { return x * x + y * y <= radius * radius; }
    int z(int x, int y) const { return int(std::nearbyint(std::sqrt(double(radius * radius - x * x - y * y)))); }
    dvec3 normal(int x, int y) const { return {double(x), double(y), double(z(x, y))}; }
    template <class Body>
    void eachPixel(const Body& body) const {
        for (int y = -radius; y <= radius; ++y)
            for (int x = -radius; x <= radius; ++x)
                if (inside(x, y)) body(x, y);
    }
};
GOLDEN(s165_20_spheres_scene) {
    const Spheres s;
    int pixels = 0;
    s.eachPixel([&](int, int) { ++pixels; });
    e.exactly("pixels_per_sphere", pixels);
    Json xs = Json::array(), ys = Json::array();
    for (int column = 0; column < s.number("columns"); ++column) xs.push_back(s.centreX(column));
    for (int row = 0; row < s.number("rows"); ++row) ys.push_back(s.centreY(row));
    e.exactly("centres_x", xs);
    e.exactly("centres_y", ys);
}
GOLDEN(s165_20_spheres_pixels) {
    const Spheres s;
    const Json& samples = e.data("samples");
    e.exactly("samples", samples.size());
    // The committed scene, on the device and by the twin: green carries ambient, diffuse and specular, red and blue the specular alone.
    Scene scene = loadScene({std::string(PLUMB_SOURCE_DIR) + "/scenes/notes-20-spheres.toml"}, {});
    RenderRequest request;
    request.width = scene.size.x;
    request.height = scene.size.y;
    request.fill = *scene.fill;
    request.encoding = *scene.encoding;
    request.planes = test::kEveryPlane;
    const Frame twin = renderCpu(scene, request).frame, device = renderGpu(*test::DeviceEnvironment::device(), scene, request).frame;
    test::expectSameFrame(twin, device);
    EXPECT_EQ(s.entry.input("canvas"), Json({twin.width, twin.height}));
    const auto byteAt = [&](int px, int py, int channel) {
        return int(twin.rgba[size_t(py) * twin.width + size_t(px)] >> (8 * channel) & 255u);
    };
    // Every pixel by the formula in binary64, and nothing is drawn elsewhere. A byte may differ only where the formula is as near to a half as float32 is
    // to the formula; on a half that no light was added to (0.3 times 255 is 76.5) it may not, both round it to the even byte.
    uint64_t covered = 0, onAHalf = 0;
    for (int row = 0; row < s.number("rows"); ++row)
        for (int column = 0; column < s.number("columns"); ++column)
            s.eachPixel([&](int x, int y) {
                const Model m = illuminated(s.normal(x, y), s.vector("L"), s.vector("V"), s.surface(row, column));
                const int bytes[] = {byteOf(m.specular), byteOf(m.sum()), byteOf(m.specular)}, px = s.centreX(column) + x,
                          py = s.centreY(row) - y;
                const double values[] = {m.specular, m.sum(), m.specular};
                for (int i = 0; i < 3; ++i) {
                    const double beyond = 255 * values[i] - std::floor(255 * values[i]) - 0.5;  // of the half
                    const bool unlit = glm::dot(unitVector(s.normal(x, y)), unitVector(s.vector("L"))) < -tolerance().float32;
                    onAHalf += unlit && beyond == 0;
                    if (!(unlit && beyond == 0) && std::abs(beyond) <= 255 * tolerance().float32) continue;
                    ASSERT_EQ(byteAt(px, py, i), bytes[i]) << "pixel (" << px << ", " << py << ")";
                }
                ASSERT_EQ(twin.object[size_t(py) * twin.width + size_t(px)], uint32_t(row * s.number("columns") + column));
                ++covered;
            });
    EXPECT_EQ(twin.coveredPixels, covered);
    EXPECT_GT(onAHalf, 1000u) << "the unlit pixels of the fifth column";
    for (const Json& sample : samples) {
        const int row = sample[0].get<int>(), column = sample[1].get<int>(), px = sample[2].get<int>(), py = sample[3].get<int>();
        const int x = px - s.centreX(column), y = s.centreY(row) - py;
        ASSERT_TRUE(s.inside(x, y));
        EXPECT_EQ(s.z(x, y), sample[5].get<int>());
        const Model m = illuminated(s.normal(x, y), s.vector("L"), s.vector("V"), s.surface(row, column));
        const double want[] = {sample[8].get<double>(), sample[9].get<double>(), sample[10].get<double>()},
                     got[] = {m.ambient, m.diffuse, m.specular};
        for (int i = 0; i < 3; ++i)
            EXPECT_LE(std::abs(got[i] - want[i]), tolerance().binary64 * std::max(1.0, std::abs(want[i]))) << sample.dump();
        EXPECT_EQ(sample[4], Json({byteOf(m.specular), byteOf(m.sum()), byteOf(m.specular)})) << sample.dump();
        for (int i = 0; i < 3; ++i)
            EXPECT_LE(std::abs(byteAt(px, py, i) - sample[4][size_t(i)].get<int>()), tolerance().colourLevels) << sample.dump();
    }
}
GOLDEN(s165_rv_clamp_matters) {
    const Spheres s;
    int pixels = 0, negative = 0;
    s.eachPixel([&](int x, int y) {
        ++pixels;
        negative += glm::dot(reflected(s.normal(x, y), s.vector("L")), s.vector("V")) < 0;
    });
    e.exactly("pixels_per_sphere", pixels);
    e.exactly("pixels_with_negative_R.V", negative);
}
GOLDEN(s165_backlit_specular) {
    const dvec3 n = vectorOf<dvec3>(e.input("N")), v = vectorOf<dvec3>(e.input("V")), l = vectorOf<dvec3>(e.input("L"));
    const Surface s{0, e.input("Ip").get<double>(), 0, e.input("Ks").get<double>(), e.input("specIndex").get<double>()};
    const double rv = glm::dot(reflected(n, l), unitVector(v));
    e.binary64("N.L", glm::dot(unitVector(n), unitVector(l)));
    e.binary64("N.V", glm::dot(unitVector(n), unitVector(v)));
    e.binary64("R.V", rv);
    e.binary64("specular_by_the_literal_code", s.ip * s.ks * std::pow(rv, s.index));
    e.binary64("specular_gated_by_N.L", illuminated(n, l, v, s).specular);
    e.float32("specular_gated_by_N.L", byPass(n, l, v, s));
}
GOLDEN(s165_hex_code) {
    Json bytes = Json::array();
    const Json& inputs = e.input("intensities");
    for (size_t i = 0; i < inputs.size(); ++i) {
        const double value = inputs[i].get<double>();
        bytes.push_back(std::max(0, byteOf(value)));
        // The product clamps above 1 (errata A14); halves go to the even byte on both sides.
        const float rgb[3] = {float(value), 0, 0};
        const int clamped = std::min(255, std::max(0, byteOf(value)));
        EXPECT_EQ(int(encodePixelCpu(gpu::kEncodeLinear, rgb, 0) & 255u), clamped) << value;
        char hex[16];
        std::snprintf(hex, sizeof hex, "%02x", unsigned(std::max(0, byteOf(value))));
        EXPECT_EQ(e.data("hex")[i], hex);
        // The library's code clamps, so it differs exactly where the notes' has three digits.
        const std::string code = hexOf(dvec3(value, 0, 0));
        EXPECT_EQ(code.substr(1, 2), value > 1 ? "ff" : hex) << value;
    }
    e.exactly("byte", bytes);
    const Json& tri = e.data("tri_example");
    const double specular = tri["specular"].get<double>(), sum = tri["ambient"].get<double>() + tri["diffuse"].get<double>() + specular;
    char colour[32];
    std::snprintf(colour, sizeof colour, "#%02x%02x%02x", unsigned(byteOf(specular)), unsigned(byteOf(sum)), unsigned(byteOf(specular)));
    EXPECT_EQ(tri["colour"], colour);
}

// The cylinder of 17.1 in binary64, and as the scene file of the project has it.
struct Cylinder {
    std::vector<dvec3> front, back;
    std::vector<std::vector<dvec3>> polygons() const {
        std::vector<std::vector<dvec3>> all;
        for (size_t i = 0; i < 8; ++i) all.push_back({front[i], back[i], back[(i + 1) % 8], front[(i + 1) % 8]});
        all.push_back(front);
        all.push_back(back);
        std::reverse(all.back().begin() + 1, all.back().end());
        return all;
    }
    std::vector<dvec3> normals() const {
        std::vector<dvec3> all;
        for (const auto& p : polygons()) all.push_back(unitVector(glm::cross(p[1] - p[0], p[2] - p[0])));
        return all;
    }
    // Normal of barrel vertex i, where rectangles i - 1 and i meet.
    dvec3 barrel(size_t i) const { return unitVector(normals()[(i + 7) % 8] + normals()[i]); }
};
Cylinder cylinder() {
    const Entry e("s171_cylinder_vertices");
    const double half = e.input("X").get<double>() / 2, y = e.input("X").get<double>() / std::numbers::sqrt2, wide = half + y;
    const glm::dvec2 ring[] = {{-half, wide}, {half, wide},   {wide, half},   {wide, -half},
                               {half, -wide}, {-half, -wide}, {-wide, -half}, {-wide, half}};
    Cylinder c;
    for (const glm::dvec2& p : ring) {
        c.front.emplace_back(p, e.input("z_front").get<double>());
        c.back.emplace_back(p, e.input("z_back").get<double>());
    }
    return c;
}
const TriangleMesh& sceneCylinder() {
    static const Scene kScene = loadScene({PLUMB_SOURCE_DIR "/scenes/cylinder.toml"}, {});
    return kScene.meshes.at(0);
}
GOLDEN(s171_cylinder_vertices) {
    const Cylinder c = cylinder();
    e.binary64("Y", e.input("X").get<double>() / std::numbers::sqrt2);
    e.binary64("front", jsonOf(c.front));
    e.binary64("back", jsonOf(c.back));
    for (const auto& [name, ring] :
         {std::pair{"front", &c.front}, std::pair{"back", &c.back}}) {  // every one is a vertex of the scene's mesh
        Json found = Json::array();
        for (const dvec3& p : *ring)
            for (const glm::vec3& q : sceneCylinder().positions)
                if (q == glm::vec3(p)) {
                    found.push_back(jsonOf(q));
                    break;
                }
        e.float32(name, found);
    }
}
GOLDEN(s171_cylinder_surface_normals) {
    e.binary64("normals", jsonOf(cylinder().normals()));
    e.float32("normals", jsonOf(sceneCylinder().faceNormal));
}
// Normal of the scene's mesh at a position, for the face of that number.
glm::vec3 sceneNormal(uint32_t face, const dvec3& position) {
    for (const TriangleMesh::Triangle& t : sceneCylinder().triangles)
        if (t.face == face)
            for (uint32_t v : t.vertex)
                if (sceneCylinder().positions[v] == glm::vec3(position)) return sceneCylinder().normals[v];
    return glm::vec3(0);
}
GOLDEN(s172_polygon0_vertex_normals) {
    const Cylinder c = cylinder();
    const std::tuple<const char*, size_t, dvec3> corners[] = {
        {"Front0", 0, c.front[0]}, {"Back0", 0, c.back[0]}, {"Back1", 1, c.back[1]}, {"Front1", 1, c.front[1]}};
    for (const auto& [name, i, position] : corners) {
        e.binary64(name, jsonOf(c.barrel(i)));
        e.float32(name, jsonOf(sceneNormal(0, position)));
    }
}
GOLDEN(s172_all_vertex_normals) {
    const Cylinder c = cylinder();
    std::vector<dvec3> barrel;
    std::vector<glm::vec3> scene;
    for (size_t i = 0; i < 8; ++i) {
        barrel.push_back(c.barrel(i));
        scene.push_back(sceneNormal(uint32_t(i), c.front[i]));
        EXPECT_EQ(sceneNormal(8, c.front[i]), glm::vec3(0, 0, -1)) << "the cap keeps its own";
        EXPECT_EQ(sceneNormal(9, c.back[i]), glm::vec3(0, 0, 1));
    }
    e.binary64("barrel_vertex_i", jsonOf(barrel));
    e.float32("barrel_vertex_i", jsonOf(scene));
    e.binary64("front_cap", jsonOf(c.normals()[8]));
    e.binary64("back_cap", jsonOf(c.normals()[9]));
}

// Polygon 0 of 17.2 and 17.3, rotated, lit at its corners and ready for the fill: values are Z, diffuse, specular, normal.
struct Polygon0 {
    explicit Polygon0(const Entry& e) {
        const Cylinder c = cylinder();
        // "X axis -45 degrees then Y axis 30 degrees about (0,0,250)"
        double turnX = 0, turnY = 0;
        dvec3 centre;
        EXPECT_EQ(
            std::sscanf(e.input("inplace_rotation").get<std::string>().c_str(),
                        "X axis %lf degrees then Y axis %lf degrees about (%lf,%lf,%lf)", &turnX, &turnY, &centre.x, &centre.y, &centre.z),
            5);
        const glm::dmat4 turn = rotationY(turnY) * rotationX(turnX);
        light = vectorOf<dvec3>(e.input("L"));
        view = vectorOf<dvec3>(e.input("V"));
        surface = {e.input("Ia").get<double>(), e.input("Ip").get<double>(), e.input("Kd").get<double>(), e.input("Ks").get<double>(),
                   e.input("specIndex").get<double>()};
        d = e.input("d").get<double>();
        const std::pair<dvec3, size_t> corners[] = {{c.front[0], 0}, {c.back[0], 0}, {c.back[1], 1}, {c.front[1], 1}};
        for (const auto& [p, i] : corners) {
            vertices.push_back(transformed(about(centre, turn), p));
            normals.push_back(transformed(turn, c.barrel(i)));
            const dvec3 v = vertices.back(), n = normals.back();
            const Model m = illuminated(n, light, view, surface);
            lights.push_back(m);
            const double w = e.input("window")[0].get<double>() / 2, h = e.input("window")[1].get<double>() / 2;
            polygon.push_back({std::nearbyint(w + d * v.x / (d + v.z)),
                               std::nearbyint(h - d * v.y / (d + v.z)),
                               {d * v.z / (d + v.z), m.diffuse, m.specular, n.x, n.y, n.z}});
        }
    }
    std::vector<dvec3> vertices, normals;
    std::vector<Model> lights;
    std::vector<NotesCorner> polygon;
    dvec3 light, view;
    Surface surface;
    double d = 0;
};
void near(double got, const Json& want, const std::string& what) {
    EXPECT_LE(std::abs(got - want.get<double>()), tolerance().binary64 * std::max(1.0, std::abs(want.get<double>()))) << what;
}
GOLDEN(s172_gouraud_setup_polygon0) {
    const Polygon0 p(e);
    e.binary64("vertices", jsonOf(p.vertices));
    e.binary64("vertex_normals", jsonOf(p.normals));
    const dvec3 n = unitVector(glm::cross(p.vertices[1] - p.vertices[0], p.vertices[2] - p.vertices[0]));
    e.binary64("visibility_value", glm::dot(n, dvec3(0, 0, -p.d)) - glm::dot(n, p.vertices[0]));
    Json display = Json::array(), lights = Json::array(), pass = Json::array();
    for (size_t i = 0; i < 4; ++i) {
        display.push_back({p.polygon[i].x, p.polygon[i].y, p.polygon[i].values[0]});
        lights.push_back({p.lights[i].ambient, p.lights[i].diffuse, p.lights[i].specular});
        const Surface diffuse{0, p.surface.ip, p.surface.kd, 0, 1}, specular{0, p.surface.ip, 0, p.surface.ks, p.surface.index};
        pass.push_back(
            {p.surface.ia * p.surface.kd, byPass(p.normals[i], p.light, p.view, diffuse), byPass(p.normals[i], p.light, p.view, specular)});
    }
    e.binary64("display_rounded", display);
    e.binary64("ambient_diffuse_specular", lights);
    e.float32("ambient_diffuse_specular", pass);
    std::vector<NotesEdge> table = notesFillTable(p.polygon);
    const Json& rows = e.data("fill_table");
    ASSERT_EQ(table.size(), rows.size());
    const char* names[] = {"Z", "D", "S", "NX", "NY", "NZ"};
    const Json& order = e.data("vertex_order");
    for (const Json& row : rows) {  // the order of tied edges is free
        const auto edge = std::find_if(table.begin(), table.end(), [&](const NotesEdge& t) {
            return row["edge"] == order[t.from].get<std::string>() + "-" + order[t.to].get<std::string>() ||
                   row["edge"] == order[t.to].get<std::string>() + "-" + order[t.from].get<std::string>();
        });
        ASSERT_NE(edge, table.end()) << row["edge"];
        near(edge->x, row["Xstart"], "Xstart");
        near(edge->yStart, row["Ystart"], "Ystart");
        near(edge->yEnd, row["Yend"], "Yend");
        near(edge->dx, row["dX"], "dX");
        for (size_t k = 0; k < 6; ++k) {
            near(edge->values[k], row[std::string(names[k]) + "start"], names[k]);
            near(edge->steps[k], row["d" + std::string(names[k])], names[k]);
        }
    }
}
GOLDEN(s173_phong_setup_polygon0) {
    const Polygon0 p(e);
    for (const auto& [key, corrected] : {std::pair{"literal", false}, std::pair{"corrected_switch", true}}) {
        const std::vector<NotesLine> lines = notesLines(notesFillTable(p.polygon), corrected);
        e.exactly("fill_lines", {lines.front().y, lines.back().y});
        const char* names[] = {"Z", "D", "S", "NX", "NY", "NZ"};
        for (const Json& row : e.data(key)) {
            const NotesLine& line = lines.at(size_t(row["y"].get<double>() - lines.front().y));
            near(line.leftX, row["left"]["X"], "left X");
            near(line.rightX, row["right"]["X"], "right X");
            for (size_t k = 0; k < 6; ++k)
                near(line.left[k], row["left"][names[k]], names[k]), near(line.right[k], row["right"][names[k]], names[k]);
            EXPECT_EQ(notesPixels(line), row["pixel_count"].get<int>()) << key << ", line " << row["y"];
            const double across = line.rightX - line.leftX;
            std::vector<double> values = line.left;
            size_t done = 0;
            for (int j = 0; j < notesPixels(line); ++j) {
                for (const Json& pixel : row["pixels"])
                    if (pixel[0] == j) {
                        ++done;
                        near(line.leftX + j, pixel[1], "X");
                        near(values[0], pixel[2], "Zps");
                        near(p.surface.ia * p.surface.kd + values[1] + values[2], pixel[3], "Gouraud");
                        const dvec3 n = unitVector(dvec3(values[3], values[4], values[5]));
                        for (int axis = 0; axis < 3; ++axis) near(n[axis], pixel[4][size_t(axis)], "normal");
                        near(illuminated(n, p.light, p.view, p.surface).sum(), pixel[5], "Phong");
                        const float pass = float(byPass(n, p.light, p.view, p.surface));
                        EXPECT_LE(std::abs(double(pass) - pixel[5].get<double>()), tolerance().float32) << "Phong by the pass";
                    }
                for (size_t k = 0; k < 6; ++k) values[k] += across != 0 ? (line.right[k] - line.left[k]) / across : 0;
            }
            EXPECT_EQ(done, row["pixels"].size());
        }
    }
}
GOLDEN(s173_phong_mid_normal) {
    const dvec3 n = (vectorOf<dvec3>(e.input("N_left")) + vectorOf<dvec3>(e.input("N_right"))) / 2.0;
    e.binary64("interpolated", jsonOf(n));
    e.binary64("length", magnitude(n));
    e.binary64("normalised", jsonOf(unitVector(n)));
}

}  // namespace
}  // namespace plumb::golden
