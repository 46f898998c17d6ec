#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Measures the plans of every committed scene, and makes the picture and the table of docs/budgets.md. For a quiet machine: its times are shown.
# usage: toolchain/plan_picture.sh [PLUMB [FLAG...]]    PLUMB: a command that is built already; else the release build. FLAG: of `bench plan`, instead of --size 320x240
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

plumb_command "${1:-}"
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- --size 320x240
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
(cd "$plumb_root" && "$plumb" bench plan "$@" --json="$folder/plans.json")
/usr/bin/python3 "$plumb_root/toolchain/plan_fronts.py" "$folder/plans.json" "$plumb_root/docs/images/plans.svg"
/usr/bin/python3 "$plumb_root/toolchain/plan_fronts.py" --table "$folder/plans.json" "$plumb_root/docs/budgets.md"
plumb_say "docs/images/plans.svg, docs/budgets.md"
