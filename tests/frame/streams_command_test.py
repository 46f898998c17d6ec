#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the command says and where: progress, streams that cannot be written, and files that agree with the exit code (docs/outputs.md).

usage: streams_command_test.py PLUMB PLUMB_FAULTY [unittest arguments]   (PLUMB_FAULTY: tests/frame/faulty_renderer.cpp)
"""
import base64
import hashlib
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

PLUMB, FAULTY = (os.path.abspath(program) for program in sys.argv[1:3])
CUBE = """v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n"""
SMALL = "--device twin --size 64x48"


class Streams(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="plumb-streams-")
        self.addCleanup(shutil.rmtree, self.folder)
        with open(os.path.join(self.folder, "cube.obj"), "w", encoding="utf-8") as f:
            f.write(CUBE)

    def made(self):
        """The files beside cube.obj, hidden ones as well."""
        return sorted(name for name in os.listdir(self.folder) if name != "cube.obj")

    def read(self, name):
        with open(os.path.join(self.folder, name), "rb") as f:
            return f.read()

    def shell(self, line):
        """A line of bash in which `plumb` is the program; its own exit code is the result's last line on standard error."""
        script = f'plumb() {{ "{PLUMB}" "$@"; }}\nfaulty() {{ "{FAULTY}" "$@"; }}\nset -o pipefail\n{line}'
        return subprocess.run(["bash", "-c", script], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False)


class StandardError(Streams):
    """Words for people are lost where they cannot be written; nothing else changes."""

    def test_no_state_of_it_ends_a_turntable(self):
        twenty = [f"s{i:02}.png" for i in range(20)]
        for broken in ("2>/dev/full", "2>&-", "2>&1 | head -1", "2>&1 | true", "2>/dev/full >&-", "2>&- >&- <&-"):
            for progress in ("", "--progress plain", "--progress json", "--progress bar", "-v"):
                done = self.shell(f"plumb render cube.obj {SMALL} --turntable 20 -o 's{{n}}.png' {progress} {broken}")
                self.assertEqual((done.returncode, self.made()), (0, twenty), (broken, progress, done.stderr))
                for name in twenty:
                    self.assertEqual(self.read(name)[:4], b"\x89PNG")
                    os.remove(os.path.join(self.folder, name))

    def test_no_state_of_it_changes_another_command(self):
        self.shell(f"plumb render cube.obj {SMALL} -o a.png; plumb render cube.obj {SMALL} --shading unlit -o b.png")
        for line, code in ((f"plumb render cube.obj {SMALL} -o c.png --with-error --explain -v", 0), (f"plumb render cube.obj {SMALL} --view front --view iso -o c.png", 0),
                           ("plumb diff a.png b.png -o c.png", 1), (f"plumb measure cube.obj {SMALL} --axis encoding --repetitions 2 -o c.html", 0), ("plumb info cube.obj", 0),
                           ("plumb render missing.obj -o c.png", 3), ("plumb render cube.obj", 2), (f"plumb render cube.obj {SMALL} --eye 0,0,9 --at 0,0,99 --fail-blank -o c.png", 7)):
            good = self.shell(line)
            self.assertEqual(good.returncode, code, (line, good.stderr))
            for broken in ("2>/dev/full", "2>&-"):
                self.assertEqual(self.shell(f"{line} {broken}").returncode, code, (line, broken))

    def test_no_file_is_opened_under_its_number(self):
        done = self.shell(f"plumb render cube.obj {SMALL} -o a.png -v --progress plain 2>&- >&- <&-; plumb render cube.obj {SMALL} -o b.png -q")
        self.assertEqual(done.returncode, 0)
        self.assertEqual(self.read("a.png"), self.read("b.png"))


