"""Scenes as the words of a scene file: the one way in which Python hands a scene over.

A file can name a part only where it is defined, in `defs`. So that is where parts go that stand in several places, that
have a name, or in which a deep nest is broken, since readers refuse deep ones.
"""

from __future__ import annotations

import difflib
import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .mesh import Mesh
from .nodes import Node, Object, Part, Placed, Solid, placed_object


class DuplicateNameWarning(UserWarning):
    """Objects that are not the same have one name, so that the name stands for all of them."""


# Nodes within nodes before the next is put into `defs`.
NESTED = 100


class Writer:
    """The nodes of one scene on their way to text."""

    def __init__(self, roots: Sequence[Node]) -> None:
        self.meshes: list[Mesh] = []
        self.defs: dict[str, dict[str, Any]] = {}
        self.order = _inner_first(roots)
        self._places = _places(roots, self.order)
        # An object is placed by a reference to it.
        self._placed = {id(n._child) for n in self.order if isinstance(n, Placed) and isinstance(n._child, Object)}
        # By the number of a node; nodes live as long as the roots do.
        self._written: dict[int, dict[str, Any]] = {}
        self._depth: dict[int, int] = {}
        self._names: dict[str, Node] = {}
        self._used: dict[str, int] = {}
        for node in self.order:
            if isinstance(node, Part):
                self._take(node._name, node)
        for node in self.order:
            self._write(node)

    def of(self, node: Node) -> dict[str, Any]:
        """The words of a root."""
        return self._written[id(node)]

    def _take(self, name: str, node: Node) -> None:
        other = self._names.setdefault(name, node)
        if _named_by(other) is not _named_by(node):
            raise ValueError(f"two parts are named {name!r}; a name stands for one part")

    def _free_name(self, node: Node) -> str:
        """A name for a part that needs one: after what it is, since it will show in the names of paths."""
        word = _word(node)
        while True:
            count = self._used[word] = self._used.get(word, 0) + 1
            name = word if count == 1 else f"{word}_{count}"
            if name not in self._names:
                self._names[name] = node
                return name

    def _write(self, node: Node) -> None:
        children = [self._written[id(child)] for child in node._children()]
        depth = 1 + max((self._depth[id(child)] for child in node._children()), default=0)
        keys = node._keys()
        if isinstance(node, Mesh):
            keys["file"] = str(len(self.meshes))
            self.meshes.append(node)
        elif isinstance(node, Placed):
            keys, depth = children[0] | node._placement(), depth - 1
        elif isinstance(node, Part):
            keys = children[0]
        elif isinstance(node, Object):
            keys["node"] = children[0]
        elif children:
            keys["args"] = children
        if isinstance(node, Part):
            keys, depth = self._define(node._name, keys), 0
        elif not isinstance(node, Placed) and (
            self._places[id(node)] > 1 or depth > NESTED or id(node) in self._placed
        ):
            keys, depth = self._define(self._free_name(node), keys), 0
        self._written[id(node)], self._depth[id(node)] = keys, depth

    def _define(self, name: str, keys: dict[str, Any]) -> dict[str, Any]:
        self.defs.setdefault(name, keys)
        return {"ref": name}


def _named_by(node: Node) -> Node:
    return node._child if isinstance(node, Part) else node


def _word(node: Node) -> str:
    if isinstance(node, Object):
        return node.name
    return node._kind if isinstance(node, Solid) else type(node).__name__.lower()


def _rooted(node: Node) -> Object:
    """The object that a root of a scene becomes: one that is placed is an object of a placed shape."""
    if isinstance(node, Object):
        return node
    placed = placed_object(node)
    return Unnamed(node) if placed is None else Object(node, placed[1].name)


class Unnamed(Object):
    """An object that readers name by its number."""

    __slots__ = ()

    def __init__(self, node: Node) -> None:
        super().__init__(node, "")

    def _keys(self) -> dict[str, Any]:
        return {}


def _inner_first(roots: Iterable[Node]) -> list[Node]:
    """Every node once, its children before it. Without recursion: scenes may be deep."""
    order: list[Node] = []
    seen: set[int] = set()
    stack = [(root, False) for root in roots][::-1]
    while stack:
        node, opened = stack.pop()
        if opened:
            order.append(node)
        elif id(node) not in seen:
            seen.add(id(node))
            stack.append((node, True))
            stack.extend((child, False) for child in reversed(node._children()))
    return order


def _places(roots: Iterable[Node], inner_first: Sequence[Node]) -> dict[int, int]:
    """In how many places of the text each node stands. What is placed is written out with its placement, wherever that
    is; everything else that has several places is written once and referred to."""
    count: dict[int, int] = {}
    for root in roots:
        count[id(root)] = count.get(id(root), 0) + 1
    for node in reversed(inner_first):
        places = count[id(node)] if isinstance(node, Placed) else 1
        for child in node._children():
            count[id(child)] = count.get(id(child), 0) + places
    return count


def write(
    roots: Sequence[Node],
    materials: dict[str, dict[str, Any]],
    camera: dict[str, Any] | None,
    lights: list[dict[str, Any]],
    units: str | None,
    accel: str | None,
) -> tuple[str, list[Mesh]]:
    """The text of a scene, and the meshes it names by their numbers."""
    objects = [_rooted(root) for root in roots]
    writer = Writer(objects)
    # Roots that are placed stand for the object that they place: it may be placed elsewhere too.
    placed = {id(made): root._object for made, root in zip(objects, roots, strict=True)}
    named = [node for node in writer.order if isinstance(node, Object) and not isinstance(node, Unnamed)]
    _check_objects([placed.get(id(node)) or node for node in named], materials)
    document: dict[str, Any] = {"shotline": 1}
    parts = {"units": units, "defs": writer.defs, "accel": accel, "materials": materials, "camera": camera}
    document |= {key: value for key, value in parts.items() if value}
    document["objects"] = [writer.of(root) for root in objects]
    if lights:
        document["lights"] = lights
    return json.dumps(document, allow_nan=False), writer.meshes


def _check_objects(objects: Sequence[Object], materials: Mapping[str, Any]) -> None:
    """Raises ValueError for materials that the scene does not have; warns of names that stand for several objects."""
    first: dict[str, Object] = {}
    wrong: dict[str, None] = {}
    twice: dict[str, None] = {}
    for item in objects:
        other = first.setdefault(item.name, item)
        if other is not item and other != item:
            twice[item.name] = None
        if item.material is not None and item.material not in materials:
            wrong[_unknown_material(item.name, item.material, list(materials))] = None
    if wrong:
        raise ValueError("\n".join(wrong))
    if twice:
        names = ", ".join(map(repr, list(twice)[:5])) + (", ..." if len(twice) > 5 else "")
        message = f"several objects, which are not the same, are named {names}: the name stands for each of them"
        warnings.warn(message, DuplicateNameWarning, stacklevel=4)


def _unknown_material(name: str, material: str, known: list[str]) -> str:
    near = difflib.get_close_matches(material, known, n=1)
    if near:
        hint = f"did you mean {near[0]!r}?"
    elif known:
        hint = f"its materials are {', '.join(map(repr, known[:10]))}{', ...' if len(known) > 10 else ''}"
    else:
        hint = f"give the scene materials={{{material!r}: ...}}"
    return f"the object {name!r} has the material {material!r}, which the scene does not have; {hint}"
