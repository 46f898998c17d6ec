#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds in a root of another Debian, draws every committed scene there and here, and compares the hashes of all planes (toolchain/scene_hashes.py).
# usage: toolchain/elsewhere.sh [--plumb PROGRAM] [SUITE]
#   SUITE     bookworm or trixie; without it the one that this machine is not
#   --plumb   a program of this machine that is built already, not build/release/plumb
# Exit 0: every plane has one hash; 1: some differ, each is named; 2: usage; 4: nothing was compared, because this machine cannot have such a root (it takes
# root, chroot and mount namespaces, and Debian's mirror); 5: nothing was compared, because building or drawing failed.
# The root is kept in ${XDG_CACHE_HOME:-~/.cache}/plumb-elsewhere/SUITE (2 GB), with its build tree.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

stop() { printf 'elsewhere.sh: not compared: %s\n' "$2" >&2; exit "$1"; }

plumb='' suite=''
while [ $# -gt 0 ]; do
  case $1 in
    --plumb) [ $# -gt 1 ] || { printf -- '--plumb needs a program\n' >&2; exit 2; }; plumb=$(realpath "$2"); shift ;;
    -h|--help) sed -n '3,10s/^# //p' "$0"; exit 0 ;;
    bookworm|trixie) suite=$1 ;;
    *) printf 'elsewhere.sh: unknown argument: %s\n' "$1" >&2; exit 2 ;;
  esac
  shift
done

here=$(. /etc/os-release 2>/dev/null && printf '%s' "${VERSION_CODENAME:-}") || true
case $here in
  bookworm) suite=${suite:-trixie} ;;
  trixie) suite=${suite:-bookworm} ;;
  *) stop 4 "this is neither Debian 12 nor 13, so where packages come from is not known" ;;
esac
[ "$(id -u)" = 0 ] || stop 4 "a root of another Debian needs root: sudo toolchain/elsewhere.sh"
unshare --mount --propagation private true 2>/dev/null || stop 4 "this machine lets nobody mount (a container without CAP_SYS_ADMIN?)"
command -v chroot >/dev/null || stop 4 "there is no chroot"
plumb_install demo elsewhere
command -v debootstrap >/dev/null || stop 4 "there is no debootstrap"

cache=${XDG_CACHE_HOME:-$HOME/.cache}/plumb-elsewhere/$suite root=$cache/root
mkdir -p "$cache"
exec 9>"$cache/lock"
flock -n 9 || { plumb_say "another elsewhere.sh is at work in $cache: waiting"; flock 9; }

# Where this machine's Debian comes from, and the same for the other suite: entries whose suite is this Debian's, in both forms of apt's lists.
sources_of() {
  local file
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
    case $file in
      *.sources) awk -v here="$here" -v there="$suite" 'BEGIN { RS = ""; ORS = "\n\n" }
        $0 ~ "(^|\n)Suites:[^\n]*[ \t]" here "([ \t\n-]|$)" && $0 !~ "(^|\n)Enabled:[ \t]*no" { gsub(here, there); print }' "$file" ;;
      *.list) awk -v here="$here" -v there="$suite" '$1 == "deb" && $0 ~ "[ \t]" here "([ \t-]|$)" { gsub(here, there); print }' "$file" ;;
    esac
  done 2>/dev/null
}
sources=$(sources_of)
mirror=$(printf '%s\n' "$sources" | sed -n -E "s/^URIs:[ \t]*([^ \t]+).*/\1/p; s/^deb[ \t]+(\[[^]]*\][ \t]+)?([^ \t]+)[ \t]+$suite[ \t].*/\2/p" | head -n 1)
[ -n "$mirror" ] || stop 4 "apt's sources name no mirror of $here"

if [ ! -d "$root" ]; then
  plumb_say "unpacking a root of $suite"
  rm -rf --one-file-system "$root.part"
  debootstrap --variant=minbase --include=ca-certificates "$suite" "$root.part" "$mirror" >"$cache/debootstrap.log" 2>&1 ||
    stop 4 "debootstrap failed: $(tail -n 1 "$cache/debootstrap.log")"
  mv "$root.part" "$root"
