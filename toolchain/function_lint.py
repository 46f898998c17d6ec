#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fails on a function of the product (host/, pipeline/, shaders/; C++ and GLSL) that is longer than 100 lines, counted from the line of its name to that of
its closing brace, and on a file of pipeline/render/ that is longer than 350. A lambda counts as part of the function around it.

A file whose braces do not match is a fault too, since nothing below them is judged.

usage: function_lint.py [ROOT]       exit 0: clean; 1: one line for each fault on stdout
       function_lint.py --longest N  prints the N longest functions
       function_lint.py --self-test  exit 1 when a long function goes unnoticed, or a short one is taken for long
"""
import os
import re
import sys
import tempfile

FOLDERS = ("host", "pipeline", "shaders")
ENDINGS = (".h", ".hpp", ".cpp", ".comp", ".glsl", ".vert", ".frag")
MOST_LINES = 100
FILE_FOLDER, MOST_FILE_LINES = "pipeline/render/", 350

# What may hold a brace that opens nothing. Numbers come before characters, since 1'000 is one.
OPAQUE = re.compile(r"""(?P<raw>\b(?:u8|[uUL])?R"(?P<mark>[^()\\\s]*)\(.*?\)(?P=mark)")"""
                    r"""|(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<string>"(?:\\.|[^"\\\n])*")|(?P<number>\b\d[\w.']*)|(?P<char>'(?:\\.|[^'\\\n])+')""", re.S)
PREPROCESSOR = re.compile(r"^[ \t]*#[ \t]*(\w*)(?:\\\n|[^\n])*", re.M)
TYPE = re.compile(r"(?:^|[^\w.])(?:enum|class|struct|union)\b")
NOT_A_NAME = {"alignas", "decltype", "explicit", "layout", "noexcept", "requires", "__attribute__", "declspec"}
# Between the last parameter list, or the last member that a constructor makes, and the body.
AFTER_PARAMETERS = re.compile(r"\s*(?:(?:const|volatile|noexcept|override|final|mutable|constexpr|try|&&?)\s*)*(?:->\s*[\w:<>,*&\s]+)?$")


def blanked(text):
    """Text without comments, literals and preprocessor lines, of the same lines; and the preprocessor's conditionals by line."""
    keep = lambda m: m.group() if m.group("number") else '""' * (m.group("string") is not None) + re.sub(r"[^\n]", "", m.group())
    text = OPAQUE.sub(keep, text)
    conditionals = {}
    for m in PREPROCESSOR.finditer(text):
        if m.group(1) in ("if", "ifdef", "ifndef", "else", "elif", "endif"):
            conditionals[text.count("\n", 0, m.start())] = m.group(1)
    return PREPROCESSOR.sub(lambda m: re.sub(r"[^\n]", "", m.group()), text), conditionals


def without_angles(head):
    """Text without what stands between < and >, as far as it is template arguments."""
    before = None
    head = re.sub(r"operator\s*(?:<=>|<<=?|>>=?|<=|>=|<|>|->)", lambda m: "operator_" + " " * (len(m.group()) - 9), head)
    while before != head:
        before, head = head, re.sub(r"<[^<>;{}]*>", lambda m: " " * len(m.group()), head)
    return head


def name_of(head):
    """(name, offset) of the function that a head declares, or None when the brace after it opens no function."""
    flat = without_angles(head)
    groups, depth = [], 0
    for at, c in enumerate(flat):
        if c == "(":
            depth += 1
            if depth == 1:
                groups.append([at, at])
        elif c == ")" and depth:
            depth -= 1
            groups[-1][1] = at
    if depth or not groups or not AFTER_PARAMETERS.match(flat[groups[-1][1] + 1:]):
        return None
    if lambda_ := re.search(r"\[[^\[\]]*\]\s*$", flat[:groups[-1][0]]):
        named = re.search(r"([\w.]+)\s*=\s*$", flat[:lambda_.start()])
        return (named.group(1) if named else "lambda", named.start() if named else lambda_.start())
    # The parameters are the last list, or the one before a constructor's members. What calls a macro may stand before.
    found = None
    for first, last in groups:
        m = re.search(r"(operator\s*[^\s\w(]{1,3}|~?[A-Za-z_][\w:~]*)\s*$", flat[:first])
        name = " ".join(head[m.start():m.end()].split()) if m else None
        if name and name.endswith("operator"):  # operator()
            return name + "()", m.start()
        if name and name not in NOT_A_NAME:
            found = name, m.start()
            if re.match(r"[\w\s]*:(?!:)", flat[last + 1:]):
                break
    return found


