#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Reads every #include of the tree and fails on an arrow against the order in which data flows.

The order (a room may include itself and what stands before it):

    shaders/shared < host < transform < choices < scene < detail < passes < render < truth < pixel, measure, bench, fingerprint, image < planner < stress, suite < library, compare, report < cli < command < tests

Two places differ from the order that a reader might expect. The plan is made in render/, because it is made of the passes that
render/ strings together. cli/ stands late and may include choices/ and scene/ only: it turns words into a request and knows nothing of passes;
command/ ties all rooms together and is included by none.

usage: check_rooms.py [ROOT]             exit 0: clean; 1: one line for each fault on stdout
       check_rooms.py --self-test        exit 1 when a forbidden arrow or an old table goes unnoticed
       check_rooms.py --table            prints the rooms as a Markdown table
       check_rooms.py --table FILE       exit 1 when the table of FILE is another one
       check_rooms.py --table --fix FILE writes the table into FILE
"""
import fnmatch
import os
import re
import sys
import tempfile

# room -> (the question it answers, folders or files of the project it may include, third-party headers it may include)
ROOMS = {
    "shaders/shared": ("what defines a result: the contract of each pass, one text for glslang and C++",
        ["shaders/shared"], []),
    "shaders": ("what the device runs: one `.comp` a kernel, `.glsl` for the text of several",
        ["shaders/shared", "shaders/*.glsl"], []),  # .glsl: text of several kernels that C++ never reads
    "host": ("how to talk to Vulkan; the only room that includes it; knows no triangle and no pixel",
        ["host", "shaders/shared/status.h", "shaders/shared/exact.h", "shaders/shared/selftest.h", "spirv"], ["vulkan", "fmt"]),
    "pipeline/transform": ("matrices in binary64, their steps and chains; knows no file and no pass",
        ["pipeline/transform"], ["glm", "fmt"]),
    "pipeline/choices": ("what may be chosen of a picture: a row a word, with its value, help, verdict and bound; knows no scene and no pass",
        ["pipeline/choices", "host/error.h"], ["fmt"]),
    "pipeline/scene": ("what is to be drawn: readers of files, meshes, materials, lights, cameras",
        ["pipeline/scene", "pipeline/choices", "pipeline/transform", "host/error.h"], ["glm", "fmt", "json", "toml"]),
    "pipeline/detail": ("a scene with as many triangles as a camera can tell: meshes simplified within a proved deviation; knows no pass",
        ["pipeline/detail", "pipeline/scene", "pipeline/transform", "pipeline/choices", "pipeline/passes/parallel.h", "host/error.h"], ["glm", "fmt", "meshoptimizer"]),
    "pipeline/passes": ("one step of a picture: its CPU twin and the recorder of its kernel",
        ["pipeline/passes", "pipeline/scene", "pipeline/choices", "pipeline/transform", "host", "shaders/shared", "spirv"], ["glm", "fmt"]),
    "pipeline/render": ("the plan of a picture, and the passes strung together, on the device and by the twin",
        ["pipeline/render", "pipeline/passes", "pipeline/scene", "pipeline/choices", "pipeline/transform", "host", "shaders/shared", "spirv"],
        ["glm", "fmt"]),
    # Shares no function with the passes: of render/ it reads types only.
    "pipeline/truth": ("the picture in binary64, by code that shares no function with the passes",
        ["pipeline/truth", "pipeline/scene", "pipeline/render/render.h", "pipeline/render/frame.h", "host/error.h"], ["glm", "fmt"]),
    "pipeline/pixel": ("one pixel opened: the chain of the lecture notes, as each side has it",
        ["pipeline/pixel", "pipeline/truth", "pipeline/render", "pipeline/passes", "pipeline/scene", "pipeline/choices", "pipeline/transform", "host", "shaders/shared"],
        ["glm", "fmt"]),
    "pipeline/measure": ("error, bounds and times of every choice against one truth",
        ["pipeline/measure", "pipeline/detail", "pipeline/truth", "pipeline/render", "pipeline/scene", "pipeline/choices", "host/error.h"], ["glm", "fmt"]),
    "pipeline/planner": ("which choices a budget of error or time needs: counted work, probes, and the check of the finished picture",
        ["pipeline/planner", "pipeline/measure", "pipeline/truth", "pipeline/render", "pipeline/scene", "pipeline/choices", "host/cache.h", "host/error.h"],
        ["glm", "fmt"]),
    "pipeline/stress": ("how far a scene can be driven along extremes before its picture is wrong",
        ["pipeline/stress", "pipeline/planner/check.h", "pipeline/truth", "pipeline/render", "pipeline/scene", "pipeline/choices", "host/error.h"], ["glm", "fmt"]),
    "pipeline/image": ("a picture as a file: PNG, EXR, NPY, eyes side by side, inks",
        ["pipeline/image", "pipeline/render", "pipeline/scene", "pipeline/passes/parallel.h", "host/error.h"], ["png", "zlib", "exr", "glm", "fmt"]),
    "pipeline/library": ("the library's front door: a renderer that chooses and falls back, a picture that saves itself, a scene from a file",
        ["pipeline/library", "pipeline/image", "pipeline/render", "pipeline/scene", "pipeline/choices", "host/device.h", "host/error.h"], ["glm", "fmt"]),
    "pipeline/compare": ("two pictures from files: every measure, gates, heat map",
        ["pipeline/compare", "pipeline/image", "pipeline/render/frame.h", "pipeline/passes/parallel.h", "pipeline/scene", "host/error.h"],
        ["png", "exr", "fmt"]),
    "pipeline/report": ("a measurement as one HTML file",
        ["pipeline/report", "pipeline/image", "host/error.h"], ["json"]),
    "pipeline/cli": ("the words of the command line as a request; knows no pass",
        ["pipeline/cli", "pipeline/scene", "pipeline/choices", "host/error.h"], ["cli", "glm", "fmt"]),
    "pipeline/bench": ("the passes against other programs, and the claims of the lecture notes",
        ["pipeline/bench", "pipeline/render", "pipeline/passes", "pipeline/scene", "pipeline/choices", "pipeline/transform", "host", "shaders/shared", "spirv", "bench_spirv"],
        ["glm", "fmt", "eigen", "embree"]),
    "pipeline/fingerprint": ("what a device does with numbers: questions, exact answers, what two devices do differently",
        ["pipeline/fingerprint", "pipeline/passes/parallel.h", "pipeline/scene/sha256.h", "host", "shaders/shared", "spirv"], ["glm", "fmt", "json"]),
    "pipeline/suite": ("built-in scenes that run every module, and what a device did wrong made small and kept as files",
        ["pipeline/suite", "pipeline/bench", "pipeline/fingerprint", "pipeline/render", "pipeline/passes", "pipeline/scene", "pipeline/choices", "host", "shaders/shared", "spirv"],
        ["glm", "fmt", "json"]),
    "pipeline/command": ("the commands; ties all rooms together and is included by none",
        ["pipeline", "host"], ["cli", "glm", "fmt", "json"]),
    "examples": ("the library from outside, through the installed headers only",
        ["plumbline"], ["glm"]),
    "tests": ("what is true of all of it, by kind: unit, twin, oracle, golden, frame, stress, fault, fuzz, lint, browser",
        ["host", "pipeline", "shaders", "tests", "spirv", "oracle_spirv"],
        ["vulkan", "cli", "glm", "fmt", "json", "toml", "png", "zlib", "exr", "gtest"]),
    "toolchain": ("the scripts that set up, build, test, measure and check",
        ["toolchain"], []),  # nothing includes it, and it includes nothing of the product
}

THIRD_PARTY = {
    "vulkan": r"volk\.[hc]$|vulkan/|vk_",
    "fmt": r"fmt/",
    "glm": r"glm/",
    "json": r"nlohmann/",
    "toml": r"toml\+\+/|toml\.hpp$",
    "png": r"png\.h$",
    "zlib": r"zlib\.h$",
    "exr": r"OpenEXR/|Imath|Imf|half\.h$",
    "cli": r"CLI/",
    "meshoptimizer": r"meshoptimizer\.h$",
    "eigen": r"Eigen/",
    "embree": r"embree3/",
    "gtest": r"gtest/|gmock/",
}
# C and POSIX headers; headers of the C++ library have neither a dot nor a slash.
SYSTEM = re.compile(r"(?:(?:std|sys/|linux/|asm/|arpa/|netinet/)\w*|fcntl|unistd|errno|signal|poll|dirent|dlfcn|pthread|sched|"
                    r"limits|math|string|time|termios|locale|fenv|setjmp|ctype|fnmatch|glob|getopt|spawn|cpuid|\w*intrin)\.h$")
SOURCE = (".h", ".hpp", ".cpp", ".c", ".cc", ".comp", ".vert", ".frag", ".glsl")
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)
CONDITIONAL = re.compile(r"^[ \t]*#[ \t]*(if|ifdef|ifndef|elif|else|endif)\b[ \t]*([^\n]*)", re.M)


def room_of(path):
    for room in sorted(ROOMS, key=len, reverse=True):
        if path.startswith(room + "/"):
            return room
    return None


def sources(root):
    for top in ("shaders", "host", "pipeline", "examples", "tests", "toolchain"):
        for folder, folders, files in os.walk(os.path.join(root, top)):
            folders.sort()
            for name in sorted(files):
                if name.endswith(SOURCE):
                    yield os.path.relpath(os.path.join(folder, name), root)


def resolve(root, path, bracket, name):
    """Path in the project that an include means; None when it names something outside."""
    if name.startswith(("spirv/", "oracle_spirv/", "bench_spirv/")):
        return name  # generated by the build
    beside = os.path.normpath(os.path.join(os.path.dirname(path), name))
    if bracket == '"' and os.path.isfile(os.path.join(root, beside)):
        return beside
    for base in ("", "shaders"):
        inside = os.path.normpath(os.path.join(base, name))
        if os.path.isfile(os.path.join(root, inside)) and not inside.startswith(".."):
            return inside
    return None


def allowed(entry, target):
    return target == entry or target.startswith(entry + "/") or ("*" in entry and fnmatch.fnmatch(target, entry))


def check_shared_conditionals(path, text):
    """bridge.h is where GLSL and C++ differ. Elsewhere in shaders/shared: the include guard, and `#ifndef __cplusplus` blocks that declare
    what C++ has no words for (a `layout(...)`), with no #else: such a block cannot hold a second version of anything."""
    depth, block, faults = [], None, []
    for m in CONDITIONAL.finditer(text):
        line = text.count("\n", 0, m.start()) + 1
        word, rest = m.group(1), m.group(2).strip()
        if word in ("if", "ifdef", "ifndef"):
            guard = not depth and word == "ifndef" and re.match(r"PLUMB_\w+_H$", rest)
            device_only = word == "ifndef" and rest == "__cplusplus"
            if not guard and not device_only:
                faults.append(f"{path}:{line}: #{word} {rest}: in shaders/shared only bridge.h may differ between the languages")
            depth.append("device" if device_only else "guard")
            if device_only:
                block = m.end()
        elif word == "endif":
            if depth and depth.pop() == "device" and "layout(" not in text[block:m.start()]:
                faults.append(f"{path}:{line}: this __cplusplus block declares no layout(...): its text belongs to both languages")
        else:
            faults.append(f"{path}:{line}: #{word}: a second version belongs into bridge.h")
    return faults


