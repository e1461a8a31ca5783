"""The stubs declare what the built module contains."""

import ast
import inspect
import os
import pathlib

import shotline
from shotline import _native, solids

HERE = pathlib.Path(__file__).resolve().parents[1] / "shotline"
UPDATE = os.environ.get("UPDATE_STUBS") == "1"


def members(thing):
    kept = {"__new__", "__version__"}
    return {n for n in vars(thing) if (not n.startswith("_") or n in kept) and n != "__doc__"}


def parameters(function):
    names = [a.arg for a in (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)]
    return [n for n in names if n not in ("self", "cls")]


def declared(body):
    """The declared names: functions with their parameters, classes with their members."""
    found = {}
    for item in body:
        if isinstance(item, ast.FunctionDef):
            found[item.name] = parameters(item)
        elif isinstance(item, ast.ClassDef):
            found[item.name] = declared(item.body)
        elif isinstance(item, ast.AnnAssign):
            if ast.unparse(item.annotation).startswith("Final"):
                found[item.target.id] = None
    return found


def signature(function):
    return [n for n in inspect.signature(function).parameters if n not in ("self", "cls")]


def test_native():
    stub = declared(ast.parse((HERE / "_native.pyi").read_text()).body)
    assert set(stub) == members(_native)
    for name, inner in stub.items():
        thing = getattr(_native, name)
        if isinstance(inner, list):
            assert inner == signature(thing), name
        elif isinstance(inner, dict):
            assert set(inner) | {"__new__"} == members(thing) | {"__new__"}, name
            for method, names in inner.items():
                assert names == signature(thing if method == "__new__" else getattr(thing, method)), (name, method)


def solids_stub():
    lines = [
        "# Made from the registry of solids: UPDATE_STUBS=1 python -m pytest python/tests/test_stubs.py",
        "from numpy.typing import ArrayLike",
        "",
        "from .nodes import Vector",
        "from .solid import Solid",
        "",
        f"__all__ = {solids.__all__}".replace("'", '"'),
    ]
    for kind, _summary, params in _native.kinds():
        keeps = {1: "float", 3: "Vector"}
        lines += ["", f"class {''.join(w.capitalize() for w in kind.split('_'))}(Solid):"]
        kept = [
            (name, keeps.get(count, "tuple[float, ...]") if columns is None else "tuple[tuple[float, ...], ...]")
            for name, count, columns, _, _ in params
        ]
        lines += [f"    {name}: {value}" for name, value in kept]
        listed = ", ".join(
            f"{name}: {'float' if count == 1 else 'ArrayLike'}{'' if default is None else ' = ...'}"
            for name, count, _, default, _ in params
        )
        lines += [f"    def __init__(self, {listed}) -> None: ..."]
    return "\n".join(lines) + "\n"


def test_solids():
    path = HERE / "solids.pyi"
    if UPDATE:
        path.write_text(solids_stub())
    assert path.read_text() == solids_stub(), "make it again with UPDATE_STUBS=1"
    stub = declared(ast.parse(path.read_text()).body)
    assert [name for name in stub if name != "__all__"] == solids.__all__


def test_marked_as_typed():
    installed = pathlib.Path(shotline.__file__).parent
    assert (
        (installed / "py.typed").exists()
        and (installed / "_native.pyi").exists()
        and (installed / "solids.pyi").exists()
    )
