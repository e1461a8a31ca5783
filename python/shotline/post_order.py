"""The order in which a graph without cycles is built: every item after those that it is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

_Item = TypeVar("_Item")


def post_order(
    roots: Iterable[_Item], children: Callable[[_Item], Sequence[_Item]]
) -> tuple[list[_Item], dict[int, int]]:
    """Every item once, after its children; and by its id how often each is met, as a root or as a child. Not recursive,
    since scenes may be deep."""
    order: list[_Item] = []
    opened: list[_Item] = []
    met: dict[int, int] = {}
    # None stands where the item that was opened last ends.
    stack: list[Any] = [*roots][::-1]
    while stack:
        item = stack.pop()
        if item is None:
            order.append(opened.pop())
            continue
        chain: list[_Item] = []
        # Most items have one child, so chains of these are followed without the stack.
        while True:
            key = id(item)
            if key in met:
                met[key] += 1
                below: Sequence[_Item] = ()
                break
            met[key] = 1
            below = children(item)
            chain.append(item)
            if len(below) != 1:
                break
            (item,) = below
        if below:
            opened += chain
            stack += [None] * len(chain)
            stack += below[::-1]
        else:
            order += chain[::-1]
    return order, met