class StandardOutput(Streams):
    """Data that cannot be written: the files are as if the command had not run, and the exit code says so."""

    COMMANDS = ((f"plumb render cube.obj {SMALL} -o a.png --json", ["a.png"]), (f"plumb render cube.obj {SMALL} --view front --view iso -o a.png --json", ["a.png"]),
                (f"plumb render cube.obj {SMALL} --turntable 3 -o 'a{{n}}.png' --json", ["a0.png", "a1.png", "a2.png"]),
                (f"plumb render cube.obj {SMALL} --aov depth,normal -o 'a{{aov}}.npy' --json", ["adepth.npy", "anormal.npy"]),
                ("plumb diff x.png y.png -o a.png --heat b.png --json", ["a.png", "b.png"]), ("plumb diff x.png y.png -o a.png", ["a.png"]),
                (f"plumb measure cube.obj {SMALL} --axis encoding --repetitions 2 -o a.html --csv=b.csv --json=c.json", ["a.html", "b.csv", "c.json"]),
                (f"plumb measure cube.obj {SMALL} --axis encoding --repetitions 2 -o a.html --json", ["a.html"]),
                ("PLUMB_FAULT=differs faulty verify cube.obj -o a.png --size 64x48 --json", [f"a.{side}.png" for side in ("device", "diff", "twin")]),
                ("PLUMB_FAULT=differs faulty verify cube.obj -o a.png --size 64x48", [f"a.{side}.png" for side in ("device", "diff", "twin")]))

    def setUp(self):
        super().setUp()
        done = self.shell(f"plumb render cube.obj {SMALL} -o x.png && plumb render cube.obj {SMALL} --shading unlit -o y.png")
        self.assertEqual(done.returncode, 0, done.stderr)

    def made(self):
        return [name for name in super().made() if name not in ("x.png", "y.png")]

    def test_nothing_new_and_everything_old_is_there(self):
        for line, files in self.COMMANDS:
            for broken in (">/dev/full", ">&-"):
                for old in (False, True):
                    for name in files if old else ():
                        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as f:
                            f.write("old")
                    done = self.shell(f"{line} {broken}")
                    self.assertEqual((done.returncode, self.made()), (5, sorted(files) if old else []), (line, broken, old, done.stderr))
                    self.assertIn(b"standard output", done.stderr)
                    for name in files if old else ():
                        self.assertEqual(self.read(name), b"old", (line, broken))
                        os.remove(os.path.join(self.folder, name))

    def test_a_reader_that_leaves_before_the_report(self):
        # The reader may also have taken all before it left: then everything is there.
        for line, files in self.COMMANDS:
            done = self.shell(f"{line} | true")
            self.assertIn((done.returncode, self.made()), ((5, []), (0, sorted(files)), (1, sorted(files))), (line, done.stderr))
            for name in self.made():
                os.remove(os.path.join(self.folder, name))
            reading, writing = os.pipe()
            os.close(reading)
            with os.fdopen(writing, "wb") as left:
                done = subprocess.run(["bash", "-c", f'plumb() {{ "{PLUMB}" "$@"; }}\nfaulty() {{ "{FAULTY}" "$@"; }}\n{line}'], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=left,
                                      stderr=subprocess.PIPE, timeout=120, check=False)
            self.assertEqual((done.returncode, self.made()), (5, []), (line, done.stderr))

    def test_a_text_is_cut_in_silence(self):
        for line in ("info " + " ".join(["cube.obj"] * 400), "help --man", "help render", "--version", "devices", "info cube.obj --json"):
            reading, writing = os.pipe()
            os.close(reading)
            with os.fdopen(writing, "wb") as left:
                done = subprocess.run([PLUMB, *line.split()], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=left, stderr=subprocess.PIPE, timeout=120, check=False)
            self.assertEqual((done.returncode, done.stderr), (141, b""), line)
            self.assertEqual(self.shell(f"plumb {line} >/dev/full").returncode, 5)
        done = self.shell("plumb info " + " ".join(["cube.obj"] * 400) + " | head -1")
        self.assertIn(done.returncode, (0, 141))
        self.assertEqual(done.stderr, b"")

    def test_a_picture_on_it_is_never_cut_in_silence(self):
        reading, writing = os.pipe()
        os.close(reading)
        with os.fdopen(writing, "wb") as left:
            done = subprocess.run([PLUMB, "render", "cube.obj", *SMALL.split(), "-o", "-"], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=left, stderr=subprocess.PIPE, timeout=120, check=False)
        self.assertEqual(done.returncode, 5)
        self.assertIn(b"Broken pipe", done.stderr)


