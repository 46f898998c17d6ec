#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Keeps SPIR-V modules inside the exact subset: what every conforming device computes to the same bits (docs/accuracy.md).

Every OpFAdd, OpFSub, OpFMul and OpVectorTimesScalar carries NoContraction. Every other instruction of a function body is on the list below,
which holds what the Vulkan specification defines to the last bit; an unknown one is a fault. OpFDiv and Sqrt stand only in the functions
SEEDS, which only the functions CALLERS of shaders/shared/exact.h call: as a seed whose error integer arithmetic takes out, or where the
self-test has found them correctly rounded.
No RelaxedPrecision, no fast-math decoration, no float of another width than 32 bits, no rounding mode but round to nearest even.

Modules with "_native" in their names draw only when a choice asks for the device's own functions (docs/accuracy.md#bounded). They may hold one
thing more: Pow, in the functions nativePow, which only NATIVE_CALLERS call.

Modules with "_double" in their names may hold binary64, its conversions and the reading of its words, in the functions rowTimesDouble, which only
DOUBLE_CALLERS call: host/binary64.cpp asks a device whether it keeps those before it runs them.

Functions are judged in modules as glslang wrote them, before the build inlines them; of the modules that are embedded (--inlined) everything but which
function an instruction stands in.

Modules whose name starts with "selftest", "canary" or "fingerprint" measure the device and are listed, not judged.

