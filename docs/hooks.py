"""Hooks of mkdocs. They add to the pages of this folder: pages of the repository's root, the notebooks with the outputs
of their cells, the tutorials as notebooks, the solids of the installed package, and the code of the gallery. They also
convert docstrings to Markdown."""

import ast
import base64
import re
import runpy
from pathlib import Path

import griffe
from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent
REPOSITORY = re.search(r'^Repository = "(.*)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)[1]
PAGES = ["ARCHITECTURE.md", "CONTRIBUTING.md"]


def on_files(files, config):
    for name in PAGES:
        files.append(File.generated(config, name, content=(ROOT / name).read_text().replace("](docs/", "](")))
    for path in sorted((ROOT / "docs/notebooks").glob("*.ipynb")):
        for name, content in notebook(path):
            files.append(File.generated(config, f"notebooks/{name}", content=content))
    notebook_of = runpy.run_path(str(ROOT / "docs/page_notebook.py"))["notebook_of"]
    for path in sorted((ROOT / "docs/tutorials").glob("*.md")):
        content = notebook_of(path.read_text(), f"docs/tutorials/{path.name}", REPOSITORY)
        files.append(File.generated(config, f"tutorials/{path.stem}.ipynb", content=content))
    files.append(File.generated(config, "api/solids.md", content=solids()))
    return files


def on_page_markdown(markdown, page, config, files):
    # Links are written for the repository: pages of the root are above this folder, and notebooks are .ipynb files.
    markdown = re.sub(r"\]\(\.\./(?=[A-Z]+\.md)", "](", markdown)
    # Code is not part of the site.
    markdown = markdown.replace("](../crates/", f"]({REPOSITORY}/blob/main/crates/")
    # A notebook's own page links to the file beside it, for download.
    markdown = re.sub(r"(\]\([^)]*/[^)]*)\.ipynb\)", r"\1.md)", markdown)
    if page.file.src_uri.startswith("tutorials/"):
        # Below the title.
        markdown = markdown.replace("\n\n", f"\n\n{download_of(Path(page.file.src_uri).stem)}.\n\n", 1)
    return with_code(markdown) if page.file.src_uri == "gallery.md" else markdown


class Docstrings(griffe.Extension):
    def on_instance(self, *, obj, **_):
        if obj.docstring:
            text = re.sub(r"^>>> (?:.+\n?)+", r"```pycon\n\g<0>\n```\n", obj.docstring.value, flags=re.MULTILINE)
            # Fields of a tuple, "t, normal: ..." at the beginning of a line, become list items.
            obj.docstring.value = re.sub(r"^([a-z_]+(?:, [a-z_]+)*): ", r"- `\1`: ", text, flags=re.MULTILINE)


def notebook(path):
    """Runs a notebook; returns names and contents of its page and its pictures."""
    import nbformat
    from nbclient import NotebookClient

    book = nbformat.read(path, as_version=4)
    NotebookClient(
        book, timeout=120, coalesce_streams=True, resources={"metadata": {"path": ROOT / "docs/notebooks"}}
    ).execute()
    words, pictures = [], []
    for cell in book.cells:
        if cell.cell_type == "markdown":
            words.append(cell.source)
            continue
        words.append(f"```python\n{cell.source}\n```")
        for output in cell.outputs:
            data = output.get("data", {})
            if "image/png" in data:
                name = f"{path.stem}-{len(pictures)}.png"
                pictures.append((name, base64.b64decode(data["image/png"])))
                words.append(f"![What the cell above draws]({name})")
            elif "text/html" in data:
                words.append(data["text/html"])
            else:
                text = output.get("text", data.get("text/plain", ""))
                words.append(f"```text\n{text.rstrip()}\n```")
    words.insert(1, f"{download_of(path.stem)}: the page shows it as it ran when the site was built.")
    return [(f"{path.stem}.md", "\n\n".join(words)), *pictures]


def download_of(stem):
    """A link of a page to the notebook of the same name beside it."""
    return f'[Download this page as a notebook]({stem}.ipynb){{ download="{stem}.ipynb" }}'


def with_code(markdown):
    """The gallery with the code of each picture that `gallery.py` makes, folded."""
    source = (ROOT / "docs/gallery.py").read_text()
    functions = {f.name: f for f in ast.parse(source).body if isinstance(f, ast.FunctionDef)}

    def code(name):
        """A function, after those of the gallery's parts that it calls."""
        calls = [node.id for node in ast.walk(functions[name]) if isinstance(node, ast.Name)]
        parts = [code(part) for part in dict.fromkeys(calls) if part in functions and part != "ground"]
        return "\n\n\n".join([*parts, ast.get_source_segment(source, functions[name])])

    def folded(title, text):
        return f'??? example "{title}"\n\n' + "\n".join(f"    {x}" for x in ["```python", *text.split("\n"), "```"])

    def shown(found):
        name = found[1].replace("-", "_")
        return f"{found[0]}\n\n{folded('Code', code(name))}" if name in functions else found[0]

    shared = source[source.index("OUT = ") : source.index("# --- the gallery")].strip()
    shared = shared[shared.index("SIZE") :]
    markdown = re.sub(r"^!\[.*\]\(pictures/(.*)\.png\)$", shown, markdown, flags=re.MULTILINE)
    return re.sub(r"\n\n(?=## )", f"\n\n{folded('What the pictures share', shared)}\n\n", markdown, count=1)


def solids():
    """A section for each kind of solid."""
    from shotline import _native

    words = [
        "# Solids",
        "One class per kind; parameters are given by keyword or by position, and stored as attributes. A ValueError says "
        "which parameter is wrong and why. All solids can be combined and placed: see [Parts of scenes](parts.md).",
    ]
    for kind, summary, parameters in _native.kinds():
        name = "".join(word.capitalize() for word in kind.split("_"))
        shown = [f"{p}={default[0]:g}" if default else p for p, _, _, default, _ in parameters]
        words += [
            f"## {name}",
            f"```python\n{name}({', '.join(shown)})\n```",
            f"{summary[0].upper()}{summary[1:]}.",
        ]
        if (ROOT / f"docs/pictures/solids/{name}.png").exists():
            words.append(f"![A {name}](../pictures/solids/{name}.png){{ .solid }}")
        takes = {p: "" if count == 1 else f" ({count} numbers)" for p, count, _, _, _ in parameters}
        takes |= {p: f" (rows of {', '.join(columns)})" for p, _, columns, _, _ in parameters if columns}
        words.append("\n".join(f"- `{p}`{takes[p]}: {text}" for p, _, _, _, text in parameters))
    return "\n\n".join(words)
