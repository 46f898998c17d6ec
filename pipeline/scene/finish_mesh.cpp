// SPDX-License-Identifier: MIT
// Polygons become triangles with normals. All arithmetic is binary64 + - * / and square root, which IEEE 754 rounds correctly everywhere.
// No function of the C library decides a bit, so a file gives the same mesh on every machine.
//
// Order is the file's: vertices and edges by first use, triangles by face. No result depends on the order of a hash.
#include "pipeline/scene/face_cutter.h"
#include "pipeline/scene/index_table.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/mesh_origin.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Least area of a face, a corner. A face has no area when its Newell sum is below what binary64 rounding leaves of collinear float32
// corners. Each of n cross products has an error of at most 4 * 2^-53 * L^2. L is the longest distance from the first corner.
constexpr double kZeroAreaPerCorner = 0x1p-51;

// Largest condition number sum |w| / |sum w n| of a mean normal; above it the mean has lost 10 bits.
constexpr double kMaxNormalCondition = 1024;

// Cosine between a file's normal and its face below which the normal is opposite: the face would be lit from behind. Means over a smooth
// neighbourhood stay within 90 degrees; 120 leaves room for faces that are coarser than the surface they stand for.
constexpr double kOppositeCosine = -0.5;

constexpr double kPi = 3.14159265358979323846;

std::array<uint32_t, 3> bitsOf(const glm::vec3& v) {
    return {std::bit_cast<uint32_t>(v.x), std::bit_cast<uint32_t>(v.y), std::bit_cast<uint32_t>(v.z)};
}

float flushed(float x, uint32_t& count) {
    if (x == 0 || std::abs(x) >= std::numeric_limits<float>::min()) return x == 0 ? 0.0f : x;  // -0 becomes +0
    ++count;
    return 0.0f;
}

glm::vec3 flushed(const glm::vec3& v, uint32_t& count) { return {flushed(v.x, count), flushed(v.y, count), flushed(v.z, count)}; }

