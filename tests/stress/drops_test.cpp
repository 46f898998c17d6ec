// SPDX-License-Identifier: MIT
// Each row of the table of drops leaves out work and changes no byte: over every committed scene, over random scenes, and in a scene of its own that
// makes it fire. The full plan (TestKnobs::keepEverything) is the witness.
//
//   PLUMB_FUZZ_SEED=n, PLUMB_FUZZ_SCENE=i, PLUMB_FUZZ_SCENES=n   as for scene_fuzz_test
#include "pipeline/render/drops.h"

#include "host/error.h"
#include "pipeline/cli/options.h"
#include "pipeline/command/request.h"
#include "pipeline/command/views.h"
#include "pipeline/scene/load.h"
#include "tests/stress/scene_fuzz.h"
#include "tests/support/compare.h"
#include "tests/support/device_fixture.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kSeed = 1, kScenes = 500;
constexpr uint32_t kPlanes = kEveryPlane & ~kPlaneTriangle;  // its numbers count over the objects that are listed

uint64_t stated(const char* name, uint64_t fallback) {
    const char* text = std::getenv(name);
    return text && *text ? std::strtoull(text, nullptr, 10) : fallback;
}

// Work of a picture that rows leave out.
struct Work {
    uint64_t transformed = 0, illuminations = 0, lightsAdded = 0, rays = 0, shadowRays = 0, steps = 0;
    void add(const RenderResult& r) {
        transformed += r.counters.transformed;
        illuminations += r.counters.illuminations;
        lightsAdded += r.counters.lightsAdded;
        for (const RenderCounters::RayCounts& c : r.counters.rays) {
            rays += c.primary + c.reflected + c.refracted;
            shadowRays += c.shadowRays;
        }
        steps += r.plan.steps.size();
    }
    std::string text() const {
        return fmt::format("{} vertices transformed, {} illuminations, {} lights added, {} rays, {} shadow rays, {} steps", transformed,
                           illuminations, lightsAdded, rays, shadowRays, steps);
    }
};

class DropsOf : public DeviceTest {
protected:
    // Draws with and without the drops, on one side. `gpu` null: the twin. Returns false where a side refuses.
    bool compare(const Scene& scene, RenderRequest request, Device* gpu) {
        const auto draw = [&](const RenderRequest& r) { return gpu ? renderGpu(*gpu, scene, r) : renderCpu(scene, r); };
        request.planes = kPlanes & techniquePlanes(request);
        request.threads = 1;
        RenderRequest kept = request;
        kept.knobs.keepEverything = true;
        RenderResult lean, full;
        try {
            lean = draw(request);
            full = draw(kept);
        } catch (const Error&) {
            return false;  // the full plan may refuse an object that is outside the view
        }
        expectSameFrame(full.frame, lean.frame);
        expectNoMoreWork(lean, full);
        for (const Plan::Drop& drop : lean.plan.dropped) {
            if (drop.row.empty()) continue;  // not drawn, rather than dropped
            EXPECT_EQ(dropRow(drop.row.c_str()).name, drop.row);
            EXPECT_FALSE(drop.why.empty()) << drop.row;
            ++fired_[drop.row];
        }
        for (const Plan::Drop& drop : full.plan.dropped)
            EXPECT_TRUE(drop.row.empty() || drop.row == "nothing") << drop.row << " fires in the full plan";
        lean_.add(lean);
        full_.add(full);
        return true;
    }

    void tell(const char* what) const {
        fmt::print("drops, {}: {}\n  the full plan: {}\n", what, lean_.text(), full_.text());
        for (const DropRow& row : dropRows())
            fmt::print("  {:14} fires {:5} times\n", row.name, fired_.contains(row.name) ? fired_.at(row.name) : 0);
    }

    std::map<std::string, uint64_t> fired_;  // by row
    Work lean_, full_;

private:
    static uint32_t techniquePlanes(const RenderRequest& r) {
        const bool lines = r.shading == Shading::wire;
        return lines ? kPlaneColour | kPlaneLinear | kPlaneObject | kPlanePrimitive : kPlanes;
    }
    static void expectNoMoreWork(const RenderResult& lean, const RenderResult& full) {
        Work a, b;
        a.add(lean);
        b.add(full);
        EXPECT_LE(a.transformed, b.transformed);
        EXPECT_LE(a.lightsAdded, b.lightsAdded);
        EXPECT_LE(a.rays, b.rays);
        EXPECT_LE(a.shadowRays, b.shadowRays);
        EXPECT_LE(a.steps, b.steps);
    }
};

