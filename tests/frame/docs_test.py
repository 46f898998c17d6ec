#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the commands of docs/ whose answer is shown: an sh block, and right behind it a block that is `text`, `json` or of no language. What is shown must be
printed, line behind line; `...` stands for what is left out. Times, devices and versions are masked on both sides. PAGES must show an answer in their first screen.
Every key of the JSON of REPORTS must stand on one of KEYED, and every word that is completed for a flag of WORDED on its line.

usage: docs_test.py PLUMB SOURCE
       docs_test.py --self-test      exit 1 when a changed answer goes unnoticed
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import time

# Pages about a command: an answer that is run stands in their first screen.
PAGES = ("accuracy.md", "budgets.md", "commands.md", "containers.md", "diff.md", "fingerprint.md", "measure.md", "outputs.md", "pixel.md", "rays.md", "scene-format.md", "stress.md", "tests.md", "truth.md")
SCREEN = 40  # lines
ANSWERS = ("", "text", "json")

# What varies with machine, moment or version. The last word of a measured row may be anything that times allow.
VARIES = [
    (r"\d+(?:\.\d+)? (ms|s)\b", r"# \1"),
    (r"llvmpipe \(LLVM [\d.]+, \d+ bits\)", "DEVICE"),
    (r"Mesa [\d.]+[^,]*", "Mesa #"),
    (r"Vulkan \d[\d.]*, [0-9a-f]+", "Vulkan #"),
    (r"memory budget \d+ MiB", "memory budget #"),
    (r"\d+ rounds, load [\d.]+", "# rounds, load #"),
    (r"\(\d+\.\d+ % a row\)", "(# % a row)"),
    # a row of `plumb measure`: its mark, median, ratio, interval and what they tell
    (r"^[*+ ] (\S+ +\S.*?) +\d+\.\d\d +\d+\.\d{3}(?: +[\d.]+ \.\. [\d.a-z]+)?(?: +(?:not told apart|faster|slower))? +(?=\d|no error)", r"  \1  #  "),
    (r"\"(git|cpu_vendor|cpu_model|spirv|uuid|driverInfo|api)\": \"[^\"]*\"", r'"\1": #'),
    (r"\"([\w]*(?:_ms|ms|Ms|bytes|_bytes)|load|device|render|write|total|truth|per_second)\": [\d.]+", r'"\1": #'),
]
# Commands whose --json is asked for its keys, on these pages; what is below a key of NAMES is named by modules, steps or counts.
KEYED = ("outputs.md", "diff.md")
REPORTS = [
    "plumb render scenes/pyramid.toml --with-error -q -o x.png",
    "plumb render scenes/pyramid.toml --stereo pair -q -o 'x{eye}.png'",
    "plumb render scenes/pyramid.toml --fill notes -q -o x.png",
    "plumb render scenes/pyramid.toml --device twin -q -o x.png",
    "plumb render scenes/four-spheres.toml --size 64x48 --sampling adaptive --with-error -q -o x.png",
    "plumb render scenes/suzanne.toml --size 64x48 --device twin --error 40:rms -q -o x.png",
    "plumb plan scenes/four-spheres.toml --size 64x48 --device twin -q",
    "plumb verify scenes/pyramid.toml -q",
    "plumb pixel scenes/pyramid.toml 200,310 --fill exact -q",
    "plumb stress scenes/suzanne.toml --size 160x120 --axis fov -q",
    "plumb diff x.png x.png --gate 'max<=0.1'",
    "plumb measure scenes/suzanne.toml --size 64x48 --axis depth,specular --repetitions 3 -q",
    "plumb devices",
    "plumb devices --fingerprint",
    "plumb info scenes/pyramid.toml",
    "plumb matrix scenes/pyramid.toml",
    "plumb matrix rotate=90:from=3,3,5:to=6,6.46,7 --vertices 100",
    "plumb bench raster sphere1e3 --size 96x64 --repeat 3 -q",
    "plumb bench passes sphere1e3 --size 96x64 --repeat 3 -q",
    "plumb bench claims --repeat 3 -q",
    "plumb bench matrix 1e3 --repeat 3 -q",
    "plumb bench trace spheres4 --size 96x64 --repeat 3 -q",
    "plumb bench plan scenes/suzanne.toml --size 64x48 --repeat 3 -q",
]
NAMES = ("spirv", "work", "passes", "passes_ms", "passesMs", "counts", "over")
# Flag, page, and the beginning of the lines on which its words stand; {} is the axis of AXIS=WORD.
WORDED = [("trade", "measure.md", r"\| `{}` \|"), ("sampling", "rays.md", r"\| `"), ("aov", "outputs.md", r"\| `")] + \
         [(flag, "scene-format.md", f"{key} = ") for flag, key in (("encode", "encoding"), ("shading", "shading"), ("fill", "fill"), ("wire", "wire"), ("edges", "edges"),
                                                                   ("viewer", "viewer"), ("sampling", "sampling"), ("levels", "levels"))]
