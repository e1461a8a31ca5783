"""Parts of scenes. They are immutable, so a part may stand in many places: it is then one shared part, built once."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native

Vector = tuple[float, float, float]


def numbers(values: ArrayLike, count: int, what: str) -> tuple[float, ...]:
    """So many finite numbers, or an error that says what they were for."""
    if (
        isinstance(values, tuple)
        and len(values) == count
        and all(type(x) in (int, float) and isfinite(x) for x in values)
    ):
        # Scenes are made of many short tuples, and arrays of them would take ten times as long.
        return tuple(map(float, values))
    array = np.asarray(values, dtype=np.float64).reshape(-1)
    if array.size != count:
        raise ValueError(f"{what} takes {count} numbers, not {array.size}")
    if not np.isfinite(array).all():
        raise ValueError(f"{what} is {array.tolist()}, but must be finite")
    return tuple(array.tolist())


class Node:
    """A part of a scene, in its own coordinates: a solid, a mesh, a combination, a group, or one of these placed.

    `a | b`, `a & b` and `a - b` combine; `translate`, `rotate`, `scale` and `transform` place. None of them changes
    the node itself: each returns a new one.
    """

    __slots__ = ()

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
        return _placed(self, ("translate", numbers(offset, 3, "translate")))

    def rotate(self, *angles: Any, axis: ArrayLike | None = None, degrees: float | None = None) -> Placed:
        """Turn by angles in degrees about x, then y, then z; or with `axis` and `degrees` about an axis through the
        origin, counter-clockwise seen from its tip. Quarter turns are exact."""
        if axis is None and degrees is None:
            return _placed(self, ("rotate", numbers(angles, 3, "rotate")))
        if angles or axis is None or degrees is None:
            raise ValueError("rotate takes three angles, or axis= and degrees= together")
        direction = numbers(axis, 3, "axis")
        if not any(direction):
            raise ValueError("the axis has no direction")
        (angle,) = numbers(degrees, 1, "degrees")
        return _placed(self, ("rotate", {"axis": direction, "degrees": angle}))

    def scale(self, *factors: Any) -> Placed:
        """Scale about the origin, by one factor or by three along the axes. A negative one mirrors; zero is refused."""
        values = np.asarray(factors, dtype=np.float64).reshape(-1)
        factors = numbers(np.repeat(values, 3) if values.size == 1 else values, 3, "scale")
        if 0.0 in factors:
            raise ValueError(f"scale is {list(factors)}, but no factor may be zero")
        return _placed(self, ("scale", factors))

    def transform(self, matrix: ArrayLike) -> Placed:
        """Place by an affine map, of shape (3, 4), (4, 4) or (12,): the parent's coordinates from the node's own. The
        last row of a 4x4 matrix must be 0, 0, 0, 1.

        Raises ValueError for a matrix that is singular, or so nearly that hardly a digit would be left.
        """
        return _placed(self, ("transform", affine(matrix)))

    def part(self, name: str) -> Part:
        """Give a shared part a name, which then stands in the names of paths, as in `arm[2]/bolt`."""
        return Part(self, name)

    def named(self, name: str, material: str | None = None, priority: int = 0) -> Object:
        """Make an object of it: see `Object`."""
        return Object(self, name, material, priority)

    # What a scene file says of the node, without its children; and those.
    def _keys(self) -> dict[str, Any]:
        return {}

    def _children(self) -> tuple[Node, ...]:
        return ()


def affine(matrix: ArrayLike) -> tuple[float, ...]:
    """The 12 numbers of an affine map, row by row."""
    array = np.asarray(matrix, dtype=np.float64)
    if array.shape == (4, 4):
        if array[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
            raise ValueError(f"the last row of a 4x4 matrix must be [0, 0, 0, 1], not {array[3].tolist()}")
        array = array[:3]
    if array.shape not in [(3, 4), (12,)]:
        raise ValueError(f"a matrix has shape (3, 4), (4, 4) or (12,), not {array.shape}")
    flat = numbers(array, 12, "the matrix")
    return flat


def _checked(node: Any) -> Node:
    if not isinstance(node, Node):
        raise TypeError(f"a part of a scene is wanted, not {type(node).__name__}")
    return node


def _words(node: Node) -> str:
    """A node in a few words: those of a large one would fill pages."""
    return repr(node) if not node._children() or isinstance(node, (Placed, Part)) else f"<{type(node).__name__}>"


class Solid(Node):
    """A solid given by parameters: the classes of `shotline.solids`."""

    __slots__ = ("_values",)
    _kind = ""
    _params: tuple[tuple[str, int], ...] = ()

    def __init__(self, **values: Any) -> None:
        names = [name for name, _ in self._params]
        unknown = [name for name in values if name not in names]
        missing = [name for name in names if name not in values]
        if unknown or missing:
            wrong = [f"no parameter {name!r}" for name in unknown] + [f"{name} is missing" for name in missing]
            raise TypeError(f"{type(self).__name__}({', '.join(names)}): {'; '.join(wrong)}")
        self._values = {name: numbers(values[name], count, name) for name, count in self._params}
        _native.check_solid(self._kind, list(self._values.values()))

    def __getattr__(self, name: str) -> Any:
        try:
            value = object.__getattribute__(self, "_values")[name]
        except (KeyError, AttributeError):
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}") from None
        return value[0] if len(value) == 1 else value

    def _keys(self) -> dict[str, Any]:
        return {"kind": self._kind, **{n: v[0] if len(v) == 1 else v for n, v in self._values.items()}}

    def __repr__(self) -> str:
        shown = ", ".join(f"{n}={v[0] if len(v) == 1 else v}" for n, v in self._values.items())
        return f"{type(self).__name__}({shown})"


class _Several(Node):
    __slots__ = ("_accel", "_args")
    _op = ""

    def __init__(self, *args: Node | Iterable[Node], accel: str | None = None) -> None:
        if len(args) == 1 and not isinstance(args[0], Node):
            args = tuple(args[0])
        if not args:
            raise ValueError(f"{type(self).__name__} needs at least one part")
        self._args: tuple[Node, ...] = tuple(_checked(arg) for arg in args)
        self._accel = accel

    def _keys(self) -> dict[str, Any]:
        return {"op": self._op} | ({"accel": self._accel} if self._accel else {})

    def _children(self) -> tuple[Node, ...]:
        return self._args

    def __repr__(self) -> str:
        shown = [_words(arg) for arg in self._args[:4]]
        more = [f"... {len(self._args) - 4} more"] if len(self._args) > 4 else []
        return f"{type(self).__name__}({', '.join(shown + more)})"


class Union(_Several):
    """All points in any of the parts: `a | b`. Parts that touch have no seam.

    `accel` names an accelerator for this combination; no answer depends on it.
    """

    __slots__ = ()
    _op = "union"


class Intersection(_Several):
    """All points in each of the parts: `a & b`."""

    __slots__ = ()
    _op = "intersection"


class Difference(_Several):
    """All points in the first part and in none of the others: `a - b`."""

    __slots__ = ()
    _op = "difference"


class Group(_Several):
    """Parts side by side, without boolean meaning: each is a body of its own, with its own path and its own list of
    crossings. Where a combination has a group as an operand, it counts as the union of its parts.

    Parts may be objects (a volume with its contents). `accel` matters for a group that stands in several places.
    """

    __slots__ = ()
    _op = "group"


def _chain(kind: type[_Several], left: Node, right: Node) -> tuple[Node, ...]:
    """The parts of a combination: chains are one operation of many parts, ((a - b) - c) - d."""
    if type(left) is kind and isinstance(left, _Several) and left._accel is None:
        return (*left._args, right)
    return (left, right)


class Placed(Node):
    """A node with a placement: what `translate`, `rotate`, `scale` and `transform` return."""

    __slots__ = ("_child", "_steps")

    def __init__(self, steps: tuple[tuple[str, Any], ...], child: Node) -> None:
        # The innermost step is the first.
        self._steps, self._child = steps, child
        if any(name in ("scale", "transform") for name, _ in steps):
            _native.compose(list(steps))  # refuses what has no inverse

    @property
    def matrix(self) -> np.ndarray:
        """The whole placement as an affine map of shape (3, 4), float64: worked out exactly and rounded once."""
        return np.array(self._matrix()).reshape(3, 4)

    def _matrix(self) -> tuple[float, ...]:
        return tuple(_native.compose(list(self._steps)))

    def _placement(self) -> dict[str, Any]:
        if len(self._steps) == 1:
            return dict(self._steps)
        order = ["scale", "rotate", "translate"]
        names = [name for name, _ in self._steps]
        if [name for name in order if name in names] == names:
            return dict(self._steps)
        return {"transform": self._matrix()}

    def _children(self) -> tuple[Node, ...]:
        return (self._child,)

    def __repr__(self) -> str:
        text = _words(self._child)
        for name, value in self._steps:
            if isinstance(value, dict):
                text += f".{name}(axis={value['axis']}, degrees={value['degrees']})"
            else:
                text += f".{name}({', '.join(map(str, value))})"
        return text


def _placed(node: Node, step: tuple[str, Any]) -> Placed:
    if isinstance(node, Placed):
        return Placed((*node._steps, step), node._child)
    return Placed((step,), node)


class Part(Node):
    """A node with a name of its own: see `Node.part`."""

    __slots__ = ("_child", "_name")

    def __init__(self, node: Node, name: str) -> None:
        self._child, self._name = _checked(node), str(name)

    def _children(self) -> tuple[Node, ...]:
        return (self._child,)

    def __repr__(self) -> str:
        return f"{_words(self._child)}.part({self._name!r})"


class Object(Node):
    """A part with a name, a material and a priority: what hits and segments are told of.

    Where objects overlap, the one of the higher priority owns the segment. Objects stand in a scene and in groups, not
    in combinations.
    """

    __slots__ = ("_material", "_name", "_node", "_priority")

    def __init__(self, node: Node, name: str, material: str | None = None, priority: int = 0) -> None:
        self._node, self._name, self._material, self._priority = _checked(node), str(name), material, int(priority)

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

    def _keys(self) -> dict[str, Any]:
        keys: dict[str, Any] = {"name": self._name}
        if self._material is not None:
            keys["material"] = self._material
        if self._priority:
            keys["priority"] = self._priority
        return keys

    def _children(self) -> tuple[Node, ...]:
        return (self._node,)

    def __repr__(self) -> str:
        rest = [] if self._material is None else [f"material={self._material!r}"]
        rest += [f"priority={self._priority}"] if self._priority else []
        return f"{_words(self._node)}.named({', '.join([repr(self._name), *rest])})"
