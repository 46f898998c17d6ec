// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/polygon_frame.h"

#include "pipeline/passes/parallel.h"
#include "pipeline/render/notes/polygons.h"
#include "pipeline/render/notes/projection.h"
#include "pipeline/render/walk.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using glm::dvec3;

// A polygon of the list: where it comes from.
struct NotesPolygon {
    uint32_t range;     // of the draw list
    uint32_t face;      // of its mesh
    uint32_t triangle;  // the face's first, of the scene
    uint32_t material;
};

class NotesFrame {
public:
    NotesFrame(const Scene& scene, const Prepared& prepared, const RenderRequest& request, NotesSide& side, PlaneWriter& writer,
               RenderResult& result)
        : scene_(scene),
          p_(prepared),
          request_(request),
          side_(side),
          writer_(writer),
          result_(result),
          view_(pinholeOf(*scene.camera, double(prepared.list.frame.width), double(prepared.list.frame.height), prepared.side)),
          projection_(view_, scene.camera->focusDistance),
          unit_(double(prepared.list.viewport.near) / double(prepared.near)) {
        // Samples are pixels of a larger canvas: its corners lie on its own grid.
        list_.width = p_.list.frame.width;
        list_.height = p_.list.frame.height;
        list_.zBuffer = scene.zBuffer;
    }

    void draw() {
        {
            const Stopwatch watch(nullptr, "");
            for (uint32_t r = 0; r < p_.list.ranges.size(); ++r) addObject(r);
            addTime(result_.times, "project", watch.elapsedMs() - illuminateMs_);
        }
        const ScanCanvas canvas = side_.paint(list_);
        finish(canvas);
    }

private:
    // A distant viewer is in the same direction from every polygon (section 3), so that no corner matters.
    bool visible(const Newell& n, const dvec3& corner, bool mirrored) const {
        return n.faces(request_.distantViewer ? -view_.forward : view_.eye - corner, mirrored);
    }

    [[noreturn]] void refuseCrossing(const Object& object, const TriangleMesh& mesh, uint32_t face) const {
        throw inputError(mesh.location.empty() ? printablePath(scene_.path) : mesh.location,
                         fmt::format("mesh.faces[{}] crosses itself (object '{}'), and --fill notes fills simple polygons", face,
                                     printable(object.name, 64)));
    }

    void addObject(uint32_t rangeNumber) {
        const DrawList::Range& r = p_.list.ranges[rangeNumber];
        const Object& object = scene_.objects[r.sceneObject];
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        if (mesh.selfCrossingFaces > 0) refuseCrossing(object, mesh, mesh.firstSelfCrossing);
        const gpu::ObjectRecord& record = p_.list.objects[r.record];
        list_.location = locationOfPart(object.location, scene_.path, "object", object.name);
        const glm::dmat4 toWorld = worldFromMesh(scene_, object);
        const bool mirrored = mirrors(toWorld);
        const uint32_t shading = p_.choices.shading;
        std::vector<dvec3> world(mesh.positions.size());
        for (size_t v = 0; v < world.size(); ++v) world[v] = dvec3(toWorld * glm::dvec4(mesh.positions[v], 1));

        struct Face {
            uint32_t face, firstTriangle, triangles;
            std::vector<uint32_t> outline;
            size_t firstPoint;
        };
        std::vector<Face> faces;
        NotesPoints points;
        for (uint32_t t = 0; t < mesh.triangles.size();) {
            Face f{mesh.triangles[t].face, t, 0, {}, points.positions.size()};
            while (t < mesh.triangles.size() && mesh.triangles[t].face == f.face) ++t, ++f.triangles;
            const std::span<const TriangleMesh::Triangle> own(mesh.triangles.data() + f.firstTriangle, f.triangles);
            f.outline = outlineOf(own);
            ++result_.counters.polygons;
            std::vector<dvec3> around;
            for (uint32_t v : f.outline) around.push_back(world[v]);
            if (around.empty())
                for (uint32_t v : own[0].vertex) around.push_back(world[v]);
            ++result_.counters.normals;  // of the face
            const Newell newell = newellOf(around);
            if (around.size() > 3 && newell.vanishes())
                for (const TriangleMesh::Triangle& t : own) {  // parts with an area that cancel: a bow tie
                    const std::array part = {world[t.vertex[0]], world[t.vertex[1]], world[t.vertex[2]]};
                    if (!newellOf(part).vanishes()) refuseCrossing(object, mesh, f.face);
                }
            if (scene_.cullBackFaces && !visible(newell, around[0], mirrored)) {
                ++result_.counters.culledBackFace;
                continue;
            }
            const uint32_t material = p_.list.faceMaterial[r.firstFace + f.face];
            const auto addPoint = [&](const glm::vec3& position, const glm::vec3& normal) {
                points.positions.emplace_back(position, 1.0f);
                points.normals.emplace_back(normal, 0.0f);
                points.materials.push_back(material);
            };
            if (shading == gpu::kShadingFlat) addPoint(mesh.faceCentre[f.face], mesh.faceNormal[f.face]);
            if (shading == gpu::kShadingGouraud)
                forEachCorner(f.outline, own, [&](uint32_t v) { addPoint(mesh.positions[v], mesh.normals[v]); });
            if (shading == gpu::kShadingGouraud || shading == gpu::kShadingPhong)
                forEachCorner(f.outline, own, [&](uint32_t) { ++result_.counters.normals; });
            faces.push_back(f);
        }
        std::vector<glm::vec4> colours;
        if (!points.positions.empty()) {
            const Stopwatch watch(nullptr, "");
            colours = side_.illuminate(points, r.record);
            illuminateMs_ += watch.elapsedMs();
        }
        result_.counters.illuminations += points.positions.size();

        for (const Face& f : faces) {
            const std::span<const TriangleMesh::Triangle> own(mesh.triangles.data() + f.firstTriangle, f.triangles);
            const uint32_t material = p_.list.faceMaterial[r.firstFace + f.face];
            size_t point = f.firstPoint;
            std::vector<std::pair<uint32_t, glm::vec3>> attributes;
            forEachCorner(f.outline, own, [&](uint32_t v) {
                glm::vec3 value = p_.list.materials[material].diffuse;
                if (shading == gpu::kShadingFlat) value = glm::vec3(colours[f.firstPoint]);
                if (shading == gpu::kShadingGouraud) value = glm::vec3(colours[point++]);
                if (shading == gpu::kShadingPhong) value = worldNormal(record, mesh.normals[v]);
                attributes.emplace_back(v, value);
            });
            const auto corner = [&](uint32_t v) {
                const auto found = std::find_if(attributes.begin(), attributes.end(), [&](const auto& c) { return c.first == v; });
                return NotesCorner{view_.viewOf(world[v]), found->second};
            };
            const NotesPolygon from{rangeNumber, f.face, r.firstTriangle + f.firstTriangle, material};
            std::vector<NotesCorner> polygon;
            for (uint32_t v : f.outline) polygon.push_back(corner(v));
            if (!polygon.empty() && addConvex(polygon, from)) continue;
            for (const TriangleMesh::Triangle& t : own) {  // concave: as it was cut into triangles
                polygon = {corner(t.vertex[0]), corner(t.vertex[1]), corner(t.vertex[2])};
                if (!addConvex(polygon, from)) addFan(polygon, from);
            }
        }
    }

