"""Serializes scenes to the text of a scene file, the one form in which Python passes a scene to the native half.

A file can refer only to nodes in `defs`. So `defs` holds the nodes that have several parents, those that have a name,
and those at which deep nesting is split, since readers refuse deep nesting.
"""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Collection, Sequence
from operator import methodcaller
from typing import NamedTuple

from .mesh import Mesh
from .nodes import Node, Object, Part, Placed, encode, placed_object
from .plain_objects import plain_objects
from .post_order import post_order
from .solid import Solid
from .unnamed import Unnamed


class DuplicateNameWarning(UserWarning):
    """Different objects have the same name, so the name stands for all of them."""


# The depth of nested nodes at which the next is put into `defs`.
MAX_NESTING = 100


class Serialized(NamedTuple):
    """The parts and the objects of a scene, each as JSON, and the meshes, which they name by their index."""

    defs: dict[str, str]
    objects: list[str]
    meshes: list[Mesh]

    def members(self) -> str:
        """The members of the document for the parts and the objects."""
        defs = [f"{encode(name)}: {entry}" for name, entry in self.defs.items()]
        return f'"defs": {{{", ".join(defs)}}}, "objects": [{", ".join(self.objects)}]'


class Serializer:
    """Serializes the nodes of one scene."""

    def __init__(self, roots: Sequence[Node]) -> None:
        self.meshes: list[Mesh] = []
        self.defs: dict[str, str] = {}
        self.order, uses = post_order(roots, methodcaller("_children"))
        # By the id of a node, which is unique while the roots keep the nodes alive.
        self._shared = _shared(self.order, uses)
        self.objects: list[Object] = []
        # The text of a node without the brace that closes it, so that transforms can follow.
        self._serialized: dict[int, str] = {}
        # The depth of the nodes in a node, where it is not 1.
        self._depths: dict[int, int] = {}
        self._names: dict[str, Node] = {}
        self._used: dict[str, int] = {}
        for part in [node for node in self.order if type(node) is Part]:
            self._reserve(part._name, part)
        self._serialize_all()

    def of(self, node: Node) -> str:
        """The serialized root."""
        return self._take(id(node))

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
            if type(node) is Placed:
                child = id(node._child)
                serialized[key] = (serialized[child] if child in shared else serialized.pop(child)) + node._text()
                if child in depths:
                    depths[key] = depths[child]
                continue
            if isinstance(node, Solid):
                text, depth = node._text(), 1
            elif type(node) is Object and not node._contents:
                child = id(node._node)
                shape = serialized[child] if child in shared else serialized.pop(child)
                text, depth = f'{node._text()}, "node": {shape}}}', 1 + depths.get(child, 1)
                self.objects.append(node)
            else:
                text, depth = self._text_of(node)
            if type(node) is Part:
                text, depth = self._define(node._name, text), 0
            elif key in shared or depth > MAX_NESTING:
                text, depth = self._define(self._free_name(node), text), 0
            serialized[key] = text
            if depth != 1:
                depths[key] = depth

    def _text_of(self, node: Node) -> tuple[str, int]:
        """The text of a node with those of its children, and the depth of the nodes in it."""
        depths = self._depths
        if isinstance(node, Mesh):
            self.meshes.append(node)
            return f'{node._text()}, "file": "{len(self.meshes) - 1}"', 1
        children = [id(child) for child in node._children()]
        depth = 1 + max([depths.get(child, 1) for child in children])
        texts = [self._take(child) for child in children]
        if type(node) is Part:
            return texts[0][:-1], depth
        if type(node) is Unnamed:
            return f'{{"node": {texts[0]}', depth
        if isinstance(node, Object):
            self.objects.append(node)
            return f'{node._text()}, "node": {texts[0]}, "contents": [{", ".join(texts[1:])}]', depth
        return f'{node._text()}, "args": [{", ".join(texts)}]', depth

    def _take(self, key: int) -> str:
        """The text of a node that stands in another. It is dropped where it stands nowhere else: in deep scenes the texts of
        all nodes would be far longer than the whole."""
        return (self._serialized[key] if key in self._shared else self._serialized.pop(key)) + "}"

    def _define(self, name: str, text: str) -> str:
        self.defs.setdefault(name, text + "}")
        return f'{{"ref": {encode(name)}'


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


def _shared(post_order: Sequence[Node], uses: dict[int, int]) -> set[int]:
    """The ids of the nodes that the text refers to: those that it uses several times, and objects that are transformed. A
    transformed node is written out with each of its transforms, so its uses are those of the node in it."""
    shared = {key for key, count in uses.items() if count > 1}
    for node in [node for node in post_order if type(node) is Placed]:
        child = node._child
        if id(node) in shared or type(child) is Object:
            shared.add(id(child))
    return shared


def serialize(roots: Sequence[Node], materials: Collection[str], taken: Collection[str]) -> Serialized:
    """The parts and objects of a scene.

    `materials` are the names of those that the scene has, `taken` the names of objects that it has besides these.
    """
    objects = [_root_object(root) for root in roots]
    plain = plain_objects(objects)
    if plain is not None:
        made = Serialized({}, plain, [])
        named = [item for item in objects if isinstance(item, Object) and type(item) is not Unnamed]
    else:
        serializer = Serializer(objects)
        made = Serialized(serializer.defs, [serializer.of(root) for root in objects], serializer.meshes)
        named = serializer.objects
    # A transformed root stands for the object it transforms, which may be used elsewhere too.
    transformed = {id(item): root._object for item, root in zip(objects, roots, strict=True) if item is not root}
    if transformed:
        named = [transformed.get(id(node)) or node for node in named]
    _check_objects(named, materials, taken)
    return made


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