def strip_comments(text):
    blank = lambda m: re.sub(r"[^\n]", " ", m.group(0))
    return re.sub(r"//[^\n]*|/\*.*?\*/", blank, text, flags=re.S)


def check(root):
    faults, arrows, third_party = [], {}, {}
    for path in sources(root):
        with open(os.path.join(root, path), encoding="utf-8") as f:
            text = strip_comments(f.read())
        room = room_of(path)
        arrows[path], third_party[path] = [], set()
        if room is None:
            continue
        _, inside, outside = ROOMS[room]
        for m in INCLUDE.finditer(text):
            bracket, name = m.groups()
            place = f"{path}:{text.count(chr(10), 0, m.start()) + 1}"
            target = resolve(root, path, bracket, name)
            if target is not None:
                arrows[path].append(target)
                if not any(allowed(entry, target) for entry in inside):
                    faults.append(f"{place}: {room} may not include {target}")
                continue
            kind = next((k for k, pattern in THIRD_PARTY.items() if re.match(pattern, name)), None)
            if path == "shaders/shared/bridge.h" and (kind == "glm" or re.match(r"\w+$", name)):
                continue
            if kind is not None:
                third_party[path].add(kind)
                if kind not in outside:
                    faults.append(f"{place}: {room} may not include <{name}>")
            elif re.match(r"plumbline/", name) and "plumbline" in inside:
                continue
            elif bracket == '"':
                faults.append(f"{place}: \"{name}\" is no file of the project")
            elif room.startswith("shaders") or not (re.match(r"\w+$", name) or SYSTEM.match(name)):
                faults.append(f"{place}: {room} may not include <{name}>")
        if room == "shaders/shared" and path != "shaders/shared/bridge.h":
            faults += check_shared_conditionals(path, text)
    # Two things that no single line shows: Vulkan seen through another header, and a circle.
    state = {}

    def visit(path, trail):
        if path in trail:
            faults.append("circle: " + " -> ".join(trail[trail.index(path):] + [path]))
            return set()
        if path not in state:
            seen = {path} if "vulkan" in third_party.get(path, ()) else set()
            for target in arrows.get(path, ()):
                seen |= visit(target, trail + [path])
            state[path] = seen
        return state[path]

    for path in arrows:
        through = visit(path, [])
        if through and room_of(path) not in ("host", "tests") and path not in through:
            faults.append(f"{path}: sees Vulkan through {sorted(through)[0]}; no Vulkan type leaves host/")
    return len(arrows), faults


