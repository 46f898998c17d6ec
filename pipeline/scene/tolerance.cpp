// SPDX-License-Identifier: MIT
#include "pipeline/scene/tolerance.h"

#include "host/error.h"

#include <fmt/core.h>
#include <cmath>
#include <glm/glm.hpp>
#include <utility>

namespace plumb {

bool Tolerance::passAgain(std::string_view kind) {
    for (Passed& passed : passed_)
        if (passed.kind == kind) {
            ++passed.count;
            return true;
        }
    return false;
}

void Tolerance::passFirst(std::string_view kind, std::string detail, std::string location) {
    if (options_.strict) throw inputError(location, fmt::format("{}{} (--strict)", detail, kind));
    passed_.push_back({std::string(kind), std::move(detail), std::move(location)});
}

void Tolerance::addTo(std::vector<std::string>& warnings) const {
    for (const auto& [kind, detail, location, count] : passed_)
        warnings.push_back(fmt::format("{}: {}{}{}", location, detail, kind, count == 1 ? "" : fmt::format(" ({} times)", count)));
}

std::vector<bool> drawnPositions(const PolygonMesh& mesh) {
    std::vector<bool> drawn(mesh.positions.size(), mesh.faceMaterial.empty());
    for (const PolygonMesh::Corner& corner : mesh.corners)
        if (corner.position < drawn.size()) drawn[corner.position] = true;
    return drawn;
}

void dropBadNormals(PolygonMesh& mesh) {
    for (PolygonMesh::Corner& corner : mesh.corners)
        if (corner.normal != kNone && std::isnan(mesh.normals[corner.normal].x)) corner.normal = kNone;
    for (glm::vec3& normal : mesh.normals)
        if (std::isnan(normal.x)) normal = glm::vec3(0);
}

}  // namespace plumb
