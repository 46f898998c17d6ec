#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the seeds of the fuzz targets: small files that use what each reader knows. usage: make_corpus.py (writes beside itself)"""
import base64
import json
import os
import struct

HERE = os.path.dirname(os.path.abspath(__file__))
POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def write(path, data):
    if not path.startswith("none/"):
        write("none/" + path.replace("/", "-"), data)  # the same bytes in a file whose name tells no format
    path = os.path.join(HERE, "corpus", path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as f:
        f.write(data.encode() if isinstance(data, str) else data)


def obj():
    lines = ["# tetrahedron", "mtllib second.obj", "o body"] + ["v %g %g %g" % p for p in POINTS] + ["vn 0 0 1", "vt 0 0", "usemtl red", "s 1"]
    lines += ["f %d %d %d" % tuple(i + 1 for i in f) for f in FACES[:2]] + ["g other", "f 1/1/1 4/1/1 3/1/1", "f -3//1 -2//1 \\", " -1//1", "l 1 2 3", "p 1"]
    material = "newmtl red\nKa 0.1 0 0\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nNs 32\nNi 1.5\nd 0.9\nTr 0.1\nKe 0 0 0\nillum 2\nmap_Kd x.png\n"
    return "\n".join(lines) + "\n%%second file%%\n" + material


def ply(kind):
    head = (f"ply\nformat {kind} 1.0\ncomment seed\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\n"
            "element face 4\nproperty list uchar int vertex_indices\nend_header\n")
    if kind == "ascii":
        return head + "".join("%g %g %g 7\n" % p for p in POINTS) + "".join("3 %d %d %d\n" % f for f in FACES)
    order = "<" if kind == "binary_little_endian" else ">"
    body = b"".join(struct.pack(order + "ffdB", *p, 7) for p in POINTS) + b"".join(struct.pack(order + "B3i", 3, *f) for f in FACES)
    return head.encode() + body


def stl_ascii():
    text = "solid seed\n"
    for face in FACES:
        text += " facet normal 0 0 1\n  outer loop\n" + "".join("   vertex %g %g %g\n" % POINTS[i] for i in face) + "  endloop\n endfacet\n"
    return text + "endsolid seed\n"


def stl_binary():
    body = b"".join(struct.pack("<3f", 0, 0, 1) + b"".join(struct.pack("<3f", *POINTS[i]) for i in face) + b"\0\0" for face in FACES)
    return b"seed".ljust(80, b"\0") + struct.pack("<I", len(FACES)) + body


def gltf(uri):
    points = b"".join(struct.pack("<3f", *p) for p in POINTS)
    indices = b"".join(struct.pack("<3H", *f) for f in FACES)
    data = points + indices
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [{"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 2, 1], "children": [1]}, {"camera": 0, "translation": [0, 0, 4]},
                  {"extensions": {"KHR_lights_punctual": {"light": 0}}, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 3, 4, 1]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "zfar": 100}}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 30, "color": [1, 1, 0.5]}]}},
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.2, 1], "roughnessFactor": 0.4, "metallicFactor": 0.1}, "doubleSided": True}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0, "mode": 4}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}, {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(data)}]}
    if uri:
        tree["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        return json.dumps(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def posed():
    """A glTF with a skin, a morph target, instances and a sparse accessor without a view."""
    points = b"".join(struct.pack("<3f", *p) for p in POINTS)
    parts = [points, b"".join(struct.pack("<3H", *f) for f in FACES), bytes([0, 1, 0, 0] * 4), struct.pack("<16f", *([0.5, 0.5, 0, 0] * 4)),
             struct.pack("<32f", *([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] * 2)), struct.pack("<2H", 1, 3), points[12:36]]
    shapes = [(5126, 4, "VEC3"), (5123, 12, "SCALAR"), (5121, 4, "VEC4"), (5126, 4, "VEC4"), (5126, 2, "MAT4")]
    tree = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 3]}],
        "nodes": [{"mesh": 0, "skin": 0, "weights": [0.5]}, {"children": [2]}, {"translation": [0, 2, 0]},
                  {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 4}],
        "materials": [{"emissiveFactor": [1, 1, 2.5], "emissiveTexture": {"index": 0},
                       "extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0.25, 0, 1], "glossinessFactor": 0.2}}}],
        "meshes": [{"weights": [1], "primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3}, "indices": 1, "material": 0,
                                                    "targets": [{"POSITION": 5}]}]}],
        "accessors": [{"bufferView": i, "componentType": t, "count": n, "type": shape} for i, (t, n, shape) in enumerate(shapes)],
        "bufferViews": [{"buffer": 0, "byteOffset": sum(map(len, parts[:i])), "byteLength": len(part)} for i, part in enumerate(parts)],
        "buffers": [{"byteLength": len(b"".join(parts)), "uri": "data:;base64," + base64.b64encode(b"".join(parts)).decode()}]}
    tree["accessors"].append({"componentType": 5126, "count": 4, "type": "VEC3",
                              "sparse": {"count": 2, "indices": {"bufferView": 5, "componentType": 5123}, "values": {"bufferView": 6}}})
    return json.dumps(tree)


