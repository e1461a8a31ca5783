"""Digests of nodes, by which they are equal and have hashes."""

from __future__ import annotations

from hashlib import blake2b
from typing import Any


def digest(root: Any) -> bytes:
    """A digest of a node and all nodes below it, each of which stores its own. Not recursive, since nodes may be
    deep."""
    stack = [root]
    while stack:
        node = stack[-1]
        children = node._children()
        missing = [child for child in children if not hasattr(child, "_digest")]
        if missing and not hasattr(node, "_digest"):
            stack.extend(missing)
            continue
        stack.pop()
        if not hasattr(node, "_digest"):
            own = blake2b(repr((type(node).__name__, node._own())).encode(), digest_size=32)
            for child in children:
                own.update(child._digest)
            node._digest = own.digest()
    stored: bytes = root._digest
    return stored
