#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fails on a C++ or GLSL file that is not in the shape of .clang-format. Versions of clang-format differ, so one judges: 14, that of Debian 12.

usage: format.py [ROOT]         names each file and its first line that differs; exit 1
       format.py --fix [ROOT]   gives all files the shape
       format.py --self-test
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

JUDGE = 14
FOLDERS = ("shaders", "host", "pipeline", "tests", "toolchain", "examples")
ENDINGS = (".cpp", ".h", ".comp", ".glsl", ".vert", ".frag")


def judge():
    """Path of the clang-format that judges, or None."""
    for name in (f"clang-format-{JUDGE}", "clang-format"):
        path = shutil.which(name)
        if path:
            said = subprocess.run([path, "--version"], check=True, capture_output=True, text=True).stdout
            if re.search(rf"version {JUDGE}\.", said):
                return path
    return None


def files_of(root):
    for folder in FOLDERS:
        for path, folders, names in os.walk(os.path.join(root, folder)):
            folders[:] = sorted(name for name in folders if name != "data")
            yield from (os.path.join(path, name) for name in sorted(names) if name.endswith(ENDINGS))


def faults_of(tool, root):
    """`file:line: ...` for the first place of each file that would change."""
    files = list(files_of(root))
    done = subprocess.run([tool, "--style=file", "--dry-run", *files], capture_output=True, text=True)
    seen = set()
    for line in done.stderr.splitlines():
        place = re.match(r"(.+?):(\d+):\d+: warning:", line)
        if place and place.group(1) not in seen:
            seen.add(place.group(1))
            yield f"{os.path.relpath(place.group(1), root)}:{place.group(2)}: not in the shape of .clang-format (toolchain/format.py --fix)"
    if not files or (done.returncode and not seen):
        yield f"format: {len(files)} files; clang-format ended with {done.returncode}: {done.stderr[:200]}"


def self_test(tool):
    here = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    with tempfile.TemporaryDirectory() as root:
        shutil.copy(os.path.join(here, ".clang-format"), root)
        for folder, name, text in (("host", "right.cpp", "int f(int x) { return x; }\n"), ("host", "wide.cpp", "int f(int x)  { return x; }\n"),
                                   ("shaders", "late.comp", "void main() {}\nint  a;\n")):
            os.makedirs(os.path.join(root, folder), exist_ok=True)
            with open(os.path.join(root, folder, name), "w", encoding="utf-8") as f:
                f.write(text)
        found = [fault.split(": ")[0] for fault in faults_of(tool, root)]
        wanted = ["shaders/late.comp:2", "host/wide.cpp:1"]
        print(f"format --self-test: {'right' if found == wanted else f'wrong: {found}'}")
        return 0 if found == wanted else 1


def main():
    arguments = sys.argv[1:]
    tool = judge()
    if tool is None:
        print(f"format: clang-format {JUDGE} is not here: install the packages of toolchain/packages.txt")
        return 1
    if arguments == ["--self-test"]:
        return self_test(tool)
    fix = "--fix" in arguments
    roots = [a for a in arguments if a != "--fix"]
    root = os.path.abspath(roots[0] if roots else os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    if fix:
        subprocess.run([tool, "--style=file", "-i", *files_of(root)], check=True)
    faults = list(faults_of(tool, root))
    print("\n".join(faults + [f"format: {len(list(files_of(root)))} files, {len(faults)} not in shape"]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
