#!/usr/bin/env python3
"""Measure shotline, side by side with Embree where its harness is available.

usage: run.py [--bin target/release/shotline] [--work DIR] [--only mesh|csg|solid|lattice] [--repeats K]

mesh  closest, any and crossings on the bunny, the dragon and the armadillo of ../shared/data, with the rays of
      ../shared/peers/rays.py, on 1 and 2 threads, taking turns with Embree (../shared/peers/embree): the medians,
      and the ratio of each round; skipped, with a message, where these folders are absent. Needs numpy and embreex.
csg   a box minus 10 to 100,000 spheres that remove the same fraction: rays/s for closest and
      crossings, build time, memory.

solid one solid alone, random rays most of which meet it: nanoseconds per ray, from array to array.
lattice 40^3 balls as a lattice and listed one by one, taking turns, and lattices of up to 10^9: microseconds a ray, build
      time, memory.

Rates are rays per second of the cast itself, the median of the repeats.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from typing import Any

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SHARED = os.path.join(os.path.dirname(ROOT), "shared")


def cast_once(binary, scene, rays, query, out, threads=1, options=()):
    """The statistics of one cast of the program."""
    command = [binary, "cast", scene, "--rays", rays, "--query", query, "-o", out, *options]
    command += ["--threads", str(threads), "--stats", "--quiet"]
    return json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout)


def cast(binary, scene, rays, query, threads, repeats, out):
    """The statistics of the run with the median rate."""
    runs = [cast_once(binary, scene, rays, query, out, threads) for _ in range(repeats)]
    return sorted(runs, key=lambda r: r["rays_per_s"])[len(runs) // 2]


# The rays, and whether they begin on the mesh: there a hit is what Embree means by one only without the start of the ray.
SETS = {"camera": False, "random": False, "ao": True, "shadow": True}
QUERIES = {"closest": "closest", "any": "any", "crossings": "all"}
# What a cast returns besides t; Embree's harness returns t and the triangle.
FIELDS = "primitive,t_err,normal"


def embree(mesh, work, threads):
    """(rays, query, mode) -> Mrays/s of one run of the harness in the data folder."""
    harness = os.path.join(SHARED, "peers", "embree", "bench.py")
    report = os.path.join(work, "embree.json")
    if os.path.exists(report):
        os.remove(report)
    options = f"repeats=1 threads={threads} scene=default,robust query=closest,any,all"
    command = [
        sys.executable,
        harness,
        mesh,
        "--work",
        work,
        "--sets",
        ",".join(SETS),
        "--opts",
        options,
        "--json",
        report,
    ]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with open(report) as lines:
        rows = [row for row in map(json.loads, lines) if row["query"] != "build"]
    return {(row["rays"].removesuffix(".npy"), row["query"], row["mode"]): row["mrays"] for row in rows}


def own(binary, mesh, work, threads):
    """(rays, query) -> Mrays/s of one run of the program, after one that warms up."""
    rates = {}
    for rays, on_mesh in SETS.items():
        path = os.path.join(work, "rays-" + os.path.splitext(os.path.basename(mesh))[0], rays + ".npy")
        for query in QUERIES:
            command = [binary, "bench", mesh, "--rays", path, "--query", query, "--threads", str(threads)]
            command += ["--repeats", "1", "--json", "--quiet"]
            command += ["--surfaces-only"] if on_mesh else []
            command += ["--fields", FIELDS] if query != "any" else []
            out = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
            rates[rays, query] = json.loads(out)["rays_per_s"] / 1e6
    return rates


def meshes(binary, work, repeats, thread_counts=(1, 2)):
    if not os.path.isdir(os.path.join(SHARED, "peers", "embree")):
        print("mesh: left out, ../shared/peers is not here")
        return
    print("| mesh | rays | query | threads | shotline | Embree | robust | ratio (range) | to robust |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for name in ("bunny", "dragon", "armadillo"):
        mesh = os.path.join(SHARED, "data", name + ".ply")
        for threads in thread_counts:
            embree(mesh, work, threads)  # makes the rays
            rounds = [(embree(mesh, work, threads), own(binary, mesh, work, threads)) for _ in range(repeats)]
            for rays in SETS:
                for query, theirs in QUERIES.items():
                    rates = [ours[rays, query] for _, ours in rounds]
                    peers = {
                        mode: [peer[rays, theirs, mode] for peer, _ in rounds] for mode in ("default", "robust")
                    }
                    ratios = {
                        mode: [a / b for a, b in zip(rates, of_mode, strict=True)]
                        for mode, of_mode in peers.items()
                    }
                    low, high = min(ratios["default"]), max(ratios["default"])
                    print(
                        f"| {name} | {rays} | {query} | {threads} | {np.median(rates):.2f} | {np.median(peers['default']):.2f} "
                        f"| {np.median(peers['robust']):.2f} | {np.median(ratios['default']):.2f} ({low:.2f}-{high:.2f}) "
                        f"| {np.median(ratios['robust']):.2f} |",
                        flush=True,
                    )


def block(count):
    """A cube of side 2 minus `count` spheres that remove about a third of it."""
    rng = random.Random(count)
    radius = (8 * 0.35 / (count * 4.18879)) ** (1 / 3)
    args = [{"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}]
    for _ in range(count):
        args.append({"kind": "sphere", "radius": radius, "translate": [rng.uniform(-1, 1) for _ in range(3)]})
    return {"shotline": 1, "objects": [{"name": "block", "node": {"op": "difference", "args": args}}]}


def combinations(binary, work, repeats):
    rng = np.random.default_rng(1)
    n = 200_000
    origins = rng.normal(size=(n, 3))
    origins *= 4 / np.linalg.norm(origins, axis=1, keepdims=True)
    rays = os.path.join(work, "block-rays.npy")
    np.save(rays, np.hstack([origins, rng.uniform(-1, 1, (n, 3)) - origins]))
    print(
        f"{'spheres':>8} {'closest/s':>11} {'crossings/s':>12} {'us closest':>11} {'us crossings':>13} {'crossings a ray':>16} {'build s':>8} {'MB':>7}"
    )
    for count in (10, 1_000, 10_000, 100_000):
        scene = os.path.join(work, f"block-{count}.json")
        with open(scene, "w") as f:
            json.dump(block(count), f)
        out = os.path.join(work, "out.npz")
        closest = cast(binary, scene, rays, "closest", 1, repeats, out)
        every = cast(binary, scene, rays, "crossings", 1, repeats, out)
        with np.load(out) as z:
            met = len(z["t"]) / n
        print(
            f"{count:8} {closest['rays_per_s']:11.0f} {every['rays_per_s']:12.0f} {1e6 / closest['rays_per_s']:11.2f} {1e6 / every['rays_per_s']:13.2f} "
            f"{met:16.2f} {every['build_s']:8.3f} {every['memory_bytes'] / 1e6:7.1f}",
            flush=True,
        )


SOLIDS: list[dict[str, Any]] = [
    {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
    {"kind": "sphere", "radius": 1},
    {"kind": "cylinder", "radius": 1, "z0": -1, "z1": 1},
    {"kind": "cone", "r0": 1, "r1": 0, "z0": -1, "z1": 1},
    {"kind": "hyperboloid", "a": 0.6, "c": 0.8, "z0": -1, "z1": 1},
    {"kind": "torus", "R": 1, "r": 0.05},
    {"kind": "torus", "R": 1, "r": 0.4},
    {"kind": "torus", "R": 0.5, "r": 0.7},
]


def solids(binary, work, repeats):
    rays = os.path.join(work, "solid-rays.npy")
    rng = np.random.default_rng(2)
    n = 500_000
    origins = rng.normal(size=(n, 3))
    origins *= 4 / np.linalg.norm(origins, axis=1, keepdims=True)
    np.save(rays, np.hstack([origins, rng.uniform(-0.8, 0.8, (n, 3)) - origins]))
    print(f"{'solid':28} {'ns closest':>11} {'ns crossings':>13} {'crossings a ray':>16}")
    for node in SOLIDS:
        scene, out = os.path.join(work, "solid.json"), os.path.join(work, "out.npz")
        with open(scene, "w") as f:
            json.dump({"shotline": 1, "objects": [{"node": node}]}, f)
        closest = cast(binary, scene, rays, "closest", 1, repeats, out)
        every = cast(binary, scene, rays, "crossings", 1, repeats, out)
        with np.load(out) as z:
            met = len(z["t"]) / n
        name = f"torus {node['R']} {node['r']}" if node["kind"] == "torus" else node["kind"]
        print(
            f"{name:28} {1e9 / closest['rays_per_s']:11.0f} {1e9 / every['rays_per_s']:13.0f} {met:16.2f}",
            flush=True,
        )


def balls(count, is_lattice):
    """A cube of count^3 balls."""
    ball = {"kind": "sphere", "radius": 0.25}
    node: dict[str, Any] = {"op": "lattice", "args": [ball], "counts": [count] * 3, "pitch": [1, 1, 1]}
    if not is_lattice:
        cells = [[i, j, k] for k in range(count) for j in range(count) for i in range(count)]
        node = {"op": "group", "args": [{"ref": "ball", "translate": cell} for cell in cells]}
    return {"shotline": 1, "defs": {"ball": ball}, "objects": [{"name": "balls", "node": node}]}


def lattices(binary, work, repeats):
    print(f"{'balls':18} {'us closest':>11} {'us count':>13} {'crossings a ray':>16} {'build ms':>9} {'kB':>8}")
    for count, is_lattice in ((40, False), (40, True), (40, False), (40, True), (200, True), (1000, True)):
        rng = np.random.default_rng(count)
        n = 8_000_000 // count**2
        origins = rng.uniform(-0.25 * count, 1.25 * count, (n, 3))
        rays, scene = os.path.join(work, "lattice-rays.npy"), os.path.join(work, "lattice.json")
        np.save(rays, np.hstack([origins, rng.uniform(0, count, (n, 3)) - origins]))
        with open(scene, "w") as f:
            json.dump(balls(count, is_lattice), f)
        out = os.path.join(work, "out.npz")
        closest = cast(binary, scene, rays, "closest", 1, repeats, out)
        every = cast(binary, scene, rays, "count", 1, repeats, out)
        with np.load(out) as z:
            met = z["count"].mean()
        name = f"{count}^3" + ("" if is_lattice else ", listed")
        print(
            f"{name:18} {1e6 / closest['rays_per_s']:11.2f} {1e6 / every['rays_per_s']:13.2f} {met:16.1f} "
            f"{1e3 * every['build_s']:9.2f} {every['memory_bytes'] / 1e3:8.1f}",
            flush=True,
        )


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--bin", default=os.path.join(ROOT, "target", "release", "shotline"))
    ap.add_argument("--work", default=os.path.join(tempfile.gettempdir(), "shotline-bench"))
    ap.add_argument("--only", choices=("mesh", "csg", "solid", "lattice"))
    ap.add_argument("--repeats", type=int, default=3)
    a = ap.parse_args()
    os.makedirs(a.work, exist_ok=True)
    for name, measure in (("mesh", meshes), ("csg", combinations), ("solid", solids), ("lattice", lattices)):
        if a.only in (None, name):
            measure(a.bin, a.work, a.repeats)


if __name__ == "__main__":
    main()
