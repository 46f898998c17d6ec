#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""From exec to a written PNG: Suzanne at 640x480, a new process each time, with an empty shader cache (cold) and with a filled one (warm), by part; beside
a program that only creates the device, and beside f3d, POV-Ray and Blender where they are installed.

Wall time and peak memory are of the whole process group as wait4() has them. Goals: warm at most 3 times the empty program and 110 MiB; at most a third
of the fastest of the others.

usage: bench_start.py PLUMB EMPTY OUT.json [--repeat N] [--small]     --small: three runs, no other programs
"""
import json
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
SCENE = os.path.join(ROOT, "scenes", "suzanne.toml")
MESH = os.path.join(ROOT, "scenes", "suzanne", "suzanne.obj")
SIZE = (640, 480)
EYE, FOV = (1.3, 0.7, 4.2), 33.0        # as scenes/suzanne.toml
LIGHTS = [((1.5, 1.6, 1), (1, 0.93, 0.82)), ((-2, 0.1, 1), (0.1, 0.14, 0.22)), ((-1, 1.2, -1.5), (0.4, 0.4, 0.4))]


def once(command, environment, folder):
    start = time.perf_counter()
    process = subprocess.Popen(command, env=environment, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
    out = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"bench_start.py: {' '.join(command)}: exit {process.returncode}")
    return time.perf_counter() - start, usage.ru_maxrss * 1024, out


def spread(values):
    ordered = sorted(values)
    at = lambda q: ordered[min(len(ordered) - 1, int(q * len(ordered)))]
    return {"median": statistics.median(ordered), "p10": at(0.1), "p90": at(0.9), "least": ordered[0], "count": len(ordered)}


def row(name, settings, runs, picture=None):
    if picture and not os.path.getsize(picture) > 1000:
        sys.exit(f"bench_start.py: {name} left no picture")
    return {"name": name, "settings": settings, "seconds": spread([r[0] for r in runs]), "peak_bytes": max(r[1] for r in runs)}


def obj():
    points, normals, faces = [], [], []
    with open(MESH, encoding="utf-8") as f:
        for line in f:
            words = line.split()
            if not words:
                continue
            if words[0] in ("v", "vn"):
                (points if words[0] == "v" else normals).append(tuple(map(float, words[1:4])))
            elif words[0] == "f":
                corners = [tuple(int(i) if i else 0 for i in w.split("/")) for w in words[1:]]
                faces += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return points, normals, faces


def pov_scene(path):
    """The mesh with its normals, the same camera, lights and material. POV-Ray's z points away: z is turned."""
    points, normals, faces = obj()
    vector = lambda v: f"<{v[0]},{v[1]},{-v[2]}>"
    with open(path, "w", encoding="utf-8") as f:
        f.write('#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 1 }\nbackground { rgb <0.0144,0.0176,0.0232> }\n')
        f.write(f"camera {{ perspective location {vector(EYE)} up y right {SIZE[0] / SIZE[1]}*x look_at 0 "
                f"angle {2 * math.degrees(math.atan(math.tan(math.radians(FOV / 2)) * SIZE[0] / SIZE[1]))} }}\n")
        for direction, colour in LIGHTS:
            f.write(f"light_source {{ {vector(tuple(100 * d for d in direction))} rgb <{colour[0]},{colour[1]},{colour[2]}> parallel point_at 0 shadowless }}\n")
        f.write("mesh {\n")
        for face in faces:
            corners = [(points[c[0] - 1], normals[c[2] - 1] if len(c) > 2 and c[2] else None) for c in face]
            if all(n for _, n in corners):
                f.write("smooth_triangle {" + ",".join(f"{vector(p)},{vector(n)}" for p, n in corners) + "}\n")
            else:
                f.write("triangle {" + ",".join(vector(p) for p, _ in corners) + "}\n")
        f.write("texture { pigment { rgb <0.5,0.26,0.16> } finish { ambient 0.1 diffuse 1 phong 0.3 phong_size 50 } } }\n")


