// SPDX-License-Identifier: MIT
// The scenes of pipeline/suite/scenes.h as rows for parameterised tests, and committed scenes from their files.
#pragma once

#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"
#include "pipeline/suite/scenes.h"

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <ostream>
#include <string>
#include <vector>

namespace plumb::test {

using suite::addObject;
using suite::Corners;
using suite::degenerate;
using suite::equalDepths;
using suite::huge;
using suite::inside;
using suite::kFocal;
using suite::kNear;
using suite::kSubpixel;
using suite::litScene;
using suite::Random;
using suite::sceneOf;
using suite::sheet;
using suite::sheetOf24;
using suite::signPatterns;
using suite::soup;
using suite::soupLarge;
using suite::soupOf;
using suite::soupOne;
using suite::soupSmall;
using suite::throughCentres;
using suite::View;

// A committed scene or mesh, as the command would draw it at this size.
inline Scene committed(const std::filesystem::path& path, glm::uvec2 size) {
    Scene s = loadScene({path}, {});
    completeScene(s, size, "", isBareMesh(path));
    return s;
}

// One row: a scene at a size. The sizes break tiles (16 x 8), blocks of 4 and words of 32.
struct SceneCase {
    const char* name;
    Scene (*build)(View);
    uint32_t width, height;
    View view() const { return {width, height}; }
    Scene scene() const { return build(view()); }
};
inline std::ostream& operator<<(std::ostream& out, const SceneCase& c) { return out << c.name << ' ' << c.width << 'x' << c.height; }

inline const std::vector<SceneCase>& sceneCases() {
    static const std::vector<SceneCase> kRows = {
        {"soupOne", soupOne, 1, 1},
        {"soupOne", soupOne, 19, 1},
        {"soupOne", soupOne, 1, 19},
        {"soupSmall", soupSmall, 131, 67},
        {"soupLarge", soupLarge, 333, 211},
        {"throughCentres", throughCentres, 131, 67},
        {"throughCentres", throughCentres, 64, 64},
        {"equalDepths", equalDepths, 131, 67},
        {"degenerate", degenerate, 131, 67},
        {"huge", huge, 131, 67},
        {"huge", huge, 333, 211},
        {"signPatterns", signPatterns, 131, 67},
        {"inside", inside, 131, 67},
        {"inside", inside, 17, 9},
        {"sheet", sheetOf24, 131, 67},
        {"sheet", sheetOf24, 333, 211},
    };
    return kRows;
}
inline std::string nameOf(const SceneCase& c) {
    return std::string(c.name) + "_" + std::to_string(c.width) + "x" + std::to_string(c.height);
}

}  // namespace plumb::test
