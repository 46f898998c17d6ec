#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Judges prose: the pages, and the comments of the sources.

usage: prose_lint.py PART... [--root ROOT]    exit 0: clean; 1: one line for each fault on stdout
       prose_lint.py --self-test              exit 1 when a planted fault goes unnoticed, or innocent text is judged

  references   a page, heading, erratum, row, decision or section of the notes that is named and does not exist
  sentences    a sentence above 30 words in a page; prints the mean of each page. Code blocks, tables and headings are left out
  openings     a comment of shaders/, host/ or pipeline/ that opens with a relation to what it does not name (rule 1 of CONTRIBUTING.md)
  constants    a constant (SHARED_CONST, `constexpr` or `const` with a name kName) that is declared and never read
  names        a file, test or identifier that a page names and that the tree does not have; a file that a comment names. History may name what is gone:
               CHANGELOG.md and docs/decisions.md are left out
  words        a word that docs/words.md has renamed, or defines twice
"""
import os
import re
import sys
import tempfile

LONGEST = 30  # words of a sentence
SOURCES = ("shaders", "host", "pipeline")
SOURCE_ENDS = (".h", ".hpp", ".cpp", ".comp", ".glsl", ".inc")
TEXT_ENDS = SOURCE_ENDS + (".py", ".sh", ".cmake", ".txt", ".toml", ".md", ".yml", ".js", ".css", ".html")
SKIPPED = {".git", "build", "out", "node_modules", "corpus", "models", "images", "third_party", "__pycache__"}
OWN = os.path.join("toolchain", "prose_lint.py")  # its examples are faults on purpose

# What a comment must not open with: each points at a line above, or at nothing.
DANGLING = re.compile(r"^(?:Of|Such|Those|These|This (?:is|was|has|must|can|may|one)|That (?:is|was|has|of|one)|The same|It|Its|They|Them|Their|So many|So much|So|With|From now on|From there|Also|Else|Likewise|Again|Ditto|"
                      r"And|But|Or|Here too|There|Then|Each of (?:them|these|those)|What (?:it|they|is left))\b(?!')")


def files_of(root, folders=None, ends=TEXT_ENDS):
    """(path below root, text) of each file of the tree, or of some folders of it."""
    for folder in folders or ("",):
        for at, inner, names in sorted(os.walk(os.path.join(root, folder))):
            inner[:] = sorted(name for name in inner if name not in SKIPPED and not (name.startswith(".") and name != ".ci"))
            for name in sorted(names):
                path = os.path.relpath(os.path.join(at, name), root)
                if not name.endswith(ends) or path == OWN:
                    continue
                with open(os.path.join(at, name), encoding="utf-8", errors="replace") as file:
                    yield path, file.read()


def without_code(page):
    """A page with its code blocks emptied, so that line numbers stay."""
    inside, lines = False, []
    for line in page.splitlines():
        fence = line.lstrip().startswith("```")
        lines.append("" if fence or inside else line)
        inside ^= fence
    return "\n".join(lines)


def slug(heading):
    """A heading's anchor, as GitHub makes it."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


class Pages:
    """What can be referred to: pages with their headings, and rows of tables."""

    def __init__(self, root):
        self.headings, self.text = {}, {}
        for path, text in files_of(root, ends=(".md",)):
            self.text[path] = text
            found = re.findall(r"^#+ +(.+?)\s*$", without_code(text), re.M)
            self.headings[path] = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "") for heading in found]
            counts, slugs = {}, set(re.findall(r'<a (?:id|name)="([^"]+)">', text))
            for heading in found:
                name = slug(heading)
                slugs.add(f"{name}-{counts[name]}" if name in counts else name)
                counts[name] = counts.get(name, 0) + 1
            self.text[path, "slugs"] = slugs
        self.errata = set(re.findall(r"^\| *([ABC]\d+) *\|", self.text.get("docs/errata.md", ""), re.M))
        self.extremes = set(re.findall(r"^\| *(\d+) *\|", self.text.get("docs/extremes.md", ""), re.M))
        self.sections = set(re.findall(r"^\| *(\d+(?:\.\d+)*) *\|", self.text.get("docs/lecture-notes.md", ""), re.M))
        self.decisions = set(re.findall(r"^#+ +(?:Decision )?(\d+)\b", self.text.get("docs/decisions.md", ""), re.M))

    def find(self, name, beside=""):
        """The page of a name, as seen from a page; None when there is none."""
        for path in (os.path.normpath(os.path.join(os.path.dirname(beside), name)), name, os.path.join("docs", name)):
            if path in self.headings:
                return path
        return None

    def has_heading(self, page, words):
        plain = lambda text: re.sub(r"[^\w ]", "", re.sub(r"^(?:the|a|an) ", "", text.strip().lower()))
        said = plain(words)
        return bool(said) and any(said == plain(h) or said.startswith(plain(h) + " ") for h in self.headings[page])


