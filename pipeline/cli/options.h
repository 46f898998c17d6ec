// SPDX-License-Identifier: MIT
// The command line as a request. One table of flags makes the parser, the help, the man page and the completions, so they cannot disagree.
// The order of flags never matters, and a flag may stand before the command. A flag that takes one value and is given twice is refused; the
// later one does not win.
#pragma once

#include "pipeline/choices/budget.h"
#include "pipeline/choices/choices.h"
#include "pipeline/choices/planes.h"
#include "pipeline/choices/trade.h"
#include "pipeline/scene/scene.h"

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace plumb {

enum Command : uint32_t {
    kRender = 1,
    kVerify = 2,
    kDevices = 4,
    kInfo = 8,
    kHelp = 16,
    kDiff = 32,
    kMeasure = 64,
    kMatrix = 128,
    kBench = 256,
    kPixel = 512,
    kPlan = 1024,
    kReplay = 2048,
    kStress = 4096,
    kEveryCommand = 127 | kMatrix | kBench | kPixel | kPlan | kReplay | kStress
};

enum class ProgressMode { automatic, bar, plain, json, none };
enum class StereoForm { none, pair, sideBySide, anaglyph };

// As written on the command line: bytes of the picture, before any encoding is undone.
struct BackgroundFlag {
    bool transparent = false;
    std::array<uint8_t, 3> rgb{};
};

struct Options {
    Command command = kHelp;
    std::vector<std::string> inputs;  // what stands after the command
    bool help = false, version = false;

    std::vector<std::string> gates;  // conditions of diff, as written; pipeline/compare/gate.h parses them
    uint32_t radius = 0;
    double pixelsPerDegree = 0;       // 0: the default of pipeline/compare
    std::vector<std::string> planes;  // empty: all
    std::string heat;                 // heat map; empty: not given

    std::string output;  // empty: not given; "-": stdout
    bool noClobber = false;
    std::optional<glm::uvec2> size;
    std::optional<Shading> shading;
    std::optional<Fill> fill;
    std::optional<bool> distantViewer, wirePerPolygon, cull;
    std::optional<WireView> wire;
    std::optional<Encoding> encoding;
    std::optional<uint32_t> samples;   // of a pixel; none: 1, and --time may choose
    std::optional<uint32_t> maxDepth;  // longest chain of rays
    std::optional<double> minWeight;
    std::optional<Sampling> sampling;  // the following five go with rays alone
    std::optional<double> jitterReflect, jitterRefract, jitterShadow;
    std::optional<uint32_t> seed;
    std::optional<bool> cutLevels;
    std::optional<BackgroundFlag> background;
    std::vector<Plane> aovs;  // empty: colour
    int bits = 8;

    std::optional<glm::dvec3> eye, at, up;
    std::optional<double> fovDegrees, near;
    std::vector<std::string> views;  // words of frameCamera()
    uint32_t turntable = 0;          // pictures of one turn; 0: none
    StereoForm stereo = StereoForm::none;
    std::optional<double> eyeSeparation;  // scene units
    bool interlace = false;
    std::string separations;  // cmy, cmyk; empty: none

    std::string device = "auto", requireDevice;
    uint32_t threads = 0;
    uint64_t memoryBytes = 0;
    double watchdogMs = 60000;
    uint64_t limitChunk = 0;
    uint32_t limitBand = 0;

    std::string format;  // format of the inputs; empty: by name, else by content
    std::string camera;  // of a glTF, by number or name; empty: the first
    bool strict = false, allowOutside = false;
    double creaseDegrees = 60;
    std::optional<double> failBlank;  // smallest covered fraction that is not blank
    bool json = false;
    std::string jsonFile;  // empty: stdout
    ProgressMode progress = ProgressMode::automatic;
    std::vector<std::string> axes;  // axes of measure and stress; empty: all
    double limitMs = 120000;        // longest time of a measurement or of a sweep
    uint32_t repetitions = 31;
    bool csv = false;
    std::string csvFile;  // empty: stdout

    Trade trade;
    std::vector<const TradeAxis*> traded;  // axes that are stated
    double detail = 0;                     // largest deviation of simplified meshes and generated shapes, in pixels; 0: not given
    bool flicker = false;
    bool withError = false;
    ErrorBudget error;                      // of a picture against its truth
    std::optional<double> timeMs, checkMs;  // most that a picture may take, and the check of its error
    bool explain = false, quiet = false;
    uint32_t verbose = 0;

    std::string object;                             // matrix: name or number; empty: all
    std::vector<glm::dvec3> points;                 // matrix: taken through the chain; in the plane z is 0
    bool planePoints = false, spacePoints = false;  // a point has two numbers, or three
    int dimensions = 3;                             // matrix: 2 or 3
    bool rowNotation = false, zReversed = false, inverse = false;
    uint64_t vertices = 0;  // matrix: to be transformed, counted and timed
    uint32_t pairs = 50;    // pairs of runs of a benchmark's row

    bool suite = false;       // of verify
    std::string junit;        // empty: not given
    std::string capsule;      // folder; empty: not given
    double reduceMs = 30000;  // longest time to make a capsule's scene small
    uint32_t times = 20;      // of replay

    bool fingerprint = false, allFloats = false, compare = false;  // of devices

    std::optional<uint32_t> polygon, vertex;       // pixel: what to open, by number from 0
    std::optional<std::array<glm::dvec3, 2>> ray;  // pixel: start, and a point that the ray passes through, world

    bool man = false;
    std::string completion;  // bash, zsh, fish
};

// One row a flag. `argument` is "" for a switch, "[=X]" when the value may be left out.
struct Flag {
    const char* names;  // "-o,--output"
    const char* argument;
    std::string help;                // one sentence without a full stop
    const char* fallback;            // default as shown; "" when there is none
    std::string accepted;            // what a refused value is told
    std::vector<std::string> words;  // values to complete; "FILE" completes file names
    uint32_t commands;
    void (*set)(Options&, const std::string&);  // throws Refused (options.cpp) on a value that is not accepted
    bool repeatable = false;
    bool hidden = false;
    std::string meanings = {};  // accepted values with what each does, shown in their place; empty: none

    bool isSwitch() const { return argument[0] == '\0'; }
    bool optionalValue() const { return argument[0] == '['; }
    std::string longName() const;   // "--output"
    std::string shortName() const;  // "-o", or ""
};

struct CommandRow {
    Command bit;
    const char* name;
    const char* operands;  // "SCENE|MESH..."
    const char* summary;
    const char* description;
    std::array<std::array<const char*, 2>, 3> examples;  // command line, what it does
};

struct ExitRow {
    int code;
    const char* meaning;
};

std::span<const Flag> flags();
std::span<const CommandRow> commands();
std::span<const ExitRow> exitCodes();
const CommandRow& rowOf(Command);

// Arguments without the program's name. Throws Error(usage): one line naming the flag and the accepted values.
Options parseOptions(const std::vector<std::string>& arguments);

std::string usageText();                                 // `plumb help`
std::string helpText(Command);                           // `plumb help CMD`: flags, three examples, exit codes
std::string manPage();                                   // roff for man(1)
std::string completionScript(const std::string& shell);  // bash, zsh, fish

// "640x480" etc. as printed in messages and JSON.
const char* nameOf(StereoForm);
std::string versionText();  // "0.1.0"

}  // namespace plumb
