"""The arguments that the Python half passes to the native half, which reads the fields by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

Vector = tuple[float, float, float]


class RayQuery(NamedTuple):
    """A query over many rays."""

    ray_count: int
    # (n, 3), or (3,) for one that all rays share; (n, 6) if `directions` is None.
    origins: np.ndarray
    directions: np.ndarray | None
    t_min: float
    t_max: float
    surfaces_only: bool
    threads: int
    progress: Callable[[int, int], Any] | None
    # The columns of `closest` and `crossings` that are needed; None for all.
    fields: list[str] | None


class PictureSettings(NamedTuple):
    """The settings of a picture."""

    width: int
    height: int
    samples: int
    look: str
    lighting: str
    counter: str
    background: str | None
    edges: bool
    clip: list[str]
    hatch: bool
    hide: list[str]
    only: list[str]
    opacity: list[tuple[str, float]]
    # The name of a standard view.
    view: str | None


class View(NamedTuple):
    """The camera of a picture; either `fov` or `height` is None."""

    eye: Vector
    target: Vector
    up: Vector
    fov: float | None
    height: float | None


class MeasureSettings(NamedTuple):
    """How to measure objects."""

    rays: int
    seed: int
    closed_forms: bool
    overlaps: str
    objects: Sequence[int] | None


class HitRows(NamedTuple):
    """Hits as columns: points (n, 3), and of each its surface, its triangle and its path."""

    points: np.ndarray
    surfaces: np.ndarray
    primitives: np.ndarray
    paths: np.ndarray


class SliceSettings(NamedTuple):
    """What is sliced."""

    plane: str
    area: tuple[float, ...] | None
    size: tuple[int, int] | None
    by: str
