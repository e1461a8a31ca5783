"""The modules of the package import each other without cycles.

Imports are read from the sources with `ast`, including those inside functions and under `if TYPE_CHECKING:`. The latter
do not run, but a reader must still follow them, so they must not close a cycle either. The package's `__init__` imports
the modules, so a module that imports a name of the package itself depends on `__init__`. Stubs count as part of the
module that they describe.
"""

import ast
import pathlib

import pytest

PACKAGE = pathlib.Path(__file__).resolve().parents[1] / "shotline"


def imported_modules(source: str, modules: set[str]) -> set[str]:
    """The modules of the package that a source imports: names of files without their suffix."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            paths = [alias.name.split(".") for alias in node.names]
            targets = [path[1:] for path in paths if path[0] == "shotline"]
        elif isinstance(node, ast.ImportFrom):
            path = (node.module or "").split(".") if node.module else []
            if not node.level and path[:1] != ["shotline"]:
                continue
            inner = path if node.level else path[1:]
            targets = [[*inner, alias.name] for alias in node.names]
        else:
            continue
        found |= {target[0] if target and target[0] in modules else "__init__" for target in targets}
    return found


def imports_of(package: pathlib.Path) -> dict[str, set[str]]:
    """The modules of a package that each of its modules imports."""
    files = [*package.glob("*.py"), *package.glob("*.pyi")]
    modules = {file.stem for file in files}
    imports: dict[str, set[str]] = {module: set() for module in modules}
    for file in files:
        imports[file.stem] |= imported_modules(file.read_text(), modules) - {file.stem}
    return imports


def find_cycle(imports: dict[str, set[str]]) -> list[str] | None:
    """A cycle, with its first module repeated at the end; None if there is no cycle."""
    done: set[str] = set()

    def visit(module: str, trail: list[str]) -> list[str] | None:
        if module in trail:
            return [*trail[trail.index(module) :], module]
        if module in done:
            return None
        for target in sorted(imports[module]):
            if cycle := visit(target, [*trail, module]):
                return cycle
        done.add(module)
        return None

    return next((cycle for module in sorted(imports) if (cycle := visit(module, []))), None)


def test_modules_import_without_cycles():
    imports = imports_of(PACKAGE)
    assert "scene" in imports["__init__"] and "mesh" in imports["scene"]
    cycle = find_cycle(imports)
    assert cycle is None, " -> ".join(cycle or [])


@pytest.mark.parametrize(
    "back",
    [
        "from .b import name",
        "from . import b",
        "import shotline.b",
        "from shotline import b",
        "def late():\n    from .b import name",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from .b import name",
    ],
)
def test_cycles_are_found(tmp_path, back):
    for name, source in {"__init__": "from . import a, b", "a": back, "b": "from .a import other"}.items():
        (tmp_path / f"{name}.py").write_text(source)
    assert find_cycle(imports_of(tmp_path)) == ["a", "b", "a"]
    (tmp_path / "a.py").write_text("import math\nfrom . import __version__")
    assert find_cycle(imports_of(tmp_path)) == ["__init__", "a", "__init__"]
