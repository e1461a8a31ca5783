"""A page of the documentation as a notebook: its blocks of Python are the cells of code."""

import json
import posixpath
import re

BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# What a relative link or picture leads to.
RELATIVE = re.compile(r"(!?)(\[[^\]]*\])\((?![a-z]+:|#)([^)\s]+)\)")


def notebook_of(markdown: str, page: str, repository: str) -> str:
    """The text of a notebook. `page` is the path of the page in the repository, whose files relative links lead to."""
    raw = repository.replace("github.com", "raw.githubusercontent.com")

    def absolute(link: re.Match[str]) -> str:
        mark, label, target = link.groups()
        path = posixpath.normpath(posixpath.join(posixpath.dirname(page), target))
        return f"{mark}{label}({f'{raw}/main' if mark else f'{repository}/blob/main'}/{path})"

    cells = []
    # Every second piece is a block.
    for number, piece in enumerate(BLOCK.split(markdown)):
        if text := piece.strip("\n"):
            text = text if number % 2 else RELATIVE.sub(absolute, text)
            code = {"execution_count": None, "outputs": []} if number % 2 else {}
            cells.append(
                {
                    "cell_type": "code" if number % 2 else "markdown",
                    "id": f"cell-{len(cells)}",
                    "metadata": {},
                    "source": text.splitlines(keepends=True),
                }
                | code
            )
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return json.dumps({"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}, indent=1)
