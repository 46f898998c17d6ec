#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The worked examples of the lecture notes, read from the JSON of commands: `plumb matrix` (sections 5 to 11), `plumb info` (7.4), `plumb pixel` (11.10, 12, 14.2, 16, 18), `plumb render` (18.1). It knows
their flags and the keys of docs/outputs.md, and nothing else of the product. An entry counts as read when every check of it is; entries of other kinds have no command yet.

usage: worked_examples_test.py PLUMB EXAMPLES.json [LEAST]      exit 1 when a number differs, or fewer than LEAST entries are read
"""
import json
import math
import os
import re
import subprocess
import sys
import tempfile

PLUMB, EXAMPLES = sys.argv[1], sys.argv[2]
LEAST = int(sys.argv[3]) if len(sys.argv) > 3 else 1
BINARY64, FLOAT32 = 1e-12, 4e-6  # conventions.implementation_tolerance, relative to max(1, |expected|)

with open(EXAMPLES, encoding="utf-8") as file:
    ENTRIES = json.load(file)["examples"]
FOLDER = tempfile.TemporaryDirectory()
faults = []


def plumb(*words):
    side = ["--device", "twin"] if words[0] in ("pixel", "render") else []  # no device is asked, and opening one takes longer than the rest
    made = subprocess.run([PLUMB, *words, *side, "--json"], capture_output=True, text=True)
    if made.returncode != 0:
        raise RuntimeError(f"plumb {' '.join(words)}: exit {made.returncode}: {made.stderr.strip()}")
    return json.loads(made.stdout)


def words_of(numbers):
    return ",".join(repr(float(n)) for n in numbers)


def matrix(steps, points=(), flat=False, vertices=0):
    words = ["matrix", *steps, "--notation", "row"]
    if flat:
        words += ["--dimensions", "2"]
    for p in points:
        words += ["--point", words_of(p)]
    return plumb(*words, *(["--vertices", str(vertices)] if vertices else []))


def after(report, step=-1):
    return report["steps"][step]["points"]


def scene(text):
    path = os.path.join(FOLDER.name, "entry.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def lines_of(report):
    return {line["name"]: line for line in report["pixels"][0]["chains"][0]["lines"]}


def polygon(vertices, distance, size=(400, 400)):
    """Lines of a polygon before the notes' viewer."""
    return lines_of(plumb("pixel", scene(f'handedness = "left"\nsize = [{size[0]}, {size[1]}]\n[camera]\ndistance = {distance}\n[[mesh]]\nname = "m"\nvertices = {vertices}\n'
                                         'faces = [[0, 1, 2]]\n[[object]]\nmesh = "m"\n'), "--polygon", "0"))


def truth(lines, name):
    value = lines[name]["truth"]
    return value[0] if len(value) == 1 else value


def across(n):
    """Two vectors P, Q with P x Q along n."""
    a = [1, 0, 0] if abs(n[0]) < 0.9 * math.hypot(*n) else [0, 1, 0]
    p = [a[1] * n[2] - a[2] * n[1], a[2] * n[0] - a[0] * n[2], a[0] * n[1] - a[1] * n[0]]
    q = [n[1] * p[2] - n[2] * p[1], n[2] * p[0] - n[0] * p[2], n[0] * p[1] - n[1] * p[0]]
    return p, q


