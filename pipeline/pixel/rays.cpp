// SPDX-License-Identifier: MIT
// Pixels of --shading ray: the tree of the sample that stands for the pixel, ray by ray. Values of the twin are those that its tracer computed; the
// device stores distance, normal and colour of the ray from the eye.
#include "pipeline/pixel/ray_chain.h"

#include "pipeline/pixel/chain_writer.h"
#include "pipeline/pixel/picture.h"
#include "pipeline/render/rays/trace_samples.h"
#include "pipeline/truth/rays.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace textbook {

SceneTriangle triangleOfScene(const Scene& scene, uint32_t number) {
    for (uint32_t o = 0; o < scene.objects.size(); ++o) {
        const auto count = uint32_t(scene.meshes[scene.objects[o].mesh].triangles.size());
        if (number < count) return {o, number};
        number -= count;
    }
    PLUMB_ASSERT(!"a triangle that was hit is one of the scene");
    return {};
}

}  // namespace textbook

namespace {

using textbook::prefixOf;

class RayPixels : public BothFrames {
public:
    RayPixels(Device* device, const std::string& why, const Scene& scene, const RenderRequest& request)
        : BothFrames(device, why, scene, request),
          p_(prepare(scene, request_, RunsOn::twin)),
          traced_(traceSceneOf(scene, p_)),
          choices_(traceChoicesOf(scene, request_, p_, traced_)),
          push_(tracePushOf(p_, request_, traced_)),
          grid_(sampleGridOf(p_, request_)),
          pinhole_(*scene.camera, request.width, request.height, 1),
          world_(scene),
          truth_(world_, pinhole_, glm::dvec3(request.background)) {}

    OpenedPixel open(const Asked& asked) override {
        if (asked.face || asked.vertex)
            throw usageError("--polygon and --vertex open polygons of --fill exact; rays are opened by a pixel or --ray");
        OpenedPixel opened;
        opened.technique = technique_.name;
        opened.x = asked.pixel->x;
        opened.y = asked.pixel->y;
        opened.twin = shownOf(twin_.frame, *asked.pixel);
        opened.device = deviceShown(*asked.pixel);
        pixel_ = at(*asked.pixel);
        const glm::uvec2 sample(opened.x * grid_.stride + grid_.anchor, opened.y * grid_.stride + grid_.anchor);
        const std::vector<TracedRay> tree = traceTree(push_, traced_, choices_, sample.x, sample.y);
        lookTruly(opened.truth, sample);
        opened.chains.push_back(chainOf(opened, asked, sample, tree));
        explain(opened);
        return opened;
    }

private:
    uint32_t spheres() const { return uint32_t(scene_.spheres.size()); }
    uint32_t shapes() const { return spheres() + uint32_t(scene_.planes.size()); }
    bool oneRay() const { return grid_.side == 1; }

    // Position of a sample on the screen from its middle, in pixels.
    glm::dvec2 placeOf(const glm::uvec2& sample) const {
        const uint32_t key = gpu::keyOfSample(sample.x, sample.y, push_.seed);
        const double side = choices_.side;
        return {double(gpu::columnOf(choices_.sampling, sample.x, choices_.side, key)) / side - pinhole_.width / 2,
                double(gpu::rowOf(choices_.sampling, sample.y, choices_.side, key)) / side - pinhole_.height / 2};
    }

    void lookTruly(Shown& shown, const glm::uvec2& sample) {
        const glm::dvec2 at = placeOf(sample);
        const truth::RaySeen seen = truth_.look(at.x, at.y);
        shown.there = true;
        shown.object = seen.object;
        shown.face = seen.primitive;
        for (int k = 0; k < 3; ++k) {
            shown.linear[k] = seen.colour[k];
            shown.linearBound[k] = seen.decided ? seen.bound[k] : INFINITY;
        }
        encode(shown);
    }

    // Material of the scene that a ray meets.
    uint32_t materialOf(const TracedRay& ray) const {
        if (ray.object < spheres()) return scene_.spheres[ray.object].material;
        if (ray.object < shapes()) {
            const size_t i = ray.object - spheres();
            const PlaneShape& p = scene_.planes[i];
            return p.square > 0 && ray.material == uint32_t(traced_.planes[i].other) && ray.material != traced_.surfaces[ray.object]
                       ? p.otherMaterial
                       : p.material;
        }
        const textbook::SceneTriangle t = textbook::triangleOfScene(scene_, ray.object - shapes());
        const TriangleMesh& mesh = scene_.meshes[scene_.objects[t.object].mesh];
        return mesh.faceMaterial[mesh.triangles[t.triangle].face];
    }
    std::string nameOf(const TracedRay& ray) const {
        if (ray.object == gpu::kNoObject) return "nothing: it brings back the background";
        if (ray.object < spheres()) return fmt::format("sphere {} '{}'", ray.object, scene_.spheres[ray.object].name);
        if (ray.object < shapes()) return fmt::format("plane {} '{}'", ray.object - spheres(), scene_.planes[ray.object - spheres()].name);
        const textbook::SceneTriangle t = textbook::triangleOfScene(scene_, ray.object - shapes());
        return fmt::format("object {} '{}', triangle {}", t.object, scene_.objects[t.object].name, t.triangle);
    }