struct Form {
    const char* name;
    Shading shading;
    Fill fill = Fill::exact;
    WireView wire = WireView::seeThrough;
};
constexpr Form kForms[] = {{"phong", Shading::phong},
                           {"gouraud", Shading::gouraud},
                           {"flat", Shading::flat},
                           {"unlit", Shading::unlit},
                           {"rays", Shading::ray},
                           {"notes", Shading::phong, Fill::notes},
                           {"notes, flat", Shading::flat, Fill::notes},
                           {"wire", Shading::wire},
                           {"wire, solid", Shading::wire, Fill::exact, WireView::solid}};

RenderRequest requestOf(const Form& form, uint32_t width = 64, uint32_t height = 48) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.shading = form.shading;
    r.fill = form.fill;
    r.wire = form.wire;
    return r;
}

TEST_F(DropsOf, EveryCommittedSceneChangeNoByte) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PLUMB_SOURCE_DIR) / "scenes"))
        if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    ASSERT_GT(files.size(), 10u);
    uint64_t drawn = 0;
    for (const fs::path& file : files) {
        SCOPED_TRACE(file.filename().string());
        const Scene scene = committed(file, {64, 48});
        for (const Form& form : kForms) {
            SCOPED_TRACE(form.name);
            drawn += compare(scene, requestOf(form), nullptr);
        }
        // The kernels have their own ways to leave out: the device draws what the scene asks for.
        RenderRequest request = requestOf({"its own", scene.shading.value_or(Shading::phong)});
        compare(scene, request, &device());
    }
    tell(fmt::format("{} committed scenes, {} pictures of the twin", files.size(), drawn).c_str());
    EXPECT_GT(drawn, 3 * files.size());
    EXPECT_LT(lean_.steps, full_.steps);
}

std::vector<std::string> wordsOf(const std::string& line) {
    std::istringstream words(line);
    return {std::istream_iterator<std::string>(words), {}};
}

TEST_F(DropsOf, RandomScenesChangeNoByte) {
    const uint64_t seed = stated("PLUMB_FUZZ_SEED", kSeed), alone = stated("PLUMB_FUZZ_SCENE", ~0ull);
    const uint64_t first = alone == ~0ull ? 0 : alone, count = alone == ~0ull ? stated("PLUMB_FUZZ_SCENES", kScenes) : 1;
    TemporaryFolder folder;
    uint64_t drawn = 0;
    for (uint64_t i = first; i < first + count && !HasFailure(); ++i) {
        SCOPED_TRACE(fmt::format("PLUMB_FUZZ_SEED={} PLUMB_FUZZ_SCENE={}", seed, i));
        const FuzzScene random = fuzzScene(seed, i);
        const fs::path file = folder.write("scene.toml", random.text());
        std::vector<std::string> arguments{"verify", file.string()};
        for (const std::string& word : wordsOf(random.flagsText())) arguments.push_back(word);
        try {
            const Options options = parseOptions(arguments);
            Scene scene = loadScene({file}, loadOptionsOf(options));
            const glm::uvec2 size = sizeOf(scene, options);
            scene.camera = viewsOf(scene, size, options, false).at(0).camera;
            const RenderRequest request = plumb::requestOf(options, scene, size);
            if (request.trade.native()) continue;  // the device's own functions
            drawn += compare(scene, request, nullptr);
        } catch (const Error&) {
        }
    }
    tell(fmt::format("random scenes of seed {}, {} drawn", seed, drawn).c_str());
    if (count < kScenes) return;
    EXPECT_GT(drawn, count / 2);
    EXPECT_LT(lean_.lightsAdded, full_.lightsAdded);
    EXPECT_LT(lean_.transformed, full_.transformed);
}

// --- a scene for each row -----------------------------------------------------------------------------------------------------------------