def lit(normal, light, view=None, ia=0.0, ip=0.0, kd=0.0, ks=0.0, index=1.0, point=None, attenuation="none"):
    """Lines of the point at the origin of a plane with this normal, seen from `view`, a picture of one pixel."""
    p, q = across(normal)
    corners = [[0.0 - 3 * p[i] - 2 * q[i] for i in range(3)], [3 * p[i] - 2 * q[i] for i in range(3)], [4 * q[i] for i in range(3)]]
    view = view or normal
    up = [1, 0, 0] if abs(view[0]) < 0.9 * math.hypot(*view) else [0, 1, 0]
    shine = f'type = "point"\nposition = {[float(c) for c in point]}\nattenuation = "{attenuation}"' if point else f'type = "directional"\ndirection = {[float(c) for c in light]}'
    grey = kd if isinstance(kd, list) else [kd] * 3
    ambient = ia if isinstance(ia, list) else [ia] * 3
    text = (f'size = [1, 1]\nencoding = "linear"\nshading = "phong"\ncull = false\nambient = {ambient}\n[camera]\neye = {[10.0 * c for c in view]}\nat = [0, 0, 0]\nup = {up}\nfov = 10\n'
            f'[[material]]\nname = "m"\nambient = {grey}\ndiffuse = {grey}\nspecular = {ks}\nshininess = {index}\n[[light]]\n{shine}\nintensity = {ip}\n'
            f'[[mesh]]\nname = "m"\nmaterial = "m"\nvertices = {corners}\nfaces = [[0, 1, 2]]\n[[object]]\nmesh = "m"\n')
    return lines_of(plumb("pixel", scene(text), "0,0"))


def turned(e, axis):
    i = e["inputs"]
    p = i["point"][:3]
    found = re.match(r"(T|S)=\((.*)\)|phi=(.*)", i.get("parameter", f"phi={i.get('phi_deg')}"))
    step = f"rotate_{axis}={found[3]}" if found[3] else f"{'translate' if found[1] == 'T' else 'scale'}={found[2]}"
    report = matrix([step], [p])
    row = report["composite"]
    column = plumb("matrix", step, "--notation", "column")["composite"]
    image = after(report)[0] + [1]
    return {"row_vector_matrix": row, "column_vector_matrix": column, "point_times_matrix": image, "matrix_times_point": image, "point": image}


def line_rotation(e):
    """The chain of 10.2.2 for the line of the notes."""
    line = next(x for x in ENTRIES if x["id"] == "s1022_line_parameters")["inputs"]
    i = e["inputs"]
    p1, p2 = i.get("P1", line["P1"]), i.get("P2", line["P2"])
    step = f"rotate={i.get('phi_deg', 90)}:from={words_of(p1)}:to={words_of(p2)}"
    return p1, p2, step


def line_step(e):
    p1, p2, step = line_rotation(e)
    number = int(e["section"].split()[-1]) - 1
    report = matrix([step], [p1, p2])
    return {"matrix": report["steps"][number]["matrix"], "points": after(report, number)}


def line_composite(e):
    p1, p2, step = line_rotation(e)
    report = matrix([step], [e["inputs"]["test_point"], p1, p2])
    axis = [b - a for a, b in zip(p1, p2)]
    again = matrix([f"rotate={e['inputs']['phi_deg']}:axis={words_of(axis)}:through={words_of(p1)}"], [e["inputs"]["test_point"]])
    return {"composite": report["composite"], "test_point_after_each_step": [s["points"][0] for s in report["steps"]], "P1_image": after(report)[1], "P2_image": after(report)[2],
            "rodrigues_image_of_test_point": after(again)[0]}


def line_parameters(e):
    p1, p2, step = line_rotation(e)
    report = matrix([step], [p2])
    x, y = report["steps"][1]["matrix"], report["steps"][2]["matrix"]
    return {"a_b_c": after(report, 0)[0], "s": after(report, 1)[0][2], "L": after(report, 2)[0][2], "sin_alpha": x[1][2], "cos_alpha": x[1][1], "sin_beta": y[0][2], "cos_beta": y[0][0]}


def step_counts(e):
    _, _, step = line_rotation(e)
    report = matrix([step], vertices=e["inputs"]["vertices"])
    separate, together = report["run"]["separate"]["applications"], report["run"]["composite"]["applications"]
    return {"point_matrix_products_without": separate, "point_matrix_products_with": together, "improvement": separate / together, "sequential_matrix_products": report["sequential"]["products"],
            "tree_levels": report["tree"]["depth"], "products_per_level": [sum(1 for n in level if n["product"]) for level in report["tree"]["levels"] if any(n["product"] for n in level)],
            "time_steps_with_enough_hardware": report["tree"]["depth"] + 1}