class Files(Streams):
    def test_extensions_count_in_any_case(self):
        shutil.copy(os.path.join(self.folder, "cube.obj"), os.path.join(self.folder, "CUBE.OBJ"))
        for upper, lower in (("A.PNG", "a.png"), ("B.Npy", "b.npy"), ("C.EXR", "c.exr")):
            for name in (upper, lower):
                done = self.shell(f"plumb render CUBE.OBJ {SMALL} -o {name}")
                self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.read(upper), self.read(lower))
        self.assertEqual(self.shell("plumb diff A.PNG a.png -o D.PNG --heat E.PNG").returncode, 0)
        self.assertEqual(self.shell(f"plumb measure cube.obj {SMALL} --axis encoding --repetitions 1 -o R.HTML").returncode, 0)

    def test_an_unwritable_name_is_told_before_a_mesh_is_read(self):
        # The mesh is not there: who read it first would say so.
        for flags, code in (("-o x.jpg", 2), ("-o x", 2), ("-o .", 2), ("-o no/such/x.png", 5), ("-o 'x{n}.jpg' --turntable 3", 2)):
            done = self.shell(f"plumb render missing.obj {SMALL} {flags}")
            self.assertEqual(done.returncode, code, (flags, done.stderr))
            self.assertNotIn(b"missing.obj", done.stderr)

    def test_few_descriptors_are_enough(self):
        done = self.shell(f"ulimit -n 12; plumb render cube.obj {SMALL} --turntable 40 --aov depth,normal,linear -o 'a{{n}}{{aov}}.npy'")
        self.assertEqual((done.returncode, len(self.made())), (0, 120), done.stderr)

    def test_what_a_killed_process_left_is_no_obstacle(self):
        for i in range(100):
            with open(os.path.join(self.folder, f".plumb-1-{i}.part"), "wb"):
                pass
        self.assertEqual(self.shell(f"plumb render cube.obj {SMALL} -o a.png").returncode, 0)
        self.assertEqual(len(self.made()), 101)


