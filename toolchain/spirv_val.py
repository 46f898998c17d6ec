#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""spirv-val on every module. usage: spirv_val.py SPIRV_VAL [--list FILE] MODULE.spv..."""
import subprocess
import sys

import spirv_lint as lint


def main():
    paths = lint.paths_of(sys.argv[2:])
    bad = 0
    for path, _ in paths:
        bad += subprocess.run([sys.argv[1], "--target-env", "vulkan1.2", "--scalar-block-layout", path]).returncode != 0
    print(f"spirv_val: {len(paths)} modules, {bad} invalid")
    return 1 if bad or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