def bounds_of(vertices):
    listed = list(vertices.values()) if isinstance(vertices, dict) else vertices
    report = plumb("info", scene('[[mesh]]\nname = "m"\nvertices = ' + str(listed) + f"\nfaces = {[[k, (k + 1) % len(listed), (k + 2) % len(listed)] for k in range(len(listed))]}\n[[object]]\nmesh = \"m\"\n"))
    b = (report[0] if isinstance(report, list) else report)["bounds"]
    return b["min"], b["max"], [(x + y) / 2 for x, y in zip(b["min"], b["max"])]


def in_place(e):
    i = e["inputs"]
    flat = "points" in i
    points = i["points"] if flat else [i["point"]]
    about = f":about={words_of(i['ref'])}"
    if "phi_deg" in i:
        step = f"rotate={i['phi_deg']}" if flat else f"rotate_{i['axis'].lower()}={i['phi_deg']}"
    else:
        step = f"scale={words_of(i['S']) if isinstance(i['S'], list) else i['S']}"
    report = matrix([step + about], points, flat)
    stages = [s["points"] if flat else s["points"][0] for s in report["steps"]]
    found = {"after_translate": stages[0], "after_rotate": stages[1], "after_scale": stages[1], "final": stages[2]}
    if flat:
        found["bounding_box_centre"] = bounds_of(points)[2][:2]
    return found


def plane_matrices(e):
    i, found = e["inputs"], {}
    for name, step in (("T", f"translate={words_of(i['T'])}"), ("S", f"scale={words_of(i['S'])}"), ("R", f"rotate={i['phi_deg']}")):
        report = matrix([step], [i["point"][:2]], True)
        found[f"{name}_matrix"], found[f"{name}_point"] = report["composite"], after(report)[0] + [1]
    return found


def composite_2d(e):
    i = e["inputs"]
    report = matrix([f"rotate={i['phi_deg']}:about={words_of(i['centre'])}"], [p[:2] for p in i["points"]], True)
    s = report["steps"]
    return {"T_minus": s[0]["matrix"], "R": s[1]["matrix"], "T_plus": s[2]["matrix"], "T_minus*R": s[1]["product"], "composite": report["composite"], "points": [p + [1] for p in after(report)]}


def visibility(e):
    i = e["inputs"]
    lines = polygon([i["P0"], i["P1"], i["P2"]], -i["viewpoint"][2])
    found = {name: truth(lines, line) for name, line in (("P", "P"), ("Q", "Q"), ("N", "N"), ("N_magnitude", "N_length"), ("N_unit", "N_unit"), ("D", "D"), ("result", "NV_minus_D"))}
    found["P_second_table"], found["Q_second_table"] = found["P"], found["Q"]
    if truth(lines, "visible") != float(e["data"]["visible"]):
        faults.append(f"{e['id']}: visible {lines['visible']}")
    return found


def projection(e):
    i = e["inputs"]
    lines = polygon([i["vertex"], [200, 0, 100], [0, 200, 100]], i["d"], (i["W"], i["H"]))
    display = truth(lines, "display0")
    return {"projected": truth(lines, "projected0"), "display_unrounded": display, "display_rounded": [round(display[0]), round(display[1]), display[2]]}


def cross_product(e):
    p, q = e["inputs"]["P"], e["inputs"]["Q"]
    lines = polygon([[0, 0, 100], [p[0], p[1], p[2] + 100], [q[0], q[1], q[2] + 100]], 500)
    return {"cross": truth(lines, "N"), "magnitude": truth(lines, "N_length"), "unit": truth(lines, "N_unit")}


