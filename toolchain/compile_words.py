# SPDX-License-Identifier: MIT
"""Words of a compile command as CMake has Ninja run it."""
import re


def of_compiler(words):
    """Without what launches the compiler (a cache and its settings)."""
    at = next((i for i, word in enumerate(words) if re.search(r"(c\+\+|g\+\+|clang\+\+)[-\w.]*$", word)), 0)
    return words[at:]


def without(words, alone=(), with_value=()):
    """Without some flags; those of `with_value` go with the word after them."""
    kept, skip = [], False
    for word in words:
        if skip or word in with_value:
            skip = not skip
        elif word not in alone:
            kept.append(word)
    return kept


def without_precompiled(words):
    """(words that read every header as text, the precompiled header or None)"""
    header = next((words[i + 1] for i, word in enumerate(words[:-1]) if word == "-include" and words[i + 1].endswith("cmake_pch.hxx")), None)
    if header:
        at = words.index(header)
        words = words[:at - 1] + words[at + 1:]
    return without(words, ("-Winvalid-pch", "-fpch-preprocess")), header