class Pipes(Streams):
    """Models that come through pipes, and files whose names tell no format."""

    def setUp(self):
        super().setUp()
        corners = [tuple(map(float, line.split()[1:])) for line in CUBE.split("\n") if line.startswith("v ")]
        faces = [[int(i) - 1 for i in line.split()[1:]] for line in CUBE.split("\n") if line.startswith("f ")]
        triangles = [(f[0], f[k], f[k + 1]) for f in faces for k in (1, 2)]
        facets = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for i in t for x in corners[i]), 0) for t in triangles)
        ascii_facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % corners[i] for i in t) + "endloop\nendfacet\n" for t in triangles)
        positions = b"".join(struct.pack("<3f", *c) for c in corners)
        indices = b"".join(struct.pack("<3H", *t) for t in triangles)
        gltf = {"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(positions + indices)}],
                "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]},
                              {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]}
        text = json.dumps(gltf).encode()
        text += b" " * (-len(text) % 4)
        binary = positions + indices
        gltf["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
        self.models = {
            "obj": CUBE.encode(), "stl": b"\0" * 80 + struct.pack("<I", 12) + facets, "stl ascii": ("solid cube\n" + ascii_facets + "endsolid cube\n").encode(),
            "off": ("OFF\n8 6 0\n" + "".join("%g %g %g\n" % c for c in corners) + "".join("4 %d %d %d %d\n" % tuple(f) for f in faces)).encode(),
            "ply": ("ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
                    + "".join("%g %g %g\n" % c for c in corners) + "".join("4 %d %d %d %d\n" % tuple(f) for f in faces)).encode(),
            "glb": b"glTF" + struct.pack("<II", 2, 12 + 8 + len(text) + 8 + len(binary)) + struct.pack("<I", len(text)) + b"JSON" + text + struct.pack("<I", len(binary)) + b"BIN\0" + binary,
            "gltf": json.dumps(gltf).encode(), "toml": b"[[mesh]]\nname = \"m\"\nfile = \"cube.obj\"\n\n[[light]]\ntype = \"directional\"\ndirection = [1, 2, 3]\n"}
        for name, data in self.models.items():
            with open(os.path.join(self.folder, name.replace(" ", "_")), "wb") as f:
                f.write(data)

    def pixels(self, line):
        done = self.shell(line)
        self.assertEqual(done.returncode, 0, (line, done.stderr))
        return self.read("a.npy")

    def test_every_format_by_every_way(self):
        for name in self.models:
            file, extension = name.replace(" ", "_"), name.split()[0]
            shutil.copy(os.path.join(self.folder, file), os.path.join(self.folder, "named." + extension))
            want = self.pixels(f"plumb render named.{extension} {SMALL} -o a.npy")
            for model in (f"- --format {extension} < {file}", f"- < {file}", f"- --format {extension} < <(cat {file})", f"<(cat {file})", f"/dev/stdin < {file}", f"/dev/stdin < <(cat {file})", f"{file}",
                          f"{file} --format {extension}"):
                self.assertEqual(self.pixels(f"plumb render {model} {SMALL} -o a.npy"), want, (name, model))
            self.assertEqual(self.pixels(f"cat {file} | plumb render - {SMALL} -o a.npy"), want, name)

    def test_reports_name_and_hash_what_came(self):
        done = self.shell("cat stl | plumb info - --json")
        scene = json.loads(done.stdout)["scene"]
        self.assertEqual((scene["path"], scene["sha256"], scene["triangles"]), ("-", hashlib.sha256(self.models["stl"]).hexdigest(), 12))
        done = self.shell("plumb verify - --size 64x48 < obj")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.shell(f"plumb render - cube.obj {SMALL} -o a.png < stl").returncode, 0, "two meshes, one of them through a pipe")

    def test_refusals(self):
        for line, code, says in ((f"printf nonsense | plumb render - {SMALL} -o a.png", 3, b"-: it has no name and the first bytes tell no format; --format names it: obj, ply, stl, off, gltf, toml"),
                                 (f"plumb render - {SMALL} -o a.png </dev/null", 3, b"empty"), (f"plumb render - {SMALL} -o a.png <&-", 3, b"empty"),
                                 (f"plumb render - - {SMALL} -o a.png < obj", 2, b"read only once"), (f"plumb render - --format xyz {SMALL} -o a.png < obj", 2, b"--format"),
                                 (f"printf 'v 0 0 0\nf 1 2 3\n' | plumb render - {SMALL} -o a.png", 3, b"-:2:5: face corner"), (f"plumb render . {SMALL} -o a.png", 3, b".: is a folder"),
                                 (f"plumb render obj --format stl {SMALL} -o a.png", 3, b"obj: byte")):
            done = self.shell(line)
            self.assertEqual(done.returncode, code, (line, done.stderr))
            self.assertIn(says, done.stderr)
            self.assertEqual(done.stderr.count(b"\n"), 1, done.stderr)
            self.assertNotIn("a.png", self.made())

    def test_a_part_beyond_the_range_is_named_by_its_place(self):
        # Accepted by the reader and refused when it is drawn: the line still begins with the place in the file.
        camera = "[camera]\neye = [0, 0, 5]\nat = [0, 0, 0]\nnear = 1e-20\n"
        mesh = "[[mesh]]\nname = \"m\"\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]\n"
        lamp = "[[light]]\ntype = \"point\"\nposition = [0, 0, 1e20]\n"
        ball = "[[sphere]]\ncentre = [0, 0, 0]\nradius = 1\n"
        floor = "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n"
        for name, text, flags, place in (("mesh", camera + mesh, "", "8:9: object 'm': it reaches further"), ("object", camera + mesh + "[[object]]\nmesh = \"m\"\n", "", "9:1: object 'm': it reaches further"),
                                         ("rays", camera + mesh + "[[object]]\nname = \"o\"\nmesh = \"m\"\n", "--shading ray", "9:1: object 'o': it reaches further"),
                                         ("light", camera.replace("near = 1e-20", "near = 1") + mesh + lamp, "", "9:1: light: a point light is further"),
                                         ("area", camera.replace("near = 1e-20", "near = 1") + mesh + lamp.replace("point", "area") + "edge_u = [1, 0, 0]\npoints = 3\n", "", "9:1: light: a point light is further"),
                                         ("sphere", camera + ball, "", "5:1: sphere: it reaches further"), ("plane", camera + floor.replace("[0, 0, 0]", "[0, 9, 0]"), "", "5:1: plane: its point is further"),
                                         ("zbuffer", "z_buffer = false\n" + mesh, "", "1:12: z_buffer"), ("shapes", ball + mesh, "--shading phong", "1:1: it has spheres or planes")):
            with open(os.path.join(self.folder, "far.toml"), "w", encoding="utf-8") as f:
                f.write(text)
            done = self.shell(f"plumb render far.toml {SMALL} -o a.png {flags}")
            self.assertEqual(done.returncode, 3, (name, done.stderr))
            self.assertTrue(done.stderr.startswith(f"plumb: far.toml:{place}".encode()), (name, done.stderr))
            self.assertNotIn("a.png", self.made())


