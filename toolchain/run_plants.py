#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants the faults of tests/fault/plants/ one after the other and shows that the tests named there go red.

BUILD is a finished build tree; nothing in it is changed. For each fault the text of one side is copied with the fault in it, only what that side
makes of the text is compiled again (the twin: its translation units; the device: its SPIR-V modules), and the named program is linked anew with these
objects before the archives, which then have no part in what the objects define. It must fail. Before any fault each program must pass
with the filters named, and run at least one test for each.

The twin's faults that stand in bodies of functions are compiled together, a program once: a body begins with `if (plumbPlant == K) { the body with the fault K }`,
and each run has one of them by PLUMB_PLANT=K. The program so built must pass with none of them, too.

usage: run_plants.py BUILD [--jobs N] [--only REGEX]
"""
import argparse
import collections
import concurrent.futures
import filecmp
import json
import os
import queue
import re
import shlex
import shutil
import subprocess
import sys
import threading
import time

import compile_words
import plants

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
BASELINE_TIMEOUT_S = 600


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def cached(build, name):
    """Value of a variable in CMake's cache."""
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as f:
        found = re.search(rf"^{name}:\w+=(.*)$", f.read(), re.M)
    if not found:
        sys.exit(f"run_plants: {build} was configured without {name}")
    return found.group(1)


class Build:
    """What Ninja knows of a finished build tree."""

    def __init__(self, build):
        self.path = os.path.abspath(build)
        self.compile = {}  # object -> words of its compile command
        self.source = {}   # object -> absolute path of its source
        for entry in json.loads(output_of("ninja", "-C", build, "-t", "compdb")):
            if entry["file"].endswith(".cpp") and " -c " in entry["command"]:
                self.compile[entry["output"]] = compile_words.of_compiler(shlex.split(entry["command"]))
                self.source[entry["output"]] = os.path.normpath(os.path.join(self.path, entry["file"]))
        self.users = collections.defaultdict(set)  # absolute path -> objects and raw modules made from it
        target = None
        for line in output_of("ninja", "-C", build, "-t", "deps").splitlines():
            if line.startswith(" "):
                self.users[os.path.normpath(os.path.join(self.path, line.strip()))].add(target)
            elif ": #deps" in line:
                target = line.split(": #deps")[0]
        for name, source in self.source.items():
            self.users[source].add(name)
        self.module_of = {}  # object of a module's words -> raw module
        for name, source in self.source.items():
            folder, file = os.path.split(source)
            if folder == os.path.join(self.path, "generated", "spirv"):
                raw = self.module_of[name] = f"generated/spirv/{file[:-4]}.raw.spv"
                with open(f"{source[:-4]}.d", encoding="utf-8") as f:  # as glslang wrote it; paths hold no spaces
                    for path in f.read().split(":", 1)[1].replace("\\\n", " ").split():
                        self.users[os.path.normpath(path)].add(raw)
        self.links = {}
        self.headers, self.headers_lock = {}, threading.Lock()

    def quick_words(self, name):
        """Words that compile an object with little optimisation, but for source and output. GCC takes what was precompiled only with the
        optimisation that it was precompiled with, so that is done once more."""
        words, header = compile_words.without_precompiled(compile_words.without(self.compile[name], ("-MD", "-O3"), ("-o", "-MF", "-MT", "-c")))
        words[1:1] = ["-O1"]
        if not header:
            return words
        with self.headers_lock:
            if header not in self.headers:
                folder = os.path.join(self.path, "plants", f"headers{len(self.headers)}")
                os.makedirs(folder, exist_ok=True)
                made = shutil.copy(header, folder)
                subprocess.run(words + ["-w", "-x", "c++-header", "-o", made + ".gch", "-c", made], cwd=self.path, check=True)
                self.headers[header] = made
        return words + ["-include", self.headers[header]]

    def command_of(self, target):
        """Words of the command that makes a target; CMake writes `: && COMMAND && :` or `cd FOLDER && COMMAND && ...`."""
        line = output_of("ninja", "-C", self.path, "-t", "commands", "-s", target).strip().splitlines()[-1]
        return shlex.split(line.split(" && ")[1])

    def link_of(self, program):
        """(words of the link command, objects that may be part of the program)"""
        if program not in self.links:
            owner = next((name for name in self.compile if f"/CMakeFiles/{program}.dir/" in name), None)
            if owner is None:
                return None
            words = self.command_of(f"{owner.split('/CMakeFiles/')[0]}/{program}")
            rooms = [f"/{m.group(1)}.dir/" for m in (re.search(r"lib(plumb\w+)\.a$", word) for word in words) if m]
            rooms.append(f"/{program}.dir/")
            self.links[program] = words, [name for name in self.compile if any(room in name for room in rooms)]
        return self.links[program]


