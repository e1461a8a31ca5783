"""The parametric solids: a class for each kind in the registry of the core.

A class has the name of its kind in CamelCase and takes its parameters by keyword or by position. A ValueError says
which parameter is wrong and why.
"""

from __future__ import annotations

from inspect import Parameter, Signature

from . import _native
from .solid import Solid

__all__: list[str] = []

# Name, count of numbers, their names if there are rows of them, default, and summary.
_Declared = tuple[str, int, list[str] | None, list[float] | None, str]


def _value(numbers: list[float]) -> float | tuple[float, ...]:
    return numbers[0] if len(numbers) == 1 else tuple(numbers)


def _signature(parameters: list[_Declared]) -> Signature:
    """The signature for help and completion; the types are those of the stubs."""
    return Signature(
        Parameter(
            name,
            Parameter.POSITIONAL_OR_KEYWORD,
            default=Parameter.empty if default is None else _value(default),
            annotation="float" if count == 1 else "ArrayLike",
        )
        for name, count, _, default, _ in parameters
    )


def _line(name: str, count: int, columns: list[str] | None, default: list[float] | None, summary: str) -> str:
    takes = {1: "a number", 3: "three numbers", 10: "ten numbers"}.get(count, f"{count} numbers")
    if columns is not None:
        takes = f"rows ({', '.join(columns)})"
    ending = "" if default is None else f"; {_value(default)} if not given"
    return f"    {name}: {takes}{ending}. {summary}"


def _class_of(kind: str, summary: str, parameters: list[_Declared]) -> type[Solid]:
    name = "".join(word.capitalize() for word in kind.split("_"))
    listed = "\n".join(_line(*parameter) for parameter in parameters)
    return type(
        name,
        (Solid,),
        {
            "__slots__": (),
            "__module__": __name__,
            "__doc__": f"{summary}\n\nParameters:\n{listed}",
            "__signature__": _signature(parameters),
            "_kind": kind,
            "_params": tuple(
                (name, count, columns is not None, None if default is None else tuple(default))
                for name, count, columns, default, _ in parameters
            ),
        },
    )


for _kind in _native.kinds():
    _class = _class_of(*_kind)
    globals()[_class.__name__] = _class
    __all__.append(_class.__name__)