def ray(start, through, shapes, *flags):
    """Report and lines of a ray through a scene of spheres and planes."""
    text = ('ambient = 0\n[camera]\neye = [0, 1, 9]\nat = [0, 0, 0]\n[[material]]\nname = "m"\nambient = 0\ndiffuse = 1\n' + shapes)
    report = plumb("pixel", scene(text), "--ray", words_of(list(start) + list(through)), *flags)
    return report["pixels"][0], lines_of(report)


def ray_sphere(e):
    i = e["inputs"]
    through = i.get("through") or [a + b for a, b in zip(i["start"], i["direction"])]
    pixel, lines = ray(i["start"], through, f'[[sphere]]\ncentre = {i["centre"]}\nradius = {i["radius"]}\nmaterial = "m"\n')
    found = {"direction": truth(lines, "ray1_vector"), "a_b_c": truth(lines, "sphere0_abc"), "discriminant": truth(lines, "sphere0_discriminant")}
    if lines["sphere0_roots"]["truth"] is not None:
        found["t_small"], found["t_large"] = found["t_near"], found["t_far"] = truth(lines, "sphere0_roots")
        found["far_point"] = [s + found["t_far"] * d for s, d in zip(i["start"], found["direction"])]
    if "ray1_root" in lines:
        found["sqrt_discriminant"], found["point"] = truth(lines, "ray1_root"), truth(lines, "ray1_point")
    if (pixel["shown"]["truth"]["object"] is not None) != any(t > 0 for t in (found.get("t_small", 0), found.get("t_large", 0))):
        faults.append(f"{e['id']}: hit {pixel['shown']['truth']}")
    return found


def ray_plane(e):
    i = e["inputs"]
    through = i.get("through") or [a + b for a, b in zip(i["start"], i["direction"])]
    pixel, lines = ray(i["start"], through, f'[[plane]]\npoint = {i["anchor"]}\nnormal = {i["normal"]}\nmaterial = "m"\n')
    found = {"direction": truth(lines, "ray1_vector"), "numerator": truth(lines, "plane0_numerator"), "denominator": truth(lines, "plane0_denominator"),
             "hit": 0 if pixel["shown"]["truth"]["object"] is None else 1}
    if lines["plane0_t"]["truth"] is not None:
        found["t"] = truth(lines, "plane0_t")
    if "ray1_point" in lines:
        found["D"], found["point"] = truth(lines, "ray1_plane_D"), truth(lines, "ray1_point")
    return found


def bent(e):
    """18.2.3 and 18.2.4: a ray with the vector T onto a plane through the origin."""
    i = e["inputs"]
    glass = f'[[material]]\nname = "g"\nreflect = 0.3\ntransmit = {0.5 if "d1" in i else 0}\nior = {i["d2"] / i["d1"] if "d1" in i else 1}\n'
    _, lines = ray([-c for c in i["T"]], [0, 0, 0], glass + f'[[plane]]\npoint = [0, 0, 0]\nnormal = {i["N"]}\nmaterial = "g"\n')
    found = {"R": truth(lines, "ray1_R"), "R_unit": truth(lines, "ray1_R_unit"), "cos_phi": -truth(lines, "ray1_denominator")}
    if "d1" not in i:
        return found | {"magnitude": truth(lines, "ray1_R_length")}
    found |= {"d": truth(lines, "ray1_d"), "cos_phi1": truth(lines, "ray1_cos_phi"), "radicand": truth(lines, "ray1_radicand")}
    if found["d"] < 1:
        found["critical_angle_deg"] = math.degrees(math.asin(found["d"]))
    if "ray1_Trans" in lines:
        found |= {"cos_phi2": truth(lines, "ray1_cos_phi2"), "Trans": truth(lines, "ray1_Trans"), "magnitude": truth(lines, "ray1_Trans_length")}
    return found


BOARD = ('[[material]]\nname = "red"\nemission = [1, 0, 0]\ndiffuse = 0\n[[material]]\nname = "white"\nemission = 1\ndiffuse = 0\n'
         '[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\nu = [1, 0, 0]\nmaterial = "red"\nboard = { square = 100, material = "white", mirrored = true }\n')


