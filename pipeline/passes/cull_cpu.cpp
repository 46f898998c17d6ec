// SPDX-License-Identifier: MIT
#include "pipeline/passes/cull.h"

#include "pipeline/passes/parallel.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace plumb {

namespace {

glm::ivec2 positionOf(const gpu::ScreenVertex& v) { return {v.x, v.y}; }

// Number of bits in a mask. std::popcount is a call where the processor is not known to have the instruction, and most masks have no bit or
// all.
uint32_t bitsIn(uint32_t mask) {
    if (mask == 0) return 0;
    if (mask == 0xffffffffu) return 32;
    mask -= (mask >> 1) & 0x55555555u;
    mask = (mask & 0x33333333u) + ((mask >> 2) & 0x33333333u);
    return (((mask + (mask >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24;
}

}  // namespace

void cullCpu(const gpu::CullPush& push, std::span<const glm::uvec4> triangles, std::span<const gpu::ScreenVertex> screen,
             std::span<gpu::CullRecord> records, uint32_t threads) {
    parallelBands(records.size(), 256, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t lane = begin; lane < end; ++lane) {
            gpu::CullRecord r{};
            for (uint32_t k = 0; k < gpu::kTrianglesPerLane; ++k) {
                const uint64_t t = lane * gpu::kTrianglesPerLane + k;
                if (t >= push.triangleCount) break;
                const uint32_t bit = 1u << k;
                const gpu::ScreenVertex &a = screen[triangles[t].x], &b = screen[triangles[t].y], &c = screen[triangles[t].z];
                if (a.outcode & b.outcode & c.outcode) {
                    r.outside |= bit;
                    continue;
                }
                if (a.outcode | b.outcode | c.outcode) {
                    r.clip |= bit;
                    continue;
                }
                const glm::ivec2 p0 = positionOf(a), p1 = positionOf(b), p2 = positionOf(c);
                switch (gpu::classify(p0, p1, p2, push.frame, push.cullBackFaces)) {
                    case gpu::kOutside:
                        r.outside |= bit;
                        break;
                    case gpu::kBackFacing:
                        r.backFacing |= bit;
                        break;
                    case gpu::kZeroArea:
                        r.zeroArea |= bit;
                        break;
                    default: {
                        r.drawn |= bit;
                        const glm::ivec2 extent = gpu::highest(p0, p1, p2) - gpu::lowest(p0, p1, p2);
                        const glm::ivec4 box = gpu::tileBox(p0, p1, p2, push.frame);
                        if (gpu::tilesInBox(box) > gpu::kSmallTiles) r.large |= bit;
                        if (!gpu::isNarrow(extent.x, extent.y)) r.wide |= bit;
                        if (((r.large | r.wide) & bit) == 0 && !gpu::inTwoTiles(box)) r.medium |= bit;
                    }
                }
            }
            records[lane] = r;
        }
    });
}

DrawSlots drawSlotsOf(std::span<const gpu::CullRecord> records, const DrawList& list, uint32_t firstClippedVertex) {
    DrawSlots d;
    d.first.resize(records.size());
    uint64_t next = 0;
    size_t range = 0;
    for (size_t lane = 0; lane < records.size(); ++lane) {
        const gpu::CullRecord& r = records[lane];
        d.first[lane] = uint32_t(next);
        d.drawn += bitsIn(r.drawn);
        d.backFacing += bitsIn(r.backFacing);
        d.zeroArea += bitsIn(r.zeroArea);
        d.outside += bitsIn(r.outside);
        d.wide |= r.wide != 0;
        const auto slotOfBit = [&](uint32_t bit) {
            const uint32_t below = (1u << bit) - 1u;
            return uint32_t(next) + bitsIn(r.drawn & below) + gpu::kClipFan * bitsIn(r.clip & below);
        };
        const auto slotted = [&](uint32_t bit) { return SlottedTriangle{slotOfBit(bit), uint32_t(lane * gpu::kTrianglesPerLane + bit)}; };
        for (uint32_t left = r.large | r.wide; left; left &= left - 1) d.large.push_back(slotted(std::countr_zero(left)));
        for (uint32_t left = r.medium; left; left &= left - 1) d.medium.push_back(slotted(std::countr_zero(left)));
        for (uint32_t left = r.clip; left; left &= left - 1) {
            const uint32_t bit = std::countr_zero(left);
            const uint32_t triangle = uint32_t(lane * gpu::kTrianglesPerLane + bit);
            while (list.ranges[range].firstTriangle + list.ranges[range].triangleCount <= triangle) ++range;
            const uint32_t job = uint32_t(d.jobs.size());
            d.jobs.push_back({triangle, list.ranges[range].record, slotOfBit(bit), firstClippedVertex + job * gpu::kClipCorners});
        }
        next += uint64_t(bitsIn(r.drawn)) + uint64_t(gpu::kClipFan) * bitsIn(r.clip);
    }
    if (next > 0x7fffffffu) throw renderError("a chunk has more than 2^31 drawn triangles");
    d.drawCount = uint32_t(next);
    d.clippedVertices = uint32_t(d.jobs.size()) * gpu::kClipCorners;
    return d;
}

void listDrawn(std::span<const gpu::CullRecord> records, std::span<uint32_t> sources) {
    uint32_t* to = sources.data();
    for (size_t lane = 0; lane < records.size(); ++lane) {
        const uint32_t first = uint32_t(lane * gpu::kTrianglesPerLane), clip = records[lane].clip;
        if (records[lane].drawn == 0xffffffffu) {
            std::iota(to, to + gpu::kTrianglesPerLane, first);
            to += gpu::kTrianglesPerLane;
            continue;
        }
        for (uint32_t left = records[lane].drawn | clip; left; left &= left - 1) {
            const uint32_t bit = uint32_t(std::countr_zero(left));
            if ((clip >> bit & 1) == 0)
                *to++ = first + bit;
            else
                to = std::fill_n(to, gpu::kClipFan, gpu::kNoTriangle);
        }
    }
    PLUMB_ASSERT(to == sources.data() + sources.size());
}

void setupCpu(std::span<const gpu::CullRecord> records, const DrawSlots& slots, std::span<const glm::uvec4> triangles,
              std::span<const gpu::ScreenVertex> screen, std::span<gpu::DrawTriangle> draws, uint32_t threads) {
    parallelBands(records.size(), 256, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t lane = begin; lane < end; ++lane) {
            uint32_t slot = slots.first[lane];
            for (uint32_t k = 0; k < gpu::kTrianglesPerLane; ++k) {
                const uint32_t bit = 1u << k;
                if (records[lane].clip & bit) slot += gpu::kClipFan;
                if (!(records[lane].drawn & bit)) continue;
                const uint32_t t = uint32_t(lane * gpu::kTrianglesPerLane + k);
                const glm::uvec4& v = triangles[t];
                draws[slot++] =
                    gpu::drawTriangle(v.x, v.y, v.z, positionOf(screen[v.x]), positionOf(screen[v.y]), positionOf(screen[v.z]), t);
            }
        }
    });
}

