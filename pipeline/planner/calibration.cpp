// SPDX-License-Identifier: MIT
#include "pipeline/planner/calibration.h"

#include "host/cache.h"
#include "host/error.h"
#include "pipeline/planner/ball.h"
#include "pipeline/scene/sha256.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr uint32_t kFewRings = 8, kManyRings = 100;
constexpr uint32_t kWidth = 384, kHeight = 288, kTiny = 16;  // pixels
constexpr uint32_t kFewLights = 2, kManyLights = 6;
constexpr double kUnsteady = 0.25;  // share of the least time by which a quarter of the times may be above it
constexpr size_t kRounds = 9, kLeastRounds = 3;
constexpr double kLimitMs = 1000;  // after which no further round begins

double processorMs() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

// A ball of `rings`, seen so large that it fills the view or so small that it covers little of it.
Scene ballScene(uint32_t rings, uint32_t lights, bool fills) {
    Scene scene;
    scene.path = "calibration";
    scene.materials.resize(1);
    scene.materials[0].specular = glm::vec3(0.4f);
    scene.materials[0].shininess = 40;
    scene.meshes.push_back(ballMesh(rings, scene.materials));
    scene.objects.push_back({});
    scene.objects[0].name = "ball";
    for (uint32_t i = 0; i < lights; ++i) {
        Light light;
        light.directional = false;
        light.position = {4 * std::cos(i), 3, 4 + std::sin(i)};
        light.intensity = glm::vec3(1.0f / float(lights));
        scene.lights.push_back(light);
    }
    Camera camera;
    camera.eye = {0, 0, fills ? 1.6 : 12};
    camera.fovYDegrees = 50;
    camera.focusDistance = camera.eye.z;
    scene.camera = camera;
    return scene;
}

// Mirrors beside one another over a floor.
Scene mirrorScene() {
    Scene scene = ballScene(kFewRings, 2, false);
    scene.objects.clear();
    scene.meshes.clear();
    scene.materials[0].reflect = 0.5f;
    scene.materials[0].statesRays = true;
    for (const double x : {-1.1, 1.1}) {
        SphereShape sphere;
        sphere.centre = {x, 0, 0};
        scene.spheres.push_back(sphere);
    }
    PlaneShape floor;
    floor.point = {0, -1, 0};
    scene.planes.push_back(floor);
    scene.camera->eye = {0, 0.5, 6};
    return scene;
}

RenderRequest requestOf(Shading shading, uint32_t width, uint32_t height) {
    RenderRequest request;
    request.shading = shading;
    request.width = width;
    request.height = height;
    request.threads = 0;
    return request;
}

// A picture of the calibration with its least time and how far a quarter of its times were above that.
struct Timed {
    const Scene* scene = nullptr;
    RenderRequest request;
    std::vector<double> ms;
    Work work;
    double least() const { return *std::min_element(ms.begin(), ms.end()); }
    double spread() const {
        std::vector<double> sorted = ms;
        std::sort(sorted.begin(), sorted.end());
        return sorted[sorted.size() / 4] - sorted[0];
    }
};

class Calibrating {
public:
    explicit Calibrating(const std::function<RenderResult(const Scene&, const RenderRequest&)>& draw) : draw_(draw) {
        add("tiny", few_, requestOf(Shading::unlit, kTiny, kTiny));
        add("triangles", many_, requestOf(Shading::unlit, kTiny, kTiny));
        RenderRequest precise = requestOf(Shading::unlit, kTiny, kTiny);
        precise.trade.precision = Precision::blockInteger;
        add("integers", many_, precise);
        precise.trade.precision = Precision::fp64;
        add("binary64", many_, precise);
        add("flat", many_, requestOf(Shading::flat, kTiny, kTiny));
        add("samples", far_, requestOf(Shading::unlit, kWidth, kHeight));
        add("unlit", few_, requestOf(Shading::unlit, kWidth, kHeight));
        const RenderRequest phong = requestOf(Shading::phong, kWidth, kHeight);
        add("phong", few_, phong);
        add("lights", lit_, phong);
        for (const TradeAxis& axis : kTradeAxes)
            for (const TradeChoice& choice : axis.choices.subspan(1)) {
                const std::string name = axis.name;
                if (name != "specular" && name != "light-vector" && name != "interpolation" && name != "normals") continue;
                if (choice.verdict != Verdict::bits) continue;
                RenderRequest request = phong;
                choice.choose(request.trade);
                add(name + "=" + choice.word, few_, request);
            }
        add("rays", mirrors_, requestOf(Shading::ray, kWidth / 4, kHeight / 4));
    }

