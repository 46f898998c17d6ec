#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds, renders the README's scenes into out/ and prints what ran, how long it took and whether the CPU twin agrees.
# usage: toolchain/demo.sh
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

plumb_install demo
plumb_build release  # with what `cmake --install` copies
plumb=$plumb_root/build/release/plumb
mkdir -p "$plumb_root/out"
cd "$plumb_root"

# The table is printed also when a scene fails, and the failure is the exit status.
status=0
while read -r name arguments; do
  case $name in ''|'#'*) continue ;; esac
  plumb_say "rendering out/$name.png"
  # The words of a row are arguments; none holds a space.
  # shellcheck disable=SC2086
  "$plumb" render $arguments -o "out/$name.png" --json="out/$name.json" -q </dev/null || status=1
  verified=0
  # shellcheck disable=SC2086
  "$plumb" verify $arguments -o "out/$name.png" </dev/null >"out/$name.verify.txt" || verified=$?
  case $verified in
    0) verdict=equal ;;
    1) verdict=DIFFERS status=1 ;;
    4) verdict='no device' status=1 ;;
    *) verdict="exit $verified" status=1 ;;
  esac
  printf '%s\n' "$verdict" >"out/$name.verdict"
done <scenes/pictures.txt

python3 toolchain/demo_table.py scenes/pictures.txt out
exit "$status"
