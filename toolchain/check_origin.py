#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A mesh keeps its numbers from an origin of its own, so the matrix from them to the world is worldFromMesh. Fails where the product takes the object's own
matrix, worldFromObject, in a file that is not known to mean the file's numbers or the user's own chain.

usage: check_origin.py [ROOT]      exit 0: clean; 1: one line for each fault on stdout
       check_origin.py --self-test exit 1 when a planted use goes unnoticed
"""
import os
import sys
import tempfile

NAME = "worldFromObject"
# file or folder below pipeline/ -> why it may
ALLOWED = {
    "scene/scene.h": "defines both",
    "scene/toml_objects.cpp": "sets it",
    "scene/gltf_nodes.cpp": "sets it",
    "scene/mesh_arrays.h": "takes it from the caller",
    "scene/mesh_arrays.cpp": "sets it",
    "scene/check_scene.cpp": "judges its entries",
    "scene/flattened.h": "asks for its linear part",
    "scene/flattened.cpp": "asks for its linear part",
    "render/render.h": "takes it from the caller",
    "render/resident_scene.cpp": "sets it",
    "command/info_command.cpp": "bounds as the file states them",
    "command/matrix_command.cpp": "shows the user's chain",
    "render/bounds/vertex_error.cpp": "bounds the rounding of the composite by its parts",
    "render/bounds/vertex_arithmetic.cpp": "compares matrices of objects whose edges may be common",
    "pixel/notes_chain.h": "starts from the file's numbers: the vertex as stated is its kept numbers and the mesh's origin",
    "pixel/raster.cpp": "asks for its linear part",
    "pixel/ray_chain.h": "starts from the file's numbers: the vertex as stated is its kept numbers and the mesh's origin",
    "stress/axes.cpp": "sets it: what offsets the vertices brings the object back",
    "stress/move.cpp": "sets it; boxes are as the file states them",
    "suite/scenes.h": "sets it",
    "truth": "starts from the file's numbers, and shares no function with the passes",
}


def faults_of(root):
    for at, _, names in sorted(os.walk(os.path.join(root, "pipeline"))):
        for name in sorted(names):
            path = os.path.join(at, name)
            short = os.path.relpath(path, os.path.join(root, "pipeline"))
            if not name.endswith((".h", ".hpp", ".cpp")) or any(short == a or short.startswith(a + "/") for a in ALLOWED):
                continue
            with open(path, encoding="utf-8") as file:
                for number, line in enumerate(file, 1):
                    if NAME in line:
                        yield f"pipeline/{short}:{number}: {NAME} is of the file's numbers; of what a mesh keeps it is worldFromMesh"


def self_test():
    with tempfile.TemporaryDirectory() as root:
        for path, text in (("scene/scene.h", f"glm::dmat4 {NAME};\n"), ("truth/a.cpp", f"o.{NAME}\n"), ("render/b.cpp", "worldFromMesh(s, o)\n")):
            os.makedirs(os.path.dirname(f"{root}/pipeline/{path}"), exist_ok=True)
            with open(f"{root}/pipeline/{path}", "w", encoding="utf-8") as file:
                file.write(text)
        clean = list(faults_of(root))
        with open(f"{root}/pipeline/render/b.cpp", "a", encoding="utf-8") as file:
            file.write(f"object.{NAME} * p\n")
        found = list(faults_of(root))
    if clean or len(found) != 1 or "render/b.cpp:2" not in found[0]:
        print(f"clean tree: {clean}; planted use: {found}")
        return 1
    return 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    found = list(faults_of(sys.argv[1] if len(sys.argv) > 1 else "."))
    print("\n".join(found) or "check_origin: clean")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
