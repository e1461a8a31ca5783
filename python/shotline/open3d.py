"""The ray casting of Open3D, answered by shotline: `RaycastingScene` has the methods, arguments and results of Open3D's
class of this name. Open3D is not needed.

In a script only the import changes:

    from shotline.open3d import RaycastingScene    # instead of o3d.t.geometry.RaycastingScene
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from .mesh import Mesh
from .pinhole import rays_of_field_of_view, rays_of_matrices
from .rays import points as points_of
from .scene import Scene
from .tensors import Array, array, like, unwrapped
from .values import bounded_integer

# Directions of rays that count the walls around points, in no special position to axes and diagonals.
_LINE = np.array([0.5379, 0.6021, 0.5902])


class RaycastingScene:
    """Triangle meshes, and queries of rays and points, as Open3D's `RaycastingScene` does them: hits are those of real
    surfaces, and a ray from inside a closed mesh hits its wall.

    Rays have shape (..., 6), origin and direction, points (..., 3); NumPy arrays, lists, or tensors of Open3D. What is
    float64 is read as float64. Results have the dtypes of Open3D: float32, and uint32 with `INVALID_ID` for a miss.
    They are tensors of Open3D if the rays or points are, and otherwise NumPy arrays that also have `numpy()`.
    `nthreads` is the number of threads, 0 for one per core. `device` has no effect.

    What differs from Open3D:

    - A hit at an edge or a vertex counts once, and a ray that only touches a closed mesh has no hit there.
    - Walls of no thickness within a mesh cancel: faces that are given twice, in opposite directions, are not hit.
    - A closed mesh is a solid: where it passes through itself, walls inside it are not hit. Meshes that were added one by
      one stay apart.
    - Inside and outside of closed meshes is exact, and takes no samples.

    Raises ValueError for arrays of other shapes, and for a ray or point with NaN, infinite numbers or a zero direction,
    which is named by its row.

    >>> scene = RaycastingScene()
    >>> scene.add_triangles([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    0
    >>> hits = scene.cast_rays([[0.25, 0.25, -1, 0, 0, 2]])
    >>> hits["t_hit"].numpy(), hits["primitive_ids"].numpy()
    (array([0.5], dtype=float32), array([0], dtype=uint32))
    """

    INVALID_ID: ClassVar[int] = 0xFFFFFFFF

    def __init__(self, nthreads: int = 0, device: Any = None) -> None:
        self._meshes: list[_Geometry] = []
        self._compiled: _Compiled | None = None
        self._search: Mesh | None = None

    def add_triangles(self, vertex_positions: Any = None, triangle_indices: Any = None, *, mesh: Any = None) -> int:
        """Add a mesh, closed or not: vertices, (n, 3) real numbers, and faces, (m, 3) integers; or, as the only argument,
        a mesh: shotline's, Open3D's (legacy or tensor), or one of another package. Returns its number, from 0."""
        source = vertex_positions if mesh is None else mesh
        if source is None or (mesh is not None and vertex_positions is not None):
            raise TypeError("add_triangles takes vertices and faces, or one mesh")
        self._meshes.append(_geometry(source, triangle_indices))
        self._compiled = self._search = None
        return len(self._meshes) - 1

    def cast_rays(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """The first hit of each ray.

        Returns:
            A dictionary of arrays. t_hit: (...) float32, in lengths of the direction; inf for a miss. geometry_ids,
            primitive_ids: (...) uint32, the number of the mesh and of the face in it; `INVALID_ID` for a miss.
            primitive_uvs: (..., 2) float32, the barycentric weights of the second and third corner; 0 for a miss.
            primitive_normals: (..., 3) float32, unit normals on the side from which the corners run counter-clockwise;
            0 for a miss.
        """
        values = array(rays, "rays", 6)
        world = self._current()
        hits = world.scene.closest(
            values, surfaces_only=True, threads=nthreads, fields=["t", "object", "primitive"]
        )
        triangle = world.triangle(hits.object, hits.primitive)
        columns = {"t_hit": hits.t} | world.ids(triangle)
        columns["primitive_uvs"] = world.weights(triangle, values, hits.t)
        columns["primitive_normals"] = world.normals(triangle)
        return {name: like(rays, column) for name, column in columns.items()}

    def test_occlusions(self, rays: Any, tnear: float = 0.0, tfar: float = math.inf, nthreads: int = 0) -> Any:
        """Whether each ray hits anything from `tnear` to `tfar`, in lengths of its direction: (...) bool."""
        scene = self._current().scene
        values = array(rays, "rays", 6)
        return like(rays, scene.any(values, t_min=tnear, t_max=tfar, surfaces_only=True, threads=nthreads))

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Any:
        """The number of hits of each ray: (...) int32; odd from inside a closed mesh."""
        count = self._current().scene.count(array(rays, "rays", 6), surfaces_only=True, threads=nthreads)
        return like(rays, count.astype(np.int32))

    def list_intersections(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """All hits of n rays, grouped by ray and ascending along it.

        Returns:
            A dictionary of arrays. ray_splits: (n + 1,) uint32; the rows of ray i are `ray_splits[i]` to
            `ray_splits[i + 1]`. ray_ids: (rows,) uint32. t_hit, geometry_ids, primitive_ids, primitive_uvs: as in
            `cast_rays`, (rows,) and (rows, 2).
        """
        values = array(rays, "rays", 6)
        world = self._current()
        hits = world.scene.crossings(
            values, surfaces_only=True, threads=nthreads, fields=["t", "object", "primitive"]
        )
        triangle, ray = world.triangle(hits.object, hits.primitive), hits.ray_ids
        columns = {
            "ray_splits": hits.ray_splits.astype(np.uint32),
            "ray_ids": ray.astype(np.uint32),
            "t_hit": hits.t,
        }
        columns |= world.ids(triangle)
        columns["primitive_uvs"] = world.weights(triangle, values.reshape(-1, 6)[ray], hits.t)
        return {name: like(rays, column) for name, column in columns.items()}

    def compute_occupancy(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """Whether points of shape (..., 3) are inside: (...) float32, 1 or 0. Inside two meshes is outside, as the number
        of walls around a point decides.

        If all meshes are closed, `nsamples` has no effect. Otherwise rays in so many directions, an odd number, vote.
        """
        return like(query_points, self._is_inside(_points(query_points), nthreads, nsamples).astype(np.float32))

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> Any:
        """The distances of points of shape (..., 3) to the nearest face, (...) float32; inf in an empty scene."""
        _, distance, _ = self._closest(_points(query_points), nthreads)
        return like(query_points, distance)

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """The distances of points to the nearest face, (...) float32; negative inside. For `nsamples` and what is inside
        see `compute_occupancy`."""
        points = _points(query_points)
        is_inside = self._is_inside(points, nthreads, nsamples)
        _, distance, _ = self._closest(points, nthreads)
        return like(query_points, np.where(is_inside, 0 - distance, distance))

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> dict[str, Any]:
        """The points of the faces that are closest to points of shape (..., 3).

        Returns:
            A dictionary of arrays. points: (..., 3) float32; NaN in an empty scene. geometry_ids, primitive_ids,
            primitive_uvs, primitive_normals: as in `cast_rays`.
        """
        triangle, _, weights = self._closest(_points(query_points), nthreads)
        world = self._current()
        columns = {"points": world.positions(triangle, weights)} | world.ids(triangle)
        columns["primitive_uvs"] = weights.astype(np.float32)
        columns["primitive_normals"] = world.normals(triangle)
        return {name: like(query_points, column) for name, column in columns.items()}

    @staticmethod
    def create_rays_pinhole(*args: Any, **kwargs: Any) -> Any:
        """The rays of the pixels of a pinhole camera, row by row: (height_px, width_px, 6) float32. One unit of `t` is one
        unit of depth along the camera's axis.

        Either `intrinsic_matrix`, (3, 3), `extrinsic_matrix`, (4, 4), camera from world, `width_px`, `height_px`; or
        `fov_deg`, the horizontal field of view in degrees, `center`, where the camera looks at, `eye`, where it is, `up`,
        (3,) each, `width_px`, `height_px`. As in Open3D, rows go from down to up in the second form.
        """
        make = rays_of_matrices if len(args) + len(kwargs) == 4 else rays_of_field_of_view
        rays = make(*args, **kwargs)
        tensors = [value for value in (*args, *kwargs.values()) if type(like(value, rays)) is not Array]
        return like(tensors[0] if tensors else None, rays)

    def _current(self) -> _Compiled:
        if self._compiled is None:
            self._compiled = _Compiled.of(self._meshes)
        return self._compiled

    def _is_inside(self, points: np.ndarray, threads: int, samples: int) -> np.ndarray:
        if bounded_integer(samples, "nsamples", 1, 2**31 - 1) % 2 == 0:
            raise ValueError(f"nsamples is {samples}, but must be odd")
        scene, is_closed = self._current().scene, self._current().is_closed
        if is_closed:
            splits, _ = scene.objects_at(points, threads=threads)
            is_odd: np.ndarray = np.diff(splits) % 2 == 1
            return is_odd.reshape(points.shape[:-1])
        # The same directions in every call.
        random = np.random.default_rng(0).normal(size=(samples - 1, 3))
        votes: np.ndarray = np.zeros(points.shape[:-1], np.int64)
        for direction in [_LINE, *random]:
            votes += scene.count(points, direction, surfaces_only=True, threads=threads) % 2
        is_inside: np.ndarray = votes > samples // 2
        return is_inside

    def _closest(self, points: np.ndarray, threads: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For each point the closest triangle, -1 for none, its distance and the weights of its second and third corner."""
        shape, world = points.shape[:-1], self._current()
        if not len(world.first_of_object):
            return np.full(shape, -1), np.full(shape, np.inf, np.float32), np.zeros((*shape, 2))
        if self._search is None:
            corners = world.corners.reshape(-1, 3)
            self._search = Mesh(corners, np.arange(len(corners)).reshape(-1, 3))
        near = self._search.closest_points(points, threads=threads)
        return near.primitive.astype(np.int64), near.distance.astype(np.float32), near.barycentric[..., 1:]


class _Geometry(NamedTuple):
    """A mesh that was added: its vertices and faces, and the mesh, None if no face has three different corners."""

    vertices: np.ndarray
    faces: np.ndarray
    mesh: Mesh | None


def _geometry(source: Any, faces: Any) -> _Geometry:
    if faces is None:
        mesh = source if isinstance(source, Mesh) else Mesh(source)
        return _Geometry(mesh.vertices, mesh.faces, mesh)
    corners, positions = np.asarray(unwrapped(faces)), array(source, "vertices", 3)
    if corners.size == 0:
        return _Geometry(positions, np.zeros((0, 3), np.uint32), None)
    if corners.ndim != 2 or corners.shape[1] != 3:
        raise ValueError(f"faces must have shape (m, 3), not {corners.shape}")
    mesh = Mesh(positions, corners)
    return _Geometry(mesh.vertices, mesh.faces, mesh)


class _Faces:
    """What answers need of triangles, (m, 3, 3), made when it is needed: it is the same for all hits of a triangle."""

    def __init__(self, corners: np.ndarray) -> None:
        self._corners = corners

    @cached_property
    def _crosses(self) -> np.ndarray:
        a, b, c = np.moveaxis(self._corners, 1, 0)
        return np.asarray(np.cross(b - a, c - a))

    @cached_property
    def normals(self) -> np.ndarray:
        """The unit normals, (m, 3) float32; 0 for a triangle without an area."""
        length = np.linalg.norm(self._crosses, axis=1, keepdims=True)
        found = np.divide(self._crosses, length, out=np.zeros_like(self._crosses), where=length > 0)
        return np.asarray(found, np.float32)

    @cached_property
    def gradients(self) -> np.ndarray:
        """How the weights of the second and the third corner grow with the point, (m, 2, 3)."""
        a, b, c = np.moveaxis(self._corners, 1, 0)
        square = (self._crosses**2).sum(axis=1)[:, None]
        across = np.stack([np.cross(c - a, self._crosses), np.cross(self._crosses, b - a)], axis=1)
        found = np.divide(across, square[:, None], out=np.zeros_like(across), where=square[:, None] > 0)
        return np.asarray(found)


class _Compiled(NamedTuple):
    """The scene, and the triangles of all meshes one after the other."""

    scene: Scene
    is_closed: bool
    # For each object of the scene, the number of its first triangle.
    first_of_object: np.ndarray
    # For each mesh, the number of its first triangle, and the number of all.
    first: np.ndarray
    corners: np.ndarray
    faces: _Faces

    @classmethod
    def of(cls, meshes: list[_Geometry]) -> _Compiled:
        first = np.cumsum([0, *(len(item.faces) for item in meshes)])
        found = [(number, mesh) for number, item in enumerate(meshes) if (mesh := item.mesh)]
        parts = [item.vertices[item.faces] for item in meshes]
        corners = np.concatenate(parts) if parts else np.zeros((0, 3, 3))
        return cls(
            Scene(*(mesh.named(f"geometry{number}") for number, mesh in found)),
            all(mesh.is_closed for _, mesh in found),
            first[[number for number, _ in found]],
            first,
            corners,
            _Faces(corners),
        )

    def triangle(self, item: np.ndarray, primitive: np.ndarray) -> np.ndarray:
        """The number of the triangle of a hit, from its object and its face; -1 for a miss."""
        if not len(self.first_of_object):
            return np.full(item.shape, -1)
        return np.where(item >= 0, self.first_of_object[item] + primitive, -1)

    def ids(self, triangle: np.ndarray) -> dict[str, np.ndarray]:
        mesh = np.searchsorted(self.first, triangle, side="right") - 1
        face = triangle - self.first[mesh]
        invalid = RaycastingScene.INVALID_ID
        return {
            "geometry_ids": np.where(triangle < 0, invalid, mesh).astype(np.uint32),
            "primitive_ids": np.where(triangle < 0, invalid, face).astype(np.uint32),
        }

    def normals(self, triangle: np.ndarray) -> np.ndarray:
        normal = np.zeros((*triangle.shape, 3), np.float32)
        is_hit = triangle >= 0
        normal[is_hit] = self.faces.normals[triangle[is_hit]]
        return normal

    def weights(self, triangle: np.ndarray, rays: np.ndarray, t: np.ndarray) -> np.ndarray:
        """The barycentric weights of the second and third corner at hits: rays, (..., 6), and their t."""
        weights = np.zeros((*triangle.shape, 2), np.float32)
        is_hit = triangle >= 0
        number, o, d = triangle[is_hit], rays[is_hit, :3], rays[is_hit, 3:]
        from_first = o - self.corners[number, 0] + t[is_hit, None] * d
        found = np.einsum("nij,nj->ni", self.faces.gradients[number], from_first)
        weights[is_hit] = np.clip(found, 0, 1)
        return weights

    def positions(self, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The points of triangles that have these weights; NaN for no triangle."""
        points = np.full((*triangle.shape, 3), np.nan, np.float32)
        is_found = triangle >= 0
        a, b, c = np.moveaxis(self.corners[triangle[is_found]], 1, 0)
        u, v = weights[is_found, :1], weights[is_found, 1:]
        points[is_found] = a + u * (b - a) + v * (c - a)
        return points


def _points(query_points: Any) -> np.ndarray:
    """Points of shape (..., 3), finite."""
    points = points_of(array(query_points, "query_points", 3), "query_points")
    wrong = np.flatnonzero(~np.isfinite(points.reshape(-1, 3)).all(axis=1))
    if wrong.size:
        row = points.reshape(-1, 3)[wrong[0]].tolist()
        raise ValueError(f"query_points: row {wrong[0]} is {row}, but must be finite")
    return points
