// SPDX-License-Identifier: MIT
// Which dispatch is at fault, and what its capsule holds. Reading and writing: capsule_file.cpp.
#include "pipeline/suite/capsule.h"

#include "host/error.h"
#include "pipeline/render/evidence.h"
#include "pipeline/scene/sha256.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb::suite {

namespace {

// Passes that one kernel runs with another: the label of their dispatch.
std::string labelOf(const std::string& pass) { return pass == "shade" ? "fill" : pass; }

// What verify says of a picture, its dispatches, and the values that differ.
struct Seen {
    VerifyReport report;
    std::vector<VerifyEvidence> evidence;
    std::vector<DispatchRecord> records;
    std::string failure;
};

Seen witnessed(Device& device, const Reduced& picture) {
    Seen seen;
    witnessDispatches(device, [&](const DispatchRecord& record) { seen.records.push_back(record); });
    struct Forget {
        Device& device;
        ~Forget() { witnessDispatches(device, nullptr); }
    } const forget{device};
    try {
        seen.report = verifyRender(device, picture.scene, picture.request, seen.evidence);
    } catch (const Error& error) {
        if (error.exit() != Exit::failed) throw;
        seen.failure = error.what();
    }
    return seen;
}

// Offset of the values in the bytes, a multiple of 4, or none. None too where they lie there twice.
std::optional<uint64_t> offsetIn(std::span<const std::byte> bytes, std::span<const std::byte> values) {
    std::optional<uint64_t> found;
    for (uint64_t from = 0;;) {
        const void* const at = ::memmem(bytes.data() + from, bytes.size() - from, values.data(), values.size());  // linear, also in zeros
        if (at == nullptr) return found;
        const auto offset = uint64_t(static_cast<const std::byte*>(at) - bytes.data());
        if (offset % 4 == 0) {
            if (found) return {};
            found = offset;
        }
        from = offset + 1;
    }
}

// Where a dispatch left these values, unless they were there before.
std::optional<Location> locationIn(const DispatchRecord& record, const std::vector<std::byte>& values) {
    for (uint32_t b = 0; b < record.bindings.size(); ++b) {
        const DispatchRecord::Bound& bound = record.bindings[b];
        if (bound.after.size() < values.size() || values.empty() || bound.after == bound.before) continue;
        const std::optional<uint64_t> offset = offsetIn(bound.after, values);
        if (offset && !std::equal(values.begin(), values.end(), bound.before.begin() + ptrdiff_t(*offset))) return Location{b, *offset};
    }
    return {};
}

// Dispatch of the first mismatch: the one that left the values, else the last of its pass.
void blame(Capsule& capsule, const Seen& seen) {
    const auto& [report, evidence, records, failure] = seen;
    const auto ofPass = [](const DispatchRecord& record, const std::string& pass) { return record.label == labelOf(pass); };
    for (const bool anyPass : {false, true})
        for (const VerifyEvidence& e : evidence)
            for (const DispatchRecord& record : records) {
                if (!anyPass && !ofPass(record, e.pass)) continue;
                const std::optional<Location> location = locationIn(record, e.device);
                if (!location) continue;
                capsule.dispatch = record;
                capsule.location = location;
                capsule.element = e.element;
                capsule.elementBytes = e.elementBytes;
                capsule.expected = e.twin;
                capsule.got = e.device;
                return;
            }
    const std::string pass = evidence.empty() ? report.mismatches[0].pass : evidence[0].pass;
    const auto last = std::find_if(records.rbegin(), records.rend(), [&](const DispatchRecord& r) { return ofPass(r, pass); });
    capsule.dispatch = last != records.rend() ? *last : records.back();
    if (evidence.empty()) return;
    capsule.element = evidence[0].element;
    capsule.elementBytes = evidence[0].elementBytes;
    capsule.expected = evidence[0].twin;
    capsule.got = evidence[0].device;
}

std::string objOf(const Scene& scene) {
    std::string text = "# The triangles of the reduced scene, in the world's coordinates.\n";
    size_t first = 1;
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        const glm::dmat4 toWorld = worldFromMesh(scene, object);
        for (const glm::vec3& p : mesh.positions) {
            const glm::dvec3 w(toWorld * glm::dvec4(p, 1));
            text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", w.x, w.y, w.z);
        }
        for (const TriangleMesh::Triangle& t : mesh.triangles)
            text += fmt::format("f {} {} {}\n", first + t.vertex[0], first + t.vertex[1], first + t.vertex[2]);
        first += mesh.positions.size();
    }
    return text;
}