def flowing(path, text):
    """The text with comment markers of continued lines taken out, character for character, so that a reference may run over a line's end."""
    if path.endswith(".md"):
        return re.sub(r"\n(?=[^\n|#`\-])", " ", text)
    return re.sub(r"\n[ \t]*(?://|#)", lambda m: " " * len(m.group()), text)


def numbers_of(words):
    """All numbers of `4, 6 to 8 and 10`."""
    found = []
    for first, last in re.findall(r"(\d+)(?:\s+to\s+(\d+))?", words):
        found += range(int(first), int(last or first) + 1)
    return [str(n) for n in found]


PAGE = r"((?:[\w.\-]+/)*[\w\-]+\.md)"


def references(root):
    pages = Pages(root)
    for path, text in files_of(root):
        text = text.replace("\r", "")
        flow = flowing(path, text)

        def at(position):
            return f"{path}:{text.count(chr(10), 0, position) + 1}"

        if path.endswith(".md"):
            prose = without_code(text)
            for m in re.finditer(r"\]\(([^)\s#]*)(?:#([^)\s]*))?\)", prose):
                target, anchor = m.groups()
                where = f"{path}:{prose.count(chr(10), 0, m.start()) + 1}"
                if re.match(r"[a-z]+:", target):
                    continue
                if target and not os.path.exists(os.path.join(root, os.path.dirname(path), target)):
                    yield f"{where}: link to {target}: there is no such file"
                elif anchor:
                    page = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
                    if anchor not in pages.text.get((page, "slugs"), ()):
                        yield f"{where}: link to {target}#{anchor}: there is no such heading"
        elif path.startswith(("tests/frame/docs_", "tests/data")):
            continue
        for m in re.finditer(PAGE + r"(?:#([\w\-]+)|,? ([A-Z]\.\d+)\b)?", flow):
            if re.search(r"[\w/{}*$]$", flow[:m.start()][-1:]) or flow[:m.start()].endswith(("](", "../", "/")):
                continue
            name, anchor, letter = m.groups()
            page = pages.find(name, path)
            if page is None:
                if "/" in name or path.endswith(SOURCE_ENDS):
                    yield f"{at(m.start())}: {name}: there is no such page"
            elif anchor and anchor not in pages.text[page, "slugs"]:
                yield f"{at(m.start())}: {name}#{anchor}: there is no such heading"
            elif letter and not any(h.startswith(letter) for h in pages.headings[page]):
                yield f"{at(m.start())}: {name} {letter}: there is no such heading"
        for m in re.finditer(r"\(\[?" + PAGE + r"(?:\]\([^)]*\))?, +(?!and\b|or\b|else\b|docs/|\[)([^).:;,\n]+)", flow):
            page = pages.find(m.group(1), path)
            if page and not re.match(r"[A-Z](?:\.\d|$)", m.group(2)) and not pages.has_heading(page, m.group(2)):
                yield f"{at(m.start())}: {m.group(1)}, {m.group(2)}: there is no such heading"
        for m in re.finditer(r"\berrat(?:um|a)\s+((?:[ABC]\d+(?:,\s+|\s+to\s+|\s+and\s+|\s+or\s+)?)+)", flow, re.I):
            for letter, words in re.findall(r"([ABC])(\d+(?:\s+to\s+[ABC]\d+)?)", m.group(1)):
                for number in numbers_of(re.sub("[ABC]", "", words)):
                    if letter + number not in pages.errata:
                        yield f"{at(m.start())}: erratum {letter}{number}: docs/errata.md has no such row"
        for m in re.finditer(r"\brows?\s+((?:\d+(?:,\s+|\s+to\s+|\s+and\s+)?)+)\s*of (?:the stress table|the extremes|(?:docs/)?extremes\.md|\[extremes)", flow):
            for number in numbers_of(m.group(1)):
                if number not in pages.extremes:
                    yield f"{at(m.start())}: row {number} of the extremes: docs/extremes.md has no such row"
        for m in re.finditer(r"\bdecisions? (\d+)\b", flow, re.I):
            if m.group(1) not in pages.decisions:
                yield f"{at(m.start())}: decision {m.group(1)}: docs/decisions.md has no such entry"
        for m in re.finditer(r"\bsections? (\d+(?:\.\d+)*) of the (?:lecture )?notes|\b(\d+(?:\.\d+)+) of the (?:lecture )?notes", flow):
            section = m.group(1) or m.group(2)
            if section not in pages.sections:
                yield f"{at(m.start())}: section {section} of the notes: docs/lecture-notes.md has no such row"


