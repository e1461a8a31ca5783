"""Slices: what owns each pixel of a plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .native_args import SliceSettings
from .values import choice, numbers, picture_size

BY = ("object", "material", "instance")


class Region(NamedTuple):
    """An object, a material or an instance that is on a slice."""

    number: int
    """The number of the object, the material or the path; -1 for what has no material."""
    name: str
    color: tuple[int, int, int]
    """sRGB from 0 to 255: that of the material if it has one, by material; else one that differs clearly from the others."""
    area: float
    """Its area in pixels."""


class Overlap(NamedTuple):
    """Two objects in conflict on a slice."""

    kind: str
    """"overlap": their priorities are equal, and neither is in the other. "protrusion": the first sticks out of the second,
    which contains and clips it."""
    first: int
    """The number of an object."""
    second: int
    """The number of the other; the same for two placements of one object."""
    pixels: int
    """The pixels whose middles are in both. There may be none in a thin overlap."""
    point: tuple[float, float, float]
    """A point in it, in world coordinates."""
    text: str
    """What is wrong, with both names."""


@dataclass(frozen=True, repr=False)
class Slice:
    """What owns each pixel of a plane. The arrays are (rows, columns); the rows are from the top, as in pictures."""

    object: np.ndarray
    """The number of the object that owns the middle of each pixel, int32; -1 where there is none."""
    material: np.ndarray
    """The number of its material, int32; -1 where there is none."""
    path: np.ndarray
    """The number of its instance path, int64; -1 where there is none."""
    overlap: np.ndarray
    """Where objects are in conflict the number of the pair, an index into `overlaps`, int32; -1 where none are."""
    area: tuple[float, float, float, float]
    """The lower left and the upper right corner (u0, v0, u1, v1), in world units along the axes."""
    origin: tuple[float, float, float]
    """The point of the plane at u = 0, v = 0."""
    u: tuple[float, float, float]
    """The axis to the right, of unit length."""
    v: tuple[float, float, float]
    """The axis upwards, of unit length."""
    axes: tuple[str, str]
    """The names of the axes: "x", "y" or "z" for those of the world, else "u" and "v"."""
    title: str
    """The plane as text."""
    by: str
    """What `regions` are: "object", "material" or "instance"."""
    regions: tuple[Region, ...]
    """What is on the slice, the largest first."""
    overlaps: tuple[Overlap, ...]
    """The objects of equal priority that overlap, and those that stick out of what contains and clips them."""

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(u0, u1, v0, v1), as `imshow` of matplotlib takes it."""
        u0, v0, u1, v1 = self.area
        return u0, u1, v0, v1

    @property
    def points(self) -> np.ndarray:
        """The middles of the pixels in world coordinates, (rows, columns, 3)."""
        rows, columns = self.object.shape
        u0, v0, u1, v1 = self.area
        along_u = u0 + (np.arange(columns) + 0.5) * ((u1 - u0) / columns)
        along_v = v1 - (np.arange(rows) + 0.5) * ((v1 - v0) / rows)
        along = along_u[None, :, None] * np.array(self.u) + along_v[:, None, None] * np.array(self.v)
        return np.asarray(np.array(self.origin) + along)

    @property
    def owner(self) -> np.ndarray:
        """The array that `regions` are the values of: `object`, `material` or `path`."""
        if self.by == "object":
            return self.object
        return self.material if self.by == "material" else self.path

    def colors(self) -> np.ndarray:
        """The slice as a picture, (rows, columns, 3) uint8: each region in its colour, and white where nothing is."""
        regions = sorted(self.regions)
        picture = np.full((*self.object.shape, 3), 255, np.uint8)
        if regions:
            table = np.array([region.color for region in regions], np.uint8)
            inside = self.object >= 0
            picture[inside] = table[np.searchsorted([region.number for region in regions], self.owner[inside])]
        return picture

    def __repr__(self) -> str:
        rows, columns = self.object.shape
        names = [region.name for region in self.regions]
        shown = ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")
        return f"<Slice {self.title}: {columns}x{rows} pixels by {self.by} ({shown})>"


def slice_of(
    scene: _native.Scene,
    plane: str | Sequence[float],
    size: tuple[int, int] | None,
    area: ArrayLike | None,
    by: str,
    threads: int,
    progress: Callable[[int, int], Any] | None,
) -> Slice:
    """See `Scene.slice`."""
    settings = SliceSettings(
        plane if isinstance(plane, str) else ",".join(map(repr, numbers(plane, 4, "plane"))),
        None if area is None else numbers(area, 4, "area"),
        None if size is None else picture_size(size),
        choice(by, "by", BY),
    )
    objects, materials, paths, overlap, frame, pairs, regions = _native.slice(scene, settings, threads, progress)
    corners, origin, u, v, axes, title = frame
    return Slice(
        objects,
        materials,
        paths,
        overlap,
        tuple(corners),
        tuple(origin),
        tuple(u),
        tuple(v),
        tuple(axes),
        title,
        settings.by,
        tuple(Region(number, name, tuple(color), pixels) for number, name, color, pixels in regions),
        tuple(Overlap(kind, a, b, pixels, tuple(at), words) for kind, a, b, pixels, at, words in pairs),
    )
