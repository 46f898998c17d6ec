// SPDX-License-Identifier: MIT
#include "pipeline/cli/options.h"

#include "host/error.h"
#include "pipeline/scene/extension.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <string_view>
#include <utility>

namespace plumb {
namespace {

// A value that a flag does not accept; the parser knows the flag and what it accepts.
struct Refused {};

constexpr uint32_t kDraw = kRender | kVerify | kMeasure | kPlan | kPixel | kStress;
constexpr uint32_t kReads = kRender | kVerify | kInfo | kMatrix | kBench | kMeasure | kPlan | kPixel | kStress;
constexpr uint32_t kReports =
    kRender | kVerify | kReplay | kDevices | kInfo | kMatrix | kDiff | kBench | kMeasure | kPlan | kPixel | kStress;
constexpr uint32_t kUsesDevice = kRender | kVerify | kReplay | kDevices | kBench | kMeasure | kPlan | kPixel | kStress;
constexpr uint32_t kLargestSide = 65536;

// All of `text`, without a locale; NaN, infinity and out of range are refused.
template <class T>
T number(std::string_view text, T least, T most) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || text.empty()) throw Refused{};
    if (!(value >= least && value <= most)) throw Refused{};
    return value;
}
double real(std::string_view text, double least = -1e30, double most = 1e30) { return number<double>(text, least, most); }

std::vector<std::string_view> split(std::string_view text, char by) {
    std::vector<std::string_view> parts;
    for (;;) {
        const size_t at = text.find(by);
        parts.push_back(text.substr(0, at));
        if (at == text.npos) return parts;
        text.remove_prefix(at + 1);
    }
}

template <class T>
T oneOf(const std::string& text, std::initializer_list<std::pair<const char*, T>> rows) {
    for (const auto& [word, value] : rows)
        if (text == word) return value;
    throw Refused{};
}

// The value of a word of a table of choices.
template <class Rows>
auto valueOf(const Rows& rows, std::string_view word) -> decltype(rows[0].value) {
    const auto* row = choiceOfWord(rows, word);
    if (row == nullptr) throw Refused{};
    return row->value;
}

// "wire, unlit, object_id (or id)".
template <class Rows>
std::string listOf(const Rows& rows) {
    std::vector<std::string> words;
    for (const auto& row : rows) words.push_back(row.alias[0] == '\0' ? row.word : fmt::format("{} (or {})", row.word, row.alias));
    return fmt::format("{}", fmt::join(words, ", "));
}

// "wire (edges only), unlit (the material's own colour)".
template <class Rows>
std::string meaningsOf(const Rows& rows) {
    std::vector<std::string> words;
    for (const auto& row : rows) words.push_back(fmt::format("{} ({})", row.word, helpOf(row)));
    return fmt::format("{}", fmt::join(words, ", "));
}

std::vector<std::string> copied(const std::vector<const char*>& words) { return {words.begin(), words.end()}; }

// A flag whose values are the words of a table of choices.
template <auto member, const auto& rows>
Flag choiceFlag(const char* names, const char* argument, const char* help, const char* fallback) {
    const auto set = [](Options& o, const std::string& word) { o.*member = valueOf(rows, word); };
    return {names, argument, help, fallback, listOf(rows), copied(wordsIn(rows)), kDraw, set, false, false, meaningsOf(rows)};
}

glm::dvec3 vector(const std::string& text) {
    const auto parts = split(text, ',');
    if (parts.size() != 3) throw Refused{};
    return {real(parts[0]), real(parts[1]), real(parts[2])};
}

void addPoint(Options& o, const std::string& text) {
    const auto parts = split(text, ',');
    if (parts.size() != 2 && parts.size() != 3) throw Refused{};
    o.points.emplace_back(real(parts[0]), real(parts[1]), parts.size() == 3 ? real(parts[2]) : 0);
    o.planePoints |= parts.size() == 2;
    o.spacePoints |= parts.size() == 3;
}

void setRay(Options& o, const std::string& text) {
    const auto parts = split(text, ',');
    if (parts.size() != 6) throw Refused{};
    std::array<glm::dvec3, 2> ray;
    for (int i = 0; i < 6; ++i) ray[size_t(i) / 3][i % 3] = real(parts[size_t(i)]);
    if (ray[0] == ray[1]) throw Refused{};
    o.ray = ray;
}

void setSize(Options& o, const std::string& text) {
    const auto parts = split(text, 'x');
    if (parts.size() != 2) throw Refused{};
    o.size = glm::uvec2(number<uint32_t>(parts[0], 1, kLargestSide), number<uint32_t>(parts[1], 1, kLargestSide));
}

void setBackground(Options& o, const std::string& text) {
    BackgroundFlag background;
    if (text == "transparent") {
        background.transparent = true;
    } else {
        if (text.size() != 7 || text[0] != '#') throw Refused{};
        for (size_t i = 0; i < 3; ++i) {
            unsigned value = 0;
            const char* first = text.data() + 1 + 2 * i;
            if (std::from_chars(first, first + 2, value, 16).ptr != first + 2) throw Refused{};
            background.rgb[i] = uint8_t(value);
        }
    }
    o.background = background;
}

void setUp(Options& o, const std::string& text) {
    if (text.size() == 2 && (text[0] == '+' || text[0] == '-')) {
        const size_t axis = std::string("XYZxyz").find(text[1]);
        if (axis == std::string::npos) throw Refused{};
        glm::dvec3 up(0);
        up[int(axis % 3)] = text[0] == '+' ? 1 : -1;
        o.up = up;
        return;
    }
    o.up = vector(text);
    if (glm::length(*o.up) == 0) throw Refused{};
}

void addView(Options& o, const std::string& text) {
    const auto parts = split(text, ',');
    if (parts.size() == 2) {
        real(parts[0], -360, 360);
        real(parts[1], -90, 90);
    } else {
        oneOf<int>(text, {{"front", 0}, {"back", 0}, {"left", 0}, {"right", 0}, {"top", 0}, {"bottom", 0}, {"iso", 0}});
    }
    o.views.push_back(text);
}

void addAovs(Options& o, const std::string& text) {
    for (const auto part : split(text, ',')) {
        const Plane aov = valueOf(kAovs, part);
        if (std::find(o.aovs.begin(), o.aovs.end(), aov) == o.aovs.end()) o.aovs.push_back(aov);
        if (aov & kPlanesJudged) o.withError = true;
    }
}

void setMemory(Options& o, const std::string& text) {
    std::string_view digits = text;
    int shift = 0;
    if (!digits.empty()) {
        const size_t unit = std::string("KMGkmg").find(digits.back());
        if (unit != std::string::npos) shift = 10 * (1 + int(unit % 3)), digits.remove_suffix(1);
    }
    o.memoryBytes = number<uint64_t>(digits, 1, std::numeric_limits<uint64_t>::max() >> shift) << shift;
    if (o.memoryBytes < (uint64_t(1) << 20)) throw Refused{};
}