def table():
    """The rooms in the order of data, as Markdown. A room may include itself, so that is left out."""
    code = lambda words: ", ".join(f"`{word}`" for word in words) or "–"
    lines = ["| room | answers | may include | libraries |", "|---|---|---|---|"]
    for room, (answers, inside, outside) in ROOMS.items():
        lines.append(f"| `{room}` | {answers} | {code(entry for entry in inside if entry != room)} | {', '.join(outside) or '–'} |")
    return "\n".join(lines) + "\n"


def with_table(text):
    """(text with the table of the rooms in place of its own, number of tables that it had)."""
    return re.subn(r"^\| room \|[^\n]*\n(?:\|[^\n]*\n)*", lambda m: table(), text, flags=re.M)


def check_table(path, fix):
    with open(path, encoding="utf-8") as f:
        text = f.read()
    wanted, count = with_table(text)
    if count != 1:
        print(f"{path}: has {count} tables that begin with \"| room |\"; one is wanted")
        return 1
    if wanted != text and fix:
        with open(path, "w", encoding="utf-8") as f:
            f.write(wanted)
    elif wanted != text:
        print(f"{path}: its table of rooms is not that of check_rooms.py; write it with: toolchain/check_rooms.py --table --fix {os.path.relpath(path)}")
        return 1
    return 0


