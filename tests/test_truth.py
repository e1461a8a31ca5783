"""Certified crossing lists (testdata/truth): every count right, every list alternating, every error of t near its own
bound and near the effect of input rounding. test_open_truth.py has the families that leave something open."""

import json

import numpy as np
import pytest
from command import ROOT, cast, object_scene

TRUTH = ROOT / "testdata/truth"
FAMILIES = ["torus", "quadric", "box", "affine", "csg", "coincident", "mesh"]
# Rays with one of these bits do not have a single right count: see testdata/truth/README.md.
GUARDED = 1 | 2 | 4 | 8 | 16
# The largest error of t, in units of the effect of half an ulp in every input.
MAX_ERROR = 8
# The median of the bounds, in the same units.
MEDIAN_BOUND = 8


def load(path):
    with np.load(path, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


@pytest.mark.parametrize("family", FAMILIES)
def test_family(tmp_path, family):
    truth = load(TRUTH / f"{family}.npz")
    scenes = json.loads((TRUTH / f"{family}.json").read_text())["scenes"]
    problems, widths = [], []
    for scene in scenes:
        rows = np.nonzero(truth["scene"] == scene["id"])[0]
        document = object_scene(scene["root"], defs=scene.get("defs", {}))
        write_meshes(tmp_path, family, [scene["root"], *document["defs"].values()])
        rays = np.hstack([truth["origin"][rows], truth["direction"][rows]])
        arrays = cast(tmp_path, document, rays, "crossings")
        for row, begin, end in zip(rows, arrays["ray_splits"], arrays["ray_splits"][1:], strict=False):
            t, entering, bound = (arrays[name][begin:end] for name in ("t", "entering", "t_err"))
            found = list(faults(truth, row, t, entering, bound))
            problems += [f"ray {row} of scene {scene['id']} ({scene['name']}): {problem}" for problem in found]
            if not found and not truth["guard"][row] & GUARDED:
                # The start of a ray that begins inside has no error.
                kept = t[np.isfinite(t)] > 0
                widths.extend(bound[np.isfinite(t)][kept] / units(truth, row)[kept])
    assert not problems, "\n".join([f"{len(problems)} faults", *problems[:20]])
    assert np.median(widths) <= MEDIAN_BOUND


def units(truth, row):
    """The effect of half an ulp in every input on each t of a ray."""
    part = slice(truth["offsets"][row], truth["offsets"][row + 1])
    return np.maximum(truth["sens"][part], np.abs(truth["t"][part])) * 2.0**-53


def faults(truth, row, t, entering, bound):
    """The faults in the crossing list of a ray."""
    if len(t) % 2:
        yield f"{len(t)} crossings, an odd number"
    # An unbounded interval has an exit at infinity here and none in the truth.
    finite = np.isfinite(t)
    if not finite[:-1].all():
        yield "a crossing that is not finite before the last"
    t, entering, bound = t[finite], entering[finite], bound[finite]
    if (t < 0).any() or (np.diff(t) < 0).any() or (entering != (np.arange(len(t)) % 2 == 0)).any():
        yield "not ascending from 0 and alternating from an entry"
    if truth["guard"][row] & GUARDED:
        return
    part = slice(truth["offsets"][row], truth["offsets"][row + 1])
    exact = truth["t"][part]
    if len(t) != len(exact):
        yield f"{len(t)} crossings instead of {len(exact)}"
        return
    unit = units(truth, row)
    error = np.abs((t - exact) - truth["t_lo"][part])
    if (error > MAX_ERROR * unit).any():
        yield f"off by {(error / unit).max():.3g} units"
    if (error > bound).any():
        yield f"off by {error[error > bound]}, more than the bounds {bound[error > bound]}"


def write_meshes(folder, family, nodes):
    """Writes every mesh of a scene to a file."""
    for node in nodes:
        write_meshes(folder, family, node.get("args", []))
        if node.get("kind") == "mesh":
            name = node.pop("model")
            node.pop("n_faces", None)
            node["file"] = f"{name}.ply"
            models = load(TRUTH / f"{family}_models.npz")
            write_ply(folder / node["file"], models[f"{name}_vertices"], models[f"{name}_faces"])


def write_ply(path, vertices, faces):
    triangles = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + vertices.astype("<f8").tobytes() + triangles.tobytes())