    Chain chainOf(const OpenedPixel& opened, const Asked& asked, const glm::uvec2& sample, const std::vector<TracedRay>& tree) {
        Chain chain;
        chain.object = opened.twin.object;
        chain.face = opened.twin.face;
        chain.triangle = tree[0].object >= shapes() && tree[0].object != gpu::kNoObject
                             ? textbook::triangleOfScene(scene_, tree[0].object - shapes()).triangle
                             : kNone;
        chain.title = fmt::format("tree of {} ray{}; the first meets {}", tree.size(), tree.size() == 1 ? "" : "s", nameOf(tree[0]));
        ChainWriter lines(chain);
        writeShapes(lines);
        std::string last;
        for (size_t i = 0; i < tree.size(); ++i) writeRay(lines, tree, i, last);
        decide(lines, opened);
        Shown truth = opened.truth;
        if (!oneRay()) truth.there = false, truth.why = "the pixel is the mean of several samples, of which one is opened";
        writePixel(chain, *asked.pixel, {}, oneRay() ? std::vector<std::string>{last} : std::vector<std::string>{}, truth);
        if (oneRay()) confirm(lines, tree.back().sum);

        textbook::RayTreeInput in{scene_, tree};
        for (const TracedRay& ray : tree) in.materials.push_back(ray.object == gpu::kNoObject ? 0 : materialOf(ray));
        const glm::dvec2 place = placeOf(sample);
        in.asGiven = asked.through.has_value();
        in.through = asked.through ? *asked.through - scene_.camera->eye
                                   : pinhole_.forward * pinhole_.focal + pinhole_.right * place.x + pinhole_.down * place.y;
        lines.take(textbook::RayTreeChain<float>(in).make());
        lines.take(textbook::RayTreeChain<Interval>(in).make());
        lines.close("the notes have no such number",
                    device_ == nullptr ? whyNoDevice_ : "the device stores what the ray from the eye meets, and no other",
                    "the pass computes no such number", "real arithmetic has no such number");
        lines.compare(false);
        return chain;
    }

    // 18.2.1 and 18.2.2 for every sphere and plane before the ray from the eye, met or not.
    void writeShapes(ChainWriter& lines) const {
        for (uint32_t i = 0; i < spheres() && i < textbook::kMostShapes; ++i) {
            const std::string n = "sphere" + std::to_string(i) + "_", of = fmt::format("sphere {} '{}'", i, scene_.spheres[i].name);
            lines.add("18.2.1", n + "abc", of + ": a, b and c of a t^2 + b t + c = 0");
            lines.add("18.2.1", n + "discriminant", "b^2 - 4 a c: below 0 the ray misses it");
            lines.add("18.2.1", n + "roots", "both t; those above 0 lie ahead");
        }
        for (uint32_t i = 0; i < scene_.planes.size() && i < textbook::kMostShapes; ++i) {
            const std::string n = "plane" + std::to_string(i) + "_", of = fmt::format("plane {} '{}'", i, scene_.planes[i].name);
            lines.add("18.2.2", n + "numerator", of + ": -(N.P - D), P the start of the ray");
            lines.add("18.2.2", n + "denominator", "N.T: 0 where the ray is parallel to it");
            lines.add("18.2.2", n + "t", "their quotient; above 0 it lies ahead");
        }
    }

