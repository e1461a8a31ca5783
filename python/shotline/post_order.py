"""The order in which a graph without cycles is built: every item after those that it is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

_Item = TypeVar("_Item")


def post_order(roots: Iterable[_Item], children: Callable[[_Item], Sequence[_Item]]) -> list[_Item]:
    """Every item once, after its children. Not recursive, since scenes may be deep."""
    order: list[_Item] = []
    opened: list[_Item] = []
    seen: set[int] = set()
    # None stands where the item that was opened last ends.
    stack: list[Any] = [*roots][::-1]
    while stack:
        item = stack.pop()
        if item is None:
            order.append(opened.pop())
        elif id(item) not in seen:
            seen.add(id(item))
            below = children(item)
            if below:
                opened.append(item)
                stack.append(None)
                stack.extend(below[::-1])
            else:
                order.append(item)
    return order
