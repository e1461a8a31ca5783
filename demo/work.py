#!/usr/bin/env python3
"""The pictures of docs/accelerators.md: the cost of rays, by structure and counter.

    work.py [--program target/release/shotline] [--data FOLDER] [--out out/demo] [--pictures docs/pictures]

Without bunny.ply in the data folder they show the knot of the demo.
"""

import argparse
import subprocess
from pathlib import Path

import models

ROOT = Path(__file__).resolve().parent.parent
# Each structure of the mesh with its most significant counter, and the tests that tags save.
MAPS = [("bvh", "boxes"), ("grid", "cells"), ("octree", "cells"), ("bsp", "planes"), ("grid", "tags")]
# Scenes whose traversal uses heaps.
HEAPS = ["section", "instances"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/shotline")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data", help="bunny.ply, armadillo.ply")
    parser.add_argument("--out", type=Path, default=ROOT / "out/demo")
    parser.add_argument("--pictures", type=Path, default=ROOT / "docs/pictures")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)

    def shotline(*arguments):
        subprocess.run([args.program, *map(str, arguments)], check=True)

    def heat(scene, accel, counter, name):
        path = args.pictures / f"work-{name}.png"
        shotline(
            "render",
            scene,
            "-o",
            path,
            "--size",
            "400x300",
            "--look",
            "cost",
            "--accel",
            accel,
            "--counter",
            counter,
        )

    _, mesh = models.models(args.data, args.out)[0].write(args.out)
    shotline("compare", mesh, "-o", args.pictures / "work.png")
    for accel, counter in MAPS:
        heat(mesh, accel, counter, f"{accel}-{counter}")
    for scene in HEAPS:
        heat(ROOT / f"scenes/{scene}.json", "bvh", "heap", scene)


if __name__ == "__main__":
    main()