    // A face without an outline (its triangles share a vertex twice) is taken triangle by triangle, each corner once.
    template <class Body>
    static void forEachCorner(const std::vector<uint32_t>& outline, std::span<const TriangleMesh::Triangle> own, const Body& body) {
        std::vector<uint32_t> corners = outline;
        if (corners.empty()) {
            for (const TriangleMesh::Triangle& t : own) corners.insert(corners.end(), t.vertex, t.vertex + 3);
            std::sort(corners.begin(), corners.end());
            corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
        }
        for (uint32_t v : corners) body(v);
    }

    static glm::vec3 worldNormal(const gpu::ObjectRecord& o, const glm::vec3& n) {
        const dvec3 v(glm::dot(dvec3(o.normal0), dvec3(n)), glm::dot(dvec3(o.normal1), dvec3(n)), glm::dot(dvec3(o.normal2), dvec3(n)));
        const double length = std::sqrt(glm::dot(v, v));
        return length > 0 ? glm::vec3(v / length) : glm::vec3(0);
    }

    bool addConvex(const std::vector<NotesCorner>& polygon, const NotesPolygon& from) {
        const std::vector<gpu::ScanCorner> corners = projection_.display(polygon);
        if (corners.size() < 3) return true;  // nothing is left of it
        if (!isConvex(corners)) return false;
        add(corners, from);
        return true;
    }
    void addFan(const std::vector<NotesCorner>& polygon, const NotesPolygon& from) {
        const std::vector<gpu::ScanCorner> corners = projection_.display(polygon);
        for (size_t i = 1; i + 1 < corners.size(); ++i) add(std::array{corners[0], corners[i], corners[i + 1]}, from);
    }
    void add(std::span<const gpu::ScanCorner> corners, const NotesPolygon& from) {
        if (!list_.add(corners)) return;
        ++result_.counters.drawnTriangles;
        from_.resize(list_.polygons.size(), from);  // a large one has several entries
    }