def on_board(x, z):
    pixel, lines = ray([x, 1, z], [x, 0, z], BOARD)
    return "white" if pixel["shown"]["truth"]["linear"][1] > 0.5 else "red", lines


def checker(e):
    i = e["inputs"]
    if "points" in i:
        for at, want in zip(i["points"], e["data"]["colours"]):
            if on_board(*at)[0] != want:
                faults.append(f"{e['id']} at {at}: not {want}")
        return {}
    colour, lines = on_board(i["X"], i["Z"])
    if colour != e["data"]["colour"]:
        faults.append(f"{e['id']}: {colour}")
    return dict(zip(("abs_X_mod_200", "abs_Z_mod_200"), truth(lines, "ray1_board_rest")))


def weights(e):
    """18.4.2: mirrors of a floor and a ceiling, met one after another."""
    shares = e["inputs"]["reflectivity_of_surfaces"]
    shapes = "".join(f'[[material]]\nname = "r{k}"\nreflect = {share}\n[[plane]]\npoint = [{2 * k + 1}, {2 * (k % 2)}, 0]\nnormal = [0, {1 - 2 * (k % 2)}, 0]\nu = [1, 0, 0]\nu_range = [-1, 1]\n'
                     f'material = "r{k}"\n' for k, share in enumerate(shares))
    _, all_rays = ray([0, 1, 0], [1, 0, 0], shapes)
    _, few = ray([0, 1, 0], [1, 0, 0], shapes, "--min-weight", str(e["inputs"]["cutoff"]))
    found = {f"ray{k}": truth(all_rays, f"ray{k}_weight") for k in range(1, len(shares) + 2)}
    return found | {"rays_traced": sum(f"ray{k}_weight" in few for k in range(1, 9))}


def shadow(e):
    def reaches(blockers, share):
        balls = "".join(f'[[sphere]]\ncentre = [0, {3 + 3 * k}, 0]\nradius = 1\nmaterial = "b"\n' for k in range(blockers))
        _, lines = ray([3, 3, 0], [0, 0, 0], f'[[light]]\ntype = "point"\nposition = [0, 20, 0]\n[[material]]\nname = "b"\ntransmit = {share}\n{balls}'
                                             '[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\nmaterial = "m"\n')
        return lines["ray1_reaches0"]["twin"][0]
    t = e["inputs"]["translucency"]
    return {"factor": reaches(1, t), "reduction_percent": 100 * (1 - reaches(1, t)), "opaque_factor": reaches(1, 0), "two_such_objects": reaches(2, t)}


def program(*pixels):
    """Pixels of the C program of 18.5, as it counts them."""
    words = [f"{x - 1},{y - 1}" for x, y in pixels]
    report = plumb("pixel", os.path.join(os.path.dirname(EXAMPLES), "..", "..", "scenes", "notes-spheres.toml"), *words, "--sampling", "notes")
    return [(pixel, {line["name"]: line for line in pixel["chains"][0]["lines"]}) for pixel in report["pixels"]]


def hand_check(e):
    (pixel, lines), = program(e["inputs"]["pixel"])
    return {"ray": truth(lines, "ray1_vector"), "t": truth(lines, "ray1_t"), "point": truth(lines, "ray1_point"), "rgb": pixel["shown"]["twin"]["code"]}


def sample_pixels(e):
    kinds = {None: "background", 0: "sphere1", 1: "sphere2", 2: "checkerboard"}
    samples = e["data"]["samples"]
    good = 0
    for (x, y, rgb, path, t), (pixel, lines) in zip(samples, program(*[(s[0], s[1]) for s in samples])):
        steps = path.split(">")
        same = kinds[pixel["shown"]["truth"]["object"]] == steps[0] and (t is None or abs(truth(lines, "ray1_t") - t) <= 1e-12 * t)
        # The program truncates to whole levels at each of its rays, so it is darker by less than a level a ray.
        good += same and all(-0.5 <= got - want <= len(steps) for got, want in zip(pixel["shown"]["twin"]["code"], rgb))
    return {"samples": good}


