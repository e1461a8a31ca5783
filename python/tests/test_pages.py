"""The Python examples of the README and of the documentation run and answer what they say.

The blocks of a page run one after the other, as one program, in a folder with the example scenes, a mesh and what the
command line has cast. A comment after an expression tells its value, and may go on over lines of its own:

    scene.count(o, d)  # -> 4
    scene.material_names
    # -> ['steel', 'brass']
"""

import ast
import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks(page):
    """Each block with the number of its first line."""
    text = page.read_text()
    return [(text.count("\n", 0, found.start(1)), found.group(1)) for found in BLOCK.finditer(text)]


def told(lines, last):
    """What a comment says an expression that ends in a line is worth."""
    after = [line.strip() for line in lines[last:]]
    here = re.search(r"# -> (.*)$", lines[last - 1])
    if not here and not (after and after[0].startswith("# -> ")):
        return None
    words = [here.group(1)] if here else []
    for line in after:
        if not line.startswith("#"):
            break
        words.append(line.removeprefix("#").strip().removeprefix("-> "))
    return " ".join(" ".join(words).split())


def run(code, names, page, first):
    tree = ast.parse("\n" * first + code, filename=str(page))
    lines = [""] * first + code.splitlines()
    for statement in tree.body:
        words = told(lines, statement.end_lineno)
        if words is None or not isinstance(statement, ast.Expr):
            assert words is None, f"{page.name}:{statement.lineno}: only expressions have values"
            exec(compile(ast.Module([statement], []), str(page), "exec"), names)
            continue
        value = eval(compile(ast.Expression(statement.value), str(page), "eval"), names)
        shown = [" ".join(text.split()) for text in (repr(value), str(value))]
        assert words in shown, f"{page.name}:{statement.lineno} says {words}, but it is {shown[1]}"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    corners, faces = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"], ["3 0 2 1", "3 0 1 3", "3 1 2 3", "3 2 0 3"]
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    (tmp_path / "part.ply").write_text(head + "\n".join([*corners, *faces]) + "\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def cast():
    """What `shotline cast` of the quick start leaves."""
    command = "cast scenes/tori.json --camera 640x480 --query crossings -o out.npz".split()
    subprocess.run([sys.executable, "-m", "shotline", *command], check=True, capture_output=True)


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p)], ids=lambda p: os.path.relpath(p, ROOT))
def test_examples(page, folder):
    if "out.npz" in page.read_text():
        cast()
    if "from dask" in page.read_text():
        pytest.importorskip("distributed", reason="dask[distributed] is not installed")
    names = {"__name__": "__main__"}
    for first, code in blocks(page):
        run(code, names, page, first)


def test_a_wrong_value_is_found(tmp_path):
    page = tmp_path / "page.md"
    for code in ["1 + 1  # -> 3\n", "1 + 1\n# -> 3\n", "x = 2  # -> 2\n"]:
        with pytest.raises(AssertionError):
            run(code, {}, page, 0)
    run("1 + 1  # -> 2\n'a b'\n# -> a\n#    b\n", {}, page, 0)


def test_pages_link_to_what_is_there():
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
            # The page of solids is made with the site.
            if "://" not in link and link != "solids.md":
                assert (page.parent / link).exists(), f"{page.name} links to {link}"
