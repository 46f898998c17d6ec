#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Holds the names that the shared library exports to its public headers and to the list that makes them.

A name is exported when and only when a public header declares it: every exported name stands in a header, every function or class of a header that the
static library defines is exported, every line of the list exports something, and nothing but names of `plumb` is exported. The shared library asks for
itself by a name with its version.

usage: library_symbols.py LIBRARY.so LIBRARY.a HEADERS MAP SONAME   exit 0: clean; 1: one line for each fault on stdout
       library_symbols.py --self-test                               exit 1 when a fault goes unnoticed
"""
import fnmatch
import os
import re
import subprocess
import sys

THROWN = re.compile(r"(typeinfo|typeinfo name|vtable) for (plumb::\w+)$")


def names_of(*command):
    """Demangled names of the defined symbols that nm lists."""
    listed = subprocess.run(["nm", "--defined-only", "-C", *command], capture_output=True, text=True, check=True).stdout
    return {match.group(2): match.group(1) for match in re.finditer(r"^[0-9a-f]+ (\w) (.+)$", listed, re.M)}


def patterns_of(text):
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    block = re.search(r'extern "C\+\+" \{(.*?)\};', text, re.S).group(1)
    return [line.strip(' ";') for line in block.splitlines() if line.strip(' ";')]


def first_word(name):
    """What of namespace plumb a name belongs to: `Device` of `plumb::Device::list(...)`."""
    return re.match(r"plumb::(~?\w+)", name)


def faults_of(exported, static, headers, patterns):
    code = re.sub(r"//[^\n]*", "", headers)
    for name in sorted(exported):
        thrown = THROWN.match(name)
        word = first_word(thrown.group(2) if thrown else name)
        if word is None:
            yield f"exported, and no name of plumb: {name}"
        elif not re.search(rf"\b{re.escape(word.group(1))}\b", code):
            yield f"exported, and no public header has it: {name}"
        elif "::Impl::" in name:
            yield f"exported, and private: {name}"
    for pattern in patterns:
        if not any(name == pattern or fnmatch.fnmatchcase(name, pattern.replace("[", "[[]")) for name in exported):
            yield f"this line of the list exports nothing: {pattern}"
    shown = {first_word(name).group(1) for name in exported if first_word(name)}
    for name, kind in sorted(static.items()):
        word = first_word(name)
        if kind != "T" or word is None or word.group(1) in shown:
            continue
        own = re.escape(word.group(1))
        if re.search(rf"^(?!inline\b|constexpr\b)[\w:][\w:<>,&* ]* [&*]?{own}\([^;{{}}]*;", code, re.M) or re.search(rf"\b(class|struct) {own}\b[^;{{]*\{{", code):
            yield f"declared in a public header and not exported: {name}"
            shown.add(word.group(1))


def self_test():
    headers = "// hidden()\nclass Device {\n    void list();\n};\nuint32_t addMesh(Scene&);\nstruct Later;\ntemplate <class T>\nint shown(T) {\n    return 1;\n}\ninline int seen(int);\n"
    exported = {"plumb::Device::list()": "T", "plumb::addMesh(plumb::Scene&)": "T"}
    static = dict(exported, **{"plumb::inner()": "T", "plumb::Later::go()": "T", "plumb::shown(int)": "T", "plumb::seen(int)": "T"})
    patterns = ["plumb::Device::*", "plumb::addMesh*"]
    cases = [("clean", exported, static, patterns, 0), ("a name of another", dict(exported, **{"fmt::print()": "T"}), static, patterns, 1),
             ("a name that no header has", dict(exported, **{"plumb::hidden()": "T"}), static, patterns, 1), ("a private name", dict(exported, **{"plumb::Device::Impl::go()": "T"}), static, patterns, 1),
             ("a dead line", exported, static, patterns + ["plumb::gone*"], 1), ("a class is missing", {"plumb::addMesh(plumb::Scene&)": "T"}, static, patterns[1:], 1),
             ("a function is missing", {"plumb::Device::list()": "T"}, static, patterns[:1], 1)]
    wrong = [f"{what}: {found}" for what, e, s, p, count in cases if len(found := list(faults_of(e, s, headers, p))) != count]
    print("\n".join(wrong) or f"library_symbols --self-test: {len(cases)} cases")
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    shared, static, include, script, soname = sys.argv[1:]
    headers = ""
    for folder, _, names in os.walk(include):
        for name in sorted(names):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                headers += file.read() + "\n"
    with open(script, encoding="utf-8") as file:
        patterns = patterns_of(file.read())
    exported = names_of("-D", shared)
    found = list(faults_of(exported, names_of(static), headers, patterns))
    dynamic = subprocess.run(["readelf", "-d", shared], capture_output=True, text=True, check=True).stdout
    if f"soname: [{soname}]" not in dynamic:
        found.append(f"{shared}: its soname is not {soname}")
    print("\n".join(found) or f"library_symbols: {len(exported)} names are exported, {len(patterns)} lines of the list")
    return 1 if found or not exported else 0


if __name__ == "__main__":
    sys.exit(main())
