#!/usr/bin/env python3
"""Pictures of every example scene and of large meshes, and the number of rays cast per second.

demo.py [--program target/release/shotline] [--data FOLDER] [--out out/demo]
"""

import argparse
import json
import random
import struct
import subprocess
import time
from pathlib import Path

import models

ROOT = Path(__file__).resolve().parent.parent
SIZE = "800x600"
RAYS = 200_000


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/shotline")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared/data", help="bunny.ply, armadillo.ply")
    parser.add_argument("--out", type=Path, default=ROOT / "out/demo")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)

    def shotline(*arguments):
        command = [args.program, *map(str, arguments)]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    pictures, speeds = [], []
    for scene in sorted((ROOT / "scenes").glob("*.json")):
        pictures.append(picture(shotline, scene, args.out / f"{scene.stem}.png", "lit"))
    for model in models.models(args.data, args.out):
        on_ground, alone = model.write(args.out)
        for look in model.looks:
            scene = on_ground if look == "lit" else alone
            pictures.append(picture(shotline, scene, args.out / f"{model.name}-{look}.png", look))
        rays = args.out / f"{model.name}.npy"
        write_rays(rays, json.loads(shotline("info", alone, "--json"))["bounds"])
        speeds += [speed(shotline, alone, rays, query) for query in ["closest", "crossings"]]

    print()
    print_table(["picture", "look", "size", "seconds"], pictures)
    print()
    print_table(["scene", "query", "rays", "threads", "build s", "rays/s"], speeds)
    roth = ROOT / "scenes/roth.json"
    print("\nOne ray through the difference of box and cylinder, scenes/roth.json:\n")
    print(shotline("shoot", roth, "--from", "9,-2,1.5", "--to", "4.1,0,1.1"))
    print(f"The pictures are in {shown(args.out)}.")


def picture(shotline, scene, path, look):
    """Renders a picture and returns its row of the table."""
    begin = time.perf_counter()
    shotline("render", scene, "-o", path, "--size", SIZE, "--look", look)
    return [path.name, look, SIZE, f"{time.perf_counter() - begin:.2f}"]


def speed(shotline, scene, rays, query):
    """Casts rays and returns the row of the table."""
    answers = scene.with_suffix(".npz")
    stats = json.loads(shotline("cast", scene, "--rays", rays, "--query", query, "-o", answers, "--stats"))
    answers.unlink()
    name = scene.stem.removesuffix("-alone")
    counts = [f"{stats['rays']:,}", str(stats["threads"]), f"{stats['build_s']:.2f}", f"{stats['rays_per_s']:,.0f}"]
    return [name, query, *counts]


def write_rays(path, bounds):
    """Rays from a sphere around a box to points in it, as .npy."""
    chance = random.Random(1)
    low, high = bounds["min"], bounds["max"]
    middle = [(a + b) / 2 for a, b in zip(low, high, strict=False)]
    far = sum((b - a) ** 2 for a, b in zip(low, high, strict=False)) ** 0.5
    rows = bytearray()
    for _ in range(RAYS):
        way = [chance.gauss(0, 1) for _ in range(3)]
        length = sum(x * x for x in way) ** 0.5
        origin = [m + far * x / length for m, x in zip(middle, way, strict=False)]
        target = [chance.uniform(a, b) for a, b in zip(low, high, strict=False)]
        rows += struct.pack("<6d", *origin, *(t - o for t, o in zip(target, origin, strict=False)))
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({RAYS}, 6), }}"
    header = header.ljust(117) + "\n"  # its length plus the ten bytes before it is a multiple of 64
    path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + rows)


def print_table(head, rows):
    """Aligns words left and numbers right."""
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    for row in [head, *rows]:
        cells = [
            c.rjust(w) if r[0].isdigit() else c.ljust(w) for c, w, r in zip(row, widths, rows[0], strict=False)
        ]
        print("  ".join(cells).rstrip())


def shown(path):
    """The path relative to the working directory, if it lies in it."""
    path = path.resolve()
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


if __name__ == "__main__":
    main()
