#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Measures: `plumb bench raster`, `matrix` and `trace`, and whole processes against POV-Ray, then the table with the goals of docs/goals.csv. Exit 0 whether a goal is
# reached or not; 1 when pictures or results disagree.
# usage: toolchain/bench.sh [--write] [--repeat N]
#   --write   also writes docs/performance.md from the reports
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

write='' repeat=50
while [ $# -gt 0 ]; do
  case $1 in
    --write) write=--write ;;
    --repeat) [ $# -gt 1 ] || plumb_die "--repeat needs a number"; repeat=$2; shift ;;
    -h|--help) sed -n '3,7s/^# //p' "$0"; exit 0 ;;
    *) plumb_die "unknown argument: $1" ;;
  esac
  shift
done

plumb_install demo bench
plumb_build release plumb
mkdir -p "$plumb_root/out"
cd "$plumb_root"
status=0
for bench in raster matrix trace; do
  plumb_say "bench $bench"
  build/release/plumb bench "$bench" --repeat "$repeat" --json="out/bench-$bench.json" >"out/bench-$bench.txt" || status=$?
  [ "$status" -le 1 ] || exit "$status"
done
plumb_say "bench process"
python3 toolchain/bench_process.py build/release/plumb --repeat "$repeat" >out/bench-process.json
python3 toolchain/bench_table.py $write out/bench-raster.json out/bench-matrix.json out/bench-trace.json out/bench-process.json
exit "$status"
