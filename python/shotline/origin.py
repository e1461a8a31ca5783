"""Where the columns of an answer come from: the names of the scene, and the rays."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from .rays import Rays


class NameSource(Protocol):
    """What knows the names that numbers in answers stand for: a scene, or `KeptNames`."""

    @property
    def object_names(self) -> list[str]: ...

    @property
    def material_names(self) -> list[str]: ...

    def surface_name(self, surface: int) -> str: ...

    def path_name(self, path: int) -> str: ...


class KeptNames:
    """The names of an answer that was unpickled: only those that occur in it, beside those of objects and materials."""

    def __init__(
        self, objects: list[str], materials: list[str], surfaces: dict[int, str], paths: dict[int, str]
    ) -> None:
        self.object_names, self.material_names = objects, materials
        self._surfaces, self._paths = surfaces, paths

    def surface_name(self, surface: int) -> str:
        return self._surfaces[surface]

    def path_name(self, path: int) -> str:
        return self._paths[path]


class RayOrigin(NamedTuple):
    """The rays of an answer, by reference."""

    rays: Rays

    def of(self, numbers: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """The origins and directions of some rays, or of all: (n, 3) each, or (3,) for one that all share."""
        origins, directions = self.rays.origins, self.rays.directions
        if directions is None:
            rows = _rows(origins, numbers)
            return rows[:, :3], rows[:, 3:]
        return _rows(origins, numbers), _rows(directions, numbers)


class BeamOrigin(NamedTuple):
    """The rays of an answer to a beam (see `shotline.beams`), which makes them again when they are needed."""

    beam: Any

    def of(self, numbers: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """As for `RayOrigin`."""
        if numbers is not None and not len(numbers):
            return np.empty((0, 3)), np.empty((0, 3))
        start, stop = (0, len(self.beam)) if numbers is None else (int(numbers.min()), int(numbers.max()) + 1)
        origins, directions = (np.asarray(vectors) for vectors in self.beam.rays(start, stop))
        within = None if numbers is None else numbers - start
        return _rows(origins, within), _rows(directions, within)


class Origin(NamedTuple):
    """Where an answer comes from."""

    names: NameSource
    # None for an answer that is not about rays.
    rays: RayOrigin | BeamOrigin | None
    # The shape of all rays, and the numbers, among them, of those that the answer has; None for all.
    shape: tuple[int, ...]
    numbers: np.ndarray | None = None

    @staticmethod
    def of(names: NameSource, rays: Rays) -> Origin:
        """The origin of the answer to a query of all rays."""
        return Origin(names, RayOrigin(rays), rays.shape)

    def select(self, chosen: np.ndarray) -> Origin:
        """The origin of the answer that is left if only these rays are kept; `chosen` has their shape."""
        flat = chosen.reshape(-1)
        return self._replace(shape=chosen.shape, numbers=flat if self.numbers is None else self.numbers[flat])

    def vectors(self, numbers: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """The origins and directions of rays, by their numbers in the answer; of all, in order, for None."""
        assert self.rays is not None
        if numbers is None or self.numbers is None:
            return self.rays.of(self.numbers if numbers is None else numbers)
        return self.rays.of(self.numbers[numbers])

    def without_scene(self, columns: dict[str, np.ndarray]) -> Origin:
        """The same for pickles: with only the names that occur in the columns, and only the rays of the answer."""
        kept = self._replace(names=_kept_names(self.names, columns))
        if self.numbers is None or not isinstance(self.rays, RayOrigin):
            return kept
        rays = Rays(self.shape, len(self.numbers), *self.rays.of(self.numbers))
        return kept._replace(rays=RayOrigin(rays), numbers=None)


def names_of(source: NameSource, kind: str, numbers: np.ndarray) -> np.ndarray:
    """The names of objects, materials, surfaces or paths: an array of str of the shape of `numbers`, with None for a
    negative number. Each name is looked up once."""
    distinct, positions = np.unique(numbers, return_inverse=True)
    table = np.empty(len(distinct), object)
    if kind in ("object", "material"):
        known = source.object_names if kind == "object" else source.material_names
        table[:] = [known[number] if number >= 0 else None for number in distinct.tolist()]
    else:
        name = source.surface_name if kind == "surface" else source.path_name
        table[:] = [name(number) if number >= 0 else None for number in distinct.tolist()]
    names = np.empty(numbers.shape, object)
    names[...] = table[positions.reshape(numbers.shape)]
    return names


def _kept_names(source: NameSource, columns: dict[str, np.ndarray]) -> KeptNames:
    """The names that occur in columns."""
    tables: dict[str, dict[int, str]] = {"surface": {}, "path": {}}
    for kind, table in tables.items():
        if kind in columns:
            numbers = np.unique(columns[kind])
            numbers = numbers[numbers >= 0]
            table |= dict(zip(numbers.tolist(), names_of(source, kind, numbers).tolist(), strict=True))
    return KeptNames(source.object_names, source.material_names, tables["surface"], tables["path"])


def _rows(vectors: np.ndarray, numbers: np.ndarray | None) -> np.ndarray:
    return vectors if vectors.ndim == 1 or numbers is None else vectors[numbers]
