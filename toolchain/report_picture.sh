#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Measures a committed scene and takes the picture of its report for README and docs: docs/images/report.png. For a quiet machine: its times are shown.
# usage: toolchain/report_picture.sh [PLUMB]    PLUMB: a command that is built already; else the release build
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

plumb_command "${1:-}"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$plumb" measure "$plumb_root/scenes/suzanne.toml" --size 640x480 -o "$folder/report.html"
/usr/bin/python3 "$plumb_root/tests/browser/picture.py" "$folder/report.html" "$plumb_root/docs/images/report.png"
plumb_say "docs/images/report.png"