void addTrades(Options& o, const std::string& text) {
    for (const auto part : split(text, ',')) {
        const auto words = split(part, '=');
        const TradeAxis* axis = words.size() == 2 ? tradeAxis(words[0]) : nullptr;
        if (axis == nullptr || std::find(o.traded.begin(), o.traded.end(), axis) != o.traded.end()) throw Refused{};
        const TradeChoice* choice = choiceOfWord(axis->choices, words[1]);
        if (choice == nullptr)
            throw usageError(fmt::format("'{}={}' is refused; accepted for {}: {}", axis->name, printable(words[1]), axis->name,
                                         fmt::join(wordsIn(axis->choices), ", ")));
        choice->choose(o.trade);
        o.traded.push_back(axis);
    }
}

// "specular=schlick or native, light-vector=vertex, face or scene, ...": what is not the default.
std::string tradeHelp() {
    std::vector<std::string> less, more;
    for (const TradeAxis& axis : kTradeAxes) {
        std::vector<const char*> others = wordsIn(axis.choices.subspan(1));
        const char* last = others.back();
        others.pop_back();
        (axis.givesMore ? more : less)
            .push_back(fmt::format("{}={}{}{}", axis.name, fmt::join(others, ", "), others.empty() ? "" : " or ", last));
    }
    return fmt::format("turn the knobs of accuracy, by commas: {}; or have more of it: {}", fmt::join(less, ", "), fmt::join(more, ", "));
}

std::string acceptedTrades() {
    std::vector<std::string> axes;
    for (const TradeAxis& axis : kTradeAxes) axes.push_back(fmt::format("{}={}", axis.name, fmt::join(wordsIn(axis.choices), "|")));
    return fmt::format("AXIS=CHOICE by commas: {}", fmt::join(axes, ", "));
}

std::vector<std::string> tradeWords() {
    std::vector<std::string> words;
    for (const TradeAxis& axis : kTradeAxes)
        for (const TradeChoice& choice : axis.choices.subspan(1)) words.push_back(fmt::format("{}={}", axis.name, choice.word));
    return words;
}

void addJitter(Options& o, const std::string& text) {
    for (const auto part : split(text, ',')) {
        const auto words = split(part, '=');
        if (words.size() != 2) throw Refused{};
        std::optional<double>& amount = *oneOf<std::optional<double>*>(
            std::string(words[0]), {{"reflect", &o.jitterReflect}, {"refract", &o.jitterRefract}, {"shadow", &o.jitterShadow}});
        if (amount) throw Refused{};
        amount = real(words[1], 0, 0.5);
    }
}

double milliseconds(const std::string& text) {
    std::string_view digits = text;
    double unit = 0;
    for (const auto& [word, ms] : {std::pair("ms", 1.0), std::pair("min", 60000.0), std::pair("s", 1000.0)})
        if (unit == 0 && digits.ends_with(word)) unit = ms, digits.remove_suffix(std::string_view(word).size());
    if (unit == 0) throw Refused{};
    return real(digits, 0, 1e9) * unit;
}

// Milliseconds, at least 1.
double duration(const std::string& text) {
    const double ms = milliseconds(text);
    if (!(ms >= 1)) throw Refused{};
    return ms;
}

void setFailBlank(Options& o, const std::string& text) {
    if (text.empty()) {
        o.failBlank = 0.001;
        return;
    }
    std::string_view digits = text;
    const bool percent = digits.back() == '%';
    if (percent) digits.remove_suffix(1);
    o.failBlank = percent ? real(digits, 0, 100) / 100 : real(digits, 0, 1);
}

const std::vector<std::string> kNoWords;
const std::vector<std::string> kFile = {"FILE"};
const std::vector<std::string> kDeviceWords = {"auto", "twin", "lavapipe", "gpu", "software"};

