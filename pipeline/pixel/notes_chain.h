// SPDX-License-Identifier: MIT
// The notes' chain of one triangle at one sample, from its vertices to its colour, in float or Interval (textbook.h).
#pragma once

#include "pipeline/pixel/textbook.h"

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb::textbook {

struct TriangleInput {
    const Scene& scene;
    const Object& object;
    const TriangleMesh& mesh;
    uint32_t vertex[3] = {};        // of the mesh, in the order of its face
    glm::dvec3 origin{0};           // composite and vertices count from here, in the object's space
    double width = 0, height = 0;   // samples
    double side = 1;                // samples a pixel along an axis
    double focal = 0;               // samples
    double near = 0, distance = 0;  // scene units; `distance`: viewer's from the screen, for Zps
    bool mirrored = false;          // the object's matrix turns polygons around
    bool sampled = false;           // true: the chain goes on to the point (x, y)
    double x = 0, y = 0;            // samples from the top left
    bool distantViewer = false, srgb = true;
    bool lit = true;  // true: the point is illuminated
    const Material* material = nullptr;
};

// Normal matrix: cofactors, up to a positive factor.
template <class R>
std::array<Vector<R>, 3> normalColumns(const glm::dmat4& m, bool mirrored) {
    const Vector<R> a{glm::dvec3(m[0])}, b{glm::dvec3(m[1])}, c{glm::dvec3(m[2])};
    std::array<Vector<R>, 3> n = {cross(b, c), cross(c, a), cross(a, b)};
    if (mirrored)
        for (Vector<R>& v : n) v = -v;
    return n;
}

template <class R>
class TriangleChain {
public:
    explicit TriangleChain(const TriangleInput& in) : in_(in) {}

    Values<R> make() {
        vertices();
        cull();
        if (in_.sampled) fill();
        return std::move(out_);
    }

private:
    static R real(double x) { return R(x); }
    // The textbook rounds to a byte; the truth keeps the code as it is.
    static float asByte(float code) { return nearestWhole(code); }
    static Interval asByte(const Interval& code) { return code; }
    Vector<R> column(int i) const { return Vector<R>(glm::dvec3(in_.object.worldFromObject[i])); }
    Vector<R> world(const Vector<R>& p) const { return column(0) * p.x + column(1) * p.y + column(2) * p.z + column(3); }

    void vertices() {
        const Camera& camera = *in_.scene.camera;
        const Vector<R> right(camera.right), down(-camera.up), forward(camera.forward), eye(camera.eye), origin(in_.origin);
        const R focal = real(in_.focal), distance = real(in_.distance), half(2);
        const Vector<R> axes[3] = {right * focal, down * focal, forward};
        const Vector<R> moved = world(origin) - eye;
        std::vector<R> composite;
        for (const Vector<R>& axis : axes)
            for (const R& entry : {dot(axis, column(0)), dot(axis, column(1)), dot(axis, column(2)), dot(axis, moved)})
                composite.push_back(entry);
        out_["M"] = composite;
        for (int i = 0; i < 3; ++i) {
            const std::string n = std::to_string(i);
            const Vector<R> stated(in_.mesh.statedAt(in_.vertex[i])), p = stated - origin;
            world_[i] = world(stated);
            out_["P" + n] = p.list();
            const auto row = [&](int k) {
                const size_t at = 4 * size_t(k);
                return composite[at] * p.x + composite[at + 1] * p.y + composite[at + 2] * p.z + composite[at + 3];
            };
            const R x = row(0), y = row(1), w = row(2);
            out_["c" + n] = {x, y, w};
            inverseW_[i] = real(1) / w;
            zps_[i] = distance * ((w - distance) / w);
            z_[i] = real(in_.near) / w;
            const R xps = x / w, yps = -(y / w);
            out_["projected" + n] = {xps, yps, zps_[i]};
            display_[i] = {real(in_.width) / half + xps, real(in_.height) / half - yps, zps_[i]};
            out_["display" + n] = display_[i].list();
            out_["whole" + n] = {nearestWhole(display_[i].x), nearestWhole(display_[i].y), zps_[i]};
            out_["z" + n] = {z_[i]};
        }
    }

    void cull() {
        const Plane<R> plane(world_[0], world_[1], world_[2], Vector<R>(in_.scene.camera->eye));
        out_["P"] = plane.p.list();
        out_["Q"] = plane.q.list();
        out_["N"] = plane.n.list();
        out_["N_length"] = {plane.magnitudeN};
        out_["N_unit"] = plane.unitN.list();
        out_["D"] = {plane.d};
        out_["NV"] = {plane.nv};
        const R result = in_.mirrored ? -plane.result : plane.result;
        out_["NV_minus_D"] = {result};
        const R whole = dot(plane.n, Vector<R>(in_.scene.camera->eye)) - dot(plane.n, world_[0]);
        out_["NV_minus_D_whole"] = {in_.mirrored ? -whole : whole};
        out_["visible"] = {isPositive(result)};
    }

    void fill() {
        const R px = real(in_.x), py = real(in_.y);
        // Twice an area, positive where the corners run counter-clockwise as seen; y runs down.
        const auto area = [](const Vector<R>& a, const Vector<R>& b, const R& x, const R& y) {
            return (b.y - a.y) * (x - a.x) + (a.x - b.x) * (y - a.y);
        };
        R edge[3];
        for (int i = 0; i < 3; ++i) edge[i] = area(display_[i], display_[(i + 1) % 3], px, py);
        const R whole = area(display_[0], display_[1], display_[2].x, display_[2].y);
        out_["area"] = {whole};
        std::vector<R> shares;  // of the corners: the edge across from each over the whole
        for (int i = 0; i < 3; ++i) shares.push_back(edge[(i + 1) % 3] / whole);
        out_["shares"] = shares;
        R covered = isPositive(shares[0]) * isPositive(shares[1]) * isPositive(shares[2]);
        out_["inside"] = {covered};
        out_["z"] = {shares[0] * z_[0] + shares[1] * z_[1] + shares[2] * z_[2]};
        out_["Zps"] = {shares[0] * zps_[0] + shares[1] * zps_[1] + shares[2] * zps_[2]};
        const R inverse = shares[0] * inverseW_[0] + shares[1] * inverseW_[1] + shares[2] * inverseW_[2];
        out_["depth"] = {real(1) / inverse};
        std::vector<R> seen;  // shares in space
        for (size_t i = 0; i < 3; ++i) seen.push_back(shares[i] * inverseW_[i] / inverse);
        out_["shares_in_space"] = seen;
        if (!in_.lit || in_.material == nullptr) return;
        const std::array<Vector<R>, 3> columns = normalColumns<R>(in_.object.worldFromObject, in_.mirrored);
        Vector<R> object, position;
        for (size_t i = 0; i < 3; ++i) {
            object = object + Vector<R>(glm::dvec3(in_.mesh.normals[in_.vertex[i]])) * seen[i];
            position = position + (world_[i] - Vector<R>(in_.scene.camera->eye)) * seen[i];
        }
        Point<R> point;
        point.normal = unit(columns[0] * object.x + columns[1] * object.y + columns[2] * object.z);
        point.position = position;
        point.view = in_.distantViewer ? -unit(Vector<R>(in_.scene.camera->forward)) : unit(-position);
        out_["position"] = position.list();
        const Vector<R> colour = illuminate(in_.scene, *in_.material, point, "pixel_", out_);
        out_["linear"] = colour.list();
        out_["bytes"] = {asByte(codeOf(colour.x, in_.srgb)), asByte(codeOf(colour.y, in_.srgb)), asByte(codeOf(colour.z, in_.srgb))};
    }

    const TriangleInput in_;
    Values<R> out_;
    Vector<R> world_[3], display_[3];
    R inverseW_[3], zps_[3], z_[3];
};

}  // namespace plumb::textbook