    Calibration run() {
        const auto begin = std::chrono::steady_clock::now();
        const auto elapsed = [&] { return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count(); };
        for (auto& [name, picture] : pictures_) warmUp(name, picture);
        const double warm = elapsed();
        for (size_t round = 0; round < kRounds && (round < kLeastRounds || elapsed() - warm < kLimitMs); ++round)
            for (auto& [name, picture] : pictures_)
                if (!missing(name)) picture.ms.push_back(draw_(*picture.scene, picture.request).totalMs);
        Calibration calibration;
        calibration.costs = costs();
        calibration.twinRay = twinRay();
        const Timed& phong = of("phong");
        calibration.steady = phong.spread() < kUnsteady * phong.least();
        calibration.ms = elapsed();
        return calibration;
    }

private:
    void add(const std::string& name, const Scene& scene, RenderRequest request) { pictures_[name] = {&scene, std::move(request), {}, {}}; }
    bool missing(const std::string& name) const { return std::find(missing_.begin(), missing_.end(), name) != missing_.end(); }

    // The first draw makes kernels and counts; a device may lack binary64.
    void warmUp(const std::string& name, Timed& picture) {
        try {
            const RenderResult result = draw_(*picture.scene, picture.request);
            picture.work = workOf(*picture.scene, picture.request, countedOf(result, picture.request));
        } catch (const Error& error) {
            if (name != "binary64" || error.exit() == Exit::interrupted) throw;
            missing_.push_back(name);
        }
    }

    const Timed& of(const std::string& name) const { return pictures_.at(name); }
    // Nanoseconds by which one picture takes longer than another; 0 where their times do not tell.
    double longer(const std::string& one, const std::string& other) const {
        const Timed &a = of(one), &b = of(other);
        const double difference = a.least() - b.least();
        return std::abs(difference) <= std::max(a.spread(), b.spread()) ? 0 : 1e6 * difference;
    }

    UnitCosts costs() const {
        const auto positive = [](double ns) { return std::max(0.0, ns); };
        UnitCosts c;
        c[Unit::picture] = 1e6 * of("tiny").least();
        const Work &many = of("triangles").work, &phong = of("phong").work;
        // A vertex and a triangle are not told apart here; each gets half of what a ball of many takes.
        const double ball = positive(1e6 * (of("triangles").least() - of("tiny").least()));
        c[Unit::triangle] = ball / 2 / many[Unit::triangle];
        c[Unit::vertex] = ball / 2 / many[Unit::vertex];
        c[Unit::vertexInteger] = c[Unit::vertex] + positive(longer("integers", "triangles")) / many[Unit::vertex];
        c[Unit::vertex64] = c[Unit::vertex] + (missing("binary64") ? 0 : positive(longer("binary64", "triangles")) / many[Unit::vertex]);
        c[Unit::corner] = positive(longer("flat", "triangles")) / of("flat").work[Unit::corner];
        c[Unit::sample] = positive(1e6 * (of("samples").least() - of("tiny").least())) / of("samples").work[Unit::sample];
        c[Unit::covered] = positive(longer("unlit", "samples")) / of("unlit").work[Unit::covered];
        const double points = phong[Unit::shade], lights = kFewLights;
        // A choice of an axis costs what it takes more than the cheapest one.
        axis(c, points * lights, {{Unit::power, "phong"}, {Unit::quickPower, "specular=schlick"}});
        axis(c, points * (lights + 1),
             {{Unit::vectorPixel, "phong"},
              {Unit::vectorVertex, "light-vector=vertex"},
              {Unit::vectorFace, "light-vector=face"},
              {Unit::vectorScene, "light-vector=scene"}});
        axis(c, points, {{Unit::perspective, "phong"}, {Unit::affine, "interpolation=affine"}});
        axis(c, points, {{Unit::unitNormal, "phong"}, {Unit::shortNormal, "normals=as-interpolated"}});
        const double light = positive(longer("lights", "phong")) / (points * (kManyLights - kFewLights));
        c[Unit::light] = positive(light - c[Unit::power] - c[Unit::vectorPixel]);
        const double shading = positive(longer("phong", "unlit")) / points;
        c[Unit::shade] = positive(shading - lights * (c[Unit::light] + c[Unit::power]) - (lights + 1) * c[Unit::vectorPixel] -
                                  c[Unit::perspective] - c[Unit::unitNormal]);
        c[Unit::ray] = positive(1e6 * of("rays").least() - c[Unit::picture]) / of("rays").work[Unit::ray];
        return c;
    }