Json aboutOf(const Device& device, const Reduced& picture, const Json& tool) {
    const RenderRequest& request = picture.request;
    const Scene& scene = picture.scene;
    return {{"tool", tool},
            {"device",
             {{"name", device.info().name},
              {"driver", device.info().driver},
              {"driverInfo", device.info().driverInfo},
              {"apiVersion", device.info().apiVersion},
              {"uuid", device.info().uuid},
              {"subgroupSize", device.limits().subgroupSize}}},
            {"picture",
             {{"size", {request.width, request.height}},
              {"shading", nameOf(request.shading)},
              {"fill", nameOf(request.fill)},
              {"samples", request.samples},
              {"trade", wordsOf(request.trade)},
              {"objects", scene.objects.size()},
              {"triangles", picture.triangles},
              {"spheres", scene.spheres.size()},
              {"planes", scene.planes.size()},
              {"lights", scene.lights.size()},
              {"trianglesBefore", picture.trianglesBefore},
              {"picturesTried", picture.tried}}}};
}

}  // namespace

std::optional<Capsule> capsuleOf(Device& device, const Reduced& picture, const Json& tool) {
    Capsule capsule;
    const Seen seen = witnessed(device, picture);
    if (seen.failure.empty() && seen.report.mismatches.empty()) return {};
    if (seen.records.empty()) throw renderError("verify --capsule: the sides differ, and the device ran no dispatch");
    if (!seen.failure.empty()) {
        capsule.dispatch = seen.records.back();
        capsule.pass = capsule.dispatch.label;
        capsule.what = seen.failure;
    } else {
        capsule.pass = seen.report.mismatches[0].pass;
        capsule.what = seen.report.mismatches[0].what;
        blame(capsule, seen);
    }
    capsule.about = aboutOf(device, picture, tool);
    capsule.triangles = objOf(picture.scene);
    return capsule;
}

std::vector<std::byte> valuesOf(const Capsule& capsule, const DispatchRecord& run) {
    if (!capsule.location) return {};
    const std::vector<std::byte>& bytes = run.bindings[capsule.location->binding].after;
    const auto first = bytes.begin() + ptrdiff_t(capsule.location->offset);
    return {first, first + ptrdiff_t(capsule.expected.size())};
}

Outcome outcomeOf(const Capsule& capsule, const DispatchRecord& run) {
    const bool ended = run.failure.empty();
    if (ended && !capsule.dispatch.failure.empty()) return Outcome::expected;  // it failed, and ends now
    if (ended && capsule.location && valuesOf(capsule, run) == capsule.expected) return Outcome::expected;
    const bool same = std::equal(run.bindings.begin(), run.bindings.end(), capsule.dispatch.bindings.begin(),
                                 [](const auto& a, const auto& b) { return a.after == b.after; });
    if (same && run.failure == capsule.dispatch.failure) return Outcome::captured;
    return ended ? Outcome::other : Outcome::failed;
}

std::string hashOf(const DispatchRecord& run) {
    std::vector<std::byte> all;
    for (const DispatchRecord::Bound& bound : run.bindings) all.insert(all.end(), bound.after.begin(), bound.after.end());
    const auto failure = std::as_bytes(std::span(run.failure));
    all.insert(all.end(), failure.begin(), failure.end());
    return sha256Hex(all);
}

ValueDifference differenceOf(std::span<const std::byte> a, std::span<const std::byte> b, uint32_t elementBytes) {
    ValueDifference difference;
    if (elementBytes == 0) return difference;
    difference.count = std::min(a.size(), b.size()) / elementBytes;
    for (uint64_t i = 0; i < difference.count; ++i) {
        if (std::memcmp(&a[i * elementBytes], &b[i * elementBytes], elementBytes) == 0) continue;
        if (difference.differing++ == 0) difference.first = i;
    }
    return difference;
}

std::string wordsOf(std::span<const std::byte> values, uint64_t index, uint32_t elementBytes) {
    std::string text;
    for (uint32_t at = 0; at + 4 <= elementBytes; at += 4) {
        uint32_t word;
        std::memcpy(&word, &values[index * elementBytes + at], 4);
        text += fmt::format("{}{:08x}", at ? " " : "", word);
    }
    return text;
}

}  // namespace plumb::suite
