// SPDX-License-Identifier: MIT
// Random small scenes that try to break the bounds of choices: every choice with a bound, held against the truth and against the default picture.
// The seed is printed; PLUMB_SEED states another, PLUMB_CASE runs that case alone. PLUMB_LONG=1 draws more.
#include "pipeline/measure/error_bound.h"
#include "pipeline/render/bounds/bound.h"
#include "tests/support/ray_scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;
using test::Random;

uint32_t numberOf(const char* name, uint32_t otherwise) {
    const char* stated = std::getenv(name);
    return stated ? uint32_t(std::strtoul(stated, nullptr, 10)) : otherwise;
}

// Calls draw(i, random) for each case, or for the one that PLUMB_CASE names, until one fails.
template <class Draw>
void eachCase(const char* what, uint32_t plain, uint32_t thorough, const Draw& draw) {
    const uint32_t seed = numberOf("PLUMB_SEED", 1), count = std::getenv("PLUMB_LONG") ? thorough : plain,
                   only = numberOf("PLUMB_CASE", UINT32_MAX);
    fmt::print("{}: seed {}, {} cases\n", what, seed, count);
    for (uint32_t i = only == UINT32_MAX ? 0 : only; i < (only == UINT32_MAX ? count : only + 1); ++i) {
        Random random(seed * 1000003u + i);
        SCOPED_TRACE(fmt::format("PLUMB_SEED={} PLUMB_CASE={}", seed, i));
        draw(i, random);
        if (testing::Test::HasFailure()) return;
    }
}

// How far bounds are from errors: bound / error of rms and of max, by choice.
class Tightness {
public:
    void add(const std::string& choice, const FrameError& error, const ErrorBound& bound) {
        const auto ratio = [&](double most, double off) {
            if (off > 0 && std::isfinite(most)) return most / off;
            return off > 0 ? ErrorBound::kNoBound : 1.0;
        };
        rms_[choice].push_back(ratio(bound.rms, error.picture.rms));
        max_[choice].push_back(ratio(bound.max, error.picture.max));
    }
    void print() {
        for (auto& [choice, values] : rms_)
            fmt::print("  {:<24} {:5} rows, bound / error: rms median {:.3g}, max median {:.3g}, {} without a largest\n", choice,
                       values.size(), median(values), median(max_[choice]),
                       std::count(max_[choice].begin(), max_[choice].end(), ErrorBound::kNoBound));
    }

private:
    static double median(std::vector<double>& values) {
        std::nth_element(values.begin(), values.begin() + ptrdiff_t(values.size() / 2), values.end());
        return values[values.size() / 2];
    }
    std::map<std::string, std::vector<double>> rms_, max_;
};

// A row against its bound, as measure judges it.
void judge(const std::string& choice, const Frame& base, const Frame& frame, const Truth& truth, bool transparent, const ColourMoves& moves,
           double steps, Tightness& tightness) {
    const FrameError error = errorOf(frame, truth, Encoding::srgb, transparent);
    const ErrorBound bound = errorBoundOf(base, truth, transparent, moves, steps);
    for (const std::optional<BoundBreach>& breach : {breachOfMoves(base, frame, moves), breachOf(error, bound, frame.width)})
        if (breach)
            ADD_FAILURE() << choice << ": " << breach->figure << " at (" << breach->x << ", " << breach->y << ") is " << breach->error
                          << ' ' << breach->unit << ", bound " << breach->bound;
    if (error.pixels > 0) tightness.add(choice, error, bound);
}

double powerOfTen(Random& random, double low, double high) { return std::pow(10.0, random(low, high)); }
template <class T>
const T& oneOf(Random& random, const std::vector<T>& values) {
    return values[random.below(uint32_t(values.size()))];
}

