// SPDX-License-Identifier: MIT
// Rule of all readers of model files: what is not drawn never refuses a file. It is counted by kind, and named once with its first location.
// With LoadOptions::strict it is refused there.
#pragma once

#include "pipeline/scene/load.h"
#include "pipeline/scene/mesh.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// Kinds that several formats have.
inline constexpr std::string_view kBadVertex = "a vertex that no face has is not finite; it is passed over";
inline constexpr std::string_view kFewCorners = "a face has fewer than 3 corners; it is not drawn";

class Tolerance {
public:
    explicit Tolerance(const LoadOptions& options) : options_(options) {}

    // Passes over one more of `kind`, a sentence that says what was met and what becomes of it. `placeOf` is called for the first only.
    template <class PlaceOf>
    void pass(std::string_view kind, PlaceOf placeOf) {
        if (!passAgain(kind)) passFirst(kind, std::string(), placeOf());
    }
    // As above; `detailOf` says what the first one is, and stands in front of the sentence.
    template <class PlaceOf, class DetailOf>
    void pass(std::string_view kind, PlaceOf placeOf, DetailOf detailOf) {
        if (!passAgain(kind)) passFirst(kind, detailOf(), placeOf());
    }

    void addTo(std::vector<std::string>& warnings) const;  // one warning a kind, in the order in which they were met

private:
    bool passAgain(std::string_view kind);
    void passFirst(std::string_view kind, std::string detail, std::string location);

    struct Passed {
        std::string kind, detail, location;
        uint64_t count = 1;
    };
    const LoadOptions& options_;
    std::vector<Passed> passed_;
};

// True for each position that a face has; for all of them where the mesh has no face.
std::vector<bool> drawnPositions(const PolygonMesh& mesh);
// Takes normals that are NaN from the corners that name them. Readers put NaN where a file's normal counts as not stated.
void dropBadNormals(PolygonMesh& mesh);

}  // namespace plumb