const std::vector<Flag> kFlags = {
    {"-o,--output", "FILE", "write here; the extension .png, .exr or .npy chooses the format, '-' is PNG on standard output, '{n}', '{view}', '{aov}', '{eye}', '{field}' and '{ink}' are filled in; diff writes the difference as PNG, measure, devices and bench plan a report as one HTML file", "",
     "a path that ends in .png, .exr or .npy (measure, devices, bench: .html), or -", kFile, kRender | kVerify | kDiff | kMeasure | kDevices | kBench, [](Options& o, const std::string& v) {
         if (v.empty()) throw Refused{};
         o.output = v;
     }},
    {"--no-clobber", "", "refuse to replace an existing file", "", "", kNoWords, kRender | kDiff | kMeasure | kDevices | kBench, [](Options& o, const std::string&) { o.noClobber = true; }},
    {"--size", "WxH", "pixels of one picture", "the scene's, else 640x480; bench: 1920x1080, but plan as the scene's", "WIDTHxHEIGHT, each 1 to 65536, e.g. 640x480", kNoWords, kDraw | kBench, setSize},
    choiceFlag<&Options::shading, kShadings>("--shading", "MODE", "how faces are shaded",
        "the scene's, else ray where it has spheres or planes or a material that mirrors or refracts, else phong"),
    choiceFlag<&Options::fill, kFills>("--fill", "RULE", "which pixels a face covers", "the scene's, else exact"),
    choiceFlag<&Options::wire, kWireViews>("--wire", "VIEW", "what a wire frame shows", "the scene's, else see-through"),
    choiceFlag<&Options::wirePerPolygon, kEdgeCounts>("--edges", "COUNT", "what a wire frame draws (--wire solid: always polygons)", "the scene's, else once"),
    {"--cull", "WHEN", "leave out polygons that face away from the viewer (wire frames: --wire)", "the scene's, else on", "on, off", {"on", "off"}, kDraw,
     [](Options& o, const std::string& v) { o.cull = oneOf<bool>(v, {{"on", true}, {"off", false}}); }},
    choiceFlag<&Options::distantViewer, kViewers>("--viewer", "PLACE", "where highlights are seen from (raster shadings; --fill notes also culls by it)", "the scene's, else local"),
    {"--max-depth", "N", "rays one after another, with --shading ray; 1 shows local colours only", "the scene's, else 5", "a whole number, 1 to 64", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.maxDepth = number<uint32_t>(v, 1, 64); }},
    {"--min-weight", "W", "a ray that adds less than this share to its pixel is not followed, with --shading ray", "the scene's, else 0", "a number, 0 to 1", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.minWeight = real(v, 0, 1); }},
    choiceFlag<&Options::sampling, kSamplings>("--sampling", "WHERE", "where rays pass through a pixel, with --shading ray", "grid"),
    {"--jitter", "LIST", "noise on what a hit sends on, by commas, with --shading ray: blurred mirrors, blurred glass, soft shadows", "none", "reflect=X, refract=X, shadow=X by commas, X from 0 to 0.5",
     {"reflect=0.02", "refract=0.02", "shadow=0.02"}, kDraw, addJitter, true},
    {"--seed", "N", "of the noise of --jitter and --sampling random, and of the order of measure's rounds", "0", "a whole number, 0 to 4294967295", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.seed = number<uint32_t>(v, 0, ~uint32_t(0)); }},
    choiceFlag<&Options::cutLevels, kLevelForms>("--levels", "HOW", "how colours of rays add up, with --shading ray and --encode linear", "exact"),
    choiceFlag<&Options::samples, kSampleCounts>("--samples", "N", "samples a pixel, in an ordered grid", "1"),
    choiceFlag<&Options::encoding, kEncodings>("--encode", "CURVE", "how linear light becomes bytes", "the scene's, else srgb"),
    {"--background", "COLOUR", "what shows where nothing is drawn, as bytes of the picture", "the scene's, else #000000", "#rrggbb (hexadecimal) or transparent",
     {"transparent"}, kDraw, setBackground},
    {"--aov", "LIST", "planes to write, by commas: several into an .exr, one into an .npy (or '{aov}' in -o)", kAovs[0].word,
     listOf(kAovs) + ", by commas", copied(wordsIn(kAovs)), kRender, addAovs, true},
    {"--bits", "N", "bits of a PNG channel", "8", "8, 16", {"8", "16"}, kRender, [](Options& o, const std::string& v) { o.bits = oneOf<int>(v, {{"8", 8}, {"16", 16}}); }},
    {"--eye", "X,Y,Z", "where the camera stands, in world space", "the scene's, else framed", "three finite numbers by commas, e.g. 0,1,3.4", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.eye = vector(v); }},
    {"--at", "X,Y,Z", "the point it looks at", "the scene's, else the centre of the framed object", "three finite numbers by commas, e.g. 0,1,0", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.at = vector(v); }},
    {"--up", "AXIS", "the direction that is up", "the scene's, else +Y", "+X, -X, +Y, -Y, +Z, -Z, or three finite numbers by commas, not all 0",
     {"+X", "-X", "+Y", "-Y", "+Z", "-Z"}, kDraw, setUp},
    {"--fov", "DEGREES", "vertical field of view", "the scene's, else 45", "degrees, 0.01 to 179", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.fovDegrees = real(v, 0.01, 179); }},
    {"--near", "DISTANCE", "distance of the near plane", "the scene's, else the largest power of two not above 2^-10 of the distance to the framed centre", "a number above 0", kNoWords,
     kDraw,
     [](Options& o, const std::string& v) { o.near = real(v, 1e-30, 1e30); }},
    {"--camera", "CAMERA", "look through this camera of a glTF", "the first", "its number, from 0, or its name", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.camera = v; }},
    {"--view", "VIEW", "look from here at the whole scene; given several times, the views make a contact sheet", "",
     "front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees (-360 to 360, -90 to 90)",
     {"front", "back", "left", "right", "top", "bottom", "iso"}, kDraw, addView, true},
    {"--turntable", "N", "N pictures of one turn about the up axis; -o needs '{n}'", "", "a whole number, 1 to 100000", kNoWords, kRender,
     [](Options& o, const std::string& v) { o.turntable = number<uint32_t>(v, 1, 100000); }},
    {"--stereo", "FORM", "what two eyes see: pair makes two pictures and -o needs '{eye}', side-by-side one with the left eye's on the left, anaglyph one for red and cyan glasses", "",
     "pair, side-by-side, anaglyph", {"pair", "side-by-side", "anaglyph"}, kRender,
     [](Options& o, const std::string& v) { o.stereo = oneOf<StereoForm>(v, {{"pair", StereoForm::pair}, {"side-by-side", StereoForm::sideBySide}, {"anaglyph", StereoForm::anaglyph}}); }},
    {"--eye-separation", "DISTANCE", "distance between the two eyes of --stereo, in scene units", "1/30 of the distance to the framed centre", "a number above 0", kNoWords, kRender,
     [](Options& o, const std::string& v) { o.eyeSeparation = real(v, 1e-30, 1e30); }},
    {"--interlace", "", "write the lines 1, 3, 5, ... and the lines 2, 4, 6, ... as two pictures; -o needs '{field}' (odd, even)", "", "", kNoWords, kRender,
     [](Options& o, const std::string&) { o.interlace = true; }},
    {"--separations", "INKS", "write one grey PNG an ink, 255 being full ink, instead of the picture; -o needs '{ink}'", "", "cmy, cmyk (black is all that the three have in common)", {"cmy", "cmyk"}, kRender,
     [](Options& o, const std::string& v) {
         oneOf<int>(v, {{"cmy", 3}, {"cmyk", 4}});
         o.separations = v;
     }},
    {"--device", "DEVICE", "what draws", "auto", "auto, twin, lavapipe, gpu, software, an index, a UUID or a part of a name (`plumb devices` lists them)", kDeviceWords,
     kUsesDevice,
     [](Options& o, const std::string& v) {
         if (v.empty()) throw Refused{};
         o.device = v;
     }},
    {"--require-device", "KIND", "exit 4 rather than draw with anything else", "", "the words of --device", kDeviceWords, kUsesDevice,
     [](Options& o, const std::string& v) {
         if (v.empty()) throw Refused{};
         o.requireDevice = v;
     }},
    {"--threads", "N", "threads of the CPU twin and of diff; changes no byte", "all", "a whole number, 0 (all) to 4096", kNoWords, kDraw | kMatrix | kDiff | kBench,
     [](Options& o, const std::string& v) { o.threads = number<uint32_t>(v, 0, 4096); }},
    {"--memory", "BYTES", "budget of device memory; K, M, G are powers of 1024", "half of the free memory at most", "a whole number with K, M or G, at least 1M", kNoWords,
     kUsesDevice,
     setMemory},
    {"--watchdog", "MS", "give a dispatch up after this time", "60000", "milliseconds, 1 to 86400000", kNoWords, kDraw | kBench | kReplay,
     [](Options& o, const std::string& v) { o.watchdogMs = real(v, 1, 86400000); }},
    {"--limit-chunk", "N", "triangles of a chunk (tests)", "the device's", "a whole number above 0", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.limitChunk = number<uint64_t>(v, 1, ~uint64_t(0)); }, false, true},
    {"--limit-band", "ROWS", "rows of a band (tests)", "the device's", "a whole number above 0", kNoWords, kDraw,
     [](Options& o, const std::string& v) { o.limitBand = number<uint32_t>(v, 1, ~uint32_t(0)); }, false, true},
    {"--format", "FORMAT", "what the inputs are, whatever their names say; '-' is standard input", "by the extension, else by the first bytes", "obj, ply, stl, off, gltf, glb, toml",
     {"obj", "ply", "stl", "off", "gltf", "glb", "toml"}, kReads,
     [](Options& o, const std::string& v) {
         oneOf<int>(v, {{"obj", 0}, {"ply", 0}, {"stl", 0}, {"off", 0}, {"gltf", 0}, {"glb", 0}, {"toml", 0}});
         o.format = v;
     }},
    {"--strict", "", "refuse what a file asks for and is not drawn, and missing material libraries", "", "", kNoWords, kReads,
     [](Options& o, const std::string&) { o.strict = true; }},
    {"--allow-outside", "", "let files name files outside their own folder", "", "", kNoWords, kReads, [](Options& o, const std::string&) { o.allowOutside = true; }},
    {"--crease", "DEGREES", "where normals are missing, faces that meet at less are smooth", "60", "degrees, 0 to 180", kNoWords, kReads,
     [](Options& o, const std::string& v) { o.creaseDegrees = real(v, 0, 180); }},
    {"--fail-blank", "[=SHARE]", "exit 7 and write nothing when less of the picture is covered, or it has one colour only", "0.1%", "a share, 0 to 1, or a percentage, e.g. 0.1%",
     kNoWords, kRender, setFailBlank},
    {"--gate", "GATE", "exit 1 when this does not hold, instead of when any pixel differs; given several times, all must hold",
     "", "[PLANE.]METRIC<=VALUE: max, mean, rmse, psnr, ssim, flip, flip_max, deltae, deltae_max, ulp, differing, region, nan, over(LEVEL); psnr and ssim take >=; e.g. 'max<=2/255', "
     "'over(4/255)<=0.1%'", kNoWords, kDiff, [](Options& o, const std::string& v) { o.gates.push_back(v); }, true},
    {"--radius", "N", "a pixel matches when a pixel of the other picture within N columns and rows does (max, mean, rmse, psnr, over, differing, region)", "0", "a whole number, 0 to 16", kNoWords,
     kDiff, [](Options& o, const std::string& v) { o.radius = number<uint32_t>(v, 0, 16); }},
    {"--plane", "LIST", "compare these planes only, by commas", "all", "names of planes, by commas", kNoWords, kDiff,
     [](Options& o, const std::string& v) {
         for (const auto part : split(v, ',')) {
             if (part.empty()) throw Refused{};
             o.planes.emplace_back(part);
         }
     }, true},
    {"--ppd", "N", "pixels a degree of the viewer, for FLIP", "67.02: 3840 pixels on 0.7 m, seen from 0.7 m", "a number, 1 to 1000", kNoWords, kDiff,
     [](Options& o, const std::string& v) { o.pixelsPerDegree = real(v, 1, 1000); }},
    {"--heat", "FILE", "write a heat map as PNG: FLIP's error for colour, else the error", "", "a path that ends in .png", kFile, kDiff,
     [](Options& o, const std::string& v) {
         if (lowerExtension(v) != ".png") throw Refused{};
         o.heat = v;
     }},
    {"--json", "[=FILE]", "write the report as JSON, to standard output or to FILE", "", "a path", kFile, kReports,
     [](Options& o, const std::string& v) {
         o.json = true;
         o.jsonFile = v == "-" ? "" : v;
     }},
    {"--progress", "MODE", "progress on standard error; auto is a bar on a terminal and nothing elsewhere", "auto", "auto, bar, plain, json, none",
     {"auto", "bar", "plain", "json", "none"}, kDraw | kBench | kInfo | kDevices | kReplay,
     [](Options& o, const std::string& v) {
         o.progress = oneOf<ProgressMode>(v, {{"auto", ProgressMode::automatic}, {"bar", ProgressMode::bar}, {"plain", ProgressMode::plain}, {"json", ProgressMode::json}, {"none", ProgressMode::none}});
     }},
    {"--trade", "LIST", tradeHelp(), "the most accurate of each", acceptedTrades(), tradeWords(), kDraw, addTrades, true},
    {"--axis", "LIST", "only these axes, by commas: of choices (measure) or of extremes (stress)", "all", "names of axes, by commas; `plumb measure SCENE` and `plumb stress SCENE` list them", kNoWords, kMeasure | kStress,
     [](Options& o, const std::string& v) {
         for (const auto part : split(v, ',')) {
             if (part.empty()) throw Refused{};
             o.axes.emplace_back(part);
         }
     },
     true},
    {"--limit", "TIME", "end after this time; choices or axes that it leaves no time for are cut and listed", "120s", "a time with ms, s or min, at least 1ms, e.g. 90s", kNoWords, kMeasure | kStress,
     [](Options& o, const std::string& v) { o.limitMs = duration(v); }},
    {"--repetitions", "N", "rounds in which each choice is drawn once; medians and a front need at least 3, telling times apart about 8 to 11", "31", "a whole number, 1 to 1000", kNoWords, kMeasure,
     [](Options& o, const std::string& v) { o.repetitions = number<uint32_t>(v, 1, 1000); }},
    {"--csv", "[=FILE]", "write the rows as CSV, to standard output or to FILE", "", "a path", kFile, kMeasure,
     [](Options& o, const std::string& v) {
         o.csv = true;
         o.csvFile = v == "-" ? "" : v;
     }},
    {"--detail", "PX", "draw meshes simplified, and generated shapes with as many segments as it takes, so that no outline moves by more than PX pixels on the screen",
     "as the scene has them", "pixels, 0.001 to 1000", kNoWords, kRender | kVerify,
     [](Options& o, const std::string& v) { o.detail = real(v, 0.001, 1000); }},
    {"--flicker", "", "with --turntable: measure the largest change of a pixel from one picture to the next, where both show the same object", "", "", kNoWords, kRender,
     [](Options& o, const std::string&) { o.flicker = true; }},
    {"--with-error", "", "measure the picture against its truth in binary64: largest error and where, p99, rms, wrong primitives", "", "", kNoWords, kRender,
     [](Options& o, const std::string&) { o.withError = true; }},
    {"--error", "LIST", "take the cheapest choices that keep this error, check the picture against its truth, and exit 6 where no choice does: E or E:METRIC by commas; stress: where a margin ends", "no budget; stress: 1:p99,0.5%:wrong",
     "E or E:METRIC by commas, E in steps of 1/255 (2 or 2/255; for wrong a share, e.g. 0.1%), METRIC one of " + listOf(kErrorMetrics),
     {"1:max", "0.5:rms", "1:p99", "0.1%:wrong"}, kRender | kPlan | kStress, [](Options& o, const std::string& v) { addErrorBudget(o.error, v); }, true},
    {"--time", "T", "take the most accurate choices whose picture is drawn in this time, by counted work and a calibration of the device; exit 6 where none is", "no budget",
     "a time with ms, s or min, at least 1ms, e.g. 200ms", kNoWords, kRender | kPlan, [](Options& o, const std::string& v) { o.timeMs = duration(v); }},
    {"--check-time", "T", "with --error: check a random sample of the pixels where the truth of all would take longer", "ten times the picture's time",
     "a time with ms, s or min, at least 1ms, e.g. 30s", kNoWords, kRender, [](Options& o, const std::string& v) { o.checkMs = duration(v); }},
    {"--explain", "", "say which passes run, which were dropped and why; without -o nothing is drawn", "", "", kNoWords, kRender | kPlan,
     [](Options& o, const std::string&) { o.explain = true; }},
    {"-q,--quiet", "", "errors only", "", "", kNoWords, kReports, [](Options& o, const std::string&) { o.quiet = true; }},
    {"-v,--verbose", "", "say more: the device and its reason, times of the passes", "", "", kNoWords, kReports, [](Options& o, const std::string&) { ++o.verbose; }, true},
    {"--object", "NAME", "the object of the scene, by name or number", "all; pixel: the first", "a name or a number", kNoWords, kMatrix | kPixel, [](Options& o, const std::string& v) { o.object = v; }},
    {"--point", "X,Y[,Z]", "carry this point through the chain and print it after each step", "", "three finite numbers by commas, or two with --dimensions 2", kNoWords, kMatrix, addPoint, true},
    {"--dimensions", "N", "steps in the plane (3x3) or in space (4x4)", "3", "2, 3", {"2", "3"}, kMatrix,
     [](Options& o, const std::string& v) { o.dimensions = oneOf<int>(v, {{"2", 2}, {"3", 3}}); }},
    {"--notation", "FORM", "matrices for column vectors (matrix * point) or for row vectors (point * matrix)", "column", "column, row", {"column", "row"}, kMatrix,
     [](Options& o, const std::string& v) { o.rowNotation = oneOf<bool>(v, {{"column", false}, {"row", true}}); }},
    {"--reverse-z", "", "the same transformation in the coordinates of the other handedness", "", "", kNoWords, kMatrix, [](Options& o, const std::string&) { o.zReversed = true; }},
    {"--inverse", "", "print the inverse of the composite, too", "", "", kNoWords, kMatrix, [](Options& o, const std::string&) { o.inverse = true; }},
    {"--vertices", "N", "transform so many vertices step by step, by the composite and on several threads; count and time it", "", "a whole number, 1 to 100000000", kNoWords, kMatrix,
     [](Options& o, const std::string& v) { o.vertices = number<uint64_t>(v, 1, 100000000); }},
    {"--repeat", "N", "measure each row of a benchmark N times, its sides in turn", "50", "a whole number, 3 to 100000", kNoWords, kBench,
     [](Options& o, const std::string& v) { o.pairs = number<uint32_t>(v, 3, 100000); }},
    {"--suite", "", "draw built-in scenes that run every pass and every module, instead of scenes of yours; one line a test", "", "", kNoWords, kVerify,
     [](Options& o, const std::string&) { o.suite = true; }},
    {"--junit", "FILE", "write the tests of --suite as JUnit XML", "", "a path", kFile, kVerify, [](Options& o, const std::string& v) { o.junit = v; }},
    {"--capsule", "DIR", "where the sides differ: make the scene small, and write the dispatch at fault with its input, what is expected and what came, for `plumb replay`", "", "a folder that is new or empty", kFile, kVerify,
     [](Options& o, const std::string& v) {
         if (v.empty()) throw Refused{};
         o.capsule = v;
     }},
    {"--reduce", "TIME", "longest time to make the scene of a capsule small; 0s keeps it", "30s", "a time with ms, s or min, e.g. 10s", kNoWords, kVerify,
     [](Options& o, const std::string& v) { o.reduceMs = milliseconds(v); }},
    {"--times", "N", "run the dispatch N times", "20", "a whole number, 1 to 100000", kNoWords, kReplay,
     [](Options& o, const std::string& v) { o.times = number<uint32_t>(v, 1, 100000); }},
    {"--fingerprint", "", "ask the picked device what it does with numbers: errors of each operation, contraction, subnormals, NaN, loops, and one hash", "", "", kNoWords, kDevices,
     [](Options& o, const std::string&) { o.fingerprint = true; }},
    {"--all-floats", "", "for the fingerprint: every float32 of sqrt, inversesqrt, exp2, log2, sin and cos, too (minutes)", "", "", kNoWords, kDevices,
     [](Options& o, const std::string&) { o.allFloats = true; }},
    {"--compare", "", "name each trait that differs between two JSON files of fingerprints; exit 1 when one does", "", "", kNoWords, kDevices,
     [](Options& o, const std::string&) { o.compare = true; }},
    {"--polygon", "N", "open this polygon of the object, at the pixels if any are given", "", "a whole number, from 0", kNoWords, kPixel,
     [](Options& o, const std::string& v) { o.polygon = number<uint32_t>(v, 0, ~uint32_t(0)); }},
    {"--ray", "X,Y,Z,X,Y,Z", "open the ray from the first point through the second, by --shading ray", "", "six finite numbers by commas, two different points of the world", kNoWords, kPixel, setRay},
    {"--vertex", "N", "open the polygon that has this vertex of the object first", "", "a whole number, from 0", kNoWords, kPixel,
     [](Options& o, const std::string& v) { o.vertex = number<uint32_t>(v, 0, ~uint32_t(0)); }},
    {"--man", "", "print the man page", "", "", kNoWords, kHelp, [](Options& o, const std::string&) { o.man = true; }},
    {"--completion", "SHELL", "print the completion script of a shell", "", "bash, zsh, fish", {"bash", "zsh", "fish"}, kHelp,
     [](Options& o, const std::string& v) {
         oneOf<int>(v, {{"bash", 0}, {"zsh", 0}, {"fish", 0}});
         o.completion = v;
     }},
    {"-h,--help", "", "print help", "", "", kNoWords, kEveryCommand, [](Options& o, const std::string&) { o.help = true; }},
    {"--version", "", "print version, commit and the hashes of the shaders", "", "", kNoWords, kEveryCommand, [](Options& o, const std::string&) { o.version = true; }},
};

