#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants the faults of tests/fault/plants.txt one after the other and shows that the tests named there go red.

A copy of the tree lies in BUILD/plants/tree, with a second copy of shaders/shared under BUILD/plants/twin that C++ reads and the shader compiler
does not; so a fault can be planted in the text of one side only. Each fault rebuilds what it touches in one build tree that is kept, then runs
the named program: it must fail. Before any fault each program must pass with the filters named, and run at least one test for each.

usage: run_plants.py BUILD [--jobs N] [--only REGEX]
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import time

import plants

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
COPIED = ("CMakeLists.txt", "host", "pipeline", "shaders", "tests", "toolchain", "scenes", "docs", "examples")
TIMEOUT_S = 180


def write_if_changed(path, data):
    """Keeps the time of a file that stays as it is, so that only what changed is built again."""
    try:
        with open(path, "rb") as f:
            if f.read() == data:
                return
    except OSError:
        os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as f:
        f.write(data)


def mirror(source, target):
    wanted = set()
    for folder, folders, files in os.walk(source):
        folders[:] = [name for name in folders if name not in (".git", "build", "__pycache__")]
        for name in files:
            path = os.path.join(folder, name)
            wanted.add(os.path.relpath(path, source))
            with open(path, "rb") as f:
                write_if_changed(os.path.join(target, os.path.relpath(path, source)), f.read())
    for folder, _, files in os.walk(target):
        for name in files:
            path = os.path.join(folder, name)
            if os.path.relpath(path, target) not in wanted:
                os.remove(path)


class Tree:
    def __init__(self, build, jobs):
        self.base, self.jobs = os.path.join(build, "plants"), jobs
        self.tree, self.twin, self.build = (os.path.join(self.base, name) for name in ("tree", "twin", "build"))
        for name in COPIED:
            path = os.path.join(ROOT, name)
            if os.path.isdir(path):
                mirror(path, os.path.join(self.tree, name))
            elif os.path.isfile(path):
                with open(path, "rb") as f:
                    write_if_changed(os.path.join(self.tree, name), f.read())
        mirror(os.path.join(ROOT, "shaders", "shared"), os.path.join(self.twin, "shaders", "shared"))
        if not os.path.exists(os.path.join(self.build, "build.ninja")):
            shutil.rmtree(self.build, ignore_errors=True)
            # A quoted include looks into -iquote folders before it looks into the -I folder that the shader compiler is given.
            done = subprocess.run(["cmake", "-S", self.tree, "-B", self.build, "-G", "Ninja", "-DPLUMB_TESTS=ON", "-DCMAKE_BUILD_TYPE=",
                                   f"-DCMAKE_CXX_FLAGS=-O1 -iquote {self.twin} -iquote {self.twin}/shaders"], capture_output=True, text=True)
            if done.returncode:
                sys.exit(done.stdout + done.stderr)
        self.environment = dict(os.environ, XDG_CACHE_HOME=os.path.join(self.base, "cache"))

    def places(self, row):
        """(file to write, file it comes from) for a row: the side decides which copies change."""
        source = plants.path_of(ROOT, row.file)
        inside = os.path.relpath(source, ROOT)
        copies = []
        if not inside.startswith("shaders/shared/"):
            copies.append(os.path.join(self.tree, inside))
        else:
            if row.side in ("device", "both"):
                copies.append(os.path.join(self.tree, inside))
            if row.side in ("twin", "both"):
                copies.append(os.path.join(self.twin, inside))
        return copies, source

    def make(self, programs):
        return subprocess.run(["cmake", "--build", self.build, "--parallel", str(self.jobs), "--target", *programs],
                              capture_output=True, text=True)

    def run(self, program, test_filter):
        """(exit status, tests run, first failed test)"""
        path = next((os.path.join(folder, program) for folder, _, files in os.walk(os.path.join(self.build, "tests")) if program in files), None)
        if path is None:
            sys.exit(f"run_plants: no program {program} under {self.build}/tests")
        try:
            done = subprocess.run([path, f"--gtest_filter={test_filter}"], capture_output=True, text=True, errors="replace",
                                  cwd=self.build, env=self.environment, timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            return -1, 1, f"no end after {TIMEOUT_S} s"
        count = re.search(r"Running (\d+) tests?", done.stdout)
        failed = re.search(r"\[  FAILED  \] ([\w./]+)", done.stdout)
        last = (done.stderr.strip().splitlines() or ["died"])[-1][:100]
        return done.returncode, int(count.group(1)) if count else 0, failed.group(1) if failed else last


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    rows, faults = plants.read_rows(os.path.join(ROOT, "tests", "fault", "plants.txt"))
    rows = [row for row in rows if re.search(options.only, row.name)]
    if faults or not rows:
        print("\n".join(faults) or "run_plants: no planted faults")
        return 1
    begin = time.monotonic()
    tree = Tree(os.path.abspath(options.build), options.jobs)
    done = tree.make(sorted({row.program for row in rows}))
    if done.returncode:
        print(done.stdout[-4000:] + done.stderr)
        return 1
    wrong = 0
    for program, test_filter in sorted({(row.program, row.filter) for row in rows}):
        status, count, failed = tree.run(program, test_filter)
        if status != 0 or count == 0:
            wrong += 1
            print(f"{program} {test_filter}: {f'fails without a fault: {failed}' if status else 'matches no test'}", flush=True)
    if wrong:
        return 1
    print(f"[{time.monotonic() - begin:5.0f} s] built, {len(rows)} faults to plant", flush=True)
    planted = []
    try:
        # Rows of one program and file lie together: less is built again.
        for row in sorted(rows, key=lambda r: (r.program, r.side, r.file)):
            copies, source = tree.places(row)
            with open(source, encoding="utf-8") as f:
                text = f.read()
            if text.count(row.text) != 1:
                print(f"{row.name}: `{row.text}` stands {text.count(row.text)} times in {row.file}")
                wrong += 1
                continue
            for copy, original in planted:
                if copy not in copies:
                    with open(original, "rb") as f:
                        write_if_changed(copy, f.read())
            planted = [(copy, source) for copy in copies]
            for copy in copies:
                write_if_changed(copy, text.replace(row.text, row.replacement).encode())
            done = tree.make([row.program])
            if done.returncode:
                says, ok = "does not build: " + (done.stdout + done.stderr).strip().splitlines()[-1], False
            else:
                status, _, failed = tree.run(row.program, row.filter)
                ok = status != 0
                says = f"noticed by {failed}" if ok else f"UNNOTICED by {row.program} {row.filter}"
            wrong += not ok
            print(f"[{time.monotonic() - begin:5.0f} s] {row.side:6} {row.name}: {says}", flush=True)
    finally:
        for copy, original in planted:
            with open(original, "rb") as f:
                write_if_changed(copy, f.read())
    print(f"run_plants: {len(rows)} planted faults, {wrong} not noticed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