fi
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
: >"$root/etc/apt/sources.list"
rm -f "$root"/etc/apt/sources.list.d/*
# The keyring has another name in each.
for keyring in /usr/share/keyrings/debian-archive-keyring.pgp /usr/share/keyrings/debian-archive-keyring.gpg; do
  [ ! -e "$root$keyring" ] || sources=$(printf '%s\n' "$sources" | sed -E "s|/usr/share/keyrings/debian-archive-keyring\.[a-z]+|$keyring|")
done
case $sources in
  *URIs:*) printf '%s\n' "$sources" >"$root/etc/apt/sources.list.d/debian.sources" ;;
  *) printf '%s\n' "$sources" >"$root/etc/apt/sources.list" ;;
esac
apt-config dump | grep -E '^Acquire::(http|https|Retries|Check-Valid-Until|By-Hash)' >"$root/etc/apt/apt.conf.d/99of-host" || true

# What git tracks, as it stands in this tree; the build tree of the last time stays, and times of files with it.
tree=$root/root/plumbline
mkdir -p "$tree"
find "$tree" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
cd "$plumb_root"
if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then git ls-files -z --cached --others --exclude-standard; else
  find . \( -path ./build -o -path ./out -o -path ./.git \) -prune -o -type f -print0; fi |
  while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done | tar --null --no-recursion -T - -cf - | tar -xf - -C "$tree"

# within SCRIPT: in the other root, with nothing of this machine's environment but the way out.
within() {
  unshare --mount --propagation private bash -c '
    set -e
    root=$1
    mount --bind /proc "$root/proc"; mount --bind /dev "$root/dev"; mount -t tmpfs none "$root/tmp"
    exec chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 PLUMB_JOBS="$3" ${http_proxy:+http_proxy="$http_proxy"} \
      ${https_proxy:+https_proxy="$https_proxy"} ${no_proxy:+no_proxy="$no_proxy"} bash -c "set -euo pipefail; cd /root/plumbline; $2"' within "$root" "$1" "$plumb_jobs" 9>&-
}
versions='printf "%s; " "$(. /etc/os-release; printf %s "$PRETTY_NAME")" "$(c++ --version | head -n 1)" "$(glslangValidator --version | sed -n "s/^Glslang Version: /glslang /p")" "$(spirv-opt --version 2>&1 | grep -m 1 SPIRV-Tools)"'

plumb_say "installing and building in $root"
within '. toolchain/setup.sh; plumb_install demo' 2>"$cache/install.log" || stop 4 "installing failed: $(tail -n 1 "$cache/install.log")"
within '. toolchain/setup.sh; plumb_build release plumb' >"$cache/build.log" 2>&1 || stop 5 "building failed: $(grep -E 'error|Error' "$cache/build.log" | head -n 1) ($cache/build.log)"
if [ -z "$plumb" ]; then
  plumb_build release plumb || stop 5 "building here failed"
  plumb=$plumb_root/build/release/plumb
fi
plumb_say "drawing there"
within 'python3 toolchain/scene_hashes.py build/release/plumb' >"$cache/$suite.txt" 2>"$cache/$suite.log" || stop 5 "drawing in $suite failed: $(head -n 1 "$cache/$suite.log")"
plumb_say "drawing here"
python3 toolchain/scene_hashes.py "$plumb" >"$cache/$here.txt" 2>"$cache/$here.log" || stop 5 "drawing here failed: $(head -n 1 "$cache/$here.log")"

printf '%s: %s%s\n' "$here" "$(bash -c "$versions")" "$(tail -n 1 "$cache/$here.log")"
printf '%s: %s%s\n' "$suite" "$(within "$versions")" "$(tail -n 1 "$cache/$suite.log")"
cd "$cache"
python3 "$plumb_root/toolchain/scene_hashes.py" --compare "$here.txt" "$suite.txt"
