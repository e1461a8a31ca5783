"""The tree of a scene, for notebooks."""

from __future__ import annotations

from html import escape
from typing import Any

# Members of a group that are listed, and levels that are.
LISTED = 20
LEVELS = 12

_WORDS = ("name", "kind", "op", "ref")
_INNER = ("args", "node")


def html(document: dict[str, Any], title: str) -> str:
    """The words of a scene file as nested lists that fold."""
    parts = [_item(node, 0) for node in document["objects"][:LISTED]]
    shared = [
        f"<li><b>{escape(name)}</b> = {_item(node, 0)[4:]}" for name, node in _first(document.get("defs", {}))
    ]
    more = _more(len(document["objects"]))
    defs = f"<details><summary>shared parts</summary><ul>{''.join(shared)}</ul></details>" if shared else ""
    return f"<div><b>{escape(title)}</b><ul>{''.join(parts)}{more}</ul>{defs}</div>"


def _first(defs: dict[str, Any]) -> list[tuple[str, Any]]:
    return list(defs.items())[:LISTED]


def _more(count: int) -> str:
    return f"<li>... {count - LISTED} more</li>" if count > LISTED else ""


def _item(node: dict[str, Any], level: int) -> str:
    word = escape(next((str(node[key]) for key in _WORDS if key in node), "object"))
    rest = ", ".join(f"{key}={value}" for key, value in node.items() if key not in (*_WORDS, *_INNER))
    label = f"{word} <small>{escape(rest)}</small>" if rest else word
    children = node["args"] if "args" in node else [node["node"]] if "node" in node else []
    if not children or level == LEVELS:
        return f"<li>{label}{' ...' if children else ''}</li>"
    inner = "".join(_item(child, level + 1) for child in children[:LISTED]) + _more(len(children))
    opened = " open" if level == 0 else ""
    return f"<li><details{opened}><summary>{label}</summary><ul>{inner}</ul></details></li>"
