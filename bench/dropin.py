#!/usr/bin/env python3
"""Time small scripts for trimesh and Open3D with their own imports, and with shotline's in their place.

usage: dropin.py [--repeats 3] [--size 1.0] [--only depth,walls,grid,picture,field]

The scripts are the functions below; only the class that they get is another one. Each is timed in CPU seconds, the least
of the repeats, with the engines taking turns. Ratios are the other's time divided by shotline's: above 1 shotline is
faster. trimesh without Embree gets a hundredth of the rays, and shotline beside it too. Packages that are missing are
left out, with a message.

pip install -r bench/peers.txt
"""

import argparse
import importlib
import sys
import time

import numpy as np


def bumpy_torus(rings=400, sides=125):
    """The vertices and faces of a closed torus with bumps; 100,000 triangles."""
    i, j = (axis.reshape(-1) for axis in np.mgrid[:rings, :sides])
    u, v = 2 * np.pi * i / rings, 2 * np.pi * j / sides
    r = 0.6 * (1 + 0.1 * np.sin(9 * u) * np.cos(5 * v))
    vertices = np.stack([(2 + r * np.cos(v)) * np.cos(u), (2 + r * np.cos(v)) * np.sin(u), r * np.sin(v)], axis=1)
    a, b = i * sides + j, (i + 1) % rings * sides + j
    c, d = (i + 1) % rings * sides + (j + 1) % sides, i * sides + (j + 1) % sides
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


# --- scripts for trimesh


def depth(intersector, mesh, size):
    """A picture of depths from above: the first hit of a ray for each pixel."""
    side = int(1000 * size**0.5)
    x, y = np.meshgrid(np.linspace(-3, 3, side), np.linspace(-3, 3, side))
    origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, 5.0)], axis=1)
    directions = np.tile([0.01, 0.02, -1.0], (len(origins), 1))
    points, rays, _ = intersector(mesh).intersects_location(origins, directions, multiple_hits=False)
    picture = np.full(len(origins), np.nan)
    picture[rays] = np.linalg.norm(points - origins[rays], axis=1)
    return picture


def walls(intersector, mesh, size):
    """The thickness of the wall under each face: how far a ray goes inside."""
    faces = np.arange(0, len(mesh.faces), max(1, round(1 / size)))
    normals = mesh.face_normals[faces]
    origins = mesh.triangles_center[faces] - 1e-4 * normals
    points, rays, _ = intersector(mesh).intersects_location(origins, -normals)
    thickness = np.full(len(faces), np.inf)
    np.minimum.at(thickness, rays, np.linalg.norm(points - origins[rays], axis=1))
    return thickness


def grid(intersector, mesh, size):
    """Which points of a grid are inside."""
    side = int(100 * size ** (1 / 3))
    axes = [np.linspace(-2.9, 2.9, side) + 0.001 * k for k in range(3)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    return intersector(mesh).contains_points(points).astype(float)


# --- scripts for Open3D


def picture(scene_class, mesh, size):
    """The depths that a pinhole camera sees."""
    scene = scene_class()
    scene.add_triangles(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
    width = int(640 * size**0.5)
    rays = scene_class.create_rays_pinhole(
        fov_deg=60, center=[0, 0, 0], eye=[0, -4, 4], up=[0, 0, 1], width_px=width, height_px=width * 3 // 4
    )
    return scene.cast_rays(rays)["t_hit"].numpy()


def field(scene_class, mesh, size):
    """Signed distances at points in the box of the mesh."""
    scene = scene_class()
    scene.add_triangles(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
    points = np.random.default_rng(0).uniform(-2.7, 2.7, (int(20_000 * size), 3)).astype(np.float32)
    return scene.compute_signed_distance(points).numpy()


TRIMESH = {"depth": depth, "walls": walls, "grid": grid}
OPEN3D = {"picture": picture, "field": field}
# The module of the other engine, its class, shotline's module, the scripts, and the portion of the rays.
PAIRS = [
    ("trimesh.ray.ray_pyembree", "RayMeshIntersector", "shotline.trimesh", TRIMESH, 1.0),
    ("trimesh.ray.ray_triangle", "RayMeshIntersector", "shotline.trimesh", TRIMESH, 0.01),
    ("open3d", "RaycastingScene", "shotline.open3d", OPEN3D, 1.0),
]


class Arrays:
    """What the scripts need of a mesh of trimesh, where trimesh is missing."""

    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices, faces
        corners = vertices[faces]
        self.triangles_center = corners.mean(axis=1)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.face_normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)


def made(vertices, faces):
    try:
        trimesh = importlib.import_module("trimesh")
    except ImportError:
        return Arrays(vertices, faces)
    return trimesh.Trimesh(vertices, faces, process=False)


def imported(module, name):
    found = importlib.import_module(module)
    return getattr(found.t.geometry if module == "open3d" else found, name)


def timed(script, engine, size):
    # A new mesh each time: trimesh keeps its trees with the mesh.
    mesh = made(*bumpy_torus())
    mesh.face_normals, mesh.triangles_center
    start = time.process_time()
    result = script(engine, mesh, size)
    return time.process_time() - start, result


def compare(script, engines, size, repeats):
    """The least times of both engines, and the portion of results that differ."""
    times, results = [[], []], [None, None]
    for _ in range(repeats):
        for which, engine in enumerate(engines):
            seconds, results[which] = timed(script, engine, size)
            times[which].append(seconds)
    a, b = results
    differs = ~(np.isclose(a, b, rtol=1e-3, atol=1e-3) | (np.isnan(a) & np.isnan(b)))
    return min(times[0]), min(times[1]), differs.mean()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--only", default=",".join([*TRIMESH, *OPEN3D]))
    arguments = parser.parse_args()
    print(
        "| script | with | its CPU seconds | shotline's | ratio | results that differ |\n|" + " --- |" * 6,
        flush=True,
    )
    for module, name, ours, scripts, portion in PAIRS:
        try:
            engines = imported(module, name), imported(ours, name)
        except ImportError as error:
            print(f"left out, not installed: {error}", file=sys.stderr)
            continue
        for title, script in scripts.items():
            if title not in arguments.only.split(","):
                continue
            size = arguments.size * portion
            theirs, own, differs = compare(script, engines, size, arguments.repeats)
            ratio = theirs / own
            print(f"| {title} | {module} | {theirs:.3g} | {own:.3g} | {ratio:.3g} | {differs:.2%} |", flush=True)


if __name__ == "__main__":
    main()
