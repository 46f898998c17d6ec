#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Renders the gallery of the lecture notes (scenes/gallery.txt) into out/gallery/index.html, a page that opens from disk.
# usage: toolchain/gallery.sh [--sheet FILE.png]     the sheet is the README's docs/images/gallery.png
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

plumb_install demo
plumb_build release plumb
cd "$plumb_root"
python3 toolchain/gallery.py build/release/plumb out/gallery "$@"
