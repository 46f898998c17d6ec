// SPDX-License-Identifier: MIT
// plumb info: what is in a file, and whether a mesh is closed. Needs no device.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Edges of the triangles between welded corners. Corners are welded when their positions have the same bits (+0 and -0 are one), so a
// vertex that was split for its normal or material is one corner. An edge inside a polygon is used twice by construction, so triangulation
// adds neither boundary nor non-manifold edges.
struct Edges {
    uint64_t corners = 0, edges = 0, boundary = 0, nonManifold = 0, flipped = 0;  // flipped: two faces run along it the same way
};

Edges edgesOf(const TriangleMesh& mesh) {
    const auto key = [&](uint32_t v) {
        const glm::vec3 p = mesh.positions[v] + 0.0f;  // -0 becomes +0
        std::array<uint32_t, 3> bits{};
        std::memcpy(bits.data(), &p, sizeof p);
        return bits;
    };
    std::vector<uint32_t> order(mesh.positions.size()), corner(mesh.positions.size());
    for (uint32_t v = 0; v < order.size(); ++v) order[v] = v;
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
    Edges result;
    for (size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || key(order[i]) != key(order[i - 1])) ++result.corners;
        corner[order[i]] = uint32_t(result.corners - 1);
    }
    struct Edge {
        uint64_t ends;  // lower corner in the high half
        bool reversed;
    };
    std::vector<Edge> uses;
    uses.reserve(mesh.triangles.size() * 3);
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t a = corner[t.vertex[i]], b = corner[t.vertex[(i + 1) % 3]];
            if (a != b) uses.push_back({uint64_t(std::min(a, b)) << 32 | std::max(a, b), a > b});
        }
    std::sort(uses.begin(), uses.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
    for (size_t i = 0; i < uses.size();) {
        size_t end = i, reversed = 0;
        for (; end < uses.size() && uses[end].ends == uses[i].ends; ++end) reversed += uses[end].reversed;
        const size_t count = end - i;
        ++result.edges;
        result.boundary += count == 1;
        result.nonManifold += count > 2;
        result.flipped += count == 2 && reversed != 1;
        i = end;
    }
    return result;
}

Json vec(const glm::vec3& v) { return {v.x, v.y, v.z}; }
Json vec(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json meshJson(const TriangleMesh& mesh) {
    const Edges e = edgesOf(mesh);
    return {{"name", mesh.name},
            {"faces", mesh.faceCentre.size()},
            {"triangles", mesh.triangles.size()},
            {"vertices", mesh.positions.size()},
            {"positions", e.corners},
            {"edges", e.edges},
            {"boundary_edges", e.boundary},
            {"non_manifold_edges", e.nonManifold},
            {"flipped_edges", e.flipped},
            {"closed", e.boundary == 0 && e.nonManifold == 0 && e.edges != 0},
            {"degenerate_faces", mesh.degenerateFaces},
            {"repaired_normals", mesh.repairedNormals},
            {"flushed_denormals", mesh.flushedDenormals},
            {"bounds", {{"min", vec(mesh.statedMin)}, {"max", vec(mesh.statedMax)}}}};
}

Json materialJson(const Material& m) {
    return {{"name", m.name},
            {"ambient", vec(m.ambient)},
            {"diffuse", vec(m.diffuse)},
            {"specular", vec(m.specular)},
            {"emission", vec(m.emission)},
            {"shininess", m.shininess}};
}

// World-space box of the vertices of all objects, from the positions as the files state them. Null without a vertex.
Json worldBounds(const Scene& scene) {
    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-std::numeric_limits<double>::infinity());
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            const glm::dvec3 world(object.worldFromObject * glm::dvec4(mesh.statedAt(v), 1));
            least = glm::min(least, world);
            most = glm::max(most, world);
        }
    }
    if (!(least.x <= most.x)) return nullptr;
    return {{"min", {least.x, least.y, least.z}}, {"max", {most.x, most.y, most.z}}};
}