SWITCH = """#if defined(__cplusplus) && !defined(PLUMB_PLANT_SWITCH)
#define PLUMB_PLANT_SWITCH
#include <cstdlib>
inline int plumbPlant = 0;
[[gnu::constructor(101)]] static void plumbReadPlant() {  // before any variable is initialised by a function of the text
    const char* const number = std::getenv("PLUMB_PLANT");
    plumbPlant = number ? std::atoi(number) : 0;
}
#endif
"""


def body_around(text, first, last):
    """(start, end, whether it returns nothing) of the body of the function, between its braces, that holds text[first:last]; None outside of any."""
    code = re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', lambda m: re.sub(r"[^\n]", " ", m.group(0)), text, flags=re.S)
    open_, outermost = [], None
    for m in re.finditer(r"[{}]", code):
        at = m.start()
        if m.group(0) == "{":
            head = code[:at].rstrip()
            function = outermost is None and re.search(r"\)(?:\s*(?:const|noexcept))*$", head) is not None
            open_.append((at + 1, function))
            if function:
                outermost = len(open_)
        elif open_:
            start, function = open_.pop()
            if function and outermost == len(open_) + 1:
                outermost = None
                if start <= first and last <= at:
                    begin = max(code.rfind(end, 0, start - 1) for end in ";}")
                    declared = re.sub(r"^[ \t]*#[^\n]*", "", code[begin + 1:start], flags=re.M)
                    return start, at, re.match(r"(?:[\w:]+\s+)*?void\s+\w+\s*\(", declared.strip()) is not None
    return None


def switched(text, rows):
    """(text with the faults of all rows behind a switch, rows that stand in no function). Rows: {number: row}."""
    bodies, outside = collections.defaultdict(list), []
    for number, row in rows.items():
        at, length = plants.places_of(text, row)[0], len(row.text.removeprefix("^"))
        body = body_around(text, at, at + length)
        if body is None or "#" in text[body[0]:body[1]]:
            outside.append(row)
            continue
        start, end, nothing = body
        faulty = text[start:at] + row.replacement + text[at + length:end]
        bodies[start].append(f"\nif (plumbPlant == {number}) {{{faulty}\n{'return;' if nothing else ''}}}\n")
    for start in sorted(bodies, reverse=True):
        text = text[:start] + "".join(bodies[start]) + text[start:]
    return SWITCH + text, outside


