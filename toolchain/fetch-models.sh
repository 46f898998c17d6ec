#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Larger meshes for tests by hand: unpacks Debian packages into build/models without installing them. Their licences are
# their own (build/models/share/doc/*/copyright); nothing of them belongs in the repository.
set -euo pipefail

packages=(assimp-testmodels occt-misc)
usage="usage: fetch-models.sh [PACKAGE...]   (default: ${packages[*]})"
case ${1-} in
  -h | --help) printf '%s\n' "$usage"; exit 0 ;;
  -*) printf '%s\n' "$usage" >&2; exit 2 ;;
esac
[ $# -gt 0 ] && packages=("$@")

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
models=$root/build/models
mkdir -p "$models"
work=$(mktemp -d "$models/fetch.XXXXXX")
trap 'rm -rf "$work"' EXIT

for package in "${packages[@]}"; do
  if [ -f "$models/share/doc/$package/copyright" ]; then
    printf '%s is here already\n' "$package" >&2
    continue
  fi
  # As root, apt-get complains that its own user cannot write here; the download succeeds all the same.
  (cd "$work" && apt-get -qq download "$package")
  dpkg-deb -x "$work/$package"_*.deb "$work/unpacked"
done
[ -d "$work/unpacked/usr" ] && cp -rT "$work/unpacked/usr" "$models"
find "$models/share" -type f \( -iname '*.obj' -o -iname '*.ply' -o -iname '*.stl' -o -iname '*.off' -o -iname '*.gltf' -o -iname '*.glb' \) | sort