const std::vector<CommandRow> kCommands = {
    {kRender,
     "render",
     "SCENE|MESH...",
     "draw a scene",
     "Draws a scene file (.toml), a glTF (.gltf, .glb) or bare meshes (.obj, .ply, .stl, .off) and writes the picture; '-' is one of these "
     "on standard input. A scene without a camera is framed, a bare mesh is lit. "
     "Without a usable Vulkan device the CPU twin draws the same bytes and says so.",
     {{{"plumb render mug.obj -o mug.png", "a framed, lit picture of 640x480 pixels"},
       {"plumb render mug.obj --view front --view iso --view 30,20 --size 320x240 -o sheet.png", "three views as one contact sheet"},
       {"plumb render scene.toml --aov color,depth,normal,object_id -o scene.exr --json",
        "measurements as one EXR, the report on standard output"}}}},
    {kVerify,
     "verify",
     "SCENE|MESH...",
     "compare the device with the CPU twin",
     "Draws each scene on the device and by the CPU twin and compares them twice: each pass on the twin's input, and the whole chain on "
     "each side's own output. "
     "Prints every plane with its SHA-256. Exit 1 names the first differing tile, pixel, both values, ULP distance, object and primitive, "
     "and with -o writes both pictures and their difference beside it. "
     "With --suite it draws built-in scenes, which need no file. With --capsule it writes a difference as one dispatch that others can "
     "run.",
     {{{"plumb verify scene.toml", "all passes and planes at the scene's size"},
       {"plumb verify --suite --junit suite.xml", "every pass and module of this program on this device"},
       {"plumb verify mug.obj --device lavapipe --json=verify.json -o verify/mug.png",
        "one device, a report, and pictures in case of a difference"}}}},
    {kReplay,
     "replay",
     "CAPSULE",
     "run the dispatch of a capsule again",
     "Runs the module of a capsule (`plumb verify --capsule`) on its input, so many times, and counts the distinct results. Needs no "
     "scene. "
     "Exit 0: every result is the expected one. Exit 1: one is not, and the first value that differs is named. Exit 3: the folder is torn, "
     "or "
     "no capsule.",
     {{{"plumb replay capsule", "20 runs"},
       {"plumb replay capsule --device lavapipe --times 1000", "more runs, on another device"},
       {"plumb replay capsule --json", "the results for programs"}}}},
    {kDiff,
     "diff",
     "A B",
     "compare two pictures",
     "Compares two PNG, EXR or NPY pictures plane by plane: largest, mean and root-mean-square error, PSNR, SSIM, FLIP, CIEDE2000, ULP of "
     "float planes, pixels over 1, 2, 4 and 8 levels, the "
     "largest connected region. Exit 0 when all gates hold, or without a gate when no pixel differs; exit 1 otherwise, with the pixel. A "
     "NaN is named before any norm; another size is a "
     "difference, never resized.",
     {{{"plumb diff a.png b.png", "every measure; exit 1 when a pixel differs"},
       {"plumb diff a.png b.png --gate 'max<=2/255' --gate 'flip<=0.02' -o diff.png --heat heat.png", "two gates, and pictures of where"},
       {"plumb diff a.exr b.exr --plane depth --gate 'depth.ulp<=4' --json", "one plane of two EXRs, the report on standard output"}}}},
    {kMeasure,
     "measure",
     "SCENE|MESH...",
     "measure what speed costs in accuracy",
     "Draws the scene in every way that there is, one choice changed at a time, and prints the time of each (its ratio to the default, "
     "round by round, with an interval) and its error against a truth computed in binary64. "
     "What the interval does not tell apart from the default is called so; rows that nothing beats are marked. An axis whose choice does "
     "not exist in this version is listed as absent.",
     {{{"plumb measure scene.toml", "all axes, at most two minutes"},
       {"plumb measure mug.obj --axis shading,samples --size 320x240 --csv=mug.csv", "two axes, the rows as CSV"},
       {"plumb measure scene.toml --limit 30s -o report.html --json=measure.json",
        "less time, with a report for people and one for programs"}}}},
    {kPlan,
     "plan",
     "SCENE|MESH...",
     "say what a scene requires",
     "Prints the choices and steps that a picture would take, what they are predicted to cost, and how wrong they are: without a budget as "
     "`render` draws it, with --error the cheapest that keep it, with --time the most accurate that fit. Costs are counted work times unit "
     "costs, which a calibration of a second or two measures once for each device and driver. Errors come from a small picture by the CPU "
     "twin. No picture is drawn at full size.",
     {{{"plumb plan scene.toml", "steps, work and time of the picture as it is"},
       {"plumb plan scene.toml --error 2:max,0.5:rms --explain", "every choice with its cost and error, and the cheapest that keeps both"},
       {"plumb plan scene.toml --time 200ms --json", "the most accurate within a time, for programs"}}}},
    {kDevices,
     "devices",
     "[A.json B.json]",
     "list what can draw, and what it does with numbers",
     "Lists what the Vulkan loader finds, what would be picked and why not the others, and what the start-up self-test says. "
     "With --fingerprint it asks the picked device for the errors of its operations, beside what Vulkan allows, and for what Vulkan leaves "
     "open. With --compare it names what two devices do differently.",
     {{{"plumb devices --require-device gpu", "the list; exit 4 when there is no GPU"},
       {"plumb devices --fingerprint -o device.html --json=device.json", "what this device does with numbers"},
       {"plumb devices --compare a.json b.json", "what two devices do differently"}}}},
    {kInfo,
     "info",
     "SCENE|MESH...",
     "describe scenes and meshes",
     "Counts, bounds, open and non-manifold edges, degenerate faces and materials of each file. Needs no device.",
     {{{"plumb info mug.obj", "what is in the file"},
       {"plumb info --json *.stl", "one JSON object a file"},
       {"plumb info --strict model.glb", "exit 3 when the file asks for what is not drawn"}}}},
    {kMatrix,
     "matrix",
     "STEP...|SCENE",
     "print a chain of transforms",
     "Prints each step of a chain of transforms, the product so far, the composite, and the same chain as a tree of products with its "
     "depth. A step is what=value with further parts after "
     "colons: translate=X,Y,Z; scale=S or X,Y,Z; rotate_x, rotate_y, rotate_z=DEGREES, these with :about=X,Y,Z; rotate=DEGREES:axis=X,Y,Z "
     "with :through=X,Y,Z; rotate=DEGREES:from=X,Y,Z:to=X,Y,Z "
     "about a line; matrix=16 numbers. With --dimensions 2: translate, scale, rotate, matrix=9 numbers. Or the objects of a scene. Needs "
     "no device.",
     {{{"plumb matrix rotate=90:from=3,3,5:to=6,6.4641,7 --point 4,3,5",
        "the seven matrices of a rotation about a line, and where a point goes"},
       {"plumb matrix --dimensions 2 rotate=90:about=3,2 --notation row", "an in-place rotation of the plane, as matrices for row vectors"},
       {"plumb matrix scene.toml --object mug --json", "the chain of one object for programs"}}}},
    {kBench,
     "bench",
     "raster|passes|matrix|claims|trace|plan [ROW...]",
     "measure speed against other ways to the same result",
     "raster: the passes against the device's own graphics pipeline, per-pixel Phong of the same scene, interleaved, warm, both with the "
     "picture in memory of the host. "
     "ROW is sphereN, knotN, displacedN (N triangles, e.g. sphere1e5), full-screen, layers-b2f, layers-f2b, a scene or a mesh; all "
     "generated ones without a ROW. "
     "Coverage of the two pictures is compared: exit 1 when a pixel differs further than 1/256 pixel from an edge. "
     "passes: the passes alone, also with lightsN (1 to 64 lights), for how their cost grows. "
     "matrix: vertices by one matrix and by seven, and products of chains, on the device, by the twin and by the libraries that were "
     "found, beside the bandwidth of the memory. "
     "ROW is a count, e.g. 1e6; 1e3 to 1e7 without a ROW. "
     "claims: P1 to P4 and P6 to P9 of the lecture notes (what transforming, filling, projecting, culling and shading cost), counted and "
     "timed; ROW is sphereN, sphere1e4 without; exit 1 when a count disagrees. "
     "trace: rays on the device against the same algorithm in plain C++ (spheres4, spheres20: mirrors over a board, depth 5) and primary "
     "rays against Embree where the build found it "
     "(mesh1e5, mesh1e6). plan: of each scene the plan that drops nothing, the lossless plan, and the cheapest choices whose largest error "
     "is at most 1 and 4 steps of 1/255, with errors and what their times tell apart; ROW is a scene or a mesh, scenes/*.toml without; "
     "exit "
     "1 when the first two differ in a byte. Medians with the 10th and 90th percentile; times are never judged.",
     {{{"plumb bench raster", "the generated meshes at 1920x1080"},
       {"plumb bench raster sphere1e5 mug.obj --repeat 20 --json", "one generated and one named mesh, for programs"},
       {"plumb bench plan scene.toml -o report.html", "what a plan saves, with a report for people"}}}},
    {kPixel,
     "pixel",
     "SCENE|MESH [X,Y...]",
     "open one pixel into the chain of the lecture notes",
     "Draws the picture on the device and by the CPU twin, and opens pixels of it (column,row from the top left): vertices, composite "
     "matrix, "
     "projection, cull, fill, Z, normal, lights, bytes. Each line has its section of the lecture notes and four columns: the textbook "
     "formula "
     "in float32, the device, the twin, and the truth with its bound. A value that a side does not compute says so. It tells the first "
     "line on "
     "which sides part. Takes the camera and the choices of `plumb render --fill exact`, without --shading wire and ray.",
     {{{"plumb pixel scene.toml 320,240", "one pixel, from its vertices to its bytes"},
       {"plumb pixel scene.toml 320,240 100,50 --json", "two pixels, for programs"},
       {"plumb pixel mug.obj --polygon 7", "one polygon of the first object, as far as it goes without a pixel"}}}},
    {kStress,
     "stress",
     "SCENE|MESH...",
     "find where a scene stops being drawn right",
     "Drives the scene along extremes by powers of two: vertices far from 0, scene and camera far from 0 or from each other, size, field "
     "of view, near plane, layers close together, highlights, lights, grazing angles, resolution, mesh density, depth of rays. "
     "Each picture is compared with its truth, and where the error passes --error the place is bisected. Prints a margin for each axis, "
     "also with float32 alone. "
     "A margin m was drawn on both sides: at m/2 the picture keeps the error, at 2m and 4m it does not. Axes that do not apply are named "
     "with the reason. "
     "Exit 1: the scene itself is beyond a margin.",
     {{{"plumb stress scene.toml --size 160x120", "the margins of every axis"},
       {"plumb stress mug.obj --axis fov,near --error 2:max", "two axes, and another error"},
       {"plumb stress scene.toml --size 160x120 --json=stress.json", "every picture that was drawn, for programs"}}}},
    {kHelp,
     "help",
     "[COMMAND]",
     "explain a command",
     "Prints the flags of a command with examples, the man page, or the completions of a shell.",
     {{{"plumb help render", "flags and examples of one command"},
       {"plumb help --man | man -l -", "the manual"},
       {"plumb help --completion bash > plumb.bash", "completions to be sourced"}}}},
};

