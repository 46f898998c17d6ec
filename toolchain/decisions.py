#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Holds docs/decisions.md to its form, and writes its index.

An entry is a heading `### 57. Title`, a line `2026-11-22 · in force` or `2026-11-22 · replaced by [71](#...)`, and a paragraph that opens with
the decision in bold. Numbers are given once each, without a gap. The index on top has a row for each entry.

usage: decisions.py              exit 0: the page is in form; 1: one line for each fault on stdout
       decisions.py --index      writes the index
       decisions.py --self-test  exit 1 when a fault goes unnoticed
"""
import os
import re
import sys

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs", "decisions.md")
STATUS = re.compile(r"\d{4}-\d\d-\d\d · (?:in force(?:; .+)?|replaced by \[\d+\]\(#[\w-]+\)(?: and \[\d+\]\(#[\w-]+\))*)$")
INDEX = re.compile(r"(^## Index\n\n).*?(?=^## )", re.M | re.S)


def slug(heading):
    """A heading's anchor, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower()).replace(" ", "-")


def entries(text):
    """(room, number, title, status line, text below it) of each entry, in the order of the page."""
    room = None
    for part in re.split(r"^(?=##)", text, flags=re.M):
        heading, _, body = part.partition("\n")
        if entry := re.match(r"### (\d+)\. (.+)$", heading):
            status, _, rest = body.strip("\n").partition("\n")
            yield room, int(entry.group(1)), entry.group(2), status, rest
        elif heading.startswith("## "):
            room = heading[3:]


def index(text):
    lines, last = ["| # | decision | date | status |", "|---|---|---|---|"], None
    for room, number, title, status, _ in entries(text):
        if room != last:
            lines.append(f"| | **{room}** | | |")
            last = room
        date, _, word = status.partition(" · ")
        lines.append(f"| {number} | [{title}](#{slug(f'{number}. {title}')}) | {date} | {word} |")
    return "\n".join(lines) + "\n\n"


def with_index(text):
    return INDEX.sub(lambda m: m.group(1) + index(text), text)


def check(text):
    found = list(entries(text))
    numbers = [number for _, number, *_ in found]
    for number in range(1, max(numbers, default=0) + 1):
        if numbers.count(number) != 1:
            yield f"decision {number}: has {numbers.count(number)} entries; a number is given once, and none is left out"
    for _, number, title, status, rest in found:
        if not STATUS.match(status):
            yield f"decision {number}: the line below its heading is no date and status: {status[:60]!r}"
        if not re.match(r"\n\*\*[^*]+\*\*", rest):
            yield f"decision {number}: does not open with the decision in bold"
    anchors = {slug(f"{number}. {title}") for _, number, title, *_ in found}
    for anchor in re.findall(r"\]\(#(\d[\w-]*)\)", text):
        if anchor not in anchors:
            yield f"a link to #{anchor}: there is no such entry"
    if with_index(text) != text:
        yield "its index is not that of its entries; write it with: toolchain/decisions.py --index"


def self_test():
    clean = with_index("# Decisions\n\n## Index\n\n## A room\n\n### 1. One `thing`\n\n2026-11-22 · in force\n\n**It is so.** Why.\n\n"
                       "### 2. Two\n\n2026-11-22 · replaced by [1](#1-one-thing)\n\n**It is not.**\n")
    wrong = [f"clean: {fault}" for fault in check(clean)]
    for claim, old, new in [("a number twice", "### 2. Two", "### 1. Two"), ("a number left out", "### 2. Two", "### 3. Two"), ("no date", "\n2026-11-22 · in force", "\nin force"),
                            ("another status", "· in force\n", "· forgotten\n"), ("no decision", "**It is so.** Why.", "It is so."), ("a dead link", "](#1-one-thing)\n", "](#1-one)\n"),
                            ("an old index", "### 2. Two\n", "### 2. Three\n")]:
        changed = clean.replace(old, new)
        if changed == clean or not list(check(changed)):
            wrong.append(f"{claim}: unnoticed")
    for line in wrong:
        print(line)
    print(f"decisions --self-test: {len(wrong)} wrong answers")
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    with open(PAGE, encoding="utf-8") as f:
        text = f.read()
    if sys.argv[1:] == ["--index"]:
        with open(PAGE, "w", encoding="utf-8") as f:
            f.write(with_index(text))
        return 0
    faults = list(check(text))
    for fault in faults:
        print("docs/decisions.md: " + fault)
    print(f"decisions: {len(list(entries(text)))} entries, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