# Seeds with what readers pass over.
LOOSE_OBJ = "\ufeffmtllib sub\\Second.OBJ\nv 0 0 0\nv 1 0 0\nv 0 1 0 nan\nv nan 0 0\nvn nan 0 0\nvt x\nf 1//1 2/7/ 3//\nf 1 2\nusemtl red\nf 1/1/9 2 3\n"
LOOSE_STL = "facet 0 0 1\nouterloop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nend loop\nend facet\nsolid a\nsolid a\n# b\nfacet normal nan 0 0 outer loop vertex 0 0 0 endloop endfacet\n"
LOOSE_OFF = "OFF4 3 x\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\nnan 0 1 1 1 1\n3 0 1 2\n2 0 1\n3 0 2 1 red\nmore\n"
LOOSE_PLY = ("ply\nformat ascii 1.0\nmade by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty int64 id\n"
             "element tristrips 1\nproperty list int int vertex_indices\nelement face 1\nproperty list uchar uint64 vertex_index\nend_header\n"
             "0 0 0 1.5\n1 0 0 x\ncomment c\n0 1 0 3 9 9\n1 1 nan 4\n8 0 1 2 -1 2 1 1 0\n2 0 1\nmore\n")


def toml():
    return '''ambient = 0.3
background = "#202830"

[camera]
eye = [3, 2, 4]
at = [0, 0, 0]
up = [0, 1, 0]
fov = 40

[[material]]
name = "red"
diffuse = [0.8, 0.1, 0.1]
specular = 0.4
shininess = 32

[[light]]
type = "directional"
direction = [1, 2, 3]
intensity = 0.8

[[light]]
type = "point"
position = [2, 3, 1]
attenuation = "1/d"

[[mesh]]
name = "body"
file = "second.obj"
material = "red"

[[mesh]]
name = "quad"
vertices = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]
faces = [[0, 1, 2, 3]]

[[object]]
mesh = "body"
transform = [{ scale = [1, 2, 0.5] }, { rotate_y = 45, about = [0, 0, 1] }, { rotate = { axis = [1, 1, 0], degrees = 30 } }]

[[object.child]]
mesh = "quad"
transform = [{ translate = [0.5, 0, 0] }]
%%second file%%
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
'''


write("obj/tetrahedron", obj())
for kind in ("ascii", "binary_little_endian", "binary_big_endian"):
    write(f"ply/{kind}", ply(kind))
write("stl/ascii", stl_ascii())
write("stl/binary", stl_binary())
write("off/tetrahedron", "OFF\n# seed\n4 4 6\n" + "".join("%g %g %g\n" % p for p in POINTS) + "".join("3 %d %d %d 255 0 0\n" % f for f in FACES))
write("gltf/tetrahedron", gltf(True))
write("glb/tetrahedron", gltf(False))
write("toml/scene", toml())
write("gltf/posed", posed())
for name, seed in (("obj", LOOSE_OBJ), ("stl", LOOSE_STL), ("off", LOOSE_OFF), ("ply", LOOSE_PLY)):
    write(f"{name}/loose", seed)
