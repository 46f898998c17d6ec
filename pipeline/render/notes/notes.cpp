// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/notes.h"

#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/notes/polygons.h"
#include "pipeline/render/plan_steps.h"
#include "pipeline/render/planes.h"
#include "pipeline/render/preparing.h"
#include "pipeline/render/stopwatch.h"
#include "pipeline/scene/camera.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using glm::dvec3;

// Points of one object to be illuminated: positions and normals in its space.
struct Points {
    std::vector<glm::vec4> positions, normals;
    std::vector<uint32_t> materials;
};

// What differs between the sides.
class Side {
public:
    virtual ~Side() = default;
    virtual std::vector<glm::vec4> illuminate(const Points&, uint32_t record) = 0;
    virtual ScanCanvas paint(const ScanList&) = 0;
};

// A polygon's corner before projection, relative to the eye in scene units: right, down, forward.
struct Corner {
    dvec3 view;
    glm::vec3 carried;
};

// Turns one way only, and once around: two changes of the direction in y at most.
bool isConvex(std::span<const gpu::ScanCorner> polygon) {
    const size_t n = polygon.size();
    int turn = 0, changes = 0, direction = 0;
    for (size_t i = 0; i < n; ++i) {
        const gpu::ScanCorner &a = polygon[i], &b = polygon[(i + 1) % n], &c = polygon[(i + 2) % n];
        const int64_t cross = int64_t(b.x - a.x) * (c.y - b.y) - int64_t(b.y - a.y) * (c.x - b.x);
        const int sign = cross > 0 ? 1 : cross < 0 ? -1 : 0;
        if (sign != 0 && turn != 0 && sign != turn) return false;
        if (sign != 0) turn = sign;
    }
    for (size_t i = 0; i < 2 * n; ++i) {  // twice around, so that the first direction is known on the second
        const int rise = polygon[(i + 1) % n].y - polygon[i % n].y;
        const int now = rise > 0 ? 1 : rise < 0 ? -1 : 0;
        if (now == 0) continue;
        if (i >= n && now != direction) ++changes;
        direction = now;
    }
    return changes <= 2;
}

