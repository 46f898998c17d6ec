#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Shows that the tests of pipeline/compare can fail: each row changes one place of one measure, and the named tests must go red.

A changed file is compiled as the build compiles it, without optimisation, and linked before the library that holds the original.

usage: compare_mutants.py BUILD [WORD]    only those whose claim has the word
"""
import concurrent.futures
import os
import shlex
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
# (what the measure then does, file, text, its replacement, test program, filter)
METRICS, GATES, READERS = "compare_metrics_test", "compare_gate_test", "compare_read_test"
MUTANTS = [
    ("max takes the smallest", "norms.cpp", "if (d <= most) continue;\n                    most = d;\n                    out.maxAt", "if (d >= most && most >= 0) continue;\n                    most = d;\n                    out.maxAt", METRICS, "CompareNorms.*"),
    ("mean forgets the channels", "norms.cpp", "double(out.compared) * channels", "double(out.compared)", METRICS, "CompareNorms.*"),
    ("rmse is the mean of squares", "norms.cpp", "std::sqrt(squares / samples)", "squares / samples", METRICS, "CompareNorms.*"),
    ("psnr takes 20 log", "norms.cpp", "10 * std::log10(samples", "20 * std::log10(samples", METRICS, "CompareNorms.*"),
    ("over counts equal levels", "norms.cpp", "error > kLevels[k] / 255.0", "error >= kLevels[k] / 255.0", METRICS, "CompareNorms.*"),
    ("regions join by sides only", "norms.cpp", "if (left[next] == 0) continue;", "if (left[next] == 0 || (u != x && v != y)) continue;", METRICS, "CompareNorms.*"),
    ("the search looks one way", "norms.cpp", "const double forth = pixels.largest(p, inB), back = pixels.largest(q, inA);", "const double forth = pixels.largest(p, inB), back = 0 * pixels.largest(q, inA);", METRICS, "CompareRadius.*"),
    ("the search stops a column early", "norms.cpp", "u <= u1; ++u", "u < u1; ++u", METRICS, "CompareRadius.*"),
    ("NaN is not counted", "norms.cpp", "if (found.pixels++ == 0)", "if (found.pixels == 0)", METRICS, "CompareNan.*"),
    ("a NaN on one side does not differ", "norms.cpp", "differs[i] = both ? 0 : 1;", "differs[i] = 0;", METRICS, "CompareNan.*"),
    ("equal infinities differ", "norms.cpp", "return a == b ? 0 : std::fabs(a - b);", "return std::fabs(a - b);", METRICS, "CompareInfinity.*"),
    ("ULP ignores the sign", "norms.cpp", "return (bits & sign) != 0 ? -magnitude : magnitude;", "return magnitude;", METRICS, "CompareUlp.*"),
    ("ids are not compared", "norms.cpp", "differs[i] = error != 0;", "differs[i] = error != 0 && !ids;", METRICS, "CompareIds.*"),
    ("SSIM has a wider window", "ssim.cpp", "kSigma = 1.5", "kSigma = 1.6", METRICS, "CompareSsim.*"),
    ("SSIM forgets a constant", "ssim.cpp", "kC1 = 0.01 * 0.01", "kC1 = 0.0", METRICS, "CompareSsim.*"),
    ("SSIM takes the covariance's half", "ssim.cpp", "(2 * covariance + kC2)", "(covariance + kC2)", METRICS, "CompareSsim.*"),
    ("SSIM's luma is of linear light", "ssim.cpp", "0.587 * srgbFromLinear(picture.green[i])", "0.587 * picture.green[i]", "compare_witness_test", "*"),
    ("FLIP's exponent", "flip.cpp", "kQc = 0.7", "kQc = 0.8", METRICS, "CompareFlip.*"),
    ("FLIP without the Hunt effect", "flip.cpp", "return {l, 0.01 * l * 500", "return {l, 500", METRICS, "CompareFlip.*"),
    ("FLIP without features", "flip.cpp", "std::pow(colour, 1 - feature)", "colour", "compare_witness_test", "*"),
    ("FLIP's blue-yellow filter has one term", "flip.cpp", "kAmount[2] = {34.1, 13.5}", "kAmount[2] = {34.1, 0}", "compare_witness_test", "*"),
    ("FLIP's border is not repeated", "flip.cpp", "std::clamp<int64_t>(int64_t(i) - int64_t(margin), 0, picture.width - 1)", "(int64_t(i) + picture.width * 4 - int64_t(margin)) % picture.width", METRICS, "CompareFlip.*"),
    ("CIEDE2000 without its rotation", "delta_e.cpp", "+ rT * c * h", "", METRICS, "CompareDeltaE.*"),
    ("CIEDE2000's mean hue across 0", "delta_e.cpp", "if (std::fabs(h1 - h2) > 180)", "if (false)", METRICS, "CompareDeltaE.*"),
    ("alpha lies on black only", "compare.cpp", "grounds.push_back(1);", "", METRICS, "CompareAlpha.*"),
    ("sizes are not compared", "compare.cpp", "a.height != b.height || ", "", METRICS, "ComparePictures.*"),
    ("a plane of B alone is forgotten", "compare.cpp", "out.onlyB.push_back(layer.name)", "(void)0", METRICS, "ComparePictures.*"),
    ("a gate holds beyond its limit", "gate.cpp", "m->value <= gate.limit", "m->value <= gate.limit * 2", GATES, "*"),
    ("< is <=", "gate.cpp", "within && !(gate.strict && m->value == gate.limit)", "within", GATES, "*"),
    ("a percentage is a number", "gate.cpp", "*limit / 100", "*limit", GATES, "*"),
    ("over forgets its level", "gate.cpp", "return e > gate.level;", "return e > 0;", GATES, "*"),
    ("an EXR's window is believed", "read_exr.cpp", "if (uint64_t(width) * uint64_t(height) * channels > kMostSamples)", "if (false)", READERS, "*TakesNoMemory*"),
    ("an interlaced PNG's size is believed", "read_png.cpp", "rowBytes) * reading.height / 1032 > reading.bytes.size()", "rowBytes) * reading.height / 1032 > ~0ull", READERS, "*TakesNoMemory*"),
    ("Fortran order is ignored", "read_npy.cpp", "if (*header.fortran)", "if (false)", READERS, "*ReadsArrays*"),
]


def commands(build, target):
    text = subprocess.run(["ninja", "-C", build, "-t", "commands", target], check=True, capture_output=True, text=True).stdout
    return text.splitlines()


def judge(build, work, number, mutant, compile_of, link_of):
    claim, name, old, new, program, tests = mutant
    with open(os.path.join(ROOT, "pipeline/compare", name), encoding="utf-8") as f:
        text = f.read()
    if text.count(old) != 1:
        return f"{claim}: the text to change stands {text.count(old)} times in {name}"
    source, made, run = (os.path.join(work, f"{number}{suffix}") for suffix in (".cpp", ".o", ".run"))
    with open(source, "w", encoding="utf-8") as f:
        f.write(text.replace(old, new))
    words = [w for w in shlex.split(compile_of[name]) if not w.startswith("-O") and "ccache" not in w and not w.startswith(("CCACHE", "-Wp,"))]
    for flag in ("-o", "-c", "-MF", "-MT"):
        at = words.index(flag)
        words[at + 1] = {"-o": made, "-c": source, "-MF": made + ".d", "-MT": made}[flag]
    words = [w for w in words if not w.startswith("-D_FORTIFY_SOURCE")]
    done = subprocess.run([*words, "-O0", "-w"], cwd=build, capture_output=True, text=True, check=False)
    if done.returncode:
        return f"{claim}: does not compile: {done.stderr[-600:]}"
    words = shlex.split(link_of[program].split("&&")[1])
    at = words.index("-o")
    words[at + 1] = run
    done = subprocess.run([*words[:at], made, *words[at:]], cwd=build, capture_output=True, text=True, check=False)
    if done.returncode:
        return f"{claim}: does not link: {done.stderr[-600:]}"
    limited = f"ulimit -v 4000000; exec '{run}' '--gtest_filter={tests}'"  # a reader that believes a header must not take the machine with it
    done = subprocess.run(["bash", "-c", limited], cwd=work, capture_output=True, text=True, timeout=240, check=False)
    os.remove(run)
    if "Running 0 tests" in done.stdout:
        return f"{claim}: '{tests}' names no test"
    return None if done.returncode else f"{claim}: UNNOTICED by {program} {tests}"


def main():
    build = os.path.abspath(sys.argv[1])
    mutants = [m for m in MUTANTS if len(sys.argv) < 3 or sys.argv[2] in m[0]]
    compile_of, link_of = {}, {}
    for program in sorted({m[4] for m in MUTANTS}):
        for line in commands(build, program):
            if " -c " in line and "/pipeline/compare/" in line:
                compile_of[os.path.basename(line.split(" -c ")[1].split()[0])] = line
        link_of[program] = commands(build, program)[-1]
    with tempfile.TemporaryDirectory(prefix="plumb-mutants-") as work, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = [pool.submit(judge, build, work, i, m, compile_of, link_of) for i, m in enumerate(mutants)]
        faults = [fault for fault in (job.result() for job in jobs) if fault]
    for fault in faults:
        print(fault)
    print(f"compare_mutants: {len(mutants)} changes, {len(mutants) - len(faults)} noticed")
    return 1 if faults or not mutants else 0


if __name__ == "__main__":
    sys.exit(main())