def counted(text, *flags):
    report = plumb("render", scene(text), "--shading", "ray", "-q", "-o", os.path.join(FOLDER.name, "x.png"), *flags)
    return [depth["primary"] + depth["reflected"] + depth["refracted"] for depth in report["counters"]["rays"]]


def ray_counts(e):
    """A stack of planes that mirror, and let pass or not: each hit has one child or two, and each child meets a plane."""
    def rays(transmit, depth):
        planes = "".join(f'[[plane]]\npoint = [0, {y}, 0]\nnormal = [0, 1, 0]\nmaterial = "p"\n' for y in range(-9, 10))
        return sum(counted(f'[camera]\neye = [0, 0.5, 0]\nat = [0.1, -1, 0]\n[[material]]\nname = "p"\nreflect = 0.4\ntransmit = {transmit}\n{planes}', "--size", "1x1", "--max-depth", str(depth)))
    depths = e["inputs"]["depth"]
    both, alone = [rays(0.4, d) for d in depths], [rays(0, d) for d in depths]
    return {"both": both, "reflection_only": alone, "depth4_both": both[3], "depth4_reflection_only": alone[3], "depth4_calls_including_depth0": 2 * both[3] + 1}


RAYS = {"s185_hand_checkerboard": hand_check, "s185_hand_sphere1": hand_check, "s185_sample_pixels": sample_pixels, "s181_ray_counts": ray_counts,
        "s1842_adaptive_depth": weights, "s1843_shadow_attenuation": shadow}


