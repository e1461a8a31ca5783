"""Joins the results of blocks of rays, which arrive in any order."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .columns import Columns
from .origin import Origin
from .results import Closest


class RowResults:
    """Results with one row for each ray."""

    def __init__(self, count: int, shape: tuple[int, ...], query: str, origin: Origin) -> None:
        if math.prod(shape) != count:
            raise ValueError(f"the shape of the beam, {shape}, does not hold its {count} rays")
        self.count, self.shape, self.query, self.origin = count, shape, query, origin
        self.columns: list[np.ndarray] = []

    def put(self, number: int, start: int, columns: list[np.ndarray]) -> None:
        if not self.columns:
            self.columns = [np.empty((self.count, *new.shape[1:]), new.dtype) for new in columns]
        for column, new in zip(self.columns, columns, strict=True):
            column[start : start + len(new)] = new

    def finish(self) -> Any:
        columns = [column.reshape(self.shape + column.shape[1:]) for column in self.columns]
        return Closest._of(columns, self.origin) if self.query == "closest" else columns[0]


class RaggedResults:
    """Results with any number of rows for each ray, joined at the end."""

    def __init__(self, table: type[Columns], origin: Origin) -> None:
        self.table, self.origin = table, origin
        self.blocks: dict[int, list[np.ndarray]] = {}

    def put(self, number: int, start: int, columns: list[np.ndarray]) -> None:
        self.blocks[number] = columns

    def finish(self) -> Any:
        splits, *columns = zip(*(self.blocks.pop(number) for number in sorted(self.blocks)), strict=True)
        rows = np.cumsum([0, *(block[-1] for block in splits)])
        shifted = [block[1:] + before for block, before in zip(splits, rows, strict=False)]
        joined = np.concatenate([splits[0][:1], *shifted])
        return self.table._of((joined, *map(np.concatenate, columns)), self.origin)


class Reduction:
    """The values of `reduce`, combined in the order of the blocks as soon as possible."""

    def __init__(self, combine: Callable[[Any, Any], Any]) -> None:
        self.combine, self.total = combine, None
        self.next = 0
        self.waiting: dict[int, Any] = {}

    def put(self, number: int, start: int, value: Any) -> None:
        self.waiting[number] = value
        while self.next in self.waiting:
            value = self.waiting.pop(self.next)
            self.total = self.combine(self.total, value) if self.next else value
            self.next += 1

    def finish(self) -> Any:
        return self.total
