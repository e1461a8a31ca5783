"""Triangle meshes from arrays and from what other packages hold."""

from __future__ import annotations

import warnings
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .foreign import triangles
from .nodes import Node, accelerator
from .values import floats, refuse_masked


class Mesh(Node):
    """A triangle mesh, as a part of a scene.

    `vertices` has shape (n, 3), float64 in the scene's units; `faces` has shape (m, 3), three numbers of vertices each,
    counter-clockwise seen from outside. Both are copied.

    Instead of two arrays one mesh of another package may be given: of trimesh, pyvista (`PolyData`), meshio or Open3D
    (legacy and tensor meshes), or a `trimesh.Scene`, whose meshes are joined where they are; `Scene(scene)` keeps them
    apart. Quads are cut in two, and what is no face, as lines and points, is left out with a warning. Triangles come in
    the order of the source; of pyvista and meshio those of faces and strips of one size after the other.

    A closed mesh is a solid. One that is not has hits, but no inside: combinations, segments and `contains` refuse it.
    Raises ValueError for faces that name vertices which are not there, for NaN, for no face at all, and for volume
    meshes; TypeError for what is no mesh.

    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> mesh = Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    >>> mesh
    <Mesh: 4 vertices, 4 faces, closed>
    """

    __slots__ = ("_accel", "_native")

    def __init__(self, vertices: Any, faces: ArrayLike | None = None, *, accel: str | None = None) -> None:
        if faces is None:
            vertices, faces, notes = triangles(vertices)
            for note in notes:
                warnings.warn(note, stacklevel=2)
        points = _points(vertices)
        self._native = _native.Mesh(points, _faces(faces, len(points)))
        self._accel = accelerator(accel)

    @classmethod
    def _of_native(cls, native: _native.Mesh, accel: str | None = None) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._native, mesh._accel = native, accel
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
    def is_closed(self) -> bool:
        """Whether along every edge as many faces run one way as the other, so that the mesh is a solid."""
        return self._native.is_closed()

    @property
    def why_open(self) -> str | None:
        """How many edges are open and where the first is; None for a closed mesh."""
        return self._native.why_open()

    def _keys(self) -> dict[str, Any]:
        return {"kind": "mesh"} | ({"accel": self._accel} if self._accel else {})

    def _own(self) -> Any:
        vertices, faces = self.vertices, self.faces
        return self._accel, len(vertices), blake2b(vertices.data).hexdigest(), blake2b(faces.data).hexdigest()

    def __reduce__(self) -> Any:
        return _again, (self.vertices, self.faces, self._accel)

    def __repr__(self) -> str:
        state = "closed" if self.is_closed else "open"
        vertices, faces = self._native.counts()
        return f"<Mesh: {vertices} vertices, {faces} faces, {state}>"


def _again(vertices: np.ndarray, faces: np.ndarray, accel: str | None) -> Mesh:
    return Mesh(vertices, faces, accel=accel)


def _points(vertices: ArrayLike) -> np.ndarray:
    array = floats(vertices, "vertices")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices have shape (n, 3), not {array.shape}")
    return array


def _faces(faces: ArrayLike, vertices: int) -> np.ndarray:
    refuse_masked(faces, "faces")
    array = np.asarray(faces)
    if array.size == 0:
        array = array.reshape(0, 3).astype(np.uint32)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces have shape (m, 3), not {array.shape}; cut polygons into triangles first")
    if array.dtype.kind not in "iu":
        raise TypeError(f"faces are numbers of vertices, so integers, not {array.dtype}")
    if array.size and (array.min() < 0 or array.max() >= vertices):
        row = int(np.argmax(((array < 0) | (array >= vertices)).any(axis=1)))
        numbered = f"vertices are numbered from 0 to {vertices - 1}" if vertices else "there are no vertices"
        raise ValueError(f"face {row} is {array[row].tolist()}, but {numbered}")
    return np.require(array, np.uint32, ["C", "A"])
