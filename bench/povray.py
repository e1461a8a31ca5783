#!/usr/bin/env python3
"""Compare the time of a camera ray with POV-Ray 3.7, on the scenes of ../shared/peers/scenes.py. Needs `povray` and NumPy.

usage: povray.py [--bin shotline] [--rounds 3] [NAME[:key=value,...] ...]

Both programs take turns on one thread. POV-Ray renders the closest hits only (+Q1, without antialiasing); its time is the
CPU time of its trace stage, which includes the camera and a flat pixel. shotline's is that of `bench`, with all columns;
`crossings` lists every crossing, which POV-Ray does not do. Ratios are POV-Ray's time over shotline's.
"""

import argparse
import json
import math
import os
import re
import statistics
import subprocess
import tempfile

import neutral
import numpy as np

SIZE = (512, 384)
SCENES = [
    "roth",
    "torus_field:prim=sphere",
    "torus_field",
    "lattice:n=22",
    "sphereflake:depth=4",
    "csg_block:n=1000",
]


def camera_rays(camera):
    """The rays through the middles of the pixels."""
    width, height = SIZE
    eye, target, up = (np.array(camera[name], float) for name in ("eye", "target", "up"))
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    half = math.tan(math.radians(camera["vfov_deg"]) / 2)
    y, x = np.mgrid[0:height, 0:width]
    x = ((x + 0.5) / width * 2 - 1) * half * width / height
    y = (1 - (y + 0.5) / height * 2) * half
    direction = forward + x[..., None] * right + y[..., None] * above
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    return np.concatenate([np.broadcast_to(eye, direction.shape), direction], -1).reshape(-1, 6)


def pov_time(folder, name):
    """Microseconds of a pixel."""
    command = [
        "povray",
        f"+I{name}.pov",
        f"+O{name}.png",
        f"+W{SIZE[0]}",
        f"+H{SIZE[1]}",
        "-A",
        "-D",
        "+Q1",
        "+WT1",
    ]
    text = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stderr
    seconds = float(re.search(r"Trace Time:.*?\n.*?with ([\d.]+) CPU", text).group(1))
    return 1e6 * seconds / (SIZE[0] * SIZE[1])


def shotline_time(program, folder, name, query):
    command = [program, "bench", f"{name}.json", "--rays", f"{name}.npy", "--query", query]
    command += ["--threads", "1", "--repeats", "3", "--json", "--quiet"]
    text = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    return 1e6 / json.loads(text)["rays_per_s"]


def write(folder, name, spec):
    scenes = neutral.scenes()
    kind, _, keys = spec.partition(":")
    scene = scenes.make(kind, *[key for key in keys.split(",") if key])
    with open(os.path.join(folder, f"{name}.json"), "w", encoding="utf-8") as out:
        json.dump(neutral.scene(scene), out)
    with open(os.path.join(folder, f"{name}.pov"), "w", encoding="utf-8") as out:
        scenes.to_pov(scene, out)
    np.save(os.path.join(folder, f"{name}.npy"), camera_rays(scene["camera"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", default="target/release/shotline")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    options = parser.parse_args()
    program = os.path.abspath(options.bin)
    print("| scene | POV-Ray, us | closest, us | ratio (range) | crossings, us |")
    print("| --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for number, spec in enumerate(options.scenes):
            name = f"scene{number}"
            write(folder, name, spec)
            rows = []
            for _ in range(options.rounds):
                pov = pov_time(folder, name)
                rows.append((pov, *(shotline_time(program, folder, name, q) for q in ("closest", "crossings"))))
            ratios = sorted(pov / closest for pov, closest, _ in rows)
            pov, closest, crossings = (statistics.median(column) for column in zip(*rows, strict=True))
            ratio = f"{statistics.median(ratios):.2f} ({ratios[0]:.2f}-{ratios[-1]:.2f})"
            print(f"| {spec} | {pov:.3f} | {closest:.3f} | {ratio} | {crossings:.3f} |", flush=True)


if __name__ == "__main__":
    main()