void clipCpu(const gpu::ClipPush& push, std::span<const gpu::ClipJob> jobs, std::span<const glm::uvec4> triangles,
             std::span<const glm::vec4> positions, std::span<const gpu::ObjectRecord> objects, std::span<gpu::ScreenVertex> screen,
             std::span<glm::vec4> attributes, std::span<gpu::DrawTriangle> draws, std::span<uint32_t> kinds, uint32_t threads,
             std::span<const glm::vec4> given) {
    parallelBands(jobs.size(), 64, threads, [&](uint64_t begin, uint64_t end) {
        std::vector<gpu::ClipVertex> polygon, next;
        for (uint64_t j = begin; j < end; ++j) {
            const gpu::ClipJob& job = jobs[j];
            const gpu::ObjectRecord& o = objects[job.object];
            polygon.clear();
            for (int i = 0; i < 3; ++i) {
                const uint32_t v = triangles[job.triangle][i];
                const glm::vec3 p(positions[v]);
                polygon.push_back({gpu::rowTimesPoint(o.rowX, p), gpu::rowTimesPoint(o.rowY, p), gpu::rowTimesPoint(o.rowW, p),
                                   glm::vec3(attributes[v])});
                if (!given.empty() && given[v].w != 0) polygon.back() = {given[v].x, given[v].y, given[v].z, polygon.back().attributes};
            }
            for (int plane = 0; plane < gpu::kClipPlanes; ++plane) {
                next.clear();
                for (size_t i = 0; i < polygon.size(); ++i) {
                    const gpu::ClipVertex &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
                    const float da = gpu::planeDistance(plane, a.x, a.y, a.w, push.viewport);
                    const float db = gpu::planeDistance(plane, b.x, b.y, b.w, push.viewport);
                    if (da >= 0) next.push_back(a);
                    if (da >= 0 && db < 0) next.push_back(gpu::intersect(plane, a, b, da, db, push.viewport));
                    if (da < 0 && db >= 0) next.push_back(gpu::intersect(plane, b, a, db, da, push.viewport));
                }
                polygon.swap(next);
            }
            PLUMB_ASSERT(polygon.size() <= gpu::kClipCorners);
            uint32_t kind = 0;
            std::vector<glm::ivec2> position;
            for (size_t i = 0; i < polygon.size(); ++i) {
                screen[job.vertex + i] = gpu::projectClipped(polygon[i], push.viewport);
                attributes[job.vertex + i] = glm::vec4(polygon[i].attributes, 0.0f);
                position.push_back(positionOf(screen[job.vertex + i]));
            }
            for (uint32_t i = 0; i < gpu::kClipFan; ++i) {
                gpu::DrawTriangle d{{job.vertex, job.vertex, job.vertex}, job.triangle};
                if (i + 2 < polygon.size() &&
                    gpu::classify(position[0], position[i + 1], position[i + 2], push.frame, push.cullBackFaces) == gpu::kDrawn) {
                    d = gpu::drawTriangle(job.vertex, job.vertex + i + 1, job.vertex + i + 2, position[0], position[i + 1], position[i + 2],
                                          job.triangle);
                    const glm::ivec2 extent = gpu::highest(position[0], position[i + 1], position[i + 2]) -
                                              gpu::lowest(position[0], position[i + 1], position[i + 2]);
                    kind |= gpu::isNarrow(extent.x, extent.y) ? 0 : 1;
                    kind += 2;
                }
                draws[job.slot + i] = d;
            }
            kinds[j] = kind;
        }
    });
}

}  // namespace plumb
