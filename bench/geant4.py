#!/usr/bin/env python3
"""Step Geant4's navigator and shotline along the same rays, in turn. Needs `geant4-pybind` and NumPy.

usage: geant4.py [--bin shotline] [--rays 2000] [--rounds 3] FILE.gdml ...

Geant4's navigator is stepped through its Python binding: `G4Navigator::ComputeStep` with the relocation after it, less the time of
as many calls that do nothing. What the binding adds is not all subtracted, so Geant4 is up to several times as fast in C++. shotline's is that of `bench` with the query
`segments`. Both use one thread. Rays begin at random points of the world, in random directions. Rates are in steps per second:
a step is one segment.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time

import numpy as np

# The package would download the data of physics otherwise, which geometry does not need.
os.environ.setdefault("GEANT4_DATA_DIR", tempfile.gettempdir())
import geant4_pybind as g4  # noqa: E402

INFINITY = 9e99


def random_rays(world, count, seed=1):
    """Rays from random points of the box of the world."""
    rng = np.random.default_rng(seed)
    low, high = g4.G4ThreeVector(), g4.G4ThreeVector()
    world.GetLogicalVolume().GetSolid().BoundingLimits(low, high)
    low, high = np.array([low.x, low.y, low.z]), np.array([high.x, high.y, high.z])
    origins = rng.uniform(low, high, (count, 3)) * 0.999
    directions = rng.normal(size=(count, 3))
    return np.hstack([origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)])


def step_time(world, rays):
    """Seconds and steps of Geant4 for all rays, without the calls of the binding."""
    navigator = g4.G4Navigator()
    navigator.SetWorldVolume(world)
    steps, begin = 0, time.process_time()
    for ray in rays:
        point, direction = g4.G4ThreeVector(*ray[:3]), g4.G4ThreeVector(*ray[3:])
        volume = navigator.LocateGlobalPointAndSetup(point, direction, False, False)
        while volume is not None:
            step = navigator.ComputeStep(point, direction, INFINITY, 0.0)
            if step > 1e90:
                break
            point += direction * step
            navigator.SetGeometricallyLimitedStep()
            volume = navigator.LocateGlobalPointAndSetup(point, direction, True, False)
            steps += 1
    seconds = time.process_time() - begin
    begin = time.process_time()
    for _ in range(steps):
        point += direction * 0.0
        navigator.SetGeometricallyLimitedStep()
        navigator.GetWorldVolume()
        navigator.GetWorldVolume()
    return seconds - (time.process_time() - begin), steps


def shotline_time(binary, path, rays, folder):
    """Seconds of shotline for all rays, and the number of segments."""
    file, out = os.path.join(folder, "rays.npy"), os.path.join(folder, "out.npz")
    np.save(file, rays)
    query = ["--rays", file, "--query", "segments", "--threads", "1"]
    bench = [binary, "bench", path, *query, "--repeats", "3", "--json", "--quiet"]
    found = json.loads(subprocess.run(bench, check=True, capture_output=True, text=True).stdout)
    cast = [binary, "cast", path, *query, "--overlaps", "priority", "--output", out]
    subprocess.run(cast, check=True, capture_output=True)
    return min(found["cast_s"]), len(np.load(out)["t_in"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--bin", default="target/release/shotline")
    parser.add_argument("--rays", type=int, default=2000)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    for path in args.files:
        reader = g4.G4GDMLParser()
        begin = time.process_time()
        reader.Read(path, False)
        loaded = time.process_time() - begin
        world = reader.GetWorldVolume()
        g4.G4GeometryManager.GetInstance().CloseGeometry()
        closed = time.process_time() - begin - loaded
        rays = random_rays(world, args.rays)
        print(f"{os.path.basename(path)}: Geant4 reads it in {loaded:.3f} s and closes it in {closed:.3f} s")
        for _ in range(args.rounds):
            with tempfile.TemporaryDirectory() as folder:
                own, segments = shotline_time(args.bin, path, rays, folder)
            other, steps = step_time(world, rays)
            print(
                f"  Geant4 {steps / other / 1e6:.3f} M steps/s, shotline {segments / own / 1e6:.3f} M segments/s,"
                f" {(segments / own) / (steps / other):.2f} times; {steps} steps, {segments} segments"
            )


if __name__ == "__main__":
    main()