# Makes a run short without changing what is masked; a busy machine must not cut rows.
SHORTER = {"plumb measure": "--repetitions 11 --limit 600s"}
LEFT_OUT = re.compile(r"^note: load ")  # lines that stand on a busy machine only


def masked(text):
    lines = []
    for line in text.splitlines():
        if LEFT_OUT.match(line):
            continue
        for pattern, instead in VARIES:
            line = re.sub(pattern, instead, line)
        lines.append(re.sub(r"\s+", " ", line).strip())
    return "\n".join(lines)


def answers_of(page):
    """(line, commands, shown text, exit code) of each sh block with an answer right behind it. A remark `# exit 1` states another exit code than 0."""
    blocks, fence, language, begun = [], None, "", 0
    lines = page.splitlines()
    for number, line in enumerate(lines, 1):
        if not line.startswith("```"):
            continue
        if fence is None:
            fence, language, begun = number, line[3:].strip(), number
        else:
            blocks.append((begun, number, language, lines[begun:number - 1]))
            fence = None
    found = []
    for (at, end, kind, commands), (begin, _, answer, shown) in zip(blocks, blocks[1:]):
        between = "".join(lines[end:begin - 1]).strip()
        if kind == "sh" and answer in ANSWERS and not between:
            code = re.search(r"#.*\bexit (?:code )?(\d+)", "\n".join(commands))
            found.append((at, [re.sub(r"\s+#\s.*$", "", c) for c in commands if c.strip() and not c.startswith("#")], "\n".join(shown), int(code.group(1)) if code else 0))
    return found


def not_printed(shown, printed):
    """The first shown part that does not stand behind the one before it; None when all do."""
    printed, at = masked(printed), 0
    for part in re.split(r"\.\.\.", masked(shown)):
        for line in filter(None, (line.strip() for line in part.split("\n"))):
            found = printed.find(line, at)
            if found < 0:
                return line
            at = found + len(line)
    return None


def keys_of(value, named=False):
    if isinstance(value, dict):
        for key, below in value.items():
            if not named:
                yield key
            yield from keys_of(below, key in NAMES)
    elif isinstance(value, list):
        for below in value:
            yield from keys_of(below, False)


def words_missing(flag, begin, page, completions):
    """Words that fish completes for a flag and no line of the page has that begins so. A flag without words is missed as a whole."""
    found = re.search(rf" -l {flag} .*?-a '([^']*)'", completions)
    if not found:
        return [f"--{flag}"]
    missing = []
    for word in found.group(1).split():
        axis, _, value = word.rpartition("=")
        lines = re.findall(f"^{begin.replace('{}', axis)}.*", page, re.M)
        if not re.search(rf"""[`"]{re.escape(value)}[`"]""", "\n".join(lines)):
            missing.append(word)
    return missing