    void finish(const ScanCanvas& canvas) {
        if (result_.counters.illuminations == 0) result_.plan.skip("illuminate", "nothing is seen that is lit");
        const size_t pixels = canvas.owner.size();
        std::vector<float> linear(3 * pixels);
        for (size_t i = 0; i < pixels; ++i) setColour(linear, i, p_.backgroundLinear);
        std::vector<glm::vec3> normals;
        std::vector<uint32_t> covered;
        for (size_t i = 0; i < pixels; ++i)
            if (canvas.owner[i] != gpu::kNoPolygon) covered.push_back(uint32_t(i));
        const bool phong = p_.choices.shading == gpu::kShadingPhong;
        normals.resize((request_.planes & kPlaneNormal) || phong ? covered.size() : 0);
        for (size_t k = 0; k < normals.size(); ++k) {
            const size_t i = covered[k];
            const NotesPolygon& from = from_[canvas.owner[i]];
            const DrawList::Range& r = p_.list.ranges[from.range];
            const dvec3 n(canvas.attributes[i]);
            // Interpolated normals are made unit again (A15); one that vanished on the way is the face's.
            const double length = phong ? std::sqrt(glm::dot(n, n)) : 0;
            normals[k] = length > 0x1p-20 ? glm::vec3(n / length)
                                          : worldNormal(p_.list.objects[r.record],
                                                        scene_.meshes[scene_.objects[r.sceneObject].mesh].faceNormal[from.face]);
        }
        if (phong) {
            NotesPoints points;
            for (size_t k = 0; k < covered.size(); ++k) {
                const size_t i = covered[k];
                points.positions.emplace_back(glm::vec3(projection_.rayOf(i) * (projection_.depthOf(canvas.z[i]) * unit_)), 1.0f);
                points.normals.emplace_back(normals[k], 0.0f);
                points.materials.push_back(from_[canvas.owner[i]].material);
            }
            if (!covered.empty()) {
                const std::vector<glm::vec4> colours = side_.illuminate(points, kNone);
                for (size_t k = 0; k < covered.size(); ++k) setColour(linear, covered[k], glm::vec3(colours[k]));
            }
            result_.counters.illuminations += covered.size();
        } else {
            for (uint32_t i : covered) setColour(linear, i, canvas.attributes[i]);
        }
        write(canvas, covered, linear, normals);
    }

    static void setColour(std::vector<float>& linear, size_t sample, const glm::vec3& colour) {
        std::copy_n(&colour.x, 3, linear.begin() + ptrdiff_t(3 * sample));
    }

    // What the polygon that owns a sample shows there.
    class Seen : public SeenNothing {
    public:
        Seen(const NotesFrame& frame, const ScanCanvas& canvas, size_t sample, const glm::vec3& normal)
            : frame_(frame),
              from_(frame.from_[canvas.owner[sample]]),
              sample_(sample),
              depth_(frame.projection_.depthOf(canvas.z[sample])),
              normal_(normal) {}
        float z() const { return float(double(frame_.p_.near) / depth_); }
        float depth() const { return float(depth_); }
        float distance() const {
            const dvec3 ray = frame_.projection_.rayOf(sample_);
            return float(depth_ * std::sqrt(glm::dot(ray, ray)));
        }
        glm::vec3 normal() const { return normal_; }
        uint32_t triangle() const { return from_.triangle; }
        uint32_t object() const { return range().sceneObject; }
        uint32_t primitive() const { return frame_.p_.list.facePrimitive[range().firstFace + from_.face]; }

    private:
        const DrawList::Range& range() const { return frame_.p_.list.ranges[from_.range]; }
        const NotesFrame& frame_;
        const NotesPolygon& from_;
        const size_t sample_;
        const double depth_;
        const glm::vec3 normal_;
    };

    // `normals`: of the covered samples, in their order; empty where none are asked for.
    void write(const ScanCanvas& canvas, const std::vector<uint32_t>& covered, const std::vector<float>& linear,
               const std::vector<glm::vec3>& normals) {
        std::vector<int> drawn(canvas.owner.size(), 0);  // covered samples, counted from 1
        for (size_t k = 0; k < covered.size(); ++k) drawn[covered[k]] = int(k + 1);
        const SampleLayout layout{uint32_t(list_.width), p_.side, p_.side, p_.side / 2};
        const auto colours = [&] { writer_.takeColours(0, p_.height, {layout, linear, drawn}, threadCount(request_.threads)); };
        const StepBody host[] = {{"resolve", colours}, {"encode", colours}};
        walk(p_.plan, result_.times, host);
        writer_.takeCoverage<int>(p_.height, layout, drawn);
        writer_.takeSeen<int>(0, p_.height, layout, drawn, [&](uint32_t, uint32_t, size_t sample) {
            return Seen(*this, canvas, sample, normals.empty() ? glm::vec3(0) : normals[size_t(drawn[sample] - 1)]);
        });
        result_.counters.bands = result_.counters.chunks = 1;
    }

    const Scene& scene_;
    const Prepared& p_;
    const RenderRequest& request_;
    NotesSide& side_;
    PlaneWriter& writer_;
    RenderResult& result_;
    const Pinhole view_;
    const NotesProjection projection_;
    const double unit_;  // the passes' length of a scene unit, a power of two
    double illuminateMs_ = 0;
    ScanList list_;
    std::vector<NotesPolygon> from_;
};

}  // namespace

void drawPolygons(const Scene& scene, const Prepared& prepared, const RenderRequest& request, NotesSide& side, PlaneWriter& writer,
                  RenderResult& result) {
    NotesFrame(scene, prepared, request, side, writer, result).draw();
}

}  // namespace plumb
