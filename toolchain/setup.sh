#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Sourced by the scripts beside it, after `set -euo pipefail`: installs what is missing, configures, builds.
# Everything it says goes to stderr.

plumb_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
plumb_jobs=${PLUMB_JOBS:-$(nproc)}

plumb_say() { printf '[%4d s] %s\n' "$SECONDS" "$*" >&2; }
plumb_die() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# Package names of the sections given, one a line.
plumb_packages() {
  local wanted=" $* " section='' line
  while IFS= read -r line || [ -n "$line" ]; do
    case $line in
      '# '*) section=${line#'# '} ;;
      '') ;;
      *) case $wanted in *" $section "*) printf '%s\n' "$line" ;; esac ;;
    esac
  done <"$plumb_root/toolchain/packages.txt"
}

plumb_as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else
    command -v sudo >/dev/null || plumb_die "needs root to run: $*"
    sudo "$@"
  fi
}

# Installs the packages of the sections that dpkg does not know as installed. Asks no registry when none is missing.
plumb_install() {
  command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
    { plumb_say "not a Debian system: toolchain/packages.txt names what must be here"; return 0; }
  local package missing=()
  while IFS= read -r package; do
    case $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) in
      installed) ;;
      *) missing+=("$package") ;;
    esac
  done < <(plumb_packages "$@")
  [ "${#missing[@]}" -gt 0 ] || return 0
  plumb_say "installing ${#missing[@]} packages: ${missing[*]}"
  local log
  log=$(mktemp)
  local install=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends
                 -o Dpkg::Use-Pty=0 "${missing[@]}")
  # Package lists may be absent (a container image) or older than the mirror: the second try is with fresh ones.
  if ! plumb_as_root "${install[@]}" >"$log" 2>&1; then
    plumb_as_root apt-get update -q >"$log" 2>&1 || { tail -n 20 "$log" >&2; plumb_die "apt-get update failed"; }
    plumb_as_root "${install[@]}" >"$log" 2>&1 || { tail -n 20 "$log" >&2; plumb_die "apt-get install failed"; }
  fi
  rm -f "$log"
}

# Configures a preset when it never was, and builds it (or only the targets given). Ninja does nothing when nothing changed
# and configures anew by itself when a CMake file changed.
plumb_build() {
  local preset=$1 build=$plumb_root/build/$1
  shift
  if [ ! -f "$build/build.ninja" ]; then
    plumb_say "configuring $preset"
    (cd "$plumb_root" && cmake --preset "$preset" >&2)
  fi
  plumb_say "building $preset"
  NINJA_STATUS="[$preset %f/%t %es] " cmake --build "$build" --parallel "$plumb_jobs" ${1:+--target "$@"} >&2
}
