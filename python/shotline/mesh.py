"""Triangle meshes from arrays and from meshes of other packages."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .accelerators import accelerator
from .attributes import Attribute, given_attributes
from .closest_points import ClosestPoints, closest_points
from .foreign import Polygons, surface
from .mesh_surface import SurfacePoints, areas_and_normals, sample
from .nodes import Node
from .values import floats, refuse_masked


class Mesh(Node):
    """A triangle mesh, as a node of a scene.

    `vertices` has shape (n, 3), float64 in the scene's units; `faces` has shape (m, 3), three vertex indices each,
    counter-clockwise seen from outside. Both are copied. Faces of more corners, as an array of shape (m, k) or as a
    list of faces of any sizes, are triangulated as the readers of files do: exactly, convex or not, and every edge is
    kept; `polygons` gives for each triangle the face that it is from.

    Instead of two arrays, a mesh of another package may be given: of trimesh, pyvista (`PolyData`), meshio or Open3D
    (legacy and tensor meshes), or a `trimesh.Scene`, whose meshes are transformed and joined; `Scene(scene)` keeps
    them apart. Anything that is not a face, such as lines and points, is left out with a warning. Faces keep the order
    of the source, and strips follow them.

    `weld` merges vertices up to this distance apart, in the units of the vertices, or with "auto" those within rounding
    error of each other (64 units in the last place of float64) and a thousand times farther from all others. Each is
    moved to the nearest vertex that is kept, so none is moved farther than the distance. `weld_note` says what was
    merged. Faces that collapse are dropped, and the others are renumbered.

    `attributes` are values that are interpolated at hits (`hits.interpolate`): arrays by name, of shape (n,) or (n, k) for the
    vertices, or (m, 3, k) for the corners of triangles. Readers of files call colours `color`, normals `normal` and
    texture coordinates `uv`. No query depends on them.

    A closed mesh is a solid. An open mesh has hits, but no inside: combinations, segments and `contains` refuse it.
    Warns of polygons that cross themselves and of anything left out. Raises ValueError for faces with vertex indices
    that do not exist, for NaN in a vertex of a face, for a mesh without faces, and for volume meshes; TypeError for
    anything that is not a mesh.

    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> mesh = Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    >>> mesh
    <Mesh: 4 vertices, 4 faces, closed>
    """

    __slots__ = ("_accel", "_native", "_weld_note")

    def __init__(
        self,
        vertices: Any,
        faces: ArrayLike | Iterable[ArrayLike] | None = None,
        *,
        accel: str | None = None,
        weld: float | str | None = None,
        attributes: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        if faces is None:
            vertices, faces, notes = surface(vertices)
            for note in notes:
                warnings.warn(note, stacklevel=2)
        points = _points(vertices)
        corners, sizes = _faces(faces, len(points))
        given = given_attributes(attributes, len(points), len(corners) // 3 if sizes is None else None)
        self._native = _native.Mesh(points, corners, sizes, None, given, weld_text(weld))
        self._weld_note = self._native.weld_note()
        for change in self._native.changes():
            warnings.warn(change, stacklevel=2)
        self._accel = accelerator(accel)

    @classmethod
    def _of_native(cls, native: _native.Mesh, accel: str | None = None) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._native, mesh._accel, mesh._weld_note = native, accel, native.weld_note()
        return mesh

    @property
    def vertices(self) -> np.ndarray:
        """The vertices, (n, 3) float64; a copy."""
        return self._native.vertices()

    @property
    def faces(self) -> np.ndarray:
        """The faces, (m, 3) uint32; a copy."""
        return self._native.faces()

    @property
    def polygons(self) -> np.ndarray:
        """For each triangle the index of the face it is a part of, (m,) uint32; a copy."""
        polygons = self._native.polygons()
        return np.arange(self._native.counts()[1], dtype=np.uint32) if polygons is None else polygons

    @property
    def attributes(self) -> dict[str, np.ndarray]:
        """The attributes by name: float64 (n, k) of the vertices, or (m, 3, k) of the corners of triangles; copies.

        >>> mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], attributes={"heat": [20, 30, 60]})
        >>> mesh.attributes["heat"].tolist()
        [[20.0], [30.0], [60.0]]
        >>> Scene(mesh).closest([0.25, 0.5, -1], [0, 0, 1]).interpolate("heat").tolist()
        [42.5]
        """
        return {attribute.name: attribute.array() for attribute in self._attributes()}

    def _attributes(self) -> list[Attribute]:
        return [Attribute(*attribute) for attribute in self._native.attributes()]

    @property
    def is_closed(self) -> bool:
        """Whether every edge has as many faces in one direction as in the other, so that the mesh is a solid."""
        return self._native.is_closed()

    @property
    def areas(self) -> np.ndarray:
        """The areas of the faces, (m,) float64, in the square of the mesh's unit. `mesh.areas.sum()` is that of the surface."""
        return areas_and_normals(self.vertices, self.faces)[0]

    @property
    def normals(self) -> np.ndarray:
        """The normals of the faces, (m, 3) float64, of unit length, on the side from which the corners run counter-clockwise: the
        outside of a closed mesh. NaN for a face without area.

        >>> Mesh([(0, 0, 0), (3, 0, 0), (0, 4, 0)], [(0, 1, 2)]).normals.tolist()
        [[0.0, 0.0, 1.0]]
        """
        return areas_and_normals(self.vertices, self.faces)[1]

    def sample(self, n: int, seed: int = 0) -> SurfacePoints:
        """Random points of the surface, independent and uniform by area, in the mesh's own coordinates.

        Returns `SurfacePoints`: `points`, `primitive` and `barycentric`; `mesh.normals[sampled.primitive]` are their normals. The
        same seed gives the same points. Points are rounded, so they may be just outside or inside. Raises ValueError for a mesh without area.

        >>> mesh = Mesh([(0, 0, 0), (3, 0, 0), (0, 4, 0)], [(0, 1, 2)])
        >>> mesh.areas.tolist(), mesh.sample(5).points.shape
        ([6.0], (5, 3))
        """
        return sample(self.vertices, self.faces, n, seed)

    def closest_points(self, points: ArrayLike, *, threads: int = 0, progress: Any = None) -> ClosestPoints:
        """The points of the mesh that are nearest to points of shape (..., 3), in the mesh's own coordinates.

        Exact but for rounding, for closed meshes and open ones. Returns `ClosestPoints`: `points`, `distance`, `primitive` and
        `barycentric`. The first call prepares the mesh. Raises ValueError for points of another shape.

        >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        >>> mesh = Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
        >>> near = mesh.closest_points([[0.25, 0.25, -2], [1, 1, 1]])
        >>> near.distance.round(3).tolist(), near.points[0].tolist(), near.primitive.tolist()
        ([2.0, 1.155], [0.25, 0.25, 0.0], [0, 2])
        """
        return closest_points(self._native, points, threads, progress)

    @property
    def why_open(self) -> str | None:
        """How many edges are open and where the first is; None for a closed mesh."""
        return self._native.why_open()

    @property
    def weld_note(self) -> str | None:
        """What welding merged and dropped, as text; None for a mesh that was not welded."""
        return self._weld_note

    def _keys(self) -> dict[str, Any]:
        return {"kind": "mesh"} | ({"accel": self._accel} if self._accel else {})

    def _own(self) -> Any:
        vertices, faces = self.vertices, self.faces
        arrays = [vertices, faces, self.polygons]
        for name, values, rows in self._attributes():
            arrays += [np.frombuffer(name.encode(), np.uint8), values, np.zeros(0) if rows is None else rows]
        return self._accel, len(vertices), *(blake2b(array.data).hexdigest() for array in arrays)

    def __reduce__(self) -> Any:
        arrays = (self.vertices, self.faces, self._native.polygons(), self._native.attributes())
        return _unpickled, (*arrays, self._accel, self._weld_note)

    def __repr__(self) -> str:
        state = "closed" if self.is_closed else "open"
        vertices, faces = self._native.counts()
        return f"<Mesh: {vertices} vertices, {faces} faces, {state}>"


