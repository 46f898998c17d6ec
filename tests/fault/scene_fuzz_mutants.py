#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Shows that scene_fuzz_test can fail: each row plants a fault in one unit of one side, or of both, and random scenes must find it.

A changed unit is compiled as the build compiles it, without optimisation, and linked before the library that holds the original. A row may change a header
instead, for that unit alone, or a contract for both sides alike: the twin's units and the SPIR-V modules that read it (toolchain/run_plants.py). Printed is the number of scenes that were drawn before the fault was found.

usage: scene_fuzz_mutants.py BUILD [WORD]    only those whose claim has the word
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import types

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
sys.path.insert(0, os.path.join(ROOT, "toolchain"))
import compile_words  # noqa: E402
import run_plants  # noqa: E402

PROGRAM, MOST_SCENES = "scene_fuzz_test", 1000
BOTH_SIDES = "both sides"
# (what then happens, unit or both sides, file that is changed, text, its replacement)
MUTANTS = [
    ("an undrawn picture of the device is black in linear", "pipeline/render/planes.cpp", None,
     "std::copy_n(&prepared_.undrawnLinear.x, 3, frame_.linear.begin() + ptrdiff_t(3 * i));", "std::fill_n(frame_.linear.begin() + ptrdiff_t(3 * i), 3, 0.0f);"),
    ("the twin rounds coverage down", "pipeline/passes/resolve_cpu.cpp", "shaders/shared/resolve.h",
     "(covered * 255u + (samples >> 1u)) / samples", "(covered * 255u) / samples"),
    ("no board is mirrored to the twin's rays", "pipeline/passes/trace_cpu.cpp", None,
     "gpu::otherSquare(hit.u, hit.v, p.square, p.mirrored)", "gpu::otherSquare(hit.u, hit.v, p.square, false)"),
    ("both sides light mirrored objects from behind: the truth knows", "pipeline/render/draw_list_of.cpp", None,
     "* (mirrored ? -1 : 1)", "* 1"),
    ("both sides lose what total reflection reflects: the truth of rays knows", BOTH_SIDES, "shaders/shared/trace.h",
     "pick(passes, mirrorShare, mirrorShare + passShare)", "mirrorShare"),
]


def commands(build):
    return subprocess.run(["ninja", "-C", build, "-t", "commands", PROGRAM], check=True, capture_output=True, text=True).stdout.splitlines()


def judge(build, work, mutant, lines):
    """The number of the scene that finds it, or what went wrong."""
    claim, unit, changed, old, new = mutant
    changed = changed or unit
    with open(os.path.join(ROOT, changed), encoding="utf-8") as f:
        text = f.read()
    if text.count(old) != 1:
        return f"the text to change stands {text.count(old)} times in {changed}"
    if unit == BOTH_SIDES:
        return found_by(planted_alike(build, work, changed, text.replace(old, new)), work)
    place = os.path.join(work, changed)
    if changed != unit:  # a quoted include looks beside the file that names it first
        shutil.copytree(os.path.join(ROOT, "shaders"), os.path.join(work, "shaders"), dirs_exist_ok=True)
    os.makedirs(os.path.dirname(place), exist_ok=True)
    with open(place, "w", encoding="utf-8") as f:
        f.write(text.replace(old, new))
    line = next(line for line in lines if " -c " in line and line.split(" -c ")[1].split()[0].endswith("/" + unit))
    words, _ = compile_words.without_precompiled(compile_words.of_compiler(shlex.split(line)))
    words = [w for w in words if not w.startswith(("-O", "-Wp,", "-D_FORTIFY_SOURCE"))]
    words = compile_words.without(words, ("-MD",), ("-o", "-MF", "-MT", "-c"))
    made, run = os.path.join(work, "unit.o"), os.path.join(work, PROGRAM)
    source = place if changed == unit else os.path.join(ROOT, unit)
    overlay = [] if changed == unit else [f"-I{work}", f"-I{work}/shaders"]
    done = subprocess.run([words[0], *overlay, *words[1:], "-O0", "-w", "-o", made, "-c", source], cwd=build, capture_output=True, text=True, check=False)
    if done.returncode:
        return f"does not compile: {done.stderr[-600:]}"
    words = shlex.split(lines[-1].split("&&")[1])
    at = words.index("-o")
    words[at + 1] = run
    done = subprocess.run([*words[:at], made, *words[at:]], cwd=build, capture_output=True, text=True, check=False)
    if done.returncode:
        return f"does not link: {done.stderr[-600:]}"
    return found_by(run, work)


def planted_alike(build, work, changed, text):
    """The program with the changed contract in it, on both sides."""
    row = types.SimpleNamespace(program=PROGRAM, side="both", file=os.path.relpath(changed, "shaders"))
    return list(run_plants.Worker(run_plants.Build(build), work, 0).attempts([row], {row.file: text}))[-1]


def found_by(run, work):
    """The number of the scene by which the program finds the fault, or what went wrong."""
    environment = {**os.environ, "PLUMB_FUZZ_FIND": "1", "PLUMB_FUZZ_SCENES": str(MOST_SCENES)}
    done = subprocess.run([run, "--gtest_filter=SceneFuzz.DeviceEqualsTwin"], cwd=work, env=environment, capture_output=True, text=True, timeout=600, check=False)
    found = re.search(r"found by scene (\d+)", done.stdout)
    if done.returncode == 0 or not found:
        return f"UNNOTICED in {MOST_SCENES} scenes: {done.stdout[-600:]}{done.stderr[-300:]}"
    return int(found.group(1))


def main():
    build = os.path.abspath(sys.argv[1])
    mutants = [m for m in MUTANTS if len(sys.argv) < 3 or sys.argv[2] in m[0]]
    lines, missed = commands(build), 0
    for mutant in mutants:
        with tempfile.TemporaryDirectory(prefix="plumb-mutants-") as work:
            result = judge(build, work, mutant, lines)
        missed += not isinstance(result, int)
        print(f"{mutant[0]}: {f'found after {result + 1} scenes' if isinstance(result, int) else result}", flush=True)
    print(f"scene_fuzz_mutants: {len(mutants)} faults, {len(mutants) - missed} found")
    return 1 if missed or not mutants else 0


if __name__ == "__main__":
    sys.exit(main())