// Reserved by the design for later versions, so that nothing else takes the words.
constexpr std::array kLater = {"view", "merge", "worker", "report"};

constexpr std::array<ExitRow, 11> kExitCodes = {{{0, "done, and every gate held"},
                                                 {1, "compared, and different"},
                                                 {2, "the command line is refused"},
                                                 {3, "the input is refused"},
                                                 {4, "no usable device, or not the required one"},
                                                 {5, "render or write failed"},
                                                 {6, "the budget cannot be met"},
                                                 {7, "the picture is blank and --fail-blank was given"},
                                                 {130, "interrupted"},
                                                 {141, "standard output has lost its reader"},
                                                 {143, "terminated"}}};

// "; did you mean 'x'?" for the nearest word that is at most two edits away.
std::string suggestion(std::string_view word, const std::vector<std::string>& words) {
    std::string best;
    size_t least = 3;
    for (const std::string& w : words) {
        const size_t d = editDistance(word, w, Letters::asWritten);
        if (d < least) least = d, best = w;
    }
    return best.empty() ? "" : fmt::format("; did you mean '{}'?", best);
}

Command commandOf(const std::string& word) {
    for (const CommandRow& row : kCommands)
        if (word == row.name) return row.bit;
    if (std::find(kLater.begin(), kLater.end(), word) != kLater.end()) throw usageError(fmt::format("'{}' is not in this version", word));
    std::vector<std::string> words;
    for (const CommandRow& row : kCommands) words.emplace_back(row.name);
    throw usageError(
        fmt::format("'{}' is not a command{}; commands: {}", printable(word), suggestion(word, words), fmt::join(words, ", ")));
}