// A row's scene, how it is drawn, and what of the work is less. The row is meant to fire in it, and no byte to change on either side.
struct RowCase {
    const char* row;
    std::function<Scene()> scene;
    Form form{"phong", Shading::phong};
    uint64_t Work::*less = nullptr;  // null: the drop is of a kernel's constants, which no counter counts
    bool repeated = false;
};

Object objectAt(const Scene& s, const glm::dvec3& at, double scale) {
    Object o = s.objects[0];
    o.name = "other";
    o.worldFromObject = glm::dmat4(scale);
    o.worldFromObject[3] = glm::dvec4(at, 1);
    return o;
}

// A triangle that fills the frame at a depth of 1/2, its front toward the eye.
TriangleMesh wall(const View& v) { return soupOf({{v.pointAt(-200, -200, 0.5), v.pointAt(-200, 400, 0.5), v.pointAt(400, -200, 0.5)}}, 3); }

// Small triangles behind a wall.
Scene behindAWall() {
    const View view{64, 48};
    Scene s = soup(view, 1, 60, 12);
    addObject(s, wall(view));
    return s;
}

// A wall, and one light that shines on its back.
Scene litFromBehind() {
    Scene s = litScene();
    addObject(s, wall({64, 48}));
    Light sun;
    sun.direction = {0.1, 0.2, -1};
    sun.intensity = glm::vec3(0.5f);
    s.lights.push_back(sun);
    return s;
}

Scene aloneOn(float reflect, float transmit) {
    Scene s = rayScene();
    addRayMaterial(s, glm::vec3(0.7f, 0.3f, 0.2f), reflect, transmit, 1.5f);
    s.spheres.push_back(ball({0, 1, 0}, 1.2, uint32_t(s.materials.size() - 1)));
    return s;
}

// Two balls of which the mirror stands behind the eye.
Scene mirrorBehindTheEye() {
    Scene s = aloneOn(0, 0);
    addRayMaterial(s, glm::vec3(0.5f), 0.6f, 0, 1);
    s.spheres.push_back(ball({0, 1, 20}, 1, uint32_t(s.materials.size() - 1)));
    addRayMaterial(s, glm::vec3(0.5f), 0, 0.8f, 1.5f);
    s.spheres.push_back(ball({3, 1, 20}, 1, uint32_t(s.materials.size() - 1)));
    return s;
}

Scene with(Scene s, const std::function<void(Scene&)>& change) {
    change(s);
    return s;
}

const std::vector<RowCase>& rowCases() {
    const View view{64, 48};
    const auto small = [view] { return soup(view, 1, 60, 12); };
    static const std::vector<RowCase> cases = {
        {"outside",
         [=] { return with(small(), [](Scene& s) {
                   s.objects.push_back(objectAt(s, {0, 0, 1000}, 1));
               }); },
         {"phong", Shading::phong},
         &Work::transformed},
        {"hidden", behindAWall, {"phong", Shading::phong}, &Work::transformed},
        {"dark",
         [=] {
             return with(small(), [](Scene& s) {
                 s.lights.push_back(s.lights[0]);
                 s.lights.back().intensity = glm::vec3(0);
             });
         },
         {"phong", Shading::phong},
         &Work::lightsAdded},
        {"unreflected",
         [=] {
             return with(small(), [](Scene& s) {
                 for (Material& m : s.materials) m.diffuse.r = m.specular.r = 0;
                 s.lights.push_back(s.lights[0]);
                 s.lights.back().intensity = {1, 0, 0};
             });
         },
         {"phong", Shading::phong},
         &Work::lightsAdded},
        {"turned-away", litFromBehind, {"phong", Shading::phong}, &Work::lightsAdded},
        {"illumination", [=] { return with(small(), [](Scene& s) { s.lights.clear(); }); }},
        {"diffuse",
         [=] {
             return with(small(), [](Scene& s) {
                 for (Material& m : s.materials) m.diffuse = glm::vec3(0);
             });
         }},
        {"specular",
         [=] {
             return with(small(), [](Scene& s) {
                 for (Material& m : s.materials) m.specular = glm::vec3(0);
             });
         }},
        {"position",
         [=] {
             return with(small(), [](Scene& s) {
                 for (Light& l : s.lights) {
                     l.directional = true;
                     l.direction = {0.2, 0.5, 1};
                     l.attenuation = Attenuation::none;
                 }
             });
         }},
        {"lamps", small, {"phong", Shading::phong}, nullptr, true},
        {"material",
         [=] {
             return with(small(), [](Scene& s) {
                 for (TriangleMesh& m : s.meshes) {
                     std::fill(m.faceMaterial.begin(), m.faceMaterial.end(), 0u);
                     std::fill(m.vertexMaterial.begin(), m.vertexMaterial.end(), 0u);
                 }
             });
         }},
        {"clip", small, {"phong", Shading::phong}, &Work::steps},
        {"normals", small, {"flat", Shading::flat}},
        {"nothing", [=] { return with(small(), [](Scene& s) { s.objects.clear(); }); }},
        {"mirrored", mirrorBehindTheEye, {"rays", Shading::ray}},
        {"refracted", mirrorBehindTheEye, {"rays", Shading::ray}},
        {"shadow-rays", [] { return aloneOn(0.2f, 0); }, {"rays", Shading::ray}, &Work::shadowRays},
    };
    return cases;
}

