// SPDX-License-Identifier: MIT
// plumb diff: two pictures against each other. A difference is a verdict (exit 1), not a failure.
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/compare/compare.h"
#include "pipeline/compare/draw.h"
#include "pipeline/compare/gate.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

std::string pixelText(const Pixel& p) { return fmt::format("({}, {})", p.x, p.y); }
Json pixelJson(const Pixel& p) { return {p.x, p.y}; }

// Number in JSON, which has no infinity and no NaN: they are the strings "inf", "-inf", "nan".
Json numberJson(double value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

const char* channelName(const LayerDifference& d, uint32_t channel) {
    static constexpr const char* kNames[] = {"red", "green", "blue", "alpha"};
    const uint32_t channels = std::max(d.a.channels, d.b.channels);
    if (!d.a.colour || channels > 4) return "";
    if (channels <= 2) return channel == 0 ? "grey" : "alpha";
    return kNames[channel];
}

// Error in words, in steps of 255 too, because 0.0078 of full scale is hard to read in bytes.
std::string levelsText(const LayerDifference& d, double error) {
    return d.a.kind == LayerKind::code ? fmt::format("{:.6g} ({:.6g}/255)", error, error * 255) : fmt::format("{:.9g}", error);
}

std::string nanText(const LayerDifference& d, const std::string& nameA, const std::string& nameB) {
    const auto side = [&](const NotANumber& nan, const std::string& name) {
        return nan.pixels == 0 ? std::string()
                               : fmt::format("    NaN         {} pixels of {}, the first at {}\n", nan.pixels, name, pixelText(nan.first));
    };
    return side(d.nanA, nameA) + side(d.nanB, nameB);
}

std::string textOf(const LayerDifference& d, const std::string& nameA, const std::string& nameB, double pixelsPerDegree) {
    const std::string forms[] = {describe(d.a), describe(d.b)};
    std::string text = fmt::format("  {} ({})\n", d.name, forms[0] == forms[1] ? forms[0] : forms[0] + " against " + forms[1]);
    text += nanText(d, nameA, nameB);
    text += fmt::format("    differing   {} of {} pixels", d.differing, d.pixels);
    if (d.differing != 0)
        text += fmt::format(" ({:.3g} %), the first at {}; largest connected region {} pixels in {} to {}",
                            100.0 * double(d.differing) / double(d.pixels), pixelText(*d.firstDiffering), d.region.pixels,
                            pixelText(d.region.least), pixelText(d.region.most));
    text += "\n";
    if (d.a.kind == LayerKind::id) return text;
    if (!d.max) return text + "    no norm     every pixel has a NaN\n";
    text += fmt::format("    max         {}", levelsText(d, *d.max));
    if (*d.max > 0) {
        const std::string channel = channelName(d, d.maxChannel);
        text += fmt::format(" at {}, {}: {:.9g} against {:.9g}", pixelText(d.maxAt),
                            channel.empty() ? fmt::format("channel {}", d.maxChannel) : channel, d.valueA, d.valueB);
    }
    text += fmt::format("\n    mean        {}\n    rmse        {}\n", levelsText(d, *d.mean), levelsText(d, *d.rmse));
    if (d.ulp)
        text += fmt::format("    ulp         {:.0f} (float{}){}\n", *d.ulp, d.ulpPrecision, *d.ulp > 0 ? " at " + pixelText(d.ulpAt) : "");
    if (d.a.colour) {
        text += fmt::format("    psnr        {:.6f} dB\n", *d.psnr);
        for (size_t k = 0; k < kLevels.size(); ++k)
            text += fmt::format("{}{} over {}/255", k == 0 ? "    levels      " : ", ", d.over[k], kLevels[k]);
        text += "\n";
    }
    if (d.ssim) text += fmt::format("    ssim        {:.6f}, lowest {:.6f} at {}\n", d.ssim->mean, d.ssim->worst, pixelText(d.ssim->at));
    if (d.flip)
        text += fmt::format("    flip        {:.6f} at {:.4g} pixels a degree, largest {:.6f} at {}\n", d.flip->mean, pixelsPerDegree,
                            d.flip->worst, pixelText(d.flip->at));
    if (d.deltaE)
        text += fmt::format("    deltae      {:.6f} (CIEDE2000), largest {:.6f} at {}\n", d.deltaE->mean, d.deltaE->worst,
                            pixelText(d.deltaE->at));
    return text;
}

Json perceivedJson(const Perceived& p, const char* worst) { return {{"mean", p.mean}, {worst, p.worst}, {"at", pixelJson(p.at)}}; }

Json layerJson(const LayerDifference& d, double pixelsPerDegree) {
    static constexpr const char* kKinds[] = {"code", "real", "id"};
    Json json;
    json["name"] = d.name;
    json["kind"] = kKinds[size_t(d.a.kind)];
    json["a"] = describe(d.a);
    json["b"] = describe(d.b);
    json["pixels"] = d.pixels;
    for (const auto& [key, nan] : {std::pair{"nan_a", &d.nanA}, {"nan_b", &d.nanB}}) {
        json[key] = {{"pixels", nan->pixels}};
        if (nan->pixels != 0) json[key]["first"] = pixelJson(nan->first);
    }
    json["differing"] = d.differing;
    if (d.firstDiffering) {
        json["first_differing"] = pixelJson(*d.firstDiffering);
        json["region"] = {{"pixels", d.region.pixels}, {"least", pixelJson(d.region.least)}, {"most", pixelJson(d.region.most)}};
    }
    if (d.max) {
        json["max"] = numberJson(*d.max);
        if (*d.max > 0)
            json["max_at"] = {
                {"pixel", pixelJson(d.maxAt)}, {"channel", d.maxChannel}, {"a", numberJson(d.valueA)}, {"b", numberJson(d.valueB)}};
        json["mean"] = numberJson(*d.mean);
        json["rmse"] = numberJson(*d.rmse);
    }
    if (d.ulp) json["ulp"] = {{"max", *d.ulp}, {"bits", d.ulpPrecision}, {"at", pixelJson(d.ulpAt)}};
    if (d.psnr) {
        json["psnr"] = numberJson(*d.psnr);
        json["over"] = Json::object();
        for (size_t k = 0; k < kLevels.size(); ++k) json["over"][fmt::format("{}/255", kLevels[k])] = d.over[k];
    }
    if (d.ssim) json["ssim"] = perceivedJson(*d.ssim, "min");
    if (d.flip) {
        json["flip"] = perceivedJson(*d.flip, "max");
        json["flip"]["pixels_per_degree"] = pixelsPerDegree;
    }
    if (d.deltaE) json["deltae"] = perceivedJson(*d.deltaE, "max");
    return json;
}

Json pictureJson(const Picture& p) {
    Json planes = Json::array();
    for (const Layer& layer : p.layers) planes.push_back({{"name", layer.name}, {"type", describe(layer)}});
    return {{"path", p.path}, {"sha256", p.sha256}, {"format", p.format}, {"size", {p.width, p.height}}, {"planes", planes}};
}

std::string valueText(const GateResult& r) {
    return r.gate->share ? fmt::format("{:.6g}%", 100 * r.value) : fmt::format("{:.9g}", r.value);
}

std::string gateText(const GateResult& r) {
    std::string text = fmt::format("gate {}: {} is {} {}", printable(r.gate->text), nameOf(r.gate->metric), valueText(r),
                                   r.held ? "and holds" : "and does NOT hold");
    if (!r.held && r.at) text += fmt::format("; worst at {}", pixelText(*r.at));
    return text + fmt::format(" (plane {})", r.layer);
}

Json gateJson(const GateResult& r) {
    Json json = {{"gate", r.gate->text}, {"plane", r.layer}, {"value", numberJson(r.value)}, {"limit", r.gate->limit}, {"held", r.held}};
    if (r.at) json["at"] = pixelJson(*r.at);
    return json;
}

// Plane to draw when there are many: the first that differs, else the first.
const LayerDifference* shown(const Comparison& c) {
    const auto at = std::find_if(c.layers.begin(), c.layers.end(), [](const LayerDifference& d) { return d.differing != 0 || d.hasNan(); });
    return at != c.layers.end() ? &*at : c.layers.empty() ? nullptr : c.layers.data();
}

// Writes the pictures. All are encoded before any is written, so that a refusal leaves none.
Json writePictures(const Options& options, FileBatch& batch, const Picture& a, const Picture& b, const Comparison& comparison) {
    Json written = Json::array();
    const LayerDifference* layer = shown(comparison);
    if (layer == nullptr || (options.output.empty() && options.heat.empty())) return written;
    WriteOptions write;
    write.noClobber = options.noClobber;
    const std::string software = fmt::format("plumb {} diff", versionText());
    std::vector<std::pair<std::string, std::vector<std::byte>>> files;
    if (!options.output.empty()) {
        const DifferencePicture picture = drawDifference(a, b, *layer);
        files.emplace_back(
            options.output,
            encodePng(picture.frame, write,
                      {{"Software", software}, {"plumb:plane", layer->name}, {"plumb:gain", fmt::format("2^{}", picture.exponent)}}));
        written.push_back({{"path", options.output}, {"shows", "difference"}, {"plane", layer->name}, {"gain_exponent", picture.exponent}});
    }
    if (!options.heat.empty()) {
        const HeatPicture picture = drawHeat(*layer, a.width, a.height);
        const char* what = picture.flip ? "flip" : "error";
        files.emplace_back(options.heat, encodePng(picture.frame, write,
                                                   {{"Software", software},
                                                    {"plumb:plane", layer->name},
                                                    {"plumb:heat", fmt::format("{}, 0 to {:.9g}", what, picture.brightest)}}));
        written.push_back({{"path", options.heat}, {"shows", what}, {"plane", layer->name}, {"brightest", picture.brightest}});
    }
    for (const auto& [path, bytes] : files) batch.add(path, bytes, options.noClobber);
    return written;
}

}  // namespace

