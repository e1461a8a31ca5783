"""Serializes objects of which each is one solid of its own, as most of a very large scene are: nothing is shared, so nothing
has to be counted, and each is a line of text."""

from __future__ import annotations

from collections.abc import Iterable

from .nodes import Node, Object, Placed
from .solid import Solid
from .unnamed import Unnamed


def plain_objects(roots: Iterable[Node]) -> list[str] | None:
    """The objects as JSON, as `Serializer` writes them, if each is a solid that may be transformed, and no two have the
    same. None if one is anything else."""
    texts: list[str] = []
    met: set[int] = set()
    for root in roots:
        if type(root) is Unnamed:
            start = '{"node": '
        elif type(root) is Object and not root._contents:
            start = root._text() + ', "node": '
        else:
            return None
        node: Node = root._node
        placement = ""
        if type(node) is Placed:
            placement = node._text()
            node = node._child
        if not isinstance(node, Solid) or id(node) in met:
            return None
        met.add(id(node))
        texts.append(f"{start}{node._text()}{placement}}}}}")
    return texts