def self_test():
    clean = {
        "shaders/shared/bridge.h": "#ifdef __cplusplus\n#include <glm/glm.hpp>\n#else\n#endif\n",
        "shaders/shared/a.h": "#ifndef PLUMB_A_H\n#define PLUMB_A_H\n#include \"bridge.h\"\n#ifndef __cplusplus\nlayout(binding = 0) x;\n#endif\n#endif\n",
        "shaders/a.comp": "#include \"shared/a.h\"\n",
        "host/open.h": "#include <string>\n",
        "host/impl.h": "#include \"volk.h\"\n",
        "host/open.cpp": "#include \"host/open.h\"\n#include \"host/impl.h\"\n#include <sys/stat.h>\n",
        "pipeline/scene/s.h": "#include <glm/glm.hpp>\n",
        "pipeline/passes/p.h": "#include \"host/open.h\"\n#include \"shared/a.h\"\n#include \"pipeline/scene/s.h\"\n",
        "pipeline/command/main.cpp": "#include \"pipeline/passes/p.h\"\n",
        "tests/unit/t.cpp": "#include <gtest/gtest.h>\n#include \"host/impl.h\"\n",
    }
    forbidden = {
        "shared text reads a room": ("shaders/shared/a.h", "#include \"host/open.h\"\n"),
        "shared text reads the C++ library": ("shaders/shared/a.h", "#include <cmath>\n"),
        "shared text differs by language": ("shaders/shared/a.h", "#ifdef __cplusplus\n#endif\n"),
        "shared text has a second version": ("shaders/shared/a.h", "#ifndef __cplusplus\nlayout(x) y;\n#else\n#endif\n"),
        "a device block hides common text": ("shaders/shared/a.h", "#ifndef __cplusplus\nint f() { return 1; }\n#endif\n"),
        "a shader reads a room": ("shaders/a.comp", "#include \"../host/open.h\"\n"),
        "host knows a scene": ("host/open.cpp", "#include \"pipeline/scene/s.h\"\n"),
        "host knows a pass": ("host/open.cpp", "#include \"shared/a.h\"\n"),
        "scene knows a pass": ("pipeline/scene/s.h", "#include \"pipeline/passes/p.h\"\n"),
        "a pass knows the command": ("pipeline/passes/p.h", "#include \"pipeline/command/main.cpp\"\n"),
        "a pass includes Vulkan": ("pipeline/passes/p.h", "#include <vulkan/vulkan.h>\n"),
        "a pass sees Vulkan through a header": ("pipeline/passes/p.h", "#include \"host/impl.h\"\n"),
        "the product includes a test": ("pipeline/command/main.cpp", "#include \"tests/unit/t.cpp\"\n"),
        "the product includes the toolchain": ("pipeline/command/main.cpp", "#include \"toolchain/x.h\"\n"),
        "a library outside the room's list": ("pipeline/scene/s.h", "#include <png.h>\n"),
        "an include that is no file": ("host/open.cpp", "#include \"host/nothing.h\"\n"),
        "a circle": ("host/impl.h", "#include \"host/impl.h\"\n"),
    }
    missed = []
    for claim, (path, line) in [("clean", (None, ""))] + list(forbidden.items()):
        with tempfile.TemporaryDirectory() as root:
            for name, text in clean.items():
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                if name == path:
                    text = text.replace("#endif\n", line + "#endif\n") if path.startswith("shaders/shared") else text + line
                with open(os.path.join(root, name), "w", encoding="utf-8") as f:
                    f.write(text)
            faults = check(root)[1]
            if bool(faults) != (path is not None):
                missed.append(f"{claim}: {faults or 'unnoticed'}")
    page = "# Page\n\n" + table() + "\nText.\n"
    if with_table(page) != (page, 1):
        missed.append("table: the printed one is not left as it is")
    for claim, old in [("a room is missing", re.sub(r"\| `host`.*\n", "", page)), ("another answer", page.replace("Vulkan", "OpenGL", 1))]:
        if old == page or with_table(old) != (page, 1):
            missed.append(f"table: {claim}: unnoticed")
    for line in missed:
        print(line)
    print(f"check_rooms --self-test: {len(forbidden)} forbidden arrows, {len(missed)} wrong answers")
    return 1 if missed else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if sys.argv[1:] == ["--table"]:
        print(table(), end="")
        return 0
    if sys.argv[1:2] == ["--table"]:
        return check_table(sys.argv[-1], "--fix" in sys.argv[2:-1])
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    count, faults = check(root)
    for fault in faults:
        print(fault)
    if count == 0:
        print("no sources under " + root)
    print(f"check_rooms: {count} files, {len(faults)} forbidden arrows")
    return 1 if faults or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