def sentences_of(page):
    """(line, sentence) of each sentence of a page's prose."""
    block, first = [], 0

    def split():
        text = " ".join(block)
        text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
        for sentence in re.split(r"(?<!\be\.g)(?<!\bi\.e)(?<!\betc)(?<!\bvs)(?<!\.\.)(?<=[.!?])(?:\*\*|[)\"'*_`])*\s+", text):
            if re.search(r"\w", sentence):
                yield first, sentence.strip()

    for number, line in enumerate(without_code(page).splitlines() + [""], 1):
        bare = line.strip()
        opens = re.match(r"[-*+] |\d+\. ", bare)
        if not bare or opens or bare.startswith(("|", "#", "<!--", "<a ", "[!")):
            yield from split()
            block, first = [], number
            if bare and not bare.startswith(("|", "#", "<!--", "<a ", "[!")):
                block = [bare[opens.end():] if opens else bare]
        else:
            if not block:
                first = number
            block.append(bare)


def words_in(sentence):
    return sum(1 for word in sentence.split() if re.search(r"\w", word))


def is_page(path):
    return path in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md") or (path.startswith("docs/") and path.endswith(".md"))


def sentences(root, say=print):
    total = count = 0
    for path, text in files_of(root, ends=(".md",)):
        if not is_page(path):
            continue
        lengths = [(words_in(sentence), line, sentence) for line, sentence in sentences_of(text)]
        lengths = [entry for entry in lengths if entry[0]]
        if not lengths:
            continue
        long = [entry for entry in lengths if entry[0] > LONGEST]
        words = sum(entry[0] for entry in lengths)
        if path.startswith("docs/"):
            total, count = total + words, count + len(lengths)
        say(f"{path:28} {len(lengths):4} sentences, mean {words / len(lengths):4.1f} words, longest {max(lengths)[0]:3}, above {LONGEST}: {len(long)}")
        for length, line, sentence in long:
            yield f"{path}:{line}: a sentence of {length} words: {sentence[:100]} ..."
    if count:
        say(f"{'docs/':28} {count:4} sentences, mean {total / count:4.1f} words")


def comments_of(text):
    """(line, words) of each comment that stands alone: a run of // lines, or a /* */."""
    run, first = [], 0
    for number, line in enumerate(text.splitlines() + [""], 1):
        m = re.match(r"\s*//[/!]?\s?(.*)$", line)
        if m:
            if not run:
                first = number
            run.append(m.group(1).strip())
        elif run:
            yield first, " ".join(run).strip()
            run = []
    for m in re.finditer(r"^\s*/\*+\s*(.*?)\*/", text, re.M | re.S):
        yield text.count("\n", 0, m.start(1)) + 1, m.group(1).strip()