usage: spirv_lint.py [--quiet] MODULE.spv... [--inlined MODULE.spv...]    exit 1 on a fault; --list FILE: one path a line
"""
import os
import struct
import sys

SEEDS = ("nativeDivide", "nativeRoot")
CALLERS = ("exactDivide", "exactRoot", "emulatedDivide", "emulatedRoot")

NATIVE, NATIVE_EXT = "nativePow", 26
NATIVE_CALLERS = ("nativePower", "encodeNative")

DOUBLE, DOUBLE_EXT, F_CONVERT = "rowTimesDouble", 59, 115
DOUBLE_CALLERS = ("doubleClip",)

EXACT = {129: "OpFAdd", 131: "OpFSub", 133: "OpFMul", 142: "OpVectorTimesScalar"}
SEED_OPS = {136: "OpFDiv"}
SEED_EXT = {31: "Sqrt"}
NAMES = {136: "OpFDiv", 140: "OpFRem", 141: "OpFMod", 143: "OpMatrixTimesScalar", 144: "OpVectorTimesMatrix",
         145: "OpMatrixTimesVector", 146: "OpMatrixTimesMatrix", 147: "OpOuterProduct", 148: "OpDot", 115: "OpFConvert"}

# Opcodes that may stand in a function body, by the groups of the SPIR-V specification.
ALLOWED = {
    0, 1,                                    # Nop, Undef
    8, 317,                                  # Line, NoLine
    12,                                      # ExtInst: see ALLOWED_EXT
    54, 55, 56, 57,                          # Function, FunctionParameter, FunctionEnd, FunctionCall
    59, 60, 61, 62, 63, 65, 66, 68,          # Variable, ImageTexelPointer, Load, Store, CopyMemory, AccessChain, ..., ArrayLength
    77, 78, 79, 80, 81, 82, 83, 84,          # VectorExtractDynamic ... Transpose
    86, 95, 98, 99, 100, 104,                # SampledImage, ImageFetch, ImageRead, ImageWrite, Image, ImageQuerySize
    109, 110, 111, 112, 113, 114, 124,       # float <-> int, UConvert, SConvert, Bitcast
    126, 127, 128, 130, 132,                 # SNegate, FNegate, IAdd, ISub, IMul
    134, 135, 137, 138, 139,                 # UDiv, SDiv, UMod, SRem, SMod
    149, 150, 151, 152,                      # IAddCarry, ISubBorrow, UMulExtended, SMulExtended
    154, 155, 156, 157,                      # Any, All, IsNan, IsInf
    *range(164, 192),                        # logical operations, Select, comparisons
    *range(194, 206),                        # shifts, bit fields, BitReverse, BitCount
    224, 225,                                # ControlBarrier, MemoryBarrier
    *range(227, 243),                        # atomics on integers
    245, 246, 247, 248, 249, 250, 251, 253, 254, 255,  # Phi, control flow
    333, 334, 335, 336, 337, 338, 339, 340, 341, 342, 343, 344, 345, 346, 347, 348,  # subgroup votes, ballots, shuffles
    349, 351, 353, 354, 355, 356, 357, 358, 359, 360, 361, 362, 363, 364,  # subgroup integer arithmetic, min and max
    400, 401, 403,                           # CopyLogical, PtrEqual, PtrDiff
} | set(EXACT)

# GLSL.std.450. Not here, on purpose: Round (ties are the implementation's), Fract, Modf, FMix, Fma, Ldexp, Pack and Unpack.
ALLOWED_EXT = {2: "RoundEven", 3: "Trunc", 4: "FAbs", 5: "SAbs", 6: "FSign", 7: "SSign", 8: "Floor", 9: "Ceil",
               37: "FMin", 38: "UMin", 39: "SMin", 40: "FMax", 41: "UMax", 42: "SMax", 43: "FClamp", 44: "UClamp",
               45: "SClamp", 73: "FindILsb", 74: "FindSMsb", 75: "FindUMsb", 79: "NMin", 80: "NMax", 81: "NClamp"}

EXT_NAMES = {1: "Round", 10: "Fract", 13: "Sin", 14: "Cos", 26: "Pow", 27: "Exp", 28: "Log", 29: "Exp2", 30: "Log2", 31: "Sqrt",
             32: "InverseSqrt", 46: "FMix", 50: "Fma", 53: "Ldexp", 66: "Length", 67: "Distance", 68: "Cross", 69: "Normalize",
             71: "Reflect", 72: "Refract"}

OP_NAME, OP_EXT_INST_IMPORT, OP_EXECUTION_MODE, OP_TYPE_FLOAT, OP_SPEC_CONSTANT_OP = 5, 11, 16, 22, 52
OP_FUNCTION, OP_FUNCTION_END, OP_FUNCTION_CALL, OP_DECORATE, OP_MEMBER_DECORATE = 54, 56, 57, 71, 72
RELAXED_PRECISION, FP_ROUNDING_MODE, FP_FAST_MATH_MODE, NO_CONTRACTION = 0, 39, 40, 42
MODES = {4459: None, 4460: "DenormFlushToZero", 4461: None, 4462: None, 4463: "RoundingModeRTZ", 31: "ContractionOff"}
# OpSpecConstantOp works on integers and booleans in a shader; what it may hold is what a body may hold, less the float operations.


def instructions(words):
    """(index of the first word, opcode, operands) of each instruction; raises ValueError on a torn module."""
    if len(words) < 5 or words[0] != 0x07230203:
        raise ValueError("is no SPIR-V module")
    at = 5
    while at < len(words):
        count, opcode = words[at] >> 16, words[at] & 0xFFFF
        if count == 0 or at + count > len(words):
            raise ValueError(f"instruction at word {at} runs over the end")
        yield at, opcode, words[at + 1:at + count]
        at += count


def text_of(words):
    return struct.pack(f"<{len(words)}I", *words).split(b"\0")[0].decode("utf-8", "replace")


def read(path):
    with open(path, "rb") as f:
        data = f.read()
    if len(data) % 4:
        raise ValueError("is no whole number of words")
    return list(struct.unpack(f"<{len(data) // 4}I", data))


def lint(words, native=False, double=False, inlined=False):
    """(faults as sentences, number of exact float operations). native: the module may hold the device's own power; double: binary64; inlined: its
    functions are gone, so what they may hold may stand anywhere."""
    faults, names, no_contraction, sets, exact = [], {}, set(), {}, 0
    for _, op, a in instructions(words):
        if op == OP_NAME:
            names[a[0]] = text_of(a[1:])
        elif op == OP_EXT_INST_IMPORT:
            sets[a[0]] = text_of(a[1:])
        elif op == OP_DECORATE and a[1] == NO_CONTRACTION:
            no_contraction.add(a[0])
        decoration = a[1] if op == OP_DECORATE else a[2] if op == OP_MEMBER_DECORATE else None
        if decoration in (RELAXED_PRECISION, FP_ROUNDING_MODE, FP_FAST_MATH_MODE):
            faults.append(f"decoration {decoration} on {names.get(a[0], a[0])} loosens what a float operation means")
        elif op == OP_EXECUTION_MODE and MODES.get(a[1]):
            faults.append(f"execution mode {MODES[a[1]]}")
        elif op == OP_TYPE_FLOAT and a[1] != 32 and not (double and a[1] == 64):
            faults.append(f"float of {a[1]} bits")
        elif op == OP_SPEC_CONSTANT_OP and (a[2] not in ALLOWED or a[2] in EXACT or a[2] in SEED_OPS):
            faults.append(f"OpSpecConstantOp of opcode {a[2]}")
    def name_of(function_id):
        return names.get(function_id, f"function {function_id}").split("(")[0]

    function = None
    for _, op, a in instructions(words):
        if op == OP_FUNCTION:
            function = name_of(a[1])
        if function is None:
            continue
        seeds = inlined or function in SEEDS
        doubles = double and (inlined or function == DOUBLE)
        if op == 12:
            if sets.get(a[2], "").startswith("NonSemantic."):
                pass
            elif sets.get(a[2]) != "GLSL.std.450":
                faults.append(f"{function}: instruction of {sets.get(a[2], 'an unknown set')}")
            elif a[3] not in ALLOWED_EXT and not (seeds and a[3] in SEED_EXT) and not (native and (inlined or function == NATIVE) and a[3] == NATIVE_EXT) \
                    and not (doubles and a[3] == DOUBLE_EXT):
                faults.append(f"{function}: GLSL.std.450 {EXT_NAMES.get(a[3], a[3])} is not exact")
        elif op == OP_FUNCTION_CALL and name_of(a[2]) in SEEDS and function not in CALLERS:
            faults.append(f"{function}: calls {name_of(a[2])}, which only exact.h may")
        elif op == OP_FUNCTION_CALL and native and name_of(a[2]) == NATIVE and function not in NATIVE_CALLERS:
            faults.append(f"{function}: calls {NATIVE}, which only {' and '.join(NATIVE_CALLERS)} may")
        elif op == OP_FUNCTION_CALL and double and name_of(a[2]) == DOUBLE and function not in DOUBLE_CALLERS:
            faults.append(f"{function}: calls {DOUBLE}, which only {' and '.join(DOUBLE_CALLERS)} may")
        elif op in EXACT:
            exact += 1
            if a[1] not in no_contraction:
                faults.append(f"{function}: {EXACT[op]} %{a[1]} lacks NoContraction")
        elif op not in ALLOWED and not (seeds and op in SEED_OPS) and not (doubles and op == F_CONVERT):
            faults.append(f"{function}: {NAMES.get(op, f'opcode {op}')} is not in the exact subset")
        if op == OP_FUNCTION_END:
            function = None
    return faults, exact


def exempt(path):
    return os.path.basename(path).startswith(("selftest", "canary", "fingerprint"))


def is_native(path):
    return "_native" in os.path.basename(path)


def is_double(path):
    return "_double" in os.path.basename(path)


def paths_of(arguments):
    """(path, whether its functions are inlined) of each module named."""
    paths, inlined, rest = [], False, iter(arguments)
    for argument in rest:
        if argument == "--inlined":
            inlined = True
        elif argument == "--list":
            with open(next(rest), encoding="utf-8") as f:
                paths += [(line.strip(), inlined) for line in f if line.strip()]
        elif not argument.startswith("-"):
            paths.append((argument, inlined))
    return paths


def main():
    paths = paths_of(sys.argv[1:])
    faulty = judged = 0
    for path, inlined in paths:
        name = os.path.basename(path)
        try:
            if exempt(path):
                read(path)
                print(f"{name}: measures the device, not judged")
                continue
            faults, exact = lint(read(path), is_native(path), is_double(path), inlined)
        except (OSError, ValueError, IndexError) as error:
            faults, exact = [str(error)], 0
        judged += 1
        faulty += bool(faults)
        for fault in faults:
            print(f"{name}: {fault}")
        if not faults and "--quiet" not in sys.argv:
            print(f"{name}: {exact} float operations, exact" + (", and the device's own power" if is_native(path) else "") + (", and binary64" if is_double(path) else ""))
    print(f"spirv_lint: {judged} modules judged, {faulty} outside the exact subset")
    return 1 if faulty or judged == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
