#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Measures everything that README.md and docs/performance.md state: `plumb bench raster`, `matrix` and `trace`, how the cost of a picture grows, and whole processes
# beside other programs; then the table with the goals of docs/goals.csv. Exit 0 whether a goal is reached or not; 1 when pictures or results disagree.
# usage: toolchain/bench.sh [--write] [--repeat N] [--small] [--build FOLDER]
#   --write    also writes docs/performance.md and its picture from the reports
#   --repeat   pairs of each row, 50
#   --small    tiny sizes, nothing installed, reports only: does it run (a test)
#   --build    a folder that is built already, not build/release
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

write='' repeat=50 small='' build=$plumb_root/build/release built=''
while [ $# -gt 0 ]; do
  case $1 in
    --write) write=--write ;;
    --small) small=--small ;;
    --repeat) [ $# -gt 1 ] || plumb_die "--repeat needs a number"; repeat=$2; shift ;;
    --build) [ $# -gt 1 ] || plumb_die "--build needs a folder"; build=$(cd "$2" && pwd); built=1; shift ;;
    -h|--help) sed -n '3,10s/^# //p' "$0"; exit 0 ;;
    *) plumb_die "unknown argument: $1" ;;
  esac
  shift
done
if [ -n "$write" ] && [ -n "$small" ]; then plumb_die "--small measures nothing that could be written"; fi

if [ -z "$small" ]; then plumb_install demo bench; fi
if [ -z "$built" ]; then plumb_build release plumb plumb_empty_device; fi
cd "$plumb_root"
out=out/bench raster=() matrix=() trace=()
if [ -n "$small" ]; then
  out=$(mktemp -d)
  trap 'rm -rf "$out"' EXIT
  raster=(sphere1e3 full-screen layers-f2b --size 96x64) matrix=(1000) trace=(spheres4 --size 96x64)
fi
mkdir -p "$out"
plumb=$build/plumb status=0
run() {
  plumb_say "bench $1"
  "$plumb" bench "$@" --repeat "$repeat" --quiet --json="$out/$1.json" >"$out/$1.txt" || status=$?
  [ "$status" -le 1 ] || exit "$status"
}
run raster "${raster[@]}"
run matrix "${matrix[@]}"
run trace "${trace[@]}"
plumb_say "bench growth"
python3 toolchain/bench_growth.py "$plumb" "$out/growth.json" --repeat "$repeat" $small
plumb_say "bench start"
python3 toolchain/bench_start.py "$plumb" "$build/host/plumb_empty_device" "$out/start.json" --repeat "$repeat" $small
if [ -z "$small" ]; then
  plumb_say "bench process"
  python3 toolchain/bench_process.py "$plumb" --repeat "$repeat" >"$out/process.json"
fi
python3 toolchain/bench_table.py $write $small "$out"
exit "$status"