def openings(root):
    for path, text in files_of(root, SOURCES, SOURCE_ENDS):
        for line, comment in comments_of(text):
            if DANGLING.match(comment):
                yield f"{path}:{line}: opens with a relation: {comment[:90]}"


def without_comments(text):
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)


DECLARED = re.compile(r"\b(?:SHARED_CONST(?:ANT)?\s*\(?\s*[\w:]+\s*,?\s*|(?:static\s+|inline\s+)*(?:constexpr|const)\s+(?:static\s+|inline\s+)?[\w:<>, ]+?\s+|#define\s+)(k[A-Z]\w*)\s*(?:=|\{|\[|\(|\)|,|$)", re.M)


def constants(root):
    declared, said = {}, {}
    for path, text in files_of(root, SOURCES + ("tests", "toolchain", "examples", "include"), SOURCE_ENDS + (".py", ".cmake", ".txt")):
        bare = without_comments(text) if path.endswith(SOURCE_ENDS) else text
        for m in DECLARED.finditer(bare):
            if path.startswith(SOURCES):
                declared.setdefault(m.group(1), []).append(f"{path}:{bare.count(chr(10), 0, m.start(1)) + 1}")
        for name in re.findall(r"\bk[A-Z]\w*", bare):
            said[name] = said.get(name, 0) + 1
    for name, places in sorted(declared.items()):
        if said[name] <= len(places):
            yield f"{places[0]}: {name} is declared and never read"


FOLDERS = ("shaders", "host", "pipeline", "tests", "toolchain", "scenes", "examples", "docs", "include", ".ci")
FILE = re.compile(r"(?<![\w/.$}~>*\-])((?:" + "|".join(re.escape(f) for f in FOLDERS) + r")/[\w./\-]*\w(?:/|\.[a-z]+))(?![\w*{$/])")
IDENTIFIER = re.compile(r"(k[A-Z]\w+|[a-z]+[a-z0-9]*[A-Z]\w*|[a-z]\w*_(?:test|long|mutants|notices|oracle))(?:\(\))?$")
TEST = re.compile(r"([A-Z]\w+)\.(test_\w+|[A-Za-z]\w+)$")


def names(root):
    said, gone = set(), {}
    for path, text in files_of(root, SOURCES + ("tests", "toolchain", "examples", "scenes")):
        said.update(re.findall(r"\w+", text))
    for path, text in files_of(root):
        page = is_page(path)
        if path in ("CHANGELOG.md", os.path.join("docs", "decisions.md")) or not (page or path.endswith(SOURCE_ENDS)) or path.startswith("examples"):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            spoken = line if page else line[line.index("//"):] if "//" in line else ""
            for name in FILE.findall(spoken):
                if name not in gone:
                    gone[name] = not os.path.exists(os.path.join(root, name))
                if gone[name] and not name.startswith(("build/", "docs/images/")) and not re.search(r"xyz|[A-Z]{2}", name.split("/")[-1]):  # stands for a name
                    yield f"{path}:{number}: {name}: there is no such file"
            for span in re.findall(r"`([^`\s]+)`", line) if page else []:
                if m := TEST.match(span):
                    missing = [part for part in m.groups() if part not in said and not (m.group(1) == "Golden" and part == "Golden")]
                    if missing and "." in span and not span.endswith((".md", ".py", ".txt")):
                        yield f"{path}:{number}: {span}: there is no such test"
                elif (m := IDENTIFIER.match(span)) and m.group(1) not in said:
                    yield f"{path}:{number}: {span}: the sources do not have this name"