def reader_of(e):
    """Function that reads an entry's checks, and the tolerance of what it reads; None for kinds without a command."""
    i, s, name = e["inputs"], e["section"], e["id"]
    if s == "5.1":
        return lambda e: {"points": after(matrix([f"translate={words_of(i['T'])}"], i["points"], True))}, BINARY64
    if s == "5.2" and "S" in i:
        return lambda e: {"points": after(matrix([f"scale={words_of(i['S'])}"], i["points"], True))}, BINARY64
    if s == "5.2":
        return lambda e: {f"S={S:g}": after(matrix([f"scale={S},{S}"], i["points"], True)) for S in i["S_list"]}, BINARY64
    if s == "5.3":
        def rotation(e):
            report = matrix([f"rotate={i['phi_deg']}"], i["points"], True)
            return {"points": after(report), "sin_cos": [report["composite"][0][1], report["composite"][0][0]]}
        return rotation, BINARY64
    if s in ("7.1", "7.2", "7.3"):
        return in_place, BINARY64
    if s == "7.4":
        return lambda e: dict(zip(("min", "max", "centre"), bounds_of(i["vertices"]))), BINARY64
    if s == "8.2":
        return plane_matrices, BINARY64
    if s.startswith("8.3"):
        axis = {"8.3.3": "z", "8.3.4": "y", "8.3.5": "x"}.get(s.split()[0])
        return lambda e: turned(e, axis), BINARY64
    if name == "s1021_composite_2d":
        return composite_2d, BINARY64
    if s.startswith("10.2.2 step"):
        return line_step, BINARY64
    if s == "10.2.2":
        return {"s1022_line_parameters": line_parameters, "s1022_composite_phi90": line_composite, "s1022_step_counts": step_counts}[name], BINARY64
    if s == "11.3":
        return lambda e: {"result": after(matrix([f"scale={i['a']}"], [i["V"]], True))[0]}, BINARY64
    if s == "11.4":
        return lambda e: {"sum": after(matrix([f"translate={words_of(i['Q'])}"], [i["P"]], True))[0],
                          "difference": after(matrix([f"translate={words_of([-c for c in i['Q']])}"], [i["P"]], True))[0]}, BINARY64
    if s == "11.10":
        return cross_product, BINARY64
    if s == "12.1 / 12.3":
        return visibility, BINARY64
    if s == "14.2" and "vertex" in i:
        return projection, BINARY64
    if s == "18.2.1":
        return ray_sphere, BINARY64
    if s == "18.2.2":
        return ray_plane, BINARY64
    if s in ("18.2.3", "18.2.4") and name != "s1823_reflect_ray_grazing":
        return bent, FLOAT32 if "d1" in i else BINARY64
    if s == "18.3":
        return checker, FLOAT32
    if RAYS.get(name):
        return RAYS[name], FLOAT32
    if name == "s162_ambient_mono" or name == "s162_ambient_rgb":
        def ambient(e):
            lines = lit([0, 0, 1], [0, 0, 1], ia=i["Ia"], kd=i["Kd"])
            value, mono = lines["linear"]["truth"], not isinstance(i["Ia"], list)
            return {"intensity": value[0] if mono else value, "times255": lines["bytes"]["truth"][0], "byte": lines["bytes"]["twin"][0], "bytes": lines["bytes"]["twin"]}
        return ambient, FLOAT32
    if name == "s163_lambert_angles":
        return lambda e: {"cos": [lit([0, 1, 0], [math.sin(math.radians(a)), math.cos(math.radians(a)), 0], ip=1, kd=1)["pixel_NL0"]["truth"][0] for a in i["phi_deg"]]}, FLOAT32
    if name == "s163_diffuse_from_below":
        def below(e):
            lines = [lit(i["N"], light, ip=i["Ip"], kd=i["Kd"]) for light in i["L_list"]]
            return {"N.L": [truth(l, "pixel_NL0") for l in lines], "diffuse": [l["pixel_diffuse0"]["truth"][0] for l in lines]}
        return below, FLOAT32
    if name == "s163_attenuation_choices":
        return lambda e: {check: lit([0, 0, 1], None, ip=i["Ip"], kd=i["Kd"], point=[0, 0, i["d"]], attenuation=word)["pixel_diffuse0"]["truth"][0]
                          for check, word in (("ignored", "none"), ("one_over_d", "1/d"), ("one_over_d2", "1/d^2"))}, FLOAT32
    if name == "s1641_spec_index_table":
        def table(e):
            a = math.radians(i["theta_deg"])
            powers = [lit([0, 1, 0], [0, 1, 0], view=[math.sin(a), math.cos(a), 0], ip=1, ks=1, index=float(n))["pixel_power0"]["truth"][0] for n in i["specIndex"]]
            return {"factor": powers, "percent": [100 * p for p in powers]}
        return table, FLOAT32
    return None


def differs(got, want, allowed):
    if isinstance(want, list):
        return not isinstance(got, list) or len(got) != len(want) or any(differs(g, w, allowed) for g, w in zip(got, want))
    return abs(got - want) > allowed * max(1, abs(want))


read, checked = [], 0
for entry in ENTRIES:
    found = reader_of(entry)
    if found is None:
        continue
    try:
        values = found[0](entry)
    except RuntimeError as error:
        faults.append(f"{entry['id']}: {error}")
        continue
    whole = True
    for check in entry["checks"]:
        if check["name"] not in values:
            whole = False
            continue
        checked += 1
        if differs(values[check["name"]], check["expected"], found[1]):
            faults.append(f"{entry['id']} {check['name']}: {values[check['name']]}, expected {check['expected']}")
    if whole:
        read.append(entry["id"])
FOLDER.cleanup()
print(f"{len(read)} of {len(ENTRIES)} entries and {checked} checks are read from the JSON of commands")
if len(read) < LEAST:
    faults.append(f"{len(read)} entries are read whole, not {LEAST}")
for fault in faults[:40]:
    print(fault)
sys.exit(1 if faults else 0)
