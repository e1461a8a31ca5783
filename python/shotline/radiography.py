"""Radiographs: the attenuation of a beam by a scene, after the law of Beer and Lambert."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .beams import Cone, Parallel
from .progress import ProgressCallback, callback
from .rays import points
from .scene import Scene
from .values import bounded_integer, floats, number

# Rays per query, which bounds the memory beside the picture.
_BLOCK = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Detector:
    """A flat detector of pixels.

    Args:
        center: the middle of the detector, in world coordinates.
        u: from the centre of a pixel to that of the next in its row.
        v: to that of the one below. Their lengths are the size of a pixel; they need not be at right angles.
        shape: rows and columns of pixels.
    """

    center: ArrayLike
    u: ArrayLike
    v: ArrayLike
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        vectors = [points(value, name).reshape(-1) for name, value in self._vectors().items()]
        if not all(vector.size == 3 and np.isfinite(vector).all() for vector in vectors):
            raise ValueError("center, u and v are three finite numbers each")
        if not np.cross(vectors[1], vectors[2]).any():
            raise ValueError("u and v lie in one line, so there is no plane of pixels")
        try:
            rows, columns = self.shape
        except (TypeError, ValueError):
            raise TypeError(f"shape is rows and columns, as in (300, 400), not {self.shape!r}") from None
        for size, what in ((rows, "the number of rows in shape"), (columns, "the number of columns in shape")):
            bounded_integer(size, what, 1, 2**31 - 1)

    def _vectors(self) -> dict[str, ArrayLike]:
        return {"center": self.center, "u": self.u, "v": self.v}

    @classmethod
    def facing(cls, source: ArrayLike, center: ArrayLike, *, pixel: float, shape: tuple[int, int]) -> Detector:
        """A detector of square pixels that faces a source. Its rows are perpendicular to z, or to y if the line from
        the source is along z."""
        axis = points(center, "center") - points(source, "source")
        if not np.isfinite(axis).all() or not axis.any():
            raise ValueError("the source is in the middle of the detector")
        right = np.cross(axis, [0.0, 0.0, 1.0])
        if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(axis):
            right = np.cross(axis, [0.0, 1.0, 0.0])
        down = np.cross(axis, right)
        pixel = number(pixel, "pixel")
        if not 0 < pixel < np.inf:
            raise ValueError(f"pixel is {pixel:g}, but must be a length above 0")
        u, v = (pixel * side / np.linalg.norm(side) for side in (right, down))
        return cls(center=center, u=u, v=v, shape=shape)

    def pixels(self) -> np.ndarray:
        """The centres of the pixels: (rows, columns, 3) float64, rows from the top."""
        centres, _ = self.parallel((0, 0, 1)).rays(0, self.shape[0] * self.shape[1])
        return centres.reshape(*self.shape, 3)

    def rays(self, source: ArrayLike, *, beam: str = "cone", scene: Scene | None = None) -> np.ndarray:
        """The rays of a radiograph, as queries take them: (rows, columns, 6) float64, origins and directions. All end at their
        pixel, which is at t = 1.

        Args:
            source, beam: as in `radiograph`.
            scene: with `beam="parallel"`, the rays start before everything bounded in it.

        >>> panel = Detector(center=(9, 0, 0), u=(0, 1, 0), v=(0, 0, -1), shape=(1, 1))
        >>> panel.rays([-9, 0, 0]).tolist()
        [[[-9.0, 0.0, 0.0, 18.0, 0.0, 0.0]]]
        """
        if beam == "parallel" and scene is None:
            raise ValueError('with beam="parallel" give scene=, before which the rays start')
        rays, t_max = _beam(scene, points(source, "source").reshape(-1), self, beam)
        origins, directions = rays(0, self.shape[0] * self.shape[1])
        vectors = np.broadcast_arrays(origins, directions * t_max)
        return np.concatenate(vectors, axis=-1).reshape(*self.shape, 6)

    def cone(self, source: ArrayLike) -> Cone:
        """The rays from a point to the pixels as a beam, for `shotline.dask.cast`; the detector is at t = 1."""
        return Cone(source=source, shape=self.shape, **self._vectors())

    def parallel(self, direction: ArrayLike) -> Parallel:
        """Rays in one direction that begin at the pixels, as a beam."""
        return Parallel(direction=direction, shape=self.shape, **self._vectors())


def radiograph(
    scene: Scene,
    source: ArrayLike,
    detector: Detector | Sequence[Detector],
    mu: Mapping[str, float] | ArrayLike | None = None,
    *,
    beam: str = "cone",
    overlaps: str = "error",
    quantity: str = "attenuation",
    threads: int = 0,
    progress: Any = None,
) -> np.ndarray:
    """The image of a source on a detector, through a scene.

    Each pixel takes one ray, to its centre. Not modelled: scattering, the extent of source and pixels, and the decrease
    with distance.

    Args:
        scene: its materials attenuate; an object without a material does not.
        source: with `beam="cone"` the origin of the beam, outside all objects; with `beam="parallel"` the direction
            of the beam. World coordinates. With several detectors of shape (3,) for all, or (views, 3).
        detector: the pixels; or a list of detectors of one shape, each for a view.
        mu: linear attenuation coefficients, one over world units. None takes those of the scene's materials, all of
            which must have one. A mapping by material name overrides some or all of them. An array is in the order of
            `scene.material_names`, with shape (materials,), or (materials, energies) for several at once.
        beam: "cone" or "parallel". A parallel beam starts before every bounded object.
        overlaps: as in `Scene.segments`.
        quantity: "attenuation" is the optical depth, the sum of mu times length; "transmission" is exp(-attenuation),
            the fraction of the beam that arrives; "thickness" is the length in each material, and in a last column in
            objects without one; it does not need mu.
        threads, progress: as in `Scene.closest`.

    Returns:
        (rows, columns) float64; with several energies (rows, columns, energies); for thickness (rows, columns,
        materials + 1). With several detectors the first axis is that of the views, as in (views, rows, columns).

    Raises:
        ValueError: for a material without mu, for a mu that is negative or not finite, for unknown material names, for
            a scene in which nothing has a material, and as in `Scene.segments`.

    >>> ball = Scene(Sphere(radius=1).named("ball", material="lead"), materials={"lead": {"mu": 0.7}})
    >>> plate = Detector.facing([-10, 0, 0], [10, 0, 0], pixel=0.5, shape=(3, 3))
    >>> radiograph(ball, [-10, 0, 0], plate)[1, 1].round(12)
    np.float64(1.4)
    >>> radiograph(ball, [-10, 0, 0], plate, {"lead": 0.5})[1, 1].round(12)
    np.float64(1.0)
    """
    if quantity not in ("attenuation", "transmission", "thickness"):
        raise ValueError(f'quantity is {quantity!r}, but must be "attenuation", "transmission" or "thickness"')
    if not isinstance(scene, Scene):
        raise TypeError(f"scene must be a Scene, not {type(scene).__name__}")
    several = isinstance(detector, (list, tuple)) and any(isinstance(panel, Detector) for panel in detector)
    given: Any = detector
    panels, sources = _views(source, [*given] if several else [given])
    coefficients = None if quantity == "thickness" else _coefficients(scene, mu)
    count = panels[0].shape[0] * panels[0].shape[1]
    tail = (len(scene.material_names) + 1,) if coefficients is None else coefficients.shape[1:]
    out = np.empty((len(panels), count, *tail))
    report = callback(progress)
    for view, (panel, origin) in enumerate(zip(panels, sources, strict=True)):
        rays, t_max = _beam(scene, origin, panel, beam)
        for start in range(0, count, _BLOCK):
            stop = min(start + _BLOCK, count)
            lengths = scene.thickness(
                *rays(start, stop),
                overlaps=overlaps,
                t_max=t_max,
                threads=threads,
                progress=_block_progress(report, view * count + start, len(panels) * count),
            )
            # The last column is for objects without a material, which do not attenuate.
            out[view, start:stop] = (
                lengths if coefficients is None else np.tensordot(lengths[:, :-1], coefficients, 1)
            )
    if quantity == "transmission":
        np.exp(-out, out=out)
    shaped = out.reshape(len(panels), *panels[0].shape, *tail)
    return shaped if several else shaped[0]


def _views(source: ArrayLike, detectors: list[Any]) -> tuple[list[Detector], np.ndarray]:
    """The detectors of one shape, and the source of each: (views, 3)."""
    for panel in detectors:
        if not isinstance(panel, Detector):
            hint = "Detector.facing makes one"
            raise TypeError(f"detector must be a Detector, not {type(panel).__name__}; {hint}")
    shapes = list(dict.fromkeys(tuple(panel.shape) for panel in detectors))
    if len(shapes) != 1:
        raise ValueError(f"several detectors must have one shape, not {shapes[0]} and {shapes[1]}")
    sources = points(source, "source")
    if sources.shape not in ((3,), (len(detectors), 3)):
        raise ValueError(
            f"source has shape (3,), or ({len(detectors)}, 3) with one for each detector, not {sources.shape}"
        )
    return detectors, np.broadcast_to(sources, (len(detectors), 3))


def _block_progress(report: ProgressCallback | None, before: int, total: int) -> ProgressCallback | None:
    """A callback of one block that reports the progress of all."""
    return None if report is None else lambda done, _: report(before + done, total)


def _beam(
    scene: Scene | None, source: np.ndarray, detector: Detector, beam: str
) -> tuple[Callable[[int, int], tuple[np.ndarray, np.ndarray]], float]:
    """The function that generates the rays of a range of pixels, and `t_max`: each ray ends at its pixel."""
    if source.size != 3 or not np.isfinite(source).all():
        raise ValueError("source is three finite numbers")
    if beam == "cone":
        return detector.cone(source).rays, 1.0
    if beam != "parallel":
        raise ValueError(f'beam is {beam!r}, but must be "cone" or "parallel"')
    if not source.any():
        raise ValueError("the direction of a parallel beam must not be zero, but source is")
    assert scene is not None
    direction = source / np.linalg.norm(source)
    panel = detector.parallel(direction)
    ends = [0, detector.shape[1] - 1, len(panel) - detector.shape[1], len(panel) - 1]
    corners = [*scene.bounds, *(panel.rays(end, end + 1)[0][0] for end in ends)]
    farthest = max(float(np.linalg.norm(np.where(np.isfinite(corner), corner, 0.0))) for corner in corners)
    # Rays start this far before their pixel, which is before every bounded object.
    reach = math.nextafter(4.0 * farthest, math.inf)

    def rays(start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        pixels, _ = panel.rays(start, stop)
        return pixels - direction * reach, direction

    return rays, reach


def _coefficients(scene: Scene, mu: Any) -> np.ndarray:
    names = scene.material_names
    if not names and scene.object_names:
        message = "the scene has no materials, so nothing attenuates: give its objects some"
        raise ValueError(f'{message}, or take quantity="thickness"')
    if mu is None or isinstance(mu, Mapping):
        mu = _by_name(scene, {} if mu is None else mu)
    array = floats(mu, "mu")
    if array.ndim not in (1, 2) or len(array) != len(names):
        raise ValueError(f"mu has a row for each of the {len(names)} materials, not shape {array.shape}")
    if not (np.isfinite(array) & (array >= 0)).all():
        raise ValueError("mu must be finite and not negative")
    return array


def _by_name(scene: Scene, mu: Mapping[str, Any]) -> list[Any]:
    """The coefficient of each material: the given one, or else its own."""
    own = dict(zip(scene.material_names, scene._native.attenuations(), strict=True))
    wrong = [f"there is none for {name!r}" for name, value in own.items() if value is None and name not in mu]
    wrong += [f"the scene has no material {name!r}" for name in mu if name not in own]
    if wrong:
        raise ValueError(f"mu: {'; '.join(wrong)}; give the materials mu=, or name all of them in mu")
    return [mu.get(name, value) for name, value in own.items()]
