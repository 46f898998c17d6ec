// SPDX-License-Identifier: MIT
#include "pipeline/detail/projected_scale.h"

#include "pipeline/scene/shape.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>

namespace plumb::detail {

double largestStretch(const glm::dmat3& m) {
    // Eigenvalues of the symmetric m^T m by Jacobi's rotations. Gershgorin's discs bound the largest whatever is left beside the diagonal.
    glm::dmat3 a = glm::transpose(m) * m;
    constexpr int kSweeps = 8;  // convergence is quadratic: the third leaves rounding alone
    for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
                const double c = 1 / std::hypot(t, 1.0), s = t * c;
                glm::dmat3 turn(1);
                turn[p][p] = turn[q][q] = c;
                turn[q][p] = s;
                turn[p][q] = -s;
                a = glm::transpose(turn) * a * turn;
            }
    double largest = 0;
    for (int i = 0; i < 3; ++i) largest = std::max(largest, std::abs(a[i][0]) + std::abs(a[i][1]) + std::abs(a[i][2]));
    // Products of three matrices round a few dozen times a sweep.
    constexpr double kRounding = 1 + 0x1p-40;
    return std::sqrt(largest) * kRounding;
}

Allowed allowedDeviation(const Scene& scene, uint32_t object, std::span<const Camera> cameras, glm::uvec2 size, double pixels) {
    const Object& o = scene.objects[object];
    const TriangleMesh& mesh = scene.meshes[o.mesh];
    const glm::dmat4 world = worldFromMesh(scene, o);
    const double stretch = largestStretch(glm::dmat3(world));
    Allowed least;
    if (!(stretch > 0)) return {0, 0, "its matrix leaves nothing of it"};
    least.deviation = std::numeric_limits<double>::infinity();
    for (const Camera& camera : cameras) {
        const double focal = camera.focalPixels > 0 ? camera.focalPixels : size.y / 2.0 / std::tan(glm::radians(camera.fovYDegrees) / 2);
        const double near = camera.near > 0 ? camera.near : std::ldexp(1.0, std::ilogb(camera.focusDistance) - 10);
        double nearest = std::numeric_limits<double>::infinity();
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec4 p(corner & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, corner & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                               corner & 4 ? mesh.boundsMax.z : mesh.boundsMin.z, 1);
            nearest = std::min(nearest, glm::dot(camera.forward, glm::dvec3(world * p) - camera.eye));
        }
        if (mesh.shape) nearest -= stretch * deviationOf(*mesh.shape);  // the surface stands out of its polygons
        if (!(nearest > near)) return {0, 0, "it reaches the near plane"};
        const double corner = std::hypot(size.x / 2.0 + pixels, size.y / 2.0 + pixels) / focal;
        const double factor = focal * std::hypot(1.0, corner);
        // Not past the near plane either, where a point would be cut away.
        const double moved = std::min(pixels * nearest / (factor + pixels), nearest - near);
        if (moved / stretch < least.deviation) least = {moved / stretch, pixels * stretch / moved, ""};
    }
    return least;
}

}  // namespace plumb::detail