def renamed(root):
    """(pattern, what to say instead) of the table of docs/words.md under the heading `Renamed`: | not | say | where |"""
    path = os.path.join(root, "docs", "words.md")
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        part = re.search(r"^## Renamed\s*$(.*?)(?=^## |\Z)", file.read(), re.M | re.S)
    rows = re.findall(r"^\| `([^`]+)` \| ([^|]+) \| ([^|]+) \|", part.group(1), re.M) if part else []
    return [(re.compile(rf"\b{old}\b", re.I), new.strip(), where.strip()) for old, new, where in rows]


def words(root):
    rows = renamed(root)
    glossary, seen = os.path.join(root, "docs", "words.md"), {}
    if os.path.exists(glossary):
        with open(glossary, encoding="utf-8") as file:
            for number, line in enumerate(file.read().split("\n## Renamed")[0].splitlines(), 1):
                m = re.match(r"\| (?!word \|)([^|-][^|]*) \|", line)
                for word in re.sub(r" *\([^)]*\)", "", m.group(1)).split(", ") if m else []:
                    if word in seen:
                        yield f"docs/words.md:{number}: '{word}' is defined in line {seen[word]}, too"
                    seen.setdefault(word, number)
    for path, text in files_of(root):
        if path in (os.path.join("docs", "words.md"), os.path.join("docs", "lecture-notes.md")):  # they name what is not said
            continue
        if is_page(path):  # a word in code is a name, which may be older than the word
            where, parts = "pages", [(number, re.sub(r"`[^`]*`|\]\([^)]*\)", "", line)) for number, line in enumerate(without_code(text).splitlines(), 1)]
        elif path.startswith(SOURCES) and path.endswith(SOURCE_ENDS):
            where, parts = "comments", [(number, line[line.index("//"):]) for number, line in enumerate(text.splitlines(), 1) if "//" in line]
        else:
            continue
        for number, line in parts:
            for pattern, new, places in rows:
                if where in places and (m := pattern.search(line)):
                    yield f"{path}:{number}: '{m.group()}': say '{new}' (docs/words.md)"


PARTS = {"references": references, "sentences": sentences, "openings": openings, "constants": constants, "names": names, "words": words}

