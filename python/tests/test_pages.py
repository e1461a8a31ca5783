"""The Python examples of the README and of the documentation run, and their values are those in their comments.

The blocks of a page run one after the other, as one program, in a folder with the example scenes, a mesh and the output
of `shotline cast`. A comment after an expression states its value, and may continue on lines of its own:

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
PROJECT = (ROOT / "pyproject.toml").read_text()
REPOSITORY = re.search(r'^Repository = "https://github.com/(.*)"$', PROJECT, re.MULTILINE).group(1)
# Addresses of files of the repository: a package index shows only the text of the README.
ABSOLUTE = re.compile(rf"https://(?:github.com/{REPOSITORY}/blob|raw.githubusercontent.com/{REPOSITORY})/main/")
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks(page):
    """Each block with the number of its first line."""
    text = page.read_text()
    return [(text.count("\n", 0, found.start(1)), found.group(1)) for found in BLOCK.finditer(text)]


def stated_value(lines, last):
    """The value that a comment states for the expression that ends in line `last`; None without such a comment."""
    after = [line.strip() for line in lines[last:]]
    here = re.search(r"# -> (.*)$", lines[last - 1])
    if not here and not (after and after[0].startswith("# -> ")):
        return None
    expected = [here.group(1)] if here else []
    for line in after:
        if not line.startswith("#"):
            break
        expected.append(line.removeprefix("#").strip().removeprefix("-> "))
    return " ".join(" ".join(expected).split())


def run(code, names, page, first):
    tree = ast.parse("\n" * first + code, filename=str(page))
    lines = [""] * first + code.splitlines()
    for statement in tree.body:
        expected = stated_value(lines, statement.end_lineno)
        if expected is None or not isinstance(statement, ast.Expr):
            assert expected is None, f"{page.name}:{statement.lineno}: only expressions have values"
            exec(compile(ast.Module([statement], []), str(page), "exec"), names)
            continue
        value = eval(compile(ast.Expression(statement.value), str(page), "eval"), names)
        shown = [" ".join(text.split()) for text in (repr(value), str(value))]
        assert expected in shown, f"{page.name}:{statement.lineno} says {expected}, but it is {shown[1]}"


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
    """Writes the output of the command `shotline cast` of the quick start."""
    command = "cast scenes/tori.json --camera 640x480 --query crossings -o out.npz".split()
    subprocess.run([sys.executable, "-m", "shotline", *command], check=True, capture_output=True)


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p)], ids=lambda p: os.path.relpath(p, ROOT))
def test_examples(page, folder):
    if "out.npz" in page.read_text():
        cast()
    if "from dask" in page.read_text():
        pytest.importorskip("distributed", reason="dask[distributed] is not installed")
    if "import matplotlib" in page.read_text():
        pytest.importorskip("matplotlib", reason="matplotlib is not installed").use("agg")
    names = {"__name__": "__main__"}
    for first, code in blocks(page):
        run(code, names, page, first)


def test_a_wrong_value_is_found(tmp_path):
    page = tmp_path / "page.md"
    for code in ["1 + 1  # -> 3\n", "1 + 1\n# -> 3\n", "x = 2  # -> 2\n"]:
        with pytest.raises(AssertionError):
            run(code, {}, page, 0)
    run("1 + 1  # -> 2\n'a b'\n# -> a\n#    b\n", {}, page, 0)


def test_linked_files_exist():
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
            base = ROOT if ABSOLUTE.match(link) else page.parent
            link = ABSOLUTE.sub("", link)
            # The page of solids is generated with the site.
            if "://" not in link and link != "solids.md":
                assert (base / link).exists(), f"{page.name} links to {link}"


def test_links_of_the_readme_work_on_a_package_index():
    """A relative link or picture of the README would be broken on the package's page there."""
    links = re.findall(r"\]\(([^)\s]+)\)", PAGES[0].read_text())
    assert links and all(link.startswith("https://") for link in links)
    assert {"docs/gallery.md", "docs/pictures/bearing-thickness.png"} < {ABSOLUTE.sub("", link) for link in links}