def _unpickled(
    vertices: np.ndarray,
    faces: np.ndarray,
    polygons: np.ndarray | None,
    attributes: list[tuple[str, np.ndarray, np.ndarray | None]],
    accel: str | None,
    weld_note: str | None,
) -> Mesh:
    mesh = Mesh._of_native(_native.Mesh(vertices, faces.reshape(-1), None, polygons, attributes, None), accel)
    mesh._weld_note = weld_note
    return mesh


def weld_text(weld: float | str | None) -> str | None:
    """The `weld` argument as text."""
    if isinstance(weld, bool) or not isinstance(weld, (int, float, str, np.number, type(None))):
        raise TypeError(f'weld is a distance or "auto", not {type(weld).__name__}')
    if isinstance(weld, str) and weld != "auto":
        raise ValueError(f'weld is a distance or "auto", not {weld!r}')
    if weld is None or isinstance(weld, str):
        return weld
    # In the form it was given, since messages quote it.
    return str(int(weld)) if isinstance(weld, (int, np.integer)) else repr(float(weld))


def _points(vertices: ArrayLike) -> np.ndarray:
    array = floats(vertices, "vertices")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices have shape (n, 3), not {array.shape}")
    return array


def _faces(faces: Any, vertices: int) -> tuple[np.ndarray, np.ndarray | None]:
    """The corners of the faces one after the other, and how many each has; None for triangles."""
    if not isinstance(faces, Polygons):
        faces = _polygons(faces)
    corners, sizes = faces
    if corners.size and (corners.min() < 0 or corners.max() >= vertices):
        wrong = int(np.argmax((corners < 0) | (corners >= vertices)))
        ends = np.cumsum(sizes)
        face = int(np.searchsorted(ends, wrong, side="right"))
        row = corners[ends[face] - sizes[face] : ends[face]].tolist()
        numbered = f"vertices are numbered from 0 to {vertices - 1}" if vertices else "there are no vertices"
        raise ValueError(f"face {face} is {row}, but {numbered}")
    corners = np.require(corners, np.uint32, ["C", "A"])
    return corners, None if (sizes == 3).all() else np.require(sizes, np.uint32, ["C", "A"])


def _polygons(faces: Any) -> Polygons:
    refuse_masked(faces, "faces")
    try:
        rows = [np.asarray(faces)]
    except ValueError:
        # Rows of several lengths.
        rows = [np.asarray(face).reshape(1, -1) for face in faces]
    if rows[0].size == 0:
        rows[0] = rows[0].reshape(0, 3).astype(np.uint32)
    for row in rows:
        if row.ndim != 2 or row.shape[1] < 3:
            raise ValueError(f"faces have shape (m, 3), or more corners each, not {row.shape}")
        if row.dtype.kind not in "iu":
            raise TypeError(f"faces are numbers of vertices, so integers, not {row.dtype}")
    return Polygons.of(rows)
