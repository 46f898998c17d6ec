#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Every test through CTest, on lavapipe. usage: toolchain/test.sh [--quick | --long] [further arguments of ctest]
#   --quick  unit, twin, small frames, lint
#   (plain)  all but the long ones; with an ASan + UBSan build and clang-tidy
#   --long   everything
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

mode=plain
case ${1:-} in
  --quick|--long) mode=${1#--}; shift ;;
  -h|--help) sed -n '3,6s/^# //p' "$0"; exit 0 ;;
esac

plumb_install demo test
plumb_build test
case $mode in
  quick) select=(-L '^(unit|twin|frame-small|lint)$') ;;
  plain) plumb_build sanitize tests/unit/all tests/fuzz/all; select=(-LE '^long$') ;;
  long) plumb_build sanitize tests/unit/all tests/fuzz/all; plumb_build fuzz tests/fuzz/all; select=() ;;
esac

left_out=$(sed -n 's/^PLUMB_LEFT_OUT:INTERNAL=//p' "$plumb_root/build/test/CMakeCache.txt")
if [ -n "$left_out" ]; then plumb_say "${left_out# }"; fi
plumb_say "testing ($mode)"
exec ctest --test-dir "$plumb_root/build/test" --parallel "$plumb_jobs" --no-tests=error --output-on-failure \
  ${select[@]+"${select[@]}"} "$@"