def functions_of(text):
    """[(name, first line, last line)] of a file, and where its braces do not match, or None."""
    text, conditionals = blanked(text)
    found, scopes, saved = [], [], []  # scope: [kind, name, line, head before it]; saved: scopes and head at each #if
    head, head_line = "", 1
    for number, line in enumerate(text.split("\n"), 1):
        word = conditionals.get(number - 1)
        if word in ("if", "ifdef", "ifndef"):
            saved.append(([list(s) for s in scopes], head, head_line))
        elif word in ("else", "elif") and saved:  # begins where the first branch began
            scopes, head, head_line = [list(s) for s in saved[-1][0]], saved[-1][1], saved[-1][2]
        elif word == "endif" and saved:
            saved.pop()
        for c in line:
            inside = bool(scopes) and scopes[-1][0] == "function"
            if c == "{":
                kind, name, at = "block", None, number
                if inside:
                    kind = "function"
                elif declared := name_of(head):
                    kind, name, at = "body", declared[0], head_line + head.count("\n", 0, declared[1])
                elif re.search(r"\bnamespace\b", head) or (TYPE.search(without_angles(head)) and "=" not in head) or re.search(r'extern\s*""\s*$', head):
                    kind = "scope"
                scopes.append(["function" if kind == "body" else kind, name, at, (head, head_line)])
                head, head_line = "", number
            elif c == "}":
                if not scopes:
                    return found, f"{number}: a brace that nothing opened"
                kind, name, at, before = scopes.pop()
                if name:
                    found.append((name, at, number))
                # A braced value is part of the declaration around it.
                if kind == "block":
                    head, head_line = before[0] + "()", before[1]
                    head += "\n" * (number - head_line - head.count("\n"))
                else:
                    head, head_line = "", number
            elif c == ";" and not inside:
                head, head_line = "", number
            elif not inside and (head or not c.isspace()):
                if not head:
                    head_line = number
                head += c
        if head:
            head += "\n"
    return found, f"{scopes[-1][2]}: a brace that nothing closes" if scopes else None


def files_of(root):
    for folder in FOLDERS:
        for path, folders, names in os.walk(os.path.join(root, folder)):
            folders.sort()
            for name in sorted(names):
                if name.endswith(ENDINGS):
                    full = os.path.join(path, name)
                    with open(full, encoding="utf-8") as file:
                        yield os.path.relpath(full, root), file.read()


def faults_of(root):
    for path, text in files_of(root):
        functions, broken = functions_of(text)
        if broken:
            yield f"{path}:{broken}"
        for name, first, last in functions:
            if last - first + 1 > MOST_LINES:
                yield f"{path}:{first}: {name} has {last - first + 1} lines; at most {MOST_LINES}: give its parts names"
        lines = text.count("\n")
        if path.startswith(FILE_FOLDER) and lines > MOST_FILE_LINES:
            yield f"{path}:1: the file has {lines} lines; at most {MOST_FILE_LINES}: divide it by subject"


def body(lines, text="x();"):
    return "".join(f"    {text}\n" for _ in range(lines))