Error unknownFlag(const std::string& token) {
    const std::string name = token.substr(0, token.find('='));
    std::vector<std::string> words;
    for (const Flag& flag : kFlags)
        if (!flag.hidden) words.push_back(flag.longName());
    return usageError(fmt::format("unknown flag '{}'{}", printable(name), suggestion(name, words)));
}

void checkTogether(const Options& o) {
    if (o.flicker && o.turntable < 2) throw usageError("--flicker goes with --turntable N of 2 or more pictures");
    if (o.detail > 0 && o.stereo != StereoForm::none)
        throw usageError("--detail and --stereo exclude each other: detail is that of one eye");
    if (o.detail > 0 && (!o.error.empty() || o.timeMs))
        throw usageError("--detail and --error or --time exclude each other: a budget is for the scene as it is");
    if (o.quiet && o.verbose != 0) throw usageError("-q and -v exclude each other");
    if (o.turntable != 0 && o.views.size() > 1) throw usageError("--turntable turns one view: give --view once at most");
    if (!o.views.empty() && (o.eye || o.at)) throw usageError("--view and --eye/--at exclude each other");
    if (!o.camera.empty() && (!o.views.empty() || o.eye || o.at)) throw usageError("--camera and --view, --eye or --at exclude each other");
    if (o.fill && o.shading == Shading::wire) throw usageError("--fill and --shading wire exclude each other: a wire frame fills nothing");
    if (o.checkMs && o.error.empty()) throw usageError("--check-time goes with --error: nothing else is checked");
    if ((!o.error.empty() || o.timeMs) && o.shading == Shading::wire)
        throw usageError("--error and --time: a wire frame has no truth that a budget could be held against");
    if ((!o.error.empty() || o.timeMs) && o.stereo != StereoForm::none)
        throw usageError("--error and --time: the truth is that of one eye; draw each by its own --eye");
    if (o.dimensions == 2 && o.spacePoints) throw usageError("--point: with --dimensions 2 a point has two numbers");
    if (o.dimensions == 3 && o.planePoints) throw usageError("--point: a point has three numbers, unless with --dimensions 2");
    if (o.command == kDiff && !o.output.empty() && o.output != "-" && lowerExtension(o.output) != ".png")
        throw usageError(fmt::format("--output: '{}' is refused; accepted: a path that ends in .png, or -", printable(o.output)));
    // Before a mesh is read for it; a placeholder in the extension is filled in later.
    if (const std::string extension = lowerExtension(o.output); o.command == kRender && !o.output.empty() && o.output != "-" &&
                                                                extension != ".png" && extension != ".exr" && extension != ".npy" &&
                                                                extension.find('{') == std::string::npos)
        throw usageError(
            fmt::format("--output: '{}' is refused; accepted: a path that ends in .png, .exr or .npy, or -", printable(o.output)));
    if ((o.command == kMeasure || o.command == kBench) && !o.output.empty() && lowerExtension(o.output) != ".html")
        throw usageError(fmt::format("--output: '{}' is refused; accepted: a path that ends in .html", printable(o.output)));
    if (o.command == kPixel && o.views.size() > 1) throw usageError("`plumb pixel` opens pixels of one picture: give --view once at most");
    if (o.polygon && o.vertex) throw usageError("--polygon and --vertex exclude each other");
    if (o.ray && (o.polygon || o.vertex)) throw usageError("--ray opens what it meets; leave --polygon and --vertex out");
    if (o.ray && o.inputs.size() > 1) throw usageError("--ray is a picture of its own; leave the pixels out");
    if (o.compare && (o.fingerprint || o.allFloats))
        throw usageError("--compare and --fingerprint exclude each other: compare reads two files");
    if (o.suite && !o.inputs.empty()) throw usageError("--suite has its own scenes: leave the operands out");
    if (o.suite && (o.size || o.shading || o.fill || o.encoding || o.samples || !o.traded.empty() || !o.views.empty() || o.turntable != 0))
        throw usageError("--suite has its own pictures: leave the flags that change one out");
    if (!o.junit.empty() && !o.suite) throw usageError("--junit goes with --suite");
    if (o.suite && !o.output.empty()) throw usageError("--suite writes no pictures: leave --output out");
    if (o.allFloats && !o.fingerprint) throw usageError("--all-floats goes with --fingerprint");
    if (o.command == kDevices && !o.output.empty() && (!o.fingerprint || lowerExtension(o.output) != ".html"))
        throw usageError(o.fingerprint ? fmt::format("--output: '{}' is refused; accepted: a path that ends in .html", printable(o.output))
                                       : std::string("--output goes with --fingerprint, which writes its page there"));
    if ((o.command & (kRender | kDiff)) != 0 && o.json && o.jsonFile.empty() && o.output == "-")
        throw usageError("--json and -o - both want standard output: use --json=FILE or -o FILE");
}

}  // namespace

