#!/usr/bin/env python3
"""Write a benchmark scene of ../shared/peers/scenes.py, on which other engines are measured too, as a shotline scene.

usage: neutral.py NAME [key=value ...] > scene.json        (the names: python3 ../shared/peers/scenes.py list)
"""

import importlib.util
import json
import math
import os
import sys

SHARED = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "shared")


def along(a, b):
    """The matrix of a frame at `a` whose z axis points to `b`, and the distance."""
    axis = [q - p for p, q in zip(a, b, strict=False)]
    length = math.hypot(*axis)
    z = [v / length for v in axis]
    least = min(range(3), key=lambda i: abs(z[i]))
    h = [float(i == least) for i in range(3)]
    x = [h[1] * z[2] - h[2] * z[1], h[2] * z[0] - h[0] * z[2], h[0] * z[1] - h[1] * z[0]]
    norm = math.hypot(*x)
    x = [v / norm for v in x]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return [v for row in zip(x, y, z, a, strict=False) for v in row], length


def solid(node):
    kind = node["prim"]
    if kind == "box":
        return {"kind": "box", "min": node["min"], "max": node["max"]}
    if kind == "sphere":
        return {"kind": "sphere", "radius": node["radius"], "translate": node["center"]}
    if kind == "mesh":
        return {"kind": "mesh", "file": node["file"]}
    if kind == "torus":
        c = node["center"]
        matrix, _ = along(c, [p + v for p, v in zip(c, node["axis"], strict=False)])
        return {"kind": "torus", "R": node["major"], "r": node["minor"], "transform": matrix}
    matrix, length = along(node["a"], node["b"])
    sizes = {"radius": node["radius"]} if kind == "cylinder" else {"r0": node["ra"], "r1": node["rb"]}
    return {"kind": kind, **sizes, "z0": 0, "z1": length, "transform": matrix}


def converted(node):
    if "prim" in node:
        out = solid(node)
    elif node["op"] == "ref":
        out = {"ref": node["def"]}
    elif node["op"] == "lattice":
        child = converted(node["child"])
        (ni, nj, nk), (x, y, z) = node["n"], node["step"]
        places = ([i * x, j * y, k * z] for k in range(nk) for j in range(nj) for i in range(ni))
        out = {"op": "group", "args": [{"op": "group", "translate": p, "args": [child]} for p in places]}
    else:
        out = {"op": node["op"], "args": [converted(arg) for arg in node["args"]]}
    if "xf" in node:
        if any(key in out for key in ("transform", "translate")):
            out = {"op": "group", "args": [out]}
        out["transform"] = node["xf"]
    return out


def scene(neutral):
    camera = neutral["camera"]
    return {
        "shotline": 1,
        "defs": {name: converted(node) for name, node in neutral["defs"].items()},
        "objects": [{"name": neutral["name"], "node": converted(neutral["root"])}],
        "camera": {"eye": camera["eye"], "target": camera["target"], "up": camera["up"], "fov": camera["vfov_deg"]},
        "lights": [{"point": neutral["light"]["position"]}, {"ambient": True, "intensity": 0.2}],
    }


def scenes():
    """The module that generates the scenes."""
    spec = importlib.util.spec_from_file_location("scenes", os.path.join(SHARED, "peers", "scenes.py"))
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


if __name__ == "__main__":
    if len(sys.argv) < 2 or not os.path.exists(os.path.join(SHARED, "peers", "scenes.py")):
        sys.exit(__doc__)
    json.dump(scene(scenes().make(*sys.argv[1:])), sys.stdout)