Material randomMaterial(Random& random) {
    Material m;
    const double bright = oneOf<double>(random, {1, 1, 1, 3});  // files may state factors above 1
    const auto colour = [&](double most) { return glm::vec3(dvec3(random(0, most), random(0, most), random(0, most))); };
    m.ambient = colour(0.2);
    m.diffuse = random.below(4) == 0 ? glm::vec3(0) : colour(bright);
    m.specular = random.below(3) == 0 ? glm::vec3(0) : colour(bright);
    m.emission = random.below(4) == 0 ? colour(0.3) : glm::vec3(0);
    m.shininess = oneOf<float>(random, {0, 1, 1, 1, 2, 5, 30, 200, 1e4f, 1e6f, 0.5f});
    return m;
}

// A ball of few triangles, smooth: each vertex's normal is its own direction.
TriangleMesh coarseBall(Random& random, uint32_t material) {
    const uint32_t around = 3 + random.below(8), along = 2 + random.below(4);
    TriangleMesh mesh = test::soupOf({}, 1);
    for (uint32_t j = 0; j <= along; ++j)
        for (uint32_t i = 0; i < around; ++i) {
            const double polar = 3.14159265358979 * j / along, turn = 6.28318530717958 * i / around;
            mesh.positions.emplace_back(dvec3(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn)));
            mesh.normals.push_back(mesh.positions.back());
            mesh.vertexMaterial.push_back(material);
        }
    for (uint32_t j = 0; j < along; ++j)
        for (uint32_t i = 0; i < around; ++i) {
            const uint32_t a = j * around + i, b = j * around + (i + 1) % around, face = uint32_t(mesh.faceCentre.size());
            mesh.triangles.push_back({{a, b + around, a + around}, face});
            mesh.triangles.push_back({{a, b, b + around}, face});
            mesh.faceCentre.push_back((mesh.positions[a] + mesh.positions[b] + mesh.positions[a + around] + mesh.positions[b + around]) *
                                      0.25f);
            mesh.faceNormal.push_back(glm::vec3(glm::normalize(dvec3(mesh.faceCentre.back()) + dvec3(0, 1e-9, 0))));
            mesh.faceMaterial.push_back(material);
        }
    mesh.boundsMin = glm::vec3(-1);
    mesh.boundsMax = glm::vec3(1);
    return mesh;
}

// Large triangles with normals that have little to do with them.
TriangleMesh wildTriangles(Random& random, uint32_t material) {
    std::vector<test::Corners> corners(1 + random.below(4));
    for (test::Corners& c : corners)
        for (glm::vec3& p : c) p = random.direction() * float(random(0.3, 1));
    Random normals(random.below(1u << 30));
    TriangleMesh mesh = test::soupOf(corners, 1, &normals);
    // Some lean together.
    if (random.below(2) == 0)
        for (size_t i = 0; i < mesh.normals.size(); ++i)
            mesh.normals[i] = glm::vec3(glm::normalize(dvec3(mesh.faceNormal[i / 3]) + dvec3(mesh.normals[i]) * powerOfTen(random, -3, 0)));
    // One face that is not flat: its centre lies on none of its triangles.
    if (random.below(2) == 0) {
        for (TriangleMesh::Triangle& t : mesh.triangles) t.face = 0;
        glm::vec3 centre(0);
        for (const glm::vec3& p : mesh.positions) centre += p / float(mesh.positions.size());
        mesh.faceCentre = {centre};
        mesh.faceNormal.resize(1);
        mesh.faceMaterial.resize(1);
    }
    for (uint32_t& m : mesh.faceMaterial) m = material;
    for (uint32_t& m : mesh.vertexMaterial) m = material;
    return mesh;
}

glm::dmat4 randomTransform(Random& random, const dvec3& place) {
    glm::dmat3 m(1);
    const uint32_t steps = 1 + random.below(3);
    for (uint32_t k = 0; k < steps; ++k) {
        glm::dmat3 step(1);
        switch (random.below(4)) {
            case 0:
                for (int i = 0; i < 3; ++i) step[i][i] = powerOfTen(random, -2, 0.3) * (random.below(4) == 0 ? -1 : 1);
                break;
            case 1:
                step[int(random.below(3))][int(random.below(3))] += random(-2, 2);
                break;
            default: {
                const dvec3 axis(random.direction());
                const double angle = random(0, 6.28), c = std::cos(angle), s = std::sin(angle);
                for (int i = 0; i < 3; ++i) {
                    dvec3 e(0);
                    e[i] = 1;
                    step[i] = e * c + glm::cross(axis, e) * s + axis * (glm::dot(axis, e) * (1 - c));
                }
            }
        }
        m = step * m;
    }
    // As large as the view, whatever the chain did.
    double largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max(largest, glm::length(m[i]));
    glm::dmat4 whole(m * (random(0.7, 2.5) / largest));
    whole[3] = glm::dvec4(place, 1);
    return whole;
}

