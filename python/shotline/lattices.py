"""Lattices: copies of nodes in cells at equal distances."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .nodes import Group, Node, _checked, _short_repr
from .values import bounded_integer, number, numbers

# The largest number of cells.
MAX_CELLS = 2**31


class _Cells(Node):
    __slots__ = ("_cells", "_elements", "_object")
    _op = ""

    def __init__(self, elements: Node | Iterable[Node], cells: ArrayLike | None, shape: tuple[int, ...]) -> None:
        nodes = (elements,) if isinstance(elements, Node) else tuple(elements)
        if not nodes:
            raise ValueError(f"a {type(self).__name__} needs at least one node")
        self._elements: tuple[Node, ...] = tuple(_checked(node) for node in nodes)
        self._object = next((node._object for node in self._elements if node._object is not None), None)
        self._cells = None if cells is None else _table(cells, shape, len(nodes))

    def _keys(self) -> dict[str, Any]:
        return {"op": self._op} | self._numbers() | ({} if self._cells is None else {"cells": self._cells})

    def _numbers(self) -> dict[str, Any]:
        raise NotImplementedError

    def _cell_indices(self) -> np.ndarray | None:
        """The table of cells in the order of a scene file; -1 for an empty cell."""
        if self._cells is None:
            return None
        return np.array([-1 if index is None else index for index in self._cells], np.int64)

    def _children(self) -> tuple[Node, ...]:
        return self._elements

    def __repr__(self) -> str:
        shown = [_short_repr(node) for node in self._elements[:4]]
        more = [f"... {len(self._elements) - 4} more"] if len(self._elements) > 4 else []
        several = f"[{', '.join(shown + more)}]" if len(self._elements) > 1 else shown[0]
        numbers = [f"{key}={value}" for key, value in self._numbers().items()]
        numbers += [] if self._cells is None else [f"cells=<{len(self._cells)}>"]
        return f"{type(self).__name__}({', '.join([several, *numbers])})"


class Lattice(_Cells):
    """Copies of a node in rows, columns and layers: each is a body of its own, with its own path. A lattice of a billion
    cells takes no more memory than one of a single cell.

    Cell `[i, j, k]` is shifted by `i`, `j` and `k` times the pitch along x, y and z, so the first copy is where the node
    is. Members may be objects.

    Args:
        node: what every cell holds, or several nodes from which `cells` chooses.
        counts: the numbers of cells along x, y and z, 2^31 cells at most.
        pitch: the distances between neighbours along x, y and z, or one for all: positive where there are several cells.
        stagger: whether every second row is shifted by half a pitch along x. Where the pitch along y is the root of 3/4
            times that along x, each cell of a layer is then as far from its six neighbours.
        cells: for each cell the index of its node, or -1 for an empty cell: integers of shape `counts`.

    >>> Lattice(Cylinder(radius=0.4, z0=0, z1=10), counts=(17, 17, 1), pitch=1.26)
    Lattice(Cylinder(radius=0.4, z0=0.0, z1=10.0), counts=(17, 17, 1), pitch=(1.26, 1.26, 1.26))
    """

    __slots__ = ("_counts", "_pitch", "_stagger")
    _op = "lattice"

    def __init__(
        self,
        node: Node | Iterable[Node],
        *,
        counts: Iterable[int],
        pitch: ArrayLike,
        stagger: bool = False,
        cells: ArrayLike | None = None,
    ) -> None:
        if np.ndim(counts) != 1:  # type: ignore[arg-type]
            raise TypeError(f"counts are three numbers of cells, along x, y and z, as in (3, 3, 1), not {counts!r}")
        sizes = tuple(_size(count, "counts") for count in counts)
        if len(sizes) != 3:
            raise ValueError(f"counts are three numbers of cells, along x, y and z, not {len(sizes)}")
        same = np.ndim(pitch) == 0
        self._pitch = numbers(np.repeat(np.asarray(pitch), 3) if same else pitch, 3, "pitch")
        if not isinstance(stagger, (bool, np.bool_)):
            raise TypeError(f"stagger is True or False, not {stagger!r}")
        self._counts, self._stagger = sizes, bool(stagger)
        for count, distance in zip(sizes, self._pitch, strict=True):
            _check_distance(distance, count, "pitch")
        _check_count(sizes[0] * sizes[1] * sizes[2], "counts")
        super().__init__(node, cells, sizes)

    @property
    def counts(self) -> tuple[int, ...]:
        """The numbers of cells along x, y and z."""
        return self._counts

    @property
    def pitch(self) -> tuple[float, ...]:
        """The distances between neighbours along x, y and z."""
        return self._pitch

    @property
    def stagger(self) -> bool:
        """Whether every second row is shifted."""
        return self._stagger

    @property
    def cells(self) -> np.ndarray | None:
        """For each cell the index of its node, -1 for an empty one: int64 of shape `counts`; None if all hold the first."""
        indices = self._cell_indices()
        return None if indices is None else indices.reshape(self._counts, order="F")

    def _numbers(self) -> dict[str, Any]:
        stagger = {"stagger": True} if self._stagger else {}
        return {"counts": self._counts, "pitch": self._pitch} | stagger


class HexagonalLattice(_Cells):
    """Copies of a node in rings around the z axis, each as far from its six neighbours: the first ring is one cell, at the
    origin.

    Args:
        node: what every cell holds, or several nodes from which `cells` chooses.
        rings: the number of rings, with the cell in the middle.
        pitch: the distance between neighbours, two of which are along x.
        layers: the number of layers along z; the first is at the origin.
        height: the distance between layers.
        cells: for each cell the index of its node, or -1 for an empty cell: row by row from the lowest y upwards, each row
            along x; then the next layer.

    >>> HexagonalLattice(Sphere(radius=0.5), rings=9, pitch=1.2)
    HexagonalLattice(Sphere(radius=0.5), rings=9, pitch=1.2, layers=1, height=0.0)
    """

    __slots__ = ("_height", "_layers", "_pitch", "_rings")
    _op = "hexagonal_lattice"

    def __init__(
        self,
        node: Node | Iterable[Node],
        *,
        rings: int,
        pitch: float,
        layers: int = 1,
        height: float = 0.0,
        cells: ArrayLike | None = None,
    ) -> None:
        self._rings, self._layers = _size(rings, "rings"), _size(layers, "layers")
        self._pitch, self._height = number(pitch, "pitch"), number(height, "height")
        _check_distance(self._pitch, self._rings, "pitch")
        _check_distance(self._height, self._layers, "height")
        count = self._layers * (3 * self._rings * (self._rings - 1) + 1)
        _check_count(count, "rings and layers")
        super().__init__(node, cells, (count,))

    @property
    def rings(self) -> int:
        """The number of rings."""
        return self._rings

    @property
    def pitch(self) -> float:
        """The distance between neighbours."""
        return self._pitch

    @property
    def layers(self) -> int:
        """The number of layers."""
        return self._layers

    @property
    def height(self) -> float:
        """The distance between layers."""
        return self._height

    @property
    def cells(self) -> np.ndarray | None:
        """For each cell the index of its node, -1 for an empty one: (cells,) int64; None if all hold the first."""
        return self._cell_indices()

    def _numbers(self) -> dict[str, Any]:
        return {"rings": self._rings, "pitch": self._pitch, "layers": self._layers, "height": self._height}


def ring(node: Node, count: int, step: float | None = None) -> Group:
    """Copies of a node turned about the z axis, the first where the node is: each is a body of its own.

    Args:
        node: what is copied; it may be an object.
        count: the number of copies, 2^20 at most.
        step: the degrees from one to the next; None fills a whole turn.

    >>> Scene(ring(Sphere(radius=1).translate(5, 0, 0), 8)).count([-9, 0, 0], [1, 0, 0])
    array(4)
    """
    copies = bounded_integer(count, "count", 1, 2**20)
    (angle,) = (360.0 / copies,) if step is None else numbers(number(step, "step"), 1, "step")
    return Group(*(_checked(node).rotate(0, 0, i * angle) for i in range(copies)))


def _size(value: Any, what: str) -> int:
    """A number of cells along an axis."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{what} is a whole number, not {value!r}")
    return bounded_integer(value, what, 1, MAX_CELLS)


def _check_distance(distance: float, count: int, what: str) -> None:
    """Raises ValueError for a distance between neighbours that is not positive, or too large."""
    if count > 1 and not 0 < distance * count < np.inf:
        raise ValueError(
            f"{what} is {distance}, but must be positive where there are several cells, and the last at a finite distance"
        )


def _check_count(count: int, what: str) -> None:
    if count > MAX_CELLS:
        raise ValueError(f"{what} give {count} cells, but a lattice has at most {MAX_CELLS}; nest lattices instead")


def _table(cells: ArrayLike, shape: tuple[int, ...], nodes: int) -> list[int | None]:
    """The entries of a table in the order of a scene file, in which x runs fastest."""
    table = np.asarray(cells)
    if table.shape != shape or table.dtype.kind not in "iu":
        raise ValueError(f"cells are integers of shape {shape}, not {table.dtype} of shape {table.shape}")
    if table.size and not -1 <= int(table.min()) <= int(table.max()) < nodes:
        raise ValueError(
            f"cells are from 0 to {nodes - 1}, or -1 for an empty cell, not {table.min()} to {table.max()}"
        )
    return [None if index < 0 else index for index in table.ravel(order="F").tolist()]
