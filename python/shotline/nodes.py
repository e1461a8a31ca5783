"""The nodes of scenes. They are immutable, so a node may have several parents; it is then shared and compiled once."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from .accelerators import accelerator
from .node_digest import digest
from .values import (
    affine,
    bounded_integer,
    floats,
    material_name,
    no_attribute,
    number,
    numbers,
    text,
    three,
)

Vector = tuple[float, float, float]

# Encode what is not encoded by hand; and strings in the same way, but much faster.
encode = json.JSONEncoder(allow_nan=False).encode
encode_text = json.encoder.encode_basestring_ascii

# Sets an attribute of a node during construction, without the check of `Node.__setattr__`.
_set = object.__setattr__


class Node:
    """A node of a scene, in its own coordinates: a solid, a mesh, a combination, a group, or a transformed node.

    `a | b`, `a & b` and `a - b` combine; `translate`, `rotate`, `scale` and `transform` transform, and `part` and
    `named` give names. They can be chained in any order and number: each applies to the result so far. None of them
    changes the node itself; each returns a new one.

    Nodes constructed in the same way from equal numbers are equal and have equal hashes. A scene still has two nodes
    then; only the identical node is shared and compiled once.
    """

    # The digest is computed on first use.
    __slots__ = ("_digest",)
    _digest: bytes

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise AttributeError(f"a {type(self).__name__} cannot be changed: make another one with another {name}")
        object.__setattr__(self, name, value)

    if not TYPE_CHECKING:  # type checkers would accept every name

        def __getattr__(self, name: str) -> Any:
            raise AttributeError(no_attribute(type(self).__name__, name))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Node):
            return NotImplemented
        return self is other or digest(self) == digest(other)

    def __hash__(self) -> int:
        return hash(digest(self))

    def __or__(self, other: Node) -> Union:
        return Union(*_chain(Union, self, other)) if isinstance(other, Node) else NotImplemented

    def __and__(self, other: Node) -> Intersection:
        return Intersection(*_chain(Intersection, self, other)) if isinstance(other, Node) else NotImplemented

    def __sub__(self, other: Node) -> Difference:
        return Difference(*_chain(Difference, self, other)) if isinstance(other, Node) else NotImplemented

    def translate(self, *offset: Any) -> Placed:
        """Move by an offset, given as three numbers or as one vector.

        >>> Sphere(radius=1).translate(0, 0, 5)
        Sphere(radius=1.0).translate(0.0, 0.0, 5.0)
        """
        return Placed((("translate", three(offset, "translate")),), self)

    def rotate(self, *angles: Any, axis: ArrayLike | None = None, degrees: float | None = None) -> Placed:
        """Rotate by angles in degrees about x, then y, then z; or with `axis` and `degrees` about an axis through the
        origin, counter-clockwise seen from its tip. Quarter turns are exact."""
        if axis is None and degrees is None:
            if len(angles) == 2 or (len(angles) == 1 and np.ndim(angles[0]) == 0):
                raise ValueError(
                    "rotate takes three angles, about x, y and z; about an axis it is rotate(axis=(x, y, z), degrees=angle)"
                )
            return Placed((("rotate", three(angles, "rotate")),), self)
        if angles or axis is None or degrees is None:
            raise ValueError("rotate takes three angles, or axis= and degrees= together")
        direction = numbers(axis, 3, "axis")
        if not any(direction):
            raise ValueError("the axis has no direction")
        (angle,) = numbers(number(degrees, "degrees"), 1, "degrees")
        return Placed((("rotate", {"axis": direction, "degrees": angle}),), self)

    def scale(self, *factors: Any) -> Placed:
        """Scale about the origin, by one factor or by three along the axes. A negative factor reflects; zero is
        refused."""
        given = factors[0] if len(factors) == 1 else factors
        values = floats(given, "scale", "a real number or three").reshape(-1)
        if values.size not in (1, 3):
            raise ValueError(f"scale takes one factor or three, not {values.size}")
        factors = numbers(np.repeat(values, 3) if values.size == 1 else values, 3, "scale")
        if 0.0 in factors:
            raise ValueError(f"scale is {list(factors)}, but no factor may be zero")
        return Placed((("scale", factors),), self)

    def transform(self, matrix: ArrayLike) -> Placed:
        """Apply an affine map, of shape (3, 4), (4, 4) or (12,): the parent's coordinates from the node's own. The last
        row of a 4x4 matrix must be 0, 0, 0, 1.

        Raises ValueError for a matrix that is singular, or so nearly singular that hardly any digits would remain.
        """
        return Placed((("transform", affine(matrix)),), self)

    def part(self, name: str) -> Part:
        """Give a shared node a name, which appears in the names of paths, as in `arm[2]/bolt`."""
        return Part(self, name)

    def named(
        self,
        name: str,
        material: str | None = None,
        priority: int | None = None,
        *,
        contents: Iterable[Node] = (),
        clip: bool | None = None,
    ) -> Object:
        """Make an object of this node: see `Object`."""
        return Object(self, name, material, priority, contents=contents, clip=clip)

    @property
    def children(self) -> tuple[Node, ...]:
        """The nodes that it is made of: operands, members, the node that is transformed or named; of an object its shape,
        then its contents."""
        return self._children()

    # The keys of the node in a scene file, without its children.
    def _keys(self) -> dict[str, Any]:
        return {}

    # The same as text, without the brace that closes it.
    def _text(self) -> str:
        return encode(self._keys())[:-1]

    # The nodes that it is made of.
    def _children(self) -> tuple[Node, ...]:
        return ()

    # The properties that determine the node besides its children, for equality.
    def _own(self) -> Any:
        return self._keys()

    # The first object in the node, or None. A node that contains an object cannot be an operand.
    _object: Object | None = None


def _checked(node: Any) -> Node:
    if not isinstance(node, Node):
        raise TypeError(f"a node of a scene is expected, not {type(node).__name__}")
    return node


def _short_repr(node: Node) -> str:
    """A short representation of a node, also of a large one."""
    return repr(node) if not node._children() or isinstance(node, (Placed, Part)) else f"<{type(node).__name__}>"


class _NodeList(Node):
    __slots__ = ("_accel", "_args", "_object")
    _op = ""

    def __init__(self, *args: Node | Iterable[Node], accel: str | None = None) -> None:
        if len(args) == 1 and not isinstance(args[0], Node):
            args = tuple(args[0])
        if not args:
            raise ValueError(f"{type(self).__name__} needs at least one part")
        self._args: tuple[Node, ...] = tuple(_checked(arg) for arg in args)
        self._object = next((arg._object for arg in self._args if arg._object is not None), None)
        self._accel = accelerator(accel)

    def _keys(self) -> dict[str, Any]:
        return {"op": self._op} | ({"accel": self._accel} if self._accel else {})

    def _children(self) -> tuple[Node, ...]:
        return self._args

    def __repr__(self) -> str:
        shown = [_short_repr(arg) for arg in self._args[:4]]
        more = [f"... {len(self._args) - 4} more"] if len(self._args) > 4 else []
        accel = [] if self._accel is None else [f"accel={self._accel!r}"]
        return f"{type(self).__name__}({', '.join(shown + more + accel)})"


class _Combination(_NodeList):
    __slots__ = ()

    def __init__(self, *args: Node | Iterable[Node], accel: str | None = None) -> None:
        super().__init__(*args, accel=accel)
        if self._object is not None:
            what, name = type(self).__name__, self._object.name
            message = f"the object {name!r} cannot be an operand of a {what}: objects stand in scenes and groups"
            raise ValueError(f"{message}; combine shapes (object.node) and name the result")


class Union(_Combination):
    """All points in any of the operands: `a | b`. Operands with a common face leave no seam.

    `accel` names an accelerator for this combination; no result depends on it.
    """

    __slots__ = ()
    _op = "union"


class Intersection(_Combination):
    """All points in each of the operands: `a & b`."""

    __slots__ = ()
    _op = "intersection"


class Difference(_Combination):
    """All points in the first operand and in none of the others: `a - b`."""

    __slots__ = ()
    _op = "difference"


class Group(_NodeList):
    """A collection of nodes without boolean meaning: each is a body of its own, with its own path and its own list of
    crossings. As an operand of a combination, a group counts as the union of its members.

    Members may be objects (a volume with its contents). `accel` matters only for a group with several instances.
    """

    __slots__ = ()
    _op = "group"


def _chain(kind: type[_NodeList], left: Node, right: Node) -> tuple[Node, ...]:
    """The operands of a combination. A chain such as ((a - b) - c) - d becomes one operation with many operands."""
    if type(left) is kind and isinstance(left, _NodeList) and left._accel is None:
        return (*left._args, right)
    return (left, right)


class Placed(Node):
    """A transformed node: what `translate`, `rotate`, `scale` and `transform` return."""

    __slots__ = ("_child", "_object", "_steps")
    _child: Node
    _steps: tuple[tuple[str, Any], ...]

    def __init__(self, steps: tuple[tuple[str, Any], ...], child: Node) -> None:
        # The innermost step is the first. Nested transforms are merged, so that the matrix is rounded once.
        if isinstance(child, Placed):
            steps, child = (*child._steps, *steps), child._child
        # Scenes have many of these.
        _set(self, "_steps", steps)
        _set(self, "_child", child)
        _set(self, "_object", child._object)
        for name, _ in steps:
            if name == "scale" or name == "transform":
                _native.compose(list(steps))  # refuses what has no inverse
                break

    @property
    def node(self) -> Node:
        """The node that is transformed."""
        return self._child

    @property
    def steps(self) -> tuple[tuple[str, Any], ...]:
        """The transforms, the first to be applied first: the name of the method, and its numbers."""
        return self._steps

    @property
    def matrix(self) -> np.ndarray:
        """All transforms as one affine map of shape (3, 4), float64: composed in double-double arithmetic and rounded
        once."""
        return np.array(self._matrix()).reshape(3, 4)

    def _matrix(self) -> tuple[float, ...]:
        return tuple(_native.compose(list(self._steps)))

    def _text(self) -> str:
        """The keys of the transforms, which follow those of the node."""
        steps = self._steps
        if len(steps) > 1:
            names = [name for name, _ in steps]
            if [name for name in ("scale", "rotate", "translate") if name in names] != names:
                steps = (("transform", self._matrix()),)
        text = ""
        for name, value in steps:
            # A tuple of numbers is longer to encode than to print as a list.
            text += f', "{name}": {list(value) if type(value) is tuple else encode(value)}'
        return text

    def _children(self) -> tuple[Node, ...]:
        return (self._child,)

    def _own(self) -> Any:
        return self._steps

    def __repr__(self) -> str:
        shown = _short_repr(self._child)
        for name, value in self._steps:
            if isinstance(value, dict):
                shown += f".{name}(axis={value['axis']}, degrees={value['degrees']})"
            elif name == "transform":
                shown += f".transform({list(value)})"
            else:
                shown += f".{name}({', '.join(map(str, value))})"
        return shown


class Part(Node):
    """A named node: see `Node.part`."""

    __slots__ = ("_child", "_name", "_object")

    def __init__(self, node: Node, name: str) -> None:
        self._child, self._name = _checked(node), text(name, "the name of a part")
        self._object = node._object

    @property
    def node(self) -> Node:
        """The node that is named."""
        return self._child

    @property
    def name(self) -> str:
        """The name."""
        return self._name

    def _children(self) -> tuple[Node, ...]:
        return (self._child,)

    def _own(self) -> Any:
        return self._name

    def __repr__(self) -> str:
        return f"{_short_repr(self._child)}.part({self._name!r})"


class Object(Node):
    """A shape with a name, a material and a priority: what hits and segments refer to.

    Where objects overlap, the one of higher priority owns the segment; the priority is 0 if not given. Scenes and
    groups contain objects, combinations do not.

    `contents` are objects, and groups of them, that are inside this one, in its coordinates. They are transformed with it,
    and displace it where they are, without a higher priority. With `clip` they count only inside its shape: what sticks
    out does not exist for segments, and is reported by `shotline check`.

    An object of an object, even if that was transformed in between, is the same shape at the same position under the
    new name, with the same contents and those given; it keeps material, priority and clip if none are given.

    >>> bolt = Sphere(radius=1).named("bolt", material="steel").translate(5, 0, 0).named("left bolt")
    >>> bolt.name, bolt.material, bolt.node
    ('left bolt', 'steel', Sphere(radius=1.0).translate(5.0, 0.0, 0.0))
    >>> fuel = Sphere(radius=1).named("fuel")
    >>> Sphere(radius=2).named("shell", contents=[fuel]).contents
    (Sphere(radius=1.0).named('fuel'),)
    """

    __slots__ = ("_clip", "_contents", "_material", "_name", "_node", "_priority")
    _name: str
    _node: Node
    _contents: tuple[Node, ...]
    _clip: bool
    _material: str | None
    _priority: int

    def __init__(
        self,
        node: Node,
        name: str,
        material: str | None = None,
        priority: int | None = None,
        *,
        contents: Iterable[Node] = (),
        clip: bool | None = None,
    ) -> None:
        name = text(name, "the name of an object")
        inside: tuple[Node, ...] = ()
        if type(contents) is not tuple or contents:
            parts = [contents] if isinstance(contents, Node) else contents
            inside = tuple([_content(part, name) for part in parts])
        if material is not None:
            material = material_name(material)
        if priority is not None:
            priority = bounded_integer(priority, "priority", -(2**31), 2**31 - 1)
        if _checked(node)._object is not None and (placed := placed_object(node)) is not None:
            steps, inner = placed
            node = Placed(steps, inner.node) if steps else inner.node
            moved = (Placed(steps, part) if steps else part for part in inner.contents)
            inside = (*moved, *inside)
            clip = inner.clip if clip is None else clip
            material = inner.material if material is None else material
            priority = inner.priority if priority is None else priority
        # Scenes have many of these.
        _set(self, "_name", name)
        _set(self, "_node", node)
        _set(self, "_contents", inside)
        _set(self, "_clip", bool(clip))
        _set(self, "_material", material)
        _set(self, "_priority", priority or 0)

    @property
    def name(self) -> str:
        """The name."""
        return self._name

    @property
    def material(self) -> str | None:
        """The name of its material."""
        return self._material

    @property
    def priority(self) -> int:
        """The priority."""
        return self._priority

    @property
    def node(self) -> Node:
        """Its shape."""
        return self._node

    @property
    def contents(self) -> tuple[Node, ...]:
        """The objects, and groups of them, that are inside it."""
        return self._contents

    @property
    def clip(self) -> bool:
        """Whether its contents count only inside its shape."""
        return self._clip

    def _keys(self) -> dict[str, Any]:
        keys: dict[str, Any] = {"name": self._name}
        if self._material is not None:
            keys["material"] = self._material
        if self._priority:
            keys["priority"] = self._priority
        if self._clip:
            keys["clip"] = True
        return keys

    def _text(self) -> str:
        if self._material is None and not self._priority and not self._clip:
            return f'{{"name": {encode_text(self._name)}'
        return super()._text()

    def _children(self) -> tuple[Node, ...]:
        return (self._node, *self._contents) if self._contents else (self._node,)

    @property
    def _object(self) -> Object:  # type: ignore[override]
        return self

    def __repr__(self) -> str:
        rest = [] if self._material is None else [f"material={self._material!r}"]
        rest += [f"priority={self._priority}"] if self._priority else []
        if self._contents:
            shown = [_short_repr(part) for part in self._contents[:4]]
            more = [f"... {len(self._contents) - 4} more"] if len(self._contents) > 4 else []
            rest.append(f"contents=[{', '.join(shown + more)}]")
        rest += ["clip=True"] if self._clip else []
        return f"{_short_repr(self._node)}.named({', '.join([repr(self._name), *rest])})"


def _content(part: Any, name: str) -> Node:
    """A checked part of the contents of an object."""
    node = _checked(part)
    if node._object is None:
        raise ValueError(
            f"the contents of {name!r} are objects and groups of them: name {_short_repr(node)} with .named(...)"
        )
    return node


def placed_object(node: Node) -> tuple[tuple[tuple[str, Any], ...], Object] | None:
    """The object within a node that transforms it and names it as a part any number of times, and the steps of these
    transforms, innermost first; None for any other node. The shape of an object never contains an object."""
    steps: tuple[tuple[str, Any], ...] = ()
    while isinstance(node, (Placed, Part)):
        if isinstance(node, Placed):
            steps = (*node._steps, *steps)
        node = node._child
    return (steps, node) if isinstance(node, Object) else None