Light randomLight(Random& random, const Scene& scene) {
    Light light;
    light.intensity = glm::vec3(dvec3(random(0, 1), random(0, 1), random(0, 1)));
    light.directional = random.below(2) == 0;
    light.direction = dvec3(random.direction());
    if (random.below(3) == 0)
        light.direction = dvec3(0.3 * random(-1, 1), 0.3 * random(-1, 1), random.below(2) ? 1 : -1);  // before or behind what is seen
    if (light.directional) return light;
    light.attenuation = oneOf<Attenuation>(random, {Attenuation::none, Attenuation::inverse, Attenuation::inverseSquare});
    light.position = {random(-3, 3), random(-3, 3), random(-8, 2)};
    if (!scene.objects.empty() && random.below(2) == 0) {  // near a corner or a face's centre
        const Object& object = oneOf(random, scene.objects);
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        const glm::vec3& near = random.below(2) ? oneOf(random, mesh.positions) : oneOf(random, mesh.faceCentre);
        light.position = dvec3(object.worldFromObject * glm::dvec4(dvec3(near), 1)) + dvec3(random.direction()) * powerOfTen(random, -3, 0);
        light.intensity *= float(powerOfTen(random, -3, 0));
    }
    return light;
}

constexpr uint32_t kWidth = 28, kHeight = 20;

RenderRequest requestOf(Shading shading) {
    RenderRequest r;
    r.width = kWidth;
    r.height = kHeight;
    r.shading = shading;
    r.threads = 1;
    r.planes = kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
    return r;
}

Scene rasterScene(Random& random) {
    Scene scene;
    scene.path = "in memory";
    scene.camera = Camera{};
    scene.camera->focalPixels = random(12, 40);
    scene.camera->near = test::kNear;
    scene.cullBackFaces = random.below(2) == 0;
    scene.leftHanded = random.below(4) == 0;
    scene.ambient = glm::vec3(float(random(0, 1)));
    const uint32_t objects = 1 + random.below(3);
    for (uint32_t i = 0; i < objects; ++i) {
        scene.materials.push_back(randomMaterial(random));
        TriangleMesh mesh = random.below(2) ? coarseBall(random, i) : wildTriangles(random, i);
        test::addObject(scene, std::move(mesh), randomTransform(random, {random(-0.5, 0.5), random(-0.5, 0.5), random(-6, -2)}));
    }
    const uint32_t lights = random.below(4);
    for (uint32_t i = 0; i < lights; ++i) scene.lights.push_back(randomLight(random, scene));
    return scene;
}

// The choices with a bound of a raster picture, one at a time and together.
std::vector<std::pair<const char*, Trade>> trades() {
    std::vector<std::pair<const char*, Trade>> all(6);
    all[0].first = "normals as-interpolated";
    all[0].second.unitNormals = false;
    all[1].first = "specular schlick";
    all[1].second.specular = Trade::Specular::schlick;
    all[2].first = "specular native";
    all[2].second.specular = Trade::Specular::native;
    all[3].first = "encode native";
    all[3].second.nativeEncode = true;
    all[4] = {"normals and schlick", all[1].second};
    all[4].second.unitNormals = false;
    all[5] = {"normals and natives", all[2].second};
    all[5].second.unitNormals = false;
    all[5].second.nativeEncode = true;
    return all;
}

