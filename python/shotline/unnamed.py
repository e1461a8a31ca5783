"""Objects that are given to a scene without a name."""

from __future__ import annotations

from .nodes import Node, Object, _set


class Unnamed(Object):
    """An object without a name; readers name it by its number."""

    __slots__ = ()
    # Values of all of them, in place of the slots of `Object`: scenes may have many.
    _name = ""
    _material = None
    _priority = 0
    _contents = ()
    _clip = False

    def __init__(self, node: Node) -> None:
        # `node` is not an object, so that nothing has to be checked or taken over.
        _set(self, "_node", node)