def self_test():
    page = "# P\n\n```sh\nplumb x   # a remark; exit 1\n```\n\n```text\na.png: 12.3 ms\n...\nb 7\n```\n\nText.\n\n```sh\nplumb y\n```\n\nText.\n\n```\nno answer\n```\n"
    found = answers_of(page)
    wrong = []
    if found != [(3, ["plumb x"], "a.png: 12.3 ms\n...\nb 7", 1)]:
        wrong.append(f"blocks: {found}")
    cases = [("a 1 ms ... c", "a 9.5 ms\nb\nc", None), ("a\nb", "b\na", "b"), ("max 1.985", "max 1.986", "max 1.985"), ("note: load 3\na", "a", None),
             ("* depth  24   7.91  1.187  0.957 .. 4.929  not told apart  0.289  5.1", "  depth  24   1.91  0.1  0.289  5.1", "depth 24 # 0.289 5.1"),
             ("* depth  24   7.91  1.187  0.957 .. 4.929  not told apart  0.289  5.1", "  depth  24   1.91  0.187  0.1 .. 0.2  faster  0.289  5.1", None),
             ("* depth  24   7.91  1.187  0.957 .. 4.929  not told apart  0.289  5.1", "  depth  24   1.91  0.187  0.1 .. 0.2  faster  0.290  5.1", "depth 24 # 0.289 5.1")]
    wrong += [f"{shown!r} of {printed!r}: {got!r}" for shown, printed, want in cases if (got := not_printed(shown, printed)) != want]
    if (keys := set(keys_of({"a": [{"b": 1, "passes": {"fill": 2}}], "passes": [{"pass": 3}]}))) != {"a", "b", "passes", "pass"}:
        wrong.append(f"keys: {keys}")
    fish = "complete -c plumb -l other -x -a 'x' -d 'x'\ncomplete -c plumb -l trade -x -a 'depth=24 depth=16' -d 'x'\ncomplete -c plumb -l json -d 'x'\n"
    for page, want in (("| `depth` | `24`, `16` |", []), ("| `depth` | `24`, 16 |", ["depth=16"]), ("| `rate` | `24`, `16` |", ["depth=24", "depth=16"])):
        if (got := words_missing("trade", r"\| `{}` \|", page, fish)) != want:
            wrong.append(f"words of {page}: {got}")
    if (got := words_missing("shading", "x", "x", fish)) != ["--shading"]:
        wrong.append(f"a flag that is not completed: {got}")
    for line in wrong:
        print(line)
    print(f"docs_test --self-test: {len(cases) + 6} cases, {len(wrong)} wrong")
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    plumb, source = (os.path.abspath(path) for path in sys.argv[1:])
    wrong, ran = [], 0
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(plumb, os.path.join(folder, "plumb"))
        for name in ("scenes", "docs", "tests"):
            os.symlink(os.path.join(source, name), os.path.join(folder, name))
        environment = dict(os.environ, PATH=f"{folder}:{os.environ['PATH']}", XDG_CACHE_HOME=os.path.join(folder, ".cache"))
        for name in sorted(os.listdir(os.path.join(source, "docs"))):
            if not name.endswith(".md"):
                continue
            with open(os.path.join(source, "docs", name), encoding="utf-8") as file:
                answers = answers_of(file.read())
            if name in PAGES and not (answers and answers[0][0] <= SCREEN):
                wrong.append(f"docs/{name}: no answer that is run stands in its first {SCREEN} lines")
            for line, commands, shown, expected in answers:
                more = [f"{command} {next((flags for start, flags in SHORTER.items() if command.startswith(start)), '')}" for command in commands]
                begin = time.monotonic()
                done = subprocess.run(["bash", "-c", "; ".join(more)], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                      text=True, errors="replace", timeout=300)
                ran += 1
                print(f"{time.monotonic() - begin:6.1f} s  docs/{name}:{line}: {'; '.join(more)}", flush=True)
                if done.returncode != expected:
                    wrong.append(f"docs/{name}:{line}: exit {done.returncode}, not {expected}")
                if (absent := not_printed(shown, done.stdout)) is not None:
                    wrong.append(f"docs/{name}:{line}: does not print `{absent}` but:\n{masked(done.stdout)[:2000]}")
        completions = subprocess.run(["plumb", "help", "--completion", "fish"], cwd=folder, env=environment, check=True, capture_output=True, text=True).stdout
        for flag, name, begin in WORDED:
            with open(os.path.join(source, "docs", name), encoding="utf-8") as file:
                if missing := words_missing(flag, begin, file.read(), completions):
                    wrong.append(f"docs/{name}: no line that begins with `{begin}` has the words {' '.join(missing)} of --{flag}")
        written = set()
        for name in KEYED:
            with open(os.path.join(source, "docs", name), encoding="utf-8") as file:
                written.update(re.findall(r"\w+", " ".join(re.findall(r"`[^`]*`", file.read()))))
        keys = set()
        for command in REPORTS:
            done = subprocess.run(["bash", "-c", f"{command} --json=report.json"], cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True,
                                  text=True, errors="replace", timeout=300)
            if done.returncode:
                wrong.append(f"{command}: exit {done.returncode}: {done.stderr[-500:]}")
                continue
            with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
                found = set(keys_of(json.load(file)))
            keys |= found
            if found - written:
                wrong.append(f"{command}: keys that no page of {' '.join(KEYED)} has: {' '.join(sorted(found - written))}")
    for line in wrong:
        print(line)
    print(f"docs_test: {ran} answers, {len(keys)} keys of reports, {len(wrong)} wrong")
    return 1 if wrong or not ran else 0


if __name__ == "__main__":
    sys.exit(main())