double lengthOf(const glm::dvec3& v) { return std::sqrt((v.x * v.x + v.y * v.y) + v.z * v.z); }
double dotOf(const glm::dvec3& a, const glm::dvec3& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

// Angle by arccos to 2e-8 (Abramowitz and Stegun 4.4.46). A weight needs no more, and acos differs between C libraries.
double angleOf(double cosine) {
    const double x = std::min(std::abs(cosine), 1.0);
    constexpr double kA[] = {1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                             0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
    double sum = kA[7];
    for (int i = 6; i >= 0; --i) sum = sum * x + kA[i];
    const double angle = std::sqrt(1.0 - x) * sum;
    return cosine < 0 ? kPi - angle : angle;
}

class Finisher {
public:
    Finisher(PolygonMesh in, std::vector<Material>& materials, uint32_t fallback, const LoadOptions& options)
        : in_(std::move(in)), materials_(materials), options_(options), fallback_(fallback), crease_(options.creaseDegrees * (kPi / 180)) {}

    TriangleMesh run() {
        PLUMB_ASSERT(in_.faceFirst.size() == in_.faceMaterial.size() + 1 || in_.faceMaterial.empty());
        faces_ = in_.faceFirst.empty() ? 0 : in_.faceFirst.size() - 1;
        out_.name = in_.name;
        out_.location = in_.location;
        takeOrigin();
        weldPositions();
        takeNormals();
        takeMaterials();
        measureFaces();
        findEdges();
        buildMissingNormals();
        makeVertices();
        cutFaces();
        if (!out_.positions.empty()) {
            out_.boundsMin = out_.boundsMax = out_.positions[0];
            for (const glm::vec3& p : out_.positions) {
                out_.boundsMin = glm::min(out_.boundsMin, p);
                out_.boundsMax = glm::max(out_.boundsMax, p);
            }
        }
        return std::move(out_);
    }

private:
    // Ends of the steps, in shares of the time for 10^7 triangles without normals.
    static constexpr double kWelded = 0.1, kMeasured = 0.2, kEdgesFound = 0.5, kJoined = 0.65, kSummed = 0.75, kVerticesMade = 0.95;
    LoadMeter meterOf(double from, double to, uint64_t total) const {
        return {options_, "finish", kParseEnds + (1 - kParseEnds) * from, kParseEnds + (1 - kParseEnds) * to, total};
    }

    uint32_t next(size_t face, uint32_t corner) const { return corner + 1 < in_.faceFirst[face + 1] ? corner + 1 : in_.faceFirst[face]; }
    uint32_t previous(size_t face, uint32_t corner) const {
        return corner > in_.faceFirst[face] ? corner - 1 : in_.faceFirst[face + 1] - 1;
    }
    uint32_t weldedAt(uint32_t corner) const { return welded_[in_.corners[corner].position]; }
    glm::dvec3 at(uint32_t corner) const { return glm::dvec3(positions_[in_.corners[corner].position]); }

    // Takes the origin from the box of the positions that faces name; other positions move nothing.
    void takeOrigin() {
        const std::vector<bool> named = namedPositions();
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
        for (size_t i = 0; i < named.size(); ++i)
            if (named[i]) low = glm::min(low, in_.positions[i]), high = glm::max(high, in_.positions[i]);
        if (low.x <= high.x) out_.statedMin = low, out_.statedMax = high;
        out_.origin = originOfBox(out_.statedMin, out_.statedMax);
        positions_.reserve(in_.positions.size());
        for (size_t i = 0; i < named.size(); ++i) {
            const glm::dvec3 exact = in_.positions[i] - out_.origin;
            positions_.push_back(flushed(glm::vec3(exact), out_.flushedDenormals));
            out_.flushedDenormals += underflows(exact);
            if (named[i]) out_.lost = glm::max(out_.lost, glm::abs(exact - glm::dvec3(positions_[i])));
        }
        if (!options_.keepNumbers || out_.lost == glm::dvec3(0)) in_.positions.release();
    }

    std::vector<bool> namedPositions() const {
        std::vector<bool> named(in_.positions.size());
        for (const PolygonMesh::Corner& corner : in_.corners) named[corner.position] = true;
        return named;
    }

    // Number of coordinates that float32 rounds to 0 before flushed() sees them.
    static uint32_t underflows(const glm::dvec3& v) {
        uint32_t count = 0;
        for (int i = 0; i < 3; ++i) count += v[i] != 0 && float(v[i]) == 0;
        return count;
    }

    // Welds positions with the same bits, because STL repeats a position for each triangle.
    void weldPositions() {
        welded_.resize(positions_.size());
        IndexTable table(positions_.size());
        const auto hashOf = [&](uint32_t i) {
            const auto b = bitsOf(positions_[i]);
            return mixBits((uint64_t(b[0]) << 32 | b[1]) ^ mixBits(b[2]));
        };
        LoadMeter meter = meterOf(0, kWelded, positions_.size());
        for (uint32_t i = 0; i < positions_.size(); ++i, meter.at(i))
            welded_[i] = table.findOrAdd(
                hashOf(i), i, [&](uint32_t j) { return positions_[i] == positions_[j]; }, hashOf);
    }

    void takeNormals() {
        normals_.reserve(in_.normals.size());
        for (const glm::vec3& n : in_.normals) {
            const glm::dvec3 clean(flushed(n, out_.flushedDenormals));
            const double length = lengthOf(clean);
            normals_.push_back(length > 0 ? clean / length : clean);
        }
    }

    void takeMaterials() {
        firstMaterial_ = uint32_t(materials_.size());
        for (Material material : in_.materials) {
            for (glm::vec3* colour : {&material.ambient, &material.diffuse, &material.specular, &material.emission})
                *colour = flushed(*colour, out_.flushedDenormals);
            material.shininess = flushed(material.shininess, out_.flushedDenormals);
            materials_.push_back(material);
        }
    }

    uint32_t materialOf(size_t face) const {
        const uint32_t material = in_.faceMaterial.empty() ? kNone : in_.faceMaterial[face];
        return material == kNone ? fallback_ : firstMaterial_ + material;
    }

    void measureFaces() {
        faceNormal_.resize(faces_);
        out_.faceCentre.reserve(faces_);
        out_.faceNormal.reserve(faces_);
        out_.faceMaterial.reserve(faces_);
        LoadMeter meter = meterOf(kWelded, kMeasured, faces_);
        for (size_t f = 0; f < faces_; ++f) {
            meter.at(f);
            const uint32_t first = in_.faceFirst[f], end = in_.faceFirst[f + 1];
            // Newell's normal, about the first corner: differences of float32 are exact or nearly so in binary64.
            const glm::dvec3 origin = at(first);
            glm::dvec3 sum(0), offset(0), a(0);
            double longest = 0;
            for (uint32_t c = first + 1; c < end; ++c) {
                const glm::dvec3 b = at(c) - origin;
                sum += glm::dvec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
                offset += b;
                longest = std::max(longest, dotOf(b, b));
                a = b;
            }
            const double length = lengthOf(sum);
            const bool flat = length <= kZeroAreaPerCorner * double(end - first) * longest;
            faceNormal_[f] = flat ? glm::dvec3(0) : sum / length;
            out_.degenerateFaces += flat;
            out_.faceNormal.push_back(flat ? glm::vec3(0, 0, 1) : glm::vec3(faceNormal_[f]));
            out_.faceCentre.push_back(glm::vec3(origin + offset / double(end - first)));
            out_.faceMaterial.push_back(materialOf(f));
        }
    }

    struct Edge {
        uint32_t from, to;                    // welded positions, in the order of the first face
        uint32_t corner, face;                // first occurrence
        uint32_t smooth[2] = {kNone, kNone};  // corners where the faces with an area begin this edge
        uint32_t smoothFace[2] = {kNone, kNone};
        uint32_t count = 0;  // faces with an area
    };

    void findEdges() {
        IndexTable table(in_.corners.size() / 2);
        const auto hash = [](uint32_t a, uint32_t b) { return mixBits(uint64_t(std::min(a, b)) << 32 | std::max(a, b)); };
        LoadMeter meter = meterOf(kMeasured, kEdgesFound, faces_);
        for (size_t f = 0; f < faces_; ++f, meter.at(f))
            for (uint32_t c = in_.faceFirst[f]; c < in_.faceFirst[f + 1]; ++c) {
                const uint32_t a = weldedAt(c), b = weldedAt(next(f, c));
                if (a == b) continue;
                const uint32_t fresh = uint32_t(edges_.size());
                const uint32_t e = table.findOrAdd(
                    hash(a, b), fresh,
                    [&](uint32_t i) { return (edges_[i].from == a && edges_[i].to == b) || (edges_[i].from == b && edges_[i].to == a); },
                    [&](uint32_t i) { return hash(edges_[i].from, edges_[i].to); });
                if (e == fresh) edges_.push_back({a, b, c, uint32_t(f)});
                // Faces without area have no side, so the faces beside one are neighbours of each other.
                if (faceNormal_[f] == glm::dvec3(0)) continue;
                Edge& edge = edges_[e];
                if (edge.count < 2) edge.smooth[edge.count] = c, edge.smoothFace[edge.count] = uint32_t(f);
                ++edge.count;
            }
    }

    // True when the normal is smooth across the edge. Exactly two faces must meet there and agree on which side is out. They must have the
    // same smoothing group of the file or, where a group is not stated, an angle below the crease angle.
    bool isSmooth(const Edge& edge) const {
        if (edge.count != 2 || weldedAt(edge.smooth[0]) == weldedAt(edge.smooth[1])) return false;
        const uint32_t f = edge.smoothFace[0], g = edge.smoothFace[1];
        if (!in_.faceSmoothing.empty()) {
            const uint32_t a = in_.faceSmoothing[f], b = in_.faceSmoothing[g];
            if (a == 0 || b == 0) return false;
            if (a != kNone && b != kNone) return a == b;
        }
        return angleOf(dotOf(faceNormal_[f], faceNormal_[g])) < crease_;
    }

    uint32_t fanOf(uint32_t corner) {
        while (fan_[corner] != corner) corner = fan_[corner] = fan_[fan_[corner]];
        return corner;
    }
    void join(uint32_t a, uint32_t b) {
        a = fanOf(a);
        b = fanOf(b);
        if (a != b) fan_[std::max(a, b)] = std::min(a, b);
    }

    // Builds a corner's normal as the mean over the faces around its position that smooth edges connect. The weight is their angle there
    // (Thuermer and Wuethrich 1998), so that cutting a face in two changes nothing.
    void buildMissingNormals() {
        const bool missing = std::any_of(in_.corners.begin(), in_.corners.end(), [](const auto& c) { return c.normal == kNone; });
        if (!missing) return;
        fan_.resize(in_.corners.size());
        for (uint32_t c = 0; c < fan_.size(); ++c) fan_[c] = c;
        LoadMeter joining = meterOf(kEdgesFound, kJoined, edges_.size());
        uint64_t asked = 0;
        for (const Edge& edge : edges_) {
            joining.at(++asked);
            if (!isSmooth(edge)) continue;
            join(edge.smooth[0], next(edge.smoothFace[1], edge.smooth[1]));
            join(edge.smooth[1], next(edge.smoothFace[0], edge.smooth[0]));
        }
        fanSum_.assign(in_.corners.size(), glm::dvec4(0));
        LoadMeter adding = meterOf(kJoined, kSummed, faces_);
        for (size_t f = 0; f < faces_; ++f, adding.at(f))
            for (uint32_t c = in_.faceFirst[f]; c < in_.faceFirst[f + 1]; ++c) {
                const glm::dvec3 toNext = at(next(f, c)) - at(c), toPrevious = at(previous(f, c)) - at(c);
                const double lengths = lengthOf(toNext) * lengthOf(toPrevious);
                const double weight = lengths > 0 ? angleOf(dotOf(toNext, toPrevious) / lengths) : 0;
                if (faceNormal_[f] != glm::dvec3(0)) fanSum_[fanOf(c)] += glm::dvec4(faceNormal_[f] * weight, weight);
            }
    }

    glm::vec3 normalOf(size_t face, uint32_t corner) {
        const uint32_t given = in_.corners[corner].normal;
        const bool flat = faceNormal_[face] == glm::dvec3(0);
        if (given != kNone) {
            const glm::dvec3& n = normals_[given];
            if (n != glm::dvec3(0) && (flat || dotOf(n, faceNormal_[face]) > kOppositeCosine)) return clean(n);
        } else {
            if (!in_.faceSmoothing.empty() && in_.faceSmoothing[face] == 0) return out_.faceNormal[face];
            const glm::dvec4& sum = fanSum_[fanOf(corner)];
            const double length = lengthOf(glm::dvec3(sum));
            if (length > 0 && sum.w <= kMaxNormalCondition * length) return clean(glm::dvec3(sum) / length);
            if (flat) return out_.faceNormal[face];  // counted as a face without area
        }
        ++out_.repairedNormals;
        return out_.faceNormal[face];
    }

    // Unit vector in float32 without denormals and without -0 (vertices are compared by bits).
    static glm::vec3 clean(const glm::dvec3& n) {
        uint32_t notCounted = 0;
        return flushed(glm::vec3(n), notCounted);
    }

    void makeVertices() {
        vertexOf_.resize(in_.corners.size());
        std::vector<uint32_t> positionOfVertex;
        IndexTable table(positions_.size());
        const auto hash = [](uint32_t welded, const glm::vec3& normal, uint32_t material) {
            const auto b = bitsOf(normal);
            return mixBits((uint64_t(welded) << 32 | b[0]) ^ mixBits((uint64_t(b[1]) << 32 | b[2]) + material));
        };
        LoadMeter meter = meterOf(kSummed, kVerticesMade, faces_);
        for (size_t f = 0; f < faces_; ++f) {
            meter.at(f);
            const uint32_t material = out_.faceMaterial[f];
            for (uint32_t c = in_.faceFirst[f]; c < in_.faceFirst[f + 1]; ++c) {
                const uint32_t where = weldedAt(c);
                const glm::vec3 normal = normalOf(f, c);
                const uint32_t fresh = uint32_t(out_.positions.size());
                const uint32_t v = table.findOrAdd(
                    hash(where, normal, material), fresh,
                    [&](uint32_t i) {
                        return positionOfVertex[i] == where && out_.vertexMaterial[i] == material && out_.normals[i] == normal;
                    },
                    [&](uint32_t i) { return hash(positionOfVertex[i], out_.normals[i], out_.vertexMaterial[i]); });
                if (v == fresh) {
                    positionOfVertex.push_back(where);
                    out_.positions.push_back(positions_[where]);
                    if (!in_.positions.empty()) out_.stated.push_back(in_.positions[where]);
                    out_.normals.push_back(normal);
                    out_.vertexMaterial.push_back(material);
                }
                vertexOf_[c] = v;
            }
        }
        out_.edges.reserve(edges_.size());
        for (const Edge& edge : edges_) out_.edges.push_back({vertexOf_[edge.corner], vertexOf_[next(edge.face, edge.corner)]});
    }

    [[noreturn]] void refuseUncut(size_t face) const {
        throw inputError(in_.location.empty() ? printable(in_.name) : in_.location,
                         fmt::format("face {} is concave and has {} corners, too many to triangulate", face,
                                     in_.faceFirst[face + 1] - in_.faceFirst[face]));
    }

    void cutFaces() {
        out_.triangles.reserve(in_.corners.size() - 2 * faces_);
        FaceCutter cutter;
        size_t firstUncut = 0;
        LoadMeter meter = meterOf(kVerticesMade, 1, faces_);
        for (size_t f = 0; f < faces_; ++f) {
            meter.at(f);
            const uint32_t first = in_.faceFirst[f], n = in_.faceFirst[f + 1] - first;
            const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
                out_.triangles.push_back({{vertexOf_[first + a], vertexOf_[first + b], vertexOf_[first + c]}, uint32_t(f)});
            };
            if (n == 3) {
                add(0, 1, 2);
                continue;
            }
            cutter.cuts.clear();
            const glm::dvec3 normal = faceNormal_[f];
            if (normal == glm::dvec3(0)) {
                cutter.fan(n);
            } else {
                // Projection that drops the coordinate in which the normal is largest: it keeps turns and rounds nothing.
                const glm::dvec3 size = glm::abs(normal);
                const int drop = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
                int u = (drop + 1) % 3, v = (drop + 2) % 3;
                if (normal[drop] < 0) std::swap(u, v);
                cutter.points.clear();
                for (uint32_t c = first; c < first + n; ++c) cutter.points.push_back({at(c)[u], at(c)[v]});
                const FaceCutter::Outcome outcome = cutter.run();
                if (outcome == FaceCutter::Outcome::tooLarge && out_.uncutFaces++ == 0) {
                    firstUncut = f;
                    if (options_.strict) refuseUncut(f);
                }
                if (outcome == FaceCutter::Outcome::selfCrossing && out_.selfCrossingFaces++ == 0) out_.firstSelfCrossing = uint32_t(f);
            }
            for (const FaceCutter::Cut& cut : cutter.cuts) add(cut[0], cut[1], cut[2]);
        }
        if (out_.uncutFaces > 0 && out_.triangles.empty()) refuseUncut(firstUncut);
    }

    PolygonMesh in_;
    std::vector<Material>& materials_;
    const LoadOptions& options_;
    const uint32_t fallback_;
    const double crease_;  // radians
    TriangleMesh out_;
    size_t faces_ = 0;
    std::vector<glm::vec3> positions_;  // relative to the origin, denormals flushed
    std::vector<uint32_t> welded_;      // position -> the first with the same bits
    std::vector<glm::dvec3> normals_;   // normals of the file: unit, or 0
    uint32_t firstMaterial_ = 0;
    std::vector<glm::dvec3> faceNormal_;  // unit, or 0
    std::vector<Edge> edges_;
    std::vector<uint32_t> fan_;       // corner -> a corner of the same fan (union-find; the root is itself)
    std::vector<glm::dvec4> fanSum_;  // at roots: weighted normals, and their weights
    std::vector<uint32_t> vertexOf_;  // corner -> vertex
};

}  // namespace

TriangleMesh finishMesh(PolygonMesh mesh, std::vector<Material>& materials, uint32_t fallback, const LoadOptions& options) {
    return Finisher(std::move(mesh), materials, fallback, options).run();
}

}  // namespace plumb
