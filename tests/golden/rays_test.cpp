// SPDX-License-Identifier: MIT
// Section 18: rays. Where the product has the step, it is asked in float32; the notes' intermediate numbers are their formulas in binary64.
#include "pipeline/passes/resolve.h"
#include "pipeline/render/rays/trace_frame.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/sha256.h"
#include "tests/golden/golden.h"
#include "tests/support/ray_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb::golden {
namespace {

using glm::dvec3;
using test::addRayMaterial;

dvec3 inputVector(const Entry& e, const char* name) { return vectorOf<dvec3>(e.input(name)); }

// The notes' quadratic along start + t direction.
struct Quadratic {
    double a, b, c;
    Quadratic(const dvec3& start, const dvec3& direction, const dvec3& centre, double radius)
        : a(glm::dot(direction, direction)),
          b(2 * glm::dot(direction, start - centre)),
          c(glm::dot(start - centre, start - centre) - radius * radius) {}
    double discriminant() const { return b * b - 4 * a * c; }
    double root(double sign) const { return (-b + sign * std::sqrt(discriminant())) / (2 * a); }
    Json abc() const { return {a, b, c}; }
};

// The product's hit, as a parameter of the unnormalised direction.
double tOfSphere(const dvec3& start, const dvec3& direction, const dvec3& centre, double radius) {
    const gpu::SphereHit hit = gpu::hitSphere(glm::vec3(start), gpu::unitLength(glm::vec3(direction)), glm::vec3(centre), float(radius), 0,
                                              gpu::kStartElsewhere, false, false);
    return double(hit.t) / glm::length(direction);
}
gpu::PlaneHit hitOf(const dvec3& start, const dvec3& direction, const dvec3& normal, const dvec3& anchor) {
    constexpr float kFar = 1e30f;
    return gpu::hitPlane(glm::vec3(start), gpu::unitLength(glm::vec3(direction)), {glm::vec3(normal), float(glm::dot(normal, anchor))},
                         {1, 0, 0, 0}, {0, 1, 0, 0}, {-kFar, kFar, -kFar, kFar}, true, gpu::kStartElsewhere);
}

GOLDEN(s181_ray_counts) {
    const auto rays = [](bool both, uint32_t depth) {
        Scene s = test::rayScene();
        const uint32_t m = addRayMaterial(s, glm::vec3(0.2f), both ? 0.4f : 0.9f, both ? 0.4f : 0.0f, 1.0f);
        for (int i = 0; i < (both ? 40 : 1); ++i)
            for (const double side : {-1.0, 1.0}) {
                PlaneShape p;
                p.point = {0, 0, side * (20 + i)};
                p.normal = {0, 0, -side};
                p.v = {0, side, 0};
                p.material = m;
                s.planes.push_back(p);
            }
        s.camera->eye = {0, 0, 0};
        s.camera->fovYDegrees = 0.01;
        RenderRequest request;
        request.width = request.height = 1;
        request.shading = Shading::ray;
        request.maxDepth = depth;
        uint64_t sum = 0;
        for (const auto& r : renderCpu(s, request).counters.rays) sum += r.primary + r.reflected + r.refracted;
        return sum;
    };
    Json both = Json::array(), mirrors = Json::array();
    for (const Json& depth : e.input("depth"))
        both.push_back(rays(true, depth.get<uint32_t>())), mirrors.push_back(rays(false, depth.get<uint32_t>()));
    e.exactly("both", both);
    e.exactly("reflection_only", mirrors);
    e.exactly("depth4_both", rays(true, 4));
    e.exactly("depth4_reflection_only", rays(false, 4));
    e.exactly("depth4_calls_including_depth0", rays(true, 5));  // one level more: the calls that return black at once
}

GOLDEN(s1821_ray_sphere) {
    const dvec3 start = inputVector(e, "start"), direction = inputVector(e, "through") - start, centre = inputVector(e, "centre");
    const double radius = e.input("radius").get<double>();
    const Quadratic q(start, direction, centre, radius);
    e.binary64("direction", jsonOf(direction));
    e.binary64("a_b_c", q.abc());
    e.binary64("discriminant", q.discriminant());
    e.binary64("sqrt_discriminant", std::sqrt(q.discriminant()));
    e.binary64("t_far", q.root(1));
    const double t = tOfSphere(start, direction, centre, radius);
    e.float32("t_near", t);
    e.float32("point", jsonOf(start + t * direction));
    e.binary64("far_point", jsonOf(start + q.root(1) * direction));
}
Quadratic quadraticOf(const Entry& e) {
    return {inputVector(e, "start"), inputVector(e, "direction"), inputVector(e, "centre"), e.input("radius").get<double>()};
}
double productOf(const Entry& e) {
    return tOfSphere(inputVector(e, "start"), inputVector(e, "direction"), inputVector(e, "centre"), e.input("radius").get<double>());
}
GOLDEN(s1821_case_miss) {
    e.binary64("a_b_c", quadraticOf(e).abc());
    e.binary64("discriminant", quadraticOf(e).discriminant());
    EXPECT_EQ(productOf(e), 0);
}
GOLDEN(s1821_case_graze) {
    e.binary64("a_b_c", quadraticOf(e).abc());
    e.binary64("discriminant", quadraticOf(e).discriminant());
    e.float32("t_small", productOf(e));
    e.binary64("t_large", quadraticOf(e).root(1));
}
GOLDEN(s1821_case_behind) {
    e.binary64("a_b_c", quadraticOf(e).abc());
    e.binary64("discriminant", quadraticOf(e).discriminant());
    e.binary64("t_small", quadraticOf(e).root(-1));
    e.binary64("t_large", quadraticOf(e).root(1));
    EXPECT_EQ(productOf(e), 0);
}
GOLDEN(s1821_case_inside) {
    e.binary64("a_b_c", quadraticOf(e).abc());
    e.binary64("discriminant", quadraticOf(e).discriminant());
    e.binary64("t_small", quadraticOf(e).root(-1));
    e.float32("t_large", productOf(e));  // A16: the smallest root ahead
}

GOLDEN(s1822_ray_plane) {
    const dvec3 start = inputVector(e, "start"), direction = inputVector(e, "through") - start, normal = inputVector(e, "normal"),
                anchor = inputVector(e, "anchor");
    const gpu::PlaneHit hit = hitOf(start, direction, normal, anchor);
    e.binary64("direction", jsonOf(direction));
    e.binary64("D", glm::dot(normal, anchor));
    e.binary64("numerator", -(glm::dot(normal, start) - glm::dot(normal, anchor)));
    e.binary64("denominator", glm::dot(normal, direction));
    e.float32("t", double(hit.t) / glm::length(direction));
    e.float32("point", jsonOf(dvec3(hit.point)));
}
GOLDEN(s1822_parallel) {
    const gpu::PlaneHit hit =
        hitOf(inputVector(e, "start"), inputVector(e, "direction"), inputVector(e, "normal"), inputVector(e, "anchor"));
    e.binary64("denominator", glm::dot(inputVector(e, "normal"), inputVector(e, "direction")));
    e.exactly("hit", hit.t > 0 ? 1 : 0);
    EXPECT_EQ(hit.undecided, 1u);
}
GOLDEN(s1822_behind) {
    const dvec3 start = inputVector(e, "start"), direction = inputVector(e, "direction"), normal = inputVector(e, "normal"),
                anchor = inputVector(e, "anchor");
    e.binary64("t", glm::dot(normal, anchor - start) / glm::dot(normal, direction));
    e.exactly("hit", hitOf(start, direction, normal, anchor).t > 0 ? 1 : 0);
}

// R = N + T / (2 N.(-T)), and the product's unit vector for a normal that faces the ray.
dvec3 notesMirror(const dvec3& n, const dvec3& t) { return n + t / (2 * glm::dot(n, -t)); }
dvec3 productMirror(dvec3 n, const dvec3& t) {
    if (glm::dot(n, t) > 0) n = -n;
    const glm::vec3 d = gpu::unitLength(glm::vec3(t));
    return gpu::mirrored(d, glm::vec3(n), -gpu::dot3(d, glm::vec3(n)));
}
GOLDEN(s1823_reflect_ray) {
    const dvec3 n = inputVector(e, "N"), t = inputVector(e, "T"), r = notesMirror(n, t);
    e.binary64("cos_phi", glm::dot(n, -t));
    e.binary64("R", jsonOf(r));
    e.binary64("magnitude", glm::length(r));
    e.float32("R_unit", jsonOf(productMirror(n, t)));
}
GOLDEN(s1823_reflect_ray_grazing) { e.float32("R", jsonOf(productMirror(inputVector(e, "N"), inputVector(e, "T")))); }
GOLDEN(s1823_reflect_ray_backside) {
    const dvec3 n = inputVector(e, "N"), t = inputVector(e, "T");
    e.binary64("cos_phi", glm::dot(n, -t));
    e.binary64("R", jsonOf(notesMirror(-n, t)));  // R'' = -N - T / (2 N.(-T))
    e.float32("R_unit", jsonOf(productMirror(n, t)));
}

GOLDEN(s1824_refract) {
    const dvec3 n = inputVector(e, "N"), t = inputVector(e, "T");
    const double d = e.input("d2").get<double>() / e.input("d1").get<double>(), c = -glm::dot(t, n), radicand = 1 - (1 - c * c) / (d * d);
    const dvec3 through = t / d - (std::sqrt(radicand) - c / d) * n;
    e.binary64("d", d);
    e.binary64("cos_phi1", c);
    e.binary64("radicand", radicand);
    e.binary64("cos_phi2", std::sqrt(radicand));
    e.binary64("Trans", jsonOf(through));
    e.binary64("magnitude", glm::length(through));
}
struct Refraction {
    double square;
    dvec3 direction;
    explicit Refraction(const Entry& e) {
        const glm::vec3 n(inputVector(e, "N")), d = gpu::unitLength(glm::vec3(inputVector(e, "T")));
        const float ratio = e.input("d1").get<float>() / e.input("d2").get<float>(), cosine = -gpu::dot3(d, n);
        const float s = gpu::refractedSquare(cosine, ratio);
        square = s;
        direction = s > 0 ? dvec3(gpu::refracted(d, n, cosine, ratio, s)) : dvec3(0);
    }
};
GOLDEN(s1824_refract_unit) {
    const Refraction r(e);
    e.float32("radicand", r.square);
    e.float32("cos_phi2", std::sqrt(r.square));
    e.float32("Trans", jsonOf(r.direction));
    e.float32("magnitude", glm::length(r.direction));
}
GOLDEN(s1824_total_internal_reflection) {
    e.float32("radicand", Refraction(e).square);
    e.binary64("critical_angle_deg", glm::degrees(std::asin(e.input("d2").get<double>() / e.input("d1").get<double>())));
}
GOLDEN(s1824_refract_normal_incidence) { e.float32("Trans", jsonOf(Refraction(e).direction)); }

std::string colourAt(double x, double z, double square) { return gpu::otherSquare(float(x), float(z), float(square), 1) ? "white" : "red"; }
void checkSquare(Entry& e) {
    const double x = e.input("X").get<double>(), z = e.input("Z").get<double>(), square = e.input("square").get<double>();
    e.binary64("abs_X_mod_200", std::fmod(std::abs(x), 2 * square));
    e.binary64("abs_Z_mod_200", std::fmod(std::abs(z), 2 * square));
    EXPECT_EQ(colourAt(x, z, square), e.data("colour").get<std::string>());
}
GOLDEN(s183_checker_275_450) { checkSquare(e); }
// The entry's name is no C++ name.
[[maybe_unused]] const bool kNegativeSquare = registerEntry("s183_checker_-320_380");
TEST(Golden, s183_checker_minus320_380) {
    Entry e("s183_checker_-320_380");
    checkSquare(e);
    e.finish();
}
GOLDEN(s183_checker_boundaries) {
    const Json &points = e.input("points"), &colours = e.data("colours");
    for (size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(colourAt(points[i][0].get<double>(), points[i][1].get<double>(), e.input("square").get<double>()),
                  colours[i].get<std::string>())
            << points[i];
}

// Primary rays of a picture of the sky, by the twin's counters.
uint64_t primaryRays(uint32_t width, uint32_t height, RayChoices::Sampling sampling, uint32_t samples) {
    RenderRequest request;
    request.width = width;
    request.height = height;
    request.shading = Shading::ray;
    request.maxDepth = 1;
    request.samples = samples;
    request.rays.sampling = sampling;
    return renderCpu(test::rayScene(), request).counters.rays[0].primary;
}
GOLDEN(s1841_corner_sharing) {
    const auto n = e.input("N").get<uint32_t>(), m = e.input("M").get<uint32_t>();
    const uint64_t centre = primaryRays(n, m, RayChoices::Sampling::grid, 1), corners = primaryRays(n, m, RayChoices::Sampling::corners, 1);
    e.exactly("rays_centre", centre);
    e.exactly("rays_corners", corners);
    e.exactly("extra_rays", corners - centre);
    e.binary64("extra_percent", 100 * double(corners - centre) / double(centre));
    e.exactly("rays_naive_4x",
              100 * primaryRays(n / 10, m / 10, RayChoices::Sampling::grid, 4));  // four a pixel: a hundredth of the picture
}
GOLDEN(s1841_corner_average) {
    std::vector<float> linear;
    for (const Json& row : e.input("corner_values"))
        for (const Json& value : row)
            for (int k = 0; k < 3; ++k) linear.push_back(value.get<float>());
    const std::vector<int> covered(4, 1);
    std::vector<float> pixel(3);
    std::vector<uint32_t> rgba(1);
    resolveCpu(1, 1, 2, false, gpu::kEncodeLinear, linear, covered, pixel, rgba, 1, 1);
    e.exactly("mean", pixel[0]);
}

GOLDEN(s1842_adaptive_depth) {
    const auto share = e.input("reflectivity_of_surfaces").get<std::vector<float>>();
    const float cutoff = e.input("cutoff").get<float>();
    float weight = 1;
    int traced = 1;
    e.exactly("ray1", 1);
    for (size_t i = 0; i < share.size(); ++i) {
        const gpu::Children c = gpu::childrenOf({0, -1, 0}, {0, 1, 0}, false, share[i], 0, 1, 1, weight, uint32_t(i + 1), 64, cutoff);
        traced += c.mirror;
        weight = c.mirrorWeight;
        e.float32("ray" + std::to_string(i + 2), weight);
    }
    e.exactly("rays_traced", traced);
}

// A floor under a lamp that is straight above, spheres of this translucency between: what is left of the light.
double leftOfLight(float translucency, int spheres) {
    Scene s = test::rayScene();
    s.lights.resize(1);
    s.lights[0] = {};
    s.lights[0].direction = {0, 1, 0};
    s.ambient = glm::vec3(0);
    Material floor;
    floor.ambient = glm::vec3(0);
    floor.diffuse = glm::vec3(0.5f);
    floor.local = 1;
    s.materials.push_back(floor);
    s.planes.push_back(test::floorAt(0, 1, 0, 0));
    const uint32_t m = addRayMaterial(s, glm::vec3(0.1f), 0, translucency, 1.0f);
    for (int i = 0; i < spheres; ++i) s.spheres.push_back(test::ball({0, 3.0 * (i + 1), 0}, 0.5, m));
    s.camera->eye = {6, 1, 0};
    s.camera->forward = glm::normalize(glm::dvec3(-6, -1, 0));
    s.camera->right = {0, 0, -1};
    s.camera->up = glm::cross(s.camera->right, s.camera->forward);
    RenderRequest request;
    request.width = request.height = 1;
    request.shading = Shading::ray;
    request.maxDepth = 1;
    request.planes = kPlaneColour | kPlaneLinear;
    return renderCpu(s, request).frame.linear[0];
}
GOLDEN(s1843_shadow_attenuation) {
    const auto translucency = e.input("translucency").get<float>();
    const double lit = leftOfLight(translucency, 0), one = leftOfLight(translucency, 1) / lit;
    e.float32("factor", one);
    e.float32("reduction_percent", 100 * (1 - one));
    e.exactly("opaque_factor", leftOfLight(0, 1));
    e.float32("two_such_objects", leftOfLight(translucency, 2) / lit);
}

// The C program, literally, in binary64: smaller root only, unnormalised reflected rays, truncation at each level.
struct CProgram {
    static constexpr double kT = 100000;
    std::array<uint64_t, 6> rays{};    // pixels by their number of rays
    uint64_t first[4] = {0, 0, 0, 0};  // background, checkerboard, sphere 1, sphere 2
    uint64_t sum[3] = {0, 0, 0}, depth0 = 0;
    std::vector<uint8_t> bytes;
    struct Traced {
        int rgb[3];
        std::vector<int> path;
        double t;
    };

    static int truncated(int reflected, int local) { return int(0.7 * reflected + 0.3 * local); }

    static bool sphere(const dvec3& o, const dvec3& d, const dvec3& c, double r, double& t) {
        const double a = d.x * d.x + d.y * d.y + d.z * d.z;
        const double b = 2 * d.x * (o.x - c.x) + 2 * d.y * (o.y - c.y) + 2 * d.z * (o.z - c.z);
        const double k =
            c.x * c.x + c.y * c.y + c.z * c.z + o.x * o.x + o.y * o.y + o.z * o.z + 2 * (-c.x * o.x - c.y * o.y - c.z * o.z) - r * r;
        const double discriminant = b * b - 4 * a * k;
        if (discriminant < 0) return false;
        t = (-b - std::sqrt(discriminant)) / (2 * a);
        return t >= 0;
    }

    void trace(int level, const dvec3& o, const dvec3& d, int (&rgb)[3], Traced& seen, uint64_t& calls) {
        if (level == 0) {
            rgb[0] = rgb[1] = rgb[2] = 0;
            ++depth0;
            return;
        }
        ++calls;
        double best = kT;
        int object = 0;
        dvec3 at(0);
        const double slope = d.y;
        if (std::abs(slope) > 0.001) {
            const double t = -(o.y + 500) / slope;
            const dvec3 p = o + t * d;
            if (p.z >= 0 && p.z <= 8000 && t >= 0 && t <= best) best = t, object = 1, at = p;
        }
        const dvec3 centre[2] = {{0, -400, 600}, {-200, -300, 1000}};
        const double radius[2] = {100, 250};
        const int local[2][3] = {{120, 180, 0}, {200, 100, 100}};
        for (int i = 0; i < 2; ++i) {
            double t = 0;
            if (sphere(o, d, centre[i], radius[i], t) && t <= best) best = t, object = 2 + i, at = o + t * d;
        }
        if (calls == 1) seen.t = best;
        seen.path.push_back(object);
        if (object == 0) {
            rgb[0] = rgb[1] = 150, rgb[2] = 255;
        } else if (object == 1) {
            bool flag = at.x >= 0;
            if (std::fmod(std::abs(at.x), 400.0) > 200) flag = !flag;
            if (std::fmod(std::abs(at.z), 400.0) > 200) flag = !flag;
            rgb[0] = 255, rgb[1] = rgb[2] = flag ? 0 : 255;
        } else {
            const dvec3& c = centre[object - 2];
            const dvec3 n = glm::normalize(at - c), v = glm::normalize(d);
            const double cosine = -(v.x * n.x + v.y * n.y + v.z * n.z);
            const dvec3 r = cosine > 0 ? n + v / (2 * cosine) : cosine == 0 ? v : -n - v / (2 * cosine);
            trace(level - 1, at, r, rgb, seen, calls);
            for (int k = 0; k < 3; ++k) rgb[k] = truncated(rgb[k], local[object - 2][k]);
        }
    }
    Traced pixel(int x, int y, uint64_t& calls) {
        Traced seen{};
        trace(5, {0, 0, -800}, {double(x - 600), double(600 - y), 800}, seen.rgb, seen, calls);
        return seen;
    }
    void run() {
        for (int y = 1; y <= 1200; ++y)
            for (int x = 1; x <= 1200; ++x) {
                uint64_t calls = 0;
                const Traced seen = pixel(x, y, calls);
                ++rays[calls];
                ++first[seen.path[0]];
                for (int k = 0; k < 3; ++k) sum[k] += uint64_t(seen.rgb[k]), bytes.push_back(uint8_t(seen.rgb[k]));
            }
    }
};

// The committed scene by the twin, sampled where the program samples: at the far corner of each pixel.
struct ProductFrame {
    std::vector<uint32_t> distance, object;
    std::vector<float> linear;
    ProductFrame() {
        const Scene scene = loadScene({std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/notes-spheres.toml"}, {});
        RenderRequest request;
        request.width = request.height = 1200;
        request.shading = Shading::ray;
        request.background = *scene.background;
        request.maxDepth = scene.maxDepth;
        const Prepared p = prepare(scene, request);
        unit = p.unit;
        const TraceScene traced = traceSceneOf(scene, p);
        gpu::TracePush push = tracePushOf(p, request, traced);
        push.rayOrigin += 0.5f * (push.rayX + push.rayY);
        push.itemCount = 1200 * 1200;
        distance.resize(push.itemCount);
        object.resize(push.itemCount);
        linear.resize(3 * size_t(push.itemCount));
        std::vector<uint64_t> counters(gpu::kCounters);
        traceCpu(push, traced, traceChoicesOf(scene, request, p, traced), {distance, object, linear, {}}, counters, 0);
    }
    size_t at(const Json& pixel) const { return size_t(pixel[1].get<int>() - 1) * 1200 + size_t(pixel[0].get<int>() - 1); }
    // 18.5 counts t in lengths of the unnormalised ray.
    double t(const Json& pixel) const {
        const dvec3 ray(pixel[0].get<int>() - 600, 600 - pixel[1].get<int>(), 800);
        return double(gpu::realOf(int(distance[at(pixel)]))) / unit / glm::length(ray);
    }
    Json rgb(const Json& pixel) const {
        Json bytes = Json::array();
        for (size_t k = 0; k < 3; ++k) bytes.push_back(255 * double(linear[3 * at(pixel) + k]));
        return bytes;
    }
    double unit = 1;
    static const ProductFrame& get() {
        static const ProductFrame kOne;
        return kOne;
    }
};
// Frame in whole levels: plumb render scenes/notes-spheres.toml --sampling notes --levels cut.
const Frame& cutFrame() {
    static const Frame kOne = [] {
        const Scene scene = loadScene({std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/notes-spheres.toml"}, {});
        RenderRequest request;
        request.width = request.height = 1200;
        request.shading = Shading::ray;
        request.encoding = Encoding::linear;
        request.background = *scene.background;
        request.maxDepth = scene.maxDepth;
        request.rays.sampling = RayChoices::Sampling::notes;
        request.rays.cutLevels = true;
        return renderCpu(scene, request).frame;
    }();
    return kOne;
}
int levelOf(const Frame& frame, size_t pixel, size_t channel) { return int(frame.rgba[pixel] >> (8 * channel) & 255u); }
constexpr uint32_t kBoard = 2;  // spheres 0 and 1, then the plane

GOLDEN(s185_scene) {
    e.exactly("sphere1_lowest_y", e.input("sphere1")["centre"][1].get<double>() - e.input("sphere1")["radius"].get<double>());
    e.exactly("sphere2_lowest_y", e.input("sphere2")["centre"][1].get<double>() - e.input("sphere2")["radius"].get<double>());
    const ProductFrame& frame = ProductFrame::get();
    int first = 0, last = 0;
    for (int y = 1; y <= 1200; ++y)
        if (frame.object[size_t(y - 1) * 1200 + 1199] == kBoard) {  // the last column sees no sphere
            if (first == 0) first = y;
            last = y;
        }
    e.exactly("horizon_first_board_row_pixel_y", first);
    e.exactly("last_board_row_pixel_y", last);
}
GOLDEN(s185_sample_pixels) {
    const Json& samples = e.data("samples");
    e.exactly("samples", samples.size());
    const ProductFrame& frame = ProductFrame::get();
    CProgram program;
    for (const Json& s : samples) {
        const Json pixel = {s[0], s[1]};
        uint64_t calls = 0;
        const CProgram::Traced literal = program.pixel(s[0].get<int>(), s[1].get<int>(), calls);
        for (size_t k = 0; k < 3; ++k) {
            const int want = s[2][k].get<int>();
            EXPECT_EQ(literal.rgb[k], want) << s;
            // Each level of mirrors cuts off less than 1, the deeper ones weigh 0.7 of the one before; and a level of the file's tolerance.
            double cut = 0;
            for (uint64_t level = 1; level < calls; ++level) cut = 0.7 * cut + 1;
            const double got = frame.rgb(pixel)[k].get<double>();
            EXPECT_GE(got, want - tolerance().colourLevels) << s;
            EXPECT_LE(got, want + cut + tolerance().colourLevels) << s;
            EXPECT_EQ(levelOf(cutFrame(), frame.at(pixel), k), want) << s;
        }
        if (!s[4].is_null()) {
            EXPECT_NEAR(frame.t(pixel), s[4].get<double>(), tolerance().float32 * std::max(1.0, s[4].get<double>())) << s;
        }
    }
}
void checkHand(Entry& e) {
    const Json& pixel = e.input("pixel");
    const dvec3 ray(pixel[0].get<int>() - 600, 600 - pixel[1].get<int>(), 800);
    const ProductFrame& frame = ProductFrame::get();
    e.binary64("ray", jsonOf(ray));
    e.float32("t", frame.t(pixel));
    e.float32("point", jsonOf(dvec3(0, 0, -800) + frame.t(pixel) * ray));
    e.colour("rgb", frame.rgb(pixel));
}
GOLDEN(s185_hand_checkerboard) { checkHand(e); }
GOLDEN(s185_hand_sphere1) { checkHand(e); }
GOLDEN(s185_truncation) {
    Json result = Json::array(), whole = Json::array();
    for (const Json& c : e.input("cases")) {
        result.push_back(CProgram::truncated(c[0].get<int>(), c[1].get<int>()));
        whole.push_back(0.7 * c[0].get<int>() + 0.3 * c[1].get<int>());
    }
    e.exactly("result", result);
    e.binary64("untruncated", whole);
    e.exactly("float_trap_0.7*90", {int(0.7 * 90), int(0.7 * 170), int(0.7 * 180)});
}
GOLDEN(s185_frame_statistics) {
    CProgram program;
    program.run();
    e.exactly("first_hit_background", program.first[0]);
    e.exactly("first_hit_checkerboard", program.first[1]);
    e.exactly("first_hit_sphere1", program.first[2]);
    e.exactly("first_hit_sphere2", program.first[3]);
    e.exactly("sum_rgb", {program.sum[0], program.sum[1], program.sum[2]});
    e.exactly("rays_per_pixel_histogram_1_to_5", {program.rays[1], program.rays[2], program.rays[3], program.rays[4], program.rays[5]});
    uint64_t total = 0;
    for (size_t i = 1; i < 6; ++i) total += i * program.rays[i];
    e.exactly("rays_total", total);
    e.exactly("pixels_that_reach_depth0", program.depth0);
    EXPECT_EQ(sha256Hex(std::as_bytes(std::span(program.bytes))), e.data("sha256_of_raw_rgb8_rows_top_to_bottom").get<std::string>());
    // The product in float32 against it: where the first hit differs, the edge of an object is within kEdge. A hit is off by at most 12 u of its
    // coordinates (docs/accuracy.md, rays), 2^-10 units at 1600; a pixel is 1.6 units or more there.
    constexpr double kEdge = 0x1p-10;
    const ProductFrame& frame = ProductFrame::get();
    // Whole levels of the product: one level apart where 0.7 r + 0.3 l is whole but for the rounding of float32 or of binary64; more only within
    // kEdge of an edge, as seen by the first ray: a mirror magnifies that offset and the errors of a hit alike, and what a later ray adds (9 u of
    // its length, 2^-7 units at 8000) is below what the offset has grown to on the board (2 * 8000 / 250 * 1.6 kEdge).
    std::array<uint64_t, 2> levels{};
    for (int y = 1; y <= 1200; ++y)
        for (int x = 1; x <= 1200; ++x) {
            const size_t pixel = size_t(y - 1) * 1200 + size_t(x - 1);
            const auto apart = [&](const auto& rgb) {
                int most = 0;
                for (size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(levelOf(cutFrame(), pixel, k) - int(rgb[k])));
                return most;
            };
            const int most = apart(std::span(program.bytes).subspan(3 * pixel, 3));
            if (most <= 1) {
                levels[0] += most == 1;
                continue;
            }
            ++levels[1];
            bool near = false;
            for (const double dx : {-kEdge, 0.0, kEdge})
                for (const double dy : {-kEdge, 0.0, kEdge}) {
                    uint64_t calls = 0;
                    CProgram::Traced seen{};
                    program.trace(5, {0, 0, -800}, {x - 600 + dx, 600 - y + dy, 800}, seen.rgb, seen, calls);
                    near |= apart(seen.rgb) <= 1;
                }
            EXPECT_TRUE(near) << "pixel " << x << ", " << y << ": " << most << " levels apart";
        }
    std::printf("18.5 in whole levels: %llu of 1440000 pixels are one level apart, %llu more, each within 2^-10 px of an edge\n",
                static_cast<unsigned long long>(levels[0]), static_cast<unsigned long long>(levels[1]));
    uint64_t differing = 0;
    for (int y = 1; y <= 1200; ++y)
        for (int x = 1; x <= 1200; ++x) {
            const auto literal = [&](double dx, double dy) {
                uint64_t calls = 0;
                CProgram::Traced seen{};
                program.trace(5, {0, 0, -800}, {x - 600 + dx, 600 - y + dy, 800}, seen.rgb, seen, calls);
                return seen.path[0];
            };
            const uint32_t object = frame.object[size_t(y - 1) * 1200 + size_t(x - 1)];
            const int mine = object == gpu::kNoObject ? 0 : object == kBoard ? 1 : int(object) + 2;
            if (mine == literal(0, 0)) continue;
            ++differing;
            bool near = false;
            for (const double dx : {-kEdge, 0.0, kEdge})
                for (const double dy : {-kEdge, 0.0, kEdge}) near |= literal(dx, dy) == mine;
            EXPECT_TRUE(near) << "pixel " << x << ", " << y << ": the product sees " << mine;
        }
    std::printf("18.5: the first hit differs in %llu of 1440000 pixels, each within 2^-10 px of an edge\n",
                static_cast<unsigned long long>(differing));
}
GOLDEN(s185_colour_table_dead_code) {
    Json levels = Json::array(), indices = Json::array();
    const auto index = [](double v) { return int(std::nearbyint(std::log(v) / std::log(1.25) - 19.6)); };
    int level = e.input("clip")[0].get<int>();
    for (int i = 0; i < 6; ++i, level = int(level * 1.25)) levels.push_back(level), indices.push_back(index(level));
    e.exactly("levels", levels);
    e.exactly("entries", 6 * 6 * 6 + 1);
    e.exactly("index_of_levels", indices);
    e.exactly("index_of_80_and_244", {index(e.input("clip")[0].get<double>()), index(e.input("clip")[1].get<double>())});
}

}  // namespace
}  // namespace plumb::golden
