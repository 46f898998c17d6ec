#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Holds the code that a page quotes to the sources.

A block is a quotation when a path stands behind the language of its fence: ```glsl shaders/resolve.comp. Its lines must stand in that file in their
order; a line `...` leaves some out, and lines between two quoted ones without it are a fault. White space and comments are not compared.

usage: quotations.py PAGE...     exit 0: every quotation is in its file; 1: one line for each fault on stdout
       quotations.py --self-test exit 1 when a changed quotation goes unnoticed
"""
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
FENCE = re.compile(r"^ *```(\w+) ([\w./-]+)\n(.*?)^ *```$", re.M | re.S)


def code_of(text, path):
    """Lines without comments and white space; empty ones are left out."""
    mark = "#" if path.endswith((".txt", ".cmake", ".py", ".sh")) else "//"
    lines = (re.sub(rf"(^|\s){mark}.*$", "", line) for line in text.splitlines())
    return [line for line in (re.sub(r"\s+", " ", line).strip() for line in lines) if line]


def fault_of(quoted, source, path):
    """The first quoted line that is not where it should be, or None."""
    source, at, free = code_of(source, path), 0, True
    for line in code_of(quoted, path):
        if line == "...":
            free = True
        elif free:
            if line not in source[at:]:
                return line
            at, free = source.index(line, at) + 1, False
        elif at < len(source) and source[at] == line:
            at += 1
        else:
            return line
    return None


def check(page, text, read):
    for fence in FENCE.finditer(text):
        language, path, quoted = fence.groups()
        where = f"{page}:{text.count(chr(10), 0, fence.start()) + 1}"
        source = read(path)
        if source is None:
            yield f"{where}: {path}: there is no such file"
        elif (line := fault_of(quoted, source, path)) is not None:
            yield f"{where}: {path} does not have there: {line}"


def self_test():
    source = "// A.\nint a() {  // why\n    return 1;\n}\n\nint b() {\n    return 2;\n}\n"
    read = lambda path: source if path == "a.cpp" else None
    block = lambda quoted, path="a.cpp": f"Text.\n\n```cpp {path}\n{quoted}```\n\n```cpp\nother();\n```\n"
    cases = [("whole", block(source), 0), ("another comment", block("int a() {\n  return 1; // x\n}\n"), 0), ("left out", block("int a() {\n...\nint b() {\n"), 0),
             ("a changed line", block("int a() {\n    return 3;\n"), 1), ("another order", block("int b() {\n...\nint a() {\n"), 1), ("a gap", block("int a() {\nint b() {\n"), 1),
             ("no file", block("int a() {\n", "b.cpp"), 1), ("in a list", "- A:\n\n  ```cpp a.cpp\n  int a() {\n      return 3;\n  ```\n", 1)]
    wrong = [claim for claim, text, faults in cases if len(list(check("page", text, read))) != faults]
    for claim in wrong:
        print(f"{claim}: wrong answer")
    print(f"quotations --self-test: {len(cases)} cases, {len(wrong)} wrong answers")
    return 1 if wrong else 0


def read_file(path):
    path = os.path.join(ROOT, path)
    if not os.path.isfile(path):
        return None
    with open(path, encoding="utf-8") as f:
        return f.read()


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if not sys.argv[1:]:
        sys.exit(__doc__.strip())
    faults, count = [], 0
    for page in sys.argv[1:]:
        with open(page, encoding="utf-8") as f:
            text = f.read()
        count += len(FENCE.findall(text))
        faults += check(page, text, read_file)
    for fault in faults:
        print(fault)
    print(f"quotations: {count} quotations, {len(faults)} faults")
    return 1 if faults or not count else 0


if __name__ == "__main__":
    sys.exit(main())
