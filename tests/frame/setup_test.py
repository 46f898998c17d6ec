#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""toolchain/setup.sh beside a registry, a package database and a CMake of our own: waits for apt's locks and says so, gives up in time, does not wait for
another fault, and configures again when packages came. usage: setup_test.py SOURCE"""
import os
import stat
import subprocess
import sys
import tempfile

HELD = "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)"
# Each plays the next line of its script: `exit status|seconds|text`; the last line stays.
APT = r"""#!/bin/bash
echo "$*" >>"$FAKE/apt.calls"
line=$(head -n 1 "$FAKE/apt.script")
[ "$(wc -l <"$FAKE/apt.script")" -le 1 ] || sed -i 1d "$FAKE/apt.script"
IFS='|' read -r status seconds text <<<"$line"
echo "$text"
sleep "$seconds"
[ "$status" != 0 ] || case " $* " in *" install "*) for word in "$@"; do echo "$word" >>"$FAKE/installed"; done ;; esac
exit "$status"
"""
DPKG = r"""#!/bin/bash
for word in "$@"; do case $word in -*) ;; *) grep -qx -- "$word" "$FAKE/installed" && case $* in *Version*) echo "installed $word 1" ;; *) echo installed ;; esac ;; esac; done
exit 0
"""
CMAKE = r"""#!/bin/bash
echo "$*" >>"$FAKE/cmake.calls"
case $1 in --preset) mkdir -p "$TREE/build/$2" && touch "$TREE/build/$2/build.ninja" ;; esac
"""


class Place:
    """A tree with setup.sh and a list of two sections, and the three programs before all others."""

    def __init__(self, source, folder):
        self.folder, self.tree = folder, os.path.join(folder, "tree")
        os.makedirs(os.path.join(self.tree, "toolchain"))
        with open(os.path.join(source, "toolchain", "setup.sh"), encoding="utf-8") as f:
            self.write("tree/toolchain/setup.sh", f.read())
        self.write("tree/toolchain/packages.txt", "# demo\nalpha\n\n# bench\nbeta\n")
        self.write("installed", "")
        for name, text in (("apt-get", APT), ("dpkg-query", DPKG), ("cmake", CMAKE), ("sudo", '#!/bin/bash\nexec "$@"\n')):
            self.write(f"bin/{name}", text)
            os.chmod(os.path.join(folder, "bin", name), stat.S_IRWXU)

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as f:
            f.write(text)

    def read(self, name):
        path = os.path.join(self.folder, name)
        return open(path, encoding="utf-8").read() if os.path.exists(path) else ""

    def run(self, script, *lines, wait="20"):
        """(exit status, standard error) of a script that sources setup.sh; the lines are what apt-get plays."""
        self.write("apt.script", "".join(line + "\n" for line in lines))
        self.write("apt.calls", "")
        self.write("cmake.calls", "")
        environment = {"PATH": f"{self.folder}/bin:/usr/bin:/bin", "FAKE": self.folder, "TREE": self.tree, "PLUMB_LOCK_WAIT_S": wait, "LC_ALL": "C.UTF-8"}
        done = subprocess.run(["bash", "-c", f"set -euo pipefail; . {self.tree}/toolchain/setup.sh; {script}"], capture_output=True, text=True, env=environment, timeout=60)
        return done.returncode, done.stderr


def main():
    with tempfile.TemporaryDirectory() as folder:
        return judged(sys.argv[1], folder)


def judged(source, folder):
    wrong, places = [], []

    def expect(claim, true, *shown):
        if not true:
            wrong.append(f"{claim}: {shown}")

    def place():
        places.append(Place(source, os.path.join(folder, str(len(places)))))
        return places[-1]

    waits = "another process holds apt's lock: waiting, at most 20 s"
    p = place()
    status, said = p.run("plumb_install demo", f"100|0|{HELD}", f"100|0|{HELD}", "0|0|done")
    calls = p.read("apt.calls").splitlines()
    expect("a lock that apt-get does not wait for is tried again", status == 0 and len(calls) == 3 and all(" install " in call for call in calls), status, said, calls)
    expect("the wait is said once", said.count(waits) == 1, said)
    expect("apt-get waits for dpkg's lock by itself", all("DPkg::Lock::Timeout=" in call for call in calls), calls)
    status, said = p.run("plumb_install demo", "1|0|must not be asked")
    expect("nothing is asked when nothing is missing", status == 0 and not p.read("apt.calls") and not said, status, said)

    status, said = place().run("plumb_install demo", "0|1|Waiting for cache lock: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 7 (dpkg)")
    expect("apt-get's own wait is said while it waits", status == 0 and said.count(waits) == 1, status, said)

    status, said = place().run("plumb_install demo", f"100|0|{HELD}", wait="2")
    expect("the wait has an end, and names who holds the lock", status == 1 and "It is held by process 7" in said, status, said)

    p = place()
    status, said = p.run("plumb_install demo", "100|0|E: Unable to locate package alpha")
    calls = p.read("apt.calls").splitlines()
    expect("another fault is not waited for", status == 1 and "waiting" not in said and len(calls) == 2, status, said, calls)  # install, update

    p = place()
    configured = lambda: p.read("cmake.calls").count("--preset")
    status, said = p.run("plumb_install demo; plumb_build release one", "0|0|done")
    expect("a new tree is configured", status == 0 and configured() == 1 and "--target one" in p.read("cmake.calls"), status, said, p.read("cmake.calls"))
    status, said = p.run("plumb_install demo; plumb_build release one", "0|0|done")
    expect("a configured tree is left alone", status == 0 and configured() == 0, status, said)
    status, said = p.run("plumb_install demo bench; plumb_build release one", "0|0|done")
    expect("packages that came are looked for", status == 0 and configured() == 1, status, said, p.read("cmake.calls"))
    status, said = p.run("plumb_build release one")
    expect("once", status == 0 and configured() == 0, status, said)

    for line in wrong:
        print(line)
    print(f"setup_test: {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
