// SPDX-License-Identifier: MIT
// The command line: what is accepted, what is refused and how, and that everything made from the table holds the table.
#include "host/error.h"
#include "pipeline/cli/options.h"
#include "pipeline/cli/progress.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <glm/glm.hpp>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace plumb {
namespace {

Options parse(const std::string& line) {
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return parseOptions(words);
}

TEST(Options, TakeEveryValueOfTheTable) {
    const Options o = parse(
        "render a.obj b.ply -o out.exr --size 333x211 --shading gouraud --samples 16 --encode linear --background #12ab00 --aov "
        "depth,id,depth "
        "--aov color --bits 16 --eye -1,2.5,3e2 --at 0,0,0 --up -Z --fov 30 --near 0.5 --device lavapipe --require-device software "
        "--threads 3 "
        "--no-clobber --fail-blank=2% --json=r.json --progress json --with-error --trade specular=schlick,depth=16 --trade subpixel=4 "
        "--explain --strict --allow-outside --crease 12 --memory 2G --limit-chunk 7 "
        "--limit-band 9 --watchdog 500 -v -v");
    EXPECT_EQ(o.command, kRender);
    EXPECT_EQ(o.inputs, (std::vector<std::string>{"a.obj", "b.ply"}));
    EXPECT_EQ(o.output, "out.exr");
    EXPECT_EQ(*o.size, glm::uvec2(333, 211));
    EXPECT_EQ(*o.shading, Shading::gouraud);
    EXPECT_EQ(o.samples, 16u);
    EXPECT_EQ(*o.encoding, Encoding::linear);
    EXPECT_EQ(o.background->rgb, (std::array<uint8_t, 3>{0x12, 0xab, 0}));
    EXPECT_EQ(o.aovs, (std::vector<Plane>{kPlaneDepth, kPlaneObject, kPlaneColour}));
    EXPECT_EQ(o.bits, 16);
    EXPECT_EQ(*o.eye, glm::dvec3(-1, 2.5, 300));
    EXPECT_EQ(*o.up, glm::dvec3(0, 0, -1));
    EXPECT_EQ(*o.fovDegrees, 30);
    EXPECT_EQ(*o.near, 0.5);
    EXPECT_EQ(o.device, "lavapipe");
    EXPECT_EQ(o.requireDevice, "software");
    EXPECT_EQ(o.threads, 3u);
    EXPECT_TRUE(o.noClobber && o.json && o.withError && o.explain && o.strict && o.allowOutside);
    EXPECT_EQ(o.trade, (Trade{.specular = Trade::Specular::schlick, .depthBits = 16, .subpixelBits = 4}));
    EXPECT_EQ(o.traded, (std::vector<const TradeAxis*>{tradeAxis("specular"), tradeAxis("depth"), tradeAxis("subpixel")}));
    EXPECT_EQ(*o.failBlank, 0.02);
    EXPECT_EQ(o.jsonFile, "r.json");
    EXPECT_EQ(o.progress, ProgressMode::json);
    EXPECT_EQ(o.creaseDegrees, 12);
    EXPECT_EQ(o.memoryBytes, uint64_t(2) << 30);
    EXPECT_EQ(o.limitChunk, 7u);
    EXPECT_EQ(o.limitBand, 9u);
    EXPECT_EQ(o.watchdogMs, 500);
    EXPECT_EQ(o.verbose, 2u);
}

TEST(Options, AreTheSameInAnyOrder) {
    for (const char* line : {"render a.obj --json -o x.png --size 8x9 -v", "--size 8x9 -v --json -o x.png render a.obj",
                             "-o x.png render --size=8x9 --json a.obj -v", "-v --json render -ox.png --size 8x9 -- a.obj"}) {
        const Options o = parse(line);
        EXPECT_EQ(o.command, kRender) << line;
        EXPECT_EQ(o.inputs, std::vector<std::string>{"a.obj"}) << line;
        EXPECT_EQ(o.output, "x.png") << line;
        EXPECT_EQ(*o.size, glm::uvec2(8, 9)) << line;
        EXPECT_TRUE(o.json && o.jsonFile.empty()) << line;
        EXPECT_EQ(o.verbose, 1u) << line;
    }
}

TEST(Options, AreAccepted) {
    for (const char* line :
         {"render a.obj -o -",
          "render a.obj -o - --json=x.json",
          "render a.glb --camera 2 --fov 30 -o x.png",
          "render a.obj --json -o x.png",
          "render a.obj --view front --view -30,20 -o x.png",
          "render a.obj --turntable 12 -o s_{n}.png --view iso",
          "render a.obj --background transparent -o a.png",
          "render a.obj --fail-blank -o a.png",
          "render a.obj --up 0,0,1 -o a.png",
          "render a.obj --explain",
          "verify a.toml b.obj --json -o d/x.png",
          "devices --require-device gpu",
          "devices",
          "info a.obj --json",
          "help",
          "help render",
          "help --man",
          "help --completion fish",
          "--version",
          "--help",
          "render --help",
          "render a.obj -o a.png --memory 1048576",
          "render a.obj -o a.png --size 65536x1",
          "diff a.png b.png --gate max<=2/255 --gate flip<=0.02 --radius 1 --ppd 30 --plane color,depth --heat h.png -o d.png --json"})
        EXPECT_NO_THROW(parse(line)) << line;
}

TEST(Options, AreRefusedWithAReason) {
    const struct {
        const char* line;
        const char* says;
    } rows[] = {
        {"", "a command is missing"},
        {"rendr a.obj", "did you mean 'render'?"},
        {"a.obj", "is not a command"},
        {"render a.glb --camera wide --view iso -o x.png", "--camera and --view, --eye or --at exclude each other"},
        {"render a.glb --camera wide --eye 0,0,9 -o x.png", "--camera and --view, --eye or --at exclude each other"},
        {"measure a.toml -o a.png", "accepted: a path that ends in .html"},
        {"diff a", "needs two pictures, and 1 are given"},
        {"diff a b c", "needs two pictures"},
        {"diff a b -o x.exr", "accepted: a path that ends in .png"},
        {"diff a b --radius 99", "0 to 16"},
        {"diff a b --plane ,", "--plane"},
        {"diff a b --heat x.exr", "--heat"},
        {"diff a b --size 3x3", "--size is not a flag of `plumb diff`"},
        {"render a.obj -o a.png --gate max<=1", "--gate is not a flag of `plumb render`"},
        {"plan", "`plumb plan` needs"},
        {"stress x --time 1s", "--time is not a flag of `plumb stress`"},
        {"stress x --shading wire --error 2", "a wire frame has no truth"},
        {"stress x --error 2:mean", "'mean' is no metric"},
        {"render x -o a.png --error 2:mean", "'mean' is no metric"},
        {"render x -o a.png --error=-1", "'-1' is no number of steps"},
        {"render x -o a.png --error nan", "'nan' is no number of steps"},
        {"render x -o a.png --error 2:wrong", "'2' is no share"},
        {"render x -o a.png --error 2:max,3:max", "max has a limit already"},
        {"render x -o a.png --error 2 --error 1:max", "max has a limit already"},
        {"render x -o a.png --time 0ms", "at least 1ms"},
        {"render x -o a.png --check-time 1s", "--check-time goes with --error"},
        {"plan x --error 2 --shading wire", "a wire frame has no truth"},
        {"render x -o a.png --error 2 --stereo anaglyph", "the truth is that of one eye"},
        {"bench", "needs raster|passes|matrix|claims|trace|plan"},
        {"render a.toml -o a.png --sampling middle", "accepted: grid, centre, random, corners, adaptive, notes"},
        {"render a.toml -o a.png --jitter reflect=0.6", "--jitter"},
        {"render a.toml -o a.png --jitter reflect", "reflect=X, refract=X, shadow=X"},
        {"render a.toml -o a.png --jitter reflect=0.1,reflect=0.2", "--jitter"},
        {"render a.toml -o a.png --seed -1", "--seed"},
        {"render a.toml -o a.png --levels half", "accepted: exact, cut"},
        {"stress", "`plumb stress` needs"},
        {"matrix", "needs STEP...|SCENE"},
        {"view x", "not in this version"},
        {"merge x", "not in this version"},
        {"worker", "not in this version"},
        {"report x", "not in this version"},
        {"render", "needs SCENE|MESH..."},
        {"info", "needs"},
        {"devices x", "takes no operand"},
        {"devices --compare a.json", "needs two fingerprints, and 1 are given"},
        {"devices --compare a.json b.json --fingerprint", "exclude each other"},
        {"devices --all-floats", "--all-floats goes with --fingerprint"},
        {"devices -o a.html", "--output goes with --fingerprint"},
        {"devices --fingerprint -o a.png", "accepted: a path that ends in .html"},
        {"help nothing", "is not a command"},
        {"help render verify", "one command"},
        {"render a.obj --sise 3x3", "unknown flag '--sise'; did you mean '--size'?"},
        {"render a.obj -z", "unknown flag '-z'"},
        {"render a.obj --size", "--size: a value is missing"},
        {"render a.obj --size=", "--size: a value is missing"},
        {"render a.obj --size 640", "--size: '640' is refused; accepted: WIDTHxHEIGHT"},
        {"render a.obj --size 0x4", "--size"},
        {"render a.obj --size 4x65537", "--size"},
        {"render a.obj --size 4x4x4", "--size"},
        {"render a.obj --size -4x4", "--size"},
        {"render a.obj --size 4.5x4", "--size"},
        {"render a.obj --size 8x8 --size 9x9", "--size is given 2 times"},
        {"render a.obj --shading toon", "--shading: 'toon' is refused; accepted: wire, unlit, flat, gouraud, phong"},
        {"render a.obj --samples 2", "accepted: 1, 4, 16"},
        {"render a.obj --encode gamma", "srgb, linear"},
        {"render a.obj --background red", "#rrggbb"},
        {"render a.obj --background #12345", "#rrggbb"},
        {"render a.obj --background #12345g", "#rrggbb"},
        {"render a.obj --aov depth,gloss", "object_id"},
        {"render a.obj --aov ,", "--aov"},
        {"render a.obj --bits 12", "8, 16"},
        {"render a.obj --eye 1,2", "--eye"},
        {"render a.obj --eye 1,2,nan", "--eye: '1,2,nan' is refused"},
        {"render a.obj --at 1,2,inf", "--at"},
        {"render a.obj --up 0,0,0", "--up"},
        {"render a.obj --up +W", "--up"},
        {"render a.obj --fov 180", "--fov"},
        {"render a.obj --near 0", "--near"},
        {"render a.obj --view behind", "--view"},
        {"render a.obj --view 0,91", "--view"},
        {"render a.obj --turntable 0", "--turntable"},
        {"render a.obj --threads x", "--threads"},
        {"render a.obj --memory 12", "--memory"},
        {"render a.obj --memory 1T", "--memory"},
        {"render a.obj --memory 99999999999G", "--memory"},
        {"render a.obj --watchdog 0", "--watchdog"},
        {"render a.obj --crease 200", "--crease"},
        {"render a.obj --fail-blank=101%", "--fail-blank"},
        {"render a.obj --trade shading=flat",
         "--trade: 'shading=flat' is refused; accepted: AXIS=CHOICE by commas: specular=exact|schlick|native"},
        {"render a.obj --trade depth", "--trade"},
        {"render a.obj --trade depth=15", "'depth=15' is refused; accepted for depth: reversed-32, standard-32, "},
        {"render a.obj --trade depth=16,depth=24", "--trade"},
        {"render a.obj --trade depth=16 --trade depth=16", "--trade"},
        {"render a.obj --progress loud", "auto, bar, plain, json, none"},
        {"render a.obj --strict=yes", "--strict takes no value"},
        {"render a.obj -q -v", "exclude each other"},
        {"render a.obj --view front --eye 0,0,1", "exclude each other"},
        {"render a.obj --turntable 3 --view front --view iso", "--view once"},
        {"render a.obj -o - --json", "standard output"},
        {"info a.obj --size 3x3", "--size is not a flag of `plumb info`"},
        {"devices --threads 1", "--threads is not a flag of `plumb devices`"},
        {"help --completion tcsh", "bash, zsh, fish"},
    };
    for (const auto& row : rows) {
        try {
            parse(row.line);
            ADD_FAILURE() << "accepted: " << row.line;
        } catch (const Error& e) {
            EXPECT_EQ(e.exit(), Exit::usage) << row.line;
            EXPECT_NE(std::string(e.what()).find(row.says), std::string::npos) << row.line << "\n  says: " << e.what();
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "one line";
        }
    }
}

// The value that a command line gives is that of the word, and help and completions know the word.
template <class Rows, class ValueOf>
void expectEveryWord(const char* flag, const Rows& rows, const ValueOf& valueOf) {
    const std::string help = helpText(kRender);
    for (const auto& row : rows) {
        SCOPED_TRACE(fmt::format("{} {}", flag, row.word));
        EXPECT_EQ(valueOf(parse(fmt::format("render a.toml -o a.exr {} {}", flag, row.word))), row.value);
        EXPECT_NE(help.find(row.word, help.find(fmt::format(" {} ", flag))), std::string::npos);
        for (const Flag& known : flags()) {
            if (known.longName() != flag) continue;
            EXPECT_EQ(std::count(known.words.begin(), known.words.end(), row.word), 1);
            EXPECT_NE(known.accepted.find(row.word), std::string::npos);
        }
    }
}

TEST(Options, TakeEveryWordOfEveryChoice) {
    expectEveryWord("--shading", kShadings, [](const Options& o) { return *o.shading; });
    expectEveryWord("--wire", kWireViews, [](const Options& o) { return *o.wire; });
    expectEveryWord("--edges", kEdgeCounts, [](const Options& o) { return *o.wirePerPolygon; });
    expectEveryWord("--fill", kFills, [](const Options& o) { return *o.fill; });
    expectEveryWord("--viewer", kViewers, [](const Options& o) { return *o.distantViewer; });
    expectEveryWord("--encode", kEncodings, [](const Options& o) { return *o.encoding; });
    expectEveryWord("--samples", kSampleCounts, [](const Options& o) { return o.samples; });
    expectEveryWord("--sampling", kSamplings, [](const Options& o) { return *o.sampling; });
    expectEveryWord("--levels", kLevelForms, [](const Options& o) { return *o.cutLevels; });
    expectEveryWord("--aov", kAovs, [](const Options& o) { return o.aovs.at(0); });
}

TEST(Options, TakeEveryWordOfEveryTrade) {
    const std::string help = helpText(kRender);
    const auto flag = std::find_if(flags().begin(), flags().end(), [](const Flag& f) { return f.longName() == "--trade"; });
    for (const TradeAxis& axis : kTradeAxes)
        for (const TradeChoice& choice : axis.choices) {
            const std::string word = fmt::format("{}={}", axis.name, choice.word);
            const Options o = parse("render a.obj --trade " + word);
            EXPECT_EQ(&axis.chosen(o.trade), &choice) << word;
            EXPECT_EQ(o.traded, std::vector<const TradeAxis*>{&axis}) << word;
            Trade wanted;
            choice.choose(wanted);
            EXPECT_EQ(o.trade, wanted) << word << " moves nothing else";
            EXPECT_NE(help.find(choice.word, help.find(axis.name)), std::string::npos) << word;
            EXPECT_EQ(std::count(flag->words.begin(), flag->words.end(), word), &choice != &axis.choices[0])
                << word << ": the default is not completed";
        }
}

TEST(Options, PrintNoControlCharacters) {
    try {
        parseOptions({"render", "a.obj", "--shading", "\x1b[31m"});
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).find('\x1b'), std::string::npos) << e.what();
    }
    try {
        parseOptions({"render", "a.obj", "--trade", "depth=\x1b[31m"});
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).find('\x1b'), std::string::npos) << e.what();
    }
}

