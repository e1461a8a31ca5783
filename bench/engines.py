"""Engines behind one interface, for peers.py: shotline, trimesh with Embree, Open3D and Raysect.

An engine is constructed from a mesh or a solid. `ready` converts rays, (n, 6) float64, to the engine's own form, before
the clock starts. `QUERIES` names the supported queries; each takes converted rays and a number of threads (0 for all).
`first` and `every` return arrays, for tests: the t of the first hit (inf for none), and the sorted ts of all hits of each ray.
"""

import json
import os
import tempfile

import neutral
import numpy as np


class Missing(Exception):
    """An engine that is not installed."""


class Shotline:
    """float64, sorted, with normals, error bounds, objects, surfaces and paths of every hit."""

    name, THREADS = "shotline", True

    def __init__(self, vertices=None, faces=None, scene=None):
        import shotline

        self.scene = scene or shotline.Scene(shotline.Mesh(np.asarray(vertices, float), faces))
        self.QUERIES = {
            "first": lambda rays, threads: self.scene.closest(rays, threads=threads),
            "any": lambda rays, threads: self.scene.any(rays, threads=threads),
            "count": lambda rays, threads: self.scene.count(rays, threads=threads),
            "all": lambda rays, threads: self.scene.crossings(rays, threads=threads),
        }

    @classmethod
    def of_solid(cls, node):
        import shotline

        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.json")
            with open(path, "w") as out:
                json.dump({"shotline": 1, "objects": [{"name": "part", "node": neutral.converted(node)}]}, out)
            return cls(scene=shotline.load(path))

    def ready(self, rays):
        return rays

    def first(self, rays):
        return self.scene.closest(rays).t

    def any(self, rays):
        return self.scene.any(rays)

    def count(self, rays):
        return self.scene.count(rays)

    def every(self, rays):
        hits = self.scene.crossings(rays)
        return np.split(hits.t, hits.ray_splits[1:-1])


class Trimesh:
    """float32 internally, with embreex. `first` returns triangles only; `all` restarts the ray behind each hit."""

    name, THREADS = "trimesh", False

    def __init__(self, vertices, faces):
        try:
            import trimesh
            from trimesh.ray.ray_pyembree import RayMeshIntersector
        except ImportError as error:
            raise Missing(f"trimesh and embreex: {error}") from None
        mesh = trimesh.Trimesh(np.asarray(vertices, float), faces, process=False)
        self.ray = RayMeshIntersector(mesh)
        self.QUERIES = {
            "first": lambda rays, _: self.ray.intersects_first(*rays),
            "first and where": lambda rays, _: self.ray.intersects_location(*rays, multiple_hits=False),
            "any": lambda rays, _: self.ray.intersects_any(*rays),
            "count": lambda rays, _: np.bincount(self.ray.intersects_id(*rays)[1], minlength=len(rays[0])),
            "all": lambda rays, _: self.ray.intersects_location(*rays),
        }

    def ready(self, rays):
        return np.ascontiguousarray(rays[:, :3]), np.ascontiguousarray(rays[:, 3:])

    def _ts(self, rays, several):
        where, row, _ = self.ray.intersects_location(*self.ready(rays), multiple_hits=several)
        d = rays[row, 3:]
        return row, ((where - rays[row, :3]) * d).sum(1) / (d * d).sum(1)

    def first(self, rays):
        out = np.full(len(rays), np.inf)
        row, t = self._ts(rays, False)
        out[row] = t
        return out

    def any(self, rays):
        return self.ray.intersects_any(*self.ready(rays))

    def count(self, rays):
        return self.QUERIES["count"](self.ready(rays), 1)

    def every(self, rays):
        return grouped(*self._ts(rays, True), len(rays))


class Open3D:
    """float32, with Embree. `all` is not sorted and has no normals."""

    name, THREADS = "Open3D", True

    def __init__(self, vertices, faces):
        try:
            import open3d
        except (ImportError, OSError) as error:
            raise Missing(f"open3d: {error}") from None
        self.tensor = open3d.core.Tensor
        self.scene = open3d.t.geometry.RaycastingScene()
        corners, faces = np.asarray(vertices, np.float32), np.asarray(faces, np.uint32)
        self.scene.add_triangles(self.tensor(corners), self.tensor(faces))
        self.QUERIES = {
            "first": lambda rays, threads: self.scene.cast_rays(rays, nthreads=threads),
            "any": lambda rays, threads: self.scene.test_occlusions(rays, nthreads=threads),
            "count": lambda rays, threads: self.scene.count_intersections(rays, nthreads=threads),
            "all": lambda rays, threads: self.scene.list_intersections(rays, nthreads=threads),
        }

    def ready(self, rays):
        return self.tensor(np.asarray(rays, np.float32))

    def first(self, rays):
        return self.scene.cast_rays(self.ready(rays))["t_hit"].numpy()

    def any(self, rays):
        return self.scene.test_occlusions(self.ready(rays)).numpy()

    def count(self, rays):
        return self.scene.count_intersections(self.ready(rays)).numpy()

    def every(self, rays):
        hits = self.scene.list_intersections(self.ready(rays))
        return grouped(hits["ray_ids"].numpy(), hits["t_hit"].numpy(), len(rays))


