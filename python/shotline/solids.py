"""The solids that are given by parameters: a class for each kind that the core knows.

A class has the name of its kind in CamelCase and takes its parameters by keyword. ValueError says which parameter is
wrong and why.
"""

from __future__ import annotations

from inspect import Parameter, Signature

from . import _native
from .nodes import Solid

__all__: list[str] = []


def _signature(parameters: list[tuple[str, int, str]]) -> Signature:
    """What help and completion tell: keywords, whose types are those of the stubs."""
    keywords = [
        Parameter(name, Parameter.KEYWORD_ONLY, annotation="float" if count == 1 else "ArrayLike")
        for name, count, _ in parameters
    ]
    return Signature(keywords)


def _class_of(kind: str, summary: str, parameters: list[tuple[str, int, str]]) -> type[Solid]:
    name = "".join(word.capitalize() for word in kind.split("_"))
    takes = {1: "a number", 3: "three numbers", 10: "ten numbers"}
    listed = [f"    {name}: {takes.get(count, f'{count} numbers')}. {text}" for name, count, text in parameters]
    return type(
        name,
        (Solid,),
        {
            "__slots__": (),
            "__module__": __name__,
            "__doc__": f"{summary}\n\nParameters:\n" + "\n".join(listed),
            "__signature__": _signature(parameters),
            "_kind": kind,
            "_params": tuple((name, count) for name, count, _ in parameters),
        },
    )


for _kind in _native.kinds():
    _class = _class_of(*_kind)
    globals()[_class.__name__] = _class
    __all__.append(_class.__name__)