TEST(Help, NamesEveryFlagAndThreeExamples) {
    for (const CommandRow& row : commands()) {
        const std::string text = helpText(row.bit),
                          list = text.substr(text.find("\nflags:"), text.find("\nexamples:") - text.find("\nflags:"));
        for (const Flag& flag : flags()) {
            const size_t at = list.find(flag.longName() + (flag.optionalValue() ? "["
                                                           : flag.isSwitch()    ? " "
                                                                                : fmt::format(" {}", flag.argument)));
            const bool listed = at != std::string::npos;
            EXPECT_EQ(listed, (flag.commands & row.bit) != 0 && !flag.hidden) << row.name << " " << flag.longName();
        }
        for (const auto& [line, what] : row.examples) {
            EXPECT_NE(text.find(line), std::string::npos);
            EXPECT_NE(what[0], '\0');
        }
    }
}

TEST(Help, HasExamplesThatParse) {
    for (const CommandRow& row : commands())
        for (const auto& [line, what] : row.examples) {
            std::string text = line;
            text = text.substr(0, text.find(" |"));
            text = text.substr(0, text.find(" >"));
            EXPECT_NO_THROW(parse(text.substr(text.find(' ') + 1))) << line;
        }
}

TEST(ManPageAndCompletions, NameEveryFlag) {
    const std::string man = manPage();
    for (const Flag& flag : flags()) {
        if (flag.hidden) continue;
        std::string escaped;
        for (const char c : flag.longName()) escaped += c == '-' ? std::string("\\-") : std::string(1, c);
        EXPECT_NE(man.find(escaped), std::string::npos) << flag.longName();
        EXPECT_NE(completionScript("bash").find(flag.longName()), std::string::npos) << flag.longName();
        EXPECT_NE(completionScript("zsh").find(flag.longName()), std::string::npos) << flag.longName();
        EXPECT_NE(completionScript("fish").find("-l " + flag.longName().substr(2)), std::string::npos) << flag.longName();
    }
}