TEST(BoundOracle, NoRasterChoiceIsBeyondItsBound) {
    Tightness tightness;
    eachCase("raster", 2400, 40000, [&](uint32_t, Random& random) {
        const Scene scene = rasterScene(random);
        RenderRequest request = requestOf(
            oneOf<Shading>(random, {Shading::phong, Shading::phong, Shading::phong, Shading::gouraud, Shading::flat, Shading::flat}));
        request.samples = oneOf<uint32_t>(random, {1, 1, 1, 4, 16});
        request.transparent = random.below(4) == 0;
        request.distantViewer = random.below(4) == 0;
        request.background = glm::vec3(float(random(0, 1)));
        const Frame base = renderCpu(scene, request).frame;
        const Truth truth = truthOf(scene, request);
        for (const auto& [name, trade] : trades()) {
            RenderRequest traded = request;
            traded.trade = trade;
            const Frame frame = renderCpu(scene, traded).frame;
            const ColourBound all = boundOfTrade(scene, traded);
            if (all.proved) judge(name, base, frame, truth, request.transparent, {all.linear, all.darker}, all.steps, tightness);
            if (request.samples != 1) continue;
            const ColourBound seen = boundOfTrade(scene, traded, &base);
            if (seen.proved && !seen.brighterAt.empty())
                judge(std::string(name) + ", seen", base, frame, truth, request.transparent, {seen.brighterAt, seen.darkerAt}, seen.steps,
                      tightness);
        }
    });
    tightness.print();
}

// One triangle that fills the view, normals far apart, a highlight alone: R.V rises and falls by most of what is proved.
TEST(BoundOracle, NoHighlightIsBeyondItsBound) {
    double reached = 0;
    eachCase("highlights", 3000, 60000, [&](uint32_t, Random& random) {
        Scene scene;
        scene.path = "in memory";
        scene.camera = Camera{};
        scene.camera->focalPixels = 8;
        scene.camera->near = test::kNear;
        scene.cullBackFaces = false;
        Material shining;
        shining.ambient = shining.diffuse = glm::vec3(0);
        shining.specular = glm::vec3(1);
        shining.shininess = float(powerOfTen(random, 0, 2));
        scene.materials = {shining};
        TriangleMesh mesh = test::soupOf({{glm::vec3(-8, -6, -4), glm::vec3(8, -6, -4), glm::vec3(0, 12, -4)}}, 1);
        const double apart = powerOfTen(random, -1, 1);
        const dvec3 middle(random.direction());
        for (glm::vec3& n : mesh.normals) n = glm::vec3(glm::normalize(middle + dvec3(random.direction()) * apart));
        Light sun;
        sun.direction = dvec3(random.direction());
        // A cone of normals about the view with the lamp behind the eye: in its middle the normal is shortest and R.V is 1.
        if (random.below(2) == 0) {
            for (size_t i = 0; i < 3; ++i)
                mesh.normals[i] =
                    glm::vec3(glm::normalize(dvec3(std::cos(2.0944 * double(i)), std::sin(2.0944 * double(i)), 1 / std::min(apart, 1.0))));
            sun.direction = dvec3(0, 0, 1) + dvec3(random.direction()) * powerOfTen(random, -3, -1);
        }
        test::addObject(scene, std::move(mesh));
        scene.lights = {sun};
        RenderRequest request = requestOf(Shading::phong);
        request.width = 13;  // odd, so that a pixel looks along the axis
        request.height = 9;
        const Frame base = renderCpu(scene, request).frame;
        request.trade.unitNormals = false;
        const ColourBound bound = boundOfTrade(scene, request, &base);
        ASSERT_TRUE(bound.proved);
        const Frame frame = renderCpu(scene, request).frame;
        const ColourMoves moves{bound.brighterAt, bound.darkerAt};
        const std::optional<BoundBreach> breach = breachOfMoves(base, frame, moves);
        if (breach) ADD_FAILURE() << breach->error << " at (" << breach->x << ", " << breach->y << "), bound " << breach->bound;
        if (bound.linear.x < 0.9)
            for (size_t i = 0; i < base.linear.size(); ++i)
                reached = std::max(reached, std::abs(double(frame.linear[i]) - double(base.linear[i])) / bound.linear.x);
    });
    fmt::print("  highlights reach {:.3f} of their bound\n", reached);
}

