#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs Gappa on the proofs beside the contracts, shaders/shared/*.g, with each constant taken from the product's own text.

A proof is a Gappa script whose comments say what it is of:

    # contract FILE: TEXT       FILE of shaders/shared must hold TEXT: where the code changes, the proof is of something else and fails
    # bound NAME FILE: REGEX    the number that REGEX finds in FILE is what is proved; @NAME@ stands for it, @NAME:u@ for its share of 2^-24
    # given NAME FILE: REGEX    the same for a number that the proof starts from

usage: prove.py ROOT             exit 0: all proved; 1: one line for each that is not
       prove.py ROOT --self-test exit 1 where a proof still goes through with a bound that is half as large, or a contract that is another
       prove.py ROOT --only NAME one proof, with what Gappa says
"""
import glob
import math
import os
import re
import shutil
import subprocess
import sys


class Fault(Exception):
    pass


def dyadic(number):
    """number * 2^-24 in Gappa's notation, rounded downward, so that what is proved is no weaker than what is stated."""
    return f"{math.floor(number * 2 ** 20)}b-44"


def stated(root, file, pattern):
    with open(os.path.join(root, "shaders/shared", file), encoding="utf-8") as f:
        found = re.findall(pattern, f.read())
    if len(found) != 1:
        raise Fault(f"{file}: '{pattern}' is there {len(found)} times, not once")
    return float(found[0])


def squeezed(text):
    return " ".join(text.split())


class Proof:
    def __init__(self, root, path):
        self.root, self.name = root, os.path.basename(path)
        with open(path, encoding="utf-8") as f:
            self.text = f.read()
        self.contracts = re.findall(r"^# contract (\S+): (.+)$", self.text, re.M)
        self.numbers = re.findall(r"^# (bound|given) (\w+) (\S+): (.+)$", self.text, re.M)
        if not self.contracts or not any(kind == "bound" for kind, *_ in self.numbers):
            raise Fault(f"{self.name}: names no contract or no bound")

    def script(self, halved=""):
        text = re.sub(r"#.*", "", self.text)
        for kind, name, file, pattern in self.numbers:
            number = stated(self.root, file, pattern) / (2 if name == halved else 1)
            if f"@{name}@" not in text and f"@{name}:u@" not in text:
                raise Fault(f"{self.name}: {name} is not used")
            text = text.replace(f"@{name}:u@", dyadic(number)).replace(f"@{name}@", repr(number))
        if "@" in text.replace("@rnd", ""):
            raise Fault(f"{self.name}: names a number that is not stated")
        return text

    def check_contracts(self, change=lambda text: text):
        for file, line in self.contracts:
            with open(os.path.join(self.root, "shaders/shared", file), encoding="utf-8") as f:
                if squeezed(change(line)) not in squeezed(f.read()):
                    raise Fault(f"{self.name}: {file} does not hold '{line}': what is proved is not what is there")

    def run(self, halved=""):
        """What Gappa says, or a Fault where it proves nothing."""
        gappa = shutil.which("gappa")
        if not gappa:
            raise Fault("gappa is missing: apt-get install gappa")
        done = subprocess.run([gappa, "-Eno-auto-dichotomy"], input=self.script(halved), capture_output=True, text=True)
        if done.returncode != 0 or "some enclosures were not satisfied" in done.stderr:
            raise Fault(f"{self.name}: not proved: {(done.stderr + done.stdout).strip()[-400:]}")
        return done.stderr + done.stdout


def main(arguments):
    root = arguments[0]
    proofs = [Proof(root, path) for path in sorted(glob.glob(os.path.join(root, "shaders/shared/*.g")))]
    if not proofs:
        raise Fault("there is no proof")
    if arguments[1:2] == ["--only"]:
        for proof in proofs:
            if proof.name == arguments[2]:
                print(proof.script(), proof.run())
        return 0
    faults = bounds = 0
    for proof in proofs:
        try:
            proof.check_contracts()
            proof.run()
        except Fault as fault:
            print(fault)
            faults += 1
    if arguments[1:2] != ["--self-test"]:
        print(f"prove: {len(proofs)} proofs, {faults} faults")
        return faults != 0
    for proof in proofs:
        for name in [name for kind, name, *_ in proof.numbers if kind == "bound"]:
            bounds += 1
            try:
                proof.run(halved=name)
                print(f"{proof.name}: half of {name} is proved as well")
                faults += 1
            except Fault:
                pass
        try:
            proof.check_contracts(lambda line: line.replace("*", "+", 1) if "*" in line else line + "1")
            print(f"{proof.name}: another contract is taken for its own")
            faults += 1
        except Fault:
            pass
    print(f"prove: {bounds} bounds halved in {len(proofs)} proofs, {faults} faults")
    return faults != 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Fault as fault:
        sys.exit(f"prove.py: {fault}")