    void writeRay(ChainWriter& lines, const std::vector<TracedRay>& tree, size_t i, std::string& last) {
        const TracedRay& ray = tree[i];
        const std::string n = prefixOf(i);
        const std::string who = ray.kind == gpu::kCountPrimary     ? "ray from the eye"
                                : ray.kind == gpu::kCountReflected ? fmt::format("ray mirrored at the hit of ray {}", ray.parent + 1)
                                                                   : fmt::format("ray refracted at the hit of ray {}", ray.parent + 1);
        lines.twin("18.1", n + "start", who + ": where it starts, from the eye, scene units", listOf(glm::dvec3(ray.origin) / p_.unit));
        lines.add("18.2", n + "vector", "its vector, in whose lengths t counts");
        lines.twin("18.2", n + "T", "direction; of the twin of length 1", listOf(ray.direction));
        Line& weight = lines.twin("18.4.2", n + "weight", "share of the pixel's colour", {double(ray.weight)});
        if (ray.parent != gpu::kNoObject) {
            const std::string parent = prefixOf(ray.parent);
            const bool total = ray.kind == gpu::kCountReflected && tree[ray.parent].children.passWeight == 0 &&
                               raySharesOf(scene_.materials[materialOf(tree[ray.parent])]).transmit > 0;
            weight.how = {ray.kind == gpu::kCountReflected ? (total ? fmt::format("{0}weight[0]*({0}reflect[0]+{0}transmit[0])", parent)
                                                                    : fmt::format("{0}weight[0]*{0}reflect[0]", parent))
                                                           : fmt::format("{0}weight[0]*{0}transmit[0]", parent)};
        }
        if (ray.object == gpu::kNoObject) {
            lines.twin("18.1", n + "sky", "it meets nothing: colour of the background", listOf(glm::vec3(push_.sky)));
            add(lines, n, last, ray.sum, [&](int k) { return fmt::format("{0}sky[{1}]*{0}weight[0]", n, k); });
            return;
        }
        writeHit(lines, ray, n, i == 0);
        writeOwn(lines, ray, n, last);
        writeChildren(lines, ray, n);
    }

    void writeHit(ChainWriter& lines, const TracedRay& ray, const std::string& n, bool fromEye) {
        const std::string met = "it meets " + nameOf(ray);
        if (ray.object < spheres()) {
            lines.add("18.2.1", n + "abc", met + ": a, b and c of the quadratic in t");
            lines.add("18.2.1", n + "discriminant", "b^2 - 4 a c");
            lines.add("18.2.1", n + "root", "its root");
            lines.add("18.2.1", n + "roots", "both t");
        } else {
            lines.add("18.2.2", n + "plane_N", met + ": N of its plane, length 1");
            lines.add("18.2.2", n + "plane_D", "N.Q of a point Q of the plane");
            lines.add("18.2.2", n + "numerator", "-(N.P - D), P the start of the ray");
            lines.add("18.2.2", n + "denominator", "N.T");
        }
        lines.add("18.2", n + "t", "t of the hit, in lengths of the vector").twin.why =
            "the pass counts in lengths, since its vectors have length 1";
        Line& distance = lines.twin("18.2", n + "distance", "distance of the hit, scene units", {double(ray.t) / p_.unit});
        if (fromEye && device_ != nullptr && oneRay()) distance.device.values = {double(drawn_.frame.distance[pixel_])};
        lines.twin("18.2", n + "P", "point of the hit, from the eye, scene units", listOf(glm::dvec3(ray.point) / p_.unit));
        lines.add("18.2", n + "point", "point of the hit, world").twin.why = "positions are kept from the eye";
        if (ray.object >= spheres() && ray.object < shapes() && scene_.planes[ray.object - spheres()].square > 0) {
            lines.add("18.3", n + "board", "coordinates of the point on the board");
            lines.add("18.3", n + "board_rest", "their size modulo two squares: above one square the colour is the other");
        }
        if (ray.object >= shapes())
            lines.twin("17.3", n + "shares", "shares of the triangle's corners",
                       {double(ray.shares.x), double(ray.shares.y), double(ray.shares.z)});
        lines.twin("18.2", n + "geometric", "normal of the surface, toward the ray", listOf(ray.geometric));
    }

    // 16 with shadows, and what it adds to the pixel.
    void writeOwn(ChainWriter& lines, const TracedRay& ray, const std::string& n, std::string& last) {
        const gpu::TraceMaterial& m = traced_.materials[ray.material];
        lines.twin("18.1", n + "local", "weight of the local colour", {double(m.local)});
        lines.twin("18.1", n + "reflect", "weight of the mirrored ray", {double(m.reflect)});
        lines.twin("18.1", n + "transmit", "weight of the refracted ray", {double(m.transmit)});
        if (!(m.local > 0)) return;
        std::vector<gpu::LightRecord> lights = traced_.lights;
        for (size_t i = 0; i < lights.size(); ++i) {
            lines.twin("18.4.3", n + "reaches" + std::to_string(i),
                       choices_.shadows ? "share of the light that its shadow ray lets through; 0 behind the surface"
                                        : "share of the light; no shadow ray is sent",
                       {double(ray.lightReaches[i])});
            lights[i].intensity *= ray.lightReaches[i];
        }
        const glm::vec3 &d = ray.direction, &normal = ray.normal, &at = ray.point;
        gpu::MaterialRecord record{};
        record.base = m.base;
        record.diffuse = m.diffuse;
        record.specular = m.specular;
        record.shininess = m.shininess;
        record.zeroPower = m.zeroPower;
        writeLit(lines,
                 {gpu::Surface{normal.x, normal.y, normal.z, -d.x, -d.y, -d.z, at.x, at.y, at.z}, record, lights, choices_.parts, p_.unit},
                 n, "at the hit");
        add(lines, n, last, ray.sum, [&](int k) { return fmt::format("{0}sum[{1}]*({0}weight[0]*{0}local[0])", n, k); });
    }

