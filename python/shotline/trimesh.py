"""The ray queries of trimesh, answered by shotline: `RayMeshIntersector` has the methods, arguments and results of
trimesh's classes of this name. Neither trimesh nor Embree is needed.

In a script only the import changes, and where a mesh is to use it, one line:

    from shotline.trimesh import RayMeshIntersector

    mesh.ray = RayMeshIntersector(mesh)    # mesh.ray.intersects_first(...), mesh.contains(...)
"""

from __future__ import annotations

from hashlib import blake2b
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .mesh import Mesh
from .rays import points as points_of
from .scene import Scene
from .values import bounded_integer

# Lines for points in open meshes, in no special position to axes and diagonals.
_DIRECTIONS = np.array(
    [
        (0.5379, 0.6021, 0.5902),
        (-0.7213, 0.3571, 0.5937),
        (0.2741, -0.8317, 0.4829),
        (-0.3163, -0.4519, 0.8341),
        (0.9127, 0.1739, -0.3701),
    ]
)


class RayMeshIntersector:
    """Ray queries of a mesh, as trimesh's `ray_triangle.RayMeshIntersector` and `ray_pyembree.RayMeshIntersector` do
    them: hits are those of real surfaces in front of the origin.

    `mesh` (or `geometry`) is a `trimesh.Trimesh`, or any object with `vertices`, (n, 3) real numbers, and `faces`,
    (m, 3) integers; closed or not. `mesh.ray = RayMeshIntersector(mesh)` makes the methods of the mesh use it. It is
    compiled by the first query, and again by the first query after its vertices or faces have changed.
    `scale_to_box` has no effect: nothing is scaled.

    Rays are origins and directions of shape (n, 3) each. Directions of any length but zero are accepted and need no
    normalising. Results are NumPy arrays: locations float64, numbers of rays and faces int64. Hits are grouped by ray,
    rays and hits along them in ascending order; trimesh has no particular order.

    What differs from trimesh:

    - A hit at an edge or a vertex counts once, and a ray that only touches a closed mesh has no hit there.
    - Walls of no thickness cancel: faces that are given twice, in opposite directions, are not hit.
    - A closed mesh is a solid: where it passes through itself, walls inside it are not hit.
    - All hits are found; `max_hits` limits them only where it is given.
    - A hit is at or after the origin, never slightly behind it.
    - Everything is float64.

    Raises ValueError for arrays of other shapes, and for a ray or point with NaN, infinite numbers or a zero direction,
    which is named by its row.

    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> mesh = Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    >>> intersector = RayMeshIntersector(mesh)
    >>> intersector.intersects_location([[0.25, 0.25, -1]], [[0, 0, 2]])
    (array([[0.25, 0.25, 0.  ],
           [0.25, 0.25, 0.5 ]]), array([0, 0]), array([0, 2]))
    """

    def __init__(self, mesh: Any = None, scale_to_box: bool = True, *, geometry: Any = None) -> None:
        source = mesh if geometry is None else geometry
        if source is None or (mesh is not None and geometry is not None):
            raise TypeError("RayMeshIntersector takes one mesh, as mesh or as geometry")
        self.mesh = source
        self._scale_to_box = scale_to_box
        self._compiled: _Compiled | None = None
        self._state: Any = None

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int | None = None,
        return_locations: bool = False,
    ) -> tuple[np.ndarray, ...]:
        """The faces that rays hit.

        Args:
            ray_origins, ray_directions: (n, 3) each.
            multiple_hits: whether to return all hits of a ray, or only the first.
            max_hits: the most hits that are returned for a ray, the first ones; None for all.
            return_locations: whether to return where the hits are.

        Returns:
            The faces and the rays of all hits, (m,) int64 each; with `return_locations` also the positions, (m, 3)
            float64.
        """
        hits = self._hits(ray_origins, ray_directions, multiple_hits, max_hits)
        numbers = hits.face, hits.ray
        return (*numbers, hits.locations()) if return_locations else numbers

    def intersects_location(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where rays hit the mesh. Arguments are those of `intersects_id`.

        Returns:
            The positions of all hits, (m, 3) float64, and their rays and faces, (m,) int64 each.
        """
        hits = self._hits(ray_origins, ray_directions, multiple_hits, max_hits)
        return hits.locations(), hits.ray, hits.face

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> np.ndarray:
        """The first face that each ray hits, (n,) int64; -1 for a miss."""
        origins, directions = _rays(ray_origins, ray_directions)
        first = self._current().scene.closest(origins, directions, surfaces_only=True, fields=["primitive"])
        return first.primitive.astype(np.int64)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> np.ndarray:
        """Whether each ray hits the mesh, (n,) bool."""
        return self._current().scene.any(*_rays(ray_origins, ray_directions), surfaces_only=True)

    def contains_points(self, points: ArrayLike) -> np.ndarray:
        """Whether points of shape (n, 3) are inside the mesh, (n,) bool. Not defined within rounding error of a face.

        In a closed mesh a point is inside where the winding number is not zero; no rays are voted on. An open mesh has
        no inside. As in trimesh there is an answer nevertheless: a point counts as inside if a line through it has an
        odd number of hits on both sides of it. Where the sides disagree, up to five lines are tried; where one side has
        no hit, or all lines disagree, the point counts as outside.
        """
        positions = _rows(points, "points")
        scene, is_closed = self._current()
        return scene.contains(positions) if is_closed else _inside_of_open(scene, positions)

    def _hits(self, origins: ArrayLike, directions: ArrayLike, multiple_hits: bool, max_hits: int | None) -> _Hits:
        o, d = _rays(origins, directions)
        most = None if max_hits is None else bounded_integer(max_hits, "max_hits", 0, 2**63 - 1)
        scene = self._current().scene
        if not multiple_hits:
            first = scene.closest(o, d, surfaces_only=True, fields=["t", "primitive"])
            ray = np.flatnonzero(first.primitive >= 0)
            hits = _Hits(o, d, ray, first.primitive[ray].astype(np.int64), first.t[ray])
            return hits if most != 0 else hits.selected(ray < 0)
        found = scene.crossings(o, d, surfaces_only=True, fields=["t", "primitive"])
        hits = _Hits(o, d, found.ray_ids, found.primitive.astype(np.int64), found.t)
        if most is None:
            return hits
        return hits.selected(np.arange(len(hits.ray)) - found.ray_splits[hits.ray] < most)

    def _current(self) -> _Compiled:
        """The scene of the mesh as it is now."""
        # Not checked earlier: primitives of trimesh make their intersector before they have vertices.
        if not (hasattr(self.mesh, "vertices") and hasattr(self.mesh, "faces")):
            raise TypeError(f"a mesh has vertices and faces, but {type(self.mesh).__name__} has not")
        vertices, faces = self.mesh.vertices, self.mesh.faces
        state = _state(vertices), _state(faces)
        if self._compiled is None or self._state != state:
            self._compiled, self._state = _compiled(vertices, faces), state
        return self._compiled

    def __getstate__(self) -> dict[str, Any]:
        return {"mesh": self.mesh, "_scale_to_box": self._scale_to_box, "_compiled": None, "_state": None}

    def __repr__(self) -> str:
        return f"<RayMeshIntersector of {self.mesh!r}>"


class _Compiled(NamedTuple):
    scene: Scene
    is_closed: bool


class _Hits(NamedTuple):
    """Hits of rays: the number of the ray, of the face, and the parameter of each."""

    origins: np.ndarray
    directions: np.ndarray
    ray: np.ndarray
    face: np.ndarray
    t: np.ndarray

    def locations(self) -> np.ndarray:
        positions: np.ndarray = self.origins[self.ray] + self.t[:, None] * self.directions[self.ray]
        return positions

    def selected(self, rows: np.ndarray) -> _Hits:
        return self._replace(ray=self.ray[rows], face=self.face[rows], t=self.t[rows])


def _compiled(vertices: Any, faces: Any) -> _Compiled:
    corners = np.asarray(faces)
    if corners.size == 0:
        return _Compiled(Scene(), True)
    if corners.ndim != 2 or corners.shape[1] != 3:
        raise ValueError(f"faces must have shape (m, 3), not {corners.shape}")
    mesh = Mesh(vertices, corners)
    return _Compiled(Scene(mesh), mesh.is_closed)


def _state(array: Any) -> Any:
    """A value that changes with the content of an array. Arrays of trimesh know their own hash."""
    if type(array).__hash__ is not None and isinstance(array, np.ndarray):
        return hash(array)
    content = np.ascontiguousarray(array)
    return content.shape, content.dtype.str, blake2b(content.data).digest()


def _rows(values: ArrayLike, what: str) -> np.ndarray:
    """An array of shape (n, 3); empty for an empty list."""
    array = np.asarray(values)
    rows = points_of(array.reshape(-1, 3) if array.size == 0 else values, what)
    if rows.ndim != 2:
        raise ValueError(f"{what} must have shape (n, 3), not {rows.shape}")
    return rows


def _rays(origins: ArrayLike, directions: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    o, d = _rows(origins, "ray_origins"), _rows(directions, "ray_directions")
    if o.shape != d.shape:
        raise ValueError(f"ray_origins of shape {o.shape} and ray_directions of shape {d.shape} do not match")
    return o, d


def _inside_of_open(scene: Scene, positions: np.ndarray) -> np.ndarray:
    """Whether points are inside an open mesh, by the parity of hits on both sides of them."""
    inside = np.zeros(len(positions), bool)
    undecided = np.arange(len(positions))
    for direction in _DIRECTIONS:
        here = positions[undecided]
        ahead = scene.count(here, direction, surfaces_only=True)
        behind = scene.count(here, -direction, surfaces_only=True)
        inside[undecided[(ahead % 2 == 1) & (behind % 2 == 1)]] = True
        undecided = undecided[(ahead % 2 != behind % 2) & (ahead > 0) & (behind > 0)]
        if not undecided.size:
            break
    return inside