TEST_F(DropsOf, EachRowFiresInASceneOfItsOwn) {
    std::set<std::string> seen;
    for (const RowCase& c : rowCases()) {
        SCOPED_TRACE(c.row);
        const Scene scene = c.scene();
        for (Device* side : {static_cast<Device*>(nullptr), &device()}) {
            SCOPED_TRACE(side ? "device" : "twin");
            fired_.clear();
            lean_ = full_ = {};
            RenderRequest request = requestOf(c.form);
            request.repeated = c.repeated;
            ASSERT_TRUE(compare(scene, request, side));
            EXPECT_GT(fired_[c.row], 0u) << "the row does not fire";
            if (c.less) EXPECT_LT(lean_.*c.less, full_.*c.less) << "no work is saved";
        }
        seen.insert(c.row);
    }
    for (const DropRow& row : dropRows()) EXPECT_TRUE(seen.contains(row.name)) << row.name << " has no scene here";
}

// What a scene says stands in the plan, in words and in numbers.
TEST_F(DropsOf, ThePlanNamesEachRow) {
    std::set<std::string> names;
    for (const DropRow& row : dropRows()) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        for (const char* text : {row.what, row.why, row.test}) EXPECT_GT(std::string(text).size(), 2u) << row.name;
        const std::string test = row.test;
        const auto* unit = testing::UnitTest::GetInstance();
        bool there = false;
        for (int i = 0; i < unit->total_test_suite_count(); ++i)
            for (int k = 0; k < unit->GetTestSuite(i)->total_test_count(); ++k)
                there |= test == fmt::format("{}.{}", unit->GetTestSuite(i)->name(), unit->GetTestSuite(i)->GetTestInfo(k)->name());
        EXPECT_TRUE(there) << row.name << ": there is no test " << test;
    }
    const RenderResult drawn = renderCpu(aloneOn(0, 0), requestOf({"rays", Shading::ray}));
    std::set<std::string> stated;
    for (const Plan::Drop& d : drawn.plan.dropped) stated.insert(d.row);
    for (const char* row : {"mirrored", "refracted", "shadow-rays"}) EXPECT_TRUE(stated.contains(row)) << "rays show their drops: " << row;
}

// A picture that is drawn again follows the view: what one view leaves out, another may need.
TEST_F(DropsOf, AResidentPictureTakesBackWhatAViewNeeds) {
    const Scene scene = behindAWall();
    RenderRequest request = requestOf({"phong", Shading::phong});
    for (const bool repeated : {false, true}) {
        request.repeated = repeated;
        ResidentScene resident(device(), scene, request);
        for (const double forward : {0.0, 0.6, 0.0, 0.3}) {
            Scene moved = scene;
            moved.camera->eye += moved.camera->forward * forward;
            const ResidentScene::Picture got = resident.draw({*moved.camera});
            const RenderResult want = renderGpu(device(), moved, request);
            for (uint32_t y = 0; y < got.height; ++y)
                for (uint32_t x = 0; x < got.width; ++x)
                    ASSERT_EQ(got.pixels[y * got.pitch + x] & 0xffffffu, want.frame.rgba[y * got.width + x] & 0xffffffu)
                        << x << " " << y << " at " << forward << ", repeated " << repeated;
        }
    }
}

}  // namespace
}  // namespace plumb::test
