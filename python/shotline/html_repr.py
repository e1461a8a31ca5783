"""A scene as an HTML tree, for notebooks."""

from __future__ import annotations

from html import escape
from typing import Any

# The maximum number of listed members of a group, and of listed levels.
MAX_MEMBERS = 20
MAX_LEVELS = 12

_TITLE_KEYS = ("name", "kind", "op", "ref")
_CHILD_KEYS = ("args", "node")


def html(document: dict[str, Any], title: str) -> str:
    """The content of a scene file as nested, collapsible lists."""
    objects = [_item(node, 0) for node in document["objects"][:MAX_MEMBERS]]
    shared = [
        f"<li><b>{escape(name)}</b> = {_item(node, 0)[4:]}" for name, node in _first(document.get("defs", {}))
    ]
    more = _more(len(document["objects"]))
    defs = f"<details><summary>shared parts</summary><ul>{''.join(shared)}</ul></details>" if shared else ""
    return f"<div><b>{escape(title)}</b><ul>{''.join(objects)}{more}</ul>{defs}</div>"


def _first(defs: dict[str, Any]) -> list[tuple[str, Any]]:
    return list(defs.items())[:MAX_MEMBERS]


def _more(count: int) -> str:
    return f"<li>... {count - MAX_MEMBERS} more</li>" if count > MAX_MEMBERS else ""


def _item(node: dict[str, Any], level: int) -> str:
    title = escape(next((str(node[key]) for key in _TITLE_KEYS if key in node), "object"))
    rest = ", ".join(f"{key}={value}" for key, value in node.items() if key not in (*_TITLE_KEYS, *_CHILD_KEYS))
    label = f"{title} <small>{escape(rest)}</small>" if rest else title
    children = node["args"] if "args" in node else [node["node"]] if "node" in node else []
    if not children or level == MAX_LEVELS:
        return f"<li>{label}{' ...' if children else ''}</li>"
    inner = "".join(_item(child, level + 1) for child in children[:MAX_MEMBERS]) + _more(len(children))
    opened = " open" if level == 0 else ""
    return f"<li><details{opened}><summary>{label}</summary><ul>{inner}</ul></details></li>"
