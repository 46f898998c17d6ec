#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the pictures of README and docs from the rows of scenes/pictures.txt, into docs/images/. The pixels are bits; the
# text chunks of a PNG name the commit that drew it.
# usage: toolchain/pictures.sh
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

plumb_install demo
plumb_build release plumb
mkdir -p "$plumb_root/docs/images"
cd "$plumb_root"
while read -r name arguments; do
  case $name in ''|'#'*) continue ;; esac
  # shellcheck disable=SC2086
  build/release/plumb render $arguments -o "docs/images/$name.png" -q </dev/null
  plumb_say "docs/images/$name.png"
done <scenes/pictures.txt