class Raysect:
    """float64 solids, float32 meshes, one process. Its users call it from Python, one ray at a time; `loop` avoids
    the calls from Python with a loop in Cython, to measure the speed of the engine itself."""

    THREADS = False

    def __init__(self, vertices=None, faces=None, solid=None, loop=None, what=""):
        try:
            from raysect.core import Point3D, Ray, Vector3D, World
            from raysect.primitive import Mesh
        except ImportError as error:
            raise Missing(f"raysect: {error}") from None
        self.name = f"Raysect{what}"
        self.world = World()
        self.solid = solid or Mesh(np.asarray(vertices, float), faces, smoothing=False)
        self.solid.parent = self.world

        def ray(row):
            return Ray(Point3D(row[0], row[1], row[2]), Vector3D(row[3], row[4], row[5]))

        def hits(row):
            hit = self.solid.hit(ray(row))
            while hit is not None:
                yield hit.ray_distance
                hit = self.solid.next_intersection()

        def nearest(rays, _):
            return [hit and hit.ray_distance for hit in (self.solid.hit(ray(row)) for row in rays)]

        self.QUERIES = {"first": nearest, "all": lambda rays, _: [list(hits(row)) for row in rays]}
        if loop:
            self.QUERIES = {
                "first": lambda rays, _: loop.first(self.solid, rays),
                "all": lambda rays, _: loop.every(self.solid, rays),
            }

    def ready(self, rays):
        return np.ascontiguousarray(rays)

    def first(self, rays):
        return np.array([np.inf if t is None else t for t in self.QUERIES["first"](self.ready(rays), 1)])

    def every(self, rays):
        return [np.sort(row) for row in self.QUERIES["all"](self.ready(rays), 1)]


def raysect_loop():
    """The loop in Cython, compiled on first use."""
    try:
        import pyximport

        folder = os.path.join(tempfile.gettempdir(), "raysect-loop")
        pyximport.install(build_dir=folder, language_level=3, setup_args={"include_dirs": [np.get_include()]})
        import raysect_loop
    except ImportError as error:
        raise Missing(
            f"Raysect without Python's calls, for which Cython and a C compiler are needed: {error}"
        ) from None
    return raysect_loop


def raysect_solid(node, balanced):
    """A Raysect solid of binary nodes: nested from left to right as a loop in Python builds it, or with a tree of
    unions that is split where the operands are sparse."""
    from raysect.core import AffineMatrix3D, Point3D
    from raysect.primitive import Box, Cylinder, Intersect, Sphere, Subtract, Union

    def placed(matrix):
        return AffineMatrix3D([matrix[0:4], matrix[4:8], matrix[8:12], [0, 0, 0, 1]])

    def centre(node):
        ends = (node.get(a, node.get(b)) for a, b in (("a", "min"), ("b", "max")))
        return node.get("center") or [(p + q) / 2 for p, q in zip(*ends, strict=False)]

    def union(nodes):
        if len(nodes) == 1:
            return made(nodes[0])
        centres = np.array([centre(node) for node in nodes])
        nodes = [nodes[i] for i in np.argsort(centres[:, np.argmax(np.ptp(centres, axis=0))])]
        half = len(nodes) // 2
        return Union(union(nodes[:half]), union(nodes[half:]))

    def made(node):
        if node.get("prim") == "box":
            return Box(Point3D(*node["min"]), Point3D(*node["max"]))
        if node.get("prim") == "sphere":
            x, y, z = node["center"]
            return Sphere(node["radius"], transform=placed([1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z]))
        if node.get("prim") == "cylinder":
            matrix, length = neutral.along(node["a"], node["b"])
            return Cylinder(node["radius"], length, transform=placed(matrix))
        first, *rest = node["args"]
        if balanced and node["op"] == "difference" and all("prim" in arg for arg in rest):
            return Subtract(made(first), union(rest))
        out = made(first)
        for arg in rest:
            out = {"union": Union, "intersection": Intersect, "difference": Subtract}[node["op"]](out, made(arg))
        return out

    return made(node)


def grouped(row, t, count):
    """The ts of each ray, sorted."""
    order = np.lexsort((t, row))
    return np.split(np.asarray(t)[order], np.cumsum(np.bincount(row, minlength=count))[:-1])