Scene tracedScene(Random& random) {
    Scene scene = test::rayScene();
    scene.ambient = glm::vec3(float(random(0, 1)));
    scene.cullBackFaces = true;
    const auto paint = [&] {
        Material m = randomMaterial(random);
        m.reflect = random.below(3) == 0 ? 0 : float(random(0, 1));
        m.transmit = random.below(2) == 0 ? 0 : float(random(0, 1)) * (1 - m.reflect);
        m.local = random.below(2) == 0 ? -1.0f : float(random(0, 1)) * (1 - m.reflect - m.transmit);
        m.refractiveIndex = oneOf<float>(random, {1, 1.1f, 1.5f, 2.4f});
        scene.materials.push_back(m);
        return uint32_t(scene.materials.size() - 1);
    };
    const uint32_t balls = 1 + random.below(4);
    for (uint32_t i = 0; i < balls; ++i) {
        SphereShape s;
        s.centre = {random(-2, 2), random(-0.5, 2.5), random(-2, 2.5)};
        s.radius = random(0.3, 1.2);
        s.material = paint();
        scene.spheres.push_back(s);
    }
    if (random.below(2)) {
        PlaneShape floor;
        floor.material = paint();
        if (random.below(2)) floor.square = 0.7, floor.otherMaterial = paint();
        floor.point.y = -0.7;
        scene.planes.push_back(floor);
    }
    if (random.below(3) == 0) {
        const uint32_t material = paint();
        test::addObject(scene, random.below(2) ? coarseBall(random, material) : wildTriangles(random, material),
                        randomTransform(random, {random(-1, 1), random(0, 2), random(-1, 2)}));
    }
    scene.lights.clear();
    const uint32_t lights = random.below(4);
    for (uint32_t i = 0; i < lights; ++i) {
        scene.lights.push_back(randomLight(random, scene));
        Light& light = scene.lights.back();
        if (random.below(2)) {  // near a sphere
            const SphereShape& s = oneOf(random, scene.spheres);
            light.directional = false;
            light.attenuation = Attenuation::inverseSquare;
            light.position = s.centre + dvec3(random.direction()) * (s.radius + powerOfTen(random, -1, 0));
        }
    }
    return scene;
}

TEST(BoundOracle, NoDepthOrCutoffIsBeyondItsBound) {
    Tightness tightness;
    eachCase("rays", 80, 2000, [&](uint32_t, Random& random) {
        const Scene scene = tracedScene(random);
        RenderRequest base = requestOf(Shading::ray);
        base.width = 16;
        base.height = 12;
        base.background = *scene.background;
        base.samples = oneOf<uint32_t>(random, {1, 1, 4});
        base.transparent = random.below(4) == 0;
        base.maxDepth = oneOf<uint32_t>(random, {1, 2, 3, 5, 5, 7});
        base.minWeight = oneOf<float>(random, {0, 0, 0.01f, 0.1f});
        base.rays.sampling =
            base.samples == 1 ? oneOf<Sampling>(random, {Sampling::grid, Sampling::grid, Sampling::corners}) : Sampling::grid;
        const Frame plain = renderCpu(scene, base).frame;
        const Truth truth = truthOf(scene, base);
        const BoundOfRays bounds(scene, base);
        const auto row = [&](const std::string& name, const RenderRequest& request) {
            BoundOfRays::Moves moves = bounds.of(request);
            if (moves.proved)
                judge(name, plain, renderCpu(scene, request).frame, truth, base.transparent,
                      {std::move(moves.brighter), std::move(moves.darker)}, 0, tightness);
        };
        for (const uint32_t depth : {1u, 2u, 3u, 5u, 9u}) {
            RenderRequest request = base;
            request.maxDepth = depth;
            if (depth != base.maxDepth) row(depth > base.maxDepth ? "deeper" : "less deep", request);
        }
        for (const float least : {0.0f, 1.0f / 256, 0.01f, 0.1f}) {
            RenderRequest request = base;
            request.minWeight = least;
            if (least != base.minWeight) row(least < base.minWeight ? "smaller cutoff" : "larger cutoff", request);
        }
    });
    tightness.print();
}

}  // namespace
}  // namespace plumb