# Each part on a tree that is clean, and on the same tree with one thing changed: (part, file, text, faults).
CLEAN = {
    "README.md": "# A\n\nSee [b](docs/b.md#two-words), [one](docs/b.md) and [web](https://x.org/y.md#z).\n",
    "docs/b.md": "# B\n\n## Two words\n\n## C.1 Of rows\n\nShort. `x.y` is code. Erratum A1.\n\n```sh\n# no heading\n```\n",
    "docs/errata.md": "# Errata\n\n| # | x |\n|---|---|\n| A1 | x |\n| A2 | x |\n",
    "docs/extremes.md": "# Extremes\n\n| 13 | x |\n| 14 | x |\n",
    "docs/lecture-notes.md": "# Notes\n\n| 16.5 | x |\n",
    "docs/decisions.md": "# Decisions\n\n## 7. Seven\n",
    "docs/words.md": "# Words\n\n## Renamed\n\n| `feelers?` | shadow ray | pages, comments |\n",
    "host/a.h": "// The thing (docs/b.md, Two words). Errata A1 to A2, rows 13 and 14 of the stress table, decision 7,\n// 16.5 of the notes.\nconstexpr int kRead = 1;\nint f() { return kRead; }\n",
    "shaders/x.h": "SHARED_CONST(uint, kUsed, 3u)\nuint g() { return kUsed; }\n",
}
PLANTED = [
    ("references", "README.md", "[b](docs/c.md)\n"), ("references", "README.md", "[b](docs/b.md#three)\n"), ("references", "host/a.h", "// (docs/b.md, Three words)\n"),
    ("references", "host/a.h", "// see docs/c.md\n"), ("references", "host/a.h", "// docs/b.md#three\n"), ("references", "host/a.h", "// b.md B.9\n"),
    ("references", "host/a.h", "// erratum A3\n"), ("references", "host/a.h", "// errata A1 to\n// A3\n"), ("references", "host/a.h", "// row 15 of the stress table\n"),
    ("references", "host/a.h", "// decision 8\n"), ("references", "host/a.h", "// section 16.6 of the notes\n"), ("references", "host/a.h", "// (docs/b.md, Three\n// words)\n"),
    ("sentences", "docs/b.md", "# B\n\n" + "word " * 31 + "end.\n"), ("sentences", "docs/b.md", "# B\n\n- Short.\n- " + "word, " * 30 + "\n  end.\n"),
    ("openings", "host/a.h", "// Of its pixels, by row.\nint a;\n"), ("openings", "shaders/x.h", "  // These are dropped.\n"), ("openings", "host/a.h", "/* It is so. */\n"),
    ("constants", "host/a.h", "constexpr int kUnread = 1;\n"), ("constants", "shaders/x.h", "SHARED_CONST(uint, kUnread, 3u)  // kUnread\n"),
    ("names", "docs/b.md", "`kGone`\n"), ("names", "docs/b.md", "`goneName()`\n"), ("names", "docs/b.md", "`Suite.Gone`\n"), ("names", "docs/b.md", "`host/gone.h`\n"),
    ("names", "docs/b.md", "`gone_test`\n"), ("names", "host/a.h", "// as tests/gone.cpp does\n"),
    ("words", "docs/words.md", "# Words\n\n| word | means |\n|---|---|\n| twin (x) | y |\n| plane, twin | z |\n"),
    ("words", "docs/b.md", "# B\n\nA feeler runs.\n"), ("words", "host/a.h", "// A feeler runs.\n"),
]
INNOCENT = [
    ("references", "host/a.h", "// as docs/b.md has it, else as the file says\n"), ("references", "host/a.h", "// (docs/b.md), (docs/b.md, C.1 Of rows: 3)\n"),
    ("sentences", "docs/b.md", "# " + "word " * 40 + "\n\n| " + "word " * 40 + " |\n\n" + ("word " * 20 + "end. ").capitalize() * 3 + "\n\n```\n" + "word " * 40 + "\n```\n"),
    ("openings", "host/a.h", "// Offsets of rows.\nint a;  // of each\n// Itself.\n"), ("constants", "host/a.h", "constexpr int kRead = 1;\nint a[kRead];\n"),
    ("names", "docs/b.md", "`kUsed` of `shaders/x.h`, `host/`, `shaders/*.glsl` and `plumb render scene.toml`\n"), ("names", "host/a.h", "// see host/a.h\n"),
    ("words", "docs/b.md", "# B\n\n`feelers` is a key. [x](feeler.md)\n"), ("words", "host/a.h", "int feelers;\n"),
]


def self_test():
    wrong = []

    def faults(part, changed):
        with tempfile.TemporaryDirectory() as root:
            for path, text in {**CLEAN, **changed}.items():
                os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(text)
            return list(sentences(root, say=lambda _: None) if part == "sentences" else PARTS[part](root))

    for part in PARTS:
        if found := faults(part, {}):
            wrong.append(f"{part}: the clean tree: {found}")
    for part, path, text in PLANTED:
        if len(found := faults(part, {path: text})) != 1:
            wrong.append(f"{part}: {text!r} in {path}: {found}")
    for part, path, text in INNOCENT:
        if found := [fault for fault in faults(part, {path: text}) if "link" not in fault or part != "references"]:
            wrong.append(f"{part}: innocent {text!r} in {path}: {found}")
    for line in wrong:
        print(line)
    print(f"prose_lint --self-test: {len(PLANTED)} planted faults, {len(INNOCENT)} innocent texts, {len(wrong)} wrong")
    return 1 if wrong else 0


def main():
    given = sys.argv[1:]
    if given == ["--self-test"]:
        return self_test()
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    if "--root" in given:
        at = given.index("--root")
        root = given[at + 1]
        del given[at:at + 2]
    if not given or any(part not in PARTS for part in given):
        print(__doc__)
        return 2
    found = [fault for part in given for fault in PARTS[part](os.path.normpath(root))]
    for fault in found:
        print(fault)
    print(f"prose_lint {' '.join(given)}: {len(found)} faults")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
