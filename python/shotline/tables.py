"""Answers as tables of text and of HTML."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

import numpy as np

# The number of rows of a table that are shown at each end.
SHOWN = 5


def shown_rows(count: int) -> list[int]:
    """The rows of a table that are shown: all, or the first and the last."""
    return list(range(count)) if count <= 2 * SHOWN + 1 else [*range(SHOWN), *range(count - SHOWN, count)]


def cells(count: int, columns: dict[str, Callable[[int], str]]) -> list[list[str]]:
    """The lines of a table, the first with the names of the columns, each beginning with the number of the row. Each
    column is given by the text of its rows."""
    rows = shown_rows(count)
    lines = [["", *columns], *([str(row), *(column(row) for column in columns.values())] for row in rows)]
    if len(rows) < count:
        lines.insert(1 + SHOWN, ["..."] * len(lines[0]))
    return lines


def as_text(heading: str, lines: list[list[str]]) -> str:
    """A table with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    aligned = [
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    ]
    return "\n".join([heading, *aligned])


def as_html(heading: str, lines: list[list[str]]) -> str:
    """A table for notebooks."""
    head, *body = ["".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in line) for tag, line in _tagged(lines)]
    rows = "".join(f"<tr>{row}</tr>" for row in body)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return f"<div>{escape(heading)}{table}</div>"


def _tagged(lines: list[list[str]]) -> list[tuple[str, list[str]]]:
    return [("td" if number else "th", line) for number, line in enumerate(lines)]


def cell(value: object) -> str:
    """The text of a value: of a number, of several, or of a name."""
    if isinstance(value, np.ndarray):
        return "(" + ", ".join(cell(x) for x in value) + ")"
    # Adding zero turns -0 into 0.
    return f"{value + 0.0:.6g}" if isinstance(value, (float, np.floating)) else str(value)


def counted(count: int, what: str) -> str:
    """A number of things, as in "1 ray" and "2 rays"."""
    return f"{count} {what}{'' if count == 1 else 's'}"
