"""Where on its triangle a ray hits a mesh."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from .columns import Columns
from .mesh import Mesh
from .nodes import Node


class OnTriangles(Columns):
    """A base of answers that have `points`, `object`, `primitive` and `path`."""

    points: Any

    @property
    def barycentric(self) -> np.ndarray:
        """The weights of the three corners of the triangle that is hit, float64 (..., 3); their sum is 1.

        NaN where no triangle is hit, and where the object is not one mesh, transformed or not: a path does not tell where a mesh
        in a combination is. Needs the columns t, object, primitive and path, and the scene: not for answers from a pickle.

        >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        >>> scene = Scene(Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]).scale(2).named("corner"))
        >>> scene.closest([0.5, 0.5, -1], [0, 0, 1]).barycentric.tolist()
        [0.5, 0.25, 0.25]
        """
        weights = np.full((self._column("object").size, 3), np.nan)
        for rows, _, of_rows in self._hit_meshes():
            weights[rows] = of_rows
        return weights.reshape(self.points.shape)

    def interpolate(self, name: str) -> np.ndarray:
        """The values of an attribute of meshes at the hits, float64 (..., k): `hits.interpolate("uv")`.

        The values of the three corners, weighted by `barycentric`. NaN where that is NaN, where the mesh has no such attribute,
        and where a corner has no value. Raises KeyError if no mesh that is hit has the attribute, ValueError if those of
        two meshes have values of different length.

        >>> corners = [(0, 0, 0), (2, 0, 0), (0, 2, 0)]
        >>> mesh = Mesh(corners, [(0, 1, 2)], attributes={"uv": [(0, 0), (1, 0), (0, 1)]})
        >>> Scene(mesh).closest([[0.5, 1, 1], [5, 5, 1]], [0, 0, -1]).interpolate("uv").tolist()
        [[0.25, 0.5], [nan, nan]]
        """
        points, found, known = self.points, None, set[str]()
        primitives = self._column("primitive").reshape(-1)
        for rows, mesh, weights in self._hit_meshes():
            attributes = {attribute.name: attribute for attribute in mesh._attributes()}
            known |= attributes.keys()
            if name not in attributes:
                continue
            corners = attributes[name].of_triangles(primitives[rows], mesh.faces)
            if found is None:
                found = np.full((primitives.size, corners.shape[2]), np.nan)
            if found.shape[1] != corners.shape[2]:
                raise ValueError(
                    f"{name!r} has {found.shape[1]} numbers in one mesh and {corners.shape[2]} in another"
                )
            found[rows] = (weights[:, :, None] * corners).sum(axis=1)
        if found is None:
            names = ", ".join(sorted(known)) or "no attributes"
            raise KeyError(f"{name!r}; the meshes that are hit have {names}")
        return found.reshape(*points.shape[:-1], -1)

    def _hit_meshes(self) -> Iterator[tuple[np.ndarray, Mesh, np.ndarray]]:
        """The meshes that are hit: the rows, the mesh, and the weights of the corners."""
        names = ("object", "primitive", "path")
        objects, primitives, paths = (self._column(name).reshape(-1) for name in names)
        if not (primitives >= 0).any():
            return
        scene: Any = self._source()
        if not hasattr(scene, "objects"):
            raise ValueError("an answer from a pickle does not know the triangles of its scene")
        points = self.points.reshape(-1, 3)
        for path in np.unique(paths[primitives >= 0]):
            rows = np.flatnonzero((paths == path) & (primitives >= 0))
            mesh = _only_mesh(scene.objects[objects[rows[0]]].node)
            if mesh is not None:
                local = _local(scene.path_transform(int(path)), points[rows])
                yield rows, mesh, _weights(mesh.vertices[mesh.faces[primitives[rows]]], local)


def _only_mesh(node: Node) -> Mesh | None:
    """The mesh that a node is, but for transforms and names."""
    while not isinstance(node, Mesh):
        inner = node.children
        if len(inner) != 1:
            return None
        (node,) = inner
    return node


def _local(transform: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points in the frame that an affine map of shape (3, 4) places."""
    return np.asarray(np.linalg.solve(transform[:, :3], (points - transform[:, 3]).T).T)


def _weights(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The weights of the corners, (n, 3, 3), at points in their planes, (n, 3)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, ac, ap = b - a, c - a, points - a
    normal = np.cross(ab, ac)
    square = (normal * normal).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        second = (np.cross(ap, ac) * normal).sum(axis=1) / square
        third = (np.cross(ab, ap) * normal).sum(axis=1) / square
    return np.stack([1 - second - third, second, third], axis=1)