Exit diffCommand(const Options& options) {
    std::vector<Gate> gates;
    for (const std::string& text : options.gates) gates.push_back(parseGate(text));
    for (const std::string& path : {options.output, options.heat})
        if (!path.empty()) checkWritable(path, options.noClobber);
    if (!options.heat.empty() && options.heat == options.output) throw usageError("--output and --heat name the same file");

    const Picture a = readPicture(options.inputs[0]);
    stopIfInterrupted();
    const Picture b = readPicture(options.inputs[1]);
    CompareOptions how;
    how.radius = options.radius;
    how.pixelsPerDegree = options.pixelsPerDegree > 0 ? options.pixelsPerDegree : kDefaultPixelsPerDegree;
    how.layers = options.planes;
    how.threads = options.threads;
    how.onStep = stopIfInterrupted;
    const Comparison comparison = compare(a, b, how);
    stopIfInterrupted();
    const std::vector<GateResult> results = judge(gates, comparison);

    // Faults. Without a gate everything must be equal. With gates: they hold, sizes and planes agree, and a gate covers every NaN.
    std::vector<std::string> faults;
    if (!comparison.sameSize) faults.push_back(fmt::format("the sizes differ: {}", comparison.sizeDifference));
    for (const auto& [names, path] : {std::pair{&comparison.onlyA, &b.path}, {&comparison.onlyB, &a.path}})
        for (const std::string& name : *names) faults.push_back(fmt::format("{} has no plane '{}'", printable(*path), name));
    for (const LayerDifference& d : comparison.layers) {
        if (d.hasNan() && !nanIsJudged(gates, d.name)) {
            const NotANumber& nan = d.nanA.pixels != 0 ? d.nanA : d.nanB;
            faults.push_back(
                fmt::format("NaN at {} of plane {} of {}", pixelText(nan.first), d.name, printable(d.nanA.pixels != 0 ? a.path : b.path)));
        }
        if (gates.empty() && d.differing != 0)
            faults.push_back(d.max && *d.max > 0 ? fmt::format("plane {} differs in {} pixels, by at most {} at {}", d.name, d.differing,
                                                               levelsText(d, *d.max), pixelText(d.maxAt))
                                                 : fmt::format("plane {} differs in {} pixels, the first at {}", d.name, d.differing,
                                                               pixelText(*d.firstDiffering)));
    }
    for (const GateResult& r : results)
        if (!r.held) faults.push_back(gateText(r));

    FileBatch batch;
    const Json written = comparison.sameSize ? writePictures(options, batch, a, b, comparison) : Json::array();
    const std::string nameA = printable(a.path), nameB = printable(b.path);
    std::string text = fmt::format("{} against {}: {}\n", nameA, nameB, comparison.equal() ? "equal" : "DIFFERS");
    for (const LayerDifference& d : comparison.layers) text += textOf(d, nameA, nameB, how.pixelsPerDegree);
    for (const GateResult& r : results) text += gateText(r) + "\n";
    for (const Json& w : written)
        text += fmt::format("wrote {} ({} of plane {}{})\n", printable(w["path"].get<std::string>()), w["shows"].get<std::string>(),
                            w["plane"].get<std::string>(),
                            w.contains("gain_exponent") ? fmt::format(", times 2^{}", w["gain_exponent"].get<int>()) : "");
    // True when standard output is free: neither the picture of -o - nor --json takes it.
    const bool printed = options.output != "-" && !(options.json && options.jsonFile.empty());

    Json json;
    json["tool"] = toolJson();
    json["a"] = pictureJson(a);
    json["b"] = pictureJson(b);
    json["options"] = {{"radius", how.radius}, {"pixels_per_degree", how.pixelsPerDegree}, {"planes", options.planes}};
    json["equal"] = comparison.equal();
    json["same_size"] = comparison.sameSize;
    json["only_a"] = comparison.onlyA;
    json["only_b"] = comparison.onlyB;
    json["planes"] = Json::array();
    for (const LayerDifference& d : comparison.layers) json["planes"].push_back(layerJson(d, how.pixelsPerDegree));
    json["gates"] = Json::array();
    for (const GateResult& r : results) json["gates"].push_back(gateJson(r));
    json["faults"] = faults;
    json["written"] = written;
    finish(options, batch, printed ? text : "", {json});
    if (!printed && options.verbose != 0) say(options, text.substr(0, text.size() - 1));
    for (const std::string& fault : faults) say(options, fmt::format("plumb: {}", fault));
    return faults.empty() ? Exit::done : Exit::overGate;
}

}  // namespace plumb
