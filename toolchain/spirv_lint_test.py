#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mutation test of spirv_lint.py: each way out of the exact subset, put into each module that it fits, must be noticed.

usage: spirv_lint_test.py [--list FILE] MODULE.spv... [--inlined [--list FILE] MODULE.spv...]
"""
import os
import sys

import spirv_lint as lint

EACH = 25  # a large module takes 0.1 s to judge


def find(words, wanted):
    """First word of each instruction with an opcode of `wanted`, with the function it stands in (None outside)."""
    names, function = {}, None
    for at, op, a in lint.instructions(words):
        if op == lint.OP_NAME:
            names[a[0]] = lint.text_of(a[1:])
        if op == lint.OP_FUNCTION:
            function = names.get(a[1], "?").split("(")[0]
        if op in wanted:
            yield at, function
        if op == lint.OP_FUNCTION_END:
            function = None


def with_opcode(words, at, opcode):
    changed = list(words)
    changed[at] = (changed[at] & 0xFFFF0000) | opcode
    return changed


def inserted(words, at, instruction):
    return words[:at] + instruction + words[at:]


def first_function(words):
    return next(at for at, op, _ in lint.instructions(words) if op == lint.OP_FUNCTION)


def first_annotation(words):
    """Where a decoration may be inserted: before the first OpDecorate."""
    return next((at for at, op, _ in lint.instructions(words) if op in (lint.OP_DECORATE, lint.OP_MEMBER_DECORATE)), None)


def spread(places):
    return places[::max(1, -(-len(places) // EACH))]


def mutants(words):
    """(what was done, changed module). The two likeliest slips (no NoContraction, a native division) at up to EACH places spread over the
    module, the others once a module."""
    results = {a[1] for _, op, a in lint.instructions(words) if op in lint.EXACT}
    decorations = [(at, a[0]) for at, op, a in lint.instructions(words)
                   if op == lint.OP_DECORATE and a[1] == lint.NO_CONTRACTION and a[0] in results]
    for at, target in spread(decorations):
        yield f"NoContraction of %{target} stripped", words[:at] + words[at + 3:]
    exact = [at for at, function in find(words, lint.EXACT)]
    plain = [at for at, function in find(words, lint.EXACT) if function not in lint.SEEDS]
    for at in spread(plain):
        yield "float operation becomes OpFDiv", with_opcode(words, at, 136)
    if exact:
        for opcode, name in ((140, "OpFRem"), (141, "OpFMod"), (143, "OpMatrixTimesScalar"), (144, "OpVectorTimesMatrix"),
                             (145, "OpMatrixTimesVector"), (146, "OpMatrixTimesMatrix"), (148, "OpDot"), (350, "OpGroupNonUniformFAdd"),
                             (6035, "OpAtomicFAddEXT"), (87, "OpImageSampleImplicitLod"), (9999, "an unknown opcode")):
            yield f"float operation becomes {name}", with_opcode(words, exact[0], opcode)
        at = exact[-1]
        type_id, a, b = words[at + 1], words[at + 3], words[at + 4]
        added = inserted(words, at + 5, [(5 << 16) | 148, type_id, words[3], a, b])
        added[3] += 1
        yield "OpDot inserted", added
        glsl = next((a[0] for _, op, a in lint.instructions(words)
                     if op == lint.OP_EXT_INST_IMPORT and lint.text_of(a[1:]) == "GLSL.std.450"), None)
        if glsl is not None and plain:
            at = plain[-1]
            for number, name in ((1, "Round"), (10, "Fract"), (26, "Pow"), (29, "Exp2"), (31, "Sqrt"), (32, "InverseSqrt"),
                                 (46, "FMix"), (50, "Fma"), (66, "Length"), (69, "Normalize")):
                added = inserted(words, at + 5, [(6 << 16) | 12, words[at + 1], words[3], glsl, number, words[at + 3]])
                added[3] += 1
                yield f"{name} inserted", added
            other = inserted(words, at + 5, [(6 << 16) | 12, words[at + 1], words[3], words[3] - 1, 4, words[at + 3]])
            other[3] += 1
            yield "instruction of an unknown set inserted", other
    for at, function in find(words, {136}):
        if function in lint.SEEDS:  # the same division, in a function of another name
            changed = list(words)
            for name_at, op, a in lint.instructions(words):
                if op == lint.OP_NAME and lint.text_of(a[1:]).split("(")[0] == function:
                    changed[name_at + 2] ^= 0x01010101
            yield f"{function} renamed", changed
            break
    for caller in lint.CALLERS:  # a seed called from a function of another name
        changed = list(words)
        for at, op, a in lint.instructions(words):
            if op == lint.OP_NAME and lint.text_of(a[1:]).split("(")[0] == caller:
                changed[at + 2] ^= 0x01010101
        calls = any(function == caller for at, function in find(words, {lint.OP_FUNCTION_CALL}))
        if calls and caller.startswith("emulated"):
            yield f"{caller} renamed", changed
    if any(a[3] == lint.NATIVE_EXT for _, op, a in lint.instructions(words) if op == 12):  # the device's own power, under another name
        for name in (lint.NATIVE, lint.NATIVE_CALLERS[0], lint.NATIVE_CALLERS[1]):
            changed = list(words)
            for at, op, a in lint.instructions(words):
                if op == lint.OP_NAME and lint.text_of(a[1:]).split("(")[0] == name:
                    changed[at + 2] ^= 0x01010101
            if changed != words:
                yield f"{name} renamed", changed
    if any(op == lint.F_CONVERT for _, op, a in lint.instructions(words)):  # binary64, under another name
        present = {function for _, function in find(words, {lint.F_CONVERT, lint.OP_FUNCTION_CALL})}
        for name in (lint.DOUBLE, *lint.DOUBLE_CALLERS):
            changed = list(words)
            for at, op, a in lint.instructions(words):
                if op == lint.OP_NAME and lint.text_of(a[1:]).split("(")[0] == name:
                    changed[at + 2] ^= 0x01010101
            if name in present:
                yield f"{name} renamed", changed
    place = first_annotation(words)
    if place is not None:
        some = words[first_function(words) + 2]
        for decoration in (lint.RELAXED_PRECISION, lint.FP_FAST_MATH_MODE):
            count = 3 if decoration == lint.RELAXED_PRECISION else 4
            yield f"decoration {decoration} added", inserted(words, place, [(count << 16) | 71, some, decoration] + [0] * (count - 3))
    for at, op, a in lint.instructions(words):
        if op == lint.OP_TYPE_FLOAT:
            changed = list(words)
            changed[at + 2] = 16
            yield "float of 16 bits", changed
        if op == lint.OP_EXECUTION_MODE:
            yield "RoundingModeRTZ added", inserted(words, at, [(4 << 16) | 16, a[0], 4463, 32])
    yield "torn off in the middle of an instruction", words[:-1] + [words[-1] + (7 << 16)]


def main():
    total = missed = 0
    kinds = set()
    for path, inlined in lint.paths_of(sys.argv[1:]):
        if lint.exempt(path):
            continue
        name, words = os.path.basename(path), lint.read(path)
        native, double = lint.is_native(path), lint.is_double(path)
        if lint.lint(words, native, double, inlined)[0]:
            print(f"{name}: not clean before it is mutated")
            return 1
        if native or double:  # where the name does not say so, it may not be there
            total += 1
            kinds.add("judged as an exact module")
            if not lint.lint(words, inlined=inlined)[0]:
                missed += 1
                print(f"{name}: unnoticed: judged as an exact module")
        for what, changed in mutants(words):
            if inlined and what in ("float operation becomes OpFDiv", "Sqrt inserted", "Pow inserted"):
                continue  # it may stand in some function, which is what the other form of the module is judged by
            total += 1
            kinds.add("NoContraction stripped" if what.startswith("NoContraction") else what)
            try:
                noticed = bool(lint.lint(changed, native, double, inlined)[0])
            except (ValueError, IndexError):
                noticed = True
            if not noticed:
                missed += 1
                print(f"{name}: unnoticed: {what}")
    print(f"spirv_lint_test: {total} mutants of {len(kinds)} kinds, {missed} unnoticed")
    return 1 if missed or len(kinds) < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
