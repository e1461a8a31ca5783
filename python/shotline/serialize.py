"""Serializes scenes to the text of a scene file, the one form in which Python passes a scene to the native half.

A file can refer only to nodes in `defs`. So `defs` holds the nodes that have several parents, those that have a name,
and those at which deep nesting is split, since readers refuse deep nesting.
"""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from .mesh import Mesh
from .nodes import Node, Object, Part, Placed, placed_object
from .post_order import post_order
from .solid import Solid


class DuplicateNameWarning(UserWarning):
    """Different objects have the same name, so the name stands for all of them."""


# The depth of nested nodes at which the next is put into `defs`.
MAX_NESTING = 100


class Serializer:
    """Serializes the nodes of one scene."""

    def __init__(self, roots: Sequence[Node]) -> None:
        self.meshes: list[Mesh] = []
        self.defs: dict[str, dict[str, Any]] = {}
        self.order = post_order(roots, lambda node: node._children())
        self._uses = _uses(roots, self.order)
        # A transform of an object refers to it.
        self._placed = {id(n._child) for n in self.order if isinstance(n, Placed) and isinstance(n._child, Object)}
        # By the id of a node, which is unique while the roots keep the nodes alive.
        self._serialized: dict[int, dict[str, Any]] = {}
        self._depth: dict[int, int] = {}
        self._names: dict[str, Node] = {}
        self._used: dict[str, int] = {}
        for node in self.order:
            if isinstance(node, Part):
                self._reserve(node._name, node)
        for node in self.order:
            self._serialize(node)

    def of(self, node: Node) -> dict[str, Any]:
        """The serialized root."""
        return self._serialized[id(node)]

    def _reserve(self, name: str, node: Node) -> None:
        other = self._names.setdefault(name, node)
        if _named_by(other) is not _named_by(node):
            raise ValueError(f"two parts are named {name!r}; a name stands for one part")

    def _free_name(self, node: Node) -> str:
        """A name for a node that needs one, after its kind, since it appears in the names of paths."""
        base = base_name(node)
        while True:
            count = self._used[base] = self._used.get(base, 0) + 1
            name = base if count == 1 else f"{base}_{count}"
            if name not in self._names:
                self._names[name] = node
                return name

    def _serialize(self, node: Node) -> None:
        if isinstance(node, Placed):
            child = id(node._child)
            keys, depth = self._serialized[child] | node._placement(), self._depth[child]
        else:
            children = node._children()
            if children:
                keys, depth = self._parent(node, children)
            else:
                keys, depth = node._keys(), 1
                if isinstance(node, Mesh):
                    keys["file"] = str(len(self.meshes))
                    self.meshes.append(node)
            if isinstance(node, Part):
                keys, depth = self._define(node._name, keys), 0
            elif self._uses[id(node)] > 1 or depth > MAX_NESTING or id(node) in self._placed:
                keys, depth = self._define(self._free_name(node), keys), 0
        self._serialized[id(node)], self._depth[id(node)] = keys, depth

    def _parent(self, node: Node, children: tuple[Node, ...]) -> tuple[dict[str, Any], int]:
        """The keys of a node that has children, and the depth of the nodes in it."""
        serialized = [self._serialized[id(child)] for child in children]
        depth = 1 + max([self._depth[id(child)] for child in children])
        if isinstance(node, Part):
            return serialized[0], depth
        keys = node._keys()
        if isinstance(node, Object):
            keys["node"] = serialized[0]
            if len(children) > 1:
                keys["contents"] = serialized[1:]
        else:
            keys["args"] = serialized
        return keys, depth

    def _define(self, name: str, keys: dict[str, Any]) -> dict[str, Any]:
        self.defs.setdefault(name, keys)
        return {"ref": name}


def _named_by(node: Node) -> Node:
    return node._child if isinstance(node, Part) else node


def base_name(node: Node) -> str:
    """What a node without a name of its own is called in the names of paths."""
    if isinstance(node, Object):
        return node.name
    return node._kind if isinstance(node, Solid) else type(node).__name__.lower()


def _root_object(node: Node) -> Node:
    """The object that a root of a scene becomes. A transformed object becomes an object of the transformed shape; one with
    contents stays as it is, so that the transform moves all of it."""
    if isinstance(node, Object):
        return node
    placed = placed_object(node)
    if placed is None:
        return Unnamed(node)
    return node if placed[1].contents else Object(node, placed[1].name)


class Unnamed(Object):
    """An object without a name; readers name it by its number."""

    __slots__ = ()

    def __init__(self, node: Node) -> None:
        # `node` is not an object, so that nothing has to be checked or taken over.
        unnamed = {"_name": "", "_material": None, "_priority": 0, "_contents": (), "_clip": False, "_node": node}
        for name, value in unnamed.items():
            object.__setattr__(self, name, value)

    def _keys(self) -> dict[str, Any]:
        return {}


def _uses(roots: Iterable[Node], post_order: Sequence[Node]) -> dict[int, int]:
    """How many times the text uses each node. A transformed node is written out with each of its transforms; any other
    node that is used several times is written once and referred to."""
    count: dict[int, int] = {}
    for root in roots:
        count[id(root)] = count.get(id(root), 0) + 1
    for node in reversed(post_order):
        children = node._children()
        if children:
            uses = count[id(node)] if isinstance(node, Placed) else 1
            for child in children:
                count[id(child)] = count.get(id(child), 0) + uses
    return count


def serialize(
    roots: Sequence[Node], materials: Collection[str], taken: Collection[str]
) -> tuple[dict[str, Any], list[Mesh]]:
    """The parts and objects of a scene as in its text, and the meshes, which it names by their index.

    `materials` are the names of those that the scene has, `taken` the names of objects that it has besides these.
    """
    objects = [_root_object(root) for root in roots]
    serializer = Serializer(objects)
    # A transformed root stands for the object it transforms, which may be used elsewhere too.
    transformed = {id(made): root._object for made, root in zip(objects, roots, strict=True)}
    named = [node for node in serializer.order if isinstance(node, Object) and not isinstance(node, Unnamed)]
    _check_objects([transformed.get(id(node)) or node for node in named], materials, taken)
    return {"defs": serializer.defs, "objects": [serializer.of(root) for root in objects]}, serializer.meshes


def _check_objects(objects: Sequence[Object], materials: Collection[str], taken: Collection[str]) -> None:
    """Raises ValueError for materials that the scene does not have; warns of names that several objects share."""
    first: dict[str, Object] = {}
    wrong: dict[str, None] = {}
    duplicates: dict[str, None] = {}
    for item in objects:
        other = first.setdefault(item.name, item)
        if item.name in taken or (other is not item and other != item):
            duplicates[item.name] = None
        if item.material is not None and item.material not in materials:
            wrong[_unknown_material(item.name, item.material, list(materials))] = None
    if wrong:
        raise ValueError("\n".join(wrong))
    if duplicates:
        names = ", ".join(map(repr, list(duplicates)[:5])) + (", ..." if len(duplicates) > 5 else "")
        message = f"several objects, which are not the same, are named {names}: the name stands for each of them"
        warnings.warn(message, DuplicateNameWarning, stacklevel=5)


def _unknown_material(name: str, material: str, known: list[str]) -> str:
    near = difflib.get_close_matches(material, known, n=1)
    if near:
        hint = f"did you mean {near[0]!r}?"
    elif known:
        hint = f"its materials are {', '.join(map(repr, known[:10]))}{', ...' if len(known) > 10 else ''}"
    else:
        hint = f"give the scene materials={{{material!r}: ...}}"
    return f"the object {name!r} has the material {material!r}, which the scene does not have; {hint}"