    // The sample's colour after a ray's own part.
    template <class Part>
    static void add(ChainWriter& lines, const std::string& n, std::string& last, const glm::vec3& sum, const Part& part) {
        std::vector<std::string> how;
        for (int k = 0; k < 3; ++k)
            how.push_back(fmt::format("{}+{}", last.empty() ? std::string("0") : fmt::format("{}[{}]", last, k), part(k)));
        lines.twin("18.1", n + "colour", "colour of the sample so far", listOf(sum), how);
        last = n + "colour";
    }

    // 18.2.3 and 18.2.4.
    void writeChildren(ChainWriter& lines, const TracedRay& ray, const std::string& n) {
        const gpu::TraceMaterial& m = traced_.materials[ray.material];
        if (m.reflect == 0 && m.transmit == 0) return;
        lines.twin("18.2", n + "B", "normal that bends rays, toward the ray", listOf(ray.bends));
        lines.add("18.2.3", n + "cos_phi", "N.(-T)").twin.why = "the pass has it inside its function of the directions";
        lines.add("18.2.3", n + "R", "N + T / (2 N.(-T))").twin.why = "the pass has T + 2 N.(-T) N, along the same direction";
        lines.add("18.2.3", n + "R_length", "its length");
        lines.twin("18.2.3", n + "R_unit", "direction of the mirrored ray", listOf(ray.children.mirrorDirection));
        if (m.transmit == 0) return;
        lines.add("18.2.4", n + "d", "ratio of the densities: beyond the surface over before it").twin.why = "the pass has its inverse";
        lines.add("18.2.4", n + "radicand", "1 - (1 - cos^2) / d^2: below 0 the ray is mirrored as a whole");
        if (ray.children.passWeight == 0) return;
        lines.add("18.2.4", n + "cos_phi2", "cosine beyond the surface");
        lines.add("18.2.4", n + "Trans", "T / d - (cos2 - cos / d) N");
        lines.add("18.2.4", n + "Trans_length", "its length");
        lines.twin("18.2.4", n + "pass", "direction of the refracted ray, of length 1", listOf(ray.children.passDirection));
    }

    void decide(ChainWriter& lines, const OpenedPixel& opened) const {
        Line& same = lines.add("18.2", "nearest", "what the ray from the eye meets first is what the twin shows");
        same.decision = true;
        same.twin.values = {1.0};
        if (opened.device.there)
            same.device.values = {opened.device.object == opened.twin.object && opened.device.face == opened.twin.face ? 1.0 : 0.0};
        same.truth.values = {opened.truth.object == opened.twin.object && opened.truth.face == opened.twin.face ? 1.0 : 0.0};
        same.bound = {0};
    }

    // The tree's colour must be the one that the twin drew: it would otherwise explain another picture.
    static void confirm(ChainWriter& lines, const glm::vec3& sum) {
        const Line* linear = lines.find("linear");
        for (int k = 0; k < 3; ++k)
            if (double(sum[k]) != linear->twin.values[size_t(k)])
                throw renderError(fmt::format("plumb pixel: the opened tree ends at {:.9g} in channel {}, and the twin drew {:.9g}", sum[k],
                                              k, linear->twin.values[size_t(k)]));
    }

    const Prepared p_;
    const TraceScene traced_;
    const TraceChoices choices_;
    const gpu::TracePush push_;
    const SampleGrid grid_;
    const truth::Pinhole pinhole_;
    const truth::RayWorld world_;
    truth::RayTruth truth_;
    size_t pixel_ = 0;  // that is opened
};

}  // namespace

std::unique_ptr<PixelOpener> rayOpener(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request) {
    return std::make_unique<RayPixels>(device, whyNoDevice, scene, request);
}

}  // namespace plumb
