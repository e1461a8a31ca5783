#!/usr/bin/env python3
"""Compare two builds of shotline: the speed of the second divided by that of the first.

usage: pair.py OLD NEW [--only NAME,NAME] [--pairs 9] [--instructions] [--work DIR]

Both cast the same rays, taking turns, on one thread (`shotline bench`). Prints the median of the ratios of the pairs, above 1
where NEW is faster. With --instructions it counts the instructions per ray (valgrind), which do not depend on other work of
the machine, and prints both counts and the ratio NEW to OLD, below 1 where NEW takes fewer.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import tempfile

import numpy as np
import run

ROOT = run.ROOT
PIN = {
    "op": "intersection",
    "args": [
        {"kind": "quadric", "coeffs": [1, 1, 0, 0, 0, 0, 0, 0, 0, -0.16]},
        {"kind": "halfspace", "normal": [0, 0, 1], "offset": 1},
        {"kind": "halfspace", "normal": [0, 0, -1], "offset": 1},
    ],
}
ROD = {"kind": "cylinder", "radius": 0.4, "z0": -1, "z1": 1}
SIDE = 30


def lattice(part):
    """Fuel pins in rows, as one object."""
    places = [{"ref": "part", "translate": [i, j, 0]} for i in range(SIDE) for j in range(SIDE)]
    return {"shotline": 1, "defs": {"part": part}, "objects": [{"node": {"op": "group", "args": places}}]}


def aimed(rng, n, centre, far, near):
    """Rays from a sphere around a point to points near it."""
    out = rng.normal(size=(n, 3))
    out *= far / np.linalg.norm(out, axis=1, keepdims=True)
    return np.hstack([centre + out, rng.uniform(-near, near, (n, 3)) - out])


def across(rng, n):
    """Rays through rows of pins, almost horizontal."""
    turn = rng.uniform(0, 2 * np.pi, n)
    o = np.column_stack([rng.uniform(0, SIDE, n), rng.uniform(0, SIDE, n), rng.uniform(-0.9, 0.9, n)])
    return np.hstack([o, np.column_stack([np.cos(turn), np.sin(turn), 0.01 * rng.normal(size=n)])])


def cases():
    """The name, the scene or its path, and the rays of each case."""
    rng = np.random.default_rng(2)
    block = aimed(rng, 100_000, 0, 4, 0.8)
    for node in run.SOLIDS[:3]:
        yield node["kind"], {"shotline": 1, "objects": [{"node": node}]}, block
    yield "roth", os.path.join(ROOT, "scenes", "roth.json"), aimed(rng, 100_000, np.array([0, 0, 1]), 18, 4)
    for count in (10, 1000):
        yield f"cube-{count}", run.block(count), block
    for name, part in (("pins", PIN), ("rods", ROD)):
        yield name, lattice(part), across(rng, 20_000)
    bunny = os.path.join(run.SHARED, "data", "bunny.ply")
    if os.path.exists(bunny):
        yield "bunny", bunny, aimed(rng, 100_000, np.array([-0.017, 0.11, -0.0015]), 0.3, 0.06)


def bench(binary, scene, rays, query, repeats=3, before=()):
    command = [
        *before,
        binary,
        "bench",
        scene,
        "--rays",
        rays,
        "--query",
        query,
        "--threads",
        "1",
        "--repeats",
        str(repeats),
        "--json",
    ]
    return subprocess.run(command, capture_output=True, text=True, check=True)


def rate(*args):
    told = json.loads(bench(*args).stdout)["rays_per_s"]
    return told["median"] if isinstance(told, dict) else told


def instructions(binary, scene, rays, query, n):
    """Instructions per ray: the difference between four casts and one."""
    valgrind = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null")
    told = (bench(binary, scene, rays, query, k, valgrind).stderr for k in (1, 4))
    one, four = (int(re.findall(r"Collected : (\d+)", text)[0]) for text in told)
    return (four - one) / 3 / n


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("old")
    ap.add_argument("new")
    ap.add_argument("--only", type=lambda names: names.split(","))
    ap.add_argument("--pairs", type=int, default=9)
    ap.add_argument("--instructions", action="store_true")
    ap.add_argument("--work", default=os.path.join(tempfile.gettempdir(), "shotline-pair"))
    a = ap.parse_args()
    os.makedirs(a.work, exist_ok=True)
    for name, scene, rays in cases():
        if a.only and name not in a.only:
            continue
        if isinstance(scene, dict):
            path = os.path.join(a.work, name + ".json")
            with open(path, "w") as f:
                json.dump(scene, f)
            scene = path
        if a.instructions:
            rays = rays[:1000]
        file = os.path.join(a.work, "rays.npy")
        np.save(file, rays)
        for query in ("closest", "any", "crossings"):
            if a.instructions:
                old, new = (instructions(b, scene, file, query, len(rays)) for b in (a.old, a.new))
                print(f"{name:10} {query:10} {old:9.0f} {new:9.0f} {new / old:7.3f}", flush=True)
                continue
            pairs = [[rate(b, scene, file, query) for b in (a.old, a.new)] for _ in range(a.pairs)]
            ratios = sorted(new / old for old, new in pairs)
            best = [max(rates) / 1e6 for rates in zip(*pairs, strict=False)]
            print(
                f"{name:10} {query:10} {statistics.median(ratios):6.3f}  from {ratios[0]:.2f} to {ratios[-1]:.2f}"
                f"  best {best[0]:.3f} and {best[1]:.3f} Mrays/s",
                flush=True,
            )


if __name__ == "__main__":
    main()
