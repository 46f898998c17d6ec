// SPDX-License-Identifier: MIT
// A scene as the user means it: binary64 world space, before anything is planned.
#pragma once

#include "pipeline/choices/choices.h"
#include "pipeline/scene/mesh.h"
#include "pipeline/transform/step.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

enum class Attenuation { none, inverse, inverseSquare };

struct Object {
    std::string name;
    uint32_t mesh = 0;
    // column vectors: world = worldFromObject * object; for the positions that a mesh keeps: worldFromMesh()
    glm::dmat4 worldFromObject{1.0};
    std::vector<Step<glm::dmat4>> chain;  // its elementary steps in order of application, parents' included; scene.toml only
    std::string location;  // where the file states it: file:line:column or file: /pointer; empty where only the file is known
};

// Sphere, seen by rays only. The object_id of shapes follow those of the objects: spheres, then planes.
struct SphereShape {
    std::string name;
    glm::dvec3 centre{0};
    double radius = 1;  // > 0
    uint32_t material = 0;
    std::string location;  // where the file states it: file:line:column or file: /pointer
};

// Plane, bounded only by the ranges of its own coordinates, inclusive: (x, y) = ((p - point).u, (p - point).v).
struct PlaneShape {
    std::string name;
    glm::dvec3 point{0}, normal{0, 1, 0}, u{1, 0, 0}, v{0, 0, 1};  // the last three orthonormal
    double uMin = -1e300, uMax = 1e300, vMin = -1e300, vMax = 1e300;
    bool twoSided = true;  // false: a ray in the direction of the normal passes
    uint32_t material = 0;
    double square = 0;  // above 0: the side of a board's squares; the first square is at x >= 0, y >= 0
    uint32_t otherMaterial = 0;
    bool mirrored = false;  // the pattern is mirrored at y = 0, as in the notes
    std::string location;   // where the file states it: file:line:column or file: /pointer
};

struct Light {
    bool directional = true;
    glm::dvec3 direction{0, 0, 1};  // toward the light, world space, any length > 0 (directional)
    glm::dvec3 position{0};         // world space (point)
    glm::vec3 intensity{1.0f};      // linear RGB, >= 0
    Attenuation attenuation = Attenuation::none;
    std::string location;  // where the file states it; empty: a light made for a scene without lights
};

// Pinhole camera. right, up, forward are orthonormal; in a right-handed world right x up = -forward, in a left-handed one +forward. Screen:
// x to the right, y down. Focal length in pixels = height / 2 / tan(fovY / 2), or focalPixels.
struct Camera {
    glm::dvec3 eye{0}, right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};
    double fovYDegrees = 45;
    double focalPixels = 0;    // > 0: the notes' viewer at distance d from the screen; overrides fovY
    double near = 0;           // 0: largest power of two not above 2^-10 of `focusDistance`
    double focusDistance = 1;  // distance from the eye to the framed centre
};

struct Scene {
    std::string path;    // path of the file as it was given
    std::string sha256;  // SHA-256 of a scene file's bytes; empty for bare meshes
    std::vector<TriangleMesh> meshes;
    std::vector<Material> materials;  // at least one
    std::vector<Object> objects;      // object_id = index here
    std::vector<SphereShape> spheres;
    std::vector<PlaneShape> planes;
    uint32_t maxDepth = 5;             // longest chain of rays (--shading ray)
    double minWeight = 0;              // least weight of a ray that is followed
    bool shadows = true;               // shadow rays are sent to the lights
    std::optional<Sampling> sampling;  // as the file states it; the command line overrides this and the next two
    std::optional<double> jitterReflect, jitterRefract, jitterShadow;  // noise, 0 to 1/2
    std::optional<uint32_t> seed;
    std::optional<bool> cutLevels;  // whole levels; the file states the linear encoding besides
    std::vector<Light> lights;
    glm::vec3 ambient{1.0f};       // Ia, linear RGB
    std::optional<Camera> camera;  // none: completeScene() frames the scene
    bool leftHanded = false;
    glm::dvec3 up{0, 1, 0};
    std::optional<glm::vec3> background;  // linear RGB
    std::optional<Shading> shading;       // as the file states it; the command line overrides
    std::optional<Fill> fill;
    std::optional<Encoding> encoding;
    std::optional<WireView> wire;        // lines that a wire frame shows
    std::optional<bool> wirePerPolygon;  // each edge once for each polygon that has it
    std::optional<bool> distantViewer;   // the viewer counts as infinitely far away when a point is lit (section 3 of the notes)
    bool cullBackFaces = true;
    // Where the file states fill, viewer and z_buffer, for refusals; empty: it does not.
    std::string fillLocation, viewerLocation, zBufferLocation;
    bool zBuffer = true;               // false: --fill notes paints polygon over polygon, as in the notes before section 14
    bool wholeSphereHeights = false;   // --fill notes rounds z of spheres to whole numbers, as the notes' program does
    glm::uvec2 size{0};                // 0: not stated
    std::vector<std::string> ignored;  // features of the file that are not drawn (JSON scene.ignored)
    std::vector<std::string> warnings;
};

// Matrix from the coordinates that the object's mesh keeps to the world. Every use of positions, bounds or centres of faces goes through
// it. Its linear part, for normals and mirrors, is that of worldFromObject.
inline glm::dmat4 worldFromMesh(const Scene& scene, const Object& object) {
    const glm::dvec3& origin = scene.meshes[object.mesh].origin;
    glm::dmat4 m = object.worldFromObject;
    if (origin != glm::dvec3(0)) m[3] += m[0] * origin.x + m[1] * origin.y + m[2] * origin.z;
    return m;
}

}  // namespace plumb