BLENDER = """
import bpy, math, mathutils, sys
mesh, out = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=mesh)
scene = bpy.context.scene
camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
camera.data.sensor_fit, camera.data.angle = 'VERTICAL', math.radians(33)
camera.location = (1.3, -4.2, 0.7)
camera.rotation_euler = (-mathutils.Vector(camera.location)).to_track_quat('-Z', 'Y').to_euler()
scene.collection.objects.link(camera)
scene.camera = camera
for direction, strength in (((1.5, -1, 1.6), 3.0), ((-2, -1, 0.1), 0.5), ((-1, 1.5, 1.2), 1.2)):
    lamp = bpy.data.objects.new('lamp', bpy.data.lights.new('lamp', 'SUN'))
    lamp.data.energy = strength
    lamp.rotation_euler = mathutils.Vector(direction).to_track_quat('Z', 'Y').to_euler()
    scene.collection.objects.link(lamp)
scene.render.engine = 'CYCLES'
scene.cycles.device, scene.cycles.samples, scene.cycles.max_bounces = 'CPU', 1, 0
scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = 640, 480
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
"""


def peers(folder, environment, repeat):
    rows, absent = [], []
    png = os.path.join(folder, "other.png")

    def add(name, program, settings, command):
        needs = [program] + (["xvfb-run"] if command[0] == "xvfb-run" else [])
        missing = [n for n in needs if not shutil.which(n)]
        if missing:
            absent.append(f"{name}: {' and '.join(missing)} not installed")
            return
        once(command, environment, folder)   # fills its own caches
        runs = []
        for _ in range(repeat):
            if os.path.exists(png):
                os.remove(png)
            runs.append(once(command, environment, folder))
        rows.append(row(name, settings, runs, png))

    add("f3d", "f3d", "xvfb-run, software OpenGL, no options but size, output and camera",
        ["xvfb-run", "-a", "f3d", MESH, f"--output={png}", "--resolution=%d,%d" % SIZE, "--camera-position=%g,%g,%g" % EYE, "--camera-focal-point=0,0,0",
         "--camera-view-angle=%g" % FOV])
    pov = os.path.join(folder, "suzanne.pov")
    pov_scene(pov)
    add("POV-Ray", "povray", "no antialiasing, quality 9, three parallel lights without shadows, Phong",
        ["povray", f"+I{pov}", f"+O{png}", "+W%d" % SIZE[0], "+H%d" % SIZE[1], "-D", "-A", "+FN8", "+Q9", "-GA"])
    script = os.path.join(folder, "suzanne.py")
    with open(script, "w", encoding="utf-8") as f:
        f.write(BLENDER)
    add("Blender", "blender", "Cycles on the CPU, 1 sample, no bounces, no denoising, three suns", ["blender", "-b", "--python-exit-code", "1", "-P", script, "--", MESH, png])
    return rows, absent


def main():
    words = sys.argv[1:]
    repeat = 15
    if "--repeat" in words:
        at = words.index("--repeat")
        repeat = int(words[at + 1])
        del words[at:at + 2]
    small = "--small" in words
    words = [w for w in words if w != "--small"]
    if len(words) != 3:
        sys.exit(__doc__.strip())
    if small:
        repeat = 3
    plumb, empty, out = (os.path.abspath(w) for w in words)
    with tempfile.TemporaryDirectory() as folder:
        cache = os.path.join(folder, "cache")
        environment = dict(os.environ, MESA_SHADER_CACHE_DIR=cache, XDG_CACHE_HOME=cache)
        png = os.path.join(folder, "suzanne.png")
        command = [plumb, "render", SCENE, "--size", "%dx%d" % SIZE, "-o", png, "--quiet", "--json"]
        cold, warm, parts, bare = [], [], {"cold": [], "warm": []}, []
        for i in range(max(3, repeat // 3)):
            shutil.rmtree(cache, ignore_errors=True)
            cold.append(once(command, environment, folder))
        for i in range(repeat + 1):          # the first fills the cache
            bare.append(once([empty], environment, folder))
            warm.append(once(command, environment, folder))
        for name, runs in (("cold", cold), ("warm", warm[1:])):
            reports = [json.loads(r[2]) for r in runs]
            keys = [k for k, v in reports[0]["time_ms"].items() if isinstance(v, (int, float))]
            parts[name] = {k: statistics.median(r["time_ms"][k] for r in reports) for k in keys}
        report = json.loads(warm[-1][2])
        rows = [row("empty", "creates the device and ends", bare[1:]), row("plumb cold", "no shader cache", cold, png), row("plumb warm", "shader cache filled", warm[1:], png)]
        others, absent = ([], ["others: not run"]) if small else peers(folder, environment, max(3, repeat // 3))
        with open(out + ".part", "w", encoding="utf-8") as f:
            json.dump({"bench": "start", **{k: report[k] for k in ("tool", "host", "device") if k in report}, "parts_ms": parts, "rows": rows + others, "absent": absent}, f, indent=1)
        os.replace(out + ".part", out)


if __name__ == "__main__":
    main()