class Worker:
    """A place of its own where one fault at a time is planted, built and run."""

    def __init__(self, build, base, number):
        self.build, self.base = build, os.path.join(base, str(number))
        shutil.rmtree(self.base, ignore_errors=True)
        self.overlay, self.out = os.path.join(self.base, "text"), os.path.join(self.base, "out")
        self.environment = dict(os.environ, XDG_CACHE_HOME=os.path.join(base, "cache"))
        os.makedirs(self.out)
        os.makedirs(os.path.join(base, "cache"), exist_ok=True)

    def lay_out(self, texts):
        """Lays out the text with faults, {file of a row: text}. A quoted include looks beside the file that names it first, so the shaders lie there whole."""
        shutil.rmtree(self.overlay, ignore_errors=True)
        shutil.copytree(os.path.join(ROOT, "shaders"), os.path.join(self.overlay, "shaders"))
        for file, text in texts.items():
            target = os.path.join(self.overlay, os.path.relpath(plants.path_of(ROOT, file), ROOT))
            os.makedirs(os.path.dirname(target), exist_ok=True)
            with open(target, "w", encoding="utf-8") as f:
                f.write(text)

    def call(self, words):
        done = subprocess.run(words, cwd=self.build.path, capture_output=True, text=True, env=self.environment)
        if done.returncode:
            raise RuntimeError(next((line for line in (done.stdout + done.stderr).splitlines() if "rror" in line), "?"))

    def in_overlay(self, path):
        """The planted copy of a file or folder of the tree, where there is one."""
        inside = os.path.relpath(os.path.join(self.build.path, path), ROOT)
        copy = os.path.join(self.overlay, inside)
        return copy if not inside.startswith("..") and os.path.exists(copy) else path

    def compiled(self, name, source):
        out = os.path.join(self.out, name.replace("/", "_"))
        words = self.build.quick_words(name)
        words[1:1] = ["-iquote", self.overlay, "-iquote", os.path.join(self.overlay, "shaders")]
        self.call(words + ["-o", out, "-c", source])
        return out

    def of_twin(self, paths, objects):
        """[objects replaced, how to make what replaces them]: the program's units that read one of the texts in C++, but for what drives the device."""
        users = set().union(*(self.build.users[path] for path in paths))
        names = sorted(name for name in users if name in objects and not name.startswith("host/") and "gpu" not in os.path.basename(name))
        return [([name], lambda name=name: self.compiled(name, self.in_overlay(self.build.source[name]))) for name in names]

    def of_device(self, path, objects):
        """The same for its modules. A module may be part of a program by more than one object."""
        named = collections.defaultdict(list)
        for name in objects:
            raw = self.build.module_of.get(name)
            if raw in self.build.users[path]:
                named[raw].append(name)
        return [(names, lambda names=names, raw=raw: self.module(names[0], raw)) for raw, names in named.items()]

    def spirv(self, raw):
        """Path of a planted module's words without its ending; None when the fault does not reach it."""
        stem = os.path.join(self.out, os.path.basename(raw)[:-len(".raw.spv")])
        places = {end: stem + end for end in (".glslang.spv", ".raw.spv", ".judged.spv", ".spv", ".h", ".cpp")}
        placed = lambda words: [next((place for end, place in places.items() if word.endswith(end)), word) for word in words]
        words = [f"-I{self.in_overlay(word[2:])}" if word.startswith("-I") else self.in_overlay(word)
                 for word in self.build.command_of(raw.replace(".raw.", ".glslang."))]
        words[words.index("--depfile") + 1] = stem + ".d"
        words[words.index("-o") + 1] = stem + ".glslang.spv"
        self.call(words)
        self.call(placed(self.build.command_of(raw)))
        if filecmp.cmp(stem + ".raw.spv", os.path.join(self.build.path, raw), shallow=False):
            return None
        embed = self.build.command_of(raw.replace(".raw.spv", ".spv"))
        self.call(placed(embed))
        return stem

    def module(self, name, raw):
        """Object of a planted module; None when the fault does not reach it."""
        stem = self.spirv(raw)
        return stem and self.compiled(name, stem + ".cpp")

    def attempts(self, rows, texts):
        """Programs with the texts in them, of rows of one program and side: first in what bears the program's own name only (the test, its pass's twin or
        kernel), which is enough for most faults and quick to build, then in everything that reads the text."""
        self.lay_out(texts)
        program, side = rows[0].program, rows[0].side
        paths = sorted({plants.path_of(ROOT, row.file) for row in rows})
        _, objects = self.build.link_of(program)
        parts = self.of_twin(paths, objects) if side in ("twin", "both") else []
        if side in ("device", "both"):
            parts += [part for path in paths for part in self.of_device(path, objects)]
        stem = program.removesuffix("_test")
        near = [part for part in parts if re.match(rf"{stem}(_test|_cpu|_shuffle)?\.cpp", os.path.basename(part[0][0]))]
        far = [part for part in parts if part not in near]
        made = []
        for group in (near, far):
            fresh = [(names, out) for names, make in group if (out := make())]
            if fresh:
                made += fresh
                yield self.linked(program, made)
        if not made:
            raise RuntimeError(f"{', '.join(sorted({row.file for row in rows}))} changes nothing of {program}")

    def linked(self, program, made):
        replaced = {name for names, _ in made for name in names}
        words = [word for word in self.build.link_of(program)[0] if word not in replaced]
        at = words.index("-o")
        words[at + 1] = os.path.join(self.out, program)
        self.call(words[:at] + [out for _, out in made] + words[at:])
        return words[at + 1]

    def run(self, program, test_filter, timeout_s, plant=0):
        """(exit status, tests run, first failed test)"""
        try:
            done = subprocess.run([program, f"--gtest_filter={test_filter}", "--gtest_fail_fast"], capture_output=True, text=True, errors="replace",
                                  cwd=self.base, env=dict(self.environment, PLUMB_PLANT=str(plant)), timeout=timeout_s)
        except subprocess.TimeoutExpired:
            return -1, 1, f"no end after {timeout_s:.0f} s"
        count = re.search(r"Running (\d+) tests?", done.stdout)
        failed = re.search(r"\[  FAILED  \] ([\w./]+)", done.stdout)
        last = (done.stderr.strip().splitlines() or ["died"])[-1][:100]
        return done.returncode, int(count.group(1)) if count else 0, failed.group(1) if failed else last


def text_of(file):
    path = plants.path_of(ROOT, file)
    if not os.path.isfile(path):
        return ""
    with open(path, encoding="utf-8") as f:
        return f.read()


def misfits(rows):
    for row in rows:
        if len(plants.places_of(text_of(row.file), row)) != 1:
            yield f"{row.name}: `{row.text}` does not stand once in {row.file}"


