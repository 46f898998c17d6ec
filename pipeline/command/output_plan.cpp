// SPDX-License-Identifier: MIT
#include "pipeline/command/output_plan.h"

#include "pipeline/image/image.h"
#include "pipeline/scene/extension.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace plumb {
namespace {

std::string extensionOf(const std::string& path) { return path == "-" ? ".png" : lowerExtension(path); }

void checkContents(const OutputFile& file, const Options& options) {
    const std::string extension = extensionOf(file.path);
    const bool colourOnly = file.aovs.size() == 1 && file.aovs[0] == kPlaneColour;
    if (file.inks && extension != ".png")
        throw usageError(fmt::format("--separations: '{}' is refused; inks are grey PNGs", printable(file.path)));
    if (extension == ".png") {
        if (!colourOnly) throw usageError(fmt::format("--aov: '{}' is a PNG and holds color only; use .exr or .npy", printable(file.path)));
    } else if (extension == ".npy") {
        if (file.aovs.size() != 1)
            throw usageError(fmt::format("--aov: '{}' holds one plane; use '{{aov}}' in -o, or .exr", printable(file.path)));
    } else if (extension != ".exr") {
        throw usageError(
            fmt::format("--output: '{}' is refused; accepted: a path that ends in .png, .exr or .npy, or -", printable(file.path)));
    }
    if (options.bits != 8 && extension != ".png") throw usageError("--bits is for .png; .exr and .npy hold float32 and uint32");
}

// A placeholder that is there exactly when the flag is that makes several pictures of one.
void checkPlaceholder(const std::string& pattern, const char* name, const char* flag, bool needed, const char* example) {
    if (needed && !hasPlaceholder(pattern, name))
        throw usageError(fmt::format("{} makes several pictures: -o needs '{{{}}}', e.g. {}", flag, name, example));
    if (!needed && hasPlaceholder(pattern, name)) throw usageError(fmt::format("--output: '{{{}}}' goes with {}", name, flag));
}

void checkCombinations(const Options& options, const std::vector<Plane>& aovs) {
    const bool stereo = options.stereo != StereoForm::none;
    checkPlaceholder(options.output, "eye", "--stereo pair", options.stereo == StereoForm::pair, "scene_{eye}.png");
    checkPlaceholder(options.output, "field", "--interlace", options.interlace, "scene_{field}.png");
    checkPlaceholder(options.output, "ink", "--separations", !options.separations.empty(), "scene_{ink}.png");
    if (options.eyeSeparation && !stereo) throw usageError("--eye-separation goes with --stereo");
    if (stereo && options.stereo != StereoForm::pair)
        for (const Plane aov : aovs)
            if (aov != kPlaneColour && aov != kPlaneLinear)
                throw usageError(fmt::format("--stereo {}: one picture of two eyes has no {} plane; use --stereo pair",
                                             nameOf(options.stereo), nameOf(aov)));
    const bool transparent = options.background && options.background->transparent;
    if (options.stereo == StereoForm::anaglyph && transparent)
        throw usageError("--stereo anaglyph: a pixel has one alpha and two eyes; state a --background");
    if (options.separations.empty()) return;
    if (transparent) throw usageError("--separations: what is transparent has no ink; state a --background");
    if (options.bits != 8) throw usageError("--separations: inks have 8 bits");
}

}  // namespace

OutputPlan outputPlanOf(const Options& options, const std::vector<Viewpoint>& views, glm::uvec2 size) {
    OutputPlan plan;
    const std::string& pattern = options.output;
    const std::vector<Plane> aovs = options.aovs.empty() ? std::vector<Plane>{kPlaneColour} : options.aovs;
    checkCombinations(options, aovs);
    for (const Viewpoint& view : views) Stereo(options, view.camera, size);
    if (options.interlace && size.y < 2) throw usageError("--interlace: a picture of one line has no even lines");
    const bool numbered = hasPlaceholder(pattern, "n"), named = hasPlaceholder(pattern, "view");
    if (options.turntable > 1 && !numbered)
        throw usageError(fmt::format("--turntable makes {} pictures: -o needs '{{n}}', e.g. spin_{{n}}.png", options.turntable));
    plan.sheet = options.turntable == 0 && views.size() > 1 && !numbered && !named;
    if (plan.sheet && extensionOf(pattern) != ".png")
        throw usageError("several --view make a contact sheet, which is a .png; use '{view}' or '{n}' in -o");
    if (plan.sheet && options.stereo == StereoForm::pair)
        throw usageError("--stereo pair with several --view: use '{view}' or '{n}' in -o");

    for (const Plane aov : aovs) plan.planes |= aov;
    // One file for each of these, of each view and each plane; one "none" where the flag is not given.
    using std::nullopt;
    const std::vector<std::optional<Eye>> eyes = options.stereo == StereoForm::pair ? std::vector<std::optional<Eye>>{Eye::left, Eye::right}
                                                                                    : std::vector<std::optional<Eye>>{nullopt};
    const std::vector<std::optional<Field>> fields =
        options.interlace ? std::vector<std::optional<Field>>{Field::odd, Field::even} : std::vector<std::optional<Field>>{nullopt};
    std::optional<Inks> inks;
    if (!options.separations.empty()) inks = options.separations == "cmy" ? Inks::cmy : Inks::cmyk;
    const size_t inkCount = inks ? namesOf(*inks).size() : 1;
    const bool byAov = hasPlaceholder(pattern, "aov");

    const auto count = uint32_t(plan.sheet ? 1 : views.size());
    const auto digits = uint32_t(std::to_string(count - 1).size());
    std::set<std::string> paths;
    for (uint32_t i = 0; i < count; ++i) {
        std::vector<OutputFile>& files = plan.files.emplace_back();
        for (const auto& eye : eyes)
            for (const auto& field : fields)
                for (size_t ink = 0; ink < inkCount; ++ink)
                    for (size_t a = 0; a < (byAov ? aovs.size() : 1); ++a) {
                        PlaceholderValues values{i, digits, views[i].name, byAov ? nameOf(aovs[a]) : "", "", "", ""};
                        if (eye) values.eye = nameOf(*eye);
                        if (field) values.field = *field == Field::odd ? "odd" : "even";
                        if (inks) values.ink = namesOf(*inks)[ink];
                        files.push_back({filledIn(pattern, values), byAov ? std::vector<Plane>{aovs[a]} : aovs, eye, field, inks, ink});
                    }
        for (const OutputFile& file : files) {
            checkContents(file, options);
            checkWritable(file.path, options.noClobber);
            if (!paths.insert(file.path).second)
                throw usageError(fmt::format("--output: two pictures would be written to '{}'", printable(file.path)));
            if (extensionOf(file.path) == ".exr" && (plan.planes & kPlaneColour) != 0) plan.planes |= kPlaneLinear;
        }
    }
    if (options.bits == 16) plan.planes |= kPlaneLinear;
    plan.transparent = options.background && options.background->transparent;
    if (!options.jsonFile.empty()) {
        if (paths.count(options.jsonFile) != 0) throw usageError("--json and -o name the same file");
        checkWritable(options.jsonFile, options.noClobber);
    }
    return plan;
}

}  // namespace plumb
