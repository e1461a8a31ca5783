#!/usr/bin/env python3
"""Make exact solids into meshes, and measure the meshes by means that have nothing to do with how they are made.

usage: tessellation.py [--rays 100000] [--threads 0] [--only NAME,...]

For each scene and tolerance, on stdout as Markdown: triangles, seconds, the greatest distance of a crossing of the exact solid from
the mesh over so many random rays, the error of the volume, and the part of the rays that cross the mesh more or less often than the
solid: those that graze it. The volume of the solid is that of `measure`, in closed form or by rays.
"""

import argparse
import os
import time

import numpy as np
import shotline
from shotline import Box, Cylinder, Scene, Sphere, Torus

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def drilled():
    return Box(min=(-1, -1, -0.5), max=(1, 1, 0.5)) - Cylinder(radius=0.4, z0=-2, z1=2)


def pitted(count):
    """A block minus many spheres, which overlap."""
    random = np.random.default_rng(1)
    block = Box(min=(-1, -1, -1), max=(1, 1, 1))
    for place in random.uniform(-1, 1, (count, 3)):
        block = block - Sphere(radius=0.15).translate(*place)
    return block


def scenes():
    """The name of each object, a scene of it, and tolerances."""
    valve = shotline.load(os.path.join(ROOT, "scenes", "section.json"))
    yield "ring", Scene(Torus(R=1, r=0.3).rotate(20, 35, 50).named("ring")), (0.01, 0.001)
    yield "drilled block", Scene(drilled().rotate(20, 35, 50).named("drilled block")), (0.01, 0.001)
    yield "housing of the valve", Scene(valve["housing"], materials=valve.materials), (0.01, 0.003)
    yield "block with 100 pits", Scene(pitted(100).named("block")), (0.01, 0.003)
    shell = Sphere(radius=1) - Sphere(radius=0.999)
    yield "shell 0.001 thick", Scene(shell.named("shell")), (0.01, 0.001)
    touching = Sphere(radius=1) - Sphere(radius=0.5).translate(0.5, 0, 0)
    yield "ball with a cavity that touches it", Scene(touching.named("ball")), (0.01, 0.001)


def random_rays(bounds, count):
    """Rays in all directions through the middle of a box and around it."""
    random = np.random.default_rng(2)
    low, high = bounds
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    targets = random.uniform(low, high, (count, 3))
    return targets - 2 * np.linalg.norm(high - low) * directions, directions


def row(name, scene, tolerance, rays, threads):
    start = time.perf_counter()
    made = scene.to_mesh(tolerance, threads=threads)
    seconds = time.perf_counter() - start
    mesh = made[made.object_names[0]].node
    vertices = np.asarray(mesh.vertices)
    origins, directions = random_rays((vertices.min(0), vertices.max(0)), rays)
    exact, of_mesh = (one.crossings(origins, directions, threads=threads) for one in (scene, made))
    distance = mesh.closest_points(exact.points).distance.max()
    other = np.mean(np.diff(exact.ray_splits) != np.diff(of_mesh.ray_splits))
    volumes = [one.measure(rays=1 << 20, threads=threads).volume[0] for one in (scene, made)]
    error = volumes[1] / volumes[0] - 1
    return [
        name,
        f"{tolerance:g}",
        f"{len(mesh.faces):,}",
        f"{seconds:.2g}",
        f"{distance:.2g}",
        f"{100 * error:+.2g} %",
        f"{100 * other:.2g} %",
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=int, default=100_000)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--only", help="names, with commas")
    options = parser.parse_args()
    head = [
        "object",
        "tolerance",
        "triangles",
        "seconds",
        "greatest distance",
        "volume",
        "rays with other crossings",
    ]
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for name, scene, tolerances in scenes():
        if options.only and name not in options.only.split(","):
            continue
        for tolerance in tolerances:
            print("| " + " | ".join(row(name, scene, tolerance, options.rays, options.threads)) + " |", flush=True)


if __name__ == "__main__":
    main()
