"""The notebooks of the documentation run without errors, including the assertions in their cells."""

import pathlib
import re
import runpy

import pytest

NOTEBOOKS = pathlib.Path(__file__).resolve().parents[2] / "docs/notebooks"
REASON = "notebooks are run with nbclient, nbformat, ipykernel and matplotlib: tests/requirements.txt"
nbformat = pytest.importorskip("nbformat", reason=REASON)
nbclient = pytest.importorskip("nbclient", reason=REASON)
pytest.importorskip("ipykernel", reason=REASON)
pytest.importorskip("matplotlib", reason=REASON)


def paths():
    found = sorted(NOTEBOOKS.glob("*.ipynb"))
    assert found
    return found


@pytest.mark.parametrize("path", paths(), ids=lambda path: path.stem)
def test_runs(path):
    book = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": NOTEBOOKS}}).execute()


@pytest.mark.parametrize("path", paths(), ids=lambda path: path.stem)
def test_is_stored_without_outputs(path):
    book = nbformat.read(path, as_version=4)
    code = [cell for cell in book.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code)
    assert any("assert " in cell.source for cell in code)


def test_tutorials_become_notebooks():
    docs = NOTEBOOKS.parent
    made = runpy.run_path(str(docs / "page_notebook.py"))
    pages = sorted((docs / "tutorials").glob("*.md"))
    assert len(pages) >= 5
    for page in pages:
        text = page.read_text()
        book = nbformat.reads(
            made["notebook_of"](text, f"docs/tutorials/{page.name}", "https://github.com/a/b"), as_version=4
        )
        nbformat.validate(book)
        assert book.cells[0].source.startswith("# ")
        code = [cell.source for cell in book.cells if cell.cell_type == "code"]
        assert code == [block.strip("\n") for block in made["BLOCK"].findall(text)]
        words = "\n".join(cell.source for cell in book.cells if cell.cell_type == "markdown")
        assert "```python" not in words
        for mark, address in re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", words):
            start = "https://raw.githubusercontent.com/a/b/main/docs/" if mark else "https://"
            assert address.startswith(start) and ".." not in address, address