// Six digits of the box's size: more of the numbers where it lies far from 0, as many as binary64 has at most.
std::string boxInWords(const Json& box) {
    constexpr int kDigits = 6, kMostDigits = std::numeric_limits<double>::max_digits10;
    double size = 0, reach = 0;
    for (size_t i = 0; i < 3; ++i) {
        const double least = box["min"][i].get<double>(), most = box["max"][i].get<double>();
        size = std::max(size, most - least);
        reach = std::max({reach, std::abs(least), std::abs(most)});
    }
    const int more = size > 0 && reach > size ? int(std::ceil(std::log10(reach / size))) : 0;
    const int digits = std::min(kDigits + more, kMostDigits);
    const auto point = [&](const Json& p) {
        return fmt::format("({:.{}g}, {:.{}g}, {:.{}g})", p[0].get<double>(), digits, p[1].get<double>(), digits, p[2].get<double>(),
                           digits);
    };
    return fmt::format("{} to {}", point(box["min"]), point(box["max"]));
}

std::string textOf(const Json& json) {
    const auto box = [](const Json& b) { return b.is_null() ? std::string("nothing") : boxInWords(b); };
    const auto count = [](const Json& value, const char* one, const char* many) {
        return fmt::format("{} {}", value.get<uint64_t>(), value.get<uint64_t>() == 1 ? one : many);
    };
    const Json& scene = json["scene"];
    std::string text = fmt::format("{}\n  {}, {}, {}; bounds {}\n", printable(scene["path"].get<std::string>()),
                                   count(scene["objects"], "object", "objects"), count(scene["triangles"], "triangle", "triangles"),
                                   count(scene["lights"], "light", "lights"), box(json["bounds"]));
    for (const Json& m : json["meshes"]) {
        text += fmt::format("  mesh '{}': {}, {}, {}; bounds {}\n", printable(m["name"].get<std::string>(), 60),
                            count(m["faces"], "face", "faces"), count(m["triangles"], "triangle", "triangles"),
                            count(m["positions"], "position", "positions"), box(m["bounds"]));
        text += fmt::format("    {}: {} of {} edges are boundary, {} non-manifold, {} between faces of opposite orientation; {}\n",
                            m["closed"].get<bool>() ? "closed" : "open", m["boundary_edges"].get<uint64_t>(), m["edges"].get<uint64_t>(),
                            m["non_manifold_edges"].get<uint64_t>(), m["flipped_edges"].get<uint64_t>(),
                            count(m["degenerate_faces"], "degenerate face", "degenerate faces"));
    }
    for (const Json& m : json["materials"]) {
        const auto colour = [&](const char* key) {
            return fmt::format("{:g},{:g},{:g}", m[key][0].get<double>(), m[key][1].get<double>(), m[key][2].get<double>());
        };
        text += fmt::format("  material '{}': Ka {}  Kd {}  Ks {}  Ke {}  Ns {:g}\n", printable(m["name"].get<std::string>(), 60),
                            colour("ambient"), colour("diffuse"), colour("specular"), colour("emission"), m["shininess"].get<double>());
    }
    for (const Json& ignored : scene["ignored"]) text += fmt::format("  not drawn: {}\n", ignored.get<std::string>());
    for (const Json& warning : scene["warnings"]) text += fmt::format("  warning: {}\n", warning.get<std::string>());
    return text;
}

}  // namespace

Exit infoCommand(const Options& options) {
    Progress progress(options.progress, options.quiet);
    std::vector<Json> reports;
    for (const std::string& path : options.inputs) {
        stopIfInterrupted();
        const LoadOptions load = loadOptionsOf(options, &progress, double(reports.size()) / double(options.inputs.size()),
                                               double(reports.size() + 1) / double(options.inputs.size()));
        const Scene scene = loadScene({path}, load);
        progress.clear();
        Json json;
        json["tool"] = toolJson();
        json["scene"] = sceneJson(scene, sourcesOf({path}, load));
        json["bounds"] = worldBounds(scene);
        json["meshes"] = Json::array();
        for (const TriangleMesh& mesh : scene.meshes) json["meshes"].push_back(meshJson(mesh));
        json["materials"] = Json::array();
        for (const Material& material : scene.materials) json["materials"].push_back(materialJson(material));
        if (!options.json || !options.jsonFile.empty()) printData(textOf(json));
        reports.push_back(std::move(json));
    }
    writeJson(options, reports);
    return Exit::done;
}

}  // namespace plumb
