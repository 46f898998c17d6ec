#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lists the decisions of the contracts (shaders/shared/*.h) and fails on one that nothing shows to matter.

A decision is a comparison (< > <= >= == != gt same), a logical && or ||, a min, max or clamp, or a choice (if, ?:, pick) whose condition holds
none of these. Each needs a planted fault in tests/fault/plants/ (one file a contract, and one each for `bound`, `measure`, `certificate` and the notes' own steps) that changes it or what it decides on, or a reason why there can be none:

    // no plant: reason        at the end of its line, or alone on the line above

A planted fault is four lines; run_plants.py shows that the named tests notice it:

    [name] SIDE PROGRAM FILTER       SIDE: device (the shader's text), twin (C++'s text), both; FILTER as for --gtest_filter
    FILE                             below shaders/ (shared/fill.h, fill.comp), or from the root
    - text                           exactly once in FILE; ^text: at the start of a line
    + replacement

usage: plants.py [ROOT]        exit 1 on a decision without a plant, or a row that fits nothing
       plants.py --list [ROOT] every decision and what covers it
       plants.py --self-test
"""
import os
import re
import sys
from collections import namedtuple

Row = namedtuple("Row", "name side program filter file text replacement place")
Decision = namedtuple("Decision", "line start end text first last")  # first, last: the extent, with what it decides on

COMPARISONS = ("<=", ">=", "==", "!=", "<", ">", "&&", "||")
FUNCTIONS = ("gt", "same", "min", "max", "clamp")
CHOICES = ("if", "?", "pick")
TOKEN = re.compile(r"[A-Za-z_]\w*|\d[\w.]*(?:[eE][+-]?\d+)?f?|<<=|>>=|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|\+\+|--|\S")
NO_PLANT = re.compile(r"//\s*no plant:\s*\S")


def tokens(text):
    """(token, start) of C or GLSL text without comments and directives, which are blanked in place."""
    blank = lambda m: re.sub(r"[^\n]", " ", m.group(0))
    text = re.sub(r"//[^\n]*|/\*.*?\*/", blank, text, flags=re.S)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.M)
    return [(m.group(0), m.start()) for m in TOKEN.finditer(text)]


def condition_of(words, at):
    """Token range of the condition of the choice at `at`."""
    if words[at][0] == "?":  # back to what the conditional expression starts after
        depth, i = 0, at - 1
        while i >= 0:
            word = words[i][0]
            if word in ")]":
                depth += 1
            elif word in "([":
                if depth == 0:
                    break
                depth -= 1
            elif depth == 0 and word in (";", "{", "}", ",", "=", "return", "?", ":"):
                break
            i -= 1
        return i + 1, at
    depth, i = 0, at + 1
    while i < len(words):
        word = words[i][0]
        depth += word in "(["
        depth -= word in ")]"
        if depth == 0 or (words[at][0] == "pick" and depth == 1 and word == ","):
            break
        i += 1
    return at + 2, i


def decisions(text):
    words, found = tokens(text), []
    called = lambda i: i + 1 < len(words) and words[i + 1][0] == "("
    # `bvec4 gt(vec4 a, ...)` declares: a name stands before it.
    declared = lambda i: i > 0 and re.match(r"[A-Za-z_]\w*$", words[i - 1][0]) and words[i - 1][0] not in ("return", "else")
    template = lambda i: i > 0 and words[i - 1][0] in ("static_cast", "bit_cast", "vector", "array", "span")
    decides = [i for i, (word, _) in enumerate(words)
               if (word in COMPARISONS and not template(i)) or (word in FUNCTIONS and called(i) and not declared(i))]
    closing = set()
    for i in range(len(words)):  # the > that closes static_cast<T
        if words[i][0] == "<" and template(i):
            closing.add(next((j for j in range(i, len(words)) if words[j][0] == ">"), -1))
    decides = [i for i in decides if i not in closing]
    for i, (word, _) in enumerate(words):
        if word in CHOICES and (word == "?" or called(i)) and not (word == "pick" and declared(i)):
            first, last = condition_of(words, i)
            if not any(first <= j < last for j in decides):
                decides.append(i)
    end = lambda i: words[i][1] + len(words[i][0])
    for i in sorted(decides):
        word, start = words[i]
        if called(i) and word not in COMPARISONS:
            depth = last = 0
            for last in range(i + 1, len(words)):
                depth += words[last][0] == "("
                depth -= words[last][0] == ")"
                if depth == 0:
                    break
            extent = start, end(last)
        elif word == "?":  # with both of its answers
            depth, last = 0, i
            while last + 1 < len(words) and depth >= 0:
                last += 1
                depth += words[last][0] in ("(", "[")
                depth -= words[last][0] in (")", "]")
                if depth <= 0 and words[last][0] in (";", ",", ")", "]"):
                    break
            extent = words[condition_of(words, i)[0]][1], end(last)
        else:
            extent = words[max(i - 1, 0)][1], end(min(i + 1, len(words) - 1))
        found.append(Decision(text.count("\n", 0, start) + 1, start, start + len(word), word, *extent))
    return found


def covered_by(part, found):
    """Decisions that a change of the range `part` is a fault of: those whose word it touches, and the innermost that it lies in."""
    touched = [d for d in found if part[0] < d.end and d.start < part[1]]
    around = [d for d in found if d.first <= part[0] and part[1] <= d.last]
    return touched + sorted(around, key=lambda d: d.last - d.first)[:1]


def read_rows(path):
    """Rows of one file, and what is wrong with it."""
    rows, faults = [], []
    with open(path, encoding="utf-8") as f:
        lines = [(n, line.rstrip("\n")) for n, line in enumerate(f, 1)]
    lines = [(n, line) for n, line in lines if line.strip() and not line.startswith("#")]
    at = 0
    while at < len(lines):
        n, head = lines[at]
        m = re.match(r"\[(\w+)\] (device|twin|both) (\w+) (\S+)$", head)
        block = [line for _, line in lines[at:at + 4]]
        if not m or len(block) < 4 or not block[2].startswith("- ") or not block[3].startswith("+"):
            faults.append(f"{path}:{n}: a row is `[name] side program filter`, a file, `- text` and `+ replacement`")
            while at < len(lines) and (lines[at][0] == n or not lines[at][1].startswith("[")):
                at += 1
            continue
        rows.append(Row(*m.groups(), block[1].strip(), block[2][2:], block[3][2:], f"{path}:{n}"))
        at += 4
    return rows, faults


def read_all(root):
    """Rows of all files of tests/fault/plants/, and what is wrong with them."""
    folder = os.path.join(root, "tests", "fault", "plants")
    rows, faults = [], []
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else ():
        more, wrong = read_rows(os.path.join(folder, name))
        rows += more
        faults += wrong
    names = [row.name for row in rows]
    faults += [f"{folder}: two rows are called {name}" for name in sorted({n for n in names if names.count(n) > 1})]
    return rows, faults


def places_of(text, row):
    """Where the text of a row stands. A leading ^ holds it to the start of a line."""
    if row.text.startswith("^"):
        return [m.start() for m in re.finditer("^" + re.escape(row.text[1:]), text, flags=re.M)]
    return [m.start() for m in re.finditer("(?=" + re.escape(row.text) + ")", text)]


def planted(text, row):
    at, length = places_of(text, row)[0], len(row.text.removeprefix("^"))
    return text[:at] + row.replacement + text[at + length:]


def path_of(root, file):
    below = os.path.join(root, "shaders", file)
    return below if os.path.isfile(below) else os.path.join(root, file)


def changed_range(text, replacement):
    """Part of `text` that a replacement changes, in whole tokens: a < that becomes <= is changed."""
    old, new = TOKEN.findall(text), TOKEN.findall(replacement)
    places = [m.span() for m in TOKEN.finditer(text)]
    first = 0
    while first < min(len(old), len(new)) and old[first] == new[first]:
        first += 1
    last = 0
    while last < min(len(old), len(new)) - first and old[-1 - last] == new[-1 - last]:
        last += 1
    changed = places[first:len(old) - last]
    if not changed and len(old) != len(new):  # only put in: a fault of what stands there
        changed = places[min(first, len(old) - 1):][:1]
    return (changed[0][0], changed[-1][1]) if changed else None


def check(root, list_all=False):
    folder = os.path.join(root, "shaders", "shared")
    rows, faults = read_all(root)
    covered = {}  # file -> [(start, end, row name)]
    for row in rows:
        path = path_of(root, row.file)
        if not os.path.isfile(path):
            faults.append(f"{row.place}: {row.name}: there is no {row.file}")
            continue
        with open(path, encoding="utf-8") as f:
            text = f.read()
        places = places_of(text, row)
        if len(places) != 1:
            faults.append(f"{row.place}: {row.name}: `{row.text}` stands {len(places)} times in {row.file}")
            continue
        part = changed_range(row.text.removeprefix("^"), row.replacement)
        if part is None:
            faults.append(f"{row.place}: {row.name}: changes nothing")
            continue
        at = places[0]
        covered.setdefault(os.path.relpath(path, root), []).append((at + part[0], at + part[1], row.name))
    total = reasons = 0
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".h"):
            continue
        path = os.path.join("shaders", "shared", name)
        with open(os.path.join(root, path), encoding="utf-8") as f:
            text = f.read()
        lines = text.split("\n")
        found = decisions(text)
        planted_here = [(d, row) for start, end, row in covered.get(path, []) for d in covered_by((start, end), found)]
        for d in found:
            total += 1
            above = lines[d.line - 2].strip() if d.line > 1 else ""
            reason = NO_PLANT.search(lines[d.line - 1]) or (above.startswith("//") and NO_PLANT.search(above))
            plants = sorted({row for other, row in planted_here if other == d})
            reasons += bool(reason)
            if list_all:
                says = ", ".join(plants) or ("no plant" if reason else "NOTHING")
                print(f"{path}:{d.line}: {d.text:4} {says:30} {lines[d.line - 1].strip()}")
            elif not reason and not plants:
                faults.append(f"{path}:{d.line}: `{d.text}` has no planted fault: {lines[d.line - 1].strip()}")
    return total, len(rows), reasons, faults


def self_test():
    text = ("#if a < b\n"
            "// x < y\n"
            "bool wins(int z, int t, int bestZ, int bestT) { return z > bestZ || (z == bestZ && t < bestT); }\n"
            "float pick(bool c, float a, float b) { return c ? a : b; }\n"
            "uint f(uint x) { if (ready) x <<= 1u; x = x >> 2; return pick(x == 1u, 2u, pick(take, 3u, min(x, 4u))); }\n"
            "for (int i = 0; i < 4; ++i) {}\n"
            "int k = static_cast<int>(x);\n")
    found = [(d.line, d.text) for d in decisions(text)]
    want = [(3, ">"), (3, "||"), (3, "=="), (3, "&&"), (3, "<"), (4, "?"), (5, "if"), (5, "=="), (5, "pick"), (5, "min"), (6, "<")]
    ok = found == want
    ok &= changed_range("a < b", "a <= b") == (2, 3)
    ok &= changed_range("z == best && t < u", "false") == (0, 18)
    ok &= changed_range("z == best && t < u", "z == best && u < t") == (13, 18)
    ok &= changed_range("a < b", "a  <  b") is None
    ok &= changed_range("if (a)", "if (!a)") == (4, 5)
    nested = "max(max(a, b), c); x == 3u; if (y) z;"
    hit = lambda part: sorted((d.start, d.text) for d in covered_by(part, decisions(nested)))
    ok &= hit((4, 16)) == [(0, "max"), (4, "max")] and hit((8, 9)) == [(4, "max")] and hit((24, 26)) == [(21, "==")] and hit((32, 33)) == [(28, "if")]
    print(f"plants --self-test: {'right' if ok else f'wrong: {found}'}")
    return 0 if ok else 1


def main():
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        return self_test()
    list_all = "--list" in arguments
    arguments = [a for a in arguments if a != "--list"]
    root = arguments[0] if arguments else os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    total, rows, reasons, faults = check(root, list_all)
    for fault in faults:
        print(fault)
    print(f"plants: {total} decisions, {rows} planted faults, {reasons} with a reason for none, {len(faults)} faults")
    return 1 if faults or total == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
