// SPDX-License-Identifier: MIT
// A mesh with fewer triangles, by meshoptimizer, within a deviation that is proved afterwards.
#pragma once

#include "pipeline/scene/mesh.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace plumb::detail {

// Mesh whose surface is within `deviation` of `mesh`'s, and the other way round (deviation.h), in units of the mesh. Vertices are some of the mesh's
// own with their normals and materials, so creases and borders between materials stay. Each triangle is a face of its own. None: no triangle can be
// taken away. `alive`: called now and then, may throw.
std::optional<TriangleMesh> simplified(const TriangleMesh& mesh, double deviation, uint32_t threads, const std::function<void()>& alive);

// "meshoptimizer 0.18": other versions take other triangles away.
std::string simplifierName();

}  // namespace plumb::detail