TEST(Progress, TellsTheTimeLeft) {
    EXPECT_EQ(Progress::secondsLeft(0, 10), std::nullopt);
    EXPECT_EQ(Progress::secondsLeft(0.5, 0.1), std::nullopt) << "too early to say";
    EXPECT_EQ(Progress::secondsLeft(0.5, 62), 62);
    EXPECT_EQ(Progress::clock(62), "1:02");
    EXPECT_EQ(Progress::clock(9000), "2:30:00");
}

// What is shown while `use` runs.
template <class Use>
std::string shownBy(ProgressMode mode, bool quiet, const Use& use) {
    char* data = nullptr;
    size_t size = 0;
    std::FILE* stream = ::open_memstream(&data, &size);
    {
        Progress progress(mode, quiet, stream);
        use(progress);
    }
    std::fclose(stream);
    std::string text(data, size);
    std::free(data);
    // How long it takes is nothing that a test may judge.
    return std::regex_replace(text, std::regex(", [0-9:]+ (elapsed|left)"), ", T $1");
}

TEST(Progress, WritesJsonLinesAndNothingWhenQuiet) {
    const auto shown = [](ProgressMode mode, bool quiet) {
        return shownBy(mode, quiet, [](Progress& progress) {
            progress.begin("render");
            progress.update(1);
        });
    };
    const std::string json = shown(ProgressMode::json, false);
    EXPECT_EQ(json.substr(0, 36), "{\"progress\":0.0000,\"task\":\"render\",\"");
    EXPECT_NE(json.find("\"left_s\":null"), std::string::npos) << json;
    EXPECT_EQ(shown(ProgressMode::plain, false), "render: 0 %\nrender: 100 %, T elapsed\n");
    EXPECT_EQ(shown(ProgressMode::plain, true), "");
    EXPECT_EQ(shown(ProgressMode::none, false), "");
}

