#!/usr/bin/env python3
"""Compare all accelerators with each other, bit for bit, and measure them, on large scenes.

usage: accelerators.py [--bin target/release/shotline] [--rays N] [--scenes NAME,...] [--accel NAME,...]

The scenes are those of ../shared/peers/scenes.py and the meshes of ../shared/data, and a million instances in one
level. For each accelerator: build seconds, memory, and nanoseconds per ray for closest and for crossings of random
rays, on one thread. `brute`, and `hierarchy`, to which most of these scenes are one flat group, get fewer rays,
so that they take seconds; their results are compared with those of the same rays.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import neutral  # noqa: E402
from run import cast_once  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
DATA = os.path.join(neutral.SHARED, "data")
with open(os.path.join(ROOT, "docs", "scene.schema.json")) as schema:
    NAMES = json.load(schema)["properties"]["accel"]["enum"]
# The accelerators that may test every item for every ray, and the number of tests they are allowed.
FLAT, LOOKS = ("brute", "hierarchy"), 2e8


def field(count):
    """Small spheres on a jittered lattice: one group, one part."""
    random = np.random.default_rng(1)
    side = round(count ** (1 / 3))
    lattice = np.stack(np.meshgrid(*[np.arange(side)] * 3), -1).reshape(-1, 3)
    places = (lattice + random.uniform(0.2, 0.8, lattice.shape)) / side * 2 - 1
    radius = 0.2 / side
    members = [{"ref": "s", "translate": place} for place in places.round(7).tolist()]
    field = {"name": "field", "node": {"op": "group", "args": members}}
    return json.dumps({"shotline": 1, "defs": {"s": {"kind": "sphere", "radius": radius}}, "objects": [field]})


def scenes(folder):
    """The name of each scene, its file and the number of items in its largest structure."""
    for mesh, count in [("bunny", 69_451), ("dragon", 871_414)]:
        path = os.path.join(DATA, f"{mesh}.ply")
        if os.path.exists(path):
            yield mesh, path, count
    made = {"csg_block": 10_000, "torus_field": 10_000, "lattice": 60}
    if os.path.exists(os.path.join(neutral.SHARED, "peers", "scenes.py")):
        for name, n in made.items():
            path = os.path.join(folder, f"{name}.json")
            with open(path, "w") as out:
                json.dump(neutral.scene(neutral.scenes().make(name, f"n={n}")), out)
            yield name, path, n**3 if name == "lattice" else n
    path = os.path.join(folder, "field.json")
    with open(path, "w") as out:
        out.write(field(10**6))
    yield "a million instances", path, 10**6


def random_rays(binary, path, count, out):
    """Rays from a sphere around the scene to points within its box."""
    info = json.loads(
        subprocess.run([binary, "info", path, "--json"], capture_output=True, text=True, check=True).stdout
    )
    low, high = (np.array(info["bounds"][side]) for side in ("min", "max"))
    random = np.random.default_rng(2)
    origin = random.normal(size=(count, 3))
    origin *= np.linalg.norm(high - low) / np.linalg.norm(origin, axis=1)[:, None]
    origin += (low + high) / 2
    np.save(out, np.hstack([origin, random.uniform(low, high, (count, 3)) - origin]))


def cast(binary, path, accel, query, rays, out):
    stats = cast_once(binary, path, rays, query, out, options=["--accel", accel])
    with np.load(out) as answer:
        bits = hashlib.sha256(b"".join(answer[key].tobytes() for key in sorted(answer.files))).hexdigest()
    return stats, bits


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default=os.path.join(ROOT, "target", "release", "shotline"))
    parser.add_argument("--rays", type=int, default=100_000)
    parser.add_argument("--scenes", default="", help="these scenes only; default: all")
    parser.add_argument("--accel", default=",".join(NAMES), help="these accelerators only; default: all")
    arguments = parser.parse_args()
    accelerators = arguments.accel.split(",")
    if unknown := set(accelerators) - set(NAMES):
        parser.error(f"unknown accelerators: {', '.join(sorted(unknown))}; known are {', '.join(NAMES)}")
    different = measured = 0
    with tempfile.TemporaryDirectory() as folder:
        rays, few, out = (os.path.join(folder, name) for name in ("rays.npy", "few.npy", "out.npz"))
        for name, path, items in scenes(folder):
            if arguments.scenes and name not in arguments.scenes.split(","):
                continue
            measured += 1
            random_rays(arguments.bin, path, arguments.rays, rays)
            np.save(few, np.load(rays)[: max(20, min(arguments.rays, int(LOOKS / items)))])
            expected, whole = cast(arguments.bin, path, "bvh", "crossings", few, out)[1], None
            print(
                f"\n{name}\n| | build, s | memory, MB | closest, ns | crossings, ns | same bits |\n|---|---|---|---|---|---|"
            )
            for accel in accelerators:
                chosen = few if accel in FLAT else rays
                closest, _ = cast(arguments.bin, path, accel, "closest", chosen, out)
                every, bits = cast(arguments.bin, path, accel, "crossings", chosen, out)
                if accel not in FLAT:
                    whole = whole or bits
                same = bits == (expected if accel in FLAT else whole)
                different += not same
                ns = [f"{1e9 / stats['rays_per_s']:,.0f}" for stats in (closest, every)]
                print(
                    f"| {accel} | {every['build_s']:.2f} | {every['memory_bytes'] / 1e6:,.1f} | {ns[0]} | {ns[1]} | "
                    f"{'yes' if same else 'NO'} |",
                    flush=True,
                )
    if not measured:
        sys.exit(f"no scene is called {arguments.scenes}")
    sys.exit(f"{different} results differ" if different else 0)


if __name__ == "__main__":
    main()
