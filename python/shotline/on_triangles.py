"""Where on its triangle a ray hits a mesh."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _native
from .columns import Columns
from .native_args import HitRows


class OnTriangles(Columns):
    """A base of answers that have `points`, `surface`, `primitive` and `path`."""

    points: Any

    @property
    def barycentric(self) -> np.ndarray:
        """The weights of the three corners of the triangle that is hit, float64 (..., 3); their sum is 1.

        NaN where no triangle is hit. Needs the columns t, surface, primitive and path, and the scene: not for answers from a
        pickle.

        >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        >>> scene = Scene(Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]).scale(2).named("corner"))
        >>> scene.closest([0.5, 0.5, -1], [0, 0, 1]).barycentric.tolist()
        [0.5, 0.25, 0.25]
        """
        points, scene, hits = self._hits()
        return scene.barycentric(hits).reshape(points.shape)

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
        points, scene, hits = self._hits()
        return scene.interpolate(hits, name).reshape(*points.shape[:-1], -1)

    def _hits(self) -> tuple[np.ndarray, _native.Scene, HitRows]:
        """The points, the native half of the scene, and the hits as it takes them."""
        columns = [self._column(name).reshape(-1) for name in ("surface", "primitive", "path")]
        points, scene = self.points, self._source()
        if not hasattr(scene, "_native"):
            raise ValueError("an answer from a pickle does not know the triangles of its scene")
        return points, scene._native, HitRows(np.ascontiguousarray(points.reshape(-1, 3)), *columns)
