"""How the `t` of a crossing changes with the ray, and with the transform of the part that is hit.

By the implicit function theorem: a crossing stays on its surface, whose normal there is n, so n . (do + t dd + d dt) = n . dp,
where dp is the motion of the surface at the point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .columns import Columns
from .rays import lengths
from .values import affine

# A ray is tangent to a surface if the cosine of its angle to the normal is at most this: the rounding error of the cosine.
_TANGENT = 8 * float(np.finfo(np.float64).eps)


class Derivatives(Columns):
    """The derivatives of the column `t`; a base of answers that have `t` and `normal`."""

    def _rows_of_rays(self) -> np.ndarray | None:
        """The ray of each row; None if there is a row for each ray."""
        return None

    @property
    def dt_do(self) -> np.ndarray:
        """The derivative of t by the origin of the ray, float64 of the shape of `normal`: -n / (n . d).

        NaN where t has none: for a miss, where the ray begins or ends inside, and where it is tangent to the surface within
        rounding. At an edge it is that of the surface that was hit. Needs the columns t and normal.

        >>> hits = Scene(Sphere(radius=1)).closest([-3, 0, 0.6], [2, 0, 0])
        >>> hits.dt_do.round(4).tolist(), hits.dt_dd.round(4).tolist()
        ([-0.5, 0.0, 0.375], [-0.55, 0.0, 0.4125])
        """
        return self._slopes().reshape(self._column("normal").shape)

    @property
    def dt_dd(self) -> np.ndarray:
        """The derivative of t by the direction of the ray: t times `dt_do`."""
        return np.asarray(np.multiply(self._column("t")[..., None], self.dt_do))

    def dt_dtransform(self, transform: ArrayLike) -> np.ndarray:
        """The derivative of t by the numbers of the transform that places the part that is hit, float64 (..., 3, 4).

        Args:
            transform: of shape (3, 4), (4, 4) or (12,): world coordinates from those of the part, as `Scene.with_moved`
                takes it for an object. The derivative holds for the rows that hit this part; select them by `object` or
                `path`.

        Raises ValueError for a matrix that has no inverse.

        >>> moved = np.array([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0.0]])
        >>> hit = Scene(Sphere(radius=1).transform(moved)).closest([0, 0, 0], [1, 0, 0])
        >>> hit.dt_dtransform(moved)[0].tolist()
        [-1.0, 0.0, 0.0, 1.0]
        """
        matrix = np.reshape(affine(transform), (3, 4))
        if np.linalg.matrix_rank(matrix[:, :3]) < 3:
            raise ValueError("a transform has an inverse, which this matrix does not have")
        origins, directions = self._ray_vectors(self._rows_of_rays())
        slopes, t = self._slopes(), self._column("t").reshape(-1, 1)
        with np.errstate(invalid="ignore"):
            points = origins + t * directions - matrix[:, 3]
        local = np.linalg.solve(matrix[:, :3], points.T).T
        local = np.concatenate([local, np.ones((len(local), 1))], axis=1)
        changes = -slopes[:, :, None] * local[:, None, :]
        return np.asarray(changes.reshape(*self._column("t").shape, 3, 4))

    def _slopes(self) -> np.ndarray:
        """-n / (n . d), (rows, 3)."""
        _, directions = self._ray_vectors(self._rows_of_rays())
        normals = self._column("normal").reshape(-1, 3)
        finite = np.isfinite(self._column("t")).reshape(-1)
        scaled, largest = lengths(directions)
        along = (normals * (directions / largest[..., None])).sum(axis=-1)
        defined = finite & (np.abs(along) > _TANGENT * scaled)
        with np.errstate(over="ignore"):
            return np.asarray(-normals / np.where(defined, along, np.nan)[:, None] / largest[..., None])
