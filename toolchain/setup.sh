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

# What apt-get says when another process holds a lock. It waits by itself for the lock of dpkg; on its other locks it fails.
plumb_locked='Waiting for cache lock|Could not get lock|Unable to acquire the dpkg frontend lock|Unable to lock directory'
plumb_lock_wait_s=${PLUMB_LOCK_WAIT_S:-600}

# plumb_apt LOG WORDS...: apt-get, which waits as long as another process holds a lock, at most plumb_lock_wait_s seconds.
plumb_apt() {
  local log=$1 until=$((SECONDS + plumb_lock_wait_s)) told='' pid status left
  shift
  while :; do
    left=$((until > SECONDS ? until - SECONDS : 0)) status=0
    plumb_as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout="$left" -o Dpkg::Use-Pty=0 "$@" >"$log" 2>&1 &
    pid=$!
    while kill -0 "$pid" 2>/dev/null; do
      if [ -z "$told" ] && grep -Eqa "$plumb_locked" "$log"; then
        told=1
        plumb_say "another process holds apt's lock: waiting, at most $plumb_lock_wait_s s"
      fi
      sleep 0.2
    done
    wait "$pid" || status=$?
    if [ "$status" = 0 ] || [ "$SECONDS" -ge "$until" ] || ! grep -Eqa "$plumb_locked" "$log"; then return "$status"; fi
    if [ -z "$told" ]; then
      told=1
      plumb_say "another process holds apt's lock: waiting, at most $plumb_lock_wait_s s"
    fi
    sleep 1
  done
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
  # Package lists may be absent (a container image) or older than the mirror: the second try is with fresh ones.
  if ! plumb_apt "$log" install -y --no-install-recommends "${missing[@]}"; then
    plumb_apt "$log" update || { tail -n 20 "$log" >&2; plumb_die "apt-get update failed"; }
    plumb_apt "$log" install -y --no-install-recommends "${missing[@]}" || { tail -n 20 "$log" >&2; plumb_die "apt-get install failed"; }
  fi
  rm -f "$log"
}

# Names and versions of what is installed of all that packages.txt names: what a configured tree has looked for.
plumb_found_packages() {
  command -v dpkg-query >/dev/null || return 0
  local wanted
  mapfile -t wanted < <(sed '/^#/d;/^$/d' "$plumb_root/toolchain/packages.txt")
  dpkg-query -W -f='${db:Status-Status} ${Package} ${Version}\n' "${wanted[@]}" 2>/dev/null | sed -n 's/^installed //p' | sort || true
}

# Configures a preset when it never was or when other packages are installed than then, and builds it (or only the targets given). Ninja does nothing when
# nothing changed and configures anew by itself when a CMake file changed.
plumb_build() {
  local preset=$1 build=$plumb_root/build/$1 packages
  shift
  packages=$(plumb_found_packages)
  if [ ! -f "$build/build.ninja" ] || [ "$packages" != "$(cat "$build/packages.txt" 2>/dev/null)" ]; then
    plumb_say "configuring $preset"
    (cd "$plumb_root" && cmake --preset "$preset" >&2)
    printf '%s\n' "$packages" >"$build/packages.txt"
  fi
  plumb_say "building $preset"
  NINJA_STATUS="[$preset %f/%t %es] " cmake --build "$build" --parallel "$plumb_jobs" ${1:+--target "$@"} >&2
}

# Sets `plumb` to the path of the command: that of the caller where one is given, else of the release build, which is made.
plumb_command() {
  if [ -n "${1:-}" ]; then
    plumb=$(realpath "$1")
    return
  fi
  plumb_install demo test
  plumb_build release plumb
  plumb=$plumb_root/build/release/plumb
}