def side_by_side(workers, jobs, do):
    """do(worker, job) for each job; every worker takes the next one that is left."""
    left = queue.SimpleQueue()
    for job in jobs:
        left.put(job)

    def labour(worker):
        try:
            while True:
                do(worker, left.get_nowait())
        except queue.Empty:
            pass

    with concurrent.futures.ThreadPoolExecutor(len(workers)) as pool:
        list(pool.map(labour, workers))  # raises what a worker raised


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    rows, faults = plants.read_all(ROOT)
    rows = [row for row in rows if re.search(options.only, row.name)]
    faults += misfits(rows)
    if faults or not rows:
        print("\n".join(faults) or "run_plants: no planted faults")
        return 1
    begin = time.monotonic()
    say = lambda text: print(f"[{time.monotonic() - begin:5.0f} s] {text}", flush=True)
    os.environ.setdefault("VK_ICD_FILENAMES", cached(options.build, "PLUMB_TEST_ICD"))
    os.environ.setdefault("PLUMB_VALIDATION", "1")
    build = Build(options.build)
    absent = sorted({row.program for row in rows if build.link_of(row.program) is None})
    if absent:
        print(f"run_plants: {options.build} has no program {', '.join(absent)}")
        return 1
    base = os.path.join(build.path, "plants")
    workers = [Worker(build, base, number) for number in range(max(1, options.jobs))]
    limits, red = {}, []

    def baseline(worker, pair):
        program, test_filter = pair
        words, _ = build.link_of(program)
        start = time.monotonic()
        status, count, failed = worker.run(os.path.join(build.path, words[words.index("-o") + 1]), test_filter, BASELINE_TIMEOUT_S)
        limits[pair] = 30 + 5 * (time.monotonic() - start)
        if status != 0 or count == 0:
            red.append(f"{program} {test_filter}: {f'fails without a fault: {failed}' if status else 'matches no test'}")

    side_by_side(workers, sorted({(row.program, row.filter) for row in rows}), baseline)
    if red:
        print("\n".join(red))
        return 1
    say(f"green without a fault; {len(rows)} faults to plant")
    seen, missed = [], []

    def tell(row, failed):
        (seen if failed else missed).append(row.name)
        return f"noticed by {failed}" if failed else f"UNNOTICED by {row.program} {row.filter}"

    def alone(worker, row):
        """The fault by itself in the text."""
        failed = ""
        try:
            for program in worker.attempts([row], {row.file: plants.planted(text_of(row.file), row)}):
                status, _, failed = worker.run(program, row.filter, limits[row.program, row.filter])
                if status:
                    break
                failed = ""
            said = tell(row, failed)
        except RuntimeError as error:
            missed.append(row.name)
            said = f"does not build: {error}"
        say(f"{row.side:6} {row.name}: {said}")

    def together(worker, batch):
        """Faults of one program behind a switch; what a program built of all of them cannot tell is planted alone."""
        numbers = {number: row for number, row in enumerate(batch, 1)}
        texts, single = {}, []
        for file in dict.fromkeys(row.file for row in batch):
            texts[file], outside = switched(text_of(file), {number: row for number, row in numbers.items() if row.file == file})
            single += outside
        left = {number: row for number, row in numbers.items() if row not in single}
        try:
            for program in worker.attempts(list(left.values()), texts) if left else ():
                for test_filter in sorted({row.filter for row in left.values()}):
                    status, _, failed = worker.run(program, test_filter, limits[batch[0].program, test_filter])
                    if status:
                        raise RuntimeError(f"{failed} fails without a fault")
                for number, row in list(left.items()):
                    status, _, failed = worker.run(program, row.filter, limits[row.program, row.filter], number)
                    if status:
                        del left[number]
                        say(f"{row.side:6} {row.name}: {tell(row, failed)}")
                if not left:
                    break
        except RuntimeError as error:
            say(f"{batch[0].program}: {len(left)} faults do not build together: {error}")
            single += left.values()
            left = {}
        for row in left.values():
            say(f"{row.side:6} {row.name}: {tell(row, '')}")
        for row in single:
            alone(worker, row)

    batches = collections.defaultdict(list)
    for row in rows:
        batches[row.program, row.side].append(row)
    jobs = [lambda worker, batch=batch: together(worker, batch) for (_, side), batch in batches.items() if side == "twin"]
    jobs += [lambda worker, row=row: alone(worker, row) for row in rows if row.side != "twin"]
    side_by_side(workers, jobs, lambda worker, job: job(worker))
    print(f"run_plants: {len(rows)} planted faults, {len(missed)} not noticed{': ' if missed else ''}{', '.join(sorted(missed))}")
    return 0 if len(seen) == len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