class NotesFrame {
public:
    NotesFrame(const Scene& scene, const Prepared& prepared, const RenderRequest& request, Side& side, PlaneWriter& writer,
               RenderResult& result)
        : scene_(scene), p_(prepared), request_(request), side_(side), writer_(writer), result_(result) {
        const Camera& c = *scene.camera;
        right_ = c.right;
        down_ = -c.up;
        forward_ = c.forward;
        eye_ = c.eye;
        // Samples are pixels of a larger canvas: its corners lie on its own grid.
        list_.width = p_.list.frame.width;
        list_.height = p_.list.frame.height;
        focal_ = focalOf(c, double(list_.height), p_.side);
        distance_ = c.focusDistance;
        near_ = double(p_.near);
        unit_ = double(p_.list.viewport.near) / near_;  // the passes' length of a scene unit, a power of two
        zUnit_ = std::exp2(-std::ilogb(distance_));
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
    dvec3 viewOf(const dvec3& world) const {
        const dvec3 v = world - eye_;
        return {glm::dot(right_, v), glm::dot(down_, v), glm::dot(forward_, v)};
    }
    // Zps = d Z / (d + Z) with Z = w - d: 0 at distance d, d at infinity.
    double zpsOf(double w) const { return distance_ * (w - distance_) / w; }
    // Depth w of a pixel's Z, which is Zps in the fill's unit.
    double depthOf(float z) const { return distance_ * distance_ / (distance_ - double(z) / zUnit_); }

    // A distant viewer is in the same direction from every polygon (section 3), so that no corner matters.
    bool visible(const Newell& n, const dvec3& corner, bool mirrored) const {
        return n.faces(request_.distantViewer ? -forward_ : eye_ - corner, mirrored);
    }

    [[noreturn]] void refuseCrossing(const Object& object, const TriangleMesh& mesh, uint32_t face) const {
        throw inputError(mesh.place.empty() ? printable(scene_.path) : mesh.place,
                         fmt::format("mesh.faces[{}] crosses itself (object '{}'), and --fill notes fills simple polygons", face,
                                     printable(object.name, 64)));
    }

    void addObject(uint32_t rangeNumber) {
        const DrawList::Range& r = p_.list.ranges[rangeNumber];
        const Object& object = scene_.objects[r.sceneObject];
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        if (mesh.selfCrossingFaces > 0) refuseCrossing(object, mesh, mesh.firstSelfCrossing);
        const gpu::ObjectRecord& record = p_.list.objects[r.record];
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
        Points points;
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
            std::vector<std::pair<uint32_t, glm::vec3>> carried;
            forEachCorner(f.outline, own, [&](uint32_t v) {
                glm::vec3 value = p_.list.materials[material].diffuse;
                if (shading == gpu::kShadingFlat) value = glm::vec3(colours[f.firstPoint]);
                if (shading == gpu::kShadingGouraud) value = glm::vec3(colours[point++]);
                if (shading == gpu::kShadingPhong) value = worldNormal(record, mesh.normals[v]);
                carried.emplace_back(v, value);
            });
            const auto corner = [&](uint32_t v) {
                const auto found = std::find_if(carried.begin(), carried.end(), [&](const auto& c) { return c.first == v; });
                return Corner{viewOf(world[v]), found->second};
            };
            const NotesPolygon from{rangeNumber, f.face, r.firstTriangle + f.firstTriangle, material};
            std::vector<Corner> polygon;
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

    // Sutherland and Hodgman at the near plane, always from the inside corner, so that neighbours meet in the same point.
    std::vector<Corner> inFront(const std::vector<Corner>& polygon) const {
        std::vector<Corner> kept;
        for (size_t i = 0; i < polygon.size(); ++i) {
            const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
            if (a.view.z >= near_) kept.push_back(a);
            if ((a.view.z >= near_) == (b.view.z >= near_)) continue;
            const Corner &in = a.view.z >= near_ ? a : b, &out = a.view.z >= near_ ? b : a;
            const double t = (in.view.z - near_) / (in.view.z - out.view.z);
            Corner cut{in.view + (out.view - in.view) * t, glm::vec3(dvec3(in.carried) + (dvec3(out.carried) - dvec3(in.carried)) * t)};
            cut.view.z = near_;
            kept.push_back(cut);
        }
        return kept;
    }

    // A corner on the screen before it is rounded.
    struct Projected {
        double x, y, z;
        dvec3 carried;
    };
    // Sutherland and Hodgman on the screen, where Z and what is carried are linear: +-x or +-y at most the farthest pixel.
    static std::vector<Projected> withinReach(std::vector<Projected> polygon) {
        constexpr double kReach = gpu::kScanFarthestPixel;
        for (const auto& [axis, sign] :
             {std::pair(&Projected::x, 1.0), {&Projected::x, -1.0}, {&Projected::y, 1.0}, {&Projected::y, -1.0}}) {
            std::vector<Projected> kept;
            for (size_t i = 0; i < polygon.size(); ++i) {
                const Projected &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
                const bool aIsIn = sign * a.*axis <= kReach, bIsIn = sign * b.*axis <= kReach;
                if (aIsIn) kept.push_back(a);
                if (aIsIn == bIsIn) continue;
                const Projected &in = aIsIn ? a : b, &out = aIsIn ? b : a;
                const double t = (sign * kReach - in.*axis) / (out.*axis - in.*axis);
                Projected cut{in.x + (out.x - in.x) * t, in.y + (out.y - in.y) * t, in.z + (out.z - in.z) * t,
                              in.carried + (out.carried - in.carried) * t};
                cut.*axis = sign * kReach;
                kept.push_back(cut);
            }
            polygon = std::move(kept);
        }
        return polygon;
    }

    // To pixels, rounded half to even; Z is not rounded (14.2).
    std::vector<gpu::ScanCorner> display(const std::vector<Corner>& polygon) const {
        constexpr double kBeyond = 0x1p200;   // differences and products of two stay finite
        constexpr double kNearest = 0x1p100;  // Zps grows beyond every bound toward the viewer; steps and products of it stay finite
        std::vector<Projected> projected;
        for (const Corner& c : inFront(polygon)) {
            const double x = double(list_.width) / 2 + focal_ * c.view.x / c.view.z,
                         y = double(list_.height) / 2 + focal_ * c.view.y / c.view.z;
            projected.push_back({std::clamp(x, -kBeyond, kBeyond), std::clamp(y, -kBeyond, kBeyond), zpsOf(c.view.z), dvec3(c.carried)});
        }
        std::vector<gpu::ScanCorner> corners;
        for (const Projected& c : withinReach(std::move(projected)))
            corners.push_back(
                {int(std::nearbyint(c.x)), int(std::nearbyint(c.y)), float(std::max(c.z * zUnit_, -kNearest)), glm::vec3(c.carried)});
        return corners;
    }

    bool addConvex(const std::vector<Corner>& polygon, const NotesPolygon& from) {
        const std::vector<gpu::ScanCorner> corners = display(polygon);
        if (corners.size() < 3) return true;  // nothing is left of it
        if (!isConvex(corners)) return false;
        add(corners, from);
        return true;
    }
    void addFan(const std::vector<Corner>& polygon, const NotesPolygon& from) {
        const std::vector<gpu::ScanCorner> corners = display(polygon);
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
            const dvec3 n(canvas.carried[i]);
            // Interpolated normals are made unit again (A15); one that vanished on the way is the face's.
            const double length = phong ? std::sqrt(glm::dot(n, n)) : 0;
            normals[k] = length > 0x1p-20 ? glm::vec3(n / length)
                                          : worldNormal(p_.list.objects[r.record],
                                                        scene_.meshes[scene_.objects[r.sceneObject].mesh].faceNormal[from.face]);
        }
        if (phong) {
            Points points;
            for (size_t k = 0; k < covered.size(); ++k) {
                const size_t i = covered[k];
                points.positions.emplace_back(glm::vec3(pixelRay(i) * (depthOf(canvas.z[i]) * unit_)), 1.0f);
                points.normals.emplace_back(normals[k], 0.0f);
                points.materials.push_back(from_[canvas.owner[i]].material);
            }
            if (!covered.empty()) {
                const std::vector<glm::vec4> colours = side_.illuminate(points, kNone);
                for (size_t k = 0; k < covered.size(); ++k) setColour(linear, covered[k], glm::vec3(colours[k]));
            }
            result_.counters.illuminations += covered.size();
        } else {
            for (uint32_t i : covered) setColour(linear, i, canvas.carried[i]);
        }
        write(canvas, covered, linear, normals);
    }

    static void setColour(std::vector<float>& linear, size_t sample, const glm::vec3& colour) {
        std::copy_n(&colour.x, 3, linear.begin() + ptrdiff_t(3 * sample));
    }

    // Direction to the sample, forward component 1. The notes' pixel (x, y) is the point (x, y) of the screen, not the middle of a cell.
    dvec3 pixelRay(size_t i) const {
        const size_t column = i % size_t(list_.width), row = i / size_t(list_.width);
        const double x = double(column) - double(list_.width) / 2, y = double(row) - double(list_.height) / 2;
        return forward_ + right_ * (x / focal_) + down_ * (y / focal_);
    }

    // What the polygon that owns a sample shows there.
    class Seen : public SeenNothing {
    public:
        Seen(const NotesFrame& frame, const ScanCanvas& canvas, size_t sample, const glm::vec3& normal)
            : frame_(frame),
              from_(frame.from_[canvas.owner[sample]]),
              sample_(sample),
              depth_(frame.depthOf(canvas.z[sample])),
              normal_(normal) {}
        float z() const { return float(frame_.near_ / depth_); }
        float depth() const { return float(depth_); }
        float distance() const {
            const dvec3 ray = frame_.pixelRay(sample_);
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
        {
            const Stopwatch watch(&result_.times, p_.side > 1 ? "resolve" : "encode");
            writer_.takeColours(0, p_.height, {layout, linear, drawn}, threadCount(request_.threads));
        }
        writer_.takeCoverage<int>(p_.height, layout, drawn);
        writer_.takeSeen<int>(0, p_.height, layout, drawn, [&](uint32_t, uint32_t, size_t sample) {
            return Seen(*this, canvas, sample, normals.empty() ? glm::vec3(0) : normals[size_t(drawn[sample] - 1)]);
        });
        result_.counters.bands = result_.counters.chunks = 1;
    }

    const Scene& scene_;
    const Prepared& p_;
    const RenderRequest& request_;
    Side& side_;
    PlaneWriter& writer_;
    RenderResult& result_;
    dvec3 right_, down_, forward_, eye_;
    double focal_ = 0, distance_ = 0, near_ = 0, unit_ = 1;
    double zUnit_ = 1;  // power of two that brings the viewer's distance to [1, 2): the fill's Z keeps clear of float32's ends
    double illuminateMs_ = 0;
    ScanList list_;
    std::vector<NotesPolygon> from_;
};

// Points that are given relative to the eye already, in the world's axes.
gpu::ObjectRecord identityRecord() {
    gpu::ObjectRecord o{};
    o.world0 = o.normal0 = {1, 0, 0, 0};
    o.world1 = o.normal1 = {0, 1, 0, 0};
    o.world2 = o.normal2 = {0, 0, 1, 0};
    return o;
}
std::vector<gpu::ObjectRecord> withIdentity(const Prepared& p) {
    std::vector<gpu::ObjectRecord> objects = p.list.objects;
    objects.push_back(identityRecord());
    return objects;
}

class TwinSide : public Side {
public:
    TwinSide(const Prepared& p, const RenderRequest& request, RenderResult& result)
        : p_(p), threads_(threadCount(request.threads)), result_(result), objects_(withIdentity(p)) {}
    std::vector<glm::vec4> illuminate(const Points& points, uint32_t record) override {
        const Stopwatch watch(&result_.times, "illuminate");
        std::vector<glm::vec4> colours(points.positions.size());
        const gpu::IlluminatePush push{0,
                                       0,
                                       uint32_t(colours.size()),
                                       std::min(record, uint32_t(objects_.size() - 1)),
                                       0,
                                       uint32_t(p_.list.lights.size()),
                                       p_.list.towardViewer};
        illuminateCpu(push, p_.choices.parts, points.positions, points.normals, points.materials, objects_, p_.list.materials,
                      p_.list.lights, colours, threads_);
        return colours;
    }
    ScanCanvas paint(const ScanList& list) override {
        const Stopwatch watch(&result_.times, "scanline");
        return scanlineCpu(list);
    }

private:
    const Prepared& p_;
    uint32_t threads_;
    RenderResult& result_;
    std::vector<gpu::ObjectRecord> objects_;
};

template <class T>
Buffer<T> uploaded(Device& device, std::span<const T> from, const char* name) {
    Buffer<T> buffer(device, std::max<size_t>(1, from.size()), name);
    buffer.upload(from);
    return buffer;
}

class DeviceSide : public Side {
public:
    DeviceSide(Device& device, const Prepared& p, const RenderRequest& request)
        : device_(device),
          p_(p),
          watchdogMs_(request.watchdogMs),
          recorder_(device),
          objects_(uploaded<gpu::ObjectRecord>(device, withIdentity(p), "objects")),
          materials_(uploaded<gpu::MaterialRecord>(device, p.list.materials, "materials")),
          lights_(uploaded<gpu::LightRecord>(device, p.list.lights, "lights")) {
        recorder_.allow(p.plan.labels(RunsOn::device));
    }
    std::vector<glm::vec4> illuminate(const Points& points, uint32_t record) override {
        const DeviceLimits& l = device_.limits();
        const uint64_t most = std::min<uint64_t>({l.storageRangeBytes / sizeof(glm::vec4), l.texelElements, uint64_t(1) << 20});
        std::vector<glm::vec4> all;
        for (uint64_t first = 0; first < points.positions.size(); first += most) {
            const uint64_t count = std::min<uint64_t>(most, points.positions.size() - first);
            const auto positions = uploaded<glm::vec4>(device_, std::span(points.positions).subspan(first, count), "points");
            const auto normals = uploaded<glm::vec4>(device_, std::span(points.normals).subspan(first, count), "point normals");
            const auto materials = uploaded<uint32_t>(device_, std::span(points.materials).subspan(first, count), "point materials");
            Buffer<glm::vec4> colours(device_, count, "point colours");
            const gpu::IlluminatePush push{0,
                                           0,
                                           uint32_t(count),
                                           std::min(record, uint32_t(p_.list.objects.size())),
                                           0,
                                           uint32_t(p_.list.lights.size()),
                                           p_.list.towardViewer};
            recordIlluminate(recorder_, push, p_.choices.parts, {}, positions, normals, materials, objects_, materials_, lights_, colours);
            recorder_.run(watchdogMs_);
            all.insert(all.end(), colours.span().begin(), colours.span().begin() + ptrdiff_t(count));
        }
        return all;
    }
    ScanCanvas paint(const ScanList& list) override { return scanlineGpu(device_, recorder_, list, {}, watchdogMs_, nullptr); }
    Recorder& recorder() { return recorder_; }

private:
    Device& device_;
    const Prepared& p_;
    double watchdogMs_;
    Recorder recorder_;
    Buffer<gpu::ObjectRecord> objects_;
    Buffer<gpu::MaterialRecord> materials_;
    Buffer<gpu::LightRecord> lights_;
};

}  // namespace

namespace {

void refusePolygons(const Scene& scene, const RenderRequest& request) {
    refuseOtherTrade(request);
    refuseShapes(scene);
}

Prepared preparePolygons(const Scene& scene, const RenderRequest& request, RunsOn side) {
    Preparing it(scene, request, shadingOf(request));
    it.dropRays(raysAskedBy(scene));
    it.list.addObjects();
    it.addLights();
    it.leaveOut();
    const bool atPixels = it.p.choices.shading == gpu::kShadingPhong;
    StepList steps(request, it.p, side);
    steps.addOnHost("project", "corners to whole pixels, by the notes' projection");
    if (!atPixels) steps.addIllumination();
    steps.add("scanline", "the first and last column of each polygon in each row");
    if (steps.onDevice())
        steps.add("scanpaint", "the nearest polygon of each pixel, row by row");
    else
        steps.addFused("scanpaint", "scanline", "the nearest polygon of each pixel, row by row");
    if (atPixels) steps.add("illuminate", "illumination at each pixel");
    steps.addColours(it.p.side * it.p.side, RunsOn::host, "");
    it.p.plan.choices.push_back(
        "fill notes: corners on whole pixels, both ends of a line painted, what is carried interpolated along edges and lines");
    return it.finish();
}

class PolygonPicture : public PreparedPicture {
public:
    using PreparedPicture::PreparedPicture;

private:
    void draw(Device* device, PlaneWriter& writer, RenderResult& result) override {
        if (device == nullptr) {
            TwinSide side(p_, request_, result);
            NotesFrame(scene_, p_, request_, side, writer, result).draw();
            return;
        }
        DeviceSide side(*device, p_, request_);
        NotesFrame(scene_, p_, request_, side, writer, result).draw();
        const std::vector<PassTime> times = side.recorder().takeTimes();
        result.times.insert(result.times.end(), times.begin(), times.end());
        for (const auto& [step, why] : side.recorder().takeSkipped()) result.plan.skip(step, why);
    }
};

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, Prepared prepared) {
    return std::make_unique<PolygonPicture>(scene, request, std::move(prepared));
}

}  // namespace

const Technique kPolygons = {
    .name = "notes",
    .refuse = refusePolygons,
    .prepare = preparePolygons,
    .picture = pictureOf,
    .leavesToRays = raysAskedBy,
    .planes = kPlanesOfLines | kPlanesOfSurfaces | kPlaneTriangle,
    .vertices = Technique::Vertices::host,
};

void refuseOtherTrade(const RenderRequest& request) {
    Trade other = request.trade;
    other.specular = Trade().specular;
    if (other != Trade{}) throw usageError("--trade: --fill notes has the axis specular; the others are of --fill exact");
}

}  // namespace plumb
