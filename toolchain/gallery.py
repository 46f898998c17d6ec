#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The gallery of the lecture notes: renders the rows of scenes/gallery.txt and writes a page that opens from disk, with picture, scene file, passes, time and error.

usage: gallery.py PLUMB OUT [--size WxH] [--sheet FILE.png]     --size: of all pictures but those of the notes' viewer, of which a unit is a pixel
       gallery.py --check       every row that docs/notes-coverage.md marks drawn has a picture, every picture's rows are marked, every scene is there

Times are of one run each and no measurement: the first picture of a shader holds its compilation. A picture without a truth says why.
"""
import html
import json
import os
import re
import subprocess
import sys

from gallery_sheet import write_sheet

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIST = os.path.join("scenes", "gallery.txt")
COVERAGE = os.path.join("docs", "notes-coverage.md")


class Picture:
    def __init__(self, line):
        fields = [f.strip() for f in line.split("|")]
        if len(fields) not in (4, 5):
            raise ValueError(f"{LIST}: {len(fields)} fields, not 4 or 5: {line.strip()}")
        self.rows = [int(n) for n in fields[0].split()]
        self.name, self.caption = fields[1], fields[2]
        self.runs = [f.split() for f in fields[3:]]  # one, or fault and cure

    def files(self):
        return [self.name] if len(self.runs) == 1 else [self.name + "-fault", self.name + "-cure"]


def pictures():
    with open(os.path.join(ROOT, LIST), encoding="utf-8") as lines:
        return [Picture(line) for line in lines if line.strip() and not line.startswith("#")]


def systems():
    """(section, system) by row of the coverage page."""
    out = {}
    with open(os.path.join(ROOT, COVERAGE), encoding="utf-8") as lines:
        for line in lines:
            m = re.match(r"\| (\d+) \| ([^|]*) \| ([^|]*) \|", line)
            if m:
                out[int(m.group(1))] = (m.group(2).strip(), m.group(3).strip())
    return out


def marked_drawn():
    with open(os.path.join(ROOT, COVERAGE), encoding="utf-8") as file:
        m = re.search(r"^Rows marked \*drawn\*: ([\d, ]+)\.$", file.read(), re.M)
    return {int(n) for n in m.group(1).split(",")} if m else set()


def check():
    faults, drawn = [], marked_drawn()
    shown = {row for p in pictures() for row in p.rows}
    names = [name for p in pictures() for name in p.files()]
    faults += [f"row {row} is marked drawn and has no picture" for row in sorted(drawn - shown)]
    faults += [f"row {row} has a picture and is not marked drawn" for row in sorted(shown - drawn)]
    faults += [f"two pictures are named {name}" for name in sorted({n for n in names if names.count(n) > 1})]
    used = {run[0] for p in pictures() for run in p.runs}
    faults += [f"{scene} is not there" for scene in sorted(used) if not os.path.exists(os.path.join(ROOT, scene))]
    folder = os.path.join("scenes", "gallery")
    faults += [f"{folder}/{name} is in no picture" for name in sorted(os.listdir(os.path.join(ROOT, folder)))
               if name.endswith(".toml") and f"{folder}/{name}" not in used]
    for fault in faults:
        print(fault)
    print(f"gallery --check: {len(names)} pictures, {len(drawn)} rows drawn, {len(faults)} faults")
    return 1 if faults or not drawn else 0


def call(plumb, words):
    return subprocess.run([plumb, *words], cwd=ROOT, capture_output=True, text=True, stdin=subprocess.DEVNULL)


def has_notes_viewer(scene):
    """Of such a scene a unit is a pixel: another size would show a part of it."""
    with open(os.path.join(ROOT, scene), encoding="utf-8") as file:
        return re.search(r"^distance\s*=", file.read(), re.M) is not None


def render(plumb, arguments, path, size):
    """(report, why there is no error or None). Raises RuntimeError with the command's own line."""
    words = ["render", *arguments, "-o", path, "--json", "-q"]
    if size and not has_notes_viewer(arguments[0]):
        if "--size" in words:
            at = words.index("--size")
            words[at + 1] = size
        else:
            words += ["--size", size]
    done, why = call(plumb, [*words, "--with-error"]), None
    if done.returncode == 2 and "--with-error" in done.stderr:
        why = done.stderr.strip().splitlines()[-1].split("--with-error: ", 1)[-1]
        done = call(plumb, words)
    if done.returncode != 0:
        raise RuntimeError(f"plumb {' '.join(words)}: exit {done.returncode}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    report = report[0] if isinstance(report, list) else report
    if report["image"]["blank"]:
        raise RuntimeError(f"plumb {' '.join(words)}: the picture is blank")
    return report, why


def difference(plumb, a, b):
    """Figures of `plumb diff` between two pictures."""
    done = call(plumb, ["diff", a, b, "--json"])
    if done.returncode not in (0, 1):
        raise RuntimeError(f"plumb diff {a} {b}: exit {done.returncode}: {done.stderr.strip()}")
    plane = json.loads(done.stdout)["planes"][0]
    return {"differing": plane["differing"] / plane["pixels"], "max": plane["max"], "rmse": plane["rmse"], "flip": plane.get("flip", {}).get("mean")}


def error_text(report, why):
    error = report.get("error")
    if not error:
        return "no truth: " + why
    steps = 255  # the report counts in shares of full scale
    text = f"error against the truth in steps of 1/255: max {steps * error['max']:.1f}, rms {steps * error['rms']:.3f}"
    if error["wrongPrimitiveShare"] is not None and error["wrongPrimitive"]:
        text += f", wrong face in {100 * error['wrongPrimitiveShare']:.2f} % of the pixels"
    return text


STYLE = """
:root { color-scheme: light dark; --line: #8884; --dim: #777; }
body { font: 16px/1.45 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
main { display: grid; grid-auto-flow: dense; grid-template-columns: repeat(auto-fill, minmax(20rem, 1fr)); gap: 1.5rem; }
article { border: 1px solid var(--line); border-radius: 6px; padding: .8rem; overflow-wrap: anywhere; }
article.pair { grid-column: span 2; }
@media (max-width: 46rem) { article.pair { grid-column: auto; } }
.two { display: grid; grid-template-columns: 1fr 1fr; gap: .8rem; }
img { width: 100%; height: auto; background: #000; image-rendering: pixelated; }
h2 { font-size: 1.05rem; margin: .5rem 0 .2rem; } h3 { font-size: .95rem; margin: .4rem 0 .1rem; }
p { margin: .2rem 0; } .dim { color: var(--dim); font-size: .85rem; } code { font-size: .85rem; }
"""


def figure(file, arguments, report, why, label):
    times = report["time_ms"]
    passes = ", ".join(report["plan"]["passes"])
    scene = arguments[0]
    return (f"<div>{f'<h3>{label}</h3>' if label else ''}<a href=\"{file}.png\"><img src=\"{file}.png\" alt=\"{html.escape(' '.join(arguments))}\" loading=\"lazy\"></a>"
            f"<p class=\"dim\"><code>plumb render {html.escape(' '.join(arguments))}</code></p>"
            f"<p class=\"dim\">scene <a href=\"{file}.{os.path.basename(scene)}.txt\">{html.escape(scene)}</a>; passes {html.escape(passes)}; "
            f"{report['image']['size'][0]}x{report['image']['size'][1]}; {times['render']:.1f} ms</p>"
            f"<p class=\"dim\">{html.escape(error_text(report, why))}</p></div>")


def article(picture, results, apart, known):
    rows = "; ".join(f"row {n}, section {known[n][0]}: {known[n][1]}" for n in picture.rows)
    labels = ["fault", "cure"] if len(results) == 2 else [""]
    body = "".join(figure(f, a, r, why, label) for f, a, (r, why), label in zip(picture.files(), picture.runs, results, labels))
    between = ""
    if apart:
        flip = f", FLIP {apart['flip']:.4f}" if apart["flip"] is not None else ""
        between = f"<p class=\"dim\">between the two (plumb diff): {100 * apart['differing']:.2f} % of the pixels differ, max {255 * apart['max']:.1f}, rms {255 * apart['rmse']:.3f} steps of 1/255{flip}</p>"
    pair, body_class = (" class=\"pair\"", "two") if len(results) == 2 else ("", "one")
    return (f"<article{pair} id=\"{picture.name}\"><h2>{html.escape(picture.caption)}</h2><p class=\"dim\">{html.escape(rows)}</p>"
            f"<div class=\"{body_class}\">{body}</div>{between}</article>")


def make(plumb, out, size, sheet):
    os.makedirs(out, exist_ok=True)
    plumb, known, articles, cells, summary, device = os.path.abspath(plumb), systems(), [], [], [], None
    for picture in pictures():
        results = []
        for file, arguments in zip(picture.files(), picture.runs):
            path = os.path.join(os.path.abspath(out), file + ".png")
            report, why = render(plumb, arguments, path, size)
            results.append((report, why))
            device = report["device"]["name"]
            cells.append(path)
            with open(os.path.join(ROOT, arguments[0]), encoding="utf-8") as scene, \
                    open(os.path.join(out, f"{file}.{os.path.basename(arguments[0])}.txt"), "w", encoding="utf-8") as copy:
                copy.write(scene.read())
        files = [os.path.join(os.path.abspath(out), f + ".png") for f in picture.files()]
        apart = difference(plumb, *files) if len(results) == 2 else None
        articles.append(article(picture, results, apart, known))
        summary.append({"name": picture.name, "rows": picture.rows, "between": apart,
                        "pictures": [{"file": f + ".png", "arguments": a, "passes": r["plan"]["passes"], "time_ms": r["time_ms"], "image": r["image"], "counters": r["counters"],
                                      "error": r.get("error"), "why": why} for f, a, (r, why) in zip(picture.files(), picture.runs, results)]})
        print(f"{picture.name}: {'; '.join(error_text(*result) for result in results)}", flush=True)
    rows = sorted({n for p in pictures() for n in p.rows})
    page = ("<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
            "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src 'self' file:; style-src 'unsafe-inline'\">"
            f"<title>Plumbline: gallery of the lecture notes</title><style>{STYLE}</style></head><body><h1>Gallery of the lecture notes, parts 1 to 3</h1>"
            f"<p>{len(cells)} pictures of {len(rows)} systems, drawn by {html.escape(device)} from the committed scene files by <code>toolchain/gallery.sh</code>. A time is that of one run and no "
            "measurement: where a shader is compiled for the first time, it is in it. The truth is Phong shading with perspective in binary64, whatever the picture's own shading is, and knows no "
            "shadows; of a traced picture it is traced, of the 20 spheres their formula without rounding.</p>"
            f"<main>{''.join(articles)}</main></body></html>\n")
    with open(os.path.join(out, "index.html"), "w", encoding="utf-8") as file:
        file.write(page)
    with open(os.path.join(out, "gallery.json"), "w", encoding="utf-8") as file:
        json.dump(summary, file, indent=1)
    write_sheet(cells, sheet or os.path.join(out, "sheet.png"))
    print(f"{len(cells)} pictures, {len(rows)} rows: {os.path.join(out, 'index.html')}")
    return 0


def main():
    words = sys.argv[1:]
    if words == ["--check"]:
        return check()
    options = {}
    while len(words) >= 2 and words[-2] in ("--size", "--sheet"):
        options[words[-2][2:]] = words[-1]
        words = words[:-2]
    if len(words) != 2 or words[0].startswith("-"):
        print(__doc__.strip().split("\n\n")[1], file=sys.stderr)
        return 2
    try:
        return make(words[0], words[1], options.get("size"), options.get("sheet"))
    except (RuntimeError, ValueError) as fault:
        print(fault, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
