#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""clang-tidy over our own translation units of a Ninja build tree, in parallel. A unit that was clean is not judged again until it, a file it
includes, its flags or .clang-tidy changes.

Most of the time goes into headers, so units with the same flags are judged as one text. A text with a finding is judged anew, unit by unit. With
--alone every unit is judged by itself, which also sees a using declaration that only another unit of its text uses.

usage: tidy.py BUILD [JOBS] [--alone] [SOURCE...]    SOURCE: a file, or a folder with all below it
"""
import collections
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys

import compile_words

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
OWN = ("host/", "pipeline/", "tests/", "toolchain/")


def inside(path):
    path = os.path.relpath(path, ROOT)
    return path if path.startswith(OWN) else None


def units(build):
    """{object: (source, arguments for clang)}"""
    text = subprocess.run(["ninja", "-C", build, "-t", "compdb"], check=True, capture_output=True, text=True).stdout
    found = {}
    for entry in json.loads(text):
        source = os.path.normpath(os.path.join(build, entry["file"]))
        if not source.endswith(".cpp") or not inside(source) or " -c " not in entry["command"]:
            continue
        words, _ = compile_words.without_precompiled(compile_words.of_compiler(shlex.split(entry["command"])))
        found[entry["output"]] = (source, compile_words.without(words[1:], ("-MD", "-c", source, entry["file"]), ("-o", "-MF", "-MT")))
    return found


def included(build):
    """{object: files it was made of}, as the last build saw them."""
    text = subprocess.run(["ninja", "-C", build, "-t", "deps"], check=True, capture_output=True, text=True).stdout
    found, current = {}, None
    for line in text.splitlines():
        if line and not line.startswith(" "):
            current = found.setdefault(line.split(": #deps")[0], [])
        elif line.strip():
            current.append(os.path.normpath(os.path.join(build, line.strip())))
    return found


def key_of(source, arguments, files):
    digest = hashlib.sha256(repr(arguments).encode())
    for path in [os.path.join(ROOT, ".clang-tidy"), source] + sorted(f for f in files if f.startswith(ROOT + os.sep)):
        digest.update(path.encode())
        with open(path, "rb") as f:
            digest.update(f.read())
    return digest.hexdigest()


def judge(build, source, arguments):
    done = subprocess.run(["clang-tidy", "--quiet", f"--config-file={ROOT}/.clang-tidy", source, "--"] + arguments +
                          ["-Wno-unknown-warning-option", "-Wno-ignored-optimization-argument"],
                          cwd=build, capture_output=True, text=True)
    return done.returncode, done.stdout + (done.stderr if done.returncode and not done.stdout else "")


MOST_TOGETHER = 10
# A definition in the first column; what stands in a class or a function is indented.
NAME = re.compile(r"^(?:struct|class|enum class|enum|union)\s+(\w+)|^(?!\s|return|else|if|for|while|namespace|static_assert|#|//)[\w:<>,*& \[\]]*?(?<!:)\b(\w+)\s*(?:\(|=|\{|\[)", re.M)


def batches(todo):
    """Lists of units that can be one text: of the same flags, and with no name defined in two of them."""
    finished, filling = [], collections.defaultdict(list)  # flags -> [(units, names)]
    for unit in todo:
        source, arguments, _ = unit
        with open(source, encoding="utf-8") as f:
            names = {a or b for a, b in NAME.findall(f.read())}
        places = filling[tuple(arguments)]
        for place in places:
            if not place[1] & names:
                place[0].append(unit)
                place[1].update(names)
                break
        else:
            place = ([unit], names)
            places.append(place)
        if len(place[0]) == MOST_TOGETHER:
            places.remove(place)
            finished.append(place[0])
    return finished + [units for places in filling.values() for units, _ in places]


def judge_together(build, number, batch):
    """[(unit, code, text)] of a batch."""
    if len(batch) > 1:
        path = os.path.join(build, "tidy", f"together{number}.cpp")
        with open(path, "w", encoding="utf-8") as out:
            for source, _, _ in batch:
                with open(source, encoding="utf-8") as f:
                    out.write(f.read() + "\n")
        if judge(build, path, batch[0][1])[0] == 0:
            return [(unit, 0, "") for unit in batch]
    return [(unit, *judge(build, unit[0], unit[1])) for unit in batch]


def main():
    alone = "--alone" in sys.argv
    if alone:
        sys.argv.remove("--alone")
    if len(sys.argv) < 2 or not os.path.exists(os.path.join(sys.argv[1], "build.ninja")):
        print("usage: tidy.py BUILD [JOBS] [SOURCE...]    BUILD: a Ninja tree that is built")
        return 2
    build = os.path.abspath(sys.argv[1])
    jobs = int(sys.argv[2]) if len(sys.argv) > 2 else os.cpu_count()
    only = [os.path.abspath(path) for path in sys.argv[3:]]
    wrong = [path for path in only if not os.path.exists(path)]
    if wrong:
        print(f"tidy.py: {wrong[0]} is not there")
        return 2
    stamps = os.path.join(build, "tidy")
    os.makedirs(stamps, exist_ok=True)
    files, todo = included(build), []
    everything, chosen = units(build), 0
    for output, (source, arguments) in sorted(everything.items()):
        if only and not any(source == path or source.startswith(path + os.sep) for path in only):
            continue
        chosen += 1
        stamp = os.path.join(stamps, key_of(source, arguments, files.get(output, [])))
        if not os.path.exists(stamp + ".alone") and (alone or not os.path.exists(stamp)):
            todo.append((source, arguments, stamp + ".alone" if alone else stamp))
    faulty = 0
    work = [[unit] for unit in todo] if alone else batches(todo)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for judged in pool.map(lambda w: judge_together(build, *w), enumerate(sorted(work, key=len, reverse=True))):
            for (source, _, stamp), code, text in judged:
                if code:
                    faulty += 1
                    print(f"{inside(source)}:\n{text}", flush=True)
                else:
                    open(stamp, "w").close()
    print(f"tidy: {chosen} of {len(everything)} units, {len(todo)} judged now in {len(work)} texts, {faulty} with faults")
    return 1 if faulty or not chosen else 0


if __name__ == "__main__":
    sys.exit(main())