// A list of pictures is one whole: its share grows from picture to picture, and ends once.
TEST(Progress, CountsAListAsOneWhole) {
    const auto list = [](Progress& progress) {
        for (int i = 0; i < 4; ++i) {
            progress.begin(fmt::format("render {}/4", i + 1), i / 4.0, (i + 1) / 4.0);
            progress.update(0.5);
            progress.update(1);
        }
    };
    EXPECT_EQ(shownBy(ProgressMode::plain, false, list),
              "render 1/4: 0 %\nrender 1/4: 10 %, T elapsed\nrender 1/4: 20 %, T elapsed\nrender 2/4: 30 %, T elapsed\nrender 2/4: 50 %, T "
              "elapsed\n"
              "render 3/4: 60 %, T elapsed\nrender 3/4: 70 %, T elapsed\nrender 4/4: 80 %, T elapsed\nrender 4/4: 100 %, T elapsed\n");
    const std::string json = shownBy(ProgressMode::json, false, list);
    EXPECT_EQ(json.find("\"progress\":1.0000,\"task\":\"render 4/4\""), json.rfind("\"progress\":1.0000"));
    EXPECT_NE(json.find("\"progress\":1.0000"), std::string::npos) << json;
    EXPECT_NE(shownBy(ProgressMode::bar, false, list).find("render 4/4 [##############################] 100 %"), std::string::npos);
}

TEST(Progress, NeverFalls) {
    EXPECT_EQ(shownBy(ProgressMode::plain, false,
                      [](Progress& progress) {
                          progress.begin("render");
                          for (const double fraction : {0.5, 0.1, 0.6}) progress.update(fraction);
                      }),
              "render: 0 %\nrender: 50 %, T elapsed\nrender: 60 %, T elapsed\n");
}

TEST(Progress, AStreamThatCannotBeWrittenIsNoFailure) {
    std::FILE* full = std::fopen("/dev/full", "w");
    ASSERT_NE(full, nullptr);
    for (const ProgressMode mode : {ProgressMode::bar, ProgressMode::plain, ProgressMode::json}) {
        Progress progress(mode, false, full);
        progress.begin("render");
        EXPECT_NO_THROW(progress.update(1));
    }
    std::fclose(full);
}

}  // namespace
}  // namespace plumb
