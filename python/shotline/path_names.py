"""Suggests the names of paths."""

from __future__ import annotations

from .queries import Queries
from .values import suggestion

# The paths whose names are looked at: a scene may have a billion.
_LOOKED_AT = 10_000


def path_hint(scene: Queries, path: str) -> str:
    """What might have been meant by the name of no path: the members of that name, or else the nearest name of its depth."""
    depth = path.count("/") + 1
    names = (scene.path_name(number).split("/") for number in range(min(scene.path_count, _LOOKED_AT)))
    known = list(dict.fromkeys("/".join(parts[:depth]) for parts in names if len(parts) >= depth))
    numbered = [name for name in known if name.startswith(f"{path}[")]
    if len(numbered) > 1:
        return f"there are {', '.join(numbered[:5])}{', ...' if len(numbered) > 5 else ''}"
    return suggestion(path, numbered or known, "there are") if known else "the scene is not so deep"
