#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Follows README.md: every line of its sh blocks is run, in order, in a fresh copy of the tree with the files that it speaks of, and must end with 0 and leave
the files that it names. Two lines are no such: test.sh is what runs this test, and demo.sh, whose build is asked for its targets instead and whose table of
pictures is cut to one. What `cmake --install` copies must be made by demo.sh's targets. A block without a language shows what the line before it prints; `...` stands
for what is left out.

usage: readme_test.py SOURCE BUILD
"""
import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
import time

# What makes a line short. A line begins with these words.
SHORTER = {
    "plumb bench raster": "sphere1e3 --size 96x64 --repeat 3",
    "plumb bench claims": "--repeat 3",
    "plumb measure": "--size 64x48 --limit 5s",
}
SCENE = """[[mesh]]
name = "mug"
file = "mug.obj"

[[object]]
mesh = "mug"

[[light]]
type = "directional"
direction = [1, 1, 1]
"""
# Answers `cmake` of demo.sh: a tree is configured already, and --build only writes down its targets.
CMAKE = r"""#!/bin/bash
case $1 in --build) echo "$*" >>"$RECORD" ;; esac
"""


def lines_of(text):
    """[line number, command, lines of the answer that is shown] of each line of an sh block; a line may go on behind a backslash."""
    found, inside, begun, language = [], False, None, ""
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            language = "" if inside else line[3:]
            inside = not inside
        elif inside and not language and found:
            found[-1][2].append(line)
        elif inside and language == "sh" and line.strip() and not line.lstrip().startswith("#"):
            start, command = begun or (number, "")
            command += re.sub(r"\s+#\s.*$", "", line)
            begun = (start, command[:-1]) if command.endswith("\\") else None
            if begun is None:
                found.append([start, command, []])
    return found


def not_printed(shown, printed):
    """The first shown line that stands nowhere in what was printed, behind the line before it; None when all do."""
    at = 0
    for line in shown:
        for part in filter(None, (part.strip() for part in line.split("..."))):
            found = printed.find(part, at)
            if found < 0:
                return part
            at = found + len(part)
    return None


class Copy:
    def __init__(self, source, build, folder):
        self.source, self.build = source, os.path.abspath(build)
        self.tree, self.home = os.path.join(folder, "tree"), os.path.join(folder, "home")
        for path in (self.home, os.path.join(self.tree, "build")):
            os.makedirs(path)
        skipped = shutil.ignore_patterns("build", "out", ".git", "*.part", "__pycache__")
        shutil.copytree(source, self.tree, ignore=skipped, dirs_exist_ok=True, symlinks=True)
        os.symlink(self.build, os.path.join(self.tree, "build", "release"))
        self.environment = dict(os.environ, HOME=self.home, XDG_CACHE_HOME=os.path.join(self.home, ".cache"))

    def run(self, command, **more):
        return subprocess.run(["bash", "-c", f"set -euo pipefail; {command}"], cwd=self.tree, env=dict(self.environment, **more), stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", timeout=300)

    def provide(self):
        """The files that the lines speak of."""
        place = lambda name: os.path.join(self.tree, name)
        for name in ("mug.obj", "mug.mtl"):
            if os.path.exists(place(f"scenes/mug/{name}")):
                shutil.copy(place(f"scenes/mug/{name}"), self.tree)
        shutil.copy(place("scenes/procedural/torus.stl"), place("part.stl"))
        shutil.copy(place("tests/fuzz/corpus/glb/" + sorted(os.listdir(place("tests/fuzz/corpus/glb")))[0]), place("scene.glb"))
        for name in ("a.png", "b.png"):
            shutil.copy(place("docs/images/pyramid.png"), place(name))
        with open(place("scene.toml"), "w", encoding="utf-8") as f:
            f.write(SCENE)


def outputs_of(build, targets):
    """All files that Ninja makes for the targets."""
    with open(os.path.join(build, "build.ninja"), encoding="utf-8") as f:
        text = f.read().replace("$\n", "")
    edges = {}  # output -> (all outputs, all inputs) of its command; paths hold no spaces
    for line in re.findall(r"^build (.*)$", text, re.M):
        outputs, inputs = (set(part.replace("|", " ").split()) for part in line.split(": ", 1))
        edges.update({output: (outputs, inputs) for output in outputs})
    made, left = set(), list(targets)
    while left:
        target = left.pop()
        if target in edges and target not in made:
            made |= edges[target][0]
            left += edges[target][1]
    return {os.path.relpath(os.path.join(build, path), build) for path in made}


def not_built(copy):
    """Files that `cmake --install` copies and that the targets of demo.sh do not make."""
    record = os.path.join(copy.home, "cmake.calls")
    fake = os.path.join(copy.home, "bin")
    os.makedirs(fake)
    with open(os.path.join(fake, "cmake"), "w", encoding="utf-8") as f:
        f.write(CMAKE)
    os.chmod(os.path.join(fake, "cmake"), stat.S_IRWXU)
    table = os.path.join(copy.tree, "scenes", "pictures.txt")
    with open(table, encoding="utf-8") as f:
        rows = [line for line in f if line.strip() and not line.startswith("#")]
    with open(table, "w", encoding="utf-8") as f:
        f.write(next(row for row in rows if row.startswith("pyramid")))
    # demo.sh writes beside the build what it was configured with: that is not this tree's to keep.
    kept = os.path.join(copy.build, "packages.txt")
    before = open(kept, encoding="utf-8").read() if os.path.exists(kept) else None
    done = copy.run("toolchain/demo.sh", PATH=f"{fake}:{copy.environment['PATH']}", RECORD=record)
    if before is None and os.path.exists(kept):
        os.remove(kept)
    elif before is not None:
        with open(kept, "w", encoding="utf-8") as f:
            f.write(before)
    if done.returncode or "equal" not in done.stdout:
        return [f"demo.sh: exit {done.returncode}: {done.stderr[-500:]}"]
    with open(record, encoding="utf-8") as f:
        words = f.read().split()
    targets = words[words.index("--target") + 1:] if "--target" in words else ["all"]
    made = outputs_of(copy.build, targets)
    wanted = set()
    for folder, _, names in os.walk(copy.build):
        if "cmake_install.cmake" in names:
            with open(os.path.join(folder, "cmake_install.cmake"), encoding="utf-8") as f:
                wanted |= set(re.findall(rf'"{re.escape(copy.build)}/([^"$]+)"', f.read()))
    # Configuring makes the package's *.cmake and *.pc. The manifest of a folder is what newer CMakes write while they install.
    wanted = {path for path in wanted if not path.endswith((".cmake", ".pc", "install_local_manifest.txt")) and "/CMakeFiles/" not in path}
    missing = [f"cmake --install copies {path}, which demo.sh does not build" for path in sorted(wanted)
               if not any(name == path or name.startswith(path + "/") for name in made)]
    return missing if wanted else ["cmake --install copies nothing that is built"]


def main():
    source, build = sys.argv[1:]
    with open(os.path.join(source, "README.md"), encoding="utf-8") as f:
        lines = lines_of(f.read())
    wrong, ran = [], 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(os.path.abspath(source), build, folder)
        copy.provide()
        for number, command, shown in lines:
            words = shlex.split(command)
            if words[0] in ("toolchain/demo.sh", "toolchain/test.sh"):
                continue
            short = next((f"{command} {more}" for start, more in SHORTER.items() if command.startswith(start)), command)
            begin = time.monotonic()
            done = copy.run(short + "; env -0 >\"$HOME/environment\"" if words[0] == "export" else short)
            if words[0] == "export" and not done.returncode:
                with open(os.path.join(copy.home, "environment"), encoding="utf-8") as f:
                    copy.environment = dict(pair.split("=", 1) for pair in f.read().split("\0") if "=" in pair)
            ran += 1
            print(f"{time.monotonic() - begin:6.1f} s  README.md:{number}: {short}", flush=True)
            if done.returncode:
                wrong.append(f"README.md:{number}: {command}: exit {done.returncode}: {(done.stderr or done.stdout).strip()[-500:]}")
            if (absent := not_printed(shown, done.stdout + done.stderr)) is not None:
                wrong.append(f"README.md:{number}: {command}: does not print `{absent}` but: {(done.stdout + done.stderr)[:500]}")
            for flag, name in zip(words, words[1:]):
                if flag == "-o" and not (os.path.isfile(os.path.join(copy.tree, name)) and os.path.getsize(os.path.join(copy.tree, name))):
                    wrong.append(f"README.md:{number}: {command}: there is no {name}")
        if not os.path.isfile(os.path.join(copy.home, ".local", "bin", "plumb")):
            wrong.append("README.md: nothing was installed into ~/.local")
        wrong += not_built(copy)
    if not any(command.startswith("toolchain/demo.sh") for _, command, _ in lines) or ran < 10:
        wrong.append(f"README.md: only {ran} lines were run")
    for line in wrong:
        print(line)
    print(f"readme_test: {ran} lines, {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
