#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants the faults of tests/fault/plants.txt one after the other and shows that the tests named there go red.

A copy of the tree lies in BUILD/plants/0/tree, with a second copy of shaders/shared under BUILD/plants/0/twin that C++ reads and the shader compiler
does not; so a fault can be planted in the text of one side only. Each fault rebuilds what it touches in one build tree that is kept, then runs
the named program: it must fail. Before any fault each program must pass with the filters named, and run at least one test for each.

usage: run_plants.py BUILD [--jobs N] [--only REGEX]
"""
import argparse
import itertools
import os
import queue
import re
import shutil
import subprocess
import sys
import threading
import time

import plants

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
COPIED = ("CMakeLists.txt", "host", "pipeline", "shaders", "tests", "toolchain", "scenes", "docs", "examples")
BASELINE_TIMEOUT_S = 600


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
    """A copy of the tree, with the build that is kept. Several work side by side: building one fault is mostly a chain of single steps."""

    def __init__(self, base, number, jobs):
        self.jobs, self.planted = jobs, {}
        self.base = os.path.join(base, str(number))
        self.tree, self.twin, self.build = (os.path.join(self.base, name) for name in ("tree", "twin", "build"))
        self.environment = dict(os.environ, XDG_CACHE_HOME=os.path.join(self.base, "cache"), CCACHE_BASEDIR=self.base, CCACHE_NOHASHDIR="1")

    def prepare(self, programs):
        """What cmake or the build said when it failed, else None."""
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
                                   f"-DCMAKE_CXX_FLAGS=-O1 -iquote {self.twin} -iquote {self.twin}/shaders"],
                                  capture_output=True, text=True, env=self.environment)
            if done.returncode:
                return done.stdout + done.stderr
        done = self.make(programs)
        return done.stdout[-4000:] + done.stderr if done.returncode else None

    def places(self, row):
        """(copies that the side of a row changes, file they come from)"""
        source = plants.path_of(ROOT, row.file)
        inside = os.path.relpath(source, ROOT)
        if not inside.startswith("shaders/shared/"):
            return [os.path.join(self.tree, inside)], source
        sides = {"device": [self.tree], "twin": [self.twin], "both": [self.tree, self.twin]}[row.side]
        return [os.path.join(side, inside) for side in sides], source

    def plant(self, row):
        """Takes back what is planted and plants `row` (None: nothing)."""
        copies, source = self.places(row) if row else ([], None)
        for copy, original in self.planted.items():
            if copy not in copies:
                with open(original, "rb") as f:
                    write_if_changed(copy, f.read())
        self.planted = {copy: source for copy in copies}
        if row:
            with open(source, encoding="utf-8") as f:
                text = f.read()
            for copy in copies:
                write_if_changed(copy, plants.planted(text, row).encode())

    def make(self, programs):
        return subprocess.run(["cmake", "--build", self.build, "--parallel", str(self.jobs), "--target", *programs],
                              capture_output=True, text=True, env=self.environment)

    def run(self, program, test_filter, timeout_s):
        """(exit status, tests run, first failed test)"""
        path = next((os.path.join(folder, program) for folder, _, files in os.walk(os.path.join(self.build, "tests")) if program in files), None)
        if path is None:
            return 0, 0, "no such program"
        try:
            done = subprocess.run([path, f"--gtest_filter={test_filter}", "--gtest_fail_fast"], capture_output=True, text=True, errors="replace",
                                  cwd=self.build, env=self.environment, timeout=timeout_s)
        except subprocess.TimeoutExpired:
            return -1, 1, f"no end after {timeout_s:.0f} s"
        count = re.search(r"Running (\d+) tests?", done.stdout)
        failed = re.search(r"\[  FAILED  \] ([\w./]+)", done.stdout)
        last = (done.stderr.strip().splitlines() or ["died"])[-1][:100]
        return done.returncode, int(count.group(1)) if count else 0, failed.group(1) if failed else last


def misfits(rows):
    for row in rows:
        path = plants.path_of(ROOT, row.file)
        text = open(path, encoding="utf-8").read() if os.path.isfile(path) else ""
        if len(plants.places_of(text, row)) != 1:
            yield f"{row.name}: `{row.text}` does not stand once in {row.file}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    rows, faults = plants.read_rows(os.path.join(ROOT, "tests", "fault", "plants.txt"))
    rows = [row for row in rows if re.search(options.only, row.name)]
    faults += misfits(rows)
    if faults or not rows:
        print("\n".join(faults) or "run_plants: no planted faults")
        return 1
    begin = time.monotonic()
    say = lambda text: print(f"[{time.monotonic() - begin:5.0f} s] {text}", flush=True)
    os.environ.setdefault("VK_ICD_FILENAMES", f"/usr/share/vulkan/icd.d/lvp_icd.{os.uname().machine}.json")
    os.environ.setdefault("PLUMB_VALIDATION", "1")
    programs = sorted({row.program for row in rows})
    base = os.path.join(os.path.abspath(options.build), "plants")
    trees = [Tree(base, 0, options.jobs)] + [Tree(base, n, 1) for n in range(1, min(options.jobs, 4, len(rows)))]
    for tree in trees:
        tree.jobs, trouble = options.jobs, tree.prepare(programs)
        if trouble:
            print(trouble)
            return 1
    say(f"{len(trees)} trees built")
    limits = {}
    for program, test_filter in sorted({(row.program, row.filter) for row in rows}):
        start = time.monotonic()
        status, count, failed = trees[0].run(program, test_filter, BASELINE_TIMEOUT_S)
        limits[program, test_filter] = 30 + 5 * (time.monotonic() - start)
        if status != 0 or count == 0:
            print(f"{program} {test_filter}: {f'fails without a fault: {failed}' if status else 'matches no test'}")
            return 1
    say(f"green without a fault; {len(rows)} faults to plant")
    # Rows of one program and file lie together: less is built again.
    work, results = queue.SimpleQueue(), []
    for _, group in itertools.groupby(sorted(rows, key=lambda r: (r.program, r.side, r.file)), key=lambda r: (r.program, r.side, r.file)):
        group = list(group)
        for at in range(0, len(group), 8):
            work.put(group[at:at + 8])

    def labour(tree):
        tree.jobs = max(1, options.jobs // len(trees))
        try:
            while True:
                for row in work.get_nowait():
                    tree.plant(row)
                    done = tree.make([row.program])
                    if done.returncode:
                        ok, says = False, "does not build: " + next((line for line in (done.stdout + done.stderr).splitlines() if "rror" in line), "?")
                    else:
                        status, _, failed = tree.run(row.program, row.filter, limits[row.program, row.filter])
                        ok = status != 0
                        says = f"noticed by {failed}" if ok else f"UNNOTICED by {row.program} {row.filter}"
                    results.append(ok)
                    say(f"{row.side:6} {row.name}: {says}")
        except queue.Empty:
            tree.plant(None)

    workers = [threading.Thread(target=labour, args=(tree,)) for tree in trees]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    print(f"run_plants: {len(rows)} planted faults, {len(rows) - sum(results)} not noticed")
    return 0 if sum(results) == len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
