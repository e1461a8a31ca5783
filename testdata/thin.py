#!/usr/bin/env python3
"""Take a small selection out of the full truth sets.

    thin.py FULL testdata/truth

FULL holds <family>.json, <family>.npz and the meshes of a family in <family>_models.npz. Scenes and rays are taken at even steps, so that every
group of rays is represented; nothing in them is changed.
"""

import argparse
import json
import os

import numpy as np

# For each family: the step between scenes, the largest scene in bytes of JSON, the number of rays.
KEEP = {
    "torus": (1, None, 460),
    "quadric": (1, None, 500),
    "box": (1, None, 300),
    "affine": (2, None, 300),
    "csg": (2, 5000, 360),
    "coincident": (4, None, 400),
    "mesh": (1, None, 400),
    "unbounded": (1, None, 500),
    "thin": (1, None, 500),
    "abutting": (1, 9000, 500),
    "solids2": (2, None, 250),
}
PER_RAY = ["scene", "group", "origin", "direction", "guard", "start_inside", "ends_inside"]
PER_CROSSING = ["t", "t_lo", "entering", "sens"]
# Arrays of the families whose truth leaves something open.
PER_RAY_OPEN = ["t_min", "t_max", "horizon"]
PER_CROSSING_OPEN = ["optional", "slack"]


def compact(value):
    return json.dumps(value, separators=(",", ":"))


def chosen_scenes(scenes, step, largest):
    fitting = [s for s in scenes if largest is None or len(compact(s)) <= largest]
    return fitting[::step]


def chosen_rays(full, scenes, count):
    """Rays at even steps through those of the scenes, ordered by group, and within a group by scene."""
    rows = np.nonzero(np.isin(full["scene"], [s["id"] for s in scenes]))[0]
    rows = rows[np.lexsort((rows, full["scene"][rows], full["group"][rows]))]
    places = np.unique(np.linspace(0, len(rows) - 1, count).round().astype(int))
    return np.sort(rows[places])


def thin(family, source, target):
    with open(os.path.join(source, family + ".json")) as file:
        document = json.load(file)
    with np.load(os.path.join(source, family + ".npz")) as arrays:
        full = {name: arrays[name] for name in arrays.files}
    step, largest, count = KEEP[family]
    document["scenes"] = chosen_scenes(document["scenes"], step, largest)
    rows = chosen_rays(full, document["scenes"], count)
    offsets = full["offsets"]
    crossings = np.concatenate([np.arange(offsets[row], offsets[row + 1]) for row in rows])
    kept = {name: full[name][rows] for name in PER_RAY + PER_RAY_OPEN if name in full}
    kept |= {name: full[name][crossings] for name in PER_CROSSING + PER_CROSSING_OPEN if name in full}
    kept["offsets"] = np.concatenate([[0], np.cumsum(offsets[rows + 1] - offsets[rows])])
    np.savez_compressed(os.path.join(target, family + ".npz"), **kept)
    with open(os.path.join(target, family + ".json"), "w") as file:
        file.write(compact(document) + "\n")
    thin_models(family, document, source, target)
    groups = len(np.unique(kept["group"]))
    print(
        f"{family}: {len(document['scenes'])} scenes, {groups} groups, {len(rows)} rays, {len(crossings)} crossings"
    )


def thin_models(family, document, source, target):
    """Keeps the meshes that the scenes refer to."""
    path = os.path.join(source, family + "_models.npz")
    if not os.path.exists(path):
        return
    text = compact(document)
    with np.load(path) as models:
        used = {name: array for name, array in models.items() if f'"{name.rsplit("_", 1)[0]}"' in text}
    np.savez_compressed(os.path.join(target, family + "_models.npz"), **used)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("full", help="folder of the full sets")
    parser.add_argument("target", help="folder for the selection")
    args = parser.parse_args()
    os.makedirs(args.target, exist_ok=True)
    for family in KEEP:
        thin(family, args.full, args.target)


if __name__ == "__main__":
    main()
