#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares docs/notes-coverage.md with the tests: every row names tests that exist, in files that a CMakeLists.txt beside them runs, or says what is open.

usage: notes_coverage.py [ROOT]      exit 1 on a row with neither, an unknown test, or another number of rows
       notes_coverage.py --self-test
"""
import os
import re
import sys
import tempfile

ROWS = 86  # systems of parts 1 to 4
TEST = re.compile(r"^\s*TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\)|^\s*GOLDEN\(\s*(\w+)\s*\)", re.M)
PYTHON = re.compile(r"^class (\w+)\([\w.]+\)|^    def (test_\w+)\(", re.M)


LOOP = re.compile(r"foreach\((\w+) ([^)]*)\)(.*?)endforeach", re.S)


PASSES = re.compile(r"^plumb_add_pass\((\w+)\)", re.M)


def files_run_by(text, passes=()):
    """Words of a CMakeLists.txt that may be names of files, plain loops and those over all passes unrolled."""
    text = text.replace("${passes}", " ".join(passes))
    text = LOOP.sub(lambda m: "".join(m.group(3).replace("${" + m.group(1) + "}", word) for word in m.group(2).split()), re.sub(r"#.*", "", text))
    return set(re.findall(r"[\w.]+", text))


def tests_of(root):
    names, passes = set(), []
    listed = os.path.join(root, "pipeline", "passes", "CMakeLists.txt")
    if os.path.exists(listed):
        with open(listed, encoding="utf-8") as f:
            passes = PASSES.findall(f.read())
    for folder, _, files in os.walk(os.path.join(root, "tests")):
        if "CMakeLists.txt" not in files:
            continue
        with open(os.path.join(folder, "CMakeLists.txt"), encoding="utf-8") as f:
            run = files_run_by(f.read(), passes)
        for file in files:
            if not file.endswith((".cpp", ".py")) or file not in run:
                continue
            with open(os.path.join(folder, file), encoding="utf-8") as f:
                text = f.read()
            if file.endswith(".py"):
                owner = None
                for m in PYTHON.finditer(text):
                    owner = m.group(1) or owner
                    if m.group(2):
                        names.add(f"{owner}.{m.group(2)}")
            else:
                names.update(f"Golden.{m.group(3)}" if m.group(3) else f"{m.group(1)}.{m.group(2)}" for m in TEST.finditer(text))
    return names


def check(text, names):
    faults, rows, done, partly, nothing = [], 0, 0, 0, 0
    for number, line in enumerate(text.splitlines(), 1):
        for name in re.findall(r"`(\w+\.\w+)`", line):
            if name not in names and not name.endswith(".py"):
                faults.append(f"docs/notes-coverage.md:{number}: there is no test {name}")
        if not re.match(r"\| \d+ \|", line):
            continue
        rows += 1
        cells = [c.strip() for c in line.strip("|").split(" | ")]
        if len(cells) < 4 or not cells[0].isdigit() or int(cells[0]) != rows:
            faults.append(f"docs/notes-coverage.md:{number}: row {rows} is out of order or lacks cells")
            continue
        tests = re.findall(r"`(\w+\.\w+)`", line)
        rest = line.rstrip(" |").rsplit("|", 1)[1].strip()
        if not tests and not rest.startswith("open: "):
            faults.append(f"docs/notes-coverage.md:{number}: row {rows} names no test and is not open")
        if not tests:
            nothing += 1
        elif rest and "`" not in rest:
            partly += 1
        else:
            done += 1
    if rows != ROWS:
        faults.append(f"docs/notes-coverage.md: {rows} rows, not {ROWS}")
    return faults, done, partly, nothing


def self_test():
    good = "".join(f"| {i} | 1 | x | `A.b` |  |\n" for i in range(1, ROWS)) + f"| {ROWS} | 1 | x |  | open: y |\n"
    cases = {"good": (good, 0), "an unknown test": (good.replace("`A.b`", "`A.c`", 1), 1), "a row less": (good[good.index("\n") + 1:], 1),
             "neither": (good.replace("open: y", ""), 1), "an empty page": ("", 1)}
    wrong = [name for name, (text, fails) in cases.items() if bool(check(text, {"A.b"})[0]) != bool(fails)]
    # A test that no CMakeLists.txt runs is none.
    with tempfile.TemporaryDirectory() as root:
        os.makedirs(os.path.join(root, "tests", "unit"))
        os.makedirs(os.path.join(root, "pipeline", "passes"))
        with open(os.path.join(root, "pipeline", "passes", "CMakeLists.txt"), "w", encoding="utf-8") as f:
            f.write("function(plumb_add_pass stem)\nplumb_add_pass(fill)  # all\n")
        for name, text in {"CMakeLists.txt": "# idle_test.cpp\nforeach(x a c)\n  plumb_test(${x}_test SOURCES ${x}_test.cpp)\nendforeach()\nforeach(pass ${passes})\n  plumb_test(${pass}_test SOURCES ${pass}_test.cpp)\nendforeach()\nadd_test(COMMAND b_test.py)\n", "fill_test.cpp": "TEST(Fill, c) {\n", "a_test.cpp": "TEST(A, b) {\n", "idle_test.cpp": "TEST(Idle, b) {\n",
                           "b_test.py": "class B(Case):\n    def test_c(self):\n"}.items():
            with open(os.path.join(root, "tests", "unit", name), "w", encoding="utf-8") as f:
                f.write(text)
        if tests_of(root) != {"A.b", "B.test_c", "Fill.c"}:
            wrong.append(f"tests found: {tests_of(root)}")
    print(f"notes_coverage --self-test: {len(cases)} pages and a folder of tests, wrong: {wrong}")
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    with open(os.path.join(root, "docs/notes-coverage.md"), encoding="utf-8") as f:
        faults, done, partly, nothing = check(f.read(), tests_of(root))
    for fault in faults:
        print(fault)
    print(f"notes_coverage: {done} rows with tests, {partly} with tests and something open, {nothing} open; {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