class Loading(Streams):
    """A mesh that takes a while: what is shown, and that an interrupt is heard."""

    def setUp(self):
        super().setUp()
        # 1.2 million triangles of a binary PLY: long enough to be shown, short enough for a test.
        side = 775
        with open(os.path.join(self.folder, "large.ply"), "wb") as f:
            f.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {(side + 1) ** 2}\nproperty float x\nproperty float y\nproperty float z\n"
                    f"element face {2 * side * side}\nproperty list uchar int vertex_indices\nend_header\n".encode())
            f.write(b"".join(struct.pack("<3f", x, y, x * y % 7) for y in range(side + 1) for x in range(side + 1)))
            for y in range(side):
                row = bytearray()
                for x in range(side):
                    a = y * (side + 1) + x
                    row += struct.pack("<B3iB3i", 3, a, a + 1, a + side + 2, 3, a, a + side + 2, a + side + 1)
                f.write(row)

    def test_it_is_shown_by_stages(self):
        done = self.shell(f"plumb render large.ply {SMALL} -o a.png --progress json")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [json.loads(row) for row in done.stderr.decode().split("\n") if row.startswith('{"progress"')]
        load = [row for row in rows if row["task"].startswith("load ")]
        self.assertTrue({"load finish"} <= {row["task"] for row in load} <= {"load read", "load parse", "load finish"}, rows)
        self.assertEqual([row["progress"] for row in load], sorted(row["progress"] for row in load))
        self.assertTrue(rows[0]["task"].startswith("load") and not rows[-1]["task"].startswith("load"))
        # A small file shows nothing of it.
        self.assertNotIn(b"load", self.shell(f"plumb render cube.obj {SMALL} -o a.png --progress json").stderr)

    def test_an_interrupt_ends_it(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            with subprocess.Popen([PLUMB, "render", "large.ply", *SMALL.split(), "-o", "a.png", "--progress", "json"], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE) as process:
                first = process.stderr.readline()
                self.assertIn(b"load", first)
                process.send_signal(number)
                _, rest = process.communicate(timeout=60)
            self.assertEqual(process.returncode, code, rest)
            self.assertNotIn(b"render", rest, "it ended in the load")
            self.assertEqual(self.made(), ["large.ply"])


class Progress(Streams):
    """The share of the whole list, never falling, with the time since its first picture."""

    def shares(self, line):
        done = self.shell(line + " --progress json")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [json.loads(row) for row in done.stderr.decode().split("\n") if row.startswith('{"progress"')]
        self.assertTrue(all({"progress", "task", "elapsed_s", "left_s"} == set(row) for row in rows))
        rows = [row for row in rows if not row["task"].startswith("load")]
        self.assertEqual([row["progress"] for row in rows], sorted(row["progress"] for row in rows))
        self.assertEqual([row["elapsed_s"] for row in rows], sorted(row["elapsed_s"] for row in rows))
        self.assertLess(rows[0]["progress"], 0.05)  # the first scene of `verify` has been loaded
        self.assertEqual(rows[-1]["progress"], 1)
        return rows

    def test_a_list_is_one_whole(self):
        # As many samples as take longer than the tenth of a second in which one line is written.
        work = "--device twin --size 640x480 --samples 16"
        for flags, count in (("--turntable 12 -o 'a{n}.png'", 12), ("--view front --view iso --view top -o sheet.png", 3), ("--turntable 2 --with-error -o 'a{n}.png'", 2),
                             ("--turntable 3 --stereo pair -o 'a{n}{eye}.png'", 3), ("--turntable 3 --stereo anaglyph -o 'a{n}.png'", 3)):
            rows = self.shares(f"plumb render cube.obj {work} {flags}")
            self.assertEqual(rows[-1]["task"].split()[-1], f"{count}/{count}")
            for row in rows:  # each is within its picture's part
                i = int(row["task"].split()[-1].split("/")[0])
                self.assertTrue((i - 1) / count - 1e-3 <= row["progress"] <= i / count + 1e-3, (flags, row))
            self.assertTrue(any(0 < row["progress"] < 1 for row in rows), (flags, rows))
        self.shares("plumb verify cube.obj cube.obj cube.obj --size 640x480 --view front --view iso")
        self.shares(f"plumb measure cube.obj {SMALL} --axis shading --repetitions 3")

    def test_lines_to_read_have_the_tenths_of_the_whole(self):
        done = self.shell(f"plumb render cube.obj {SMALL} --turntable 20 -o 'a{{n}}.png' --progress plain")
        rows = [line for line in done.stderr.decode().split("\n") if " %" in line and line.startswith("render ")]
        self.assertEqual([int(line.split(": ")[1].split()[0]) for line in rows], list(range(0, 101, 10)), rows)
        self.assertTrue(all("elapsed" in line for line in rows[1:]), rows)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
