"""Reads the nodes of a scene back from its text: the inverse of `serialize`."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import solids
from .lattices import HexagonalLattice, Lattice
from .mesh import Mesh
from .nodes import Difference, Group, Intersection, Node, Object, Part, Placed, Union
from .post_order import post_order
from .serialize import base_name

# In the order in which a scene file applies them.
STEPS = ("scale", "rotate", "translate", "transform")

_COMBINATIONS: dict[str, type[Union | Intersection | Difference | Group]] = {
    "union": Union,
    "intersection": Intersection,
    "difference": Difference,
    "group": Group,
}
_SOLIDS = {kind._kind: kind for kind in (getattr(solids, name) for name in solids.__all__)}

# Deeper than the text of any scene.
_MAX_DEPTH = 10_000


def parsed(text: str) -> dict[str, Any]:
    """The content of the text of a scene, as the native half writes it, nested as deep as it may be."""
    try:
        document: dict[str, Any] = json.loads(text)
    except RecursionError:
        limit = sys.getrecursionlimit()
        sys.setrecursionlimit(_MAX_DEPTH)
        try:
            document = json.loads(text)
        finally:
            sys.setrecursionlimit(limit)
    return document


class Reader:
    """The nodes of a parsed scene. What a scene file refers to several times is one node."""

    def __init__(self, document: dict[str, Any], meshes: Sequence[Mesh]) -> None:
        self._entries: list[dict[str, Any]] = document["objects"]
        self._defs: dict[str, dict[str, Any]] = document.get("defs", {})
        self._meshes = meshes
        # By the id of the part of the document that describes it: the node, and the same without its placement.
        self._nodes: dict[int, Node] = {}
        self._bare: dict[int, Node] = {}
        self._parts: dict[str, Node] = {}
        order, self._uses = post_order(self._entries, self._children)
        for entry in order:
            self._read(entry)

    def objects(self) -> list[Object]:
        """All objects, in the order of their numbers: each before its contents."""
        found: dict[int, Object] = {}
        stack = self._entries[::-1]
        seen: set[int] = set()
        while stack:
            entry = stack.pop()
            if id(entry) in seen:
                continue
            seen.add(id(entry))
            bare = self._bare[id(entry)]
            if "ref" not in entry and isinstance(bare, Object):
                found[id(bare)] = bare
            stack.extend(reversed(self._children(entry)))
        for entry in self._entries:
            self._place(entry, found)
        return list(found.values())

    def _place(self, entry: dict[str, Any], found: dict[int, Object]) -> None:
        """Moves an object at the top level to where it is, if it is there only once."""
        node = self._nodes[id(entry)]
        target = self._defs[entry["ref"]] if "ref" in entry else entry
        while "ref" in target and not _steps(target):
            target = self._defs[target["ref"]]
        bare = self._bare[id(target)]
        if isinstance(node, Placed) and isinstance(bare, Object) and self._uses[id(target)] == 1:
            found[id(bare)] = Object(node, bare.name)

    def _children(self, entry: dict[str, Any]) -> list[dict[str, Any]]:
        if "ref" in entry:
            return [self._defs[entry["ref"]]]
        children: list[dict[str, Any]] = entry.get("args", [])
        return [entry["node"], *entry.get("contents", [])] if "node" in entry else children

    def _read(self, entry: dict[str, Any]) -> None:
        parts = [self._nodes[id(child)] for child in self._children(entry)]
        if "ref" in entry:
            name = entry["ref"]
            bare = self._parts[name] = self._parts.get(name) or _named(parts[0], name)
        elif "node" in entry:
            keys = {key: entry.get(key) for key in ("material", "priority", "clip")}
            bare = Object(parts[0], entry["name"], contents=parts[1:], **keys)
        elif "op" in entry:
            bare = _operation(entry, parts)
        elif entry["kind"] == "mesh":
            bare = self._meshes[int(entry["file"])]
            if "accel" in entry:
                bare = Mesh._of_native(bare._native, entry["accel"])
        else:
            values = {key: value for key, value in entry.items() if key not in (*STEPS, "kind", "label")}
            bare = _SOLIDS[entry["kind"]](**values)
        steps = _steps(entry)
        self._bare[id(entry)] = bare
        self._nodes[id(entry)] = Placed(steps, bare) if steps else bare


def _named(node: Node, name: str) -> Node:
    """A node of `defs`: a part, if its name was not made from what it is."""
    base = base_name(node)
    return node if re.fullmatch(rf"({re.escape(base)}(_\d+)?|part\d+)", name) else Part(node, name)


def _steps(entry: dict[str, Any]) -> tuple[tuple[str, Any], ...]:
    """The transforms of an entry, innermost first."""
    steps: list[tuple[str, Any]] = []
    for name in STEPS:
        value = entry.get(name)
        if isinstance(value, dict):
            steps.append((name, {"axis": _floats(value["axis"]), "degrees": float(value["degrees"])}))
        elif value is not None:
            steps.append((name, _floats(value) if isinstance(value, list) else (float(value),) * 3))
    return tuple(steps)


def _floats(values: list[Any]) -> tuple[float, ...]:
    return tuple(map(float, values))


def _operation(entry: dict[str, Any], parts: list[Node]) -> Node:
    op = entry["op"]
    if op in _COMBINATIONS:
        return _COMBINATIONS[op](*parts, accel=entry.get("accel"))
    cells = entry.get("cells")
    table = None if cells is None else np.array([-1 if cell is None else cell for cell in cells], np.int64)
    if op == "hexagonal_lattice":
        keys = {key: entry[key] for key in ("rings", "pitch", "layers", "height")}
        return HexagonalLattice(parts, cells=table, **keys)
    counts = tuple(entry["counts"])
    shaped = None if table is None else table.reshape(counts, order="F")
    stagger = entry.get("stagger", False)
    return Lattice(parts, counts=counts, pitch=entry["pitch"], stagger=stagger, cells=shaped)