std::string Flag::longName() const {
    const std::string all = names;
    return all.substr(all.find("--"));
}
std::string Flag::shortName() const {
    const std::string all = names;
    return all[1] == '-' ? "" : all.substr(0, 2);
}

std::span<const Flag> flags() { return kFlags; }
std::span<const CommandRow> commands() { return kCommands; }
std::span<const ExitRow> exitCodes() { return kExitCodes; }
const CommandRow& rowOf(Command command) {
    for (const CommandRow& row : kCommands)
        if (row.bit == command) return row;
    PLUMB_ASSERT(!"a command has a row");
    return kCommands[0];
}

const char* nameOf(StereoForm form) {
    static constexpr const char* kNames[] = {"none", "pair", "side-by-side", "anaglyph"};
    return kNames[size_t(form)];
}
std::string versionText() { return PLUMB_VERSION; }

Options parseOptions(const std::vector<std::string>& arguments) {
    CLI::App app;
    app.set_help_flag("");
    app.allow_extras();
    std::vector<std::string> words;
    app.add_option("words", words);
    std::vector<std::vector<std::string>> values(kFlags.size());
    std::vector<CLI::Option*> switches(kFlags.size());
    for (size_t i = 0; i < kFlags.size(); ++i) {
        const Flag& flag = kFlags[i];
        if (flag.isSwitch() || flag.optionalValue())
            switches[i] = app.add_flag(flag.names);
        else
            app.add_option(flag.names, values[i])->allow_extra_args(false);
    }
    for (const std::string& argument : arguments) {
        if (argument == "--") break;
        if (argument.size() > 3 && argument.starts_with("--") && argument.find('=') == argument.size() - 1)
            throw usageError(fmt::format("{}: a value is missing after '='", printable(argument.substr(0, argument.size() - 1))));
    }
    try {
        app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 takes them from the back
    } catch (const CLI::ArgumentMismatch& e) {
        const std::string text = e.what();
        for (const Flag& flag : kFlags)
            if (text.find(flag.longName() + ":") != std::string::npos || text.find(flag.longName() + " ") != std::string::npos)
                throw usageError(fmt::format("{}: a value is missing; accepted: {}", flag.longName(), flag.accepted));
        throw usageError(text);
    } catch (const CLI::ParseError& e) {
        throw usageError(e.what());
    }
    for (const std::string& extra : app.remaining())
        if (extra != "--") throw unknownFlag(extra);

    Options options;
    for (size_t i = 0; i < kFlags.size(); ++i) {
        const std::string name = kFlags[i].longName();
        if (switches[i] != nullptr) {
            for (const std::string& result : switches[i]->results()) {
                const bool bare = result == "true";
                if (!bare && kFlags[i].isSwitch()) throw usageError(fmt::format("{} takes no value", name));
                values[i].push_back(bare ? "" : result);
            }
        }
        if (values[i].size() > 1 && !kFlags[i].repeatable)
            throw usageError(fmt::format("{} is given {} times; once is enough", name, values[i].size()));
        for (const std::string& value : values[i]) {
            try {
                kFlags[i].set(options, value);
            } catch (const Refused&) {
                throw usageError(fmt::format("{}: '{}' is refused; accepted: {}", name, printable(value), kFlags[i].accepted));
            }
        }
    }
    if (words.empty()) {
        if (!options.help && !options.version) throw usageError("a command is missing; `plumb help` lists them");
        return options;
    }
    options.command = commandOf(words[0]);
    options.inputs.assign(words.begin() + 1, words.end());
    for (size_t i = 0; i < kFlags.size(); ++i)
        if (!values[i].empty() && (kFlags[i].commands & options.command) == 0)
            throw usageError(
                fmt::format("{} is not a flag of `plumb {}`; `plumb help {}` lists them", kFlags[i].longName(), words[0], words[0]));
    if (options.help || options.version) return options;
    const CommandRow& row = rowOf(options.command);
    if (options.command == kHelp) {
        if (options.inputs.size() > 1) throw usageError("help takes one command");
        if (!options.inputs.empty()) commandOf(options.inputs[0]);
    } else if (row.operands[0] == '\0' || (options.command == kDevices && !options.compare)) {
        if (!options.inputs.empty())
            throw usageError(fmt::format("`plumb {}` takes no operand, and '{}' is one", row.name, printable(options.inputs[0])));
    } else if (options.inputs.empty() && !options.suite) {
        throw usageError(fmt::format("`plumb {}` needs {}", row.name, row.operands));
    }
    if (options.compare && options.inputs.size() != 2)
        throw usageError(fmt::format("`plumb devices --compare` needs two fingerprints, and {} are given", options.inputs.size()));
    if (options.command == kDiff && options.inputs.size() != 2)
        throw usageError(fmt::format("`plumb diff` needs two pictures, and {} are given", options.inputs.size()));
    checkTogether(options);
    return options;
}

}  // namespace plumb