def self_test():
    long_, short = body(99), body(98)  # with the name's line and the brace's: 101 and 100
    # name -> (path, text, functions that must be found; "" where a file is the fault)
    cases = {
        "plain": ("host/a.cpp", f"void f() {{\n{long_}}}\n", ["f"]),
        "of exactly 100 lines": ("host/b.cpp", f"void f() {{\n{short}}}\n", []),
        "two short ones": ("host/c.cpp", f"void f() {{\n{short}}}\nvoid g() {{\n{short}}}\n", []),
        "in namespaces": ("pipeline/a.cpp", f"namespace a::b {{\nnamespace {{\nint f(int x) {{\n{long_}}}\n}}\n}}\n", ["f"]),
        "a long namespace": ("pipeline/b.cpp", f"namespace a {{\n{body(200, 'int x();')}}}\n", []),
        "a long class": ("pipeline/c.h", f"class A : public B<int> {{\npublic:\n{body(200, 'int x() const {{ return 1; }}')}private:\n    int y_{{0}};\n}};\n", []),
        "a method": ("pipeline/d.h", f"struct A {{\n    int y{{0}};\n    double f() const noexcept override {{\n{long_}    }}\n}};\n", ["f"]),
        "an enumeration": ("pipeline/e.h", "enum class A : int {\n" + body(200, "x,") + "};\n", []),
        "a constructor": ("pipeline/f.cpp", f"A::A(int a)\n    : a_(a),\n      b_{{a, {{1}}}},\n      c_{{}} {{\n{long_}}}\n", ["A::A"]),
        "a destructor": ("pipeline/g.cpp", f"A::~A() {{\n{long_}}}\n", ["A::~A"]),
        "operators": ("pipeline/h.cpp", f"bool operator==(const A& a, const A& b) {{\n{long_}}}\nint A::operator()(int x) const {{\n{long_}}}\n"
                      f"bool A::operator<(const A& b) const {{\n{long_}}}\n", ["operator==", "A::operator()", "A::operator<"]),
        "templates": ("pipeline/i.h", "template <class T, class F = std::function<void(int)>>\nstd::map<int, std::vector<T>> f(const std::function<void(double)>& g) {\n"
                      f"{long_}}}\n", ["f"]),
        "a trailing type": ("pipeline/j.cpp", f"auto f(int x) -> std::vector<int> {{\n{long_}}}\n", ["f"]),
        "a function in a function's lambda": ("pipeline/k.cpp", f"void f() {{\n    const auto g = [&](int x) {{\n{body(50)}    }};\n{body(50)}}}\n", ["f"]),
        "a lambda of the file": ("pipeline/l.cpp", f"const auto g = [](int x) {{\n{long_}}};\n", ["g"]),
        "a lambda in a table": ("pipeline/m.cpp", f"const Row kRows[] = {{\n    {{\"a\", [](int x) {{ return x; }}}},\n    {{.run = [](int x) {{\n{long_}    }}}},\n}};\n", [".run"]),
        "a long table": ("pipeline/n.cpp", "const Row kRows[] = {\n" + body(200, '{"a", [](int x) { return f(x); }},') + "};\n", []),
        "braces in comments": ("pipeline/o.cpp", f"// {{ it's\n/* {{{{\n */\nvoid f() {{\n{body(98, 'x(); // }')}}}\n", []),
        "a long one with braces in comments": ("pipeline/o2.cpp", f"void f() {{\n{body(99, 'x(); // } it is')}}}\n", ["f"]),
        "braces in literals": ("pipeline/p.cpp", "const char* a = \"{ \\\" {\"; const char b = '{', c = '\\'', d = '\"'; const int e = 1'000'000;\n"
                               f"void f() {{\n{long_}}}\n", ["f"]),
        "a raw string": ("pipeline/q.cpp", f"const char* a = R\"json({{ \" ) {{{{\n)json\"; void f() {{\n{short}}}\nvoid g() {{\n    a = R\"(}})\";\n{short}}}\n", ["g"]),
        "preprocessor": ("pipeline/r.cpp", f"#define X {{ \\\n    {{\n#if A\nvoid f(int x) {{\n#else\nvoid f() {{\n#endif\n{short}}}\nvoid g() {{\n#ifdef B\n    if (x) {{\n#else\n    {{\n#endif\n    }}\n{body(95)}}}\n",
                         ["f", "g"]),
        "a kernel": ("shaders/a.comp", "layout(local_size_x = 64) in;\nlayout(push_constant, scalar) uniform Push { FillPush push; };\n"
                     "layout(binding = 4, scalar) readonly buffer Jobs { ClipJob jobs[]; };\nconst vec2 k[2] = vec2[](vec2(0), vec2(1));\n"
                     f"void main() {{\n    [[unroll]] for (int i = 0; i < 4; ++i) {{ x(); }}\n{body(98)}}}\n", ["main"]),
        "a contract": ("shaders/shared/a.h", f"SHARED_BEGIN\nstruct A {{\n    uint a;\n}};\nSHARED_FN void f(INOUT(Real) x, vec3 y) {{\n{long_}}}\nSHARED_END\n", ["f"]),
        "a macro before": ("shaders/b.glsl", f"LIGHT(0, 2)\nLIGHT(1, 10)\n\nvoid f(int x) {{\n{short}}}\nLIGHT(3, 4)\nvoid g() {{\n{long_}}}\n", ["g"]),
        "a brace too few": ("host/d.cpp", "void f() {\n", ["nothing closes"]),
        "a brace too many": ("host/e.cpp", "void f() {}\n}\n", ["nothing opened"]),
        "a long file": ("pipeline/render/x/a.h", "int x;\n" * 351, ["the file"]),
        "a file of exactly 350 lines": ("pipeline/render/x/b.h", "int x;\n" * 350, []),
        "a long file elsewhere": ("pipeline/scene/a.h", "int x;\n" * 351, []),
        "what is no product": ("tests/a.cpp", f"void f() {{\n{long_}}}\n", []),
    }
    failed = 0
    for what, (path, text, wanted) in cases.items():
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.dirname(f"{root}/{path}"), exist_ok=True)
            with open(f"{root}/{path}", "w", encoding="utf-8") as file:
                file.write(text)
            found = list(faults_of(root))
        if len(found) != len(wanted) or any(f" {name}" not in fault for name, fault in zip(wanted, found)):
            print(f"{what}: wanted {wanted}, found {found}")
            failed += 1
    print(f"{len(cases)} cases, {failed} failed")
    return 1 if failed else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if sys.argv[1:2] == ["--longest"]:
        all_ = [(last - first + 1, f"{path}:{first}", name) for path, text in files_of(".") for name, first, last in functions_of(text)[0]]
        for lines, where, name in sorted(all_, reverse=True)[:int(sys.argv[2])]:
            print(f"{lines:5d} {where} {name}")
        return 0
    found = list(faults_of(sys.argv[1] if len(sys.argv) > 1 else "."))
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
