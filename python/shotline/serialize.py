"""Serializes scenes to the text of a scene file, the one form in which Python passes a scene to the native half.

A file can refer only to nodes in `defs`. So `defs` holds the nodes that have several parents, those that have a name,
and those at which deep nesting is split, since readers refuse deep nesting.
"""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Collection, Sequence
from operator import methodcaller
from typing import Any

from .mesh import Mesh
from .nodes import Node, Object, Part, Placed, _set, placed_object
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
        self.order, uses = post_order(roots, methodcaller("_children"))
        # By the id of a node, which is unique while the roots keep the nodes alive.
        self._shared = _shared(self.order, uses)
        self._serialized: dict[int, dict[str, Any]] = {}
        # The depth of the nodes in a node, where it is not 1.
        self._depths: dict[int, int] = {}
        self._names: dict[str, Node] = {}
        self._used: dict[str, int] = {}
        for node in self.order:
            if isinstance(node, Part):
                self._reserve(node._name, node)
        self._serialize_all()

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

    def _serialize_all(self) -> None:
        # Scenes have many nodes, and this is the one pass that makes something of each.
        serialized, depths, shared = self._serialized, self._depths, self._shared
        for node in self.order:
            key = id(node)
            if isinstance(node, Placed):
                child = id(node._child)
                # What is used only here need not be copied.
                keys = serialized[key] = dict(serialized[child]) if child in shared else serialized[child]
                node._add_placement(keys)
                if child in depths:
                    depths[key] = depths[child]
                continue
            keys, depth = self._keys_of(node)
            if isinstance(node, Part):
                keys, depth = self._define(node._name, keys), 0
            elif key in shared or depth > MAX_NESTING:
                keys, depth = self._define(self._free_name(node), keys), 0
            serialized[key] = keys
            if depth != 1:
                depths[key] = depth

    def _keys_of(self, node: Node) -> tuple[dict[str, Any], int]:
        """The keys of a node with those of its children, and the depth of the nodes in it."""
        if isinstance(node, Solid):
            return node._keys(), 1
        serialized, depths = self._serialized, self._depths
        if isinstance(node, Object) and not node._contents:
            keys, child = node._keys(), id(node._node)
            keys["node"] = serialized[child]
            return keys, 1 + depths.get(child, 1)
        if isinstance(node, Mesh):
            self.meshes.append(node)
            return node._keys() | {"file": str(len(self.meshes) - 1)}, 1
        children = [id(child) for child in node._children()]
        depth = 1 + max([depths.get(child, 1) for child in children])
        if isinstance(node, Part):
            return serialized[children[0]], depth
        keys = node._keys()
        if isinstance(node, Object):
            keys["node"] = serialized[children[0]]
            keys["contents"] = [serialized[child] for child in children[1:]]
        else:
            keys["args"] = [serialized[child] for child in children]
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
    placed = None if node._object is None else placed_object(node)
    if placed is None:
        return Unnamed(node)
    return node if placed[1].contents else Object(node, placed[1].name)


# What an object without a name has besides its node.
_UNNAMED = (("_name", ""), ("_material", None), ("_priority", 0), ("_contents", ()), ("_clip", False))


class Unnamed(Object):
    """An object without a name; readers name it by its number."""

    __slots__ = ()

    def __init__(self, node: Node) -> None:
        # `node` is not an object, so that nothing has to be checked or taken over.
        for name, value in _UNNAMED:
            _set(self, name, value)
        _set(self, "_node", node)

    def _keys(self) -> dict[str, Any]:
        return {}


def _shared(post_order: Sequence[Node], uses: dict[int, int]) -> set[int]:
    """The ids of the nodes that the text refers to: those that it uses several times, and objects that are transformed. A
    transformed node is written out with each of its transforms, so its uses are those of the node in it."""
    shared = {key for key, count in uses.items() if count > 1}
    for node in post_order:
        if isinstance(node, Placed) and (id(node) in shared or isinstance(node._child, Object)):
            shared.add(id(node._child))
    return shared


def serialize(
    roots: Sequence[Node], materials: Collection[str], taken: Collection[str]
) -> tuple[dict[str, Any], list[Mesh]]:
    """The parts and objects of a scene as in its text, and the meshes, which it names by their index.

    `materials` are the names of those that the scene has, `taken` the names of objects that it has besides these.
    """
    objects = [_root_object(root) for root in roots]
    serializer = Serializer(objects)
    # A transformed root stands for the object it transforms, which may be used elsewhere too.
    transformed = {id(made): root._object for made, root in zip(objects, roots, strict=True) if made is not root}
    named = [node for node in serializer.order if isinstance(node, Object) and not isinstance(node, Unnamed)]
    if transformed:
        named = [transformed.get(id(node)) or node for node in named]
    _check_objects(named, materials, taken)
    return {"defs": serializer.defs, "objects": [serializer.of(root) for root in objects]}, serializer.meshes


def _check_objects(objects: Sequence[Object], materials: Collection[str], taken: Collection[str]) -> None:
    """Raises ValueError for materials that the scene does not have; warns of names that several objects share."""
    first: dict[str, Object] = {}
    wrong: dict[str, None] = {}
    duplicates: dict[str, None] = {}
    for item in objects:
        name, material = item._name, item._material
        other = first.setdefault(name, item)
        if name in taken or (other is not item and other != item):
            duplicates[name] = None
        if material is not None and material not in materials:
            wrong[_unknown_material(name, material, list(materials))] = None
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
