"""Runs the program and reads its output."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SHOTLINE = os.environ.get("SHOTLINE", ROOT / "target/release/shotline")


def run(*arguments):
    """Returns the finished process, even if it failed."""
    return subprocess.run([SHOTLINE, *map(str, arguments)], capture_output=True, text=True, timeout=60)


def cast(folder, scene, rays, query, *flags):
    """Casts rays (N, 6) at a scene given as a dict; returns the arrays."""
    answer = attempt(folder, scene, rays, query, *flags)
    assert answer.returncode == 0, answer.stderr
    with np.load(folder / "out.npz", allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def attempt(folder, scene, rays, query, *flags):
    """Casts rays (N, 6) at a scene given as a dict; returns the finished process."""
    (folder / "scene.json").write_text(json.dumps(scene))
    np.save(folder / "rays.npy", rays)
    files = [folder / "scene.json", "--rays", folder / "rays.npy", "-o", folder / "out.npz"]
    return run("cast", *files, "--query", query, *flags)


def object_scene(node, **more):
    """A scene with one object."""
    return {"shotline": 1, "objects": [{"name": "thing", "node": node}], **more}
