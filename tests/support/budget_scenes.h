// SPDX-License-Identifier: MIT
// What the planner is held against: random small scenes, every combination of the choices that it has, and budgets of every tightness.
#pragma once

#include "pipeline/planner/ball.h"
#include "pipeline/planner/check.h"
#include "pipeline/render/render.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/scenes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb::test {

// Every combination of the words of the tables, without those that change nothing of what a planner may change: bytes of the device's own,
// and choices that cost as much and are less accurate.
inline std::vector<RenderRequest> everyCombination(const RenderRequest& base) {
    std::vector<RenderRequest> all = {base};
    for (const TradeAxis& axis : kTradeAxes) {
        const std::string name = axis.name;
        if (name == "depth" || name == "subpixel" || name == "transform") continue;
        std::vector<RenderRequest> more;
        for (const RenderRequest& r : all)
            for (const TradeChoice& choice : axis.choices) {
                if (choice.verdict != Verdict::bits) continue;
                more.push_back(r);
                choice.choose(more.back().trade);
            }
        all = std::move(more);
    }
    std::vector<RenderRequest> shaded;
    for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong})
        for (RenderRequest r : all) {
            r.shading = shading;
            shaded.push_back(std::move(r));
        }
    return shaded;
}

// The same of rays: every depth with every cutoff, but for trees that nothing ends.
inline std::vector<RenderRequest> everyTree(const RenderRequest& base) {
    std::vector<RenderRequest> all;
    for (const uint32_t depth : {1u, 2u, 3u, 5u, 10u, 20u, 64u})
        for (const float cutoff : {0.0f, 0x1p-16f, 0x1p-12f, 1 / 256.0f, 1 / 100.0f, 1 / 10.0f}) {
            if (depth > 10 && cutoff == 0) continue;
            all.push_back(base);
            all.back().maxDepth = depth;
            all.back().minWeight = cutoff;
        }
    return all;
}

// Balls of few and of many faces, squashed and turned, among triangles with normals of their own.
inline Scene randomScene(Random& random) {
    Scene scene = litScene();
    scene.camera->focalPixels = 0;
    scene.camera->fovYDegrees = random(30, 80);
    scene.cullBackFaces = random.below(2) == 0;
    scene.lights.resize(1 + random.below(3));
    for (Material& m : scene.materials) {
        m.diffuse = glm::vec3(glm::dvec3(random(0.1, 1), random(0.1, 1), random(0.1, 1)));
        m.specular = random.below(3) == 0 ? glm::vec3(0) : glm::vec3(float(random(0.1, 0.8)));
        m.shininess = float(random(1, 80));
    }
    const uint32_t balls = 1 + random.below(3);
    for (uint32_t i = 0; i < balls; ++i) {
        TriangleMesh ball = ballMesh(2 + random.below(12), scene.materials);
        for (uint32_t& material : ball.vertexMaterial) material = i % 3;
        for (uint32_t& material : ball.faceMaterial) material = i % 3;
        const double size = random(0.3, 1.2), angle = random(0, 6);
        glm::dmat4 place(size);
        place[0] = {size * std::cos(angle), 0, -size * std::sin(angle), 0};
        place[2] = {random(0.4, 1) * std::sin(angle), 0, random(0.4, 1) * std::cos(angle), 0};
        place[3] = {random(-1, 1), random(-1, 1), random(-5, -2), 1};
        addObject(scene, std::move(ball), place);
    }
    if (random.below(3) == 0) {
        std::vector<Corners> triangles(4);
        for (Corners& corners : triangles)
            for (glm::vec3& p : corners) p = glm::vec3(glm::dvec3(random(-2, 2), random(-2, 2), random(-7, -3)));
        addObject(scene, soupOf(triangles, 3, random.below(2) ? &random : nullptr));
    }
    return scene;
}

// Balls of mirror and of glass over a board.
inline Scene randomRays(Random& random) {
    Scene scene = rayScene();
    const uint32_t mirror = addRayMaterial(scene, glm::vec3(0.4f), float(random(0.2, 0.8)), 0, 1),
                   glass = addRayMaterial(scene, glm::vec3(0.1f), float(random(0, 0.2)), float(random(0.5, 0.8)), 1.5f);
    for (uint32_t i = 0; i < 4; ++i)
        scene.spheres.push_back(ball({random(-2, 2), random(0, 2), random(-2, 2)}, random(0.3, 0.9), i % 2 ? glass : mirror));
    scene.planes.push_back(floorAt(-0.5, 0, mirror, 1));
    return scene;
}

// Budgets from one that nothing keeps to one that everything keeps, on different metrics.
inline std::vector<ErrorBudget> budgetsOf(std::span<const BudgetFigures> drawn, Random& random) {
    std::vector<ErrorBudget> budgets(6);
    const auto some = [&](double BudgetFigures::*figure) {
        const double value = drawn[random.below(uint32_t(drawn.size()))].*figure;
        return value * random(0.8, 1.3);
    };
    budgets[0].max = std::max(0.5, some(&BudgetFigures::max));
    budgets[1].rms = std::max(0.2887, some(&BudgetFigures::rms));
    budgets[2].p99 = std::max(0.495, some(&BudgetFigures::p99));
    budgets[3].max = std::max(0.5, some(&BudgetFigures::max));
    budgets[3].wrong = some(&BudgetFigures::wrong);
    budgets[4].rms = std::max(0.2887, some(&BudgetFigures::rms));
    budgets[4].p99 = std::max(0.495, some(&BudgetFigures::p99));
    budgets[5].max = random(0.5, 3);
    return budgets;
}

}  // namespace plumb::test