    void axis(UnitCosts& c, double count, const std::vector<std::pair<Unit, const char*>>& choices) const {
        double least = 0;
        for (const auto& [unit, name] : choices) least = std::min(least, longer(name, "phong"));
        for (const auto& [unit, name] : choices) c[unit] = (longer(name, "phong") - least) / count;
    }

    // Processor time of the twin, which a busy machine does not lengthen.
    double twinRay() const {
        const Timed& rays = of("rays");
        double least = INFINITY;
        for (size_t round = 0; round < kLeastRounds; ++round) {
            const double before = processorMs();
            renderCpu(*rays.scene, rays.request);
            least = std::min(least, processorMs() - before);
        }
        return 1e6 * least / rays.work[Unit::ray];
    }

    const std::function<RenderResult(const Scene&, const RenderRequest&)>& draw_;
    const Scene few_ = ballScene(kFewRings, kFewLights, true), many_ = ballScene(kManyRings, kFewLights, true),
                far_ = ballScene(kFewRings, kFewLights, false), lit_ = ballScene(kFewRings, kManyLights, true), mirrors_ = mirrorScene();
    std::map<std::string, Timed> pictures_;
    std::vector<std::string> missing_;
};

constexpr const char* kFirstLine = "plumb unit costs 1";

std::string hashOf(const std::string& text) { return sha256Hex(std::as_bytes(std::span(text))); }

// Empty: there is no folder for it.
std::filesystem::path fileOf(const std::string& key) {
    const std::filesystem::path folder = cacheFolder();
    return folder.empty() ? folder : folder / fmt::format("costs-{}", hashOf(key).substr(0, 16));
}

}  // namespace

std::string calibrationText(const Calibration& calibration, const std::string& key) {
    std::string text = fmt::format("{}\n{}\n", kFirstLine, key);
    for (const Choice<Unit>& unit : kUnitWords) text += fmt::format("{} {:.17g}\n", unit.word, calibration.costs[unit.value]);
    text += fmt::format("twin-ray {:.17g}\n", calibration.twinRay);
    return text + fmt::format("sha256 {}\n", hashOf(text));
}

bool readCalibration(const std::string& text, const std::string& key, Calibration& calibration) {
    const size_t last = text.rfind("sha256 ");
    if (last == std::string::npos || text.substr(last) != fmt::format("sha256 {}\n", hashOf(text.substr(0, last)))) return false;
    std::istringstream lines(text.substr(0, last));
    std::string first, second, word;
    std::getline(lines, first);
    std::getline(lines, second);
    if (first != kFirstLine || second != key) return false;
    Calibration read;
    double value = 0;
    const auto take = [&](const char* name) { return bool(lines >> word >> value) && word == name && std::isfinite(value) && value >= 0; };
    for (const Choice<Unit>& unit : kUnitWords) {
        if (!take(unit.word)) return false;
        read.costs[unit.value] = value;
    }
    if (!take("twin-ray")) return false;
    read.twinRay = value;
    read.fromCache = true;
    calibration = read;
    return true;
}

bool keptCalibration(const std::string& key, Calibration& calibration) {
    const std::filesystem::path file = fileOf(key);
    return !file.empty() && readCalibration(readCache(file), key, calibration);
}

Calibration calibrationOf(const std::string& key, const std::function<RenderResult(const Scene&, const RenderRequest&)>& draw) {
    const std::filesystem::path file = fileOf(key);
    Calibration calibration;
    if (keptCalibration(key, calibration)) return calibration;
    calibration = Calibrating(draw).run();
    if (!file.empty() && calibration.steady) writeCache(file, calibrationText(calibration, key));
    return calibration;
}

}  // namespace plumb
